//! The tracks and regions of all frames in a temporary file, until later decisions about them are known: memory holds
//! one frame, however long the video is.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read as _, Seek as _, Write as _};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::export::Staging;
use crate::export::regions_csv::{FrameRows, RegionRow};
use crate::export::source_pixels;
use crate::export::write_failure::told;
use crate::pipeline::{Analysis, LateDecisions};
use crate::placement::Placement;
use crate::tracking::{FrameTracks, ObjectId, Track};

/// The final results of one frame.
pub(super) struct FrameResults {
    /// The confirmed objects.
    pub tracks: FrameTracks,
    /// The regions.
    pub regions: FrameRows,
}

/// The results of one frame as the analysis gave them.
#[derive(Serialize, Deserialize)]
struct SpooledFrame {
    number: u32,
    time: f64,
    /// All objects, each with the key that its track is recorded under.
    objects: Vec<(ObjectId, Track)>,
    regions: Vec<RegionRow>,
}

/// The file while it is written. It has no name, so that nothing of it is left after a failure. Each frame is the number
/// of its bytes and these.
pub(super) struct SpoolWriter {
    file: BufWriter<File>,
    frames: usize,
    /// The output folder, for messages.
    folder: PathBuf,
}

impl SpoolWriter {
    /// An empty file.
    pub(super) fn new(staging: &Staging) -> io::Result<Self> {
        let folder = staging.path("");
        let file = tempfile::tempfile_in(&folder).map_err(|error| told(&folder, error))?;
        Ok(Self { file: BufWriter::new(file), frames: 0, folder })
    }

    /// Adds the next frame.
    pub(super) fn add(&mut self, analysis: &Analysis) -> io::Result<()> {
        let frame = SpooledFrame {
            number: analysis.number,
            time: analysis.time,
            objects: analysis.objects.iter().map(|track| (track.key, track.clone())).collect(),
            regions: analysis.regions.iter().map(RegionRow::from).collect(),
        };
        let bytes = postcard::to_stdvec(&frame).map_err(io::Error::other)?;
        let length = self.file.write_all(&(bytes.len() as u64).to_le_bytes());
        length.and_then(|()| self.file.write_all(&bytes)).map_err(|error| told(&self.folder, error))?;
        self.frames += 1;
        Ok(())
    }

    /// The complete file, with everything that was decided later.
    pub(super) fn finish(self, decisions: LateDecisions) -> io::Result<ResultSpool> {
        let Self { file, frames, folder } = self;
        let file = file.into_inner().map_err(|error| told(&folder, error.into_error()))?;
        Ok(ResultSpool { file, frames, folder, decisions, placement: None })
    }
}

/// The complete file, and the decisions that its frames are changed by when they are read.
pub(super) struct ResultSpool {
    file: File,
    frames: usize,
    folder: PathBuf,
    /// The decisions, with all events and episodes.
    pub decisions: LateDecisions,
    placement: Option<Placement>,
}

impl ResultSpool {
    /// Number of frames.
    pub(super) const fn len(&self) -> usize {
        self.frames
    }

    /// Moves the results from the pixels of the frames to those of the source.
    pub(super) fn move_to_source(&mut self, placement: Placement) {
        source_pixels::move_events(&mut self.decisions.events, &placement);
        self.placement = Some(placement);
    }

    /// The final results of all frames, in order.
    pub(super) fn frames(&self) -> io::Result<impl Iterator<Item = io::Result<FrameResults>>> {
        // All readers of a file share its position: there is one at a time.
        let mut file = &self.file;
        let failed = |error| told(&self.folder, error);
        file.rewind().map_err(failed)?;
        let mut file = BufReader::new(file);
        Ok((0..self.frames).map(move |_| Ok(self.decided(read(&mut file).map_err(failed)?))))
    }

    fn decided(&self, SpooledFrame { number, time, objects, regions }: SpooledFrame) -> FrameResults {
        let objects: Vec<_> = objects.into_iter().map(|(key, track)| Track { key, ..track }).collect();
        let mut tracks = self.decisions.tracks_of(number, time, &objects);
        let mut regions = FrameRows { number, rows: regions };
        if let Some(placement) = &self.placement {
            source_pixels::move_tracks(std::slice::from_mut(&mut tracks), placement);
            source_pixels::move_regions(std::slice::from_mut(&mut regions), placement);
        }
        FrameResults { tracks, regions }
    }
}

fn read(file: &mut BufReader<&File>) -> io::Result<SpooledFrame> {
    let mut length = [0; 8];
    file.read_exact(&mut length)?;
    let mut bytes = vec![0; u64::from_le_bytes(length) as usize];
    file.read_exact(&mut bytes)?;
    postcard::from_bytes(&bytes).map_err(io::Error::other)
}
