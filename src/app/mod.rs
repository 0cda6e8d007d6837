//! The window.

pub mod inspector;
pub mod theme;
