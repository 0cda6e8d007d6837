//! The scatter plot of all three channels: a cube turned by dragging, keys or buttons.

use std::f32::consts::PI;

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Align2, Button, Color32, EventFilter, FontId, Key, Painter, Pos2, Rect, Response, Sense, Shape, Stroke,
    StrokeKind, Ui, Vec2, WidgetInfo,
};
use egui_material_icons::icons as m;

use super::chosen_pixel::ChosenPixel;
use super::style::{self, small};
use crate::app::theme;
use crate::explain::pixel::component_states::component_states;
use crate::explain::pixel::scatter_points::{PointKind, ScatterPoint, ScatterSpace, coordinates_of};
use crate::export::figure::cube::{EXTENT, Look, Role as Line, Scene, Span, Turn, scene};
use crate::export::figure::scatter::density;

/// The angle that one key press or button turns, in radians.
const TURN_STEP_RADIANS: f64 = std::f64::consts::PI / 18.0;
/// Margin for labels around the cube.
const LABEL_MARGIN_PT: f32 = 24.0;
/// Maximum side of the plot.
const MAX_SIDE_PT: f32 = 440.0;

/// The orientation of the cube.
pub(super) struct CubeView {
    pub(super) look: Look,
}

impl Default for CubeView {
    fn default() -> Self {
        Self { look: Look { turn: Turn::default(), fit: true } }
    }
}

impl CubeView {
    pub(super) fn ui(&mut self, ui: &mut Ui, chosen: &ChosenPixel<'_>, places: &[ScatterPoint]) {
        self.controls(ui);
        let side = ui.available_width().min(MAX_SIDE_PT);
        let (area, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::click_and_drag());
        self.turn(ui, &response);

        let (component_states, _) = component_states(chosen.history, chosen.slots, chosen.index, false);
        let lambda = chosen.history.parameters.lambda;
        let span = if self.look.fit { Span::around(places, &component_states, lambda) } else { Span::WHOLE };
        let here = coordinates_of(chosen.history, chosen.index, ScatterSpace::Cube);
        let Turn { yaw, pitch } = self.look.turn;
        response.widget_info(|| {
            let (yaw, pitch) = (yaw.to_degrees(), pitch.to_degrees());
            let count = places.len();
            WidgetInfo::labeled(
                Role::Image,
                true,
                format!(
                    "Scatter plot of R, G and B, {count} positions, rotated by {yaw:.0}°, elevation \
                     {pitch:.0}°"
                ),
            )
        });
        if ui.is_rect_visible(area) {
            let scene = scene(places, &component_states, here, lambda, span, self.look.turn);
            CubePainter { ui, painter: ui.painter_at(area), area }.draw(&scene);
        }
        if response.has_focus() {
            let stroke = Stroke::new(1.0, theme::colours(ui.visuals()).accent);
            ui.painter().rect_stroke(area.shrink(0.5), 3.0, stroke, StrokeKind::Inside);
        }
        response
            .on_hover_text("Drag to rotate, or click and use the arrow keys. Double click resets the view.");
    }

    fn controls(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.label(style::aside(ui, "rotate"));
            for (icon, name, yaw, pitch) in [
                (m::ICON_CHEVRON_LEFT, "Rotate left", -TURN_STEP_RADIANS, 0.0),
                (m::ICON_CHEVRON_RIGHT, "Rotate right", TURN_STEP_RADIANS, 0.0),
                (m::ICON_EXPAND_LESS, "Increase elevation", 0.0, TURN_STEP_RADIANS),
                (m::ICON_EXPAND_MORE, "Decrease elevation", 0.0, -TURN_STEP_RADIANS),
            ] {
                let button = Button::new(icon.rich_text().size(14.0)).small();
                if ui.add(button).accessible_name(name).on_hover_text(name).clicked() {
                    self.look.turn = self.look.turn.by(yaw, pitch);
                }
            }
            if ui.small_button(small("Reset")).on_hover_text("Reset the view").clicked() {
                self.look.turn = Turn::default();
            }
            ui.add_space(6.0);
            ui.checkbox(&mut self.look.fit, small("fit values"))
                .on_hover_text("Fit the axes to the values and spheres, instead of 0 to 255");
        });
    }

    /// Turns the cube by the pointer, or by the arrow keys while the plot has the focus.
    fn turn(&mut self, ui: &Ui, response: &Response) {
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        if response.double_clicked() {
            self.look.turn = Turn::default();
        }
        if response.dragged() {
            // A drag across the whole plot turns by half a turn; the front side follows the pointer.
            let by = response.drag_delta() * PI / response.rect.width().max(1.0);
            self.look.turn = self.look.turn.by(f64::from(by.x), f64::from(by.y));
        }
        if response.has_focus() {
            let arrows =
                EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
            ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
            let presses = |key| ui.input(|input| input.num_presses(key)) as f64 * TURN_STEP_RADIANS;
            let yaw = presses(Key::ArrowRight) - presses(Key::ArrowLeft);
            self.look.turn = self.look.turn.by(yaw, presses(Key::ArrowUp) - presses(Key::ArrowDown));
        }
    }
}

