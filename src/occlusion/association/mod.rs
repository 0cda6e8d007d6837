//! Prediction and association: from the regions of a frame to detections, each of a blob with one or several objects or
//! of a new object.

pub(crate) mod births;
pub(crate) mod cluster_update;
pub(crate) mod detections;
pub(crate) mod matching;
mod partition;
pub(crate) mod prediction;
