//! The object panel: state, motion model, competing hypotheses and appearance of the chosen object.

use eframe::egui::{
    Align, Color32, CornerRadius, Grid, Layout, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, Ui,
    WidgetInfo, accesskit::Role, vec2,
};

use crate::app::commands::command::Command;
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::event_comparison::EventRef;
use crate::app::panels::evidence::participants;
use crate::app::theme;
use crate::export::source_pixels;
use crate::palette::{event_colour, identity_colour};
use crate::regions::{Region, Shape, colour::delta_e};
use crate::replay::TrackTimeline;
use crate::tracking::{HypothesisSummary, Identity, Track, TrackState};

/// The number of displayed colours of a region's histogram.
const MAX_HISTOGRAM_BARS: usize = 10;

/// Draws the chosen object in the frame in view.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some((id, shown)) = model.selection.object.zip(model.worker.shown()) else { return };
    let life = model
        .worker
        .timeline()
        .and_then(|timeline| timeline.track_timelines.iter().find(|line| line.id == id));
    let track = shown.analysis.tracks.iter().find(|track| track.id == id);
    ScrollArea::vertical().id_salt("object").auto_shrink(false).min_scrolled_height(0.0).show(ui, |ui| {
        head(ui, id, track);
        ui.label(track.map_or_else(|| "No box in this frame.".to_owned(), state_sentence));
        if let Some(life) = life {
            track_timeline(ui, model, life, commands);
        }
        if let Some(track) = track {
            let placement = model.worker.placement();
            let moved = placement.map(|placement| source_pixels::track_in_source(track, &placement));
            let in_source = moved.as_ref().unwrap_or(track);
            motion(ui, in_source, model.worker.fps(), &shown.settings);
            hypotheses_table(ui, &in_source.hypotheses);
            for region in shown.analysis.regions.iter().filter(|region| track.regions.contains(&region.label))
            {
                let shape = placement.map_or(region.shape, |placement| placement.source_shape(&region.shape));
                appearance(ui, region, &shape, track, shown.settings.same_colour);
            }
        }
        object_events(ui, model, id, commands);
        ui.add_space(2.0 * theme::SPACE);
    });
}

fn head(ui: &mut Ui, id: Identity, track: Option<&Track>) {
    ui.horizontal(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(18.0, 18.0), Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("colour of object {id}")));
        ui.painter().rect_filled(rect, 3.0, theme::rgb(identity_colour(id)));
        ui.label(RichText::new(format!("Object {id}")).size(theme::HEADING_TEXT).strong());
        if let Some(track) = track {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.weak(track.state.label()));
        }
    });
}

/// The object's state in a sentence, with its numbers.
fn state_sentence(track: &Track) -> String {
    let list = |numbers: &mut dyn Iterator<Item = u32>| {
        numbers.map(|number| number.to_string()).collect::<Vec<_>>().join(", ")
    };
    let regions = list(&mut track.regions.iter().copied());
    let regions = match track.regions.len() {
        1 => format!("region {regions}"),
        _ => format!("regions {regions}"),
    };
    let seen = (track.visible_share * 100.0).round();
    match track.state {
        TrackState::Visible => {
            format!("Associated with {regions}; {seen} % of its full size is visible.")
        }
        TrackState::Merged => {
            let others = list(&mut track.group.iter().copied().filter(|&other| other != track.id));
            format!("Shares {regions} with {others}; {seen} % of it is visible. Its box is predicted.")
        }
        TrackState::Hidden => {
            "Occluded: no associated region. Its box is predicted, dashed in the views.".to_owned()
        }
    }
}

fn section(ui: &mut Ui, title: &str, meaning: &str) {
    ui.add_space(2.0 * theme::SPACE);
    ui.label(RichText::new(title).strong()).on_hover_text(meaning);
}

