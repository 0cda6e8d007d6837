//! Reads marks back from the SVG and compares them with the states.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeSet;

use ::svg::parser::Event;

use super::cube::{Look, Turn};
use super::mixture::{UpdateSide, densities, weights};
use super::{Figure, Sign, cube, pins, region, scatter, svg, through_time, tuning};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_slots::{ComponentChange, component_change, slots_by_rank};
use crate::explain::pixel::component_states::component_states;
use crate::explain::pixel::region_shares::RegionShares;
use crate::explain::pixel::scatter_points::{PointGrouping, ScatterSelection, ScatterSpace};
use crate::explain::tuning::{TunableSetting, map};
use crate::export::pixel_csv;
use crate::export::tests::written;
use crate::mixture::{MAX_K, Parameters};
use crate::palette::component_on_light;
use crate::settings::{Preset, Settings, Space as Channels};

/// Two surfaces in turn with noise, and temporarily a third.
fn history_of(settings: &Settings, frames: u32) -> PixelHistory {
    let mut seed = 4711_u32;
    let mut noise = move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((seed >> 16) % 9) as u8
    };
    let colours = (1..=frames).map(|n| {
        let [r, g, b] = match n {
            220..240 => [58 + (n % 20) as u8, 44, 70],
            _ if n % 17 < 5 => [92, 128, 64],
            _ => [168, 160, 150],
        };
        (n, [r + noise(), g + noise(), b + noise()])
    });
    PixelHistory::of_colours((5, 4), Parameters::new(settings), colours)
}

fn settings() -> Settings {
    Settings { t: 0.8, k: 4, alpha: 0.01, ..Settings::preset(Preset::Plain) }
}

/// A panel parsed from the file.
struct WrittenPanel {
    place: [f64; 4],
    ends: [[f64; 2]; 2],
    logarithmic: bool,
    /// The name and the path of each mark.
    marks: Vec<(String, String)>,
}

impl WrittenPanel {
    /// The values at a position in the figure.
    fn values(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, width, height] = self.place;
        let [[x0, x1], [y0, y1]] = self.ends;
        let up = 1.0 - (y - top) / height;
        let y = if self.logarithmic { y0 * (y1 / y0).powf(up) } else { y0 + up * (y1 - y0) };
        [x0 + (x - left) / width * (x1 - x0), y]
    }

    /// The corners of all marks of this name.
    fn corners(&self, name: &str) -> Vec<Vec<[f64; 2]>> {
        let found = self.marks.iter().filter(|(own, _)| own == name);
        found
            .map(|(_, points)| {
                let numbers = numbers(points);
                numbers.chunks_exact(2).map(|pair| self.values([pair[0], pair[1]])).collect()
            })
            .collect()
    }
}

fn numbers(text: &str) -> Vec<f64> {
    text.split([' ', ',']).filter(|part| !part.is_empty()).map(|part| part.parse().unwrap()).collect()
}

/// The panels of a file. Rectangles are given by their lower left and upper right corners, dots by their centres.
fn panels(text: &str) -> Vec<WrittenPanel> {
    let (mut panels, mut name) = (Vec::<WrittenPanel>::new(), String::new());
    for event in ::svg::read(text).unwrap() {
        let Event::Tag(tag, _, attributes) = event else { continue };
        let get = |key: &str| attributes.get(key).map_or("", |value| value);
        if !get("data-place").is_empty() {
            let ends = |key| numbers(get(key)).try_into().unwrap();
            panels.push(WrittenPanel {
                place: numbers(get("data-place")).try_into().unwrap(),
                ends: [ends("data-x"), ends("data-y")],
                logarithmic: get("data-log") == "y",
                marks: Vec::new(),
            });
            name.clear();
        } else if tag == "g" {
            name = get("data-name").to_owned();
        }
        let Some(panel) = panels.last_mut().filter(|_| !name.is_empty()) else { continue };
        let points = match tag {
            "polyline" | "polygon" => get("points").to_owned(),
            "circle" => format!("{},{}", get("cx"), get("cy")),
            "path" => get("d").replace(['M', 'H', 'V', 'Z'], " "),
            _ => continue,
        };
        let each: Vec<String> = if tag == "path" && !points.contains('h') {
            // M left bottom H right V top H left Z.
            let rects = numbers(&points);
            rects.chunks_exact(5).map(|r| format!("{},{} {},{}", r[0], r[1], r[2], r[3])).collect()
        } else {
            vec![points]
        };
        panel.marks.extend(each.into_iter().map(|points| (name.clone(), points)));
    }
    panels
}

