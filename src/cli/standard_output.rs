//! What goes to stdout.

use std::io::{self, BufWriter, StdoutLock, Write as _};
use std::path::Path;

use crate::export::write_failure::told;

/// Its name in messages.
const NAME: &str = "standard output";

/// Writes to stdout; an error of it is told as one.
pub(super) fn write(
    content: impl FnOnce(&mut BufWriter<StdoutLock<'static>>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    content(&mut out).map_err(|error| match error.downcast::<io::Error>() {
        Ok(error) => told(Path::new(NAME), error).into(),
        Err(other) => other,
    })?;
    Ok(out.flush().map_err(|error| told(Path::new(NAME), error))?)
}
