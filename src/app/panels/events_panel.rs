//! The list of events, and the evidence of the selected event.

use eframe::egui::text::{LayoutJob, TextWrapping};
use eframe::egui::{
    Align, Align2, Button, Color32, FontId, Label, Layout, RichText, ScrollArea, Sense, Ui, WidgetInfo,
    accesskit::Role, vec2,
};
use egui_material_icons::icons as m;

use crate::app::commands::command::Command;
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::event_comparison::{ComparisonFilter, EventComparison, EventRef};
use crate::app::theme;
use crate::explain::events::event_pairs::EventPair;
use crate::occlusion::event::{Comparison, Relation};
use crate::occlusion::{Event, EventKind};
use crate::palette::{event_colour, identity_colour};
use crate::replay::Timeline;
use crate::settings::Setting;

/// Draws the panel.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some(timeline) = model.timeline() else { return };
    ui.horizontal(|ui| {
        ui.heading("Events");
        ui.weak(timeline.events.len().to_string());
        if let Some(compared) = &model.compared {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                listings(ui, model, compared, commands);
            });
        }
    });
    filter(ui, model, commands);
    let listed = listed(model, timeline);
    if listed.is_empty() {
        ui.add_space(theme::SPACE);
        let why = match model.listing {
            _ if timeline.events.is_empty() && model.compared.is_none() => "No events so far.",
            ComparisonFilter::OnlyInView | ComparisonFilter::OnlyCompared | ComparisonFilter::Moved
                if model.compared.is_some() =>
            {
                "No such events: A and B agree."
            }
            _ => "No events of the selected kinds.",
        };
        ui.weak(why);
        return;
    }
    let read = model.reading.and_then(|read| Some((read, model.event(read)?)));
    let height = ui.available_height();
    let list = if read.is_some() { (height * 0.38).max(height - 320.0) } else { height };
    let here = model.shown().map(|shown| shown.position);
    let row_height = theme::ROW;
    // Without a minimum height: in a low panel the list would cover the evidence.
    let mut area = ScrollArea::vertical().id_salt("events").auto_shrink([false, true]);
    area = area.min_scrolled_height(0.0).max_height(list);
    let positions = listed.iter().filter_map(|row| Some(model.event(row.read)?.0));
    if let Some(offset) = follow(ui, positions, here, row_height, list) {
        area = area.vertical_scroll_offset(offset);
    }
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        area.show_rows(ui, row_height, listed.len(), |ui, rows| {
            for listed in &listed[rows] {
                let Some((position, event)) = model.event(listed.read) else { continue };
                let current = here == Some(*position);
                let aside = aside(model, listed);
                if row(ui, event, current, model.reading == Some(listed.read), aside) {
                    commands.push(Command::OpenEvent(Some(listed.read)));
                    commands.push(Command::GoTo(*position));
                }
            }
        });
    });
    if let Some((_, (_, event))) = read {
        ui.separator();
        evidence(ui, model, event, commands);
    }
}

/// A row of the list.
struct Listed {
    read: EventRef,
    /// The pair that contains the event, while settings are compared.
    pair: Option<EventPair>,
}

/// The listed events, in order of time.
fn listed(model: &Model, timeline: &Timeline) -> Vec<Listed> {
    let shows = |listed: &Listed| model.event(listed.read).is_some_and(|(_, event)| model.lists(event.kind));
    let Some(compared) = &model.compared else {
        let all =
            (0..timeline.events.len()).map(|index| Listed { read: EventRef::InView(index), pair: None });
        return all.filter(shows).collect();
    };
    let pairs = compared.pairs.iter().filter(|pair| compared.lists(model.listing, **pair));
    let rows = pairs.map(|&pair| {
        let read = match pair {
            EventPair::First(index) | EventPair::Both(index, _) => EventRef::InView(index),
            EventPair::Second(index) => EventRef::Compared(index),
        };
        Listed { read, pair: Some(pair) }
    });
    rows.filter(shows).collect()
}