fn assert_near(a: f64, b: f64, off: f64) {
    assert!((a - b).abs() <= off, "{a} is not {b}");
}

/// The table of `occluscope pixel`, as a map from column to values.
fn csv(history: &PixelHistory) -> impl Fn(&str) -> Vec<f64> {
    let text = written(|out| {
        pixel_csv::write_header(out, &history.parameters)?;
        history.states.iter().try_for_each(|state| pixel_csv::write_row(out, &history.parameters, state))
    });
    let mut reader = ::csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().unwrap().clone();
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    move |name: &str| {
        let column = header.iter().position(|head| head == name).unwrap();
        rows.iter().map(|row| row[column].parse().unwrap()).collect()
    }
}

#[test]
fn a_history_figure_equals_the_table_of_the_command_line() {
    let history = history_of(&settings(), 400);
    let column = csv(&history);
    let choice = through_time::HistorySelection { frames: 0..400, index: 230, fit: false };
    let panels = panels(&svg::write(&through_time::figure(&history, &slots_by_rank(&history), &choice)));
    assert_eq!(panels.len(), 8, "three channels, weights, B, ρ, changes, verdict");
    let frames = column("frame");
    for (panel, channel) in panels.iter().zip(["r", "g", "b"]) {
        let line = &panel.corners(&format!("value {}", channel.to_uppercase()))[0];
        assert_eq!(line.len(), 400);
        for ((point, frame), value) in line.iter().zip(&frames).zip(column(&format!("value_{channel}"))) {
            assert_near(point[0], *frame, 1e-3);
            assert_near(point[1], value, 5e-3);
        }
    }
    // The first mean is that of the component of rank 1, up to the first change of rank.
    let mean = &panels[0].corners("mean of component 1")[0];
    for (point, value) in mean[1..].iter().zip(column("mu1_r")).take(20) {
        assert_near(point[1], value, 5e-3);
    }
    let (w1, w2) = (column("w1"), column("w2"));
    for (at, rank) in [(0, 1), (1, 2)] {
        let areas = panels[3].corners(&format!("weight of rank {rank}"));
        // Two corners per frame along the upper edge, and back along the lower one.
        for area in areas {
            let upper = &area[..area.len() / 2];
            for step in upper.chunks_exact(2) {
                let frame = f64::midpoint(step[0][0], step[1][0]).round() as usize - 1;
                assert_near(step[0][1], w1[frame] + f64::from(at) * w2[frame], 1e-4);
            }
        }
    }
    let counts = &panels[4].corners("B")[0];
    for (step, count) in counts.chunks_exact(2).zip(column("background_count")) {
        assert_near(step[0][1], count, 1e-3);
    }
    let drawn: Vec<_> = panels[5].corners("ρ").into_iter().flatten().collect();
    let learned: Vec<_> = column("rho").into_iter().filter(|&rho| rho > 0.0).collect();
    assert_eq!(drawn.len(), 2 * learned.len());
    for (step, rho) in drawn.chunks_exact(2).zip(learned) {
        assert_near(step[0][1] / rho, 1.0, 1e-3);
    }
    let foreground: BTreeSet<usize> = panels[7]
        .corners("foreground")
        .iter()
        .flat_map(|rect| (rect[0][0] + 0.5).round() as usize..(rect[1][0] + 0.5).round() as usize)
        .collect();
    let expected = column("foreground").into_iter().enumerate().filter(|(_, foreground)| *foreground == 1.0);
    assert_eq!(foreground, expected.map(|(at, _)| at + 1).collect());
    assert_near(panels[3].corners("T")[0][0][1], 0.8, 1e-4);
    assert_near(panels[2].corners("current frame")[0][0][0], 231.0, 1e-3);
    let born: Vec<_> = panels[6].corners("created").iter().map(|mark| mark[0][0].round() as usize).collect();
    let made = column("matched").iter().filter(|&&matched| matched == 0.0).count();
    let replaced = panels[6].corners("replaced").len();
    assert_eq!((born[0], born.len() + replaced), (1, made));
}

