//! Commands: the table of actions, their shortcuts, and their execution.

pub(crate) mod actions;
pub(crate) mod apply;
pub(crate) mod command;
pub(crate) mod entry;
pub(crate) mod keys;
