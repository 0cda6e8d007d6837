//! The kinds of work, each in short steps. The worker decides which is due; tasks do not depend on the worker.

pub(crate) mod analyse;
pub(crate) mod explain;
pub(crate) mod gather;
pub(crate) mod score;
pub(crate) mod score_external;
pub(crate) mod show;
pub(crate) mod timeline;
pub(crate) mod tune;
