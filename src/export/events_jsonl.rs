//! Events with their evidence, one JSON object per line: the `time` of the event in seconds since the first frame of the
//! video, and the fields of [`Event`].

use std::io::{self, Write};

use serde::Serialize;

use super::number::microseconds;
use crate::occlusion::Event;

#[derive(Serialize)]
struct EventLine<'a> {
    time: f64,
    #[serde(flatten)]
    event: &'a Event,
}

/// Writes the events in the given order. `times` are the numbers and times of all frames, in order.
pub fn write(out: &mut impl Write, events: &[Event], times: &[(u32, f64)]) -> io::Result<()> {
    for event in events {
        let at = times.partition_point(|&(number, _)| number < event.frame);
        let time = times.get(at).map_or(0.0, |&(_, time)| microseconds(time));
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
        let times = [(202, 8.04), (203, 8.079_999_999_1), (204, 8.12)];
        let text = written(|out| write(out, &[event.clone(), event], &times));
        assert_eq!(text.lines().count(), 2);
        assert!(
            text.starts_with(
                r#"{"time":8.08,"frame":203,"kind":"merge","objects":[3,5],"becomes":[3,5],"x":1.5,"y":2.0,"front":null,"evidence":{"#
            ),
            "{text}"
        );
    }
}
