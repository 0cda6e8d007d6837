//! Ctrl-C: the work stops at the next frame, so that temporary files are removed.

use std::io::{self, Write as _};
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::export::staging;

static STOP_REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler: the first Ctrl-C (or SIGTERM) requests a stop, the second removes temporary files and ends the
/// process.
pub(super) fn watch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Without a handler, Ctrl-C ends the process at once.
        let _ = ctrlc::set_handler(|| {
            if STOP_REQUESTED.swap(true, Ordering::SeqCst) {
                staging::remove_all();
                // An error of stderr cannot be reported.
                let _ = writeln!(io::stderr(), "error: stopped at once; nothing was written");
                std::process::exit(1);
            }
        });
    });
}

/// Whether a stop was requested.
pub(super) fn is_stop_requested() -> bool {
    STOP_REQUESTED.load(Ordering::SeqCst)
}
