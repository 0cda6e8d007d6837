//! The life of each object, as a line.

use std::ops::RangeInclusive;

use eframe::egui::{Painter, Rect, Shape, Stroke, pos2};

use super::axis::TimeAxis;
use super::curves::PROGRESS_HEIGHT;
use crate::app::model::Model;
use crate::app::theme;
use crate::palette::identity_colour;
use crate::replay::Timeline;
use crate::tracking::TrackState;

/// Assigns each track line to a lane so that lines do not overlap. Returns the lanes and their number.
fn lanes(lives: &[RangeInclusive<u32>]) -> (Vec<usize>, usize) {
    let mut ends: Vec<u32> = Vec::new();
    let taken = lives
        .iter()
        .map(|life| {
            let free = ends.iter().position(|&end| end < *life.start());
            let lane = free.unwrap_or(ends.len());
            if lane == ends.len() {
                ends.push(0);
            }
            ends[lane] = *life.end() + 1;
            lane
        })
        .collect();
    (taken, ends.len())
}

pub(super) fn draw_tracks(
    painter: &Painter,
    model: &Model,
    timeline: &Timeline,
    axis: &TimeAxis,
    ground: Rect,
) {
    let mut lines: Vec<_> = timeline.track_timelines.iter().filter(|line| !line.spans.is_empty()).collect();
    lines.sort_by_key(|line| (line.spans.first().map(|span| span.0), line.id));
    let lives: Vec<_> = lines
        .iter()
        .map(|line| {
            let first = line.spans.iter().map(|span| span.0).min().unwrap_or(0);
            let last = line.spans.iter().map(|span| span.1).max().unwrap_or(0);
            first..=last
        })
        .collect();
    let (taken, count) = lanes(&lives);
    let height = ground.height() - PROGRESS_HEIGHT - 6.0;
    let pitch = (height / count.max(1) as f32).min(11.0);
    let thick = (pitch * 0.55).clamp(1.0, 5.0);
    for (line, lane) in lines.iter().zip(taken) {
        // With a chosen object, all other lines are fainter.
        let strength = if model.selection.object.is_none_or(|id| id == line.id) { 1.0 } else { 0.35 };
        let colour = theme::rgb(identity_colour(line.id)).gamma_multiply(strength);
        let y = ground.top() + 4.0 + (lane as f32 + 0.5) * pitch;
        for &(first, last, state) in &line.spans {
            let (from, to) =
                (axis.edge(first as f32), axis.edge(last as f32 + 1.0).max(axis.edge(first as f32) + 1.0));
            match state {
                TrackState::Visible => {
                    painter.hline(from..=to, y, Stroke::new(thick, colour));
                }
                TrackState::Merged => {
                    painter.hline(from..=to, y, Stroke::new(thick, colour.gamma_multiply(0.5)));
                }
                TrackState::Hidden => {
                    let ends = [pos2(from, y), pos2(to, y)];
                    painter.extend(Shape::dashed_line(&ends, Stroke::new(thick.min(2.0), colour), 3.0, 3.0));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_track_lines_get_separate_lanes() {
        let (taken, count) = lanes(&[0..=10, 5..=20, 12..=15, 22..=30]);
        assert_eq!((taken, count), (vec![0, 1, 0, 0], 2));
    }
}
