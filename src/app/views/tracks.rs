//! Objects with their trails, occlusion groups, occlusions, and the events of the frame.

use std::collections::HashMap;

use eframe::egui::{Align2, Color32, FontId, Mesh, Rect, Stroke, pos2, vec2};

use super::compose_style::{Compose, ComposeStyle};
use super::draw::{self, OccupiedRects};
use super::external_boxes;
use super::input;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::overlays::TrackOverlay;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::palette::{event_colour, identity_colour};
use crate::regions;
use crate::replay::ShownFrame;
use crate::tracking::{Identity, Track, TrackState};
use crate::truth::boxes::Bounds;

/// The objects over the input.
pub(super) struct TracksContent;

impl ViewContent for TracksContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::Input.layers()
    }

    fn compose_style(&self, _: &Pane<'_>) -> Option<ComposeStyle> {
        Some(compose_style())
    }

    fn paint(&self, pane: &Pane<'_>) {
        paint(pane);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        input::value(shown, at)
    }
}

/// The composition of the view: a darker input, so that boxes stand out.
pub(super) fn compose_style() -> ComposeStyle {
    ComposeStyle { tint: 205.0 / 255.0, ..ComposeStyle::plain(Compose::Input) }
}

/// Draws the objects of the pane's frame.
pub(super) fn paint(pane: &Pane<'_>) {
    pane.compose(compose_style());
    let (tracks, drawn) = (&pane.shown.analysis.tracks, pane.model.display.track_overlays);
    // Trails exist only for the settings in view.
    if drawn.has(TrackOverlay::Trails) && !pane.view.compares() {
        trails(pane);
    }
    for (index, track) in tracks.iter().enumerate().filter(|_| drawn.has(TrackOverlay::Occlusions)) {
        for other in &tracks[index + 1..] {
            if track.group.contains(&other.id) {
                occlusion(pane, &pane.canvas.place(&track.bbox.intersection(&other.bbox)));
            }
        }
        if track.state == TrackState::Hidden {
            occlusion(pane, &pane.canvas.place(&track.bbox));
        }
    }
    let groups = if drawn.has(TrackOverlay::Groups) { groups(tracks) } else { Vec::new() };
    for group in &groups {
        outline(pane, group);
    }
    for track in pane.shown.analysis.tentative.iter() {
        let stroke = Stroke::new(1.0, Color32::from_white_alpha(120));
        draw::dashed_rect(pane.painter, pane.canvas.place(&track.bbox), stroke, 2.0);
    }
    let mut gates = Mesh::default();
    for track in tracks.iter() {
        object(pane, track, &mut gates);
    }
    // Under other settings the same identity may be another object.
    let object = pane.model.selection.object.filter(|_| !pane.view.compares());
    if let Some(track) = tracks.iter().find(|track| object == Some(track.id)) {
        chosen(pane, track);
    }
    if drawn.has(TrackOverlay::Gates) {
        pane.painter.add(gates);
    }
    external_boxes::outlines(pane);
    let truth =
        pane.model.truth.as_ref().and_then(|truth| truth.boxes.as_ref()?.get(&pane.shown.frame.number));
    let truth = truth.filter(|_| drawn.has(TrackOverlay::Truth));
    let placement = pane.model.worker.placement();
    let in_frame = |bounds: &Bounds| placement.map_or(bounds.0, |placement| placement.frame_box(bounds.0));
    for bounds in truth.into_iter().flat_map(|boxes| boxes.values()) {
        let [x, y, w, h] = in_frame(bounds);
        let place = regions::Rect::new(x as f32, y as f32, w as f32, h as f32);
        let place = pane.canvas.place(&place);
        let stroke = |width, colour| Stroke::new(width, colour);
        draw::dashed_rect(pane.painter, place, stroke(3.0, Color32::from_black_alpha(120)), 2.5);
        draw::dashed_rect(pane.painter, place, stroke(1.5, Color32::WHITE), 2.5);
    }
    // Texts come last, so that no box crosses them.
    let mut taken = OccupiedRects::default();
    for track in tracks.iter().filter(|_| drawn.has(TrackOverlay::Names)) {
        let word = match track.state {
            TrackState::Visible => track.id.to_string(),
            state => format!("{} {}", track.id, state.label()),
        };
        let at = pane.canvas.place(&track.bbox).left_top() - vec2(1.0, 1.0);
        let colour = theme::rgb(identity_colour(track.id));
        draw::free_tag(pane.painter, at, &word, colour, pane.canvas.rect, &mut taken);
    }
    for (id, bounds) in truth.into_iter().flatten() {
        let [x, y, w, h] = in_frame(bounds);
        let foot = pane.canvas.screen([(x + w) as f32, (y + h) as f32]) + vec2(1.0, 17.0);
        let word = format!("GT {id}");
        draw::free_tag(pane.painter, foot, &word, Color32::from_gray(225), pane.canvas.rect, &mut taken);
    }
    external_boxes::tags(pane, &mut taken);
    for group in groups.iter().filter(|_| drawn.has(TrackOverlay::Names)) {
        let place = around(pane, group);
        let names: Vec<String> = group.iter().map(|track| track.id.to_string()).collect();
        let at = pos2(place.left(), place.bottom() + 18.0);
        let colour = Color32::from_rgb(244, 246, 250);
        draw::free_tag(pane.painter, at, &names.join(" + "), colour, pane.canvas.rect, &mut taken);
    }
    if drawn.has(TrackOverlay::Events) {
        flags(pane, taken);
    }
}

