//! What can be done: one table of actions, from which menu, keys, help and palette are made,
//! and the commands that panels hand to [`super::apply`].

use eframe::egui::{Key, Modifiers};
use egui_material_icons::icons as m;

use super::areas::Change;
use super::icons::Icon;
use super::slots::Slot;
use super::state::{Camera, Hover};
use super::views::{Background, View};
use crate::regions::roi::Purpose;
use crate::replay::Start;
use crate::settings::Settings;

/// Something that a person can ask for by name or key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Action {
    /// Choose a video file.
    OpenVideo,
    /// Choose a folder of images.
    OpenFolder,
    /// Open the bundled scene.
    OpenSample,
    /// Write the annotated frame as a picture.
    ExportFrame,
    /// Write the settings as a file.
    SaveSettings,
    /// Read the settings from a file.
    LoadSettings,
    /// End the program.
    Quit,
    /// Take back the last change of settings.
    Undo,
    /// Make it again.
    Redo,
    /// All settings to their defaults.
    DefaultSettings,
    /// Analyse under the settings of this slot.
    Slot(Slot),
    /// Draw an area over the views.
    DrawArea(Purpose),
    /// The area that is being drawn is whole.
    CloseArea,
    /// Take back its last corner.
    UndoCorner,
    /// Give up drawing, or choose no area any more.
    CancelArea,
    /// Take the chosen area away.
    DeleteArea,
    /// Take all areas away.
    ClearAreas,
    /// Take what is analysed from a picture.
    LoadMask,
    /// Write what is analysed as a picture.
    SaveMask,
    /// Start or stop playing.
    Play,
    /// Go so many frames on, or back.
    Step(i32),
    /// Go to the next event.
    NextEvent,
    /// Go to the event before.
    PreviousEvent,
    /// Go to the first frame.
    First,
    /// Go to the last frame that is known.
    Last,
    /// Play slower.
    Slower,
    /// Play faster.
    Faster,
    /// One view alone, or all again.
    Maximise(View),
    /// The whole image in each view.
    Fit,
    /// Nearer.
    ZoomIn,
    /// Farther.
    ZoomOut,
    /// What the background view shows.
    Background,
    /// The mask over the input, or none.
    Overlay,
    /// Another opacity of the mask over the input.
    OverlayOpacity,
    /// No pixel chosen any more.
    ClearPixel,
    /// The panel with the settings.
    SettingsPanel,
    /// The panel with the inspector and the events.
    InspectorPanel,
    /// Views back in their first places.
    ResetLayout,
    /// Dark or light.
    Theme,
    /// The list of keys.
    Help,
    /// Find an action by its name.
    Palette,
}

/// Under which menu an action stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Menu {
    /// Opening and writing.
    File,
    /// What is seen.
    View,
    /// Settings, playing and going from frame to frame.
    Analysis,
    /// What there is to know.
    Help,
}

impl Menu {
    /// All menus in order.
    pub(crate) const ALL: [Self; 4] = [Self::File, Self::View, Self::Analysis, Self::Help];

    /// The menu's name.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::View => "View",
            Self::Analysis => "Analysis",
            Self::Help => "Help",
        }
    }
}

/// A key with what is held down with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shortcut {
    /// Ctrl (on a Mac, command).
    pub(crate) ctrl: bool,
    /// Shift, where the key itself does not need it.
    pub(crate) shift: bool,
    /// The key.
    pub(crate) key: Key,
}

impl Shortcut {
    /// Whether a key press means this shortcut.
    pub(crate) fn matches(self, key: Key, modifiers: Modifiers) -> bool {
        let needs_shift = matches!(self.key, Key::Questionmark | Key::Plus);
        key == self.key
            && modifiers.command == self.ctrl
            && !modifiers.alt
            && (needs_shift || modifiers.shift == self.shift)
    }

    /// As it is written in menus: `Ctrl+Shift+Z`.
    pub(crate) fn text(self) -> String {
        let key = match self.key {
            Key::ArrowLeft => "Left",
            Key::ArrowRight => "Right",
            Key::OpenBracket => "[",
            Key::CloseBracket => "]",
            Key::Comma => ",",
            Key::Period => ".",
            Key::Questionmark => "?",
            Key::Plus => "+",
            Key::Minus => "-",
            Key::Equals => "=",
            Key::Escape => "Esc",
            key => key.name(),
        };
        let ctrl = if self.ctrl { "Ctrl+" } else { "" };
        let shift = if self.shift { "Shift+" } else { "" };
        format!("{ctrl}{shift}{key}")
    }
}

