//! The command palette: finds actions and settings by parts of their names.

use eframe::egui::{Align, Align2, Button, Context, Id, Key, Modal, Modifiers, ScrollArea, TextEdit};
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::actions::ACTIONS;
use crate::app::commands::availability::is_available;
use crate::app::commands::command::Command;
use crate::app::commands::entry::ActionEntry;
use crate::app::icons;
use crate::app::icons::Icon;
use crate::app::model::Model;
use crate::app::theme;
use crate::settings::{SETTINGS, Setting};

/// An entry of the palette.
#[derive(Clone, Copy)]
enum PaletteEntry {
    Action(&'static ActionEntry),
    Setting(&'static Setting),
}

impl PaletteEntry {
    /// Its name.
    fn text(self) -> String {
        match self {
            Self::Action(entry) => entry.text.to_owned(),
            Self::Setting(setting) if setting.symbol.is_empty() => setting.label(),
            Self::Setting(setting) => format!("{} {}", setting.label(), setting.symbol),
        }
    }

    /// How well `text` matches the entry's name, or the file key of a setting.
    fn score(self, text: &str) -> Option<u32> {
        let of_key = match self {
            Self::Action(_) => None,
            Self::Setting(setting) => score(text, &setting.name.replace('_', " ")),
        };
        score(text, &self.text()).max(of_key)
    }

    const fn icon(self) -> Icon {
        match self {
            Self::Action(entry) => entry.icon,
            Self::Setting(_) => m::ICON_TUNE,
        }
    }

    /// The note beside the name: the shortcut of an action, the stage of a setting.
    fn note(self) -> String {
        match self {
            Self::Action(entry) => {
                entry.shortcuts.first().map_or_else(String::new, |shortcut| shortcut.text())
            }
            Self::Setting(setting) => setting.stage.name().to_owned(),
        }
    }

    fn tooltip(self) -> &'static str {
        match self {
            Self::Action(entry) => entry.tooltip,
            Self::Setting(setting) => setting.meaning.trim(),
        }
    }
}

/// The typed text and the chosen entry.
#[derive(Default)]
pub(crate) struct CommandPalette {
    open: bool,
    text: String,
    chosen: usize,
}

impl CommandPalette {
    /// Opens the palette with an empty text, or closes it.
    pub(crate) fn toggle(&mut self) {
        *self = Self { open: !self.open, ..Self::default() };
    }

    /// Whether it is open.
    pub(crate) const fn is_open(&self) -> bool {
        self.open
    }

    /// Draws the palette while it is open.
    pub(crate) fn ui(&mut self, ctx: &Context, model: &Model, commands: &mut Vec<Command>) {
        if !self.open {
            return;
        }
        let area = Modal::default_area(Id::unique("command palette")).anchor(Align2::CENTER_TOP, [0.0, 80.0]);
        let response = Modal::new(Id::unique("command palette"))
            .area(area)
            .frame(theme::dialog_frame(ctx))
            .show(ctx, |ui| {
                ui.set_width(440.0);
                let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
                let (up, down, enter) = (pressed(Key::ArrowUp), pressed(Key::ArrowDown), pressed(Key::Enter));
                let edit = TextEdit::singleline(&mut self.text)
                    .hint_text("Action or setting")
                    .desired_width(f32::INFINITY);
                let response = ui.add(edit).accessible_name("Command palette");
                response.request_focus();
                if response.changed() {
                    self.chosen = 0;
                }
                let found = find(&self.text, model);
                let last = found.len().saturating_sub(1);
                self.chosen = (self.chosen + usize::from(down)).saturating_sub(usize::from(up)).min(last);
                let mut done = enter.then(|| found.get(self.chosen).copied()).flatten();
                ui.add_space(theme::SPACE);
                if found.is_empty() {
                    ui.weak("No matching action or setting.");
                }
                ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
                    ui.with_layout(eframe::egui::Layout::top_down_justified(Align::Min), |ui| {
                        for (index, &each) in found.iter().enumerate() {
                            let chosen = index == self.chosen;
                            let text = each.text();
                            let button = Button::selectable(chosen, (icons::text(each.icon()), &text))
                                .shortcut_text(each.note());
                            let response = ui.add(button).accessible_name(text);
                            if chosen && (up || down) {
                                response.scroll_to_me(None);
                            }
                            if response.on_hover_text(each.tooltip()).clicked() {
                                done = Some(each);
                            }
                        }
                    });
                });
                done
            });
        if let Some(found) = response.inner {
            self.open = false;
            match found {
                // The palette is already closed: executing its own action would open it again.
                PaletteEntry::Action(entry) if entry.action == Action::Palette => {}
                PaletteEntry::Action(entry) => commands.push(Command::Act(entry.action)),
                PaletteEntry::Setting(setting) => commands.push(Command::RevealSetting(setting.name)),
            }
        } else if response.should_close() {
            self.open = false;
        }
    }
}

/// The available actions and the settings whose name contains the letters, best match first.
fn find(text: &str, model: &Model) -> Vec<PaletteEntry> {
    let actions = ACTIONS.iter().filter(|entry| is_available(model, entry)).map(PaletteEntry::Action);
    let mut found: Vec<_> = actions
        .chain(SETTINGS.iter().map(PaletteEntry::Setting))
        .filter_map(|each| Some((each.score(text)?, each)))
        .collect();
    found.sort_by_key(|(score, _)| std::cmp::Reverse(*score));
    found.into_iter().map(|(_, each)| each).collect()
}

/// How well `name` contains the letters of `text` in order; `None` where it does not. Letters that start a word or
/// follow the previous match score higher.
fn score(text: &str, name: &str) -> Option<u32> {
    let name: Vec<char> = name.to_lowercase().chars().collect();
    let (mut at, mut score, mut last) = (0, 0, None);
    for letter in text.to_lowercase().chars().filter(|letter| !letter.is_whitespace()) {
        let place = at + name[at..].iter().position(|&other| other == letter)?;
        let starts_word = place == 0 || name[place - 1] == ' ';
        score += 1
            + if starts_word { 4 } else { 0 }
            + if last.is_some_and(|last| last + 1 == place) { 3 } else { 0 };
        last = Some(place);
        at = place + 1;
    }
    Some(score)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_in_order_match_and_word_starts_score_higher() {
        assert!(score("nxev", "Next event").is_some());
        assert!(score("vn", "Next event").is_some());
        assert!(score("xn n", "Next event").is_none());
        assert!(score("fit", "Fit image") > score("fit", "First frame of it"));
        let model = Model::new(crate::settings::Settings::default());
        let always = |found: &PaletteEntry| matches!(found, PaletteEntry::Action(entry) if entry.always);
        assert!(
            find("", &model).iter().all(|found| always(found) || matches!(found, PaletteEntry::Setting(_)))
        );
        assert!(
            matches!(find("openv", &model)[0], PaletteEntry::Action(entry) if entry.action == Action::OpenVideo)
        );
        for text in ["match sig", "λ"] {
            assert!(
                matches!(find(text, &model)[0], PaletteEntry::Setting(setting) if setting.name == "match_sigmas"),
                "{text}"
            );
        }
    }
}