/// The filters of the list while settings are compared, with the number of events of each.
fn listings(ui: &mut Ui, model: &Model, compared: &EventComparison, commands: &mut Vec<Command>) {
    let slot = model.ab_settings.in_view;
    ui.spacing_mut().item_spacing.x = theme::SPACE / 2.0;
    ui.spacing_mut().button_padding = vec2(theme::SPACE, 1.0);
    for listing in ComparisonFilter::ALL.into_iter().rev() {
        let (word, meaning) = match listing {
            ComparisonFilter::All => ("all".to_owned(), "Events under A or B".to_owned()),
            ComparisonFilter::OnlyInView => {
                (format!("only {}", slot.name()), format!("Events under {} only", slot.name()))
            }
            ComparisonFilter::OnlyCompared => {
                let other = slot.other().name();
                (format!("only {other}"), format!("Events under {other} only"))
            }
            ComparisonFilter::Moved => {
                ("moved".to_owned(), "Events under both, at different frames".to_owned())
            }
        };
        let count = compared.pairs.iter().filter(|pair| compared.lists(listing, **pair)).count();
        let text = RichText::new(format!("{word} {count}")).size(theme::SMALL);
        let response = ui.add(Button::selectable(model.listing == listing, text));
        if response.accessible_name(&meaning).on_hover_text(meaning).clicked() {
            commands.push(Command::List(listing));
        }
    }
}

/// The note beside an event while settings are compared: the slot that alone has it, or its shift in frames.
fn aside(model: &Model, listed: &Listed) -> Option<(String, [u8; 3])> {
    let slot = model.ab_settings.in_view;
    match listed.pair? {
        EventPair::First(_) => Some((slot.name().to_owned(), slot.colour())),
        EventPair::Second(_) => Some((slot.other().name().to_owned(), slot.other().colour())),
        pair @ EventPair::Both(..) => {
            let moved = model.compared.as_ref()?.moved(pair).filter(|moved| *moved != 0)?;
            let text = format!("{moved:+} in {}", slot.other().name());
            Some((text, slot.other().colour()))
        }
    }
}

/// The scroll offset that shows the events nearest to the frame in view; `None` if that frame is unchanged.
fn follow(
    ui: &Ui,
    mut positions: impl Iterator<Item = u32>,
    here: Option<u32>,
    row: f32,
    height: f32,
) -> Option<f32> {
    let id = ui.scope_id().with("followed");
    let before = ui.data(|data| data.get_temp::<u32>(id));
    let here = here?;
    if before == Some(here) {
        return None;
    }
    ui.data_mut(|data| data.insert_temp(id, here));
    let first = positions.position(|position| position >= here)?;
    Some((first as f32 * row - height * 0.4).max(0.0))
}

fn filter(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let counts = model.timeline().map(|timeline| {
        EventKind::ALL.map(|kind| timeline.events.iter().filter(|(_, event)| event.kind == kind).count())
    });
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(theme::SPACE / 2.0, theme::SPACE / 2.0);
        ui.spacing_mut().button_padding = vec2(theme::SPACE, 1.0);
        let weak = theme::colours(ui.visuals()).weak;
        for (place, kind) in EventKind::ALL.into_iter().enumerate() {
            let on = model.listed[place];
            let colour = if on { readable(ui, event_colour(kind)) } else { weak.gamma_multiply(0.5) };
            let count = counts.map_or(0, |counts| counts[place]);
            let button = Button::selectable(
                on,
                (
                    icons::text(icons::of_event(kind)).color(colour).size(14.0),
                    RichText::new(count.to_string()).size(theme::SMALL),
                ),
            );
            let name = format!("Show {} events", kind.label());
            let text = format!(
                "{}: {count}. Click to show or hide them in the list and for keys N and P.",
                kind.label()
            );
            if ui.add(button).accessible_name(name).on_hover_text(text).clicked() {
                commands.push(Command::FilterEvents(place, !on));
            }
        }
    });
}

