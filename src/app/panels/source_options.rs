//! The dialog of the source's options: how the open video is read.

use std::num::NonZeroU32;

use eframe::egui::{Button, Context, DragValue, Grid, Id, Modal, Response, RichText, TextEdit, Ui, vec2};

use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::theme;
use crate::frame::Size;
use crate::placement::{Crop, Placement};
use crate::source::{FPS_RANGE, FpsFrom, Levels, Options, SCALE_RANGE, SourceInfo, SourceKind};

/// Width of the dialog, in points.
const WIDTH: f32 = 480.0;

/// The dialog. The edited options, while it is open.
#[derive(Default)]
pub(crate) struct SourceOptions(Option<OptionsDraft>);

/// The options as they are edited.
struct OptionsDraft {
    options: Options,
    /// The kind of the source, if it is known.
    kind: Option<SourceKind>,
    /// The levels as they are typed.
    levels: String,
}

/// An option, and its controls.
struct OptionRow {
    label: &'static str,
    hint: &'static str,
    /// Whether a source of this kind has the option.
    is_of: fn(SourceKind) -> bool,
    controls: fn(&mut Ui, &mut OptionsDraft, RowContext<'_>),
}

/// What the controls of a row refer to.
#[derive(Clone, Copy)]
struct RowContext<'a> {
    model: &'a Model,
    /// The source, once it is open.
    info: Option<&'a SourceInfo>,
    /// The label of the row.
    label: Id,
}

/// The rows of the dialog.
const ROWS: &[OptionRow] = &[
    OptionRow {
        label: "Frame rate",
        hint: "Frames per second of the source, if it states none or a wrong one (--fps)",
        is_of: |_| true,
        controls: frame_rate,
    },
    OptionRow {
        label: "Every N-th frame",
        hint: "Analyse the first frame and each N-th after it; frames keep their numbers (--every)",
        is_of: |_| true,
        controls: every,
    },
    OptionRow {
        label: "Levels",
        hint: "The stored values of images that become black and white, as 0..4095, or auto (--levels)",
        is_of: SourceKind::is_images,
        controls: levels,
    },
    OptionRow {
        label: "Interlaced",
        hint: "Make one picture of the two fields of each frame (--deinterlace)",
        is_of: SourceKind::is_video,
        controls: deinterlace,
    },
    OptionRow {
        label: "Stream",
        hint: "The index of the stream of a file with several, as ffprobe prints it (--stream)",
        is_of: SourceKind::is_video,
        controls: stream,
    },
    OptionRow {
        label: "Part of the image",
        hint: "Analyse only this part: left, top, width and height in the source's pixels (--crop)",
        is_of: |_| true,
        controls: crop,
    },
    OptionRow {
        label: "Scale",
        hint: "Reduce the images by this factor before the analysis (--scale)",
        is_of: |_| true,
        controls: scale,
    },
];

impl SourceOptions {
    /// Opens the dialog with these options of the source `name`.
    pub(crate) fn open(&mut self, name: &str, options: Options) {
        let levels = options.levels.map_or_else(String::new, |levels| levels.to_string());
        self.0 = Some(OptionsDraft { options, kind: SourceKind::of(name).ok(), levels });
    }

    /// Whether the dialog is open.
    pub(crate) const fn is_open(&self) -> bool {
        self.0.is_some()
    }

    /// Draws the dialog while it is open.
    pub(crate) fn ui(&mut self, ctx: &Context, model: &Model, commands: &mut Vec<Command>) {
        let Some(draft) = &mut self.0 else { return };
        let response = Modal::new(Id::unique("source options"))
            .frame(theme::dialog_frame(ctx))
            .show(ctx, |ui| content(ui, draft, model, commands));
        if response.inner || response.should_close() {
            self.0 = None;
        }
    }
}