fn object(pane: &Pane<'_>, track: &Track, gates: &mut Mesh) {
    let colour = theme::rgb(identity_colour(track.id));
    let place = pane.canvas.place(&track.bbox);
    let stroke = Stroke::new(2.0, colour);
    if track.state == TrackState::Visible {
        draw::outlined_rect(pane.painter, place, stroke);
    } else {
        draw::dashed_rect(pane.painter, place, Stroke::new(4.0, Color32::from_black_alpha(90)), 6.0);
        draw::dashed_rect(pane.painter, place, stroke, 6.0);
    }
    let [major, minor, angle] = track.gate;
    let gate = vec2(major, minor);
    if gate.x.is_finite()
        && gate.y.is_finite()
        && gate.length() * pane.canvas.scale < 4.0 * pane.canvas.rect.width()
    {
        let centre = pane.canvas.screen(track.centre);
        // A gate grows while the track coasts; at full opacity a large gate would hide the image.
        let strength = if track.state == TrackState::Visible { 0.8 } else { 0.4 };
        draw::add_ellipse(
            gates,
            centre,
            gate,
            angle,
            pane.canvas.pixel_size(),
            Stroke::new(1.0, colour.gamma_multiply(strength)),
        );
    }
}

/// The chosen object: its predicted motion, and the positions of the hypotheses that compete for it.
fn chosen(pane: &Pane<'_>, track: &Track) {
    let colour = theme::rgb(identity_colour(track.id));
    let place = pane.canvas.place(&track.bbox).expand(3.0);
    draw::outlined_rect(pane.painter, place, Stroke::new(2.0, Color32::WHITE));
    let mut gates = Mesh::default();
    for (rank, each) in track.hypotheses.iter().enumerate() {
        let centre = pane.canvas.screen(each.centre);
        if rank > 0 {
            let [major, minor, angle] = each.gate;
            let gate = vec2(major, minor);
            let faint = Stroke::new(1.0, Color32::WHITE.gamma_multiply(0.25 + 0.6 * each.probability));
            if gate.x.is_finite() && gate.length() * pane.canvas.scale < 4.0 * pane.canvas.rect.width() {
                draw::add_ellipse(&mut gates, centre, gate, angle, pane.canvas.pixel_size(), faint);
            }
        }
        let size = 3.0 + 3.0 * each.probability;
        let ring = Stroke::new(1.5, if rank == 0 { colour } else { Color32::WHITE });
        pane.painter.circle(centre, size, Color32::from_black_alpha(120), ring);
        let number = Align2::LEFT_CENTER;
        let font = FontId::proportional(theme::SMALL_TEXT);
        if track.hypotheses.len() > 1 {
            let at = centre + vec2(size + 3.0, 0.0);
            let word = (rank + 1).to_string();
            pane.painter.text(at + vec2(1.0, 1.0), number, &word, font.clone(), Color32::BLACK);
            pane.painter.text(at, number, word, font, Color32::WHITE);
        }
    }
    pane.painter.add(gates);
    // The predicted position in half a second, at the model's velocity.
    let from = pane.canvas.screen(track.centre);
    let way =
        vec2(track.velocity[0], track.velocity[1]) * 0.5 * pane.model.worker.fps() * pane.canvas.pixel_size();
    if way.length() > 6.0 && way.length() < pane.canvas.rect.width() {
        pane.painter.arrow(from, way, Stroke::new(3.5, Color32::from_black_alpha(140)));
        pane.painter.arrow(from, way, Stroke::new(1.5, colour));
    }
}

fn occlusion(pane: &Pane<'_>, place: &Rect) {
    if place.is_positive() {
        let place = place.intersect(pane.canvas.rect);
        pane.painter.rect_filled(place, 0.0, Color32::from_black_alpha(60));
        draw::hatch(pane.painter, place, Stroke::new(1.0, Color32::from_white_alpha(150)), 7.0);
    }
}

