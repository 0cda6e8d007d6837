//! The pipeline: all stages of the analysis, from a [`Frame`] to its [`Analysis`]; [`offline_result`] applies later
//! decisions to the analyses of a sequence.

mod background_subtractor;
mod offline;
mod region_finder;
mod segmentation;

use std::sync::Arc;

pub use self::offline::{OfflineResult, offline_result};

pub(crate) use self::background_subtractor::BackgroundSubtractor;
pub(crate) use self::offline::{LateDecisions, TrackedFrame, offline_result_of};
pub(crate) use self::region_finder::RegionFinder;
use self::segmentation::Segmentation;
pub(crate) use self::segmentation::SegmentedFrame;
use crate::frame::{Frame, Mask, Size};
use crate::mixture::Mixture;
use crate::occlusion::{Counters, Event, FinalResult, SettledResults, Tracker};
use crate::regions::roi::RoiError;
use crate::regions::{Labels, Region, Roi};
use crate::settings::Settings;
use crate::tracking::Track;

/// An error of the analysis of a frame.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// An error of OpenCV.
    #[error("OpenCV failed on frame {frame}: {source}")]
    Opencv {
        /// The frame's number, 0 before the first.
        frame: u32,
        /// OpenCV's error.
        source: opencv::Error,
    },
    /// A frame of another size than the previous ones.
    #[error("frame {frame} is {found}, expected {expected}; all frames must have the same size")]
    Size {
        /// The frame's number.
        frame: u32,
        /// Its size.
        found: Size,
        /// The size of the previous frames.
        expected: Size,
    },
    /// The region of interest has another size than the frames.
    #[error(transparent)]
    Roi(#[from] RoiError),
}

/// The results of all stages for one frame: the online result, as known at that frame.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The frame number in the source.
    pub number: u32,
    /// The frame's time in seconds since the source's first frame.
    pub time: f64,
    /// The frame's index among the classified ones, from 1.
    pub t: u32,
    /// The foreground in which regions were found: after cleaning, before `min_area`.
    pub mask: Arc<Mask>,
    /// The region of each pixel.
    pub labels: Arc<Labels>,
    /// The regions, by label.
    pub regions: Arc<Vec<Region>>,
    /// The confirmed objects.
    pub tracks: Arc<Vec<Track>>,
    /// The tentative objects (`id` 0).
    pub tentative: Arc<Vec<Track>>,
    /// All objects by their track keys, for the offline result.
    pub objects: Arc<Vec<Track>>,
    /// The events decided in this frame; some happened a few frames earlier.
    pub events: Arc<Vec<Event>>,
    /// Other results about earlier frames that became final in this frame.
    pub settled: Arc<SettledResults>,
    /// All events decided up to this frame, by kind.
    pub counters: Counters,
}

/// The stages with their state, ready for the next frame.
///
/// Methods that process frames fail if a frame has another size than the pipeline, or if OpenCV fails.
///
/// # Examples
/// An object of 8 × 16 pixels moves over a grey background from frame 2 on. The preset `plain` has no bootstrap, so
/// that frame 1 is the background:
///
/// ```
/// use occluscope::frame::{Frame, Size};
/// use occluscope::occlusion::EventKind;
/// use occluscope::pipeline::{Pipeline, offline_result};
/// use occluscope::regions::Rect;
/// use occluscope::settings::{Preset, Settings};
///
/// let size = Size::new(64, 48);
/// let frame = |number: u32| {
///     let mut rgb = vec![100; 3 * size.pixels()];
///     for y in (16..32).filter(|_| number >= 2) {
///         let start = 64 * y + 4 + 2 * number as usize;
///         rgb[3 * start..3 * (start + 8)].fill(220);
///     }
///     Frame::new(number, size, rgb)
/// };
/// let mut pipeline = Pipeline::new(&Settings::preset(Preset::Plain), size, 25.0)?;
/// let analyses = (1..=13).map(|number| pipeline.step(&frame(number))).collect::<Result<Vec<_>, _>>()?;
/// assert_eq!(analyses[0].mask.foreground_pixels(), 0);
/// assert_eq!(analyses[3].regions[0].shape.bbox, Rect::new(12.0, 16.0, 8.0, 16.0));
///
/// let result = offline_result(&analyses, &pipeline);
/// let frame = &result.tracks[12];
/// assert_eq!(frame.number, 13);
/// assert_eq!((frame.tracks[0].id, frame.tracks[0].bbox), (1, Rect::new(30.0, 16.0, 8.0, 16.0)));
/// assert_eq!((result.events[0].frame, result.events[0].kind), (2, EventKind::Appear));
/// # Ok::<(), occluscope::pipeline::PipelineError>(())
/// ```
pub struct Pipeline {
    segmentation: Segmentation,
    tracking: Tracking,
}

