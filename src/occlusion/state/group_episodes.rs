//! Inter-object occlusion episodes, from the first shared region until the members have been apart for
//! `same_episode`.

use std::collections::{BTreeMap, BTreeSet};

use crate::occlusion::event::{Episode, EpisodeKind};
use crate::tracking::{Identity, ObjectId};

/// An episode: objects that share a region, or did recently.
#[derive(Clone, Debug)]
struct GroupEpisode {
    /// All members so far.
    members: BTreeSet<ObjectId>,
    /// Number and time (in frame periods) of the first frame with a shared region.
    start: (u32, u32),
    /// Those of the last one.
    last: (u32, u32),
    /// The least visible share of a member.
    least_visible: f32,
    /// For each member its visible share above the members' mean, summed over frames.
    seen_more: BTreeMap<ObjectId, f32>,
    /// Whether a member was lost inside the group.
    lost_member: bool,
}

impl GroupEpisode {
    /// The member in front: the one with clearly the greatest visible share.
    fn front(&self) -> Option<ObjectId> {
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
const MAX_EPISODE_MEMBERS: usize = 64;

/// The open episodes, and the closed ones that were not taken yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct GroupEpisodes {
    open: Vec<GroupEpisode>,
    closed: Vec<GroupEpisode>,
}

impl GroupEpisodes {
    /// Records that these objects, each with its visible share, share a region in frame `number`, at time `t` in frame periods.
    /// Whether this starts a new episode.
    pub(crate) fn record_sharing(
        &mut self,
        members: &[(ObjectId, f32)],
        number: u32,
        t: u32,
        overlapping: bool,
    ) -> bool {
        let ids: BTreeSet<ObjectId> = members.iter().map(|(id, _)| *id).collect();
        let (same, other): (Vec<_>, Vec<_>) =
            self.open.drain(..).partition(|episode| !episode.members.is_disjoint(&ids));
        self.open = other;
        let (full, mut same): (Vec<_>, Vec<_>) =
            same.into_iter().partition(|episode| episode.members.len() > MAX_EPISODE_MEMBERS);
        self.closed.extend(full);
        let new = same.is_empty();
        let mut episode = same.pop().unwrap_or_else(|| GroupEpisode {
            members: BTreeSet::new(),
            start: (number, t),
            last: (number, t),
            least_visible: 1.0,
            seen_more: BTreeMap::new(),
            lost_member: false,
        });
        for joined in same {
            episode.start = episode.start.min(joined.start);
            episode.members.extend(joined.members);
            episode.least_visible = episode.least_visible.min(joined.least_visible);
            episode.lost_member |= joined.lost_member;
            for (id, votes) in joined.seen_more {
                *episode.seen_more.entry(id).or_insert(0.0) += votes;
            }
        }
        episode.members.extend(ids);
        episode.last = (number, t);
        let mean = members.iter().map(|(_, share)| share).sum::<f32>() / members.len() as f32;
        for &(id, share) in members {
            episode.least_visible = episode.least_visible.min(share);
            if overlapping {
                *episode.seen_more.entry(id).or_insert(0.0) += share - mean;
            }
        }
        self.open.push(episode);
        new
    }

    /// For how many frames an object has been in an open episode, 0 when it is in none.
    pub(crate) fn duration_of(&self, id: ObjectId, t: u32) -> u32 {
        let episodes = self.open.iter().filter(|episode| episode.members.contains(&id));
        episodes.map(|episode| t - episode.start.1).max().unwrap_or(0)
    }

    /// Marks that a member was lost during its open episode.
    pub(crate) fn mark_member_lost(&mut self, id: ObjectId) {
        for episode in self.open.iter_mut().filter(|episode| episode.members.contains(&id)) {
            episode.lost_member = true;
        }
    }

    /// Closes the episodes whose members have been apart for longer than `same_episode` frames.
    pub(crate) fn close(&mut self, t: u32, same_episode: u32) {
        let (over, open): (Vec<_>, Vec<_>) =
            self.open.drain(..).partition(|episode| t - episode.last.1 > same_episode);
        self.open = open;
        self.closed.extend(over);
    }

    /// Closes all episodes at the end of the sequence.
    pub(crate) fn close_all(&mut self) {
        self.closed.append(&mut self.open);
    }

    /// Whether the object is in an open episode.
    pub(crate) fn contains(&self, id: ObjectId) -> bool {
        self.open.iter().any(|episode| episode.members.contains(&id))
    }

