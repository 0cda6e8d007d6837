//! Motion and appearance of the objects in each region: alone, or localised among the members of a group; members that
//! are not visible are searched, and believed to exist for a time.

pub(crate) mod existence;
mod localisation;
mod member_localisation;
pub(crate) mod member_search;
pub(crate) mod object_update;
