//! Pointer and arrow keys in a view.

use eframe::egui::{CursorIcon, EventFilter, Key, Modifiers, Painter, PointerButton, Pos2, Response, Ui};

use super::areas;
use super::canvas::ViewCanvas;
use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::model::areas::AreaEdit;
use crate::app::model::camera::{Hover, ViewCamera};
use crate::app::model::selection::Subject;
use crate::app::model::view::View;
use crate::frame::Size;
use crate::tracking::{Identity, Track};

/// A click within this distance of an area's outline selects the area, in points.
const OUTLINE_REACH_PT: f32 = 4.0;

/// The camera after the pointer actions, and the pixel under the pointer. The wheel zooms around the pointer, dragging
/// pans, a click chooses the pixel or the area whose outline it hits, a double click fits the image. While an area is
/// drawn, only the middle button pans.
pub(super) fn navigate(
    ui: &Ui,
    response: &Response,
    model: &Model,
    view: View,
    size: Size,
    hovered: &mut Option<Hover>,
    commands: &mut Vec<Command>,
) -> ViewCamera {
    let mut camera = model.display.camera;
    let canvas = ViewCanvas::of_aspect(response.rect, size, model.worker.pixel_aspect(), camera);
    let drawing = model.edits.areas.draft.is_some();
    if drawing && response.hovered() {
        ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
    }
    if response.double_clicked() && !drawing {
        return ViewCamera::FIT;
    }
    let pulled = response.dragged_by(PointerButton::Primary) && !drawing;
    if pulled || response.dragged_by(PointerButton::Middle) {
        camera = canvas.panned(response.drag_delta());
    }
    if let Some(at) = response.hover_pos() {
        let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = (wheel / 180.0).exp() * pinch;
        if factor != 1.0 {
            camera = canvas.zoomed(at, factor);
        }
        if let Some(pixel) = canvas.pixel(at) {
            *hovered = Some(Hover { view, pixel, scale: canvas.scale });
            if response.clicked() && !drawing {
                let area = model.edits.areas.at(canvas.image(at), OUTLINE_REACH_PT / canvas.scale);
                commands.push(match area {
                    Some(_) => Command::Area(AreaEdit::Choose(area)),
                    None => Command::Choose(Some(pixel)),
                });
                let object = object_at(model, view, pixel, canvas.image(at));
                match (area, object) {
                    (None, Some(object)) => commands.push(Command::ChooseObject(Some(object))),
                    _ => commands.push(Command::ShowSubject(Subject::Pixel)),
                }
            }
        }
    }
    camera
}

/// The object at a click: in the tracks view, the smallest box that contains it; in the regions view, the object
/// of the region.
fn object_at(model: &Model, view: View, (x, y): (u32, u32), at: [f32; 2]) -> Option<Identity> {
    let analysis = &model.worker.shown()?.analysis;
    let meant = |track: &&Track| match view {
        View::Tracks => {
            let bbox = &track.bbox;
            (bbox.x..=bbox.right()).contains(&at[0]) && (bbox.y..=bbox.bottom()).contains(&at[1])
        }
        View::Regions => {
            analysis.labels.at(x, y).is_some_and(|label| label > 0 && track.regions.contains(&label))
        }
        _ => false,
    };
    let tracks = analysis.tracks.iter().filter(meant);
    tracks.min_by(|a, b| a.bbox.area().total_cmp(&b.bbox.area())).map(|track| track.id)
}

/// In the focused view the arrow keys move the chosen pixel.
pub(super) fn arrows(ui: &Ui, response: &Response, commands: &mut Vec<Command>) {
    if !response.has_focus() {
        return;
    }
    let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    for (key, columns, rows) in
        [(Key::ArrowLeft, -1, 0), (Key::ArrowRight, 1, 0), (Key::ArrowUp, 0, -1), (Key::ArrowDown, 0, 1)]
    {
        for _ in 0..ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key)) {
            commands.push(Command::Act(Action::MovePixel(columns, rows)));
        }
    }
}

/// The areas over a view, and the pointer actions on the draft.
pub(super) fn draw_areas(
    painter: &Painter,
    canvas: &ViewCanvas,
    response: &Response,
    model: &Model,
    shows_hint: bool,
    commands: &mut Vec<Command>,
) {
    let areas = &model.edits.areas;
    let pointer = response.hover_pos().or_else(|| response.interact_pointer_pos());
    // The start of a rectangle. egui clears the press origin before it reports the end of the drag.
    let began = response.id.with("began");
    let mut from = response.ctx.data(|data| data.get_temp::<Pos2>(began));
    if let Some(draft) = &areas.draft {
        if shows_hint {
            areas::hint(painter, canvas, draft);
        }
        if response.drag_started_by(PointerButton::Primary) {
            from = response.ctx.input(|input| input.pointer.press_origin());
            response.ctx.data_mut(|data| from.map(|from| data.insert_temp(began, from)));
        } else if let Some((from, to)) =
            from.zip(pointer).filter(|_| response.drag_stopped_by(PointerButton::Primary))
        {
            let corners = AreaEdit::Rectangle(canvas.image(from), canvas.image(to));
            commands.push(Command::Area(corners));
        } else if response.double_clicked() {
            commands.push(Command::Area(AreaEdit::Close));
        } else if response.clicked()
            && let Some(at) = pointer
        {
            let closes = areas::closes(canvas, draft, at);
            let change = if closes { AreaEdit::Close } else { AreaEdit::Corner(canvas.image(at)) };
            commands.push(Command::Area(change));
        }
    }
    if from.is_some() && !response.dragged() {
        response.ctx.data_mut(|data| data.remove::<Pos2>(began));
        from = None;
    }
    areas::paint(painter, canvas, areas, pointer, from);
}
