//! A pixel's values in its three channels: a cube of R, G and B that can be rotated.
//!
//! The projection is orthographic. The yaw rotates the plane of R and G; B is vertical, and the pitch tilts it
//! towards the viewer. The window and the figure draw the same [`Scene`].

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::scatter::{legend, look, title};
use super::{
    Anchor, Axis, DrawnAxes, Figure, GRAY, INK, MarkShape, NARROW, Panel, Sign, axis, component, parameters,
};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_states::{ComponentState, component_states};
use crate::explain::pixel::scatter_points::{
    ScatterPoint, ScatterSelection, ScatterSpace, coordinates_of, scatter_points, thin_points,
};
use crate::mixture::MAX_K;

/// Largest number of points; more are merged, as they would be neither distinguishable nor fast to rotate.
pub const MAX_POINTS: usize = 6000;
/// The names of the axes.
pub const NAMES: [&str; 3] = ["R", "G", "B"];
/// Half the diagonal of the unit cube, which bounds its projection in each direction at any rotation.
pub const EXTENT: f64 = 0.866_025_403_784_438_6;
/// Space for labels around a figure's cube, in points.
const LABEL_SPACE: f64 = 27.0;
/// Least projected length of an axis with tick labels.
const MIN_AXIS_LENGTH: f64 = 0.3;

/// The direction of view, in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Rotation about the vertical axis.
    pub yaw: f64,
    /// Angle of view from above, −π/2..=π/2.
    pub pitch: f64,
}

impl Default for Turn {
    /// All three axes are visible and do not overlap.
    fn default() -> Self {
        Self { yaw: 0.6, pitch: 0.42 }
    }
}

impl Turn {
    /// Rotated by additional angles in radians.
    pub fn by(self, yaw: f64, pitch: f64) -> Self {
        let yaw = (self.yaw + yaw + PI).rem_euclid(TAU) - PI;
        Self { yaw, pitch: (self.pitch + pitch).clamp(-FRAC_PI_2, FRAC_PI_2) }
    }

    /// The projection of a point, x to the right and y up, and its depth behind the centre.
    pub fn project(self, [x, y, z]: [f64; 3]) -> ([f64; 2], f64) {
        let ((sin, cos), (rise, run)) = (self.yaw.sin_cos(), self.pitch.sin_cos());
        let (across, behind) = (x * cos - y * sin, x * sin + y * cos);
        ([across, z * run + behind * rise], behind * run - z * rise)
    }
}

/// The displayed part of the colour space: a cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Its lowest level of each channel.
    pub low: [f64; 3],
    /// Its side in levels.
    pub side: f64,
}

impl Span {
    /// The whole colour space.
    pub const WHOLE: Self = Self { low: [0.0; 3], side: 255.0 };

    /// The smallest cube that contains these points and components.
    pub fn around(places: &[ScatterPoint], component_states: &[ComponentState], lambda: f32) -> Self {
        let mut ends = [(f64::INFINITY, f64::NEG_INFINITY); 3];
        let reaches = component_states.iter().map(|component_state| {
            (
                component_state.component.mean.map(f64::from),
                f64::from(component_state.component.reach(lambda)),
            )
        });
        let values = places.iter().map(|place| (place.at.map(f64::from), 1.0));
        for (at, reach) in values.chain(reaches) {
            for ((low, high), level) in ends.iter_mut().zip(at) {
                (*low, *high) = (low.min(level - reach), high.max(level + reach));
            }
        }
        if ends[0].0 > ends[0].1 {
            return Self::WHOLE;
        }
        let side = ends.iter().map(|(low, high)| high - low).fold(16.0, f64::max);
        Self { low: ends.map(|(low, high)| f64::midpoint(low, high) - side / 2.0), side }
    }

    /// Converts levels to sides of the cube, relative to its centre.
    fn within(&self, at: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (at[axis] - self.low[axis]) / self.side - 0.5)
    }
}