/// The occlusion groups, each once.
fn groups(tracks: &[Track]) -> Vec<Vec<&Track>> {
    let mut seen: Vec<&[Identity]> = Vec::new();
    for track in tracks {
        if track.group.len() > 1 && !seen.contains(&track.group.as_slice()) {
            seen.push(&track.group);
        }
    }
    seen.into_iter().map(|ids| tracks.iter().filter(|track| ids.contains(&track.id)).collect()).collect()
}

/// The rectangle of a group, slightly larger than the union of its members.
fn around(pane: &Pane<'_>, members: &[&Track]) -> Rect {
    let places = members.iter().map(|track| pane.canvas.place(&track.bbox));
    places.fold(Rect::NOTHING, Rect::union).expand(6.0)
}

fn outline(pane: &Pane<'_>, members: &[&Track]) {
    draw::outlined_rect(pane.painter, around(pane, members), Stroke::new(1.5, Color32::WHITE));
}

/// The past positions of each object, fainter with age.
fn trails(pane: &Pane<'_>) {
    let (here, tracks) = (pane.shown.position, &pane.shown.analysis.tracks);
    let mut lines: HashMap<Identity, Vec<(u32, [f32; 2])>> =
        tracks.iter().map(|track| (track.id, Vec::new())).collect();
    for (&position, (_, objects)) in pane.set.frame.trails.range(..=here) {
        for then in objects.iter() {
            if let Some(line) = lines.get_mut(&then.id) {
                line.push((position, then.centre));
            }
        }
    }
    let mut mesh = Mesh::default();
    for track in tracks.iter() {
        let colour = theme::rgb(identity_colour(track.id));
        let faded = |position: u32| {
            let age = (here - position) as f32 / 60.0;
            colour.gamma_multiply((1.0 - age).clamp(0.15, 1.0))
        };
        let line = lines.get(&track.id).map_or(&[][..], Vec::as_slice);
        // A gap of one frame is bridged; over a longer gap the path is unknown.
        for piece in line.chunk_by(|(before, _), (after, _)| after - before <= 2) {
            let points = piece.iter().map(|&(position, at)| (pane.canvas.screen(at), faded(position)));
            draw::add_line(&mut mesh, points, 2.0);
        }
    }
    pane.painter.add(mesh);
}

/// The flags of the frame's events, placed beside the rectangles in `taken`.
fn flags(pane: &Pane<'_>, mut taken: OccupiedRects) {
    let timeline = if pane.view.compares() {
        pane.model.worker.compared_timeline()
    } else {
        pane.model.worker.timeline()
    };
    let Some(timeline) = timeline.or_else(|| pane.model.worker.timeline()) else { return };
    let here = pane.shown.position;
    let first = timeline.events.partition_point(|(position, _)| *position < here);
    for (_, event) in timeline.events[first..].iter().take_while(|(position, _)| *position == here) {
        let foot = pane.canvas.screen([event.x, event.y]);
        let colour = theme::rgb(event_colour(event.kind));
        let ids: Vec<String> = event.objects.iter().map(ToString::to_string).collect();
        let word = format!("{} {}", event.kind.label(), ids.join("+"));
        let font = FontId::proportional(theme::MONO_TEXT);
        let width = pane.painter.layout_no_wrap(word.clone(), font.clone(), colour).size().x + 30.0;
        let mut flag = Rect::from_min_size(foot - vec2(0.0, 46.0), vec2(width, 20.0));
        while !taken.is_free(flag) {
            flag = flag.translate(vec2(0.0, -23.0));
        }
        let bounds = pane.canvas.rect.shrink(2.0);
        let shift = vec2(
            (bounds.left() - flag.left()).max(0.0) - (flag.right() - bounds.right()).max(0.0),
            (bounds.top() - flag.top()).max(0.0),
        );
        flag = flag.translate(shift);
        taken.add(flag);
        let pole = pos2(foot.x.clamp(flag.left(), flag.right()), flag.bottom());
        pane.painter.line_segment([foot, pole], Stroke::new(3.5, Color32::from_black_alpha(120)));
        pane.painter.line_segment([foot, pole], Stroke::new(1.5, colour));
        pane.painter.circle(foot, 3.0, colour, Stroke::new(1.0, Color32::BLACK));
        let ink = theme::ink_on(colour);
        pane.painter.rect_filled(flag, 3.0, colour);
        let icon = icons::of_event(event.kind);
        pane.painter.text(
            flag.left_center() + vec2(5.0, 0.0),
            Align2::LEFT_CENTER,
            icon.codepoint,
            FontId::new(14.0, icon.font_family()),
            ink,
        );
        pane.painter.text(flag.left_center() + vec2(22.0, 0.0), Align2::LEFT_CENTER, word, font, ink);
    }
}
