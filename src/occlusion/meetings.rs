//! Occlusion episodes: meetings of objects, from the first touch until they have been apart for good.

use std::collections::{BTreeMap, BTreeSet};

use super::event::{Episode, EpisodeKind};
use super::reasoner::ObjectId;

/// Objects that share a region, or did a moment ago.
#[derive(Clone, Debug)]
pub struct Meeting {
    /// Everybody who took part.
    pub members: BTreeSet<ObjectId>,
    /// The frame's number and t of the first sharing.
    pub start: (u32, u32),
    /// The frame's number and t of the last.
    pub last: (u32, u32),
    /// The least visible share of a member.
    pub least_visible: f32,
    /// For each member, how much more of it was seen than of the others, summed over frames.
    pub seen_more: BTreeMap<ObjectId, f32>,
    /// Whether somebody was lost without coming out.
    pub lost_member: bool,
}

impl Meeting {
    /// Who is in front: the one of whom clearly more was seen.
    pub fn front(&self) -> Option<ObjectId> {
        let mut votes: Vec<_> = self.seen_more.iter().collect();
        votes.sort_by(|a, b| b.1.total_cmp(a.1));
        match votes.as_slice() {
            [(first, most), (_, next), ..] if *most - *next > 0.3 => Some(**first),
            _ => None,
        }
    }
}

/// An episode of more members than this is closed, and a new one begins with its present members. In a crowd that never
/// separates it would otherwise grow with every object that passes.
const MAX_MEMBERS: usize = 64;

/// The meetings that go on, and those that ended and have not been asked for yet.
#[derive(Clone, Debug, Default)]
pub struct Meetings {
    open: Vec<Meeting>,
    closed: Vec<Meeting>,
}

impl Meetings {
    /// Notes that these objects share a region in frame `number` (the `t`-th), each seen to its
    /// share. Whether this is a new meeting rather than one that goes on.
    pub fn share(&mut self, members: &[(ObjectId, f32)], number: u32, t: u32, overlapping: bool) -> bool {
        let ids: BTreeSet<ObjectId> = members.iter().map(|(id, _)| *id).collect();
        let (same, other): (Vec<_>, Vec<_>) =
            self.open.drain(..).partition(|meeting| !meeting.members.is_disjoint(&ids));
        self.open = other;
        let (full, mut same): (Vec<_>, Vec<_>) =
            same.into_iter().partition(|meeting| meeting.members.len() > MAX_MEMBERS);
        self.closed.extend(full);
        let new = same.is_empty();
        let mut meeting = same.pop().unwrap_or_else(|| Meeting {
            members: BTreeSet::new(),
            start: (number, t),
            last: (number, t),
            least_visible: 1.0,
            seen_more: BTreeMap::new(),
            lost_member: false,
        });
        for joined in same {
            meeting.start = meeting.start.min(joined.start);
            meeting.members.extend(joined.members);
            meeting.least_visible = meeting.least_visible.min(joined.least_visible);
            meeting.lost_member |= joined.lost_member;
            for (id, votes) in joined.seen_more {
                *meeting.seen_more.entry(id).or_insert(0.0) += votes;
            }
        }
        meeting.members.extend(ids);
        meeting.last = (number, t);
        let mean = members.iter().map(|(_, share)| share).sum::<f32>() / members.len() as f32;
        for &(id, share) in members {
            meeting.least_visible = meeting.least_visible.min(share);
            if overlapping {
                *meeting.seen_more.entry(id).or_insert(0.0) += share - mean;
            }
        }
        self.open.push(meeting);
        new
    }

    /// For how many frames an object has been in its meeting, 0 when it is in none.
    pub fn duration_of(&self, id: ObjectId, t: u32) -> u32 {
        let meetings = self.open.iter().filter(|meeting| meeting.members.contains(&id));
        meetings.map(|meeting| t - meeting.start.1).max().unwrap_or(0)
    }

    /// Notes that an object was lost while in a meeting.
    pub fn lose(&mut self, id: ObjectId) {
        for meeting in self.open.iter_mut().filter(|meeting| meeting.members.contains(&id)) {
            meeting.lost_member = true;
        }
    }

    /// Closes the meetings whose members have been apart for longer than `same_episode` frames.
    pub fn close(&mut self, t: u32, same_episode: u32) {
        let (over, open): (Vec<_>, Vec<_>) =
            self.open.drain(..).partition(|meeting| t - meeting.last.1 > same_episode);
        self.open = open;
        self.closed.extend(over);
    }

    /// Closes all meetings: there is no later frame in which they could go on.
    pub fn close_all(&mut self) {
        self.closed.append(&mut self.open);
    }

    /// Whether the object is in an open episode.
    pub fn hold(&self, id: ObjectId) -> bool {
        self.open.iter().any(|meeting| meeting.members.contains(&id))
    }

    /// The meetings that were closed since this was last asked, as episodes; `identity` names the objects, those
    /// without a name are left out.
    pub fn take_closed(&mut self, identity: impl Fn(ObjectId) -> Option<u32>) -> Vec<Episode> {
        let meetings = std::mem::take(&mut self.closed);
        meetings
            .iter()
            .filter_map(|meeting| {
                let mut objects: Vec<_> = meeting.members.iter().filter_map(|&id| identity(id)).collect();
                objects.sort_unstable();
                objects.dedup();
                (objects.len() > 1).then(|| Episode {
                    kind: EpisodeKind::InterObject,
                    objects,
                    start: meeting.start.0,
                    end: meeting.last.0,
                    least_visible: meeting.least_visible,
                    front: meeting.front().and_then(&identity),
                    identities_kept: !meeting.lost_member,
                })
            })
            .collect()
    }

    /// How many have taken part in the meetings.
    pub fn len(&self) -> usize {
        self.open.iter().chain(&self.closed).map(|meeting| meeting.members.len()).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The memory it takes, roughly, in bytes.
    pub fn bytes(&self) -> usize {
        (self.open.len() + self.closed.len()) * size_of::<Meeting>() + 32 * self.len()
    }
}
