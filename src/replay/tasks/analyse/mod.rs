//! The analysis of the sequence, under the settings in view and under those compared with them.

pub(crate) mod analysis_pass;
pub(crate) mod compared_pass;
pub(crate) mod model_timeline;
