//! Events of objects, with the evidence for each.

use serde::Serialize;

use crate::tracking::Identity;

/// The kinds of events, in their order within a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EventKind {
    /// An object ended moving outward with its box near a boundary.
    Exit,
    /// A group's region split, or a member appeared beside it.
    Demerge,
    /// Objects that had regions of their own came to share one.
    Merge,
    /// An object lost its region away from any boundary, and no region grew to hold it.
    Disappear,
    /// A hidden object got a region again.
    Reappear,
    /// An object started with its box near a boundary.
    Enter,
    /// A new object that is none of these.
    Appear,
}

impl EventKind {
    /// Whether an event of this kind can follow one of kind `before` of the same object or group in the same frame.
    pub const fn may_follow(self, before: Self) -> bool {
        match (before, self) {
            // A new object is there from the frame's beginning on; and the order in which objects leave a group, or
            // in which one leaves before others join, is irrelevant.
            (Self::Enter | Self::Appear | Self::Reappear, _)
            | (Self::Exit | Self::Disappear, Self::Exit | Self::Disappear)
            | (Self::Disappear, Self::Merge) => true,
            _ => self as u8 > before as u8,
        }
    }

    /// All kinds, in their order.
    pub const ALL: [Self; 7] =
        [Self::Exit, Self::Demerge, Self::Merge, Self::Disappear, Self::Reappear, Self::Enter, Self::Appear];

    /// Its name on the screen.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Demerge => "split",
            _ => self.name(),
        }
    }

    /// The word for it in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exit => "exit",
            Self::Demerge => "demerge",
            Self::Merge => "merge",
            Self::Disappear => "disappear",
            Self::Reappear => "reappear",
            Self::Enter => "enter",
            Self::Appear => "appear",
        }
    }
}

/// The numbers that a decision compared, the thresholds, and the branch of the algorithm.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Evidence {
    /// The branch of the algorithm in words, a sentence with its numbers.
    pub branch: String,
    /// Regions that stood for objects in the frame before the event's and in it (the paper's object counters): a merge
    /// lowers them, a demerge raises them.
    pub objects_before: u32,
    /// See `objects_before`.
    pub objects_now: u32,
    /// Each compared number with its threshold.
    pub comparisons: Vec<Comparison>,
}

/// The side of its threshold on which a number supports a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// The number is no larger.
    AtMost,
    /// The number is no smaller.
    AtLeast,
}

/// One number of a decision.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// What was measured: `size change`, `distance to edge`, `ΔE of 3 with piece 2`.
    pub what: String,
    /// The number.
    pub value: f32,
    /// The threshold, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f32>,
    /// The relation to the threshold that supports the decision, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relation: Option<Relation>,
    /// Whether the relation holds, which supports the decision; true for a number without a threshold.
    pub holds: bool,
    /// For one of several alternatives, whether it was chosen; the choice is by all of their numbers together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chosen: Option<bool>,
}

impl Comparison {
    /// A number without a threshold.
    pub fn note(what: impl Into<String>, value: f32) -> Self {
        Self { what: what.into(), value, threshold: None, relation: None, holds: true, chosen: None }
    }

    /// A number that supports the decision when it is at most `threshold`.
    pub fn at_most(what: impl Into<String>, value: f32, threshold: f32) -> Self {
        let (threshold, relation) = (Some(threshold), Some(Relation::AtMost));
        Self { threshold, relation, ..Self::note(what, value) }.judged()
    }

    /// A number that supports the decision when it is at least `threshold`.
    pub fn at_least(what: impl Into<String>, value: f32, threshold: f32) -> Self {
        let (threshold, relation) = (Some(threshold), Some(Relation::AtLeast));
        Self { threshold, relation, ..Self::note(what, value) }.judged()
    }

    /// The same number as one of several alternatives.
    pub fn of_alternative(self, chosen: bool) -> Self {
        Self { chosen: Some(chosen), ..self }
    }

    fn judged(self) -> Self {
        let holds = match (self.threshold, self.relation) {
            (Some(threshold), Some(Relation::AtMost)) => self.value <= threshold,
            (Some(threshold), Some(Relation::AtLeast)) => self.value >= threshold,
            _ => true,
        };
        Self { holds, ..self }
    }
}

impl Evidence {
    /// Of a branch, without a number yet.
    pub fn of_branch(branch: impl Into<String>) -> Self {
        Self { branch: branch.into(), ..Self::default() }
    }

    /// Adds a number without a threshold.
    pub fn note(&mut self, what: impl Into<String>, value: f32) {
        self.comparisons.push(Comparison::note(what, value));
    }

    /// Adds a number that supports the decision when it is at most `threshold`.
    pub fn at_most(&mut self, what: impl Into<String>, value: f32, threshold: f32) {
        self.comparisons.push(Comparison::at_most(what, value, threshold));
    }

    /// Adds a number that supports the decision when it is at least `threshold`.
    pub fn at_least(&mut self, what: impl Into<String>, value: f32, threshold: f32) {
        self.comparisons.push(Comparison::at_least(what, value, threshold));
    }
}

