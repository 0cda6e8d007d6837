//! The whole image's mixtures (placeholder until the next commit).
/// x
#[derive(Clone)]
pub struct Mixture;