/// The role of a line in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A grid line on a rear face, at a tick of an axis.
    Grid,
    /// An edge of the cube.
    Edge,
    /// The outline of a component's sphere.
    Reach {
        /// The component's slot.
        slot: u8,
        /// Whether it is background.
        background: bool,
    },
    /// A great circle of the sphere, in the plane of two channels.
    Girdle {
        /// The component's slot.
        slot: u8,
    },
}

/// A point of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Its projected position.
    pub at: [f64; 2],
    /// Its depth, 0 at the back and 1 at the front.
    pub nearness: f64,
    /// The data point.
    pub place: ScatterPoint,
}

/// A label of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLabel {
    /// Its anchor on the picture.
    pub at: [f64; 2],
    /// The unit vector from the anchor to the text.
    pub out: [f64; 2],
    /// The text.
    pub text: String,
    /// The slot of the component whose rank it is; `None` for labels of the axes.
    pub slot: Option<u8>,
    /// Whether it is the name of an axis.
    pub name: bool,
}

/// The projection of a cube, in sides of the cube relative to its centre, y up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Lines below the points.
    pub below: Vec<(Role, Vec<[f64; 2]>)>,
    /// The points, the farthest first.
    pub spots: Vec<Spot>,
    /// Lines above the points.
    pub above: Vec<(Role, Vec<[f64; 2]>)>,
    /// The labels.
    pub labels: Vec<SceneLabel>,
    /// The value of the frame in view.
    pub here: Option<[f64; 2]>,
}

/// The scene of these points and components.
pub fn scene(
    places: &[ScatterPoint],
    component_states: &[ComponentState],
    here: Option<[u8; 3]>,
    lambda: f32,
    span: Span,
    turn: Turn,
) -> Scene {
    let mut scene = Scene::default();
    let seen = |at: [f64; 3]| turn.project(span.within(at));
    cube(&mut scene, span, turn);
    let half = EXTENT;
    scene.spots = places
        .iter()
        .map(|&place| {
            let (at, behind) = seen(place.at.map(f64::from));
            Spot { at, nearness: (0.5 - behind / half / 2.0).clamp(0.0, 1.0), place }
        })
        .collect();
    scene.spots.sort_by(|a, b| a.nearness.total_cmp(&b.nearness));
    for component_state in component_states {
        let mean = component_state.component.mean.map(f64::from);
        let reach = f64::from(component_state.component.reach(lambda));
        let angles = || (0..=60).map(|step| (f64::from(step) / 60.0 * TAU).sin_cos());
        let (slot, background) = (component_state.slot, component_state.background);
        for plane in [[0, 1], [1, 2], [0, 2]] {
            let around = angles().map(|(sin, cos)| {
                let mut at = mean;
                at[plane[0]] += reach * cos;
                at[plane[1]] += reach * sin;
                seen(at).0
            });
            scene.above.push((Role::Girdle { slot }, around.collect()));
        }
        // The orthographic projection of a sphere is a circle.
        let ([x, y], radius) = (seen(mean).0, reach / span.side);
        let outline = angles().map(|(sin, cos)| [x + radius * cos, y + radius * sin]).collect();
        scene.above.push((Role::Reach { slot, background }, outline));
        let text = component_state.rank.to_string();
        scene.labels.push(SceneLabel {
            at: [x, y + radius],
            out: [0.0, 1.0],
            text,
            slot: Some(slot),
            name: false,
        });
    }
    scene.here = here.map(|here| seen(here.map(f64::from)).0);
    scene
}

