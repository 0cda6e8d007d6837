//! Keeps OpenCV and FFmpeg from writing to the terminal; errors are reported by the program itself.

use std::sync::Once;

/// Silences OpenCV and FFmpeg for the rest of the process, also where the environment asks them to speak.
///
/// Opening a source does this as well. A program should call it first in `main`, before it starts a thread, because
/// OpenCV takes FFmpeg's log level only from the environment.
pub fn silence_libraries() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Fails only where OpenCV is missing, which other calls report.
        let _ = opencv::core::set_log_level(opencv::core::LogLevel::LOG_LEVEL_SILENT);
        ffmpeg::log::set_level(ffmpeg::log::Level::Quiet);
        set_environment();
    });
}

/// Sets AV_LOG_QUIET in the variable that OpenCV reads when it first uses FFmpeg, and removes those that ask for more.
#[expect(unsafe_code, reason = "OpenCV has no other way to set FFmpeg's log level than the environment")]
fn set_environment() {
    // SAFETY: called once. A program calls it before it has a second thread; the standard library locks its own reads
    // of the environment, and no other code of ours reads these variables.
    unsafe {
        std::env::set_var("OPENCV_FFMPEG_LOGLEVEL", "-8");
        for name in ["OPENCV_FFMPEG_DEBUG", "GST_DEBUG", "GST_DEBUG_FILE", "GST_DEBUG_DUMP_DOT_DIR"] {
            std::env::remove_var(name);
        }
    }
}