/// Draws the contents of the dialog; returns whether it is to be closed.
fn content(ui: &mut Ui, draft: &mut OptionsDraft, model: &Model, commands: &mut Vec<Command>) -> bool {
    let info = model.worker.state.as_ref().and_then(|state| state.info.as_deref());
    ui.set_width(WIDTH);
    ui.label(RichText::new("Source options").size(18.0).strong());
    ui.weak("How the open video is read. Another choice analyses it again; files have the source's pixels.");
    ui.add_space(2.0 * theme::SPACE);
    Grid::new("source options").num_columns(2).min_row_height(26.0).spacing(vec2(16.0, 4.0)).show(ui, |ui| {
        let rows = ROWS.iter().filter(|row| draft.kind.is_none_or(row.is_of));
        for OptionRow { label, hint, controls, .. } in rows.collect::<Vec<_>>() {
            let label = ui.label(*label).on_hover_text(*hint).id;
            ui.horizontal(|ui| controls(ui, draft, RowContext { model, info, label }));
            ui.end_row();
        }
    });
    ui.add_space(2.0 * theme::SPACE);
    let outcome = outcome(draft, info);
    let options = &mut draft.options;
    match &outcome {
        Ok(text) => ui.weak(text),
        Err(why) => ui.colored_label(theme::colours(ui.visuals()).bad, why),
    };
    ui.add_space(2.0 * theme::SPACE);
    ui.horizontal(|ui| {
        let differs = *options != model.videos.opened_options();
        let apply = ui.add_enabled(differs && outcome.is_ok(), Button::new("Apply"));
        if apply.clicked() {
            commands.push(Command::Read(*options));
        }
        let hint = "Read the source as it is: choose Apply afterwards";
        if ui.add_enabled(!options.is_default(), Button::new("Reset")).on_hover_text(hint).clicked() {
            *options = Options::default();
            draft.levels.clear();
        }
        ui.button("Cancel").clicked() || apply.clicked()
    })
    .inner
}

/// What is analysed with these options, in words, or why they are impossible.
fn outcome(draft: &OptionsDraft, info: Option<&SourceInfo>) -> Result<String, String> {
    let options = draft.options;
    if options.levels.is_none() && !draft.levels.trim().is_empty() {
        return Err("Levels are two values in ascending order, as 0..4095, or auto.".to_owned());
    }
    let Some(info) = info else {
        return Ok("The size of the images is unknown until the video opens.".to_owned());
    };
    let source = info.source_size();
    let placement = Placement::new(source, options.crop, options.scale)
        .ok_or_else(|| format!("The part reaches beyond the images, which are {source}."))?;
    let every = options.every.map_or(1, NonZeroU32::get);
    let fps = options.fps.or_else(|| own_rate(info)).map(|fps| fps / every as f32);
    if fps.is_some_and(|fps| fps < FPS_RANGE.0) {
        return Err(format!("Less than {} frames per second would be left.", FPS_RANGE.0));
    }
    let fps = fps.map(|fps| format!(", {} frames per second", (fps * 100.0).round() / 100.0));
    let of = if placement.is_identity() { String::new() } else { format!(" of {source}") };
    Ok(format!("Analysed: {}{of} pixels{}", placement.size(), fps.unwrap_or_default()))
}

/// The source's own rate; `None` if it was replaced by a given one.
fn own_rate(info: &SourceInfo) -> Option<f32> {
    (info.fps_from != FpsFrom::Given).then(|| info.source_fps())
}

/// A number that can be typed or dragged, in `least`..=`most`.
fn whole(ui: &mut Ui, value: &mut u32, prefix: &str, least: u32, most: u32) -> Response {
    ui.add(DragValue::new(value).prefix(prefix).range(least..=most.max(least)).update_while_editing(false))
}

fn frame_rate(ui: &mut Ui, OptionsDraft { options, .. }: &mut OptionsDraft, row: RowContext<'_>) {
    let mut is_given = options.fps.is_some();
    ui.checkbox(&mut is_given, "").labelled_by(row.label).on_hover_text("Set the frame rate");
    let known = row.info.map_or(25.0, SourceInfo::source_fps);
    if !is_given {
        options.fps = None;
        let own = row.info.and_then(own_rate).map(|fps| format!("{fps} fps, of the source"));
        ui.weak(own.unwrap_or_else(|| "of the source".to_owned()));
        return;
    }
    let fps = options.fps.get_or_insert(known);
    let (least, greatest) = FPS_RANGE;
    let typed = DragValue::new(fps).range(least..=greatest).max_decimals(3).update_while_editing(false);
    ui.add(typed).labelled_by(row.label);
    ui.weak("fps");
}

