//! Events with their evidence, one JSON object per line: the `time` of the event in seconds since the first frame of the
//! video, and the fields of [`Event`].

use std::io::{self, Write};

use serde::Serialize;

use super::number::microseconds;
use crate::occlusion::Event;
use crate::tracking::FrameTracks;

#[derive(Serialize)]
struct EventLine<'a> {
    time: f64,
    #[serde(flatten)]
    event: &'a Event,
}

/// Writes the events in the given order. `frames` are all frames, in order, for their times.
pub fn write(out: &mut impl Write, events: &[Event], frames: &[FrameTracks]) -> io::Result<()> {
    for event in events {
        let at = frames.partition_point(|frame| frame.number < event.frame);
        let time = frames.get(at).map_or(0.0, |frame| microseconds(frame.time));
        serde_json::to_writer(&mut *out, &EventLine { time, event })?;
        out.write_all(b"\n")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::occlusion::{EventKind, Evidence};

    #[test]
    fn a_line_has_the_documented_keys() {
        let mut evidence = Evidence { branch: "the region grew".into(), ..Evidence::default() };
        evidence.at_least("size change", 0.5, 0.2);
        let event = Event {
            frame: 203,
            kind: EventKind::Merge,
            objects: vec![3, 5],
            becomes: vec![3, 5],
            pieces: vec![],
            x: 1.5,
            y: 2.0,
            front: None,
            evidence,
        };
        let frame = |number, time| FrameTracks { number, time, tracks: Vec::new() };
        let frames = [frame(202, 8.04), frame(203, 8.079_999_999_1), frame(204, 8.12)];
        let text = written(|out| write(out, &[event.clone(), event], &frames));
        assert_eq!(text.lines().count(), 2);
        assert!(
            text.starts_with(
                r#"{"time":8.08,"frame":203,"kind":"merge","objects":[3,5],"becomes":[3,5],"x":1.5,"y":2.0,"front":null,"evidence":{"#
            ),
            "{text}"
        );
    }
}
