//! The SHA-256 of the input.

use std::fs::File;
use std::io::{self, Read};
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::thread::{self, JoinHandle};

use anyhow::Context as _;
use sha2::{Digest, Sha256};

use super::record::RunRecord;
use crate::source::{SourceInfo, path_of};

/// The hash of a video file, computed on a thread of its own. Images are hashed as they are decoded, a camera is not.
pub(super) struct InputHash {
    video: String,
    of_file: Option<JoinHandle<io::Result<String>>>,
}

impl InputHash {
    /// Starts hashing `video` if it is a file.
    pub(super) fn start(video: &str) -> Self {
        let hash =
            |path: PathBuf| thread::Builder::new().name("hash".to_owned()).spawn(|| hash_of_file(path));
        let of_file = Some(path_of(video).into_owned()).filter(|path| path.is_file());
        Self { video: video.to_owned(), of_file: of_file.and_then(|path| hash(path).ok()) }
    }

    /// Waits for the hash of the file; without one it is that of the decoded frames, `None` for a camera.
    pub(super) fn finish(self, record: &RunRecord) -> anyhow::Result<Option<String>> {
        let Some(of_file) = self.of_file else { return Ok(record.frames_hash.clone()) };
        let hash = of_file.join().unwrap_or_else(|panic| resume_unwind(panic));
        let hash = hash.with_context(|| {
            format!("{} cannot be read to its end; check that it is still there", self.video)
        })?;
        Ok(Some(hash))
    }
}

/// Whether frames come from a folder or a pattern of images.
pub(super) fn is_images(info: &SourceInfo) -> bool {
    !info.live && !path_of(&info.name).is_file()
}

/// The digits of a hash.
pub(in crate::cli) fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn hash_of_file(path: PathBuf) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hasher = Sha256::new();
    let mut part = vec![0; 1 << 16];
    loop {
        match file.read(&mut part)? {
            0 => return Ok(hexadecimal(&hasher.finalize())),
            read => hasher.update(&part[..read]),
        }
    }
}
