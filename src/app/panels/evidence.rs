//! The evidence of an event, and its counterfactuals.

use eframe::egui::{Align, Button, Label, Layout, RichText, ScrollArea, Ui, vec2};
use egui_material_icons::icons as m;

use crate::app::commands::command::Command;
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::event_comparison::EventRef;
use crate::app::theme;
use crate::occlusion::event::{Comparison, Relation};
use crate::occlusion::{Event, EventKind};
use crate::palette::event_colour;
use crate::settings::Setting;

/// Draws the evidence.
pub(crate) fn ui(ui: &mut Ui, model: &Model, event: &Event, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let colour = theme::readable_colour(ui, event_colour(event.kind));
        ui.label(icons::coloured(icons::of_event(event.kind), colour));
        ui.strong(format!("Evidence for {} {}", event.kind.label(), participants(event)));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = Button::new(m::ICON_CLOSE.rich_text().size(14.0)).frame_when_inactive(false);
            if ui.add(close).accessible_name("Close evidence").clicked() {
                commands.push(Command::OpenEvent(None));
            }
        });
    });
    ScrollArea::vertical().id_salt("evidence").auto_shrink([false, true]).show(ui, |ui| {
        ui.label(&event.evidence.branch);
        if let Some(front) = event.front {
            ui.label(format!("Occluder: {front}"));
        }
        ui.weak(format!(
            "Regions of objects: {} before, {} in this frame",
            event.evidence.objects_before, event.evidence.objects_now
        ));
        ui.add_space(theme::SPACE);
        for comparison in &event.evidence.comparisons {
            comparison_row(ui, comparison);
        }
        if matches!(model.selection.event, Some(EventRef::InView(_))) {
            counterfactuals(ui, model, event, commands);
        }
    });
}

/// The counterfactuals of an event, each with a button that applies it.
fn counterfactuals(ui: &mut Ui, model: &Model, event: &Event, commands: &mut Vec<Command>) {
    let what_if = model.worker.state.as_ref().and_then(|state| state.counterfactual.as_ref());
    let Some(what_if) = what_if.filter(|what_if| what_if.event.is_same(event)) else { return };
    ui.add_space(theme::SPACE);
    ui.label(RichText::new("Settings that would prevent this event").strong()).on_hover_text(
        "Counterfactuals: tracking and occlusion re-run over the preceding frames with one setting \
         changed. Listed is the nearest value of each setting at which the event does not occur",
    );
    if !what_if.happens {
        ui.weak("Not available: the preceding seconds alone do not reproduce the event.");
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(theme::SPACE, theme::SPACE);
        for prevention in &what_if.preventions {
            let words = prevention.words();
            let button = Button::new(RichText::new(&words).size(theme::SMALL_TEXT));
            let response = ui.add(button).accessible_name(format!("Apply {words}"));
            if response.on_hover_text("Apply this value; undo restores the current one").clicked() {
                let mut settings = model.edits.settings.clone();
                let setting = Setting::named(prevention.setting);
                // The tested value lies within the setting's range.
                if setting.is_some_and(|setting| setting.set(&mut settings, prevention.value).is_ok()) {
                    commands.push(Command::Set(Box::new(settings)));
                }
            }
        }
    });
    let (tried, all) = what_if.tried;
    if !what_if.done {
        ui.weak(format!("Tested {tried} of {all} values…"));
    } else if what_if.preventions.is_empty() {
        ui.weak("No single tracking or occlusion setting prevents it.");
    } else {
        ui.weak(format!("Tested up to frame {}.", what_if.until)).on_hover_text(
            "Last frame tested after the event; values that only delay the event up to this frame are not \
             listed",
        );
    }
}

/// A comparison: the compared quantity on the left, value and threshold on the right.
fn comparison_row(ui: &mut Ui, comparison: &Comparison) {
    let colours = theme::colours(ui.visuals());
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = theme::SPACE;
        let (icon, colour, word) = match (comparison.chosen, comparison.threshold, comparison.holds) {
            (Some(true), ..) => (m::ICON_RADIO_BUTTON_CHECKED, colours.good, "selected alternative"),
            (Some(false), ..) => (m::ICON_RADIO_BUTTON_UNCHECKED, colours.weak, "rejected alternative"),
            (None, None, _) => (m::ICON_REMOVE, colours.weak, "no threshold"),
            (None, _, true) => (m::ICON_CHECK, colours.good, "condition met"),
            (None, _, false) => (m::ICON_CLOSE, colours.bad, "condition not met"),
        };
        ui.label(icon.rich_text().size(14.0).color(colour)).on_hover_text(word);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let limit = match (comparison.threshold, comparison.relation) {
                (Some(limit), Some(Relation::AtMost)) => format!("≤ {limit:.2}"),
                (Some(limit), _) => format!("≥ {limit:.2}"),
                (None, _) => String::new(),
            };
            ui.add_sized(
                vec2(84.0, 16.0),
                Label::new(RichText::new(limit).monospace().color(colours.weak)).halign(Align::RIGHT),
            );
            ui.monospace(format!("{:.2}", comparison.value));
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(Label::new(&comparison.what).truncate());
            });
        });
    });
}

/// The participants of an event: `3 + 5`, `3 + 5 » 3, 7`.
pub(crate) fn participants(event: &Event) -> String {
    let join = |ids: &[u32], with: &str| ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(with);
    let before = join(&event.objects, " + ");
    let after = join(&event.becomes, ", ");
    let same =
        matches!(event.kind, EventKind::Merge) || event.becomes.is_empty() || event.becomes == event.objects;
    match (same, before.is_empty()) {
        (true, _) => before,
        (false, true) => after,
        (false, false) => format!("{before} » {after}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn participants_show_identities_before_and_after() {
        let event = |kind, objects: &[u32], becomes: &[u32]| Event {
            frame: 1,
            kind,
            objects: objects.to_vec(),
            becomes: becomes.to_vec(),
            pieces: Vec::new(),
            x: 0.0,
            y: 0.0,
            front: None,
            evidence: crate::occlusion::Evidence::default(),
        };
        assert_eq!(participants(&event(EventKind::Merge, &[3, 5], &[3, 5])), "3 + 5");
        assert_eq!(participants(&event(EventKind::Demerge, &[3, 5], &[3, 7])), "3 + 5 » 3, 7");
        assert_eq!(participants(&event(EventKind::Enter, &[], &[4])), "4");
        assert_eq!(participants(&event(EventKind::Disappear, &[4], &[])), "4");
    }
}
