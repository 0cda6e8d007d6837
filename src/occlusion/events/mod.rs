//! Events, each emitted once with its evidence: merges and demerges of groups with the assignment of their members, and
//! the episodes.

pub(crate) mod assign;
pub(crate) mod demerges;
pub(crate) mod emission;
pub(crate) mod episodes;
pub(crate) mod group_changes;
pub(crate) mod region_counts;
