//! The arrangement of the views.

use eframe::egui::{
    Color32, Rect, RichText, Sense, Stroke, Ui, UiBuilder, Visuals, WidgetInfo, WidgetText, accesskit::Role,
};
use egui_tiles::{Behavior, SimplificationOptions, TabState, Tabs, TileId, Tiles, Tree, UiResponse};

use super::canvas::ViewCanvas;
use super::contents::content;
use super::frame_uploads::FrameUploads;
use super::layer::{LayerSet, ViewLayer};
use super::pane::Pane;
use super::{draw, loupe, pins, pointer, title_bar};
use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::commands::shortcut::Shortcut;
use crate::app::model::Model;
use crate::app::model::camera::Hover;
use crate::app::model::view::View;
use crate::app::theme;

/// Draws the views, or the maximised one. Returns the points per image pixel of the fitted image: in the view under
/// the pointer, or in the largest view.
pub(crate) fn show(
    ui: &mut Ui,
    tree: &mut Tree<View>,
    pictures: &mut FrameUploads,
    model: &Model,
    commands: &mut Vec<Command>,
) -> Option<f32> {
    let mut panes = Panes { model, pictures, commands, hover: None, layers: LayerSet::NONE, fitted: None };
    if let Some(view) = model.display.maximised {
        let whole = ui.available_rect_before_wrap();
        let (bar, rest) = whole.split_top_bottom_at_y(whole.top() + theme::ROW_HEIGHT);
        ui.painter().rect_filled(bar, 0.0, ui.visuals().panel_fill);
        ui.scope_builder(UiBuilder::new().max_rect(bar), |ui| {
            ui.horizontal_centered(|ui| {
                ui.add_space(2.0 * theme::SPACE);
                ui.strong(view.title());
                if let Some(key) = maximise_key(view) {
                    ui.weak(format!("Press {} to restore all views", key.text()));
                }
                title_bar::controls(ui, model, view, 1, panes.commands);
            });
        });
        ui.scope_builder(UiBuilder::new().max_rect(rest), |ui| panes.view(ui, view));
    } else {
        // Fills gaps of a fraction of a pixel between views.
        ui.painter().rect_filled(ui.available_rect_before_wrap(), 0.0, ui.visuals().panel_fill);
        tree.ui(&mut panes, ui);
    }
    let (hover, layers, fitted) = (panes.hover, panes.layers, panes.fitted);
    pictures.set_layers(layers);
    if model.selection.hovered != hover {
        commands.push(Command::Hover(hover));
    }
    fitted.map(|(_, fitted)| fitted)
}

/// The key that maximises a view and restores all views, if any.
fn maximise_key(view: View) -> Option<Shortcut> {
    Action::Maximise(view).entry().and_then(|entry| entry.shortcuts.first()).copied()
}

struct Panes<'a> {
    model: &'a Model,
    pictures: &'a FrameUploads,
    commands: &'a mut Vec<Command>,
    hover: Option<Hover>,
    /// The layers that the visible views need.
    layers: LayerSet,
    /// The area of the largest view, infinite for the view under the pointer, and its points per image pixel of the
    /// fitted image.
    fitted: Option<(f32, f32)>,
}

impl Panes<'_> {
    fn view(&mut self, ui: &mut Ui, view: View) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        response.widget_info(|| {
            WidgetInfo::labeled(
                Role::Image,
                true,
                format!("{} view", view.label(&self.model.edits.ab_settings)),
            )
        });
        let colours = theme::colours(ui.visuals());
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, 0.0, colours.canvas);
        self.layers.add(content(view).layers(self.model.display.background));
        self.layers.add(&[ViewLayer::Ignored]);
        let Some(set) = self.pictures.in_view() else { return };
        let shown = &*set.frame().shown;
        let size = shown.frame.size;
        let camera = pointer::navigate(ui, &response, self.model, view, size, &mut self.hover, self.commands);
        let canvas = ViewCanvas::of_aspect(rect, size, self.model.worker.pixel_aspect(), camera);
        let area = if response.contains_pointer() { f32::INFINITY } else { rect.area() };
        if self.fitted.is_none_or(|(most, _)| area > most) {
            self.fitted = Some((area, canvas.fitted()));
        }
        if camera != self.model.display.camera {
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
        content(view).paint(&pane);
        pins::paint(&painter, &canvas, self.model);
        if let Some(pixel) = self.model.selection.pixel {
            draw::cross(&painter, &canvas, pixel, Color32::from_rgb(255, 255, 255));
        }
        let magnify = self.model.display.loupe || ui.input(|input| input.modifiers.alt);
        if let Some((at, hover)) = response.hover_pos().zip(self.hover).filter(|_| magnify)
            && hover.view == view
            && !response.dragged()
        {
            loupe::paint(ui, &pane, at, hover.pixel);
        }
        let shows_hint = response.hovered() || (view == View::Input && self.hover.is_none());
        pointer::draw_areas(&painter, &canvas, &response, self.model, shows_hint, self.commands);
        pointer::arrows(ui, &response, self.commands);
        theme::focus(ui, &response);
    }
}

impl Behavior<View> for Panes<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile_id: TileId, view: &mut View) -> UiResponse {
        self.view(ui, *view);
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, view: &View) -> WidgetText {
        let slots = &self.model.edits.ab_settings;
        match slots.other {
            Some(_) => RichText::new(view.slot_title(slots.in_view)).into(),
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
                let key = maximise_key(*view);
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
            let seen = tabs.children.iter().filter(|&&tab| tiles.is_visible(tab)).count();
            title_bar::controls(ui, self.model, view, seen, self.commands);
        }
    }

    /// A view is moved by its title. A draggable tab bar would add an unnamed control to the Tab order.
    fn is_tile_draggable(&self, tiles: &Tiles<View>, tile_id: TileId) -> bool {
        tiles.get_pane(&tile_id).is_some()
    }

    fn tab_bar_height(&self, _style: &eframe::egui::Style) -> f32 {
        theme::ROW_HEIGHT
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
