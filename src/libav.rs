//! What reading and writing files with FFmpeg's libraries have in common.

use std::ffi::OsString;
use std::io;
use std::path::{self, Path};

/// The address by which FFmpeg opens this file and nothing else; `None` where there is none.
pub(crate) fn address(file: &Path) -> Option<OsString> {
    // Without a protocol, a name with a colon would be read as an address.
    let mut address = OsString::from("file:");
    address.push(path::absolute(file).ok()?);
    // The crate panics on a zero byte.
    (!address.as_encoded_bytes().contains(&0)).then_some(address)
}

/// Whether a decoder or encoder asks for more data with this error.
pub(crate) fn wants_data(error: ffmpeg::Error) -> bool {
    let kind = |errno| io::Error::from_raw_os_error(errno).kind();
    matches!(error, ffmpeg::Error::Other { errno } if kind(errno) == io::ErrorKind::WouldBlock)
}