/// The stages from tracking on with their state.
#[derive(Clone)]
struct Tracking {
    /// Number of frames so far.
    t: u32,
    tracker: Tracker,
}

impl Tracking {
    fn new(settings: &Settings, size: Size, fps: f32) -> Self {
        Self { t: 0, tracker: Tracker::new(settings, size, fps) }
    }

    /// Tracks the objects of the next frame and decides its events, from its regions.
    fn step(&mut self, found: SegmentedFrame) -> Analysis {
        let SegmentedFrame { number, time, mask, labels, regions } = found;
        self.t += 1;
        let result = self.tracker.step(number, time, &regions);
        Analysis {
            number,
            time,
            t: self.t,
            mask,
            labels,
            regions,
            tracks: Arc::new(result.tracks),
            tentative: Arc::new(result.tentative),
            objects: Arc::new(result.objects),
            events: Arc::new(result.events),
            settled: Arc::new(result.settled),
            counters: self.tracker.counters(),
        }
    }

    fn step_many(&mut self, found: Vec<SegmentedFrame>) -> Vec<Analysis> {
        found.into_iter().map(|found| self.step(found)).collect()
    }
}

impl Pipeline {
    /// The stages before the first frame, for frames of `size` at `fps` frames per second. Fails only if OpenCV cannot
    /// create MOG2 or KNN.
    pub fn new(settings: &Settings, size: Size, fps: f32) -> Result<Self, PipelineError> {
        let (segmentation, tracking) =
            (Segmentation::new(settings, size)?, Tracking::new(settings, size, fps));
        Ok(Self { segmentation, tracking })
    }

    /// Sets the region of interest from the next frame on, `None` for the whole image: foreground outside it is
    /// removed before cleaning. The model still learns every pixel. Fails if the mask has another size than the
    /// frames.
    pub fn set_roi(&mut self, roi: Option<Arc<Roi>>) -> Result<(), PipelineError> {
        roi.as_ref().map_or(Ok(()), |roi| roi.check(self.segmentation.size()))?;
        self.segmentation.region_finder.roi = roi;
        Ok(())
    }

    /// Lets only the model learn from frames before the first step: those of [`Settings::bootstrap`], which are
    /// classified afterwards.
    pub fn learn(&mut self, frames: &[&Frame]) -> Result<(), PipelineError> {
        self.segmentation.learn(frames)
    }

    /// Starts classification with the learned model after the last frame to learn from. Needed only to read the model
    /// before the first step, which otherwise does the same.
    pub fn begin(&mut self) {
        self.segmentation.model.begin();
    }

    /// Processes the next frame in all stages.
    pub fn step(&mut self, frame: &Frame) -> Result<Analysis, PipelineError> {
        let mut analyses = self.step_many(&[frame])?;
        // One frame gives one analysis.
        Ok(analyses.swap_remove(0))
    }

    /// Processes the next frames in all stages, in order: equal to [`Self::step`] frame by frame but faster, because
    /// most of the work on a frame is independent of the previous one.
    pub fn step_many(&mut self, frames: &[&Frame]) -> Result<Vec<Analysis>, PipelineError> {
        let found = self.segmentation.step_many(frames)?;
        Ok(self.tracking.step_many(found))
    }

