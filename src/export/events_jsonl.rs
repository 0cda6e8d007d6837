//! Events with their evidence, one JSON object per line, whose keys are the fields of [`Event`].

use std::io::{self, Write};

use crate::occlusion::Event;

/// Writes the events in the given order.
pub fn write(out: &mut impl Write, events: &[Event]) -> io::Result<()> {
    for event in events {
        serde_json::to_writer(&mut *out, event)?;
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
        let text = written(|out| write(out, &[event.clone(), event]));
        assert_eq!(text.lines().count(), 2);
        assert!(
            text.starts_with(
                r#"{"frame":203,"kind":"merge","objects":[3,5],"becomes":[3,5],"x":1.5,"y":2.0,"front":null,"evidence":{"#
            ),
            "{text}"
        );
    }
}
