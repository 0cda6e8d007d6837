//! A measurement of the window thread's time for each frame. It is run by hand and is not a test.
//!
//! `cargo test --release --locked --lib -- --ignored --nocapture the_windows_own_work`
//!
//! The drawing time of the software adapter is shown in brackets: it is not part of this thread's work, though it
//! slows it down.

#![allow(clippy::unwrap_used)]

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, Rect, Theme, vec2};
use eframe::egui_wgpu::{RendererOptions, ScreenDescriptor, wgpu};
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};

use crate::app::Window;
use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::model::player::Player;
use crate::export::tests::track;
use crate::frame::{Frame, Mask, Size};
use crate::occlusion::Counters;
use crate::pipeline::Analysis;
use crate::regions::{self, Labels, Region, Shape};
use crate::replay::{Phase, Request, ShownFrame, Start, State, Timeline};
use crate::settings::Settings;
use crate::source::SourceInfo;
use crate::tracking::Track;

const SIZE: Size = Size::new(1920, 1080);
const FRAMES: u32 = 10_000;
const WINDOW: (f32, f32) = (2560.0, 1440.0);
/// The number of prepared frames; consecutive frames differ in every layer.
const PREPARED: u32 = 6;
const WARM_UP: usize = 70;
const MEASURED: usize = 120;

/// A worker with all frames ready.
struct ReadyPlayer {
    frames: Rc<Vec<ShownFrame>>,
    state: RefCell<State>,
}

impl Player for ReadyPlayer {
    fn state(&self) -> State {
        self.state.borrow().clone()
    }

    fn request(&self, request: Request) {
        if let Request::Show(position) = request {
            let frames = &self.frames;
            let shown = ShownFrame { position, ..frames[position as usize % frames.len()].clone() };
            self.state.borrow_mut().shown = Some(Arc::new(shown));
        }
    }

    fn leave(self: Box<Self>) {}
}

/// A frame with `count` people who walk in rows across the image.
fn shown_at(position: u32, count: u32) -> ShownFrame {
    let columns = (count as f32).sqrt().ceil() as u32;
    let (step_x, step_y) = (SIZE.width / columns, SIZE.height / columns.max(count.div_ceil(columns)));
    let (w, h) = ((step_x / 3).min(60), (step_y * 2 / 3).min(150));
    let noise =
        |x: u32, y: u32, salt: u32| ((x * 7 + y * 13 + salt * 31).wrapping_mul(2_654_435_761) >> 24) as u8;
    let colours = |salt: u32| {
        let pixel = |y: u32, x: u32| {
            let n = noise(x, y, salt) / 16;
            [(x / 16) as u8 / 2 + n, (y / 8) as u8 / 2 + n, 90 + n]
        };
        (0..SIZE.height).flat_map(|y| (0..SIZE.width).flat_map(move |x| pixel(y, x))).collect::<Vec<u8>>()
    };
    let (mut mask, mut labels) = (Mask::empty(SIZE), vec![0; SIZE.pixels()]);
    let (mut regions, mut tracks) = (Vec::new(), Vec::new());
    for id in 1..=count {
        let (left, top) = ((id - 1) % columns * step_x + position % 20, (id - 1) / columns * step_y);
        for y in top..top + h {
            for x in left..left + w {
                let at = SIZE.index(x, y).unwrap();
                mask.data[at] = Mask::FOREGROUND;
                labels[at] = id;
            }
        }
        let bbox = regions::Rect::new(left as f32, top as f32, w as f32, h as f32);
        let centre = [bbox.x + bbox.w / 2.0, bbox.y + bbox.h / 2.0];
        let shape = Shape { area: w * h, bbox, centroid: centre, ..Shape::default() };
        let histogram = regions::Histogram::default();
        regions.push(Region { label: id, shape, colour: [180, 90, 70], histogram, mosaic: Arc::default() });
        tracks.push(Track {
            bbox,
            centre,
            gate: [24.0, 14.0, 0.3],
            regions: vec![id],
            ..track(id, bbox.x, bbox.y)
        });
    }
    let picture = |salt| Arc::new(Frame::new(position + 1, SIZE, colours(salt)));
    ShownFrame {
        position,
        settings: Arc::new(Settings::default()),
        roi: None,
        frame: picture(position + 1),
        analysis: Arc::new(Analysis {
            number: position + 1,
            time: f64::from(position) / 30.0,
            t: position + 1,
            mask: Arc::new(mask),
            labels: Arc::new(Labels::of_image(SIZE, &labels)),
            regions: Arc::new(regions),
            tracks: Arc::new(tracks),
            tentative: Arc::default(),
            objects: Arc::default(),
            events: Arc::default(),
            settled: Arc::default(),
            counters: Counters::default(),
        }),
        background: picture(0),
        multi_mode: Some(picture(0)),
        map: None,
        pixel: None,
        truth: None,
        external: None,
        compared: None,
    }
}

fn ready(frames: Rc<Vec<ShownFrame>>) -> ReadyPlayer {
    let info = SourceInfo {
        name: "crowd.mp4".into(),
        size: SIZE,
        pixel_aspect: None,
        fps: 30.0,
        fps_from: crate::source::FpsFrom::Video,
        frames: Some(FRAMES),
        live: false,
        reduction: None,
    };
    let timeline = Timeline { numbers: (1..=FRAMES).collect(), complete: true, ..Timeline::default() };
    let state = State {
        phase: Phase::Ready,
        info: Some(Arc::new(info)),
        shown: Some(Arc::new(frames[0].clone())),
        timeline: Arc::new(timeline),
        ..State::default()
    };
    ReadyPlayer { frames, state: RefCell::new(state) }
}