#[test]
fn a_part_of_a_history_has_its_own_frames_and_a_long_history_keeps_extremes() {
    let history = history_of(&settings(), 400);
    let choice = through_time::HistorySelection { frames: 100..150, index: 10, fit: true };
    let part = through_time::figure(&history, &slots_by_rank(&history), &choice);
    assert_eq!(part.title, "pixel (5, 4), frames 101–150");
    let panels_of_part = panels(&svg::write(&part));
    assert_near(panels_of_part[0].ends[0][0], 100.5, 0.0);
    assert_eq!(panels_of_part[1].corners("value G")[0].len(), 50);
    assert!(panels_of_part[0].corners("current frame").is_empty(), "the current frame is outside the part");

    let colours = (1..=20_000).map(|n| (n, if n == 7777 { [250; 3] } else { [60 + (n % 4) as u8; 3] }));
    let long = PixelHistory::of_colours((1, 1), Parameters::new(&settings()), colours);
    let choice = through_time::HistorySelection { frames: 0..20_000, index: 3, fit: false };
    let text = svg::write(&through_time::figure(&long, &slots_by_rank(&long), &choice));
    assert!(text.len() < 2_000_000, "{}", text.len());
    let line = panels(&text)[0].corners("value R").remove(0);
    let highest = line.iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
    assert_near(highest[1], 250.0, 5e-3);
    assert_near(highest[0], 7777.0, 20_000.0 / 1500.0);
}

#[test]
fn densities_and_weights_equal_those_of_the_mixture() {
    let history = history_of(&settings(), 400);
    let slots = slots_by_rank(&history);
    for (moment, index) in [(UpdateSide::Before, 225), (UpdateSide::After, 225), (UpdateSide::Both, 300)] {
        let text = svg::write(&densities(&history, &slots, index, moment));
        let panels_of = panels(&text);
        let weights = panels(&svg::write(&weights(&history, &slots, index, moment)));
        for (column, &before) in moment.sides().iter().enumerate() {
            let (component_states, count) = component_states(&history, &slots, index, before);
            let mut sum = 0.0;
            for component_state in &component_states {
                for channel in 0..3 {
                    let panel = &panels_of[3 * column + channel];
                    for point in &panel.corners(&format!("density of rank {}", component_state.rank))[0] {
                        assert_near(point[1], component_state.marginal(channel, point[0]), 2e-5);
                    }
                    let band = &panel.corners(&format!("band of rank {}", component_state.rank))[0];
                    let reach = 2.5 * f64::from(component_state.component.sigma());
                    assert_near(band[0][0], f64::from(component_state.component.mean[channel]) - reach, 5e-3);
                    assert_near(band[1][0], f64::from(component_state.component.mean[channel]) + reach, 5e-3);
                    assert_near(
                        panel.corners("value")[0][0][0],
                        history.states[index].value[channel].into(),
                        5e-3,
                    );
                }
                let bar = &weights[column].corners(&format!("weight of rank {}", component_state.rank))[0];
                assert_near(bar[0][0], sum, 1e-4);
                sum += f64::from(component_state.component.weight);
                assert_near(bar[1][0], sum, 1e-4);
            }
            let cut = weights[column].corners("B")[0][0][1];
            assert_near(weights[column].ends[1][1] - cut, count as f64, 1e-3);
            assert_near(weights[column].corners("T")[0][0][0], 0.8, 1e-4);
        }
    }
}

