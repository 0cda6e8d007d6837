//! The tabs of the inspector, in one line at every width.

use eframe::egui::{Button, Color32, FontId, RichText, Ui};

use super::style::SMALL_TEXT;
use crate::app::theme;

/// A tab of the inspector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Tab {
    #[default]
    Mixture,
    History,
    Scatter,
    Tuning,
    Statistics,
    Pixels,
}

/// The tabs in order, each with its name, and its abbreviation for narrow panels.
const TABS: [(Tab, &str, &str); 6] = [
    (Tab::Mixture, "Mixture", "Mix"),
    (Tab::History, "History", "Hist"),
    (Tab::Scatter, "Scatter", "Scat"),
    (Tab::Tuning, "Tuning", "Tune"),
    (Tab::Statistics, "Statistics", "Stat"),
    (Tab::Pixels, "Pixels", "Pix"),
];

/// Distance between two tabs, in points.
const TAB_SPACING: f32 = 2.0;

/// The appearance of the tabs, from wide to narrow panels.
const STYLES: [TabStyle; 3] = [
    TabStyle { abbreviated: false, text_size: theme::BODY_TEXT, padding: 6.0 },
    TabStyle { abbreviated: false, text_size: SMALL_TEXT, padding: 4.0 },
    TabStyle { abbreviated: true, text_size: SMALL_TEXT, padding: 4.0 },
];

#[derive(Clone, Copy)]
struct TabStyle {
    /// Whether the tabs are abbreviated.
    abbreviated: bool,
    /// The size of the text, in points.
    text_size: f32,
    /// The space on either side of the text, in points.
    padding: f32,
}

impl TabStyle {
    const fn text(self, name: &'static str, abbreviation: &'static str) -> &'static str {
        if self.abbreviated { abbreviation } else { name }
    }

    /// The width of all tabs, in points.
    fn width(self, ui: &Ui) -> f32 {
        let font = FontId::proportional(self.text_size);
        let tab = |&(_, name, abbreviation): &(Tab, &'static str, &'static str)| {
            let text = self.text(name, abbreviation).to_owned();
            let galley = ui.painter().layout_no_wrap(text, font.clone(), Color32::WHITE);
            galley.size().x + 2.0 * self.padding
        };
        TABS.iter().map(tab).sum::<f32>() + TAB_SPACING * (TABS.len() - 1) as f32
    }
}

impl Tab {
    /// Draws the tabs, of which this one is open.
    pub(super) fn choose(&mut self, ui: &mut Ui) {
        let width = ui.available_width();
        let [.., narrowest] = STYLES;
        let style = STYLES.into_iter().find(|style| style.width(ui) <= width).unwrap_or(narrowest);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = TAB_SPACING;
            ui.spacing_mut().button_padding.x = style.padding;
            for (tab, name, abbreviation) in TABS {
                let text = RichText::new(style.text(name, abbreviation)).size(style.text_size);
                let mut response = ui.add(Button::selectable(*self == tab, text)).accessible_name(name);
                if style.abbreviated {
                    response = response.on_hover_text(name);
                }
                if response.clicked() {
                    *self = tab;
                }
            }
        });
    }

    /// The key of the tab's scroll position.
    pub(super) const fn scroll_key(self) -> &'static str {
        match self {
            Self::Mixture => "now",
            Self::History => "history",
            Self::Scatter => "scatter",
            Self::Tuning => "tuning",
            Self::Statistics => "statistics",
            Self::Pixels => "pixels",
        }
    }
}
