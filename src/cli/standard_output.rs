//! What goes to stdout.

use std::io::{self, BufWriter, StdoutLock, Write as _};
use std::path::Path;

use crate::export::write_failure::describe;

/// Its name in messages.
const NAME: &str = "standard output";

/// Writes to stdout; an error names it.
pub(super) fn write(
    content: impl FnOnce(&mut BufWriter<StdoutLock<'static>>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    content(&mut out).map_err(|error| own_error(error).map_or_else(|other| other, failure))?;
    out.flush().map_err(failure)
}

/// An error of writing to stdout, with its name.
pub(super) fn failure(error: io::Error) -> anyhow::Error {
    describe(Path::new(NAME), error).into()
}

/// An error of writing, or one of the work, which says what it is of.
pub(super) fn own_error(error: anyhow::Error) -> Result<io::Error, anyhow::Error> {
    let outermost = error.chain().next();
    let is_own = outermost.is_some_and(<dyn std::error::Error>::is::<io::Error>);
    if is_own { error.downcast() } else { Err(error) }
}
