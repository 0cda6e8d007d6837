//! The numbers of the frames of a sequence that were analysed: only these are judged.

use serde::{Deserialize, Serialize};

/// Frame numbers at equal distances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    first: u32,
    last: u32,
    step: u32,
}

/// How the analysed frames are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// From the record of the analysis.
    Record,
    /// From the record beside the results, a file of tracks.
    RecordBeside,
    /// From the length of the sequence that the ground truth states.
    Length,
    /// From the first to the last frame with a result.
    Results,
    /// Not at all, as there are no results: all frames.
    Unknown,
}

/// The numbers of the frames that were analysed, at least one. In a file it is a list of runs, in ascending order: first
/// number, last number and, if it is not 1, the distance of the numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Vec<Vec<u32>>", try_from = "Vec<Vec<u32>>")]
pub struct AnalysedFrames {
    /// In ascending order, at least one.
    runs: Vec<Run>,
    origin: Origin,
}

impl AnalysedFrames {
    /// These frames, in ascending order, from the record of the analysis; `None` without frames.
    pub fn of_numbers(numbers: impl IntoIterator<Item = u32>) -> Option<Self> {
        let mut runs: Vec<Run> = Vec::new();
        for number in numbers {
            match runs.last_mut() {
                Some(run) if run.first == run.last && number > run.last => {
                    (run.last, run.step) = (number, number - run.last);
                }
                Some(run) if number > run.last && number - run.last == run.step => run.last = number,
                _ => runs.push(Run { first: number, last: number, step: 1 }),
            }
        }
        (!runs.is_empty()).then_some(Self { runs, origin: Origin::Record })
    }

    /// The frames from `first` to `last` at a distance of `step`, from the record of the analysis; `None` without
    /// frames.
    pub fn at_steps(first: u32, last: u32, step: u32) -> Option<Self> {
        let runs = vec![Run { first, last, step }];
        (first <= last && step > 0).then_some(Self { runs, origin: Origin::Record })
    }

    /// The frames from the first to the last with a result; all if there is none.
    pub fn of_results(span: Option<(u32, u32)>) -> Self {
        let origin = if span.is_some() { Origin::Results } else { Origin::Unknown };
        let (first, last) = span.unwrap_or((0, u32::MAX));
        Self { runs: vec![Run { first, last, step: 1 }], origin }
    }

    /// The same frames, known otherwise.
    #[must_use]
    pub fn known_by(self, origin: Origin) -> Self {
        Self { origin, ..self }
    }

    /// How they are known.
    pub fn origin(&self) -> Origin {
        self.origin
    }

    /// The first and the last number.
    pub fn span(&self) -> (u32, u32) {
        (self.runs.first().map_or(0, |run| run.first), self.runs.last().map_or(u32::MAX, |run| run.last))
    }

    /// Whether a frame is in the range, analysed or left out between others.
    pub fn covers(&self, number: u32) -> bool {
        let (first, last) = self.span();
        (first..=last).contains(&number)
    }

    /// Whether a frame was analysed.
    pub fn contains(&self, number: u32) -> bool {
        let run = self.runs.get(self.runs.partition_point(|run| run.last < number));
        run.is_some_and(|run| run.first <= number && (number - run.first).is_multiple_of(run.step))
    }

    /// The numbers, in ascending order.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        self.runs.iter().flat_map(|run| (run.first..=run.last).step_by(run.step as usize))
    }

    /// Number of frames.
    pub fn count(&self) -> u64 {
        self.runs.iter().map(|run| u64::from((run.last - run.first) / run.step) + 1).sum()
    }
}

impl From<AnalysedFrames> for Vec<Vec<u32>> {
    fn from(frames: AnalysedFrames) -> Self {
        let list = |Run { first, last, step }: Run| match step {
            1 => vec![first, last],
            _ => vec![first, last, step],
        };
        frames.runs.into_iter().map(list).collect()
    }
}

impl TryFrom<Vec<Vec<u32>>> for AnalysedFrames {
    type Error = &'static str;

    fn try_from(lists: Vec<Vec<u32>>) -> Result<Self, Self::Error> {
        let run = |list: &Vec<u32>| {
            let (first, last, step) = match list[..] {
                [first, last] => (first, last, 1),
                [first, last, step] => (first, last, step),
                _ => return None,
            };
            let is_run = first <= last && step > 0 && (last - first).is_multiple_of(step);
            is_run.then_some(Run { first, last, step })
        };
        let runs: Option<Vec<Run>> = lists.iter().map(run).collect();
        let runs = runs.filter(|runs| !runs.is_empty() && runs.is_sorted_by(|a, b| a.last < b.first));
        runs.map(|runs| Self { runs, origin: Origin::Record })
            .ok_or("expected runs of ascending frame numbers, [first, last] or [first, last, step]")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_range_has_the_frames_at_its_steps() {
        let frames = AnalysedFrames::at_steps(3, 11, 4).unwrap();
        assert_eq!((0..20).filter(|&number| frames.contains(number)).collect::<Vec<_>>(), [3, 7, 11]);
        assert_eq!((frames.count(), frames.span(), frames.covers(5)), (3, (3, 11), true));
        assert!(!frames.covers(2) && frames.covers(3) && frames.covers(11) && !frames.covers(12));
        assert_eq!(AnalysedFrames::at_steps(5, 4, 1), None);
        assert_eq!(AnalysedFrames::of_numbers([]), None);
        let all = AnalysedFrames::of_results(None);
        assert!(all.contains(u32::MAX) && all.origin() == Origin::Unknown && all.count() == 1 << 32);
    }

    #[test]
    fn a_file_has_runs_of_ascending_numbers() {
        let read = |text: &str| serde_json::from_str::<AnalysedFrames>(text).ok();
        let frames = AnalysedFrames::of_numbers([1, 2, 3, 7, 10, 13, 20]).unwrap();
        let text = "[[1,3],[7,13,3],[20,20]]";
        assert_eq!(serde_json::to_string(&frames).unwrap(), text);
        assert_eq!(read(text), Some(frames));
        for text in [
            "[]",
            "[[1]]",
            "[[1,2,3,4]]",
            "[[2,1]]",
            "[[1,4,2]]",
            "[[1,4,0]]",
            "[[1,4],[4,5]]",
            "[[5,6],[1,2]]",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn runs_hold_the_numbers_they_were_made_of(numbers in prop::collection::btree_set(0_u32..60, 1..40)) {
            let frames = AnalysedFrames::of_numbers(numbers.iter().copied()).unwrap();
            let held: Vec<_> = (0..70).filter(|&number| frames.contains(number)).collect();
            prop_assert_eq!(frames.count() as usize, numbers.len());
            prop_assert!(frames.numbers().eq(numbers.iter().copied()));
            prop_assert_eq!(held, numbers.into_iter().collect::<Vec<_>>());
        }
    }
}