/// Adds the cube's edges except the three in front, a grid on the rear faces, and labels along three edges.
fn cube(scene: &mut Scene, span: Span, turn: Turn) {
    // The rear side along each axis.
    let far: [f64; 3] = [0, 1, 2].map(|axis| {
        let mut unit = [0.0; 3];
        unit[axis] = 1.0;
        if turn.project(unit).1 > 0.0 { 0.5 } else { -0.5 }
    });
    let corner = |axis: usize, along: f64, [j, k]: [usize; 2], [b, c]: [f64; 2]| {
        let mut at = [0.0; 3];
        (at[axis], at[j], at[k]) = (along, b, c);
        turn.project(at).0
    };
    for (axis, name) in NAMES.into_iter().enumerate() {
        let others = [(axis + 1) % 3, (axis + 2) % 3];
        let back = others.map(|other| far[other]);
        for (b, c) in [(back[0], back[1]), (back[0], -back[1]), (-back[0], back[1])] {
            let edge = [-0.5, 0.5].map(|along| corner(axis, along, others, [b, c]));
            scene.below.push((Role::Edge, edge.to_vec()));
        }
        // Of the two edges on the outline the lower one, or the left one of the vertical edges.
        let sides = [[back[0], -back[1]], [-back[0], back[1]]];
        let middles = sides.map(|side| corner(axis, 0.0, others, side));
        let key = |[x, y]: [f64; 2]| if axis == 2 { x } else { y };
        let chosen = usize::from(key(middles[1]) < key(middles[0]));
        let (side, [mx, my]) = (sides[chosen], middles[chosen]);
        let length = mx.hypot(my).max(1e-9);
        let out = [mx / length, my / length];
        let [[x0, y0], [x1, y1]] = [-0.5, 0.5].map(|along| corner(axis, along, others, side));
        let short = (x1 - x0).hypot(y1 - y0) < MIN_AXIS_LENGTH;
        let ends = (span.low[axis], span.low[axis] + span.side);
        for value in axis::ticks(ends.0, ends.1, 5) {
            let along = (value - span.low[axis]) / span.side - 0.5;
            let at = corner(axis, along, others, side);
            if !short {
                scene.labels.push(SceneLabel {
                    at,
                    out,
                    text: axis::written(value),
                    slot: None,
                    name: false,
                });
            }
            // Two lines that meet at the rear edge.
            let [j, k] = back;
            let grid = [[j, -k], [j, k], [-j, k]].map(|side| corner(axis, along, others, side));
            scene.below.push((Role::Grid, grid.to_vec()));
        }
        let text = name.to_owned();
        scene.labels.push(SceneLabel { at: [mx, my], out, text, slot: None, name: true });
    }
    // Edges are drawn over the grid.
    scene.below.sort_by_key(|(role, _)| *role == Role::Edge);
}

/// The appearance of the figure, in addition to its [`ScatterSelection`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// The direction of view.
    pub turn: Turn,
    /// Whether the cube is reduced to the range of the values.
    pub fit: bool,
}

/// The points of a selection, few enough for fast rotation.
pub fn spots(history: &PixelHistory, slots: &[[u8; MAX_K]], choice: &ScatterSelection) -> Vec<ScatterPoint> {
    thin_points(
        scatter_points(history, slots, &ScatterSelection { space: ScatterSpace::Cube, ..choice.clone() }),
        MAX_POINTS,
    )
}