#[test]
fn a_long_history_shows_how_much_of_a_column_is_foreground() {
    let colour = |n| match n {
        7777 => [250; 3],
        10_000..10_040 => [200; 3],
        _ => [60 + (n % 4) as u8; 3],
    };
    let parameters = Parameters::new(&settings());
    let long = PixelHistory::of_colours((1, 1), parameters, (1..=20_000).map(|n| (n, colour(n))));
    let of = |history: &PixelHistory, frames: usize| {
        let choice = through_time::HistorySelection { frames: 0..frames, index: 3, fit: false };
        let figure = through_time::figure(history, &slots_by_rank(history), &choice);
        let strip = figure.panels.last().unwrap();
        let strengths: Vec<_> = strip
            .marks
            .iter()
            .filter(|mark| mark.name == "foreground")
            .flat_map(|mark| {
                let super::MarkShape::Rects(rects) = &mark.shape else { panic!("{mark:?}") };
                rects.iter().map(|rect| (rect[0], rect[2], mark.opacity))
            })
            .collect();
        let keys: Vec<_> = figure.legend.into_iter().map(|key| key.name).collect();
        (strengths, keys)
    };
    let (strengths, keys) = of(&long, 20_000);
    let at = |frame: f64| strengths.iter().find(|(from, to, _)| (*from..*to).contains(&frame)).unwrap().2;
    assert!(at(7777.0) < 0.6, "one of thirteen frames: {strengths:?}");
    assert_eq!(at(10_006.0), 1.0, "all of them: {strengths:?}");
    assert!(keys.iter().any(|key| key == "some of a column's frames"), "{keys:?}");
    // If every frame has its own column, each column is entirely background or foreground.
    let short = PixelHistory { states: long.states[7000..8000].to_vec(), ..long };
    let (strengths, keys) = of(&short, 1000);
    assert!(!strengths.is_empty() && strengths.iter().all(|strength| strength.2 == 1.0), "{strengths:?}");
    assert!(!keys.iter().any(|key| key.contains("some of")), "{keys:?}");
}

#[test]
fn a_legend_of_both_mixtures_has_both_ranks() {
    let history = history_of(&settings(), 400);
    let slots = slots_by_rank(&history);
    let rose =
        |index: &usize| matches!(component_change(&history, *index), Some(ComponentChange::Rose { .. }));
    let index = (1..400).find(rose).unwrap();
    let (was, is) = match component_change(&history, index) {
        Some(ComponentChange::Rose { from, to }) => (from, to),
        other => panic!("{other:?}"),
    };
    for figure in [densities, weights].map(|of| of(&history, &slots, index, UpdateSide::Both)) {
        let names: Vec<_> = figure.legend.iter().map(|key| key.name.as_str()).collect();
        assert!(names.iter().any(|name| name.ends_with(&format!("{is} (was {was})"))), "{names:?}");
        for component_state in component_states(&history, &slots, index, false).0 {
            let key = &figure.legend[component_state.rank - 1];
            assert_eq!(key.colour, component_on_light(component_state.slot.into()), "{names:?}");
            assert!(key.name.contains(&component_state.rank.to_string()), "{names:?}");
            assert_eq!(key.sign == Sign::Band, component_state.background, "as after the update: {names:?}");
        }
    }
    let made = (1..400)
        .find(|&index| component_change(&history, index) == Some(ComponentChange::Replaced))
        .unwrap_or(1);
    let new = usize::from(history.states[made].outcome.rank);
    let names: Vec<_> =
        weights(&history, &slots, made, UpdateSide::Both).legend.into_iter().map(|key| key.name).collect();
    let expected = history.states[made].outcome.matched == 0;
    assert_eq!(names[new - 1].ends_with("(new)"), expected, "frame {made}: {names:?}");
    // A single mixture has a single set of ranks.
    for moment in [UpdateSide::Before, UpdateSide::After] {
        let legend = densities(&history, &slots, index, moment).legend;
        assert!(legend.iter().all(|key| !key.name.contains('(')), "{legend:?}");
    }
}

