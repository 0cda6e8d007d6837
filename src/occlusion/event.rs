//! What can happen to objects, and why it was decided that it did.

use serde::Serialize;

use crate::tracking::Identity;

/// The kinds of events, in the order in which those of one frame are told.
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
    /// Whether what happens to an object can be of this kind where something of kind `before` happened to it or its
    /// group earlier in the same frame.
    pub const fn may_follow(self, before: Self) -> bool {
        match (before, self) {
            // Who comes is there from the frame's beginning on; and it does not matter in which order some leave a
            // group, or whether one leaves it before others come to it.
            (Self::Enter | Self::Appear | Self::Reappear, _)
            | (Self::Exit | Self::Disappear, Self::Exit | Self::Disappear)
            | (Self::Disappear, Self::Merge) => true,
            _ => self as u8 > before as u8,
        }
    }

    /// All kinds, in their order.
    pub const ALL: [Self; 7] =
        [Self::Exit, Self::Demerge, Self::Merge, Self::Disappear, Self::Reappear, Self::Enter, Self::Appear];

    /// The word for it on the screen.
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

/// The numbers that a decision compared, the thresholds, and the branch that was taken.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Evidence {
    /// The branch of the algorithm in words, a sentence with its numbers.
    pub branch: String,
    /// Regions that stood for objects in the frame before the event's and in it (the paper's object counters): a merge
    /// lowers them, a demerge raises them.
    pub objects_before: u32,
    /// See `objects_before`.
    pub objects_now: u32,
    /// Each number that was looked at, with what it was compared to.
    pub comparisons: Vec<Comparison>,
}

/// On which side of its threshold a number speaks for a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// The number is no larger.
    AtMost,
    /// The number is no smaller.
    AtLeast,
}

/// One number that a decision looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// What was measured: `size change`, `distance to edge`, `ΔE of 3 with piece 2`.
    pub what: String,
    /// The number.
    pub value: f32,
    /// The threshold, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f32>,
    /// How the number has to stand to the threshold, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relation: Option<Relation>,
    /// Whether it stands so, which speaks for the decision; true of a number without a threshold.
    pub holds: bool,
    /// Of several alternatives, whether this one was chosen; the choice is by all of their numbers together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chosen: Option<bool>,
}

impl Comparison {
    /// A number without a threshold.
    pub fn note(what: impl Into<String>, value: f32) -> Self {
        Self { what: what.into(), value, threshold: None, relation: None, holds: true, chosen: None }
    }

    /// A number that speaks for the decision when it is at most `threshold`.
    pub fn at_most(what: impl Into<String>, value: f32, threshold: f32) -> Self {
        let (threshold, relation) = (Some(threshold), Some(Relation::AtMost));
        Self { threshold, relation, ..Self::note(what, value) }.judged()
    }

    /// A number that speaks for the decision when it is at least `threshold`.
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

    /// Notes a number without a threshold.
    pub fn note(&mut self, what: impl Into<String>, value: f32) {
        self.comparisons.push(Comparison::note(what, value));
    }

    /// Notes a number that speaks for the decision when it is at most `threshold`.
    pub fn at_most(&mut self, what: impl Into<String>, value: f32, threshold: f32) {
        self.comparisons.push(Comparison::at_most(what, value, threshold));
    }

    /// Notes a number that speaks for the decision when it is at least `threshold`.
    pub fn at_least(&mut self, what: impl Into<String>, value: f32, threshold: f32) {
        self.comparisons.push(Comparison::at_least(what, value, threshold));
    }
}

/// Something that happened to objects in one frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// The frame in which it happened, which may be earlier than the one in which it was decided.
    pub frame: u32,
    /// What happened.
    pub kind: EventKind,
    /// The identities before: the members of a merge or demerge, the one of the others.
    pub objects: Vec<Identity>,
    /// The identities after: for a merge the same members, for a demerge who came out, for a
    /// reappear who it was.
    pub becomes: Vec<Identity>,
    /// Of a demerge, the partition of the group's members after it: one list of objects for each region.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<Vec<Identity>>,
    /// Where, in pixels.
    pub x: f32,
    /// See `x`.
    pub y: f32,
    /// Who is in front in a merge, where that can be told.
    pub front: Option<Identity>,
    /// Why.
    pub evidence: Evidence,
}

impl Event {
    /// What happened to one object.
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

    /// Whether both tell of the same happening. Who was in front may be found out only later.
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
    /// The word for it in files and on the screen.
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
    /// Who hides whom.
    pub kind: EpisodeKind,
    /// Everybody who took part.
    pub objects: Vec<Identity>,
    /// The first frame in which somebody is occluded.
    pub start: u32,
    /// The last such frame; the video's last when it had not ended by then.
    pub end: u32,
    /// The least share of its full size at which a member was seen, 0..=1.
    pub least_visible: f32,
    /// Who was in front, where that can be told.
    pub front: Option<Identity>,
    /// Whether everybody came out with the identity they went in with.
    pub identities_kept: bool,
}

/// How many events of each kind have been seen.
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
