//! Results of dialogs, and exports of the inspector.

use std::sync::Arc;

use eframe::egui::{ColorImage, Context};

use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::files::dialogs::DialogResult;
use crate::app::inspector::InspectorAction;
use crate::app::model::areas::AreaEdit;
use crate::app::model::view::View;
use crate::app::views;
use crate::app::window::Window;
use crate::replay::Start;
use crate::source::name_of;
use crate::truth::Truth;
use crate::truth::external::ExternalResults;

impl Window {
    /// Handles the result of a dialog.
    pub(in crate::app) fn handle_result(&mut self, ctx: &Context, result: DialogResult) {
        match result {
            DialogResult::Open(path) => {
                self.apply(ctx, Command::Open(name_of(path), Start::First));
            }
            DialogResult::Plot(Ok(picture)) => {
                ctx.copy_image(picture);
                self.toasts.done(ctx, "Copied the plot as an image");
            }
            DialogResult::Written(Ok(path)) => self.toasts.done(ctx, format!("Wrote {}", path.display())),
            DialogResult::Settings(Ok((path, settings))) => {
                self.apply(ctx, Command::Set(settings));
                self.toasts.done(ctx, format!("Loaded the settings of {}", path.display()));
            }
            DialogResult::Sweep(Ok(sweep)) => self.sweep_maps.open(sweep),
            DialogResult::Mask(Ok(mask)) => self.change_areas(ctx, AreaEdit::Load(mask)),
            DialogResult::Truth(Ok(truth)) => {
                let remark = truth.remark.clone();
                self.set_truth(ctx, truth);
                if let Some(remark) = remark {
                    self.toasts.warn(ctx, remark);
                }
            }
            DialogResult::External(Ok(results)) => self.set_external(ctx, results),
            DialogResult::TruthOffered(name, truth) => self.model.offer_truth(&name, truth),
            DialogResult::NoDialog => self.toasts.fail(
                ctx,
                "No file dialog available; install xdg-desktop-portal or zenity, drop a video on the \
                 window, or pass it on the command line",
            ),
            DialogResult::Table(Ok((text, rows))) => {
                ctx.copy_text(text);
                self.toasts.done(ctx, format!("Copied {rows} rows as CSV"));
            }
            DialogResult::Failed(why)
            | DialogResult::Plot(Err(why))
            | DialogResult::Table(Err(why))
            | DialogResult::Written(Err(why))
            | DialogResult::Settings(Err(why))
            | DialogResult::Sweep(Err(why))
            | DialogResult::Mask(Err(why))
            | DialogResult::Truth(Err(why))
            | DialogResult::External(Err(why)) => {
                self.toasts.fail(ctx, why);
            }
        }
    }

    /// Sets the ground truth, shows a message about it, and opens the mask-error view if it has masks.
    fn set_truth(&mut self, ctx: &Context, truth: Arc<Truth>) {
        let boxes = truth
            .boxes
            .as_ref()
            .map(|boxes| format!("boxes of {} frames, shown over the tracks", boxes.len()));
        let masks = truth
            .masks
            .as_ref()
            .map(|masks| format!("masks of {} frames, shown in Mask errors", masks.frames()));
        let parts: Vec<String> = boxes.into_iter().chain(masks).collect();
        if truth.masks.is_some() {
            views::set_open(&mut self.tree, View::MaskErrors, true);
        }
        self.model.set_truth(truth);
        self.toasts.done(ctx, format!("Loaded ground truth: {}", parts.join("; ")));
    }

    /// Sets the external results, shows a message about them, and opens the view that compares the masks if they have any.
    fn set_external(&mut self, ctx: &Context, results: Arc<ExternalResults>) {
        let boxes = results
            .boxes
            .as_ref()
            .map(|boxes| format!("boxes of {} frames, shown over the tracks", boxes.len()));
        let masks = results.masks.as_ref();
        let masks = masks.map(|masks| {
            format!("masks of {} frames, shown in {}", masks.frames(), View::ExternalAgreement.title())
        });
        let parts: Vec<String> =
            boxes.into_iter().chain(masks).chain(results.remarks.iter().cloned()).collect();
        if results.masks.is_some() {
            views::set_open(&mut self.tree, View::ExternalAgreement, true);
        }
        self.toasts.done(ctx, format!("Loaded {}: {}", results.name, parts.join("; ")));
        self.model.set_external(Some(results));
    }

    /// Executes an action of the inspector.
    pub(super) fn inspector_action(
        &mut self,
        ctx: &Context,
        action: InspectorAction,
        commands: &mut Vec<Command>,
    ) {
        match action {
            InspectorAction::GoTo(position) => commands.push(Command::GoTo(position)),
            InspectorAction::Apply(values) => {
                let mut settings = self.model.edits.settings.clone();
                // The map covers only values that the setting accepts.
                if values.iter().all(|&(setting, value)| setting.set(&mut settings, value).is_ok()) {
                    commands.push(Command::Set(Box::new(settings)));
                }
            }
            InspectorAction::Choose(at) => commands.push(Command::Choose(Some(at))),
            InspectorAction::Pin => commands.push(Command::Act(Action::Pin)),
            InspectorAction::LoadTruth => commands.push(Command::Act(Action::LoadTruthFolder)),
            InspectorAction::Unpin(number) => commands.push(Command::Unpin(number)),
            InspectorAction::Copy(table) => self.dialogs.run(ctx, move || {
                let failed = |error| format!("the table cannot be copied: {error}; save it instead");
                DialogResult::Table(table.csv().map(|text| (text, table.rows())).map_err(failed))
            }),
            InspectorAction::Save(table) => {
                let (name, kind) = (table.name(), ("CSV table", "csv"));
                self.dialogs.save(ctx, "Save table", name, kind, move |path| table.save(path));
            }
            InspectorAction::CopyPicture(plot) => self.dialogs.run(ctx, move || {
                DialogResult::Plot(plot.drawn().map(|picture| {
                    let size = [picture.size.width as usize, picture.size.height as usize];
                    ColorImage::from_rgb(size, &picture.rgb)
                }))
            }),
            InspectorAction::SavePicture(plot, format) => {
                let (name, kind) = (plot.name(format), (format.name(), format.ending()));
                self.dialogs.save(ctx, "Save figure", name, kind, move |path| plot.save(path, format));
            }
        }
    }
}
