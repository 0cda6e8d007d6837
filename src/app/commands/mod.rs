//! Commands: what panels and views request. `action` lists the actions that have a name, `actions` is their table,
//! `keys` finds them by shortcut, `apply` executes the commands that change only the model.

pub(crate) mod action;
pub(crate) mod actions;
pub(crate) mod apply;
pub(crate) mod availability;
pub(crate) mod command;
pub(crate) mod entry;
pub(crate) mod keys;
pub(crate) mod shortcut;