/// An event of objects in one frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// The frame of the event, which may be earlier than the frame of the decision.
    pub frame: u32,
    /// The kind.
    pub kind: EventKind,
    /// The identities before: the members of a merge or demerge, the one of the others.
    pub objects: Vec<Identity>,
    /// The identities after: for a merge the same members, for a demerge those that left, for a reappear the
    /// re-identified one.
    pub becomes: Vec<Identity>,
    /// Of a demerge, the partition of the group's members after it: one list of objects for each region.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<Vec<Identity>>,
    /// Where, in pixels.
    pub x: f32,
    /// See `x`.
    pub y: f32,
    /// The object in front in a merge, where known.
    pub front: Option<Identity>,
    /// The evidence.
    pub evidence: Evidence,
}

impl Event {
    /// An event of one object.
    pub fn of_one(
        frame: u32,
        kind: EventKind,
        identity: Identity,
        [x, y]: [f32; 2],
        evidence: Evidence,
    ) -> Self {
        let (objects, becomes) = (vec![identity], vec![identity]);
        Self { frame, kind, objects, becomes, pieces: Vec::new(), x, y, front: None, evidence }
    }

    /// Whether both are the same event. The object in front may become known only later.
    pub fn is_same(&self, other: &Self) -> bool {
        (self.frame, self.kind) == (other.frame, other.kind)
            && self.objects == other.objects
            && self.becomes == other.becomes
    }
}

/// The two kinds of occlusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EpisodeKind {
    /// Objects hide each other: merge … demerge.
    InterObject,
    /// The scene hides an object: disappear … reappear.
    Scene,
}

impl EpisodeKind {
    /// Its name in files and on the screen.
    pub const fn name(self) -> &'static str {
        match self {
            Self::InterObject => "inter-object",
            Self::Scene => "scene",
        }
    }
}

/// An occlusion from its start to its end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Episode {
    /// The kind of occlusion.
    pub kind: EpisodeKind,
    /// All objects that took part.
    pub objects: Vec<Identity>,
    /// The first frame with an occluded object.
    pub start: u32,
    /// The last such frame; the video's last when it had not ended by then.
    pub end: u32,
    /// The least visible share of a member, 0..=1.
    pub least_visible: f32,
    /// The object in front, where known.
    pub front: Option<Identity>,
    /// Whether all objects kept their identities.
    pub identities_kept: bool,
}

/// The number of events of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    /// Ended at a boundary.
    pub exit: u32,
    /// Groups that split.
    pub demerge: u32,
    /// Objects that came together.
    pub merge: u32,
    /// Objects that vanished inside the image.
    pub disappear: u32,
    /// Hidden objects that came back.
    pub reappear: u32,
    /// Started at a boundary.
    pub enter: u32,
    /// Started inside the image.
    pub appear: u32,
}

impl Counters {
    /// Counts one event.
    pub fn count(&mut self, kind: EventKind) {
        *self.of_mut(kind) += 1;
    }

    /// How many of one kind.
    pub fn of(mut self, kind: EventKind) -> u32 {
        *self.of_mut(kind)
    }

    fn of_mut(&mut self, kind: EventKind) -> &mut u32 {
        match kind {
            EventKind::Exit => &mut self.exit,
            EventKind::Demerge => &mut self.demerge,
            EventKind::Merge => &mut self.merge,
            EventKind::Disappear => &mut self.disappear,
            EventKind::Reappear => &mut self.reappear,
            EventKind::Enter => &mut self.enter,
            EventKind::Appear => &mut self.appear,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comparison_holds_on_its_side_of_the_threshold() {
        let held = |at: fn(&'static str, f32, f32) -> Comparison| {
            [1.0, 2.0, 3.0].map(|value| at("distance", value, 2.0).holds)
        };
        assert_eq!(held(Comparison::at_most), [true, true, false]);
        assert_eq!(held(Comparison::at_least), [false, true, true]);
        assert!(Comparison::note("distance", 5.0).holds);
    }

    #[test]
    fn evidence_lists_its_numbers_in_order() {
        let mut evidence = Evidence::of_branch("some");
        evidence.note("a", 1.0);
        evidence.at_most("b", 2.0, 1.0);
        evidence.at_least("c", 3.0, 1.0);
        let expected = [
            Comparison::note("a", 1.0),
            Comparison::at_most("b", 2.0, 1.0),
            Comparison::at_least("c", 3.0, 1.0),
        ];
        assert_eq!(evidence.comparisons, expected);
    }

    #[test]
    fn events_are_counted_by_kind() {
        let mut counters = Counters::default();
        for kind in [EventKind::Merge, EventKind::Exit, EventKind::Merge] {
            counters.count(kind);
        }
        assert_eq!(counters, Counters { merge: 2, exit: 1, ..Counters::default() });
        assert_eq!((counters.of(EventKind::Merge), counters.of(EventKind::Appear)), (2, 0));
    }

    #[test]
    fn an_event_is_the_same_whatever_is_learnt_of_it_later() {
        let event = Event::of_one(7, EventKind::Exit, 3, [10.0, 20.0], Evidence::of_branch("some"));
        assert!(event.is_same(&Event { front: Some(3), x: 11.0, ..event.clone() }));
        let others = [
            Event { frame: 8, ..event.clone() },
            Event { kind: EventKind::Disappear, ..event.clone() },
            Event { objects: vec![4], ..event.clone() },
            Event { becomes: vec![4], ..event.clone() },
        ];
        assert!(others.iter().all(|other| !event.is_same(other)));
    }
}