#[test]
fn a_figure_names_every_parameter() {
    let description = |settings: &Settings| super::parameters(&history_of(settings, 3));
    let first = description(&settings());
    assert!(first.contains("α ≥ 1/t for t ≤ 0") && first.ends_with("X = (R, G, B)"), "{first}");
    for other in [
        Settings { warm_up: 100, ..settings() },
        Settings { space: Channels::Gray, ..settings() },
        Settings { k: 5, ..settings() },
        Settings { alpha: 0.02, ..settings() },
        Settings { t: 0.6, ..settings() },
        Settings { match_sigmas: 3.0, ..settings() },
        Settings { initial_sigma: 11.0, ..settings() },
        Settings { initial_weight: 0.02, ..settings() },
        Settings { min_sigma: 2.5, ..settings() },
        Settings { rate: crate::settings::Rate::Density, ..settings() },
    ] {
        assert_ne!(description(&other), first, "{other:?}");
    }
}

/// A share of foreground that varies, with less after cleaning.
fn shares() -> RegionShares {
    let share = |n: u32| (1.6 * (n as f32 / 44.0).sin() - 0.4).clamp(0.0, 1.0);
    let model = (0..400).map(|n| (share(n) + if n % 7 == 0 { 0.12 } else { 0.0 }).min(1.0)).collect();
    RegionShares { at: (5, 4), side: 5, pixels: 25, model, cleaned: (0..400).map(share).collect() }
}

#[test]
fn the_shares_around_a_pixel_and_pinned_pixels_are_drawn_frame_by_frame() {
    let history = history_of(&settings(), 400);
    let shares = shares();
    let panel = &panels(&svg::write(&region::figure(&history, &shares, 230)))[0];
    let (area, line) =
        (&panel.corners("ratio after post-processing")[0], &panel.corners("ratio before post-processing")[0]);
    assert_eq!((area.len(), line.len()), (802, 800), "two corners a frame, and the ground");
    for at in 0..400 {
        for (corners, expected) in [(area, shares.cleaned[at]), (line, shares.model[at])] {
            for (corner, frame) in
                [(corners[2 * at], at as f64 + 0.5), (corners[2 * at + 1], at as f64 + 1.5)]
            {
                assert_near(corner[0], frame, 1e-2);
                assert_near(corner[1], expected.into(), 1e-3);
            }
        }
    }
    assert_near(panel.corners("current frame")[0][0][0], 231.0, 1e-2);

    let other = PixelHistory { at: (70, 8), ..history_of(&Settings { k: 2, ..settings() }, 400) };
    let figure = pins::figure(&[(1, &history), (4, &other)], 230);
    let captions: Vec<_> = figure
        .panels
        .iter()
        .map(|panel| panel.caption.as_str())
        .filter(|caption| !caption.is_empty())
        .collect();
    assert_eq!(captions, ["P1, pixel (5, 4)", "P4, pixel (70, 8)"]);
    let panels = panels(&svg::write(&figure));
    assert_eq!(panels.len(), 4, "each with its verdicts");
    for (pair, history) in panels.chunks(2).zip([&history, &other]) {
        let line = &pair[0].corners("brightness")[0];
        assert_eq!(line.len(), 400);
        for (point, state) in line.iter().zip(&history.states) {
            assert_near(point[0], state.number.into(), 1e-2);
            assert_near(point[1], crate::mixture::pixel::luma(state.rgb).into(), 1e-2);
        }
        let first = &pair[0].corners("band of rank 1");
        assert_eq!(first.len(), 400);
        let [r, g, b] = history.states[399].pixel.components()[0].mean.map(f64::from);
        let middle = f64::midpoint(first[399][0][1], first[399][1][1]);
        assert_near(middle, 0.299 * r + 0.587 * g + 0.114 * b, 1e-2);
        let frames = pair[1].corners("foreground").iter().map(|rect| rect[1][0] - rect[0][0]).sum::<f64>();
        assert_near(
            frames,
            history.states.iter().filter(|state| state.outcome.foreground).count() as f64,
            0.5,
        );
    }
}