    /// Processes the next frames in the stages before tracking, and at the same time `segmented`, the result for the frames
    /// before them, in the other stages. Together, calls equal [`Self::step_many`]; the first has nothing segmented, and the
    /// last no frames. Until then the model is ahead of the tracks, and no other method may process frames. On an error the
    /// analyses of `segmented` are lost.
    pub(crate) fn step_staggered(
        &mut self,
        segmented: Vec<SegmentedFrame>,
        frames: &[&Frame],
    ) -> Result<(Vec<Analysis>, Vec<SegmentedFrame>), PipelineError> {
        let Self { segmentation, tracking } = self;
        let (analyses, next) =
            rayon::join(|| tracking.step_many(segmented), || segmentation.step_many(frames));
        Ok((analyses, next?))
    }

    /// The model's masks of the next frames, before cleaning: the first stage only. Each has to be passed to
    /// [`Self::analyse_masks`].
    pub fn masks(&mut self, frames: &[&Frame]) -> Result<Vec<Mask>, PipelineError> {
        self.segmentation.masks(frames)
    }

    /// Processes frames in all stages after the model: `raw` is the mask of each frame, from [`Self::masks`] or from
    /// another segmentation. Frames and masks have the size of the pipeline.
    pub fn analyse_masks(
        &mut self,
        frames: &[&Frame],
        raw: Vec<Mask>,
    ) -> Result<Vec<Analysis>, PipelineError> {
        let found = self.segmentation.regions(frames, raw)?;
        Ok(self.tracking.step_many(found))
    }

    /// Restarts the stages after the model under `settings`, which must be the same for the model. Frames then pass
    /// through [`Self::analyse_masks`] in order, with the model's masks.
    pub fn restart_after_model(&mut self, settings: &Settings, fps: f32) {
        let finder = &mut self.segmentation.region_finder;
        *finder = RegionFinder::new(settings, finder.roi.take());
        self.restart_tracking(settings, fps);
    }

    /// Restarts tracking under `settings`, which may differ only in tracking and occlusion; the model and the other
    /// stages before tracking are unchanged.
    pub fn restart_tracking(&mut self, settings: &Settings, fps: f32) {
        self.tracking = Tracking::new(settings, self.segmentation.size(), fps);
    }

    /// Processes the regions of an analysed frame in tracking and occlusion only, after [`Self::restart_tracking`]
    /// and in the order of frames.
    pub fn track_again(&mut self, analysis: &Analysis) -> Analysis {
        let Analysis { number, time, mask, labels, regions, .. } = analysis.clone();
        self.tracking.step(SegmentedFrame { number, time, mask, labels, regions })
    }

    /// What is decided if the last frame was the last of the sequence. The pipeline may continue.
    pub(crate) fn decide_pending(&self) -> FinalResult {
        self.tracking.tracker.clone().finish()
    }

    /// The model's background: the mean of component 1, or the background image of MOG2 or KNN; RGB bytes in row
    /// order.
    pub fn background_image(&self) -> Result<Vec<u8>, PipelineError> {
        self.segmentation.model.background_image()
    }

    /// The mixture; `None` with MOG2 or KNN.
    pub const fn mixture(&self) -> Option<&Mixture> {
        self.segmentation.model.mixture()
    }

