//! The tracks and regions of all frames in a temporary file, until later decisions about them are known.

use std::io;

use serde::{Deserialize, Serialize};

use super::spool::{Spool, SpoolWriter};
use crate::export::Staging;
use crate::export::regions_csv::{FrameRows, RegionRow};
use crate::export::source_pixels;
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

/// The results of one frame as the analysis gave them: its number, time in seconds, all objects, each with the key that its
/// track is recorded under, and regions. `T` is a track or a reference to one.
#[derive(Serialize, Deserialize)]
struct SpooledFrame<T> {
    number: u32,
    time: f64,
    objects: Vec<(ObjectId, T)>,
    regions: Vec<RegionRow>,
}

/// The results while they are added.
pub(super) struct ResultWriter {
    spool: SpoolWriter,
    frames: usize,
}

impl ResultWriter {
    /// Before the first frame.
    pub(super) fn new(staging: &Staging) -> io::Result<Self> {
        Ok(Self { spool: SpoolWriter::new(&staging.path(""))?, frames: 0 })
    }

    /// Adds the next frame.
    pub(super) fn add(&mut self, analysis: &Analysis) -> io::Result<()> {
        let frame = SpooledFrame {
            number: analysis.number,
            time: analysis.time,
            objects: analysis.objects.iter().map(|track| (track.key, track)).collect(),
            regions: analysis.regions.iter().map(RegionRow::from).collect(),
        };
        self.frames += 1;
        self.spool.add(&postcard::to_stdvec(&frame).map_err(io::Error::other)?)
    }

    /// The results of all frames, with everything that was decided later.
    pub(super) fn finish(self, decisions: LateDecisions) -> io::Result<ResultSpool> {
        Ok(ResultSpool { spool: self.spool.finish()?, frames: self.frames, decisions, placement: None })
    }
}

/// The results of all frames, and the decisions that they are changed by when they are read.
pub(super) struct ResultSpool {
    spool: Spool,
    frames: usize,
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

    /// The final results of all frames, in order, for one reader at a time.
    pub(super) fn frames(&self) -> io::Result<impl Iterator<Item = io::Result<FrameResults>>> {
        Ok(self.spool.read()?.take(self.frames).map(|data| self.decided(&data?)))
    }

    fn decided(&self, data: &[u8]) -> io::Result<FrameResults> {
        let SpooledFrame { number, time, objects, regions } =
            postcard::from_bytes::<SpooledFrame<Track>>(data).map_err(|error| self.spool.error(error))?;
        let objects: Vec<_> = objects.into_iter().map(|(key, track)| Track { key, ..track }).collect();
        let mut tracks = self.decisions.tracks_of(number, time, &objects);
        let mut regions = FrameRows { number, rows: regions };
        if let Some(placement) = &self.placement {
            source_pixels::move_tracks(std::slice::from_mut(&mut tracks), placement);
            source_pixels::move_regions(std::slice::from_mut(&mut regions), placement);
        }
        Ok(FrameResults { tracks, regions })
    }
}
