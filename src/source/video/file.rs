//! A video file or network stream and how it is read.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{fs, io};

use crate::libav;
use crate::source::{Options, path_of};

/// The schemes of addresses, with the protocols that FFmpeg may use for them. Files are not among them: what a server
/// sends must not name files of this machine.
const SCHEMES: [(&str, &str); 3] = [
    ("http://", "http,https,tls,tcp,httpproxy,crypto,data"),
    ("https://", "https,http,tls,tcp,httpproxy,crypto,data"),
    ("rtsp://", "rtsp,rtp,srtp,udp,tcp,tls,http,https"),
];
/// Microseconds after which a server that sends nothing is given up.
const TIMEOUT: &str = "10000000";

/// Whether a name is the address of a network stream.
pub(in crate::source) fn is_address(name: &str) -> bool {
    protocols(name).is_some()
}

/// A name as it may be shown and stored: an address without the user name and password in it.
pub(super) fn without_credentials(name: &str) -> String {
    let Some((scheme, rest)) = name.split_once("://").filter(|_| is_address(name)) else {
        return name.to_owned();
    };
    let host = rest.find(['/', '?', '#']).unwrap_or(rest.len());
    match rest[..host].rfind('@') {
        Some(at) => format!("{scheme}://{}", &rest[at + 1..]),
        None => name.to_owned(),
    }
}

fn protocols(name: &str) -> Option<&'static str> {
    let has_scheme =
        |scheme: &str| name.get(..scheme.len()).is_some_and(|start| start.eq_ignore_ascii_case(scheme));
    SCHEMES.iter().find(|(scheme, _)| has_scheme(scheme)).map(|(_, protocols)| *protocols)
}

/// A video as it was when it was opened first.
#[derive(Clone, Debug)]
pub(super) struct InputFile {
    place: Place,
    /// Index of the stream that is read; `None` for the one that the `ffmpeg` program selects.
    pub(super) stream: Option<u32>,
    /// Whether its frames are deinterlaced.
    pub(super) deinterlace: bool,
}

#[derive(Clone, Debug)]
enum Place {
    /// The absolute path of a file and the version that is read.
    File(PathBuf, Option<Version>),
    /// The address of a network stream.
    Address(String),
}

/// What changes when a file is written to.
type Version = (u64, SystemTime);

impl InputFile {
    /// The present version of the file of this name, or the network stream at this address.
    pub(super) fn new(name: &str, options: Options) -> io::Result<Self> {
        let place = if is_address(name) {
            // FFmpeg knows its protocols in lower case only.
            let (scheme, rest) = name.split_once(':').unwrap_or_default();
            Place::Address(format!("{}:{rest}", scheme.to_lowercase()))
        } else {
            let path = fs::canonicalize(path_of(name))?;
            let version = version(&path);
            Place::File(path, version)
        };
        Ok(Self { place, stream: options.stream, deinterlace: options.deinterlace })
    }

    /// Whether it is a network stream, which is read once.
    pub(super) const fn is_live(&self) -> bool {
        matches!(self.place, Place::Address(_))
    }

    /// Whether the file is still the same.
    pub(super) fn is_unchanged(&self) -> bool {
        match &self.place {
            Place::File(path, expected) => version(path) == *expected,
            Place::Address(_) => true,
        }
    }

    /// Its address for FFmpeg; `None` where there is none.
    pub(super) fn address(&self) -> Option<OsString> {
        match &self.place {
            Place::File(path, _) => libav::address(path),
            // The crate panics on a zero byte.
            Place::Address(address) => (!address.contains('\0')).then(|| address.into()),
        }
    }

    /// The options with which FFmpeg opens it.
    pub(super) fn open_options(&self) -> Vec<(&'static str, &'static str)> {
        match &self.place {
            // A local playlist must not open a network address.
            Place::File(..) => vec![("protocol_whitelist", "file,crypto,data")],
            Place::Address(address) => {
                let protocols = protocols(address).unwrap_or_default();
                // Over UDP, packets are lost.
                vec![("protocol_whitelist", protocols), ("timeout", TIMEOUT), ("rtsp_flags", "prefer_tcp")]
            }
        }
    }
}

fn version(path: &Path) -> Option<Version> {
    let metadata = fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_password_in_an_address_is_not_shown() {
        for (name, shown) in [
            ("rtsp://user:w@rd@10.0.0.7:554/stream?a=1", "rtsp://10.0.0.7:554/stream?a=1"),
            ("http://a/b@c.mp4", "http://a/b@c.mp4"),
            ("a@b.mp4", "a@b.mp4"),
        ] {
            assert_eq!(without_credentials(name), shown);
        }
    }

    #[test]
    fn addresses_are_distinguished_from_files() {
        for address in ["http://a/b.mp4", "HTTPS://a", "rtsp://user:word@10.0.0.7:554/stream?a=1"] {
            assert!(is_address(address), "{address}");
        }
        for name in ["a.mp4", "http:a.mp4", "file:///a.mp4", "rtsp", "ftp://a/b.mp4", "ü", "camera:0"] {
            assert!(!is_address(name), "{name}");
        }
    }
}
