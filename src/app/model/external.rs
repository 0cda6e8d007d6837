//! Results of another method on the open video.

use std::sync::Arc;

use crate::replay::Timeline;
use crate::truth::external::ExternalResults;

/// The loaded results, in the source's pixels.
#[derive(Clone, Debug)]
pub(crate) struct LoadedResults {
    /// The results.
    pub(crate) results: Arc<ExternalResults>,
    /// Whether it is known if they have frames of the video.
    is_checked: bool,
}

impl LoadedResults {
    /// Results that are not checked against the video yet.
    pub(super) const fn new(results: Arc<ExternalResults>) -> Self {
        Self { results, is_checked: false }
    }

    /// A warning if the results share no frame with the video, once that is known.
    pub(super) fn check(&mut self, timeline: &Timeline) -> Option<String> {
        let (first, last) = self.results.span().filter(|_| !self.is_checked)?;
        let numbers = &timeline.numbers;
        let known = &numbers[numbers.partition_point(|number| *number < first)..];
        let is_shared =
            known.iter().take_while(|number| **number <= last).any(|&n| self.results.has_frame(n));
        self.is_checked = is_shared || timeline.complete;
        let (video_first, video_last) = (numbers.first()?, numbers.last()?);
        (self.is_checked && !is_shared).then(|| {
            format!(
                "{} has no frame of the video: its frames are {first} to {last}, the video's {video_first} to \
                 {video_last}; number them like the video's, or load the results of this video",
                self.results.name
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::truth::boxes::{Bounds, Boxes};

    fn warning(frames: &[u32], numbers: &[u32], complete: bool) -> Option<String> {
        let place = BTreeMap::from([(1, Bounds([0.0, 0.0, 1.0, 1.0]))]);
        let boxes: Boxes = frames.iter().map(|&number| (number, place.clone())).collect();
        let results =
            ExternalResults { name: "x.txt".into(), boxes: Some(boxes), ..ExternalResults::default() };
        let mut loaded = LoadedResults::new(Arc::new(results));
        let timeline = Timeline { numbers: numbers.to_vec(), complete, ..Timeline::default() };
        let warning = loaded.check(&timeline);
        assert_eq!(loaded.check(&timeline), None, "once");
        warning
    }

    #[test]
    fn results_without_a_frame_of_the_video_are_reported_once_it_is_known() {
        assert_eq!(warning(&[101, 102], &[1, 2, 3], false), None, "there may be more frames");
        let why = warning(&[101, 102], &[1, 2, 3], true);
        let expected = "x.txt has no frame of the video: its frames are 101 to 102, the video's 1 to 3";
        assert!(why.as_ref().is_some_and(|why| why.starts_with(expected)), "{why:?}");
        assert_eq!(warning(&[3, 102], &[1, 2, 3], true), None);
        // Frames that were left out lie between others.
        assert!(warning(&[2, 4], &[1, 3, 5], true).is_some());
        assert_eq!(warning(&[], &[1, 2], true), None, "there is nothing to number");
    }
}
