//! The arrangement of the views, and the pointer actions in them.

use eframe::egui::containers::menu::MenuButton;
use eframe::egui::{
    Button, Color32, CursorIcon, DragValue, EventFilter, Key, Modifiers, Painter, PointerButton, Pos2, Rect,
    Response, RichText, Sense, Stroke, Ui, UiBuilder, Visuals, WidgetInfo, WidgetText, accesskit::Role, vec2,
};
use egui_material_icons::icons as m;
use egui_tiles::{Behavior, SimplificationOptions, TabState, Tabs, TileId, Tiles, Tree, UiResponse};

use super::layer::{Layer, Layers};
use super::{Background, Canvas, Pane, Pictures, View, areas, draw, loupe, map, pins};
use crate::app::commands::command::{Action, Command};
use crate::app::model::areas::AreaEdit;
use crate::app::model::overlays::Drawn;
use crate::app::model::{Camera, Hover, Model, Subject};
use crate::app::panels::top_bar;
use crate::app::theme;
use crate::mixture::Quantity;
use crate::tracking::{Identity, Track};

/// Minimum width of a title bar for buttons of all kinds of background, in points.
const CHOICES_FROM: f32 = 330.0;
/// Minimum width for the selected kind only; below, the tabs need all the space.
const CHOICE_FROM: f32 = 230.0;

/// Minimum width for the whole name of the mapped quantity; below, its symbol is shown.
const NAME_FROM: f32 = 330.0;

/// A click within this distance of an area's outline selects the area, in points.
const OUTLINE: f32 = 4.0;

/// Minimum width of a title bar per tab for the close button.
const CLOSE_FROM: f32 = 130.0;

/// Minimum width of a title bar for the switch of the mask overlay.
const OVERLAY_FROM: f32 = 120.0;

/// Draws the views, or the maximised one. Returns the points per image pixel of the fitted image: in the view under
/// the pointer, or in the largest view.
pub(crate) fn show(
    ui: &mut Ui,
    tree: &mut Tree<View>,
    pictures: &mut Pictures,
    model: &Model,
    commands: &mut Vec<Command>,
) -> Option<f32> {
    let mut panes = Panes { model, pictures, commands, hover: None, layers: Layers::NONE, fitted: None };
    if let Some(view) = model.maximised {
        let whole = ui.available_rect_before_wrap();
        let (bar, rest) = whole.split_top_bottom_at_y(whole.top() + theme::ROW);
        ui.painter().rect_filled(bar, 0.0, ui.visuals().panel_fill);
        ui.scope_builder(UiBuilder::new().max_rect(bar), |ui| {
            ui.horizontal_centered(|ui| {
                ui.add_space(2.0 * theme::SPACE);
                ui.strong(view.title());
                ui.weak("press the same key to restore all views");
                panes.buttons(ui, view, 1);
            });
        });
        ui.scope_builder(UiBuilder::new().max_rect(rest), |ui| panes.view(ui, view));
    } else {
        // Fills gaps of a fraction of a pixel between views.
        ui.painter().rect_filled(ui.available_rect_before_wrap(), 0.0, ui.visuals().panel_fill);
        tree.ui(&mut panes, ui);
    }
    let (hover, layers, fitted) = (panes.hover, panes.layers, panes.fitted);
    pictures.need(layers);
    if model.hovered != hover {
        commands.push(Command::Hover(hover));
    }
    fitted.map(|(_, fitted)| fitted)
}

struct Panes<'a> {
    model: &'a Model,
    pictures: &'a Pictures,
    commands: &'a mut Vec<Command>,
    hover: Option<Hover>,
    /// The layers that the visible views need.
    layers: Layers,
    /// The area of the largest view, infinite for the view under the pointer, and its points per image pixel of the
    /// fitted image.
    fitted: Option<(f32, f32)>,
}

