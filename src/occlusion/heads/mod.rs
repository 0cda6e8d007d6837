//! Regions with more heads than members: `head_count` counts the heads, `head_split` adds the member.

mod head_count;
pub(crate) mod head_split;