fn selection(space: ScatterSpace, by: PointGrouping) -> ScatterSelection {
    ScatterSelection { space, frames: 0..400, by }
}

/// All dots of a panel, in whole levels.
fn dots(panel: &WrittenPanel) -> BTreeSet<[i32; 2]> {
    let names: BTreeSet<_> = panel.marks.iter().map(|(name, _)| name.as_str()).collect();
    let values = names.into_iter().filter(|name| name.starts_with("values"));
    values.flat_map(|name| panel.corners(name)).map(|at| at[0].map(|level| level.round() as i32)).collect()
}

#[test]
fn a_scatter_plot_has_a_dot_for_every_value() {
    let history = history_of(&settings(), 400);
    let slots = slots_by_rank(&history);
    let values: Vec<[i32; 3]> =
        history.states.iter().map(|state| state.value.map(|level| level as i32)).collect();
    for by in [PointGrouping::Component, PointGrouping::Verdict, PointGrouping::Time] {
        for (x, y) in [(0, 1), (1, 2), (0, 2)] {
            let text = svg::write(&scatter::figure(
                &history,
                &slots,
                &selection(ScatterSpace::Plane(x, y), by),
                230,
            ));
            let expected = values.iter().map(|value| [value[x], value[y]]).collect();
            let panel = &panels(&text)[0];
            assert_eq!(dots(panel), expected, "{x} {y} {by:?}");
            let circle = &panel.corners("reach of rank 1")[0];
            let component = history.states[230].pixel.components()[0];
            for point in circle {
                let off =
                    (point[0] - f64::from(component.mean[x])).hypot(point[1] - f64::from(component.mean[y]));
                assert_near(off, 2.5 * f64::from(component.sigma()), 0.01);
            }
        }
    }
    let gray = history_of(&Settings { space: Channels::Gray, ..settings() }, 400);
    let slots = self::slots_by_rank(&gray);
    let text = svg::write(&scatter::figure(
        &gray,
        &slots,
        &selection(ScatterSpace::Next, PointGrouping::Verdict),
        230,
    ));
    let expected =
        gray.states.windows(2).map(|pair| [pair[0].value[0] as i32, pair[1].value[0] as i32]).collect();
    assert_eq!(dots(&panels(&text)[0]), expected);
}

#[test]
fn the_front_view_of_a_cube_is_the_plane_of_r_and_b() {
    let history = history_of(&settings(), 400);
    let slots = slots_by_rank(&history);
    let look = Look { turn: Turn { yaw: 0.0, pitch: 0.0 }, fit: false };
    let figure =
        cube::figure(&history, &slots, &selection(ScatterSpace::Cube, PointGrouping::Verdict), 230, look);
    let panel = &panels(&svg::write(&figure))[0];
    let drawn: BTreeSet<[i32; 2]> = panel
        .corners("values")
        .iter()
        .map(|at| at[0].map(|place| ((place + 0.5) * 255.0).round() as i32))
        .collect();
    let expected =
        history.states.iter().map(|state| [state.value[0] as i32, state.value[2] as i32]).collect();
    assert_eq!(drawn, expected);
    assert!(figure.description.contains("rotated by 0° about B"), "{}", figure.description);
}