/// A palette colour adapted to panels: darker on a light panel.
fn readable(ui: &Ui, colour: [u8; 3]) -> Color32 {
    let colour = theme::rgb(colour);
    if ui.visuals().dark_mode {
        colour
    } else {
        Color32::from_rgb(colour.r() / 10 * 7, colour.g() / 10 * 7, colour.b() / 10 * 7)
    }
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

fn row(ui: &mut Ui, event: &Event, current: bool, read: bool, aside: Option<(String, [u8; 3])>) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::click());
    let who = participants(event);
    let mut name = format!("{} {who}, frame {}", event.kind.label(), event.frame);
    if let Some((text, _)) = &aside {
        name = format!("{name}, {text}");
    }
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, read, &name));
    let colours = theme::colours(ui.visuals());
    let painter = ui.painter();
    if read {
        painter.rect_filled(rect, 3.0, ui.visuals().selection.bg_fill);
    } else if response.hovered() {
        painter.rect_filled(rect, 3.0, ui.visuals().widgets.hovered.weak_bg_fill);
    } else if current {
        painter.rect_filled(rect, 3.0, colours.accent.gamma_multiply(0.16));
    }
    if current {
        let mark =
            eframe::egui::Rect::from_min_size(rect.min + vec2(0.0, 3.0), vec2(3.0, rect.height() - 6.0));
        painter.rect_filled(mark, 1.0, colours.accent);
    }
    let icon = icons::of_event(event.kind);
    let font = FontId::new(theme::ICON, icon.font_family());
    let middle = rect.left_center();
    painter.text(
        middle + vec2(8.0, 0.0),
        Align2::LEFT_CENTER,
        icon.codepoint,
        font,
        readable(ui, event_colour(event.kind)),
    );
    let font = FontId::proportional(theme::BODY);
    painter.text(
        middle + vec2(30.0, 0.0),
        Align2::LEFT_CENTER,
        event.kind.label(),
        font.clone(),
        colours.text,
    );
    let mut x = 104.0;
    let ids = if event.objects.is_empty() { &event.becomes } else { &event.objects };
    for id in ids.iter().take(3) {
        painter.circle_filled(middle + vec2(x, 0.0), 4.0, theme::rgb(identity_colour(*id)));
        x += 10.0;
    }
    let number = painter.text(
        rect.right_center() - vec2(8.0, 0.0),
        Align2::RIGHT_CENTER,
        format!("#{}", event.frame),
        FontId::monospace(theme::MONO),
        colours.weak,
    );
    let mut end = number.left();
    if let Some((text, colour)) = aside {
        let at = rect.right_center() - vec2(58.0, 0.0);
        let font = FontId::proportional(theme::SMALL);
        end = painter.text(at, Align2::RIGHT_CENTER, text, font, readable(ui, colour)).left();
    }
    let mut job = LayoutJob::simple_singleline(who, font, colours.text);
    job.wrap = TextWrapping::truncate_at_width((end - rect.left() - x - 8.0).max(0.0));
    let who = painter.layout_job(job);
    painter.galley(middle + vec2(x + 2.0, -who.size().y / 2.0), who, colours.text);
    theme::focus(ui, &response);
    if response.gained_focus() {
        response.scroll_to_me(None);
    }
    let clicked = response.clicked();
    response.on_hover_ui(|ui| {
        ui.strong(&name);
        ui.label(&event.evidence.branch);
    });
    clicked
}

fn evidence(ui: &mut Ui, model: &Model, event: &Event, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let colour = readable(ui, event_colour(event.kind));
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
            compared(ui, comparison);
        }
        if matches!(model.reading, Some(EventRef::InView(_))) {
            prevented(ui, model, event, commands);
        }
    });
}

/// The counterfactuals of an event, each with a button that applies it.
fn prevented(ui: &mut Ui, model: &Model, event: &Event, commands: &mut Vec<Command>) {
    let what_if = model.state.as_ref().and_then(|state| state.counterfactual.as_ref());
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
            let button = Button::new(RichText::new(&words).size(theme::SMALL));
            let response = ui.add(button).accessible_name(format!("Apply {words}"));
            if response.on_hover_text("Apply this value; undo restores the current one").clicked() {
                let mut settings = model.settings.clone();
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
        ui.weak(format!("… tested {tried} of {all}"));
    } else if what_if.preventions.is_empty() {
        ui.weak("No single tracking or occlusion setting prevents it.");
    } else {
        ui.weak(format!("tested up to frame {}", what_if.until)).on_hover_text(
            "Last frame tested after the event; values that only delay the event up to this frame are not \
             listed",
        );
    }
}

/// A comparison: the compared quantity on the left, value and threshold on the right.
fn compared(ui: &mut Ui, comparison: &Comparison) {
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
