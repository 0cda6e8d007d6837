//! What a panic said.

use std::any::Any;

/// The message of a panic, in one line.
pub(crate) fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("of an unknown kind").split_whitespace().collect::<Vec<_>>().join(" ")
}
