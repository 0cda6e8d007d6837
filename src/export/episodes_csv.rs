//! Occlusion episodes, one per row: `kind,objects,start,end,least_visible,front,identities_kept`.
//!
//! `start` and `end` are frame numbers; `objects` are identities, as in `3+5`; `front` is empty if unknown.

use std::io::{self, Write};

use super::joined;
use super::number::significant;
use crate::occlusion::Episode;

/// Writes the header and the episodes in the given order.
pub fn write(out: &mut impl Write, episodes: &[Episode]) -> io::Result<()> {
    writeln!(out, "kind,objects,start,end,least_visible,front,identities_kept")?;
    for episode in episodes {
        writeln!(
            out,
            "{},{},{},{},{},{},{}",
            episode.kind.name(),
            joined(&episode.objects),
            episode.start,
            episode.end,
            significant(episode.least_visible),
            episode.front.map_or_else(String::new, |front| front.to_string()),
            episode.identities_kept,
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::occlusion::EpisodeKind;

    #[test]
    fn a_row_has_the_documented_columns() {
        let scene = Episode {
            kind: EpisodeKind::Scene,
            objects: vec![7],
            start: 10,
            end: 20,
            least_visible: 0.0,
            front: None,
            identities_kept: true,
        };
        let meeting = Episode {
            kind: EpisodeKind::InterObject,
            objects: vec![3, 5],
            least_visible: 0.5,
            front: Some(5),
            identities_kept: false,
            ..scene.clone()
        };
        assert_eq!(
            written(|out| write(out, &[scene, meeting])),
            "kind,objects,start,end,least_visible,front,identities_kept\n\
             scene,7,10,20,0,,true\ninter-object,3+5,10,20,0.5,5,false\n"
        );
    }
}