/// The CPU time of this thread, without other threads and processes.
#[cfg(unix)]
fn ran() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Elapsed time, where the CPU time is not available.
#[cfg(not(unix))]
fn ran() -> Duration {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    START.elapsed()
}

/// Minimum, median, 95th percentile and maximum, in milliseconds.
fn spread(took: &mut [Duration]) -> String {
    took.sort_unstable();
    let at = |share: f32| took[((took.len() - 1) as f32 * share) as usize].as_secs_f64() * 1e3;
    format!("{:6.2} {:6.2} {:6.2} {:6.2}", at(0.0), at(0.5), at(0.95), at(1.0))
}

#[test]
#[ignore = "a measurement"]
fn the_windows_own_work() {
    println!("ms a pass, five views of {SIZE} in a window of {}×{}: min median 95% max", WINDOW.0, WINDOW.1);
    for count in [5, 300] {
        measure(count);
    }
}

fn measure(count: u32) {
    let frames: Rc<Vec<ShownFrame>> =
        Rc::new((0..PREPARED).map(|position| shown_at(position, count)).collect());
    let gpu = create_render_state(default_wgpu_setup(), RendererOptions::default());
    let ctx = egui::Context::default();
    ctx.set_theme(Theme::Dark);
    let opener = move |_: &str,
                       _: crate::source::Options,
                       _: (Settings, Option<Arc<regions::Roi>>),
                       _: Start,
                       _: &egui::Context|
          -> Box<dyn Player> { Box::new(ready(frames.clone())) };
    let mut window = Window::new(&ctx, &gpu, Settings::default(), Box::new(opener)).unwrap();
    window.apply(&ctx, Command::Open("crowd.mp4".into(), Start::First));
    let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: WINDOW.0 as u32, height: WINDOW.1 as u32, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: gpu.target_format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let target = target.create_view(&wgpu::TextureViewDescriptor::default());
    let screen =
        ScreenDescriptor { size_in_pixels: [WINDOW.0 as u32, WINDOW.1 as u32], pixels_per_point: 1.0 };

    let start = Instant::now();
    let (mut ui, mut tessellation, mut upload) = (vec![], vec![], vec![]);
    let (mut all, mut waited, mut shown) = (vec![], vec![], vec![]);
    for pass in 0..WARM_UP + MEASURED {
        if pass == 5 {
            window.apply(&ctx, Command::Act(Action::Play));
        }
        let (began, before_ui) = (Instant::now(), ran());
        let input = egui::RawInput {
            time: Some(start.elapsed().as_secs_f64()),
            screen_rect: Some(Rect::from_min_size(egui::Pos2::ZERO, vec2(WINDOW.0, WINDOW.1))),
            max_texture_side: Some(8192),
            ..egui::RawInput::default()
        };
        let output = ctx.run_ui(input, |ui| {
            window.advance(ui.ctx());
            window.show(ui);
        });
        let after_ui = ran();
        let jobs = ctx.tessellate(output.shapes, 1.0);
        let after_tessellation = ran();
        let mut renderer = gpu.renderer.write();
        for (id, images) in &output.textures_delta.set {
            for image in images {
                renderer.update_texture(&gpu.device, &gpu.queue, *id, image);
            }
        }
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let buffers = renderer.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &jobs, &screen);
        let (after_upload, by_the_clock) = (ran(), began.elapsed());
        {
            let attachment = wgpu::RenderPassColorAttachment {
                view: &target,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
                depth_slice: None,
            };
            let descriptor = wgpu::RenderPassDescriptor {
                color_attachments: &[Some(attachment)],
                ..wgpu::RenderPassDescriptor::default()
            };
            let mut pass = encoder.begin_render_pass(&descriptor).forget_lifetime();
            renderer.render(&mut pass, &jobs, &screen);
        }
        gpu.queue.submit(buffers.into_iter().chain([encoder.finish()]));
        drop(renderer);
        let drawing = Instant::now();
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let drawn = drawing.elapsed();
        let mut deltas = output.textures_delta;
        deltas.clear();
        std::thread::sleep(Duration::from_millis(33).saturating_sub(began.elapsed()));
        if pass >= WARM_UP {
            ui.push(after_ui.saturating_sub(before_ui));
            tessellation.push(after_tessellation.saturating_sub(after_ui));
            upload.push(after_upload.saturating_sub(after_tessellation));
            all.push(after_upload.saturating_sub(before_ui));
            waited.push(by_the_clock);
            shown.push(drawn);
        }
    }
    let position = window.model.worker.shown().unwrap().position;
    println!("{count} objects, {position} frames seen");
    for (what, took) in [
        ("logic and ui", &mut ui),
        ("tessellation", &mut tessellation),
        ("textures and buffers", &mut upload),
        ("together", &mut all),
        ("by the clock", &mut waited),
        ("(drawing, waited for)", &mut shown),
    ] {
        println!("  {what:22} {}", spread(took));
    }
}
