//! The sequences of a data set: folders with images or a video and ground truth beside them.

use std::collections::{BTreeMap, HashSet};
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::source::{SceneFolder, VIDEO_ENDINGS, name_of};

/// How deep below the data set's folder sequences are looked for.
const MAX_DEPTH: usize = 6;

/// The folder of true masks, beside that of the images.
const MASKS: &str = "groundtruth";
/// Ground truth beside the images of a sequence.
const TRUTHS: [&str; 2] = [MASKS, "gt/gt.txt"];
/// The folders of images beside ground truth.
const IMAGES: [&str; 2] = ["input", "img1"];

/// A sequence with its ground truth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// Its name, unique within a sweep; within a data set its path below the data set's folder, with `/`.
    pub name: String,
    /// The name of the source.
    pub video: String,
    /// The path of the ground truth.
    pub truth: PathBuf,
}

/// The sequences of a data set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DataSet {
    /// Those with images and ground truth, in natural order of their names.
    pub sequences: Vec<Sequence>,
    /// The names of folders that are left out, by reason.
    pub left_out: BTreeMap<LeftOut, Vec<String>>,
}

/// Why a folder of a data set is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftOut {
    /// It has images, but no ground truth.
    NoTruth,
    /// It has ground truth, but neither images nor a video.
    NoImages,
    /// It has ground truth and several videos.
    SeveralVideos,
    /// It is a scene without a part, or with a description that cannot be read.
    DamagedScene,
    /// It cannot be read.
    Unreadable,
    /// Another sequence has its name, as characters that cannot be written are replaced.
    SameName,
}

impl LeftOut {
    /// The reason and a remedy.
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoTruth => {
                "there are images, but neither groundtruth/ nor gt/gt.txt; add one, or name the ground truth with --sequence"
            }
            Self::NoImages => {
                "there is ground truth, but no images in input/ or img1/ and no video beside it; add them, or name them with --sequence"
            }
            Self::SeveralVideos => {
                "there are several videos beside the ground truth; name the right one with --sequence"
            }
            Self::DamagedScene => {
                "scene.json is damaged or missing, or the video that it names or truth/gt.txt is; write the scene again"
            }
            Self::Unreadable => "the folder cannot be read; check its permissions",
            Self::SameName => {
                "another sequence has the same name but for characters that are no text; rename it"
            }
        }
    }
}

/// The name of a sequence in tables: that of its file or folder, with a replacement for what is no text or no character
/// of a line.
pub fn sequence_name(file: &OsStr) -> String {
    let name = file.to_string_lossy().replace(char::is_control, "\u{fffd}");
    if name.trim().is_empty() { "sequence".to_owned() } else { name }
}

/// The sequences below `root`, or that at `root`, by name: folders with images in `input/` or `img1/`, or one video file,
/// beside `groundtruth/` or `gt/gt.txt`, and scenes written by `synth`. Fails if `root` cannot be read.
///
/// A folder that several links lead to is taken once.
pub fn sequences_below(root: &Path) -> io::Result<DataSet> {
    let mut found = DataSet::default();
    let name = root.file_name().or_else(|| root.parent().and_then(Path::file_name));
    let name = sequence_name(name.unwrap_or_default());
    match sequence_at(root, &name) {
        Some(sequence) => found.sequences.push(sequence),
        None => search(root, "", 0, &mut found, &mut HashSet::new())?,
    }
    Ok(found)
}

impl DataSet {
    fn leave_out(&mut self, why: LeftOut, name: String) {
        self.left_out.entry(why).or_default().push(name);
    }
}

fn search(
    folder: &Path,
    prefix: &str,
    depth: usize,
    found: &mut DataSet,
    visited: &mut HashSet<PathBuf>,
) -> io::Result<()> {
    if !visited.insert(folder.canonicalize()?) {
        return Ok(());
    }
    let mut folders: Vec<(String, PathBuf)> = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = sequence_name(path.file_name().unwrap_or_default());
        if path.is_dir() && !name.starts_with('.') {
            folders.push((name, path));
        }
    }
    folders.sort_by(|a, b| natord::compare(&a.0, &b.0).then_with(|| a.1.cmp(&b.1)));
    for (name, path) in folders {
        let name = if prefix.is_empty() { name } else { format!("{prefix}/{name}") };
        match sequence_at(&path, &name) {
            Some(_) if path.canonicalize().is_ok_and(|path| !visited.insert(path)) => {}
            Some(sequence) if found.sequences.iter().any(|other| other.name == sequence.name) => {
                found.leave_out(LeftOut::SameName, name);
            }
            Some(sequence) => found.sequences.push(sequence),
            None => match missing_part(&path) {
                Some(why) => found.leave_out(why, name),
                None if depth < MAX_DEPTH && search(&path, &name, depth + 1, found, visited).is_err() => {
                    found.leave_out(LeftOut::Unreadable, name);
                }
                None => {}
            },
        }
    }
    Ok(())
}

/// What a folder lacks that has a part of a data set's layout, but is no sequence; `None` if it has no part.
fn missing_part(folder: &Path) -> Option<LeftOut> {
    let has = |names: [&str; 2]| names.iter().any(|name| folder.join(name).exists());
    match (has(TRUTHS), has(IMAGES)) {
        (true, false) if videos_in(folder).len() > 1 => Some(LeftOut::SeveralVideos),
        (true, _) => Some(LeftOut::NoImages),
        (false, true) => Some(LeftOut::NoTruth),
        (false, false) => has(["scene.json", "truth/gt.txt"]).then_some(LeftOut::DamagedScene),
    }
}

