//! The settings panel: all settings from the table, grouped by stage.

use eframe::egui::containers::menu::MenuButton;
use eframe::egui::{
    Align, Button, CollapsingHeader, ComboBox, InputState, Layout, RichText, ScrollArea, Stroke, StrokeKind,
    Ui, Vec2, vec2,
};
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::icons;
use crate::app::menu_item::menu_item;
use crate::app::model::Model;
use crate::app::model::ab_settings::{self, AbSlot};
use crate::app::model::layout::ViewLayout;
use crate::app::panels::area_panel;
use crate::app::panels::score_panel;
use crate::app::panels::setting_control;
use crate::app::theme;
use crate::settings::{Preset, SETTINGS, Setting, Settings, Stage};

/// Draws the panel.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let mut settings = model.edits.settings.clone();
    head(ui, model, &mut settings, commands);
    score_panel::ui(ui, model);
    ui.add_space(theme::SPACE);
    let fps = model.worker.fps();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for stage in Stage::ALL {
            // Ignored areas are removed before post-processing.
            if stage == Stage::Cleaning && model.worker.size().is_some() {
                area_panel::ui(ui, model, commands);
            }
            let defaults = Settings::default();
            let of_stage = || SETTINGS.iter().filter(move |setting| setting.stage == stage);
            let changed = of_stage().filter(|s| s.get(&settings) != s.get(&defaults)).count();
            let title = if changed == 0 {
                RichText::new(stage.name()).strong()
            } else {
                RichText::new(format!("{}  ({changed} changed)", stage.name())).strong()
            };
            let looked_at = model.panels.revealed_setting.and_then(Setting::named);
            CollapsingHeader::new(title)
                .id_salt(stage.name())
                .default_open(stage == Stage::Mixture)
                .open(looked_at.filter(|setting| setting.stage == stage).map(|_| true))
                .show_unindented(ui, |ui| {
                    for setting in of_stage() {
                        let looked_at = model.panels.revealed_setting == Some(setting.name);
                        let response = setting_control::ui(ui, setting, &mut settings, &defaults, fps);
                        if looked_at {
                            response.scroll_to_me(Some(Align::Center));
                            let accent = theme::colours(ui.visuals()).accent;
                            let place = response.rect.expand2(vec2(2.0, 1.0));
                            ui.painter().rect_stroke(
                                place,
                                4.0,
                                Stroke::new(1.5, accent),
                                StrokeKind::Inside,
                            );
                            let elsewhere = |input: &InputState| {
                                input.pointer.any_pressed() || input.smooth_scroll_delta() != Vec2::ZERO
                            };
                            if ui.input(elsewhere) {
                                commands.push(Command::SettingRevealed);
                            }
                        }
                    }
                    ui.add_space(2.0 * theme::SPACE);
                });
        }
    });
    if settings != model.edits.settings {
        commands.push(Command::Set(Box::new(settings)));
    }
}

fn head(ui: &mut Ui, model: &Model, settings: &mut Settings, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        ui.heading("Settings");
        slots(ui, model, commands);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = theme::SPACE;
            let (undo, redo) = (model.edits.history.can_undo(), model.edits.history.can_redo());
            for (enabled, icon, action, name) in
                [(redo, m::ICON_REDO, Action::Redo, "Redo"), (undo, m::ICON_UNDO, Action::Undo, "Undo")]
            {
                let button = Button::new(icons::text(icon)).frame_when_inactive(false);
                let response = ui.add_enabled(enabled, button).accessible_name(name);
                if response.on_hover_text(name).clicked() {
                    commands.push(Command::Act(action));
                }
            }
        });
    });
    let present = Preset::ALL.into_iter().find(|&preset| Settings::preset(preset) == *settings);
    ui.horizontal(|ui| {
        let label = ui.label("Preset");
        let text = present.map_or("custom", Preset::word);
        let combo = ComboBox::from_id_salt("preset")
            .selected_text(text)
            .width((ui.available_width() - theme::SPACE).max(0.0));
        let response = combo.show_ui(ui, |ui| {
            for preset in Preset::ALL {
                let response = ui.selectable_label(present == Some(preset), preset.word());
                if response.on_hover_text(preset.meaning()).clicked() {
                    *settings = Settings::preset(preset);
                }
            }
        });
        response.response.labelled_by(label.id).on_hover_text("Predefined set of values");
    });
}

/// The selector of the slot in view, once there are two.
fn slots(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some(other) = &model.edits.ab_settings.other else { return };
    ui.spacing_mut().item_spacing.x = theme::SPACE;
    for slot in AbSlot::ALL {
        let here = slot == model.edits.ab_settings.in_view;
        let response = ui
            .selectable_label(here, slot.name())
            .accessible_name(format!("Settings {}", slot.name()))
            .on_hover_ui(|ui| {
                ui.label(format!(
                    "{}; keys A and B switch",
                    ab_settings::difference(&model.edits.settings, other)
                ));
            });
        if response.clicked() && !here {
            commands.push(Command::Act(Action::AbSlot(slot)));
        }
        let mark = eframe::egui::Rect::from_min_size(
            response.rect.left_bottom() - vec2(0.0, 2.0),
            vec2(response.rect.width(), 2.0),
        );
        ui.painter().rect_filled(mark, 0.0, theme::rgb(slot.colour()));
    }
    let button = Button::new(icons::text(m::ICON_MORE_HORIZ)).frame_when_inactive(false);
    let (response, _) = MenuButton::from_button(button).ui(ui, |ui| {
        for action in [Action::FlipSettings, Action::CopySettings, Action::SwapSettings, Action::KeepSettings]
        {
            if let Some(entry) = action.entry() {
                menu_item(ui, model, entry, commands);
            }
        }
        ui.separator();
        if let Some(entry) = Action::Arrange(ViewLayout::Compare).entry() {
            menu_item(ui, model, entry, commands);
        }
    });
    response.accessible_name("A and B").on_hover_text("Actions on settings A and B");
}
