//! Commands: the table of actions, their shortcuts, and the execution of those that change
//! only the model.

pub(crate) mod actions;
pub(crate) mod apply;
pub(crate) mod availability;
pub(crate) mod command;
pub(crate) mod entry;
pub(crate) mod keys;