fn every(ui: &mut Ui, OptionsDraft { options, .. }: &mut OptionsDraft, row: RowContext<'_>) {
    let mut every = options.every.map_or(1, NonZeroU32::get);
    whole(ui, &mut every, "", 1, u32::MAX).labelled_by(row.label);
    options.every = NonZeroU32::new(every).filter(|every| *every > NonZeroU32::MIN);
    ui.weak(if every == 1 { "all frames".to_owned() } else { format!("1 of {every} frames") });
}

fn levels(ui: &mut Ui, draft: &mut OptionsDraft, row: RowContext<'_>) {
    let field = TextEdit::singleline(&mut draft.levels).hint_text("of the images").desired_width(120.0);
    if ui.add(field).labelled_by(row.label).changed() {
        draft.options.levels = draft.levels.parse().ok().filter(|levels: &Levels| levels.is_valid());
    }
    ui.weak("LOW..HIGH or auto");
}

fn deinterlace(ui: &mut Ui, OptionsDraft { options, .. }: &mut OptionsDraft, row: RowContext<'_>) {
    ui.checkbox(&mut options.deinterlace, "Deinterlace").labelled_by(row.label);
}

fn stream(ui: &mut Ui, OptionsDraft { options, .. }: &mut OptionsDraft, row: RowContext<'_>) {
    let mut is_given = options.stream.is_some();
    ui.checkbox(&mut is_given, "").labelled_by(row.label).on_hover_text("Select a stream");
    if is_given {
        whole(ui, options.stream.get_or_insert(0), "", 0, 1000).accessible_name("Stream");
    } else {
        options.stream = None;
        ui.weak("the best one");
    }
}

fn scale(ui: &mut Ui, OptionsDraft { options, .. }: &mut OptionsDraft, row: RowContext<'_>) {
    let (least, greatest) = SCALE_RANGE;
    let mut scale = options.scale.unwrap_or(greatest);
    let typed = DragValue::new(&mut scale).range(least..=greatest).speed(0.01).max_decimals(3);
    ui.add(typed.update_while_editing(false)).labelled_by(row.label);
    options.scale = Some(scale).filter(|scale| *scale < greatest);
}

fn crop(ui: &mut Ui, OptionsDraft { options, .. }: &mut OptionsDraft, row: RowContext<'_>) {
    let size = row.info.map(SourceInfo::source_size);
    let mut is_given = options.crop.is_some();
    ui.checkbox(&mut is_given, "").labelled_by(row.label).on_hover_text("Analyse only a part");
    if is_given {
        let whole_image = Crop::whole(size.unwrap_or(Size::new(1, 1)));
        let Crop { x, y, width, height } = options.crop.get_or_insert(whole_image);
        let [columns, rows] = size.map_or([u32::MAX; 2], |size| [size.width, size.height]);
        whole(ui, x, "x ", 0, columns.saturating_sub(1)).accessible_name("Left column");
        whole(ui, y, "y ", 0, rows.saturating_sub(1)).accessible_name("Upper row");
        whole(ui, width, "w ", 1, columns).accessible_name("Width");
        whole(ui, height, "h ", 1, rows).accessible_name("Height");
    } else {
        options.crop = None;
        ui.weak("all");
    }
    let area = selected_area(row);
    let button = ui.add_enabled(area.is_some(), Button::new("Selected area"));
    let hint = "Take the bounds of the area that is selected in the views";
    if button.on_hover_text(hint).on_disabled_hover_text(hint).clicked() {
        options.crop = area;
    }
}

/// The bounds of the selected area in the source's images.
fn selected_area(row: RowContext<'_>) -> Option<Crop> {
    let areas = &row.model.edits.areas;
    let corners = &areas.drawn.get(areas.chosen?)?.corners;
    let placement = row.model.worker.placement();
    let size = row.info?.source_size();
    let corners = corners.iter().map(|&at| placement.map_or(at, |placement| placement.source_point(at)));
    let bounds = |values: Vec<f32>, most: u32| {
        let low = values.iter().copied().fold(f32::INFINITY, f32::min).floor().clamp(0.0, most as f32) as u32;
        let high = values.iter().copied().fold(0.0, f32::max).ceil().clamp(0.0, most as f32) as u32;
        (high > low).then_some((low, high - low))
    };
    let (x, width) = bounds(corners.clone().map(|[x, _]| x).collect(), size.width)?;
    let (y, height) = bounds(corners.map(|[_, y]| y).collect(), size.height)?;
    Some(Crop { x, y, width, height })
}
