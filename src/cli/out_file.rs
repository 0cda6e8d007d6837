//! A single output file, which appears under its name when it is complete.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use anyhow::Context as _;

use crate::export::Staging;

/// Writes a temporary file next to `path` and renames it; writes directly to a device or a pipe.
pub(super) fn write(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let fail = || format!("{} cannot be written", path.display());
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if target.exists() && !target.is_file() {
        let mut out = BufWriter::new(File::create(&target).with_context(fail)?);
        content(&mut out)?;
        return out.flush().with_context(fail);
    }
    let name = target.file_name().with_context(fail)?;
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let staging = Staging::new(folder).with_context(fail)?;
    let mut out = BufWriter::new(File::create(staging.path(name)).with_context(fail)?);
    content(&mut out)?;
    out.flush().with_context(fail)?;
    staging.publish(name).with_context(fail)
}
