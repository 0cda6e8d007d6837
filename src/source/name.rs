//! Names of sources as text.
//!
//! A path need not be text. Its bytes that are not UTF-8 are characters of a private area in a name, so that names fit all
//! files that hold text, and still lead to the path. [`shown`] is what people see of them.

use std::borrow::Cow;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The character of byte 0. Only bytes from 128 on are not UTF-8.
const FIRST: u32 = 0x10_FE00;

/// The name of a path, an address or a camera.
pub fn name_of(path: impl AsRef<OsStr>) -> String {
    let mut name = String::new();
    for chunk in path.as_ref().as_encoded_bytes().utf8_chunks() {
        for c in chunk.valid().chars() {
            if byte_of(c).is_some() {
                // Such a character in a path must not become a byte.
                let mut bytes = [0; 4];
                name.extend(c.encode_utf8(&mut bytes).bytes().map(character));
            } else {
                name.push(c);
            }
        }
        name.extend(chunk.invalid().iter().copied().map(character));
    }
    name
}

/// The path of a name.
pub fn path_of(name: &str) -> Cow<'_, Path> {
    if !name.contains(is_byte) {
        return Cow::Borrowed(Path::new(name));
    }
    let mut bytes = Vec::new();
    for c in name.chars() {
        match byte_of(c) {
            Some(byte) => bytes.push(byte),
            None => bytes.extend(c.encode_utf8(&mut [0; 4]).bytes()),
        }
    }
    Cow::Owned(PathBuf::from(os_string(bytes)))
}

/// A text with names in it, for people: a replacement character for each byte that is not UTF-8.
pub fn shown(text: &str) -> Cow<'_, str> {
    if text.contains(is_byte) { Cow::Owned(text.replace(is_byte, "\u{fffd}")) } else { Cow::Borrowed(text) }
}

#[cfg(unix)]
fn os_string(bytes: Vec<u8>) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes)
}

/// Paths of other systems are text that can lack halves of characters; these do not come back.
#[cfg(not(unix))]
fn os_string(bytes: Vec<u8>) -> OsString {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

fn character(byte: u8) -> char {
    char::from_u32(FIRST + u32::from(byte)).unwrap_or(char::REPLACEMENT_CHARACTER)
}

fn byte_of(c: char) -> Option<u8> {
    u8::try_from(u32::from(c).checked_sub(FIRST)?).ok().filter(|byte| *byte >= 0x80)
}

fn is_byte(c: char) -> bool {
    byte_of(c).is_some()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn every_path_has_a_name_that_leads_back_to_it() {
        let private = character(0xe9).to_string();
        for bytes in [
            b"street.mp4".as_slice(),
            b"caf\xe9/in%06d.png",
            b"\xff\xfe\x80",
            "straße — 1:2\n.mp4".as_bytes(),
            private.as_bytes(),
            b"cut \xf0\x9f",
            b"",
        ] {
            let path = PathBuf::from(os_string(bytes.to_vec()));
            assert_eq!(path_of(&name_of(&path)), path);
        }
        assert_eq!(name_of("straße"), "straße");
        assert_eq!(shown(&name_of(os_string(b"caf\xe9: no".to_vec()))), "caf\u{fffd}: no");
    }
}
