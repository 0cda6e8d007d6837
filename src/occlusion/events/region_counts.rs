//! The paper's object counters: how many regions stand for objects in each frame.

use std::collections::VecDeque;

use crate::occlusion::state::context::Context;
use crate::occlusion::state::object_table::{ObjectTable, TrackedBlob};

/// For each recent frame its number and how many regions contained confirmed objects.
#[derive(Clone, Debug, Default)]
pub(crate) struct RegionCounts(VecDeque<(u32, u32)>);

impl RegionCounts {
    /// Records the present frame.
    pub(crate) fn record(&mut self, context: &Context, table: &ObjectTable) {
        let stands_for_objects = |tracked: &&TrackedBlob| {
            tracked.detection.is_some() && tracked.members().iter().any(|&id| table.is_confirmed(id))
        };
        let count = table.blobs().iter().filter(stands_for_objects).count();
        // No event is emitted later than `max_hidden` frames after the frame it belongs to.
        if self.0.len() > context.limits.max_hidden_frames as usize + 1 {
            self.0.pop_front();
        }
        self.0.push_back((context.number, count as u32));
    }

    /// The counts in the frame before the frame with this number, and in that frame; 0 where it is not recorded.
    pub(crate) fn around(&self, number: u32) -> (u32, u32) {
        let at = self.0.partition_point(|(counted, _)| *counted < number);
        let count = |at: Option<usize>| at.and_then(|at| self.0.get(at)).map_or(0, |(_, count)| *count);
        (count(at.checked_sub(1)), count(Some(at)))
    }

    /// Number of recorded frames.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_counts_of_a_frame_and_of_the_one_before_are_found_by_number() {
        let counts = RegionCounts(VecDeque::from([(10, 2), (12, 1), (13, 4)]));
        assert_eq!(counts.around(12), (2, 1));
        assert_eq!(counts.around(13), (1, 4));
        assert_eq!(counts.around(10), (0, 2));
        assert_eq!(counts.around(14), (4, 0), "not recorded yet");
    }

    #[test]
    fn regions_of_confirmed_objects_are_counted_for_as_long_as_an_event_can_be_late() {
        use crate::occlusion::fixtures::{BLUE, RED, context, person, start_confirmed, start_tentative};
        let mut context = context(1);
        context.limits.max_hidden_frames = 3;
        let (mut table, mut counts) = (ObjectTable::default(), RegionCounts::default());
        start_tentative(&context, &mut table, person(20.0, 90.0), RED, [0.0; 2]);
        start_confirmed(&context, &mut table, person(100.0, 90.0), BLUE, [0.0; 2]);
        start_confirmed(&context, &mut table, person(200.0, 90.0), BLUE, [0.0; 2]);
        table.blobs_mut().skip(2).for_each(|tracked| tracked.detection = None);
        for number in 1..=9 {
            context.number = number;
            counts.record(&context, &table);
        }
        assert_eq!(counts.0, (5..=9).map(|number| (number, 1)).collect::<Vec<_>>());
    }
}