impl Panes<'_> {
    fn view(&mut self, ui: &mut Ui, view: View) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        response.widget_info(|| {
            WidgetInfo::labeled(Role::Image, true, format!("{} view", view.label(&self.model.ab_settings)))
        });
        let colours = theme::colours(ui.visuals());
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, 0.0, colours.canvas);
        self.layers.add(view.layers(self.model.background));
        self.layers.add(&[Layer::Ignored]);
        let Some(set) = self.pictures.in_view() else { return };
        let shown = &*set.moment().shown;
        let camera = self.pointer(ui, &response, view, shown.frame.size);
        let canvas = Canvas::new(rect, shown.frame.size, camera);
        let area = if response.contains_pointer() { f32::INFINITY } else { rect.area() };
        if self.fitted.is_none_or(|(most, _)| area > most) {
            self.fitted = Some((area, canvas.fitted()));
        }
        if camera != self.model.camera {
            self.commands.push(Command::SetCamera(camera));
        }
        let pane = Pane {
            view,
            painter: &painter,
            canvas,
            model: self.model,
            shown,
            composer: self.pictures.composer(),
            set,
            colours,
        };
        view.paint(&pane);
        pins::paint(&painter, &canvas, self.model);
        if let Some(pixel) = self.model.chosen {
            draw::cross(&painter, &canvas, pixel, Color32::from_rgb(255, 255, 255));
        }
        let magnify = self.model.loupe || ui.input(|input| input.modifiers.alt);
        if let Some((pointer, hover)) = response.hover_pos().zip(self.hover).filter(|_| magnify)
            && hover.view == view
            && !response.dragged()
        {
            loupe::paint(ui, &pane, pointer, hover.pixel);
        }
        self.areas(&painter, &canvas, view, &response);
        self.arrows(ui, &response);
        theme::focus(ui, &response);
    }

    /// In the focused view the arrow keys move the chosen pixel.
    fn arrows(&mut self, ui: &Ui, response: &Response) {
        if !response.has_focus() {
            return;
        }
        let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
        for (key, columns, rows) in
            [(Key::ArrowLeft, -1, 0), (Key::ArrowRight, 1, 0), (Key::ArrowUp, 0, -1), (Key::ArrowDown, 0, 1)]
        {
            for _ in 0..ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key)) {
                self.commands.push(Command::Act(Action::MovePixel(columns, rows)));
            }
        }
    }

    /// The areas over a view, and the pointer actions on the draft.
    fn areas(&mut self, painter: &Painter, canvas: &Canvas, view: View, response: &Response) {
        let areas = &self.model.areas;
        let pointer = response.hover_pos().or_else(|| response.interact_pointer_pos());
        // The start of a rectangle. egui clears the press origin before it reports the end of the drag.
        let began = response.id.with("began");
        let mut from = response.ctx.data(|data| data.get_temp::<Pos2>(began));
        if let Some(draft) = &areas.draft {
            if response.hovered() || (view == View::Input && self.hover.is_none()) {
                areas::hint(painter, canvas, draft);
            }
            if response.drag_started_by(PointerButton::Primary) {
                from = response.ctx.input(|input| input.pointer.press_origin());
                response.ctx.data_mut(|data| from.map(|from| data.insert_temp(began, from)));
            } else if let Some((from, to)) =
                from.zip(pointer).filter(|_| response.drag_stopped_by(PointerButton::Primary))
            {
                let corners = AreaEdit::Rectangle(canvas.image(from), canvas.image(to));
                self.commands.push(Command::Area(corners));
            } else if response.double_clicked() {
                self.commands.push(Command::Area(AreaEdit::Close));
            } else if response.clicked()
                && let Some(at) = pointer
            {
                let closes = areas::closes(canvas, draft, at);
                let change = if closes { AreaEdit::Close } else { AreaEdit::Corner(canvas.image(at)) };
                self.commands.push(Command::Area(change));
            }
        }
        if from.is_some() && !response.dragged() {
            response.ctx.data_mut(|data| data.remove::<Pos2>(began));
            from = None;
        }
        areas::paint(painter, canvas, areas, pointer, from);
    }

    /// The pointer actions: the wheel zooms around the pointer, dragging pans, a click chooses the pixel or the area
    /// whose outline it hits, a double click fits the image. While an area is drawn, only the middle button pans.
    fn pointer(&mut self, ui: &Ui, response: &Response, view: View, size: crate::frame::Size) -> Camera {
        let mut camera = self.model.camera;
        let canvas = Canvas::new(response.rect, size, camera);
        let drawing = self.model.areas.draft.is_some();
        if drawing && response.hovered() {
            ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        }
        if response.double_clicked() && !drawing {
            return Camera::FIT;
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
                self.hover = Some(Hover { view, pixel, scale: canvas.scale });
                if response.clicked() && !drawing {
                    let area = self.model.areas.at(canvas.image(at), OUTLINE / canvas.scale);
                    self.commands.push(match area {
                        Some(_) => Command::Area(AreaEdit::Choose(area)),
                        None => Command::Choose(Some(pixel)),
                    });
                    let object = self.object_at(view, pixel, canvas.image(at));
                    match (area, object) {
                        (None, Some(object)) => self.commands.push(Command::ChooseObject(Some(object))),
                        _ => self.commands.push(Command::Explain(Subject::Pixel)),
                    }
                }
            }
        }
        camera
    }

    /// The object at a click: in the tracks view, the smallest box that contains it; in the regions view, the object
    /// of the region.
    fn object_at(&self, view: View, (x, y): (u32, u32), at: [f32; 2]) -> Option<Identity> {
        let analysis = &self.model.shown()?.analysis;
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

    /// The controls at the right end of a title bar with this number of tabs.
    fn buttons(&mut self, ui: &mut Ui, view: View, tabs: usize) {
        ui.with_layout(eframe::egui::Layout::right_to_left(eframe::egui::Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = theme::SPACE / 2.0;
            ui.spacing_mut().button_padding = vec2(theme::SPACE, 0.0);
            ui.add_space(theme::SPACE);
            if self.model.maximised.is_none() && ui.available_width() >= CLOSE_FROM * tabs as f32 {
                self.close(ui, view);
            }
            let (icon, word) = if self.model.maximised == Some(view) {
                (m::ICON_FULLSCREEN_EXIT, "Show all views")
            } else {
                (m::ICON_FULLSCREEN, "Show alone")
            };
            let button = Button::new(icon.rich_text().size(theme::ICON)).frame_when_inactive(false);
            let text = Action::Maximise(view).entry().map_or_else(
                || word.to_owned(),
                |entry| {
                    entry
                        .shortcuts
                        .first()
                        .map_or_else(|| word.to_owned(), |key| format!("{word} ({})", key.text()))
                },
            );
            let response =
                ui.add(button).accessible_name(format!("{word}: {}", view.label(&self.model.ab_settings)));
            if response.on_hover_text(text).clicked() {
                self.commands.push(Command::Act(Action::Maximise(view)));
            }
            if view == View::Input && ui.available_width() >= OVERLAY_FROM {
                self.overlay(ui);
            }
            if view == View::Tracks {
                self.drawn(ui);
            }
            if view == View::Map {
                self.quantity(ui);
            }
            if view != View::Background || ui.available_width() < CHOICE_FROM {
                return;
            }
            if ui.available_width() < CHOICES_FROM {
                let kind = self.model.background;
                let button = Button::selectable(true, RichText::new(kind.name()).size(theme::SMALL));
                let text = format!("{}. Click for the next display.", kind.meaning());
                if ui.add(button).accessible_name(kind.meaning()).on_hover_text(text).clicked() {
                    self.commands.push(Command::Act(Action::Background));
                }
            } else {
                for kind in Background::ALL.into_iter().rev() {
                    let selected = self.model.background == kind;
                    let text = RichText::new(kind.name()).size(theme::SMALL);
                    let response = ui.add(Button::selectable(selected, text)).on_hover_text(kind.meaning());
                    if response.accessible_name(kind.meaning()).clicked() {
                        self.commands.push(Command::ShowBackground(kind));
                    }
                }
            }
        });
    }

    /// The button that closes a view.
    fn close(&mut self, ui: &mut Ui, view: View) {
        let action = Action::Open(view);
        let last = action.entry().is_some_and(|entry| !top_bar::allowed(self.model, entry));
        let button = Button::new(m::ICON_CLOSE.rich_text().size(14.0)).frame_when_inactive(false);
        let response = ui
            .add_enabled(!last, button)
            .accessible_name(format!("Close: {}", view.label(&self.model.ab_settings)));
        let text = "Close this view; reopen it with the menu View, Views";
        if response.on_hover_text(text).clicked() {
            self.commands.push(Command::Act(action));
        }
    }

    /// The menu of the overlays.
    fn drawn(&mut self, ui: &mut Ui) {
        let icon = m::ICON_LAYERS.rich_text().size(theme::ICON);
        let button = Button::new(icon).frame_when_inactive(false);
        let (response, _) = MenuButton::from_button(button).ui(ui, |ui| {
            ui.set_min_width(190.0);
            for what in Drawn::ALL {
                if let Some(entry) = Action::Draw(what).entry() {
                    top_bar::item(ui, self.model, entry, self.commands);
                }
            }
        });
        response.accessible_name("Track overlays").on_hover_text("Select the track overlays");
    }

    /// The menu of the mapped quantity.
    fn quantity(&mut self, ui: &mut Ui) {
        let chosen = self.model.quantity;
        let narrow = ui.available_width() < NAME_FROM;
        let name = if narrow { map::symbol(chosen) } else { map::name(chosen) };
        let text = RichText::new(name).size(theme::SMALL);
        let button = Button::new((text, m::ICON_ARROW_DROP_DOWN.rich_text().size(theme::ICON)));
        let (response, _) = MenuButton::from_button(button.frame_when_inactive(false)).ui(ui, |ui| {
            ui.set_min_width(230.0);
            for quantity in Quantity::ALL {
                if let Some(entry) = Action::Map(quantity).entry() {
                    top_bar::item(ui, self.model, entry, self.commands);
                }
            }
        });
        let name = format!("Map of {}", map::name(chosen));
        response.accessible_name(name).on_hover_text("Mapped quantity (Shift+M for the next)");
    }

    /// The switch of the mask overlay and, while it is on, its opacity.
    fn overlay(&mut self, ui: &mut Ui) {
        let overlay = self.model.overlay;
        if overlay.on {
            let mut opacity = overlay.opacity;
            let drag = DragValue::new(&mut opacity).range(5..=100).suffix(" %").speed(0.5);
            ui.spacing_mut().interact_size = vec2(44.0, theme::ROW - 6.0);
            let response = ui.add(drag).accessible_name("Mask opacity");
            if response
                .on_hover_text("Opacity of the mask over the input; drag, or click to enter a value")
                .changed()
            {
                self.commands.push(Command::Overlay(opacity));
            }
        }
        let text = RichText::new("Mask").size(theme::SMALL);
        let response = ui.add(Button::selectable(overlay.on, text)).accessible_name("Mask overlay");
        if response.on_hover_text("Show or hide the foreground mask over the input (O)").clicked() {
            self.commands.push(Command::Act(Action::Overlay));
        }
    }
}

