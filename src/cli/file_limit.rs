//! The largest size of a file (`ulimit -f`).

#![expect(unsafe_code, reason = "the standard library has no safe access to signals")]

/// Makes a write beyond the largest size an error instead of a signal, which ends the process and leaves
/// temporary files.
pub(super) fn make_an_error() {
    #[cfg(unix)]
    // SAFETY: ignoring a signal installs no handler, and no other thread runs at the start of the program.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}
