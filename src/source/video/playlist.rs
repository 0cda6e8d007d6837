//! Playlists of a video in parts (HLS), as files. FFmpeg leaves out parts that are missing without a word.

use std::fs;
use std::path::Path;

const START: &str = "#EXTM3U";

/// Whether a text is a playlist.
pub(super) fn is_playlist(start: &[u8]) -> bool {
    start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start).starts_with(START.as_bytes())
}

/// A warning of parts that are missing, if any. Fails with the reason where none can be read.
pub(super) fn check_parts(name: &str, path: &Path) -> Result<Option<String>, String> {
    let bytes = fs::read(path).map_err(|error| format!("{error}; check its permissions"))?;
    let text = String::from_utf8_lossy(&bytes);
    let parts = || text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let remedy = "download it with its parts";
    // What is in a file must not open a network address.
    if let Some(address) = parts().find(|part| part.contains("://")) {
        return Err(format!(
            "it is a playlist of parts on the network, such as {address}; give its address, or {remedy}"
        ));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let missing: Vec<&str> = parts().filter(|part| !folder.join(part).is_file()).collect();
    match (missing.first(), parts().count()) {
        (_, 0) => Err(format!("it is a playlist without parts; {remedy}")),
        (None, _) => Ok(None),
        (Some(first), all) if missing.len() == all => {
            Err(format!("it is a playlist, and none of its {all} parts exists, such as {first}; {remedy}"))
        }
        (Some(first), all) => Ok(Some(format!(
            "{name} is a playlist, and {} of its {all} parts do not exist, the first of them {first}; their frames are \
             missing",
            missing.len()
        ))),
    }
}
