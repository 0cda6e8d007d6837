//! The thread that uploads frames to the graphics card, and the frame in view.
//!
//! The window's thread requests a frame and does not wait. The frame comes into view, in all views at once, when all
//! of its layers are uploaded.

use std::io;
use std::sync::mpsc;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use eframe::egui::Context;
use eframe::egui_wgpu::{RenderState, wgpu};

use super::composer::Composer;
use super::contents::content;
use super::layer::{self, LayerSet, ViewLayer};
use super::layer_upload::{LayerUploader, UploadedLayers};
use super::mask_agreement::MaskAgreement;
use super::uploaded_frame::UploadedFrame;
use crate::app::model::trails::FrameWithTrails;
use crate::app::model::view::{BackgroundDisplay, View};

/// A request to the upload thread.
#[derive(Clone)]
struct UploadRequest {
    frame: Arc<FrameWithTrails>,
    layers: LayerSet,
    /// The index of its video. Late results of a previous video are not shown.
    video: u32,
}

/// The uploaded frame that waits for the window; a newer one replaces it.
type UploadSlot = Arc<Mutex<Option<UploadedFrame>>>;

/// The window's side of the upload.
pub(crate) struct FrameUploads {
    composer: Arc<Composer>,
    requests: Option<mpsc::Sender<UploadRequest>>,
    ready: UploadSlot,
    thread: Option<JoinHandle<()>>,
    asked: Option<UploadRequest>,
    video: u32,
    layers: LayerSet,
    in_view: Option<Arc<UploadedFrame>>,
}

impl FrameUploads {
    /// Starts the thread. It wakes the window when a frame is uploaded.
    pub(crate) fn start(ctx: &Context, gpu: &RenderState) -> io::Result<Self> {
        let composer = Arc::new(Composer::new(gpu));
        let (requests, received) = mpsc::channel();
        let ready = UploadSlot::default();
        let worker = UploadThread {
            sender: LayerUploader::new(gpu.device.clone(), gpu.queue.clone()),
            device: gpu.device.clone(),
            composer: Arc::clone(&composer),
            ready: Arc::clone(&ready),
            ctx: ctx.clone(),
        };
        let thread = thread::Builder::new().name("pictures".into()).spawn(move || worker.work(&received))?;
        Ok(Self {
            composer,
            requests: Some(requests),
            ready,
            thread: Some(thread),
            asked: None,
            video: 0,
            layers: first_layers(),
            in_view: None,
        })
    }

    /// The composer of the views.
    pub(crate) const fn composer(&self) -> &Arc<Composer> {
        &self.composer
    }

    /// The frame in view.
    pub(crate) const fn in_view(&self) -> Option<&Arc<UploadedFrame>> {
        self.in_view.as_ref()
    }

    /// Sets the layers that the views need.
    pub(crate) const fn set_layers(&mut self, layers: LayerSet) {
        self.layers = layers;
    }

    /// Whether a map is visible.
    pub(crate) const fn shows_map(&self) -> bool {
        self.layers.has(ViewLayer::Map)
    }

    /// Requests a frame, unless it was requested last.
    pub(crate) fn request(&mut self, frame: &Arc<FrameWithTrails>) {
        let (layers, video) = (self.layers, self.video);
        let known = self.asked.as_ref().is_some_and(|asked| {
            Arc::ptr_eq(&asked.frame, frame) && asked.layers.covers(layers) && asked.video == video
        });
        if known {
            return;
        }
        let request = UploadRequest { frame: Arc::clone(frame), layers, video };
        if let Some(requests) = &self.requests {
            // Sending fails if the thread has ended, which `has_failed` reports.
            let _ = requests.send(request.clone());
        }
        self.asked = Some(request);
    }

    /// Brings the latest uploaded frame into view. Returns whether there was one.
    pub(crate) fn show_latest(&mut self) -> bool {
        let set = self.ready.lock().unwrap_or_else(PoisonError::into_inner).take();
        let set = set.filter(|set| set.video == self.video);
        let turned = set.is_some();
        if let Some(set) = set {
            self.in_view = Some(Arc::new(set));
        }
        turned
    }

