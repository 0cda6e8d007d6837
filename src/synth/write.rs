//! A scene as files: a video and its truth.
//!
//! | file | form |
//! | --- | --- |
//! | `NAME.mp4` | for [playback](VideoKind::Playback); [lossless](VideoKind::Lossless): `NAME.avi`, with exactly the rendered bits |
//! | `truth/identities/000001.png` | 8 bit: the identity visible at the pixel, 0 for the background, parked cars and occluders |
//! | `truth/gt.txt` | MOTChallenge, no header: `frame,id,x,y,w,h,1,1,visibility`; the box of the full silhouette clipped to the image, from enter to exit, occluded or not; the first pixel is (0, 0); the first 1 is 0 while a car is parked |
//! | `truth/events.jsonl` | one event per line: `frame`, `kind`, `objects`, `becomes`, `x`, `y`, `front` |
//! | `truth/episodes.csv` | header `kind,objects,start,end,least_visible,front,identities_kept` |
//! | `scene.json` | name, seed, size, fps, frames, the video's name, the parameters, and everything that is in the scene |
//!
//! All files are written to a hidden folder in the output folder and moved when all are complete, `scene.json` last.

use std::fs;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::catalogue::SceneParameters;
use super::render::{FrameTruth, Renderer};
use super::scene::Scene;
use super::truth::{Recorder, SceneTruth};
use crate::export::Staging;
use crate::export::staging::IsFolder;
use crate::export::video::{VideoError, VideoFile, VideoKind};
use crate::export::write_failure::describe;
use crate::frame::Size;

/// The folder of the truth.
const TRUTH_FOLDER: &str = "truth";
/// The folder of the identity images.
const IDENTITIES: &str = "truth/identities";
/// The other files of the truth.
const TRUTH: [&str; 3] = ["truth/gt.txt", "truth/events.jsonl", "truth/episodes.csv"];
/// The description of the scene.
const SCENE: &str = "scene.json";

/// Number of frames rendered at once: enough for all cores, few enough for memory at any size.
const BATCH: u32 = 16;

/// An error of writing a scene. Each message names the file, the problem, its cause and a remedy.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// A file or folder cannot be written.
    #[error("{0}")]
    File(io::Error),
    /// The video cannot be encoded.
    #[error("{} cannot be encoded: {why}", path.display())]
    Video {
        /// Its path.
        path: PathBuf,
        /// The cause.
        why: VideoError,
    },
    /// The ground truth in the folder is that of another video there.
    #[error(
        "{video} would lose its ground truth, {truth}, which is replaced; remove it, or choose another folder",
        truth = truth.display(), video = video.display()
    )]
    OtherVideo {
        /// The other video.
        video: PathBuf,
        /// The folder of the ground truth.
        truth: PathBuf,
    },
    /// The callback `progress` stopped the work.
    #[error("stopped before the end of the scene; nothing was written")]
    Stopped,
}

impl From<io::Error> for WriteError {
    fn from(error: io::Error) -> Self {
        Self::File(error)
    }
}

/// The contents of `scene.json`.
#[derive(Serialize)]
struct SceneFile<'a> {
    #[serde(flatten)]
    scene: &'a Scene,
    video: &'a str,
    parameters: &'a SceneParameters,
    version: &'static str,
}