#[test]
fn every_cell_of_a_map_is_drawn_once_with_its_verdict() {
    let history = history_of(&settings(), 230);
    let values: Vec<_> = history.states.iter().map(|state| state.value).collect();
    let map = map(&values, &history.parameters, [TunableSetting::T, TunableSetting::K]);
    let panel = &panels(&svg::write(&tuning::figure(&history, &map, 229)))[0];
    let mut seen = 0;
    for (foreground, name) in [(false, "background"), (true, "foreground")] {
        for cell in panel.corners(name) {
            let [x, y] = [0, 1].map(|side| f64::midpoint(cell[0][side], cell[1][side]) as f32);
            let [column, row] =
                [(0, x), (1, y)].map(|(side, at)| map.axes[side].cell_at(map.axes[side].share_of(at)));
            assert_eq!(map.is_foreground(column, row), foreground, "{column} {row}");
            seen += 1;
        }
    }
    assert_eq!(seen, 24 * MAX_K);
    assert!(map.foreground_share() > 0.0 && map.foreground_share() < 1.0, "the test has both verdicts");
}

/// One figure of each kind, in colour and in gray.
fn all() -> Vec<(&'static str, Figure)> {
    let history = history_of(&settings(), 400);
    let of = slots_by_rank(&history);
    let crowded = Settings { space: Channels::Gray, k: 8, initial_sigma: 4.0, min_sigma: 1.0, ..settings() };
    let gray = history_of(&crowded, 300);
    let of_gray = slots_by_rank(&gray);
    let values: Vec<_> = history.states[..=230].iter().map(|state| state.value).collect();
    let maps = [[TunableSetting::Alpha, TunableSetting::T], [TunableSetting::Lambda, TunableSetting::K]]
        .map(|tuned_settings| map(&values, &history.parameters, tuned_settings));
    let look = Look { turn: Turn::default(), fit: true };
    let part = |frames, fit| through_time::HistorySelection { frames, index: 230, fit };
    vec![
        ("history", through_time::figure(&history, &of, &part(0..400, false))),
        ("history-part", through_time::figure(&history, &of, &part(200..260, true))),
        ("history-gray", through_time::figure(&gray, &of_gray, &part(0..300, false))),
        ("densities", densities(&history, &of, 230, UpdateSide::After)),
        ("densities-both", densities(&history, &of, 230, UpdateSide::Both)),
        ("densities-gray", densities(&gray, &of_gray, 230, UpdateSide::Before)),
        ("weights", weights(&history, &of, 230, UpdateSide::After)),
        ("weights-both", weights(&history, &of, 230, UpdateSide::Both)),
        ("weights-gray", weights(&gray, &of_gray, 230, UpdateSide::After)),
        (
            "scatter",
            scatter::figure(
                &history,
                &of,
                &selection(ScatterSpace::Plane(0, 1), PointGrouping::Component),
                230,
            ),
        ),
        (
            "scatter-time",
            scatter::figure(&history, &of, &selection(ScatterSpace::Plane(1, 2), PointGrouping::Time), 230),
        ),
        (
            "scatter-gray",
            scatter::figure(&gray, &of_gray, &selection(ScatterSpace::Next, PointGrouping::Verdict), 230),
        ),
        (
            "cube",
            cube::figure(&history, &of, &selection(ScatterSpace::Cube, PointGrouping::Component), 230, look),
        ),
        (
            "cube-time",
            cube::figure(
                &history,
                &of,
                &selection(ScatterSpace::Cube, PointGrouping::Time),
                230,
                Look { fit: false, ..look },
            ),
        ),
        ("tuning", tuning::figure(&history, &maps[0], 230)),
        ("tuning-k", tuning::figure(&history, &maps[1], 230)),
        ("region", region::figure(&history, &shares(), 230)),
        ("pins", pins::figure(&[(1, &history), (2, &gray), (5, &history)], 230)),
        ("pins-none", pins::figure(&[], 230)),
    ]
}