fn row(ui: &mut Ui, name: &str, value: String, meaning: &str) {
    ui.label(RichText::new(name).size(theme::SMALL_TEXT).color(theme::colours(ui.visuals()).weak))
        .on_hover_text(meaning);
    ui.label(RichText::new(value).monospace()).on_hover_text(meaning);
    ui.end_row();
}

fn rows(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    Grid::new(name).num_columns(2).min_row_height(16.0).spacing([3.0 * theme::SPACE, 2.0]).show(ui, add);
}

/// The state and the gate of the Kalman filter.
fn motion(ui: &mut Ui, track: &Track, fps: f32, settings: &crate::settings::Settings) {
    section(ui, "Kalman model", "State (x, y, s) and its velocity; s is the square root of the area");
    let ([x, y], [vx, vy]) = (track.centre, track.velocity);
    let [major, minor, angle] = track.gate;
    rows(ui, "motion", |ui| {
        row(ui, "centre x, y", format!("{x:.1}, {y:.1} px"), "After this frame's measurement update");
        row(
            ui,
            "velocity",
            format!("{vx:+.2}, {vy:+.2} px/frame"),
            "Velocity of the centre; right and down are positive",
        );
        row(ui, "speed", format!("{:.1} px/s", vx.hypot(vy) * fps), "Speed of the centre");
        row(ui, "size s", format!("{:.1} px", track.scale), "The square root of the area");
        row(
            ui,
            "gate",
            format!("{major:.1} × {minor:.1} px at {:.0}°", angle.to_degrees()),
            "Semi-axes and angle of the association gate for the next region; dotted in the views",
        );
        row(
            ui,
            "fitness",
            format!("{:.3}  (min. {:.3})", track.fitness, settings.min_fitness),
            "Inverse variance of the prediction error, times the null factor for each frame without a \
             region; below min fitness the hypothesis is removed",
        );
        let bbox = track.bbox;
        row(
            ui,
            "box",
            format!("{:.0}, {:.0}  {:.0} × {:.0} px", bbox.x, bbox.y, bbox.w, bbox.h),
            "Left, top, width and height",
        );
    });
}

/// The association hypotheses that compete for the object.
fn hypotheses_table(ui: &mut Ui, hypotheses: &[HypothesisSummary]) {
    section(
        ui,
        "Hypotheses",
        "Each hypothesis associates other regions with the object, or none (null match); shown is the most \
         likely combination over all objects",
    );
    if hypotheses.is_empty() {
        ui.weak("No hypotheses: no associated region.");
        return;
    }
    let colours = theme::colours(ui.visuals());
    Grid::new("hypotheses").num_columns(5).spacing([3.0 * theme::SPACE, 2.0]).striped(true).show(ui, |ui| {
        for title in ["", "probability", "fitness", "association", "centre"] {
            ui.label(RichText::new(title).size(theme::SMALL_TEXT).color(colours.weak));
        }
        ui.end_row();
        for (rank, each) in hypotheses.iter().enumerate() {
            ui.label(RichText::new((rank + 1).to_string()).monospace());
            ui.horizontal(|ui| {
                let (rect, _) = ui.allocate_exact_size(vec2(36.0, 8.0), Sense::hover());
                ui.painter().rect_filled(rect, 2.0, colours.line);
                let share = rect.with_max_x(rect.left() + rect.width() * each.probability);
                ui.painter().rect_filled(share, 2.0, colours.accent);
                ui.monospace(format!("{:.2}", each.probability));
            });
            ui.monospace(format!("{:.3}", each.fitness));
            ui.label(if each.matched { "region" } else { "none" });
            ui.monospace(format!("{:.0}, {:.0}", each.centre[0], each.centre[1]));
            ui.end_row();
        }
    });
}

