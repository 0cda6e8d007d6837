//! The list of events, and the evidence of the selected event.

use eframe::egui::text::{LayoutJob, TextWrapping};
use eframe::egui::{
    Align, Align2, Button, FontId, Layout, RichText, ScrollArea, Sense, Ui, WidgetInfo, accesskit::Role, vec2,
};

use crate::app::commands::command::Command;
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::event_comparison::{ComparisonFilter, EventComparison, EventRef};
use crate::app::panels::evidence::{self, participants};
use crate::app::theme;
use crate::explain::events::event_pairs::EventPair;
use crate::occlusion::{Event, EventKind};
use crate::palette::{event_colour, identity_colour};
use crate::replay::Timeline;

/// Draws the panel.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some(timeline) = model.worker.timeline() else { return };
    ui.horizontal(|ui| {
        ui.heading("Events");
        ui.weak(timeline.events.len().to_string());
        if let Some(compared) = &model.events.comparison {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                comparison_filters(ui, model, compared, commands);
            });
        }
    });
    filter(ui, model, commands);
    let listed = event_rows(model, timeline);
    if listed.is_empty() {
        ui.add_space(theme::SPACE);
        let why = match model.events.filter {
            _ if timeline.events.is_empty() && model.events.comparison.is_none() => "No events so far.",
            ComparisonFilter::OnlyInView | ComparisonFilter::OnlyCompared | ComparisonFilter::Moved
                if model.events.comparison.is_some() =>
            {
                "No such events: A and B agree."
            }
            _ => "No events of the selected kinds.",
        };
        ui.weak(why);
        return;
    }
    let read = model.selection.event.and_then(|read| Some((read, model.worker.event(read)?)));
    let height = ui.available_height();
    let list = if read.is_some() { (height * 0.38).max(height - 320.0) } else { height };
    let here = model.worker.shown().map(|shown| shown.position);
    let row_height = theme::ROW_HEIGHT;
    // Without a minimum height: in a low panel the list would cover the evidence.
    let mut area = ScrollArea::vertical().id_salt("events").auto_shrink([false, true]);
    area = area.min_scrolled_height(0.0).max_height(list);
    let positions = listed.iter().filter_map(|row| Some(model.worker.event(row.read)?.0));
    if let Some(offset) = scroll_offset(ui, positions, here, row_height, list) {
        area = area.vertical_scroll_offset(offset);
    }
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        area.show_rows(ui, row_height, listed.len(), |ui, rows| {
            for listed in &listed[rows] {
                let Some((position, event)) = model.worker.event(listed.read) else { continue };
                let current = here == Some(*position);
                let aside = comparison_note(model, listed);
                if row(ui, event, current, model.selection.event == Some(listed.read), aside) {
                    commands.push(Command::OpenEvent(Some(listed.read)));
                    commands.push(Command::GoTo(*position));
                }
            }
        });
    });
    if let Some((_, (_, event))) = read {
        ui.separator();
        evidence::ui(ui, model, event, commands);
    }
}

/// A row of the list.
struct EventRow {
    read: EventRef,
    /// The pair that contains the event, while settings are compared.
    pair: Option<EventPair>,
}

/// The listed events, in order of time.
fn event_rows(model: &Model, timeline: &Timeline) -> Vec<EventRow> {
    let shows = |listed: &EventRow| {
        model.worker.event(listed.read).is_some_and(|(_, event)| model.events.lists(event.kind))
    };
    let Some(compared) = &model.events.comparison else {
        let all =
            (0..timeline.events.len()).map(|index| EventRow { read: EventRef::InView(index), pair: None });
        return all.filter(shows).collect();
    };
    let pairs = compared.pairs.iter().filter(|pair| compared.lists(model.events.filter, **pair));
    let rows = pairs.map(|&pair| {
        let read = match pair {
            EventPair::First(index) | EventPair::Both(index, _) => EventRef::InView(index),
            EventPair::Second(index) => EventRef::Compared(index),
        };
        EventRow { read, pair: Some(pair) }
    });
    rows.filter(shows).collect()
}

/// The filters of the list while settings are compared, with the number of events of each.
fn comparison_filters(ui: &mut Ui, model: &Model, compared: &EventComparison, commands: &mut Vec<Command>) {
    let slot = model.edits.ab_settings.in_view;
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
        let text = RichText::new(format!("{word} {count}")).size(theme::SMALL_TEXT);
        let response = ui.add(Button::selectable(model.events.filter == listing, text));
        if response.accessible_name(&meaning).on_hover_text(meaning).clicked() {
            commands.push(Command::FilterComparison(listing));
        }
    }
}

/// The note beside an event while settings are compared: the slot that alone has it, or its shift in frames.
fn comparison_note(model: &Model, listed: &EventRow) -> Option<(String, [u8; 3])> {
    let slot = model.edits.ab_settings.in_view;
    match listed.pair? {
        EventPair::First(_) => Some((slot.name().to_owned(), slot.colour())),
        EventPair::Second(_) => Some((slot.other().name().to_owned(), slot.other().colour())),
        pair @ EventPair::Both(..) => {
            let moved = model.events.comparison.as_ref()?.moved(pair).filter(|moved| *moved != 0)?;
            let text = format!("{moved:+} in {}", slot.other().name());
            Some((text, slot.other().colour()))
        }
    }
}

/// The scroll offset that shows the events nearest to the frame in view; `None` if that frame is unchanged.
fn scroll_offset(
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
    let counts = model.worker.timeline().map(|timeline| {
        EventKind::ALL.map(|kind| timeline.events.iter().filter(|(_, event)| event.kind == kind).count())
    });
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(theme::SPACE / 2.0, theme::SPACE / 2.0);
        ui.spacing_mut().button_padding = vec2(theme::SPACE, 1.0);
        let weak = theme::colours(ui.visuals()).weak;
        for (place, kind) in EventKind::ALL.into_iter().enumerate() {
            let on = model.events.listed_kinds[place];
            let colour =
                if on { theme::readable_colour(ui, event_colour(kind)) } else { weak.gamma_multiply(0.5) };
            let count = counts.map_or(0, |counts| counts[place]);
            let button = Button::selectable(
                on,
                (
                    icons::text(icons::of_event(kind)).color(colour).size(14.0),
                    RichText::new(count.to_string()).size(theme::SMALL_TEXT),
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

fn row(ui: &mut Ui, event: &Event, current: bool, read: bool, aside: Option<(String, [u8; 3])>) -> bool {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW_HEIGHT), Sense::click());
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
    let font = FontId::new(theme::ICON_SIZE, icon.font_family());
    let middle = rect.left_center();
    painter.text(
        middle + vec2(8.0, 0.0),
        Align2::LEFT_CENTER,
        icon.codepoint,
        font,
        theme::readable_colour(ui, event_colour(event.kind)),
    );
    let font = FontId::proportional(theme::BODY_TEXT);
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
        FontId::monospace(theme::MONO_TEXT),
        colours.weak,
    );
    let mut end = number.left();
    if let Some((text, colour)) = aside {
        let at = rect.right_center() - vec2(58.0, 0.0);
        let font = FontId::proportional(theme::SMALL_TEXT);
        end = painter.text(at, Align2::RIGHT_CENTER, text, font, theme::readable_colour(ui, colour)).left();
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
