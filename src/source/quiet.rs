//! Keeps OpenCV and FFmpeg from writing to the terminal; errors are reported by the program itself.

use std::sync::Once;

/// Silences OpenCV and FFmpeg for the rest of the process.
///
/// Opening a source does this as well. A program should call it first in `main`, before it starts a thread, because
/// OpenCV takes FFmpeg's log level only from the environment. It changes nothing where `OPENCV_LOG_LEVEL` or
/// `OPENCV_FFMPEG_LOGLEVEL` is set.
pub fn silence_libraries() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        if std::env::var_os("OPENCV_LOG_LEVEL").is_none() {
            // Fails only where OpenCV is missing, which other calls report.
            let _ = opencv::core::set_log_level(opencv::core::LogLevel::LOG_LEVEL_SILENT);
        }
        if std::env::var_os("OPENCV_FFMPEG_LOGLEVEL").is_none() {
            ffmpeg::log::set_level(ffmpeg::log::Level::Quiet);
            set_level_for_opencv();
        }
    });
}

/// Sets AV_LOG_QUIET in the variable that OpenCV reads when it first uses FFmpeg.
#[expect(unsafe_code, reason = "OpenCV has no other way to set FFmpeg's log level than the environment")]
fn set_level_for_opencv() {
    // SAFETY: called once. A program calls it before it has a second thread; the standard library locks its own reads
    // of the environment, and no other code of ours reads it.
    unsafe { std::env::set_var("OPENCV_FFMPEG_LOGLEVEL", "-8") };
}