    /// Takes the closed episodes; `identity` gives the objects' identities, objects without one are left out.
    pub(crate) fn take_closed(&mut self, identity: impl Fn(ObjectId) -> Option<Identity>) -> Vec<Episode> {
        let episodes = std::mem::take(&mut self.closed);
        episodes
            .iter()
            .filter_map(|episode| {
                let mut objects: Vec<_> = episode.members.iter().filter_map(|&id| identity(id)).collect();
                objects.sort_unstable();
                objects.dedup();
                (objects.len() > 1).then(|| Episode {
                    kind: EpisodeKind::InterObject,
                    objects,
                    start: episode.start.0,
                    end: episode.last.0,
                    least_visible: episode.least_visible,
                    front: episode.front().and_then(&identity),
                    identities_kept: !episode.lost_member,
                })
            })
            .collect()
    }

    /// Number of members of all retained episodes.
    pub(crate) fn len(&self) -> usize {
        self.open.iter().chain(&self.closed).map(|episode| episode.members.len()).sum()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;

    fn taken(episodes: &mut GroupEpisodes) -> Vec<Episode> {
        episodes.close_all();
        episodes.take_closed(|id| (id != 9).then_some(id + 100))
    }

    #[test]
    fn the_member_in_front_is_the_one_that_is_seen_clearly_more() {
        let front = |shares: [f32; 2], overlapping: bool| {
            let mut episodes = GroupEpisodes::default();
            episodes.record_sharing(&[(1, shares[0]), (2, shares[1])], 5, 5, overlapping);
            taken(&mut episodes)[0].front
        };
        assert_eq!(front([1.0, 0.5], true), Some(101));
        assert_eq!(front([0.5, 1.0], true), Some(102));
        assert_eq!(front([1.0, 0.75], true), None);
        assert_eq!(front([1.0, 0.5], false), None, "not one before the other");
        // Over several frames the differences from the mean add up.
        let mut episodes = GroupEpisodes::default();
        for t in 5..8 {
            episodes.record_sharing(&[(1, 0.5), (2, 0.625)], t, t, true);
        }
        assert_eq!(taken(&mut episodes)[0].front, Some(102));
    }

    #[test]
    fn episodes_that_come_together_become_one() {
        let mut episodes = GroupEpisodes::default();
        assert!(episodes.record_sharing(&[(1, 0.9), (2, 0.25)], 15, 5, true));
        assert!(episodes.record_sharing(&[(3, 0.5), (4, 0.75)], 17, 7, true));
        assert!(!episodes.record_sharing(&[(1, 0.75), (2, 0.75)], 18, 8, true));
        assert_eq!(
            (episodes.duration_of(1, 20), episodes.duration_of(3, 20), episodes.duration_of(5, 20)),
            (15, 13, 0)
        );
        assert!(episodes.contains(4) && !episodes.contains(5));
        episodes.mark_member_lost(2);
        assert!(!episodes.record_sharing(&[(2, 0.5), (3, 0.5)], 19, 9, true));
        assert_eq!((episodes.duration_of(4, 20), episodes.len()), (15, 4));
        let found = taken(&mut episodes);
        let [one] = &found[..] else { panic!("{found:?}") };
        assert_eq!((&one.objects[..], one.start, one.end), (&[101, 102, 103, 104][..], 15, 19));
        assert_eq!((one.least_visible, one.front, one.identities_kept), (0.25, None, false));
    }

    #[test]
    fn an_episode_ends_after_its_members_were_apart_for_longer() {
        let mut episodes = GroupEpisodes::default();
        episodes.record_sharing(&[(1, 1.0), (2, 1.0)], 5, 5, false);
        episodes.record_sharing(&[(8, 1.0), (9, 1.0)], 5, 5, false);
        episodes.close(15, 10);
        assert!(episodes.contains(1));
        episodes.close(16, 10);
        assert!(!episodes.contains(1));
        assert_eq!(taken(&mut episodes).len(), 1, "of the other, one has no identity");
    }

    #[test]
    fn an_episode_of_too_many_members_is_closed() {
        let mut episodes = GroupEpisodes::default();
        let pair = |id: ObjectId| [(0, 1.0), (id, 1.0)];
        for id in 1..64 {
            assert_eq!(episodes.record_sharing(&pair(id), id, id, false), id == 1);
        }
        assert!(!episodes.record_sharing(&pair(64), 64, 64, false), "64 members, and one more");
        assert!(episodes.record_sharing(&pair(65), 65, 65, false));
        let members: Vec<usize> = taken(&mut episodes).iter().map(|episode| episode.objects.len()).collect();
        assert_eq!(members, [64, 2], "without the one that has no identity");
    }
}
