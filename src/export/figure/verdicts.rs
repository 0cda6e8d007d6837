//! The strip of verdicts below plots over time.

use super::{Key, MarkShape, Panel, Sign};
use crate::palette::verdict_colour;

/// The opacity of background.
const BACKGROUND: f64 = 0.35;
/// The opacity by the share of foreground in a column: a single frame is visible, a full column is opaque. Few steps,
/// so that neighbouring columns merge to one rectangle.
const FOREGROUND: [f64; 4] = [0.55, 0.7, 0.85, 1.0];

/// The step of this share of foreground; `None` for background.
fn step(share: f32) -> Option<usize> {
    let last = FOREGROUND.len() - 1;
    (share > 0.0).then(|| ((share * FOREGROUND.len() as f32).ceil() as usize).saturating_sub(1).min(last))
}

/// Draws columns in order, each with its edges and its share of foreground.
pub(super) fn draw(panel: &mut Panel, columns: impl Iterator<Item = ([f64; 2], f32)>) {
    let columns: Vec<_> = columns.map(|(edges, share)| (edges, step(share))).collect();
    let background = [(None, "background", BACKGROUND)].into_iter();
    let steps = FOREGROUND.iter().enumerate().map(|(step, &strength)| (Some(step), "foreground", strength));
    for (step, name, strength) in background.chain(steps) {
        let runs = columns.chunk_by(|a, b| a.1 == b.1).filter(|run| run[0].1 == step);
        let rects: Vec<_> =
            runs.filter_map(|run| Some([run.first()?.0[0], 0.0, run.last()?.0[1], 1.0])).collect();
        if !rects.is_empty() {
            panel.draw(name, MarkShape::Rects(rects), verdict_colour(step.is_some(), false), strength);
        }
    }
    // A ground line, so that pale background has a visible edge.
    panel.draw_ground("ground");
}

/// The legend of the opacities for columns of these shares.
pub(super) fn legend(shares: impl Iterator<Item = f32>) -> Vec<Key> {
    let key = |foreground, strength, name: &str| {
        Key::new(Sign::Patch(strength), verdict_colour(foreground, false), name)
    };
    let mut keys = vec![key(false, BACKGROUND, "background"), key(true, FOREGROUND[3], "foreground")];
    let mut parted = shares.filter(|&share| share > 0.0 && share < 1.0);
    if parted.next().is_some() {
        keys.push(key(true, FOREGROUND[0], "some of a column's frames"));
    }
    keys
}
