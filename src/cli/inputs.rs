//! The inputs of a command, which no output may replace.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::ArgMatches;

use crate::export::staging::IsFolder;
use crate::source::{SceneFolder, has_image_name, path_of};

/// The files and folders that a video is read from: a file, or a folder of images.
pub(super) fn of_video(name: &str) -> Vec<PathBuf> {
    let path = path_of(name).into_owned();
    if path.is_file() {
        return vec![path];
    }
    if path.is_dir() {
        return vec![SceneFolder::at(&path).map_or(path, |scene| scene.images)];
    }
    // Images that a pattern names.
    path.parent().filter(|folder| folder.is_dir()).map(Path::to_path_buf).into_iter().collect()
}

/// The video of a command, and its files of settings and of the region of interest.
pub(super) fn of_command(matches: &ArgMatches) -> Vec<PathBuf> {
    let video = matches.try_get_one::<String>("video").ok().flatten();
    let file = |flag| matches.try_get_one::<PathBuf>(flag).ok().flatten().cloned();
    let files = ["settings", "roi"].into_iter().filter_map(file);
    video.into_iter().flat_map(|video| of_video(video)).chain(files).collect()
}

/// Fails if one of the `outputs` is an input, an image in a folder of images that is an input, or such a folder.
pub(super) fn protect<'a>(
    inputs: &[PathBuf],
    outputs: impl IntoIterator<Item = (&'a Path, IsFolder)>,
) -> anyhow::Result<()> {
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
    for (output, is_folder) in outputs {
        let Ok(place) = output.canonicalize() else { continue };
        let is_within = |input: &PathBuf| {
            is_folder == IsFolder::No && place.parent() == Some(input) && has_image_name(&place)
        };
        if inputs.iter().any(|input| *input == place || is_within(input)) {
            bail!(
                "{} is an input of this command and would be replaced; choose another --out",
                output.display()
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::fs;

    use super::*;

    #[test]
    fn no_output_is_an_input_also_through_links_and_other_names() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        fs::create_dir_all(at("out/masks")).unwrap();
        for name in ["a.mp4", "out/masks/000001.png", "out/masks/notes.txt", "out/tracks.csv"] {
            fs::write(at(name), "mine").unwrap();
        }
        let is_refused = |input: &str, output: PathBuf, is_folder| {
            protect(&of_video(at(input).to_str().unwrap()), [(output.as_path(), is_folder)]).is_err()
        };
        for (input, output, is_folder, expected) in [
            ("a.mp4", "out/../a.mp4", IsFolder::No, true),
            ("a.mp4", "b.mp4", IsFolder::No, false),
            ("out/masks", "out/masks", IsFolder::Yes, true),
            ("out/masks", "out/masks/000001.png", IsFolder::No, true),
            ("out/masks/%06d.png", "out/masks", IsFolder::Yes, true),
            ("out/masks", "out/masks/notes.txt", IsFolder::No, false),
            ("out/masks", "out/frames", IsFolder::Yes, false),
            ("out/masks", "out/tracks.csv", IsFolder::No, false),
        ] {
            assert_eq!(is_refused(input, at(output), is_folder), expected, "{input}, {output}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("a.mp4"), at("link")).unwrap();
            assert!(is_refused("a.mp4", at("link"), IsFolder::No));
        }
    }
}
