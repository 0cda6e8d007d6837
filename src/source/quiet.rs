//! Keeps OpenCV and FFmpeg from writing to the terminal: what goes wrong is told in our own words.

use std::sync::Once;

/// Silences OpenCV and FFmpeg for the rest of the process.
///
/// Opening a source does it, too; a program calls it first thing in `main`, before it starts a
/// thread, because OpenCV takes FFmpeg's log level from the environment alone.
/// Who sets `OPENCV_LOG_LEVEL` or `OPENCV_FFMPEG_LOGLEVEL` wants to see the messages, and does.
pub fn silence_libraries() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        if std::env::var_os("OPENCV_LOG_LEVEL").is_none() {
            // It can only fail where OpenCV is not there at all, and that shows soon enough.
            let _ = opencv::core::set_log_level(opencv::core::LogLevel::LOG_LEVEL_SILENT);
        }
        if std::env::var_os("OPENCV_FFMPEG_LOGLEVEL").is_none() {
            set_ffmpeg_level();
        }
    });
}

/// AV_LOG_QUIET, as OpenCV reads it when it first meets FFmpeg.
#[expect(unsafe_code, reason = "OpenCV has no other way to set FFmpeg's log level than the environment")]
fn set_ffmpeg_level() {
    // SAFETY: called once. A program calls it before it has a second thread; the standard library
    // guards its own readers of the environment; no other of ours reads it.
    unsafe { std::env::set_var("OPENCV_FFMPEG_LOGLEVEL", "-8") };
}
