//! A second copy of the window's state. The library that stores it writes over the only one, so that the state would be lost
//! where the program is killed or the disk is full in that moment.

use std::collections::HashMap;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// The library's file, in its folder.
const FILE: &str = "app.ron";
/// The copy beside it.
const COPY: &str = "app.ron.kept";

/// The folder of the state, which is that of the window's identifier; `None` where the system has none.
pub(crate) fn folder(app_id: &str) -> Option<PathBuf> {
    eframe::storage_dir(app_id)
}

/// Copies the state where it is whole, before it is written again.
pub(crate) fn keep(folder: &Path) {
    let state = folder.join(FILE);
    if let Some(text) = whole(&state)
        && fs::read_to_string(folder.join(COPY)).ok().as_ref() != Some(&text)
    {
        // Without a copy the state is as safe as the library makes it.
        let _ = place(folder, COPY, &text);
    }
}

/// Restores the state from its copy where it is there but not whole.
pub(crate) fn restore(folder: &Path) {
    let state = folder.join(FILE);
    if state.exists()
        && whole(&state).is_none()
        && let Some(text) = whole(&folder.join(COPY))
    {
        let _ = place(folder, FILE, &text);
    }
}

/// The text of a state that can be read to its end.
fn whole(path: &Path) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    ron::from_str::<HashMap<String, String>>(&text).ok()?;
    Some(text)
}

/// Writes a file in one step. It does not wait for the disk, because the window waits for it.
fn place(folder: &Path, name: &str, text: &str) -> io::Result<()> {
    let draft = folder.join(format!("{name}.new"));
    fs::File::create(&draft)?.write_all(text.as_bytes())?;
    fs::rename(draft, folder.join(name))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_cut_state_is_restored_from_its_copy() {
        let folder = tempfile::tempdir().unwrap();
        let (state, copy) = (folder.path().join(FILE), folder.path().join(COPY));
        let read = || fs::read_to_string(&state).unwrap();
        restore(folder.path());
        keep(folder.path());
        assert!(!state.exists() && !copy.exists());
        let whole = "{\n    \"window\": \"(light:true,text:\\\"}\\\")\",\n}";
        fs::write(&state, whole).unwrap();
        keep(folder.path());
        for cut in 0..whole.len() {
            fs::write(&state, &whole[..cut]).unwrap();
            keep(folder.path());
            restore(folder.path());
            assert_eq!(read(), whole, "cut after {cut} bytes");
        }
        let newer = whole.replace("true", "false");
        fs::write(&state, &newer).unwrap();
        restore(folder.path());
        assert_eq!(read(), newer);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