const fn key(key: Key) -> Shortcut {
    Shortcut { ctrl: false, shift: false, key }
}

const fn ctrl(key: Key) -> Shortcut {
    Shortcut { ctrl: true, shift: false, key }
}

const fn shift(key: Key) -> Shortcut {
    Shortcut { ctrl: false, shift: true, key }
}

const fn ctrl_shift(key: Key) -> Shortcut {
    Shortcut { ctrl: true, shift: true, key }
}

/// All that is said of an action anywhere.
pub(crate) struct Entry {
    /// What it does.
    pub(crate) action: Action,
    /// Its name in menu, palette and help.
    pub(crate) text: &'static str,
    /// What it does, in a sentence.
    pub(crate) tooltip: &'static str,
    /// The keys that call it.
    pub(crate) shortcuts: &'static [Shortcut],
    /// Its picture.
    pub(crate) icon: Icon,
    /// The menu it stands in.
    pub(crate) menu: Menu,
    /// Whether a line goes before it in its menu.
    pub(crate) line_before: bool,
    /// Whether it makes sense with nothing opened.
    pub(crate) always: bool,
    /// Whether holding the key down repeats it.
    pub(crate) repeats: bool,
}

const fn entry(
    menu: Menu,
    action: Action,
    icon: Icon,
    text: &'static str,
    shortcuts: &'static [Shortcut],
    tooltip: &'static str,
) -> Entry {
    Entry { action, text, tooltip, shortcuts, icon, menu, line_before: false, always: false, repeats: false }
}

impl Entry {
    const fn after_line(mut self) -> Self {
        self.line_before = true;
        self
    }

    const fn always(mut self) -> Self {
        self.always = true;
        self
    }

    const fn repeats(mut self) -> Self {
        self.repeats = true;
        self
    }

    /// The sentence with the keys behind it: `One frame on (Right or .)`.
    pub(crate) fn tooltip_with_keys(&self) -> String {
        let keys: Vec<String> = self.shortcuts.iter().map(|shortcut| shortcut.text()).collect();
        if keys.is_empty() {
            return self.tooltip.to_owned();
        }
        format!("{} ({})", self.tooltip, keys.join(" or "))
    }
}