impl Behavior<View> for Panes<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile_id: TileId, view: &mut View) -> UiResponse {
        self.view(ui, *view);
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, view: &View) -> WidgetText {
        let slots = &self.model.ab_settings;
        match slots.other {
            Some(_) => RichText::new(view.titled(slots.in_view)).into(),
            None => RichText::new(view.title()).into(),
        }
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<View>,
        tile_id: TileId,
        response: eframe::egui::Response,
    ) -> eframe::egui::Response {
        match tiles.get_pane(&tile_id) {
            Some(view) => {
                let entry = Action::Maximise(*view).entry();
                let key = entry.and_then(|entry| entry.shortcuts.first());
                let key = key.map_or_else(String::new, |key| format!(" Key {}.", key.text()));
                response.on_hover_text(format!("{}{key}", view.meaning()))
            }
            None => response,
        }
    }

    fn top_bar_right_ui(
        &mut self,
        tiles: &Tiles<View>,
        ui: &mut Ui,
        _tile_id: TileId,
        tabs: &Tabs,
        _scroll_offset: &mut f32,
    ) {
        if let Some(&view) = tabs.active.and_then(|active| tiles.get_pane(&active)) {
            self.buttons(ui, view, tabs.children.len());
        }
    }

    /// A view is moved by its title. A draggable tab bar would add an unnamed control to the Tab order.
    fn is_tile_draggable(&self, tiles: &Tiles<View>, tile_id: TileId) -> bool {
        tiles.get_pane(&tile_id).is_some()
    }

    fn tab_bar_height(&self, _style: &eframe::egui::Style) -> f32 {
        theme::ROW
    }

    fn tab_title_spacing(&self, _visuals: &Visuals) -> f32 {
        6.0
    }

    fn gap_width(&self, _style: &eframe::egui::Style) -> f32 {
        3.0
    }

    fn min_size(&self) -> f32 {
        90.0
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn tab_bar_color(&self, visuals: &Visuals) -> Color32 {
        visuals.panel_fill
    }

    fn tab_bg_color(&self, _: &Visuals, _: &Tiles<View>, _: TileId, _: &TabState) -> Color32 {
        Color32::TRANSPARENT
    }

    fn tab_outline_stroke(&self, _: &Visuals, _: &Tiles<View>, _: TileId, _: &TabState) -> Stroke {
        Stroke::NONE
    }

    fn tab_text_color(&self, visuals: &Visuals, _: &Tiles<View>, _: TileId, state: &TabState) -> Color32 {
        let colours = theme::colours(visuals);
        if state.active { colours.text } else { colours.weak }
    }

    fn paint_on_top_of_tile(
        &self,
        _painter: &eframe::egui::Painter,
        _style: &eframe::egui::Style,
        _tile_id: TileId,
        _rect: Rect,
    ) {
    }
}