/// Renders a scene into folder `out`, which is created if necessary, and returns the path of the video. Only existing
/// files of the same names are replaced, and identity images beyond the scene's frames removed. Fails where `out` holds
/// another video, which would lose its ground truth. `progress` is called
/// with the number of rendered frames and can stop the work.
pub fn write(
    scene: &Scene,
    parameters: &SceneParameters,
    out: &Path,
    lossless: bool,
    mut progress: impl FnMut(u32) -> ControlFlow<()>,
) -> Result<PathBuf, WriteError> {
    let out = &std::path::absolute(out).map_err(|error| describe(out, error))?;
    let staging = Staging::new(out)?;
    let kind = if lossless { VideoKind::Lossless } else { VideoKind::Playback };
    let video_name = format!("{}.{}", scene.name, kind.extension());
    let files =
        TRUTH.into_iter().chain([video_name.as_str(), SCENE]).map(|name| (Path::new(name), IsFolder::No));
    staging.check(files.chain([(Path::new(IDENTITIES), IsFolder::Yes)]))?;
    check_other_video(out, &video_name)?;
    let identities = staging.folder(IDENTITIES)?;

    let video_error = |error| match error {
        VideoError::File(error) => WriteError::File(error),
        why => WriteError::Video { path: out.join(&video_name), why },
    };
    let video = VideoFile::create(kind, &staging.path(&video_name), scene.size, scene.fps, None);
    let mut video = video.map_err(video_error)?;
    let renderer = Renderer::new(scene);
    let mut recorder = Recorder::new(scene.fps);
    for first in (1..=scene.frames).step_by(BATCH as usize) {
        let last = first.saturating_add(BATCH - 1).min(scene.frames);
        let batch: Vec<_> = (first..=last).into_par_iter().map(|number| renderer.frame(number)).collect();
        batch.par_iter().try_for_each(|(_, truth)| write_identities(&identities, truth))?;
        for (frame, truth) in &batch {
            video.write(frame, frame.time).map_err(video_error)?;
            recorder.push(truth);
        }
        if progress(last).is_break() {
            return Err(WriteError::Stopped);
        }
    }
    video.finish().map_err(video_error)?;

    write_truth(&staging, &recorder.finish())?;
    let description = SceneFile { scene, video: &video_name, parameters, version: env!("CARGO_PKG_VERSION") };
    let text = serde_json::to_string_pretty(&description).map_err(io::Error::from)?;
    write_text(&staging, SCENE, &(text + "\n"))?;
    staging.publish(SCENE)?;
    Ok(out.join(video_name))
}

/// Fails if the scene in `out` has another video than `video_name`.
fn check_other_video(out: &Path, video_name: &str) -> Result<(), WriteError> {
    #[derive(Deserialize)]
    struct EarlierScene {
        video: String,
    }
    let Ok(text) = fs::read_to_string(out.join(SCENE)) else { return Ok(()) };
    let Ok(EarlierScene { video }) = serde_json::from_str(&text) else { return Ok(()) };
    let path = out.join(&video);
    if video != video_name && path.is_file() {
        return Err(WriteError::OtherVideo { video: path, truth: out.join(TRUTH_FOLDER) });
    }
    Ok(())
}

fn image_name(number: u32) -> String {
    format!("{number:06}.png")
}

fn write_identities(folder: &Path, truth: &FrameTruth) -> Result<(), WriteError> {
    let path = folder.join(image_name(truth.number));
    let Size { width, height } = truth.size;
    // The encoder passes on no error of its last writes: it has memory to write to, and the file gets all bytes at once.
    let mut bytes = Vec::new();
    let encoded =
        PngEncoder::new(&mut bytes).write_image(&truth.identities, width, height, ExtendedColorType::L8);
    let written = encoded.map_err(io::Error::other).and_then(|()| fs::write(&path, bytes));
    Ok(written.map_err(|error| describe(&path, error))?)
}

fn write_truth(staging: &Staging, truth: &SceneTruth) -> io::Result<()> {
    let [boxes, events, episodes] = TRUTH;
    write_text(staging, boxes, &boxes_text(truth))?;
    write_text(staging, events, &events_text(truth)?)?;
    write_text(staging, episodes, &episodes_text(truth))
}

fn write_text(staging: &Staging, name: &str, text: &str) -> io::Result<()> {
    let path = staging.path(name);
    fs::write(&path, text).map_err(|error| describe(&path, error))
}

/// The text of `gt.txt`.
pub fn boxes_text(truth: &SceneTruth) -> String {
    let line = |(frame, who): &(u32, super::Silhouette)| {
        let (place, visibility) = (who.bbox, who.visibility());
        // MOTChallenge's 0 marks boxes that are not to be counted.
        let counts = u8::from(!who.parked);
        format!(
            "{frame},{},{},{},{},{},{counts},1,{visibility:.3}\n",
            who.id, place.x, place.y, place.w, place.h
        )
    };
    truth.boxes.iter().map(line).collect()
}

