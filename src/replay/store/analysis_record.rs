//! The record of every analysed frame: all results except images; masks are run-length encoded.

use std::ops::Range;
use std::sync::Arc;

use crate::frame::{Mask, Size};
use crate::pipeline::Analysis;
use crate::regions::rle;
use crate::regions::{Labels, Region};
use crate::tracking::{HypothesisSummary, Track};

/// The analyses of a sequence from its first frame on. Copies share the large parts.
#[derive(Clone)]
pub(crate) struct AnalysisRecord {
    size: Size,
    entries: Vec<RecordedFrame>,
    /// Size of the entries in memory, in bytes.
    bytes: usize,
    empty_mask: Arc<Mask>,
    empty_labels: Arc<Labels>,
}

#[derive(Clone)]
struct RecordedFrame {
    /// The analysis, with an empty mask and empty labels.
    analysis: Analysis,
    /// Its run-length encoded mask and labels.
    labels: Arc<[u8]>,
    /// The run-length encoded mask of the model, before cleaning.
    raw: Arc<[u8]>,
    foreground_share: f32,
}

impl RecordedFrame {
    fn bytes(&self) -> usize {
        let regions = self.analysis.regions.iter().map(Region::bytes).sum::<usize>();
        let tracks = self.analysis.tracks.len() + self.analysis.objects.len() + self.analysis.tentative.len();
        size_of::<Self>()
            + self.labels.len()
            + self.raw.len()
            + regions
            + tracks * size_of::<Track>()
            + self.analysis.objects.iter().map(|track| track.hypotheses.len()).sum::<usize>()
                * size_of::<HypothesisSummary>()
    }
}

impl AnalysisRecord {
    pub(crate) fn new(size: Size) -> Self {
        let none = Size::new(0, 0);
        Self {
            size,
            entries: Vec::new(),
            bytes: 0,
            empty_mask: Arc::new(Mask::empty(none)),
            empty_labels: Arc::new(Labels::none(none)),
        }
    }

    /// Number of frames on record.
    pub(crate) fn len(&self) -> u32 {
        self.entries.len() as u32
    }

    /// Adds the analysis of the next frame, and the model's mask before cleaning.
    pub(crate) fn push(&mut self, analysis: Analysis, raw: Box<[u8]>) {
        let entry = self.entry(analysis, raw.into());
        self.bytes += entry.bytes();
        self.entries.push(entry);
    }

    /// Approximate size in memory, in bytes; some kilobytes per frame.
    pub(crate) const fn bytes(&self) -> usize {
        self.bytes
    }

    /// Replaces the analysis of a frame after regions were found again; its model mask stays.
    pub(crate) fn replace_regions(&mut self, position: u32, analysis: Analysis) {
        let Some(raw) = self.entries.get(position as usize).map(|entry| Arc::clone(&entry.raw)) else {
            return;
        };
        let entry = self.entry(analysis, raw);
        self.change(position, |before| *before = entry);
    }

    /// Changes an entry and updates the size in memory.
    fn change(&mut self, position: u32, change: impl FnOnce(&mut RecordedFrame)) {
        if let Some(entry) = self.entries.get_mut(position as usize) {
            self.bytes -= entry.bytes();
            change(entry);
            self.bytes += entry.bytes();
        }
    }

    fn entry(&self, analysis: Analysis, raw: Arc<[u8]>) -> RecordedFrame {
        let labels = rle::encode_labels(&analysis.labels).into();
        let foreground_share = analysis.mask.foreground_share();
        let analysis = Analysis {
            mask: Arc::clone(&self.empty_mask),
            labels: Arc::clone(&self.empty_labels),
            ..analysis
        };
        RecordedFrame { analysis, labels, raw, foreground_share }
    }

    /// The model's mask of a frame, before cleaning.
    pub(crate) fn raw(&self, position: u32) -> Option<Mask> {
        self.entries.get(position as usize).map(|entry| rle::decode_mask(&entry.raw, self.size))
    }

    /// Calls `take` with the pixels of each run of the model's mask of a frame, before cleaning.
    pub(crate) fn for_each_raw_run(&self, position: u32, take: impl FnMut(Range<usize>)) {
        if let Some(entry) = self.entries.get(position as usize) {
            rle::for_each_run(&entry.raw, take);
        }
    }

    /// Calls `take` with the pixels of each run of foreground of a frame, after cleaning.
    pub(crate) fn for_each_run(&self, position: u32, take: impl FnMut(Range<usize>)) {
        if let Some(entry) = self.entries.get(position as usize) {
            rle::for_each_labelled_run(&entry.labels, take);
        }
    }

    /// Replaces the analysis of a frame except its mask and labels.
    pub(crate) fn replace(&mut self, position: u32, analysis: Analysis) {
        self.change(position, |entry| entry.analysis = analysis);
    }

    /// The analysis of a frame without its mask and labels.
    pub(crate) fn outline(&self, position: u32) -> Option<&Analysis> {
        self.entries.get(position as usize).map(|entry| &entry.analysis)
    }

    /// The share of foreground of a frame, 0..=1.
    pub(crate) fn foreground_share(&self, position: u32) -> Option<f32> {
        self.entries.get(position as usize).map(|entry| entry.foreground_share)
    }

    /// All analyses without their masks and labels.
    pub(crate) fn outlines(&self) -> impl Iterator<Item = &Analysis> {
        self.entries.iter().map(|entry| &entry.analysis)
    }

    /// The complete analysis of a frame.
    pub(crate) fn analysis(&self, position: u32) -> Option<Analysis> {
        let entry = self.entries.get(position as usize)?;
        let (mask, labels) = rle::decode_labels(&entry.labels, self.size);
        Some(Analysis { mask: Arc::new(mask), labels: Arc::new(labels), ..entry.analysis.clone() })
    }
}
