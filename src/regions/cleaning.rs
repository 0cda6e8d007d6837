//! Cleaning.
/// x
#[derive(Clone)]
pub struct Cleaning;