/// The figure: the cube at the window's rotation.
pub fn figure(
    history: &PixelHistory,
    slots: &[[u8; MAX_K]],
    choice: &ScatterSelection,
    index: usize,
    look_at: Look,
) -> Figure {
    let places = spots(history, slots, choice);
    let (component_states, _) = component_states(history, slots, index, false);
    let lambda = history.parameters.lambda;
    let span = if look_at.fit { Span::around(&places, &component_states, lambda) } else { Span::WHOLE };
    let here = coordinates_of(history, index, ScatterSpace::Cube);
    let scene = scene(&places, &component_states, here, lambda, span, look_at.turn);
    let mut keys = legend(history, choice, &component_states, false);
    for key in &mut keys {
        key.name = key.name.replace("circles", "spheres");
    }
    let Turn { yaw, pitch } = look_at.turn;
    let description = format!(
        "{}; rotated by {:.0}° about B, elevation {:.0}°",
        parameters(history),
        yaw.to_degrees(),
        pitch.to_degrees()
    );
    let title = format!("{}, levels of R, G and B", title(history, choice));
    let mut figure = Figure::new(NARROW, title, description, keys);
    let width = figure.size[0] - 2.0 * super::RIGHT;
    let ends = extent(&scene);
    // The scale, in points per side of the cube.
    let scale = (width - 2.0 * LABEL_SPACE) / (ends[0].1 - ends[0].0);
    let ends = ends.map(|(low, high)| (low - LABEL_SPACE / scale, high + LABEL_SPACE / scale));
    let [across, up] = [0, 1].map(|side| Axis::new("", ends[side], 1));
    let mut panel = Panel { frame: DrawnAxes::None, ..Panel::new(across, up) };
    for (role, points) in scene.below {
        let (name, colour, width) = match role {
            Role::Grid => ("grid", [222, 226, 232], 0.4),
            _ => ("edge", GRAY, 0.6),
        };
        panel.draw(name, MarkShape::Line { points, width, dashed: false }, colour, 1.0);
    }
    // Three sizes of dots: nearer ones are larger.
    let size = |spot: &Spot| (spot.nearness * 3.0).min(2.0) as usize;
    for run in scene.spots.chunk_by(|a, b| look(&a.place) == look(&b.place) && size(a) == size(b)) {
        let (colour, sign, opacity) = look(&run[0].place);
        let radius = [0.95, 1.15, 1.4][size(&run[0])] + if sign == Sign::Ring { 0.3 } else { 0.0 };
        let places = run.iter().map(|spot| spot.at).collect();
        panel.draw("values", MarkShape::Dots { places, radius, sign }, colour, opacity);
    }
    for (role, points) in scene.above {
        let (name, slot, width, dashed, opacity) = match role {
            Role::Reach { slot, background } => ("reach", slot, 1.1, !background, 1.0),
            Role::Girdle { slot } => ("girdle", slot, 0.5, false, 0.55),
            Role::Grid | Role::Edge => continue,
        };
        panel.draw(name, MarkShape::Line { points, width, dashed }, component(slot), opacity);
    }
    if let Some(here) = scene.here {
        panel.draw_cross("current value", here, 4.0);
    }
    for label in scene.labels {
        // The distance at which the label overlaps neither the edge nor a number.
        let off = if label.name { 21.0 } else { 9.0 - 7.0 * f64::from(u8::from(label.slot.is_some())) };
        let [x, y] = [0, 1].map(|side| label.at[side] + label.out[side] * off / scale);
        // The position of text is its baseline.
        let at = [x, if label.slot.is_some() { y } else { y - 0.35 * super::SMALL / scale }];
        let colour = label.slot.map_or(if label.name { INK } else { GRAY }, component);
        panel.draw("", MarkShape::Text { at, text: label.text, anchor: Anchor::Middle }, colour, 1.0);
    }
    let [across, up] = ends.map(|(from, to)| to - from);
    figure.stack(0, 1, vec![(panel, width * up / across)]);
    if let Some(panel) = figure.panels.last_mut() {
        (panel.place[0], panel.place[2]) = (super::RIGHT, width);
    }
    // There are no numbers below the panel.
    figure.size[1] -= super::BELOW - 6.0;
    figure
}

