//! Where files are while they are incomplete: `DIR/.occluscope-XXXXXX/new/NAME` for the file `DIR/NAME`.

use std::path::{Component, Path, PathBuf};

/// The beginning of the names of hidden folders.
pub(super) const PREFIX: &str = ".occluscope-";
/// The folder of the files that are being written, in a hidden folder.
pub(super) const NEW: &str = "new";

/// The final path of a staged file, the folder in which a hidden folder is, and any other path as it is.
pub(super) fn final_path(path: &Path) -> PathBuf {
    let is_hidden = |part: &Component<'_>| part.as_os_str().to_string_lossy().starts_with(PREFIX);
    let mut parts = path.components().peekable();
    let mut result = PathBuf::new();
    while let Some(part) = parts.next() {
        // A user's own folder may have such a name.
        let holds_staged = parts.peek().is_none_or(|next| next.as_os_str() == NEW);
        if is_hidden(&part) && holds_staged {
            parts.next();
        } else {
            result.push(part);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_final_path_is_without_the_hidden_folder() {
        for (staged, expected) in [
            ("out/.occluscope-x1/new/masks/a.png", "out/masks/a.png"),
            (".occluscope-x1/new", ""),
            ("out/.occluscope-x1", "out"),
            ("out/masks/a.png", "out/masks/a.png"),
            ("/home/me/.occluscope-results/masks/a.png", "/home/me/.occluscope-results/masks/a.png"),
            ("/home/me/.occluscope-results/.occluscope-x1/new/a.png", "/home/me/.occluscope-results/a.png"),
        ] {
            assert_eq!(final_path(Path::new(staged)), Path::new(expected), "{staged}");
        }
    }
}