/// A region's shape in the source and colours, compared with the object's appearance model.
fn appearance(ui: &mut Ui, region: &Region, shape: &Shape, track: &Track, same_colour: f32) {
    let title = format!("Region {}", region.label);
    section(
        ui,
        &title,
        "Connected component of the mask that is associated with the object, alone or in a group",
    );
    rows(ui, &title, |ui| {
        row(ui, "area", format!("{} px", shape.area), "Area in pixels");
        row(
            ui,
            "centroid",
            format!("{:.1}, {:.1} px", shape.centroid[0], shape.centroid[1]),
            "Mean position of the pixels",
        );
        row(
            ui,
            "orientation",
            format!("{:.0}°", shape.orientation.to_degrees()),
            "½·atan2(2μ11, μ20 − μ02): angle of the major axis to the x axis; down is positive",
        );
        row(
            ui,
            "eccentricity",
            format!("{:.3}", shape.eccentricity),
            "√(1 − λ₂/λ₁): 0 for a disc, 1 for a line",
        );
        row(ui, "extent", format!("{:.2}", shape.extent), "Ratio of the area to the area of its box");
    });
    histogram(ui, region);
    let nearest =
        track.colours.iter().map(|&mine| delta_e(mine, region.colour)).fold(f32::INFINITY, f32::min);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = theme::SPACE;
        ui.weak("Appearance model");
        for &colour in &track.colours {
            colour_swatch(ui, colour, 14.0);
        }
        if nearest.is_finite() {
            let same = if nearest <= same_colour { "same" } else { "different" };
            ui.label(format!("ΔE {nearest:.1} to the dominant colour: {same} (threshold {same_colour})"));
        }
    });
}

fn colour_swatch(ui: &mut Ui, colour: [u8; 3], side: f32) {
    let [r, g, b] = colour;
    let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("colour {r}, {g}, {b}")));
    response.on_hover_text(format!("R {r}  G {g}  B {b}"));
    let edge = Stroke::new(1.0, ui.visuals().text_color().gamma_multiply(0.25));
    ui.painter().rect(rect, CornerRadius::same(2), theme::rgb(colour), edge, StrokeKind::Inside);
}

/// The most frequent colours of a region, as bars of their ratio.
fn histogram(ui: &mut Ui, region: &Region) {
    let total = region.histogram.total().max(1.0);
    let mut bins: Vec<_> = region.histogram.bins().map(|(_, bin)| (bin.count / total, bin.mean())).collect();
    bins.sort_by(|a, b| b.0.total_cmp(&a.0));
    let kinds = bins.len();
    bins.truncate(MAX_HISTOGRAM_BARS);
    let Some(&(most, [r, g, b])) = bins.first() else { return };
    ui.weak(format!(
        "dominant colour R {r} G {g} B {b}, {:.0} % of pixels; {kinds} bins of 16 levels per channel",
        most * 100.0
    ));
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width().min(300.0), 44.0), Sense::hover());
    response.widget_info(|| {
        WidgetInfo::labeled(Role::Image, true, format!("colours of region {}", region.label))
    });
    let colours = theme::colours(ui.visuals());
    ui.painter().rect_filled(rect, 3.0, colours.canvas);
    let inside = rect.shrink(3.0);
    let pitch = inside.width() / MAX_HISTOGRAM_BARS as f32;
    let column = |at: usize| {
        let left = inside.left() + at as f32 * pitch;
        Rect::from_x_y_ranges(left..=left + pitch - 2.0, inside.y_range())
    };
    for (at, (share, colour)) in bins.iter().enumerate() {
        let column = column(at);
        let bar = column.with_min_y(column.bottom() - (column.height() * share / most).max(2.0));
        let edge = Stroke::new(1.0, ui.visuals().text_color().gamma_multiply(0.3));
        ui.painter().rect(bar, CornerRadius::same(1), theme::rgb(*colour), edge, StrokeKind::Inside);
    }
    let pointed = response.hover_pos().and_then(|at| {
        let index = ((at.x - inside.left()) / pitch) as usize;
        bins.get(index)
    });
    if let Some((share, [r, g, b])) = pointed {
        response.on_hover_text_at_pointer(format!("R {r}  G {g}  B {b}: {:.1} %", share * 100.0));
    }
}

