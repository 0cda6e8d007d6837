//! The program on a layer that lets calls of the system fail (`layer.c`).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use tempfile::TempDir;

/// The number of the error of a disk.
pub(crate) const EIO: i32 = 5;
/// The number of the error of a full disk.
pub(crate) const ENOSPC: i32 = 28;

/// What fails.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fault {
    /// The kinds of calls that are counted.
    pub(crate) calls: &'static str,
    /// The number of the call that fails; 0 for none.
    pub(crate) at: u32,
    /// Whether later ones fail as well.
    pub(crate) lasts: bool,
    /// The number of the error; `None` kills the program.
    pub(crate) error: Option<i32>,
}

/// The compiled layer.
fn library() -> &'static Path {
    static BUILT: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = BUILT.get_or_init(|| {
        // It stays until the next build: nothing drops what is kept for all tests.
        let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
        let path = folder.path().join("layer.so");
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults/layer.c");
        let built =
            Command::new("cc").args(["-O1", "-shared", "-fPIC", "-o"]).arg(&path).arg(source).output();
        let built = built.expect("a C compiler is installed");
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        (folder, path)
    });
    path
}

/// Runs the program with faults in the files below `under`; what it did, and the number of counted calls, which is `None`
/// where it was killed.
pub(crate) fn run(arguments: &[String], under: &Path, fault: Fault) -> (Output, Option<u32>) {
    let folder = tempfile::tempdir().unwrap();
    let count = folder.path().join("count");
    let mut command = Command::new(env!("CARGO_BIN_EXE_occluscope"));
    command.args(arguments).env("LD_PRELOAD", library()).env("OCCLUSCOPE_FAULT_COUNT", &count);
    command.env("OCCLUSCOPE_FAULT_UNDER", under.canonicalize().unwrap());
    command.env("OCCLUSCOPE_FAULT_CALLS", fault.calls);
    command.env("OCCLUSCOPE_FAULT_AT", fault.at.to_string());
    command.env("OCCLUSCOPE_FAULT_LASTS", u8::from(fault.lasts).to_string());
    command.env("OCCLUSCOPE_FAULT_ERROR", fault.error.unwrap_or(0).to_string());
    let output = command.output().unwrap();
    let count = fs::read_to_string(count).ok().map(|text| text.parse().unwrap());
    (output, count)
}
