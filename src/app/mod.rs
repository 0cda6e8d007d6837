//! The window.
//!
//! `model` is the window's state. `views`, `inspector` and `panels` show it and return commands. `commands` is the
//! table of everything that has a name or a shortcut, and executes what changes only the model. `files` reads and
//! writes files. `window` holds all of them, and executes the other commands.

mod commands;
mod files;
mod icons;
pub mod inspector;
mod menu_item;
mod model;
mod panels;
mod views;
mod window;

pub mod theme;

#[cfg(test)]
mod dependencies;
#[cfg(test)]
mod golden;
#[cfg(test)]
mod measure;
#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui::{self, vec2};

use self::commands::command::Command;
use self::files::kept_state;
use self::model::areas::Areas;
use self::model::worker::PlayerFactory;
use self::window::Window;
use crate::export::staging;
use crate::regions::Roi;
use crate::replay::{AnalysisOptions, Session, Start};
use crate::settings::Settings;
use crate::source::Options;

/// The identifier of the program for the desktop, and the name of the folder of its state.
const APP_ID: &str = "occluscope";
/// The program's icon.
const ICON: &[u8] = include_bytes!("../../assets/occluscope.png");

/// The initial state of the window.
#[derive(Clone, Debug, Default)]
pub struct Opening {
    /// The video; `None` for the bundled sample at its first occlusion.
    pub video: Option<String>,
    /// The options of that video.
    pub options: Options,
    /// The initial settings.
    pub settings: Settings,
    /// The region of interest; `None` for the whole image.
    pub roi: Option<Arc<Roi>>,
    /// The path of the ground truth.
    pub truth: Option<PathBuf>,
    /// The memory limit for videos in bytes; `None` for a quarter of the machine's memory.
    pub memory: Option<usize>,
}

/// Opens the window and returns when it is closed.
/// Fails with a sentence when there is no display or no graphics adapter.
pub fn run(opening: Opening) -> anyhow::Result<()> {
    let Opening { video, options: of_video, settings, roi, truth, memory } = opening;
    let viewport = egui::ViewportBuilder::default()
        .with_title("Occluscope")
        .with_app_id(APP_ID)
        .with_icon(eframe::icon_data::from_png_bytes(ICON).unwrap_or_default())
        .with_inner_size(vec2(1600.0, 1000.0))
        .with_min_inner_size(vec2(800.0, 560.0));
    let options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    let first = match video {
        Some(video) => Command::Open(video, Start::First),
        None => Command::OpenSample,
    };
    let state = kept_state::folder(APP_ID);
    if let Some(folder) = &state {
        kept_state::restore(folder);
    }
    let create = move |creation: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        let gpu = creation.wgpu_render_state.as_ref().ok_or("no graphics adapter")?;
        let mut window = Window::new(&creation.egui_ctx, gpu, settings, open_sessions(memory))?;
        window.restore(&creation.egui_ctx, creation.storage);
        window.state_folder = state;
        window.model.edits.areas = Areas::of_mask(roi);
        if let Command::Open(name, _) = &first
            && !of_video.is_default()
        {
            window.model.videos.command_line = Some((name.clone(), of_video));
        }
        window.apply(&creation.egui_ctx, first);
        if let Some(truth) = truth {
            window.apply(&creation.egui_ctx, Command::ReadTruth(truth));
        }
        Ok(Box::new(window))
    };
    let closed = eframe::run_native("occluscope", options, Box::new(create)).map_err(|error| explain(&error));
    // Files that threads are still writing stay incomplete.
    staging::remove_all();
    closed
}

/// A factory of sessions that stay within a memory limit in bytes.
fn open_sessions(memory: Option<usize>) -> PlayerFactory {
    Box::new(move |name, options, (settings, roi), start, ctx| {
        let ctx = ctx.clone();
        let analysis = AnalysisOptions { settings, roi };
        Box::new(Session::open(name, options, analysis, start, memory, move || ctx.request_repaint()))
    })
}

/// The reason why the window cannot open, in one line. The libraries' messages name their source files.
fn explain(error: &eframe::Error) -> anyhow::Error {
    match error {
        eframe::Error::Wgpu(_) => anyhow::anyhow!(
            "the window cannot be opened: no usable graphics adapter; install a Vulkan or OpenGL driver \
             (mesa-vulkan-drivers works without a graphics card), or use a command that needs no window"
        ),
        eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => anyhow::anyhow!(
            "the window cannot be opened: no display is reachable; check DISPLAY or WAYLAND_DISPLAY, or \
             use a command that needs no window"
        ),
        other @ eframe::Error::AppCreation(_) => {
            anyhow::anyhow!("the window cannot be opened: {}", other.to_string().replace('\n', " "))
        }
    }
}