#[test]
fn all_text_is_inside_its_figure() {
    for (name, figure) in all() {
        let text = svg::write(&figure);
        let [width, height] = figure.size;
        let mut open: Option<(f64, f64, f64, String)> = None;
        for event in ::svg::read(&text).unwrap() {
            match event {
                Event::Tag("text", _, attributes) if attributes.contains_key("x") => {
                    let get = |key: &str| attributes[key].parse::<f64>().unwrap();
                    let upright = attributes.contains_key("transform");
                    let anchor = attributes["text-anchor"].to_string();
                    open = (!upright).then(|| (get("x"), get("y"), get("font-size"), anchor));
                }
                Event::Text(content) => {
                    let Some((x, y, size, anchor)) = open.take() else { continue };
                    let wide = super::text::width(content, size);
                    let left = x - wide
                        * match anchor.as_str() {
                            "start" => 0.0,
                            "middle" => 0.5,
                            _ => 1.0,
                        };
                    assert!(
                        left >= 0.0 && left + wide <= width,
                        "{name}: {content:?} from {left} to {}",
                        left + wide
                    );
                    assert!(y - size >= 0.0 && y <= height, "{name}: {content:?} at {y} of {height}");
                }
                _ => {}
            }
        }
    }
}

#[test]
#[cfg(feature = "gui")]
fn rasterised_figures_are_white_and_have_a_physical_size() {
    use super::raster;
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("target/figures");
    std::fs::create_dir_all(&folder).unwrap();
    for (name, figure) in all() {
        let picture = raster::picture(&figure).unwrap();
        let [width, height] = figure.size.map(|length| (length / 72.0 * raster::RESOLUTION).round() as u32);
        assert_eq!((picture.size.width, picture.size.height), (width, height), "{name}");
        let dark = picture.rgb.chunks_exact(3).filter(|pixel| pixel.iter().all(|&level| level < 70)).count();
        let white = picture.rgb.chunks_exact(3).filter(|pixel| *pixel == [255; 3]).count();
        let all = picture.size.pixels();
        assert!(dark > 500 && white > all / 4, "{name}: {dark} dark, {white} white of {all}");
        std::fs::write(folder.join(format!("{name}.svg")), svg::write(&figure)).unwrap();
        let path = folder.join(format!("{name}.png"));
        raster::write_png(&path, &picture).unwrap();
        assert_eq!(image::open(&path).unwrap().into_rgb8().into_raw(), picture.rgb);
        let bytes = std::fs::read(&path).unwrap();
        // 300 pixels per inch are 11 811 per metre.
        let size = [&b"pHYs"[..], &11_811_u32.to_be_bytes(), &11_811_u32.to_be_bytes(), &[1]].concat();
        assert!(bytes.windows(size.len()).any(|part| part == size), "{name}");
    }
}

#[test]
#[cfg(feature = "gui")]
fn a_pdf_has_the_figures_size_and_its_typeface() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("target/figures");
    std::fs::create_dir_all(&folder).unwrap();
    for (name, figure) in all() {
        let bytes = super::pdf::write(&figure).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let (_, page) = text.split_once("/MediaBox [").expect("a page has a size");
        let sides: Vec<f64> =
            page.split(']').next().unwrap().split(' ').map(|side| side.parse().unwrap()).collect();
        for (side, length) in [0.0, 0.0, figure.size[0], figure.size[1]].iter().zip(&sides) {
            assert!((side - length).abs() < 0.01, "{name}: {sides:?} is not {:?}", figure.size);
        }
        assert!(text.contains("/FontFile"), "{name}: the typeface is embedded");
        assert!(!text.contains("/Subtype /Image"), "{name}: nothing is rasterised");
        std::fs::write(folder.join(format!("{name}.pdf")), &bytes).unwrap();
    }
}
