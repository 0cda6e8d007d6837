//! What all stages share: the `context` (settings and frame), the objects with their place in the `object_table`, and
//! the `decisions` that wait for later frames.

pub(crate) mod comparable_colours;
pub(crate) mod context;
pub(crate) mod decisions;
pub(crate) mod group_episodes;
pub(crate) mod groups;
pub(crate) mod object;
pub(crate) mod object_table;
pub(crate) mod perspective;
pub(crate) mod split_region;
pub(crate) mod template;
