//! Files that the window reads and writes.

pub(crate) mod atomic_write;
pub(crate) mod dialogs;
pub(crate) mod export_frame;
pub(crate) mod kept_state;
pub(crate) mod sample;
pub(crate) mod settings_file;
pub(crate) mod sweep_file;
