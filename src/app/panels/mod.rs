//! Panels, dialogs and messages around the views, one file each.

pub(crate) mod about;
pub(crate) mod area_panel;
pub(crate) mod command_palette;
pub(crate) mod drop_files;
pub(crate) mod events_panel;
pub(crate) mod evidence;
pub(crate) mod help;
pub(crate) mod messages;
pub(crate) mod notices;
pub(crate) mod object_panel;
pub(crate) mod score_panel;
pub(crate) mod setting_control;
pub(crate) mod setting_help;
pub(crate) mod settings_panel;
pub(crate) mod source_options;
pub(crate) mod status;
pub(crate) mod subject_choice;
pub(crate) mod sweep_maps;
pub(crate) mod timeline;
pub(crate) mod toasts;
pub(crate) mod top_bar;
pub(crate) mod transport;
pub(crate) mod welcome;