    /// A copy of the current state; `None` for MOG2 and KNN, whose state cannot be copied.
    pub fn try_clone(&self) -> Option<Self> {
        Some(Self { segmentation: self.segmentation.try_clone()?, tracking: self.tracking.clone() })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::export::tests::track;
    use crate::occlusion::{Episode, EpisodeKind, EventKind, Evidence};
    use crate::regions::Rect;
    use crate::settings::Preset;

    const SIZE: Size = Size::new(64, 48);

    fn pipeline() -> Pipeline {
        Pipeline::new(&Settings::preset(Preset::Plain), SIZE, 25.0).unwrap()
    }

    fn frame(number: u32) -> Frame {
        Frame::new(number, SIZE, vec![100; SIZE.pixels() * 3])
    }

    /// A mask with a foreground of 8 by 16 pixels with its upper left corner at (x, 16).
    fn mask(x: u32) -> Mask {
        let mut mask = Mask::empty(SIZE);
        for (column, row) in (16..32).flat_map(|row| (x..x + 8).map(move |column| (column, row))) {
            mask.data[SIZE.index(column, row).unwrap()] = Mask::FOREGROUND;
        }
        mask
    }

    /// The analyses of a foreground that moves to the right by two pixels a frame from x = 8 on.
    fn moving_foreground(pipeline: &mut Pipeline, frames: u32) -> Vec<Analysis> {
        let frames: Vec<Frame> = (1..=frames).map(frame).collect();
        let masks = (0..frames.len()).map(|at| mask(8 + 2 * at as u32)).collect();
        pipeline.analyse_masks(&frames.iter().collect::<Vec<_>>(), masks).unwrap()
    }

    /// The analysis of a frame with these tracks and nothing else.
    fn analysis(number: u32, objects: Vec<Track>) -> Analysis {
        let mut found = pipeline().analyse_masks(&[&frame(number)], vec![Mask::empty(SIZE)]).unwrap();
        Analysis { objects: Arc::new(objects), ..found.swap_remove(0) }
    }

    fn event(frame: u32, kind: EventKind, objects: &[u32]) -> Event {
        Event { objects: objects.to_vec(), ..Event::of_one(frame, kind, 0, [0.0; 2], Evidence::default()) }
    }

    #[test]
    fn a_moving_foreground_is_a_region_in_every_frame_and_an_object_in_the_offline_result() {
        let mut pipeline = pipeline();
        let analyses = moving_foreground(&mut pipeline, 12);
        assert_eq!(analyses.iter().map(|it| it.t).collect::<Vec<_>>(), (1..=12).collect::<Vec<_>>());
        assert_eq!(analyses[3].regions[0].shape.bbox, Rect::new(14.0, 16.0, 8.0, 16.0));
        assert!(analyses[3].tracks.is_empty(), "it is tentative");
        assert_eq!(analyses[11].counters.appear, 1);
        let offline = offline_result(&analyses, &pipeline);
        let boxes: Vec<_> =
            offline.tracks.iter().map(|frame| (frame.tracks[0].id, frame.tracks[0].bbox.x)).collect();
        assert_eq!(boxes, (0..12).map(|at| (1, 8.0 + 2.0 * at as f32)).collect::<Vec<_>>());
    }

    #[test]
    fn staggered_steps_equal_steps() {
        let frames: Vec<Frame> = (1..=20)
            .map(|number| {
                let mut frame = frame(number);
                for y in (16..32).filter(|_| number >= 2) {
                    let start = 64 * y + 4 + 2 * number as usize;
                    frame.rgb[3 * start..3 * (start + 8)].fill(220);
                }
                frame
            })
            .collect();
        let frames: Vec<&Frame> = frames.iter().collect();
        let expected = pipeline().step_many(&frames).unwrap();
        assert_eq!(expected.last().unwrap().counters.appear, 1);

        let (mut pipeline, mut found, mut analyses) = (pipeline(), Vec::new(), Vec::new());
        for batch in [&frames[..7], &frames[7..8], &frames[8..], &[]] {
            let (tracked, next) = pipeline.step_staggered(found, batch).unwrap();
            analyses.extend(tracked);
            found = next;
        }
        assert!(found.is_empty());
        assert_eq!(analyses.len(), expected.len());
        for (found, expected) in analyses.iter().zip(&expected) {
            assert_eq!((found.number, found.t), (expected.number, expected.t));
            assert_eq!((&found.objects, &found.events), (&expected.objects, &expected.events));
        }
    }

    #[test]
    fn tracking_again_under_the_same_settings_gives_the_same() {
        let mut pipeline = pipeline();
        let analyses = moving_foreground(&mut pipeline, 12);
        pipeline.restart_tracking(&Settings::preset(Preset::Plain), 25.0);
        for analysis in &analyses {
            let again = pipeline.track_again(analysis);
            assert_eq!(
                (again.t, &again.tracks, &again.events),
                (analysis.t, &analysis.tracks, &analysis.events)
            );
        }
    }

    #[test]
    fn foreground_outside_the_region_of_interest_is_no_region() {
        let mut pipeline = pipeline();
        pipeline.set_roi(Roi::new(mask(40)).map(Arc::new)).unwrap();
        let masks = vec![mask(8), mask(36)];
        let found = pipeline.analyse_masks(&[&frame(1), &frame(2)], masks).unwrap();
        assert!(found[0].regions.is_empty());
        assert_eq!(found[1].regions[0].shape.bbox, Rect::new(40.0, 16.0, 4.0, 16.0));
    }

    #[test]
    fn a_frame_of_another_size_is_an_error() {
        let other = Frame::new(7, Size::new(2, 2), vec![0; 12]);
        let error = pipeline().step(&other).unwrap_err();
        assert!(matches!(error, PipelineError::Size { frame: 7, .. }), "{error}");
    }

    #[test]
    fn identities_hold_from_the_first_frame_on_and_noise_is_left_out() {
        let (noise, first, second) = (track(9, 1.0, 1.0), track(4, 20.0, 8.0), track(4, 22.0, 8.0));
        let mut analyses = [analysis(1, vec![noise, first]), analysis(2, vec![second])];
        analyses[1].settled =
            Arc::new(SettledResults { identities: vec![(4, 1)], ..SettledResults::default() });
        let offline = offline_result(&analyses, &pipeline());
        let ids: Vec<_> = offline.tracks.iter().map(|frame| (frame.number, frame.tracks.len())).collect();
        assert_eq!(ids, [(1, 1), (2, 1)]);
        assert_eq!((offline.tracks[0].tracks[0].id, offline.tracks[0].tracks[0].bbox.x), (1, 20.0));
    }

    #[test]
    fn a_track_before_birth_is_taken_unless_the_object_has_one_in_that_frame() {
        let mut analyses = [analysis(1, vec![]), analysis(2, vec![track(4, 20.0, 8.0)]), analysis(3, vec![])];
        analyses[2].settled = Arc::new(SettledResults {
            identities: vec![(4, 1), (5, 1)],
            earlier: vec![(1, track(5, 10.0, 8.0)), (2, track(5, 12.0, 8.0))],
            ..SettledResults::default()
        });
        let offline = offline_result(&analyses, &pipeline());
        let places = |at: usize| offline.tracks[at].tracks.iter().map(|it| it.bbox.x).collect::<Vec<_>>();
        assert_eq!([places(0), places(1), places(2)], [vec![10.0], vec![20.0], vec![]]);
    }

    #[test]
    fn events_are_in_order_and_a_merge_names_the_object_in_front_during_its_episode() {
        let mut analyses = [analysis(5, vec![]), analysis(6, vec![])];
        analyses[0].events =
            Arc::new(vec![event(4, EventKind::Merge, &[1, 2]), event(2, EventKind::Enter, &[3])]);
        analyses[1].events = Arc::new(vec![event(9, EventKind::Merge, &[1, 2])]);
        let episode = Episode {
            kind: EpisodeKind::InterObject,
            objects: vec![1, 2],
            start: 3,
            end: 8,
            least_visible: 0.5,
            front: Some(2),
            identities_kept: true,
        };
        analyses[1].settled =
            Arc::new(SettledResults { episodes: vec![episode], ..SettledResults::default() });
        let offline = offline_result(&analyses, &pipeline());
        let fronts: Vec<_> = offline.events.iter().map(|event| (event.frame, event.front)).collect();
        assert_eq!(fronts, [(2, None), (4, Some(2)), (9, None)]);
        assert_eq!((offline.counters.merge, offline.counters.enter), (2, 1));
    }
}