/// Every action, in the order of the menus.
pub(crate) static ACTIONS: &[Entry] = &[
    entry(
        Menu::File,
        Action::OpenVideo,
        m::ICON_VIDEO_FILE,
        "Open video…",
        &[ctrl(Key::O)],
        "Choose a video file: mp4, avi, mkv, mov, webm",
    )
    .always(),
    entry(
        Menu::File,
        Action::OpenFolder,
        m::ICON_FOLDER_OPEN,
        "Open folder of images…",
        &[ctrl_shift(Key::O)],
        "Choose a folder whose images are the frames, in natural order",
    )
    .always(),
    entry(
        Menu::File,
        Action::OpenSample,
        m::ICON_MOVIE,
        "Open sample",
        &[],
        "Two people cross: a bundled scene, opened at its occlusion",
    )
    .always(),
    entry(
        Menu::File,
        Action::ExportFrame,
        m::ICON_PHOTO_CAMERA,
        "Export frame…",
        &[key(Key::E)],
        "Write this frame with boxes, identities and events drawn on, as a PNG",
    )
    .after_line(),
    entry(
        Menu::File,
        Action::SaveSettings,
        m::ICON_SAVE,
        "Save settings…",
        &[ctrl(Key::S)],
        "Write the settings in view as TOML, which --settings reads",
    )
    .after_line()
    .always(),
    entry(
        Menu::File,
        Action::LoadSettings,
        m::ICON_UPLOAD_FILE,
        "Load settings…",
        &[],
        "Take the settings of a TOML file; what it does not name has its default",
    )
    .always(),
    entry(
        Menu::File,
        Action::LoadMask,
        m::ICON_UPLOAD_FILE,
        "Load area mask…",
        &[],
        "Analyse where a picture as large as the frames is bright, as --roi does",
    )
    .after_line(),
    entry(
        Menu::File,
        Action::SaveMask,
        m::ICON_SAVE,
        "Save area mask…",
        &[],
        "Write what is analysed as a PNG, which --roi reads",
    ),
    entry(Menu::File, Action::Quit, m::ICON_CLOSE, "Quit", &[ctrl(Key::Q)], "End the program")
        .after_line()
        .always(),
    entry(
        Menu::View,
        Action::Maximise(View::Input),
        m::ICON_FULLSCREEN,
        "Input alone",
        &[key(Key::Num1)],
        "Show the input alone, or all views again",
    ),
    entry(
        Menu::View,
        Action::Maximise(View::Background),
        m::ICON_FULLSCREEN,
        "Background alone",
        &[key(Key::Num2)],
        "Show the background model alone, or all views again",
    ),
    entry(
        Menu::View,
        Action::Maximise(View::Foreground),
        m::ICON_FULLSCREEN,
        "Foreground alone",
        &[key(Key::Num3)],
        "Show the foreground mask alone, or all views again",
    ),
    entry(
        Menu::View,
        Action::Maximise(View::Regions),
        m::ICON_FULLSCREEN,
        "Regions alone",
        &[key(Key::Num4)],
        "Show the regions alone, or all views again",
    ),
    entry(
        Menu::View,
        Action::Maximise(View::Tracks),
        m::ICON_FULLSCREEN,
        "Tracks and occlusions alone",
        &[key(Key::Num5)],
        "Show tracks and occlusions alone, or all views again",
    ),
    entry(
        Menu::View,
        Action::Maximise(View::Difference),
        m::ICON_FULLSCREEN,
        "Difference alone",
        &[key(Key::Num6)],
        "Show how far the input is from the background alone, or all views again",
    ),
    entry(
        Menu::View,
        Action::Fit,
        m::ICON_FIT_SCREEN,
        "Fit image",
        &[key(Key::F)],
        "Show the whole image in each view",
    )
    .after_line(),
    entry(
        Menu::View,
        Action::ZoomIn,
        m::ICON_ZOOM_IN,
        "Zoom in",
        &[key(Key::Plus), key(Key::Equals)],
        "Nearer, at the chosen pixel or the middle",
    )
    .repeats(),
    entry(Menu::View, Action::ZoomOut, m::ICON_ZOOM_OUT, "Zoom out", &[key(Key::Minus)], "Farther").repeats(),
    entry(
        Menu::View,
        Action::Background,
        m::ICON_LAYERS,
        "Next kind of background",
        &[key(Key::M)],
        "The mean of component 1, the mean of all background components, or how many there are",
    ),
    entry(
        Menu::View,
        Action::Overlay,
        m::ICON_MASKED_TRANSITIONS,
        "Mask over the input",
        &[key(Key::O)],
        "Lay the foreground over the input view, or take it off",
    ),
    entry(
        Menu::View,
        Action::OverlayOpacity,
        m::ICON_OPACITY,
        "Next opacity of the mask",
        &[shift(Key::O)],
        "Cover a quarter of the input, half, three quarters, or all",
    ),
    entry(
        Menu::View,
        Action::ClearPixel,
        m::ICON_LOCATION_OFF,
        "Clear chosen pixel",
        &[],
        "Take the cross off the views",
    ),
    entry(
        Menu::View,
        Action::SettingsPanel,
        m::ICON_TUNE,
        "Settings panel",
        &[],
        "Show or hide the settings on the left",
    )
    .after_line()
    .always(),
    entry(
        Menu::View,
        Action::InspectorPanel,
        m::ICON_FRAME_INSPECT,
        "Inspector and events",
        &[],
        "Show or hide the panel on the right",
    )
    .always(),
    entry(
        Menu::View,
        Action::ResetLayout,
        m::ICON_GRID_VIEW,
        "Reset layout",
        &[],
        "Views back in their first places",
    )
    .always(),
    entry(
        Menu::View,
        Action::Theme,
        m::ICON_CONTRAST,
        "Dark or light",
        &[],
        "Change between dark and light colours",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::Play,
        m::ICON_PLAY_ARROW,
        "Play or pause",
        &[key(Key::Space)],
        "Play at the video's frame rate times the speed, or stop",
    ),
    entry(
        Menu::Analysis,
        Action::Step(1),
        m::ICON_CHEVRON_RIGHT,
        "Next frame",
        &[key(Key::ArrowRight), key(Key::Period)],
        "One frame on",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(-1),
        m::ICON_CHEVRON_LEFT,
        "Previous frame",
        &[key(Key::ArrowLeft), key(Key::Comma)],
        "One frame back",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(10),
        m::ICON_KEYBOARD_DOUBLE_ARROW_RIGHT,
        "Ten frames on",
        &[shift(Key::ArrowRight)],
        "Ten frames on",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(-10),
        m::ICON_KEYBOARD_DOUBLE_ARROW_LEFT,
        "Ten frames back",
        &[shift(Key::ArrowLeft)],
        "Ten frames back",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::NextEvent,
        m::ICON_FLAG,
        "Next event",
        &[ctrl(Key::ArrowRight), key(Key::N)],
        "To the next event of the kinds that the list shows",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::PreviousEvent,
        m::ICON_FLAG,
        "Previous event",
        &[ctrl(Key::ArrowLeft), key(Key::P)],
        "To the event before",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::First,
        m::ICON_FIRST_PAGE,
        "First frame",
        &[key(Key::Home)],
        "To the first frame",
    ),
    entry(
        Menu::Analysis,
        Action::Last,
        m::ICON_LAST_PAGE,
        "Last frame",
        &[key(Key::End)],
        "To the last frame that is known",
    ),
    entry(
        Menu::Analysis,
        Action::Slower,
        m::ICON_FAST_REWIND,
        "Slower",
        &[key(Key::OpenBracket)],
        "Play at half the speed",
    ),
    entry(
        Menu::Analysis,
        Action::Faster,
        m::ICON_FAST_FORWARD,
        "Faster",
        &[key(Key::CloseBracket)],
        "Play at twice the speed",
    ),
    entry(
        Menu::Analysis,
        Action::Undo,
        m::ICON_UNDO,
        "Undo change of settings",
        &[ctrl(Key::Z)],
        "Take the last change of settings back",
    )
    .after_line()
    .always()
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Redo,
        m::ICON_REDO,
        "Redo change of settings",
        &[ctrl_shift(Key::Z), ctrl(Key::Y)],
        "Make it again",
    )
    .always()
    .repeats(),
    entry(
        Menu::Analysis,
        Action::DefaultSettings,
        m::ICON_RESTART_ALT,
        "All settings to defaults",
        &[],
        "Take the preset `default`",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::Slot(Slot::A),
        m::ICON_COMPARE,
        "Settings A",
        &[key(Key::A)],
        "Analyse under the first of two sets of settings",
    )
    .after_line()
    .always(),
    entry(
        Menu::Analysis,
        Action::Slot(Slot::B),
        m::ICON_COMPARE,
        "Settings B",
        &[key(Key::B)],
        "Analyse under the second; it begins as a copy of A",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::DrawArea(Purpose::Ignore),
        m::ICON_DRAW,
        "Draw area to ignore",
        &[key(Key::I)],
        "Foreground inside is taken away: click corners, or drag a rectangle, over any view",
    )
    .after_line(),
    entry(
        Menu::Analysis,
        Action::DrawArea(Purpose::Analyse),
        m::ICON_SELECT_ALL,
        "Draw area to analyse",
        &[shift(Key::I)],
        "Foreground outside of all such areas is taken away",
    ),
    entry(
        Menu::Analysis,
        Action::CloseArea,
        m::ICON_CHECK,
        "Close the area that is drawn",
        &[key(Key::Enter)],
        "Join its last corner to the first",
    ),
    entry(
        Menu::Analysis,
        Action::UndoCorner,
        m::ICON_BACKSPACE,
        "Take back the last corner",
        &[key(Key::Backspace)],
        "One corner less of the area that is drawn",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::CancelArea,
        m::ICON_CANCEL,
        "Give up the area that is drawn",
        &[key(Key::Escape)],
        "Draw no area, and choose none",
    ),
    entry(
        Menu::Analysis,
        Action::DeleteArea,
        m::ICON_DELETE,
        "Delete chosen area",
        &[key(Key::Delete)],
        "An area is chosen by a click on its outline, or in the list",
    ),
    entry(
        Menu::Analysis,
        Action::ClearAreas,
        m::ICON_DELETE_SWEEP,
        "Clear all areas",
        &[],
        "Analyse the whole image again",
    ),
    entry(
        Menu::Help,
        Action::Palette,
        m::ICON_SEARCH,
        "Find an action…",
        &[ctrl(Key::K)],
        "Find an action by its name",
    )
    .always(),
    entry(
        Menu::Help,
        Action::Help,
        m::ICON_KEYBOARD,
        "Keys and pointer",
        &[key(Key::Questionmark), key(Key::F1)],
        "All keys, and what the pointer does",
    )
    .always(),
];

