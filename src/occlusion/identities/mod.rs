//! Who each object is: confirmed as new, re-identified after an occlusion or a demerge, lost, occluded or ended.

mod coherence;
pub(crate) mod confirmation;
pub(crate) mod lost;
pub(crate) mod occluded;
mod split_member;
