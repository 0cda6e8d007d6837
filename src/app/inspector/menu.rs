//! The menu of each plot: copy or save as image, vector drawing or table.

use eframe::egui::containers::menu::MenuButton;
use eframe::egui::{Button, Label, Response, Ui};
use egui_material_icons::icons as m;

use super::action::InspectorAction;
use super::plot::{Format, Plot};
use super::style;
use super::table::Table;

/// Width of the menu button.
const WIDTH: f32 = 24.0;

/// An export of a plot.
#[derive(Clone, Copy)]
enum PlotExport {
    CopyPicture,
    Save(Format),
    CopyTable,
    SaveTable,
}

const OF_PLOTS: [(PlotExport, &str, &str); 6] = [
    (PlotExport::CopyPicture, "Copy image", "Copy as an image of 300 dpi on white"),
    (PlotExport::Save(Format::Png), "Save PNG…", "Save as a PNG image of 300 dpi on white"),
    (PlotExport::Save(Format::Svg), "Save SVG…", "Save as a vector image on white"),
    (
        PlotExport::Save(Format::Pdf),
        "Save PDF…",
        "Save as a PDF page with selectable text, as large as the plot",
    ),
    (PlotExport::CopyTable, "Copy CSV", "Copy the plotted data as a table"),
    (PlotExport::SaveTable, "Save CSV…", "Save the plotted data as a table"),
];

/// A plot's caption with its menu at the right. Longer explanations are in the caption's tooltip.
pub(super) fn caption(
    ui: &mut Ui,
    text: &str,
    meaning: &str,
    what: &str,
    plot: impl Fn() -> Plot,
) -> Option<InspectorAction> {
    let label = |ui: &mut Ui| {
        let label = ui.add(Label::new(style::aside(ui, text)).truncate());
        label.on_hover_text(if meaning.is_empty() { text } else { meaning });
    };
    row(ui, |ui| of_plot(ui, what, plot), label)
}

/// A row with a menu at its right end; content that does not fit wraps to a second line.
pub(super) fn row(
    ui: &mut Ui,
    menu: impl FnOnce(&mut Ui) -> Option<InspectorAction>,
    before: impl FnOnce(&mut Ui),
) -> Option<InspectorAction> {
    let spacing = ui.spacing().item_spacing;
    let row = |ui: &mut Ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        let width = (ui.available_width() - WIDTH).max(0.0);
        ui.vertical(|ui| {
            ui.set_width(width);
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing = spacing;
                before(ui);
            });
        });
        menu(ui)
    };
    ui.horizontal_top(row).inner
}

/// The menu of a plot that is called `what`.
pub(super) fn of_plot(ui: &mut Ui, what: &str, plot: impl Fn() -> Plot) -> Option<InspectorAction> {
    opened(ui, what, |ui| {
        let mut asked = None;
        for (at, (ask, name, meaning)) in OF_PLOTS.into_iter().enumerate() {
            if at == 3 {
                ui.separator();
            }
            if entry(ui, name, meaning).clicked() {
                asked = Some(match ask {
                    PlotExport::CopyPicture => InspectorAction::CopyPicture(Box::new(plot())),
                    PlotExport::Save(format) => InspectorAction::SavePicture(Box::new(plot()), format),
                    PlotExport::CopyTable => InspectorAction::Copy(plot().table()),
                    PlotExport::SaveTable => InspectorAction::Save(plot().table()),
                });
            }
        }
        asked
    })
}

/// The menu of named tables.
pub(super) fn of_tables(
    ui: &mut Ui,
    what: &str,
    tables: &[(&str, &dyn Fn() -> Table)],
) -> Option<InspectorAction> {
    opened(ui, what, |ui| {
        let mut asked = None;
        for (at, (name, table)) in tables.iter().enumerate() {
            if at > 0 {
                ui.separator();
            }
            if entry(ui, &format!("Copy CSV of {name}"), "Copy as a table").clicked() {
                asked = Some(InspectorAction::Copy(table()));
            }
            if entry(ui, &format!("Save CSV of {name}…"), "Save as a table").clicked() {
                asked = Some(InspectorAction::Save(table()));
            }
        }
        asked
    })
}

fn opened(
    ui: &mut Ui,
    what: &str,
    entries: impl FnOnce(&mut Ui) -> Option<InspectorAction>,
) -> Option<InspectorAction> {
    ui.spacing_mut().button_padding.x = 4.0;
    let button = Button::new(m::ICON_DOWNLOAD.rich_text().size(14.0)).small().frame_when_inactive(false);
    let (response, menu) = MenuButton::from_button(button).ui(ui, |ui| {
        ui.set_min_width(130.0);
        entries(ui)
    });
    let name = format!("Copy or save {what}");
    response.accessible_name(&name).on_hover_text(name);
    menu.and_then(|menu| menu.inner)
}

fn entry(ui: &mut Ui, name: &str, meaning: &str) -> Response {
    ui.button(name).on_hover_text(meaning)
}