impl Action {
    /// All that is said of it.
    pub(crate) fn entry(self) -> Option<&'static Entry> {
        ACTIONS.iter().find(|entry| entry.action == self)
    }
}

/// Something that a panel asks for.
#[derive(Clone, Debug)]
pub(crate) enum Command {
    /// An action of the table.
    Act(Action),
    /// Open this video at this place.
    Open(String, Start),
    /// Open the bundled scene at its first occlusion.
    OpenSample,
    /// Show the frame at a position from 0.
    GoTo(u32),
    /// Show the frame of this number, or the nearest that there is.
    GoToNumber(u32),
    /// Play at the speed of this place in the list.
    Speed(usize),
    /// Analyse under these settings.
    Set(Box<Settings>),
    /// Choose a pixel.
    Choose(Option<(u32, u32)>),
    /// Look elsewhere in all views.
    Look(Camera),
    /// The pointer is on this pixel.
    Hover(Option<Hover>),
    /// Show this kind of background.
    ShowBackground(Background),
    /// The mask over the input covers so much of it, in per cent.
    Overlay(u8),
    /// Change the areas that are analysed or ignored.
    Area(Change),
    /// Read an event's evidence.
    Read(Option<usize>),
    /// Show or hide a kind of events, by its place in [`crate::occlusion::EventKind::ALL`].
    FilterEvents(usize, bool),
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn no_two_actions_share_a_key_a_name_or_a_meaning() {
        for (i, a) in ACTIONS.iter().enumerate() {
            for b in &ACTIONS[i + 1..] {
                assert_ne!(a.action, b.action);
                assert_ne!(a.text, b.text);
                for shortcut in a.shortcuts {
                    assert!(
                        !b.shortcuts.contains(shortcut),
                        "{} of {} and {}",
                        shortcut.text(),
                        a.text,
                        b.text
                    );
                }
            }
        }
    }