/// The video files in a folder, by their endings.
fn videos_in(folder: &Path) -> Vec<PathBuf> {
    let is_video = |path: &PathBuf| {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        VIDEO_ENDINGS.contains(&ending.as_str()) && path.is_file() && !is_hidden(path)
    };
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    files.filter(is_video).collect()
}

fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'))
}

/// The sequence in a folder, if it is that of one.
fn sequence_at(folder: &Path, name: &str) -> Option<Sequence> {
    let sequence =
        |video: &Path, truth: PathBuf| Sequence { name: name.to_owned(), video: name_of(video), truth };
    if let Some(SceneFolder { truth: Some(truth), .. }) = SceneFolder::at(folder) {
        return Some(sequence(folder, truth));
    }
    if let Some((video, truth)) = video_beside_truth(folder) {
        return Some(sequence(&video, truth));
    }
    let video = folder.join(video_of_scene(folder)?);
    (video.is_file() && folder.join("truth").join("gt.txt").is_file())
        .then(|| sequence(&video, folder.to_owned()))
}

/// The only video file in a folder, and the ground truth beside it, if the folder has no place for images.
fn video_beside_truth(folder: &Path) -> Option<(PathBuf, PathBuf)> {
    let truth = TRUTHS.iter().find(|truth| folder.join(truth).exists())?;
    if IMAGES.iter().any(|images| folder.join(images).exists()) {
        return None;
    }
    let [video] = <[PathBuf; 1]>::try_from(videos_in(folder)).ok()?;
    let truth = if *truth == MASKS { folder.to_owned() } else { folder.join(truth) };
    Some((video, truth))
}

/// The name of the video of a scene written by `synth`.
fn video_of_scene(folder: &Path) -> Option<String> {
    #[derive(Deserialize)]
    struct SceneFile {
        video: String,
    }
    let text = fs::read_to_string(folder.join("scene.json")).ok()?;
    let SceneFile { video } = serde_json::from_str(&text).ok()?;
    Some(video)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn sequences_of_all_layouts_are_found_in_natural_order() {
        let root = tempfile::tempdir().unwrap();
        for file in [
            "shadow/cubicle/input/in000001.jpg",
            "shadow/cubicle/groundtruth/gt000001.png",
            "MOT-10/img1/000001.jpg",
            "MOT-10/gt/gt.txt",
            "MOT-9/img1/000001.jpg",
            "MOT-9/gt/gt.txt",
            "tree/tree.mp4",
            "tree/scene.json",
            "tree/truth/gt.txt",
            "untrue/img1/000001.jpg",
            "filmed/street.AVI",
            "filmed/gt/gt.txt",
            "filmed/notes.txt",
            "masked/a.mp4",
            "masked/groundtruth/gt000001.png",
            "twice/a.mp4",
            "twice/b.mkv",
            "twice/gt/gt.txt",
            "empty/input/notes.txt",
            "empty/preview.mp4",
            "empty/groundtruth/gt000001.png",
            "unseen/gt/gt.txt",
            "cut/scene.json",
            "notes/readme.txt",
            ".hidden/img1/000001.jpg",
            ".hidden/gt/gt.txt",
        ] {
            let path = root.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, if file.ends_with("scene.json") { r#"{"video":"tree.mp4"}"# } else { "" })
                .unwrap();
        }
        // A link to a folder above, and one to a sequence.
        #[cfg(unix)]
        for (to, link) in [("", "shadow/back"), ("tree", "again")] {
            std::os::unix::fs::symlink(root.path().join(to), root.path().join(link)).unwrap();
        }
        let DataSet { sequences: found, left_out } = sequences_below(root.path()).unwrap();
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let expected = [
            (LeftOut::NoTruth, names(&["untrue"])),
            (LeftOut::NoImages, names(&["empty", "unseen"])),
            (LeftOut::SeveralVideos, names(&["twice"])),
            (LeftOut::DamagedScene, names(&["cut"])),
        ];
        assert_eq!(left_out, BTreeMap::from(expected));
        let names: Vec<_> = found.iter().map(|it| &*it.name).collect();
        let expected = ["MOT-9", "MOT-10", "again", "filmed", "masked", "shadow/cubicle"];
        assert_eq!(names, expected, "natural order, once each");
        let at = |name: &str| found.iter().find(|it| it.name == name).unwrap();
        assert_eq!(Path::new(&at("again").video), root.path().join("again/tree.mp4"));
        assert_eq!(at("shadow/cubicle").truth, root.path().join("shadow/cubicle"));
        assert_eq!(Path::new(&at("filmed").video), root.path().join("filmed/street.AVI"));
        assert_eq!(at("filmed").truth, root.path().join("filmed/gt/gt.txt"));
        assert_eq!(at("masked").truth, root.path().join("masked"));
        let single = sequences_below(&root.path().join("tree")).unwrap();
        assert_eq!(single.sequences.iter().map(|it| &it.name).collect::<Vec<_>>(), ["tree"]);
        assert!(sequences_below(&root.path().join("notes")).unwrap().sequences.is_empty());
        assert!(sequences_below(&root.path().join("nothing")).is_err());
    }
}
