//! The open video, and what is remembered of it and of others.

use std::collections::BTreeMap;
use std::path::Path;

use crate::app::model::marks::Marks;
use crate::source::{Options, name_of, path_of};

/// Maximum number of recent videos.
const MAX_RECENT_VIDEOS: usize = 10;

/// The relation of the open video to the list of recent videos.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// The video is added to the list once it has opened.
    New,
    /// The video is in the list.
    Listed,
    /// The bundled sample, which is never listed.
    Sample,
}

/// The open video, and the state of each video by its name.
#[derive(Clone, Debug)]
pub(crate) struct Videos {
    /// The name of the open video.
    pub(crate) opened: Option<String>,
    /// The relation of that video to the list of recent videos.
    pub(crate) origin: Origin,
    /// Recent videos, latest first.
    pub(crate) recent: Vec<String>,
    /// The options with which the open video is read.
    pub(crate) read_with: Options,
    /// The marks in other videos, by name; pixels and positions are those of frames that are read in one way, so that
    /// each way has its own.
    pub(crate) marks: BTreeMap<String, Marks>,
    /// Options of videos that were chosen in the window, by name.
    pub(crate) options: BTreeMap<String, Options>,
    /// The video that the command line opens, with its options, which hold for this run only.
    pub(crate) command_line: Option<(String, Options)>,
}

impl Videos {
    /// No open video, nothing remembered.
    pub(super) const fn new() -> Self {
        Self {
            opened: None,
            origin: Origin::New,
            recent: Vec::new(),
            read_with: Options::AS_IS,
            marks: BTreeMap::new(),
            options: BTreeMap::new(),
            command_line: None,
        }
    }

    /// The options of a video.
    pub(crate) fn options_of(&self, name: &str) -> Options {
        let given = self.command_line.as_ref().filter(|(of, _)| of == name).map(|(_, options)| *options);
        given.or_else(|| self.options.get(name).copied()).unwrap_or_default()
    }

    /// Sets the options of a video, in place of those of the command line.
    pub(crate) fn set_options(&mut self, name: &str, options: Options) {
        self.command_line = self.command_line.take().filter(|(of, _)| of != name);
        if options.is_default() {
            self.options.remove(name);
        } else {
            self.options.insert(name.to_owned(), options);
        }
    }

    /// Stores the marks of the open video under its name.
    pub(crate) fn store_marks(&mut self, marks: &Marks) {
        let Some(key) = self.marks_key() else { return };
        if marks.is_empty() {
            self.marks.remove(&key);
        } else {
            self.marks.insert(key, marks.clone());
        }
    }

    /// The stored marks of the open video.
    pub(super) fn stored_marks(&self) -> Marks {
        self.marks_key().and_then(|key| self.marks.get(&key).cloned()).unwrap_or_default()
    }

    /// The key of the open video's marks: its name, with the options that change its frames.
    fn marks_key(&self) -> Option<String> {
        let name = self.opened.as_ref()?;
        let read_with = Options { fps: None, ..self.read_with };
        if read_with.is_default() {
            return Some(name.clone());
        }
        Some(format!("{name} {}", serde_json::to_string(&read_with).ok()?))
    }

    /// The options of the open video.
    pub(crate) fn opened_options(&self) -> Options {
        self.opened.as_ref().map_or_else(Options::default, |name| self.options_of(name))
    }

    /// Moves the open video to the front of the recent videos, unless it is `live`.
    pub(super) fn remember(&mut self, live: bool) {
        self.origin = Origin::Listed;
        let Some(name) = self.opened.as_ref().filter(|_| !live) else { return };
        // A relative name from the command line depends on the working directory.
        let whole = std::path::absolute(path_of(name)).ok().filter(|path| path.exists());
        let name = whole.map_or_else(|| name.clone(), name_of);
        self.recent.retain(|other| *other != name);
        self.recent.insert(0, name);
        self.recent.truncate(MAX_RECENT_VIDEOS);
    }
}

/// The last part of a video's path.
pub(crate) fn file_name(name: &str) -> &str {
    Path::new(name).file_name().and_then(|last| last.to_str()).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_of_the_command_line_precede_those_chosen_before() {
        let mut videos = Videos::new();
        let of_rate = |fps| Options { fps: Some(fps), ..Options::default() };
        videos.set_options("a.mp4", of_rate(12.5));
        videos.command_line = Some(("b.mp4".into(), of_rate(30.0)));
        assert_eq!(
            ["a.mp4", "b.mp4", "c.mp4"].map(|name| videos.options_of(name).fps),
            [Some(12.5), Some(30.0), None]
        );
        videos.command_line = Some(("a.mp4".into(), of_rate(50.0)));
        assert_eq!(videos.options_of("a.mp4").fps, Some(50.0));
        videos.set_options("a.mp4", of_rate(20.0));
        assert_eq!(videos.options_of("a.mp4").fps, Some(20.0), "chosen later");
        videos.set_options("a.mp4", Options::default());
        assert!(videos.options.is_empty(), "nothing is kept of a video that is read as it is");
    }

    #[test]
    fn marks_belong_to_a_way_of_reading() {
        let mut videos = Videos::new();
        let mut marks = Marks::default();
        marks.toggle_bookmark(7);
        videos.opened = Some("a.mp4".into());
        videos.store_marks(&marks);
        videos.read_with = Options { scale: Some(0.5), ..Options::default() };
        assert!(videos.stored_marks().is_empty(), "those of whole frames are elsewhere in smaller ones");
        videos.store_marks(&Marks::default());
        videos.read_with = Options { fps: Some(5.0), ..Options::default() };
        assert_eq!(videos.stored_marks(), marks, "the rate changes no frame");
    }

    #[test]
    fn recent_videos_are_listed_once_and_latest_first() {
        let mut videos = Videos::new();
        for (name, live) in [("a", false), ("b", false), ("camera", true), ("a", false)] {
            videos.opened = Some(name.into());
            videos.remember(live);
        }
        assert_eq!(videos.recent, ["a", "b"]);
        for number in 0..20 {
            videos.opened = Some(format!("video-{number}"));
            videos.remember(false);
        }
        assert_eq!((videos.recent.len(), videos.recent[0].as_str()), (10, "video-19"));
    }

    #[test]
    fn the_file_name_is_the_last_part_of_a_path() {
        assert_eq!(["/videos/walk.mp4", "walk.mp4", "/"].map(file_name), ["walk.mp4", "walk.mp4", "/"]);
    }
}