struct CubePainter<'a> {
    ui: &'a Ui,
    painter: Painter,
    area: Rect,
}

impl CubePainter<'_> {
    fn at(&self, [x, y]: [f64; 2]) -> Pos2 {
        let scale = (self.area.width() - 2.0 * LABEL_MARGIN_PT) / (2.0 * EXTENT as f32);
        self.area.center() + Vec2::new(x as f32, -y as f32) * scale
    }

    fn line(&self, points: &[[f64; 2]], stroke: Stroke) {
        self.painter.line(points.iter().map(|point| self.at(*point)).collect(), stroke);
    }

    fn draw(&self, scene: &Scene) {
        let visuals = self.ui.visuals();
        let (faint, muted) = (style::faint(visuals), style::muted(visuals));
        for (role, points) in &scene.below {
            let edge = *role == Line::Edge;
            self.line(
                points,
                if edge {
                    Stroke::new(1.0, muted.gamma_multiply(0.7))
                } else {
                    Stroke { width: 0.6, ..faint }
                },
            );
        }
        for spot in &scene.spots {
            let nearness = spot.nearness as f32;
            let hollow = matches!(spot.place.kind, PointKind::Component { foreground: true, .. });
            let strength = [0.55, 0.75, 0.95][density(spot.place.count)];
            let (place, radius) = (self.at(spot.at), 1.3 + 1.0 * nearness);
            let colour = style::point_colour(visuals, spot.place.kind);
            if hollow {
                self.painter.circle_stroke(place, radius + 0.7, Stroke::new(1.0, colour));
            } else {
                // Distant points are fainter.
                let haze = 0.6 + 0.4 * nearness;
                self.painter.circle_filled(place, radius, colour.gamma_multiply(strength * haze));
            }
        }
        for (role, points) in &scene.above {
            match *role {
                Line::Reach { slot, background } => {
                    let stroke = Stroke::new(1.5, style::component(visuals, slot));
                    if background {
                        self.line(points, stroke);
                    } else {
                        let points: Vec<_> = points.iter().map(|point| self.at(*point)).collect();
                        self.painter.extend(Shape::dashed_line(&points, stroke, 4.0, 3.0));
                    }
                }
                Line::Girdle { slot } => {
                    self.line(points, Stroke::new(0.8, style::component(visuals, slot).gamma_multiply(0.5)));
                }
                Line::Grid | Line::Edge => {}
            }
        }
        if let Some(here) = scene.here {
            let (at, reach) = (self.at(here), 6.0);
            let stroke = Stroke::new(1.6, style::ink(visuals));
            self.painter.line_segment([at - Vec2::X * reach, at + Vec2::X * reach], stroke);
            self.painter.line_segment([at - Vec2::Y * reach, at + Vec2::Y * reach], stroke);
        }
        for label in &scene.labels {
            let (font, colour): (FontId, Color32) = match label.slot {
                Some(slot) => (style::font(), style::component(visuals, slot)),
                None if label.name => (FontId::proportional(theme::BODY_TEXT), visuals.text_color()),
                None => (style::tick_font(), muted),
            };
            let anchor = if label.slot.is_some() { Align2::CENTER_BOTTOM } else { Align2::CENTER_CENTER };
            let off = match label.slot {
                Some(_) => 1.0,
                None if label.name => 28.0,
                None => 12.0,
            };
            let out = Vec2::new(label.out[0] as f32, -label.out[1] as f32) * off;
            self.painter.text(self.at(label.at) + out, anchor, &label.text, font, colour);
        }
    }
}