    /// Whether the last requested frame is in view.
    #[cfg(test)]
    pub(crate) fn is_settled(&self) -> bool {
        self.asked.as_ref().is_none_or(|asked| {
            self.in_view.as_ref().is_some_and(|set| {
                let missing = |&layer: &ViewLayer| {
                    asked.layers.has(layer) && layer.is_in(&asked.frame.shown) && !set.has(layer)
                };
                Arc::ptr_eq(&set.frame, &asked.frame) && !ViewLayer::ALL.iter().any(missing)
            })
        })
    }

    /// Whether the thread has ended unexpectedly.
    pub(crate) fn has_failed(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// Drops the frame in view, for another video.
    pub(crate) fn clear(&mut self) {
        self.video += 1;
        self.in_view = None;
        self.asked = None;
    }
}

/// The layers of the initially open views, so that the first frame is complete.
fn first_layers() -> LayerSet {
    let mut layers = LayerSet::NONE;
    // A map is computed only once its view is visible.
    for view in View::ALL.into_iter().filter(|&view| view != View::Map) {
        layers.add(content(view).layers(BackgroundDisplay::Mean));
    }
    layers.add(&[ViewLayer::Ignored]);
    layers
}

impl Drop for FrameUploads {
    fn drop(&mut self) {
        // The process must not end while the thread is inside the graphics driver.
        self.requests = None;
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

/// The thread's side of the upload.
struct UploadThread {
    sender: LayerUploader,
    device: wgpu::Device,
    composer: Arc<Composer>,
    ready: UploadSlot,
    ctx: Context,
}

impl UploadThread {
    fn work(mut self, requests: &mpsc::Receiver<UploadRequest>) {
        let mut last: Option<(Arc<FrameWithTrails>, u32, UploadedLayers)> = None;
        while let Ok(mut request) = requests.recv() {
            while let Ok(newer) = requests.try_recv() {
                request = newer;
            }
            let started = Instant::now();
            let shown = &request.frame.shown;
            let every = layer::thinning(shown.frame.size, self.device.limits().max_texture_dimension_2d);
            let known = |layer: ViewLayer| {
                let (before, thinned, uploaded) = last.as_ref()?;
                let sent = uploaded[layer as usize].as_ref()?;
                (*thinned == every && layer.is_same(&before.shown, shown)).then(|| Arc::clone(sent))
            };
            let Ok((uploaded, bytes)) = self.sender.send(shown, request.layers, every, known) else { return };
            let view = |layer: ViewLayer| uploaded[layer as usize].as_ref().map(|sent| &sent.view);
            let compared = shown.compared.as_ref().filter(|_| request.layers.has(ViewLayer::ComparedMask));
            let agreement =
                compared.map(|compared| MaskAgreement::of(&shown.analysis.mask, &compared.analysis.mask));
            let truth = shown.truth.as_ref().filter(|_| request.layers.has(ViewLayer::Truth));
            let decisions = truth.map(|truth| truth.score(&shown.analysis.mask));
            let external = shown.external.as_ref().filter(|_| request.layers.has(ViewLayer::External));
            let external_agreement =
                external.map(|mask| MaskAgreement::from(mask.score(&shown.analysis.mask)));
            let external_decisions = truth.zip(external).map(|(truth, mask)| truth.score_labels(mask));
            let set = UploadedFrame {
                agreement,
                decisions,
                external_agreement,
                external_decisions,
                group: self.composer.bind(&self.device, view),
                frame: Arc::clone(&request.frame),
                video: request.video,
                every,
                took: started.elapsed(),
                bytes,
                uploaded: uploaded.clone(),
            };
            last = Some((request.frame, every, uploaded));
            *self.ready.lock().unwrap_or_else(PoisonError::into_inner) = Some(set);
            self.ctx.request_repaint();
        }
    }
}
