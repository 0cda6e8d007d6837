//! The analysis of the sequence, under the settings in view and under those compared with them.

pub(crate) mod analysis_pass;
pub(crate) mod compared_pass;
pub(crate) mod model_timeline;
pub(crate) mod pass_progress;

use std::sync::Arc;

use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::SourceInfo;

/// The inputs of a pass through a sequence.
pub(crate) struct PassInputs {
    /// The settings.
    pub(crate) settings: Arc<Settings>,
    /// The region of interest; `None` for the whole image.
    pub(crate) roi: Option<Arc<Roi>>,
    /// The source.
    pub(crate) info: Arc<SourceInfo>,
    /// Memory for checkpoints and the record, in bytes.
    pub(crate) budget: usize,
}
