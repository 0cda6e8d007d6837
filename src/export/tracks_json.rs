//! Tracks with all their data: a JSON array of objects, one per line. `time` is in seconds since the first frame of the
//! video, lengths are in pixels, `velocity` is in pixels per frame period, `conf` is that of [`super::tracks_csv`].

use std::io::{self, Write};

use serde::Serialize;

use super::number::microseconds;
use super::tracks_csv::confidence;
use crate::regions::Rgb;
use crate::tracking::{FrameTracks, Identity, Track, TrackState};

/// One object in one frame.
#[derive(Serialize)]
struct TrackRow<'a> {
    frame: u32,
    time: f64,
    id: Identity,
    state: TrackState,
    x: f32,
    y: f32,
    w: f32,
    h: f32,
    conf: f32,
    visible_share: f32,
    velocity: [f32; 2],
    fitness: f32,
    colours: &'a [Rgb],
    group: &'a [Identity],
    regions: &'a [u32],
}

/// Writes the file frame by frame.
#[derive(Debug)]
pub struct TracksJson<W: Write> {
    out: W,
    is_empty: bool,
}

impl<W: Write> TracksJson<W> {
    /// Writes the beginning.
    pub fn new(mut out: W) -> io::Result<Self> {
        out.write_all(b"[")?;
        Ok(Self { out, is_empty: true })
    }

    /// Writes the objects of the next frame.
    pub fn write_frame(&mut self, frame: &FrameTracks) -> io::Result<()> {
        for track in &frame.tracks {
            self.out.write_all(if self.is_empty { b"\n" } else { b",\n" })?;
            self.is_empty = false;
            serde_json::to_writer(&mut self.out, &record(frame, track))?;
        }
        Ok(())
    }

    /// Writes the end and flushes.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.write_all(b"\n]\n")?;
        self.out.flush()
    }
}

fn record<'a>(frame: &FrameTracks, track: &'a Track) -> TrackRow<'a> {
    TrackRow {
        frame: frame.number,
        time: microseconds(frame.time),
        id: track.id,
        state: track.state,
        x: track.bbox.x,
        y: track.bbox.y,
        w: track.bbox.w,
        h: track.bbox.h,
        conf: confidence(track.state),
        visible_share: track.visible_share,
        velocity: track.velocity,
        fitness: track.fitness,
        colours: &track.colours,
        group: &track.group,
        regions: &track.regions,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::export::tests::{track, written};

    #[test]
    fn output_is_json_with_one_record_per_line() {
        let frame =
            FrameTracks { number: 4, time: 0.12, tracks: vec![track(3, 1.0, 2.0), track(5, 1.0, 2.0)] };
        let text = written(|out| {
            let mut json = TracksJson::new(out)?;
            json.write_frame(&frame)?;
            json.finish()
        });
        assert_eq!(text.lines().count(), 4);
        let read: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            (&read[1]["id"], &read[1]["frame"], &read[1]["time"]),
            (&5.into(), &4.into(), &0.12.into())
        );
        assert_eq!(read[0]["state"], "visible");
        assert_eq!(read[0]["colours"][0][0], 200);

        let text = written(|out| TracksJson::new(out)?.finish());
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), serde_json::json!([]));
    }
}
