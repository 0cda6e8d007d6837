//! The frames' results in memory: the record of every analysed frame, and what reproduces the model at any of them.

pub(crate) mod analysis_record;
pub(crate) mod local_checkpoints;
pub(crate) mod model_pictures;
pub(crate) mod strided_checkpoints;