    #[test]
    fn shift_and_ctrl_tell_shortcuts_apart() {
        let press = |key, modifiers| {
            ACTIONS
                .iter()
                .filter(|entry| entry.shortcuts.iter().any(|shortcut| shortcut.matches(key, modifiers)))
                .map(|entry| entry.action)
                .collect::<Vec<_>>()
        };
        assert_eq!(press(Key::ArrowRight, Modifiers::NONE), [Action::Step(1)]);
        assert_eq!(press(Key::ArrowRight, Modifiers::SHIFT), [Action::Step(10)]);
        assert_eq!(press(Key::ArrowRight, Modifiers::COMMAND | Modifiers::CTRL), [Action::NextEvent]);
        assert_eq!(press(Key::Questionmark, Modifiers::SHIFT), [Action::Help]);
        assert_eq!(press(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT), [Action::Redo]);
        assert!(press(Key::F, Modifiers::ALT).is_empty());
    }

    /// The keys in the first cell of a row of the README's table, written as in the menus.
    fn keys_of(cell: &str) -> Vec<String> {
        let mut keys: Vec<String> = Vec::new();
        let mut before = String::new();
        for part in cell.split("<kbd>").skip(1) {
            let (name, after) = part.split_once("</kbd>").unwrap();
            let name = match name {
                "←" => "Left",
                "→" => "Right",
                name => name,
            };
            if after == "+" {
                before = format!("{before}{name}+");
                continue;
            }
            if let Some(first) = keys.pop_if(|key| key.ends_with('–')) {
                let numbers = first.trim_end_matches('–').parse::<u32>().unwrap()..=name.parse().unwrap();
                keys.extend(numbers.map(|number| number.to_string()));
            } else {
                let range = if after == "–" { "–" } else { "" };
                keys.push(format!("{before}{name}{range}"));
            }
            before.clear();
        }
        keys
    }

    #[test]
    fn the_readme_lists_the_keys_that_there_are() {
        let rows = include_str!("../../README.md").lines().filter(|line| line.starts_with("| <kbd>"));
        let listed: Vec<String> = rows.flat_map(|row| keys_of(row.split('|').nth(1).unwrap())).collect();
        let texts = |entry: &Entry| entry.shortcuts.iter().map(|key| key.text()).collect::<Vec<_>>();
        for key in &listed {
            let does = ACTIONS.iter().filter(|entry| texts(entry).contains(key)).count();
            assert_eq!(does, 1, "{key} is in the README and calls {does} actions");
            assert_eq!(listed.iter().filter(|other| *other == key).count(), 1, "{key} is listed twice");
        }
        for entry in ACTIONS.iter().filter(|entry| !entry.shortcuts.is_empty()) {
            let texts = texts(entry);
            assert!(texts.iter().any(|key| listed.contains(key)), "{} {texts:?} is not listed", entry.text);
        }
    }

    #[test]
    fn every_action_of_the_keyboard_has_an_entry() {
        for action in [
            Action::Play,
            Action::Step(-10),
            Action::Maximise(View::Tracks),
            Action::Slot(Slot::B),
            Action::Palette,
        ] {
            assert_eq!(action.entry().unwrap().action, action);
        }
    }
}
