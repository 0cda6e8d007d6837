//! Ctrl-C: the work stops at the next frame, so that temporary files are removed.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

static STOP_REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler: the first Ctrl-C (or SIGTERM) requests a stop, the second ends the process.
pub(super) fn watch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Without a handler, Ctrl-C ends the process at once.
        let _ = ctrlc::set_handler(|| {
            if STOP_REQUESTED.swap(true, Ordering::SeqCst) {
                std::process::exit(1);
            }
        });
    });
}

/// Whether a stop was requested.
pub(super) fn is_stop_requested() -> bool {
    STOP_REQUESTED.load(Ordering::SeqCst)
}