/// The text of `events.jsonl`.
pub fn events_text(truth: &SceneTruth) -> Result<String, serde_json::Error> {
    truth.events.iter().map(|event| Ok(serde_json::to_string(event)? + "\n")).collect()
}

/// The text of `episodes.csv`.
pub fn episodes_text(truth: &SceneTruth) -> String {
    let line = |episode: &crate::occlusion::Episode| {
        let objects: Vec<String> = episode.objects.iter().map(ToString::to_string).collect();
        let front = episode.front.map(|id| id.to_string()).unwrap_or_default();
        format!(
            "{},{},{},{},{:.3},{front},{}\n",
            episode.kind.name(),
            objects.join("+"),
            episode.start,
            episode.end,
            episode.least_visible,
            episode.identities_kept
        )
    };
    let header = "kind,objects,start,end,least_visible,front,identities_kept\n".to_owned();
    header + &truth.episodes.iter().map(line).collect::<String>()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

    use super::*;
    use crate::frame::Frame;
    use crate::source::{self, Options};
    use crate::synth::{catalogue, render};

    fn small(name: &str, frames: Option<u32>) -> (Scene, SceneParameters) {
        let parameters =
            SceneParameters { size: Size::new(96, 72), frames, speed: 2.0, ..SceneParameters::default() };
        (catalogue::scene(name, &parameters).unwrap(), parameters)
    }

    fn decoded(video: &Path) -> Vec<Frame> {
        let mut source = source::open(video.to_str().unwrap(), Options::default()).unwrap();
        std::iter::from_fn(|| source.next_frame().unwrap()).collect()
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn written_files_read_back_as_rendered() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new").join("crossing");
        let (scene, parameters) = small("crossing", None);
        let mut done = 0;
        let video = write(&scene, &parameters, &out, false, |frames| {
            done = frames;
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!((done, video.as_path()), (scene.frames, out.join("crossing.mp4").as_path()));
        assert_eq!(decoded(&video).len(), scene.frames as usize);
        assert_eq!(names(&out), ["crossing.mp4", "scene.json", "truth"]);

        let mut recorder = Recorder::new(scene.fps);
        for (_, truth) in render(&scene) {
            let path = out.join("truth/identities").join(image_name(truth.number));
            let image = image::open(path).unwrap();
            assert!(matches!(image, image::DynamicImage::ImageLuma8(_)));
            assert_eq!(image.into_luma8().into_raw(), truth.identities);
            recorder.push(&truth);
        }
        let truth = recorder.finish();

        let boxes = fs::read_to_string(out.join("truth/gt.txt")).unwrap();
        assert_eq!(boxes.lines().count(), truth.boxes.len());
        for (line, (frame, who)) in boxes.lines().zip(&truth.boxes) {
            let fields: Vec<f32> = line.split(',').map(|field| field.parse().unwrap()).collect();
            let place = who.bbox;
            let expected = [*frame as f32, who.id as f32, place.x, place.y, place.w, place.h, 1.0, 1.0];
            assert_eq!(fields[..8], expected);
            assert!((fields[8] - who.visibility()).abs() < 6e-4);
        }
        let events = fs::read_to_string(out.join("truth/events.jsonl")).unwrap();
        for (line, event) in events.lines().zip(&truth.events) {
            let value: serde_json::Value = serde_json::from_str(line).unwrap();
            assert_eq!(value["kind"], event.kind.name());
            assert_eq!(value["frame"], event.frame);
            assert_eq!(value["objects"].as_array().unwrap().len(), event.objects.len());
        }
        assert_eq!(events.lines().count(), 6);
        let episodes = csv::Reader::from_path(out.join("truth/episodes.csv")).unwrap().into_records();
        let rows: Vec<_> = episodes.map(Result::unwrap).collect();
        assert_eq!(rows.len(), 1);
        assert_eq!((&rows[0][0], &rows[0][1]), ("inter-object", "1+2"));
        let description: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(out.join("scene.json")).unwrap()).unwrap();
        assert_eq!(description["name"], "crossing");
        assert_eq!(description["frames"], scene.frames);
        assert_eq!(description["parameters"]["speed"], 2.0);
    }

    #[test]
    fn lossless_video_has_the_rendered_bits() {
        let folder = tempfile::tempdir().unwrap();
        let (scene, parameters) = small("empty", Some(5));
        let video = write(&scene, &parameters, folder.path(), true, |_| ControlFlow::Continue(())).unwrap();
        let rendered: Vec<Frame> = render(&scene).map(|(frame, _)| frame).collect();
        assert!(decoded(&video) == rendered);
    }

    #[test]
    fn writing_again_replaces_only_its_own_files() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let (scene, parameters) = small("empty", Some(9));
        write(&scene, &parameters, out, false, |_| ControlFlow::Continue(())).unwrap();
        fs::write(out.join("notes.txt"), "mine").unwrap();
        fs::write(out.join("truth/identities/000123b.png"), "mine").unwrap();
        let (scene, parameters) = small("empty", Some(4));
        write(&scene, &parameters, out, false, |_| ControlFlow::Continue(())).unwrap();
        let images = names(&out.join("truth/identities"));
        assert_eq!(images, ["000001.png", "000002.png", "000003.png", "000004.png", "000123b.png"]);
        assert_eq!(names(out), ["empty.mp4", "notes.txt", "scene.json", "truth"]);
        assert_eq!(fs::read_to_string(out.join("notes.txt")).unwrap(), "mine");
    }

    #[test]
    fn another_video_keeps_its_truth() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let written = |name: &str, lossless| {
            let (scene, parameters) = small(name, Some(3));
            write(&scene, &parameters, out, lossless, |_| ControlFlow::Continue(()))
        };
        written("empty", false).unwrap();
        let earlier = fs::read(out.join("scene.json")).unwrap();
        for (name, lossless) in [("empty", true), ("crossing", false)] {
            let message = written(name, lossless).unwrap_err().to_string();
            let (video, truth) = (out.join("empty.mp4"), out.join("truth"));
            let expected = format!(
                "{} would lose its ground truth, {}, which is replaced; remove it, or choose another folder",
                video.display(),
                truth.display()
            );
            assert_eq!(message, expected);
            assert_eq!(names(out), ["empty.mp4", "scene.json", "truth"]);
            assert_eq!(fs::read(out.join("scene.json")).unwrap(), earlier);
        }
        fs::remove_file(out.join("empty.mp4")).unwrap();
        written("empty", true).unwrap();
        assert_eq!(names(out), ["empty.avi", "scene.json", "truth"]);
    }

    #[test]
    fn the_bundled_samples_equal_the_program_s_output() {
        let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_videos");
        for name in ["crossing", "tree"] {
            let mut parameters = SceneParameters::default();
            parameters.noise.sigma = 6.0;
            let scene = catalogue::scene(name, &parameters).unwrap();
            let mut recorder = Recorder::new(scene.fps);
            render(&scene).for_each(|(_, truth)| recorder.push(&truth));
            let truth = recorder.finish();
            let kept = |file: &str| fs::read_to_string(samples.join("truth").join(name).join(file)).unwrap();
            assert_eq!(kept("gt.txt"), boxes_text(&truth));
            assert_eq!(kept("events.jsonl"), events_text(&truth).unwrap());
            assert_eq!(kept("episodes.csv"), episodes_text(&truth));
            let video = samples.join(name).with_extension("mp4");
            assert_eq!(decoded(&video).len(), scene.frames as usize);
            assert!(fs::metadata(video).unwrap().len() < 1 << 20);
        }
    }

    #[test]
    fn an_unwritable_path_gives_an_error_of_one_line_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::write(&taken, "a file").unwrap();
        let (scene, parameters) = small("empty", Some(2));
        let message =
            write(&scene, &parameters, &taken, false, |_| ControlFlow::Continue(())).unwrap_err().to_string();
        assert!(message.contains("taken") && message.lines().count() == 1, "{message}");
        assert_eq!(fs::read_to_string(&taken).unwrap(), "a file");
    }

    #[test]
    fn stopped_work_leaves_no_file() {
        let parameters = SceneParameters { frames: Some(40), ..SceneParameters::default() };
        let scene = catalogue::scene("tree", &parameters).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let stopped = write(&scene, &parameters, folder.path(), false, |_| ControlFlow::Break(()));
        assert!(matches!(stopped, Err(WriteError::Stopped)));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
