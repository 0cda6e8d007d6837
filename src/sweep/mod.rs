//! Sweeps: a sequence, or every sequence of a data set, under every combination of some settings, scored against ground
//! truth.
//!
//! [`grid`] makes the combinations, [`data_set`] finds the sequences. A [`pass`] analyses a sequence under several
//! combinations at once, [`scoring`] gives their measures, [`table`] holds them. [`heat_map`] shows them over two settings,
//! [`sequence_frames`] is what a report shows of a sequence's frames.

pub mod data_set;
pub mod grid;
pub mod heat_map;
pub mod pass;
pub mod scoring;
pub mod sequence_frames;
pub mod table;