/// The range of a scene's plane without the labels.
fn extent(scene: &Scene) -> [(f64, f64); 2] {
    let lines = scene.below.iter().chain(&scene.above).flat_map(|(_, points)| points);
    let mut ends = [(-0.5_f64, 0.5_f64); 2];
    for place in lines.chain(&scene.here) {
        for ((low, high), at) in ends.iter_mut().zip(place) {
            (*low, *high) = (low.min(*at), high.max(*at));
        }
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_from_the_front_and_from_above_are_planes() {
        let front = Turn { yaw: 0.0, pitch: 0.0 };
        assert_eq!(front.project([0.3, 0.2, 0.1]), ([0.3, 0.1], 0.2), "R across, B up, G behind");
        let ([x, y], behind) = Turn { yaw: 0.0, pitch: FRAC_PI_2 }.project([0.3, 0.2, 0.1]);
        assert!((x - 0.3).abs() < 1e-12 && (y - 0.2).abs() < 1e-12 && (behind + 0.1).abs() < 1e-12);
    }

    #[test]
    fn rotation_preserves_lengths_and_stops_at_the_poles() {
        let turn = Turn::default().by(2.5, -0.7);
        let ([x, y], behind) = turn.project([1.0, 2.0, 2.0]);
        assert!((x.hypot(y).hypot(behind) - 3.0).abs() < 1e-12);
        let turned = turn.by(0.0, 9.0).by(TAU, 0.0);
        assert!(turned.pitch == FRAC_PI_2 && (turned.yaw - turn.yaw).abs() < 1e-9);
    }

    #[test]
    fn a_cube_has_nine_edges_and_its_labels_are_outside() {
        for turn in [Turn::default(), Turn { yaw: -2.0, pitch: -0.5 }, Turn { yaw: 1.2, pitch: 0.1 }] {
            let scene = scene(&[], &[], None, 2.5, Span::WHOLE, turn);
            let edges: Vec<_> = scene.below.iter().filter(|(role, _)| *role == Role::Edge).collect();
            assert_eq!(edges.len(), 9);
            let names: Vec<_> = scene.labels.iter().filter(|label| label.name).collect();
            assert_eq!(names.iter().map(|label| label.text.as_str()).collect::<String>(), "RGB");
            for label in &scene.labels {
                let [x, y] = label.at;
                assert!(x.hypot(y) > 0.49 && x.hypot(y) <= EXTENT + 1e-9, "{turn:?}: {label:?}");
                assert!(x * label.out[0] + y * label.out[1] > 0.0, "{turn:?}: {label:?} stands outside");
            }
        }
        let above = scene(&[], &[], None, 2.5, Span::WHOLE, Turn { yaw: 0.3, pitch: FRAC_PI_2 });
        let numbers = above.labels.iter().filter(|label| !label.name).count();
        assert_eq!(numbers, 2 * 3, "B is parallel to the line of sight: only R and G have 0, 100 and 200");
    }

    #[test]
    fn nearer_points_are_drawn_over_farther_ones() {
        use crate::explain::pixel::scatter_points::PointKind;
        let place = |at| ScatterPoint { kind: PointKind::Verdict { foreground: false }, at, count: 1 };
        let places = [place([10, 10, 10]), place([10, 250, 10]), place([10, 120, 10])];
        let scene = scene(&places, &[], None, 2.5, Span::WHOLE, Turn { yaw: 0.0, pitch: 0.0 });
        let order: Vec<_> = scene.spots.iter().map(|spot| spot.place.at[1]).collect();
        assert_eq!(order, [250, 120, 10], "greater G is further back");
        assert!(scene.spots[2].nearness > scene.spots[0].nearness);
    }

    #[test]
    fn a_span_contains_all_values_and_components() {
        use crate::explain::pixel::scatter_points::PointKind;
        use crate::mixture::Component;
        let place = ScatterPoint { kind: PointKind::Age(0), at: [100, 90, 80], count: 1 };
        let component = Component { weight: 1.0, mean: [110.0, 90.0, 80.0], variance: 16.0 };
        let component_state = ComponentState {
            rank: 1,
            slot: 0,
            component,
            background: true,
            distance: None,
            matched: false,
            new: false,
        };
        let span = Span::around(&[place], &[component_state], 2.5);
        assert_eq!((span.side, span.low), (21.0, [99.0, 79.5, 69.5]));
        assert_eq!(Span::around(&[], &[], 2.5), Span::WHOLE);
    }
}
