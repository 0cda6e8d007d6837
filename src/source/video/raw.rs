//! What the crate cannot do safely: fields of FFmpeg's structures, some of which it reads with a panic on unknown values,
//! and the count of reported errors.

#![expect(unsafe_code, reason = "the crate has no safe access to these numbers and to the log")]

use std::cell::Cell;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::atomic::{AtomicU64, Ordering};

use ffmpeg::ffi::{AV_LOG_ERROR, AVDiscard, av_log_set_callback};
use ffmpeg::format::context::Input;
use ffmpeg::frame::Video as Picture;

/// The colour description of a picture, as the numbers of ITU-T H.273, and the range of its levels.
///
/// The crate's own readers panic on a number that they do not know, and containers pass on any number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ColorNumbers {
    /// Matrix: 1 is BT.709, 2 unspecified, 5 and 6 BT.601, 9 BT.2020.
    pub(super) matrix: u32,
    /// Transfer characteristic: 16 is PQ, 18 HLG.
    pub(super) transfer: u32,
    /// 0 is unspecified, 1 limited, 2 full.
    pub(super) range: u32,
}

/// The colour description of a picture.
pub(super) fn colors(picture: &Picture) -> ColorNumbers {
    // SAFETY: a picture that was decoded into owns a valid AVFrame for as long as the borrow. The fields are numbers;
    // their types are newtypes of integers, so any value is valid.
    let frame = unsafe { &*picture.as_ptr() };
    // The integers are signed on Windows.
    #[allow(clippy::unnecessary_cast, reason = "the type differs between platforms")]
    ColorNumbers {
        matrix: frame.colorspace.0 as u32,
        transfer: frame.color_trc.0 as u32,
        range: frame.color_range.0 as u32,
    }
}

/// Whether the decoder found errors in the picture's data or concealed them.
pub(super) fn has_errors(picture: &Picture) -> bool {
    // SAFETY: as in `colors`.
    unsafe { (*picture.as_ptr()).decode_error_flags != 0 }
}

/// Whether the stream says that the picture consists of two fields of different times.
pub(super) fn is_interlaced(picture: &Picture) -> bool {
    picture.is_interlaced()
}

/// The flag where the crate has no method for it, with FFmpeg 8 and newer.
///
/// Where the crate has the method, it takes precedence over this one.
#[allow(dead_code, reason = "used where the crate has no method")]
trait InterlacedFlag {
    fn is_interlaced(&self) -> bool;
}

impl InterlacedFlag for Picture {
    fn is_interlaced(&self) -> bool {
        /// FFmpeg's `AV_FRAME_FLAG_INTERLACED`, which 5.1 does not have.
        const INTERLACED: c_int = 1 << 3;
        // SAFETY: as in `colors`.
        unsafe { (*self.as_ptr()).flags & INTERLACED != 0 }
    }
}

/// Makes the demuxer drop the packets of all streams except this one.
pub(super) fn select_stream(input: &mut Input, selected: usize) {
    for index in 0..input.nb_streams() as usize {
        let Some(mut stream) = input.stream_mut(index) else { continue };
        let discard = if index == selected { AVDiscard::DEFAULT } else { AVDiscard::ALL };
        // SAFETY: the stream belongs to the context that is borrowed mutably; FFmpeg lets the caller set this field to
        // one of these values at any time.
        unsafe { (*stream.as_mut_ptr()).discard = discard };
    }
}

/// Number of errors that FFmpeg reported in this process.
static REPORTED_ERRORS: AtomicU64 = AtomicU64::new(0);

/// Number of parts of streams that FFmpeg could not open in this process.
static MISSED_PARTS: AtomicU64 = AtomicU64::new(0);

/// The start of FFmpeg's message of such a part, which is no error.
const MISSED_PART: &[u8] = b"Failed to open segment";

thread_local! {
    /// Number of errors that FFmpeg reported on this thread.
    static REPORTED_ERRORS_HERE: Cell<u64> = const { Cell::new(0) };
}

/// Number of errors that FFmpeg reported in this process, in any file, since [`count_reported_errors`] was called.
pub(super) fn reported_errors() -> u64 {
    REPORTED_ERRORS.load(Ordering::SeqCst)
}

/// Number of errors that FFmpeg reported on this thread since [`count_reported_errors`] was called. A decoder of one thread
/// works and reports on the thread that calls it.
pub(super) fn reported_errors_here() -> u64 {
    REPORTED_ERRORS_HERE.get()
}

/// Number of parts of streams (HLS) that could not be opened in this process, since [`count_reported_errors`] was called.
/// FFmpeg goes on with the next one.
pub(super) fn missed_parts() -> u64 {
    MISSED_PARTS.load(Ordering::SeqCst)
}

/// Counts FFmpeg's error messages from now on; they are not printed. OpenCV may end this when it opens a file.
pub(super) fn count_reported_errors() {
    // SAFETY: FFmpeg lets the callback be set at any time; it may be called from any thread, and `count` only reads the
    // format and changes atomic numbers and one of its thread.
    unsafe { av_log_set_callback(Some(count)) };
}

/// The type of the last argument, the values of a message, depends on the platform.
unsafe extern "C" fn count<Values>(_: *mut c_void, level: c_int, format: *const c_char, _: Values) {
    // The upper bits are a colour.
    if level & 0xff <= AV_LOG_ERROR as c_int {
        REPORTED_ERRORS.fetch_add(1, Ordering::SeqCst);
        // A thread that ends has none any more.
        let _ = REPORTED_ERRORS_HERE.try_with(|errors| errors.set(errors.get() + 1));
    }
    // SAFETY: a format is a string that lasts for the call.
    if !format.is_null() && unsafe { CStr::from_ptr(format) }.to_bytes().starts_with(MISSED_PART) {
        MISSED_PARTS.fetch_add(1, Ordering::SeqCst);
    }
}