/// The object's states over time, with the frame in view. A click goes to a frame.
fn track_timeline(ui: &mut Ui, model: &Model, life: &TrackTimeline, commands: &mut Vec<Command>) {
    let first = life.spans.iter().map(|span| span.0).min().unwrap_or(0);
    let last = life.spans.iter().map(|span| span.1).max().unwrap_or(0);
    section(ui, "Track timeline", "Full: visible; pale: merged; thin: occluded. Click to go to a frame");
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 22.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, "Frame in track timeline"));
    let colours = theme::colours(ui.visuals());
    ui.painter().rect_filled(rect, 3.0, colours.canvas);
    let inside = rect.shrink2(vec2(4.0, 0.0));
    let many = (last - first + 1) as f32;
    let x = |position: u32| inside.left() + inside.width() * (position.saturating_sub(first)) as f32 / many;
    let colour = theme::rgb(identity_colour(life.id));
    for &(from, to, state) in &life.spans {
        let (high, strength) = match state {
            TrackState::Visible => (8.0, 1.0),
            TrackState::Merged => (8.0, 0.5),
            TrackState::Hidden => (2.0, 0.9),
        };
        let span = Rect::from_x_y_ranges(
            x(from)..=x(to + 1).max(x(from) + 1.0),
            rect.center().y - high / 2.0..=rect.center().y + high / 2.0,
        );
        ui.painter().rect_filled(span, 1.0, colour.gamma_multiply(strength));
    }
    if let Some(shown) = model.worker.shown().filter(|shown| (first..=last).contains(&shown.position)) {
        let at = f32::midpoint(x(shown.position), x(shown.position + 1));
        ui.painter().vline(at, rect.y_range(), Stroke::new(1.5, colours.accent));
    }
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
        let share = ((at.x - inside.left()) / inside.width()).clamp(0.0, 1.0);
        commands.push(Command::GoTo((first + (share * many) as u32).min(last)));
    }
    let frames = |wanted: TrackState| -> u32 {
        let spans = life.spans.iter().filter(|span| span.2 == wanted);
        spans.map(|(from, to, _)| to - from + 1).sum()
    };
    let seconds = many / model.worker.fps();
    ui.weak(format!(
        "frames {}–{}, {seconds:.1} s: {} visible, {} merged, {} occluded",
        model.worker.number(first),
        model.worker.number(last),
        frames(TrackState::Visible),
        frames(TrackState::Merged),
        frames(TrackState::Hidden)
    ));
}

/// The events of the object. A click goes to the event and shows its evidence.
fn object_events(ui: &mut Ui, model: &Model, id: Identity, commands: &mut Vec<Command>) {
    let Some(timeline) = model.worker.timeline() else { return };
    let about = |(_, (_, event)): &(usize, &(u32, crate::occlusion::Event))| {
        event.objects.contains(&id) || event.becomes.contains(&id)
    };
    let events: Vec<_> = timeline.events.iter().enumerate().filter(about).collect();
    if events.is_empty() {
        return;
    }
    section(ui, "Events of this object", "Events that involve this object; click one to show its evidence");
    for (index, (position, event)) in events {
        ui.horizontal(|ui| {
            let colour: Color32 = theme::rgb(event_colour(event.kind));
            ui.label(icons::coloured(icons::of_event(event.kind), colour).size(14.0));
            let text = format!("#{}  {} {}", event.frame, event.kind.label(), participants(event));
            let read = model.selection.event == Some(EventRef::InView(index));
            if ui.selectable_label(read, text).on_hover_text(&event.evidence.branch).clicked() {
                commands.push(Command::OpenEvent(Some(EventRef::InView(index))));
                commands.push(Command::GoTo(*position));
            }
        });
    }
}
