//! The annotated video as `ffprobe` and the decoder see it, and what remains where it cannot be encoded.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;
#[path = "common/encoded.rs"]
mod encoded;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{TABLES, TestFolder, names, noise, occluscope, text, works, write_images};
use encoded::{make, read_all, remux, set_display_matrix, times_by_program};
use image::{Rgb, RgbImage};
use occluscope::export::video::{VideoFile, VideoKind};
use occluscope::frame::{Frame, Size};
use serde_json::Value;

/// A frame of coloured stripes that move.
fn stripes(number: u32, size: Size) -> Frame {
    let colour = |x: u32| if (x + number) % 16 < 8 { [40, 90, 200] } else { [200, 180, 30] };
    let rgb = (0..size.height).flat_map(|_| (0..size.width).flat_map(colour)).collect();
    Frame::new(number, size, rgb)
}

/// Writes a video of stripes with these times.
fn write_video(path: &Path, size: Size, fps: f32, times: &[f64]) {
    let mut video = VideoFile::create(VideoKind::Playback, path, size, fps, None).unwrap();
    assert!(video.is_h264());
    for (&time, number) in times.iter().zip(1..) {
        video.write(&stripes(number, size), time).unwrap();
    }
    video.finish().unwrap();
}

/// The video stream according to `ffprobe`.
fn stream(path: &Path) -> Value {
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error", "-count_frames", "-show_streams", "-of", "json"]).arg(path);
    let output = command.output().expect("the ffprobe program is installed");
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["streams"].as_array().unwrap().len(), 1);
    json["streams"][0].clone()
}

/// The value of a ratio such as `25/1`.
fn ratio(value: &Value) -> f64 {
    let (above, below) = value.as_str().unwrap().split_once('/').unwrap();
    above.parse::<f64>().unwrap() / below.parse::<f64>().unwrap()
}

#[test]
fn browsers_can_play_a_video_of_any_rate() {
    let place = TestFolder::new();
    let path = place.path("video.mp4");
    for (fps, rate) in
        [(25.0, "25/1"), (29.97, "2997/100"), (66.667, "66667/1000"), (211.222, "105611/500"), (0.1, "1/10")]
    {
        let exact = f64::from(fps);
        let expected: Vec<f64> = (0..30).map(|index| f64::from(index) / exact).collect();
        write_video(&path, Size::new(64, 48), fps, &expected);
        let stream = stream(&path);
        for (key, value) in [
            ("codec_name", "h264"),
            ("profile", "High"),
            ("pix_fmt", "yuv420p"),
            ("color_range", "tv"),
            ("color_space", "bt709"),
            ("color_primaries", "bt709"),
            ("color_transfer", "bt709"),
            ("avg_frame_rate", rate),
            ("nb_frames", "30"),
            ("nb_read_frames", "30"),
        ] {
            assert_eq!(stream[key], value, "{key} at {fps}");
        }
        assert!((ratio(&stream["r_frame_rate"]) / exact - 1.0).abs() < 1e-3, "{}", stream["r_frame_rate"]);
        assert_eq!(stream["has_b_frames"], 0);
        let times = times_by_program(&path);
        assert_eq!(times.len(), expected.len());
        for (time, expected) in times.iter().zip(&expected) {
            // `ffprobe` prints six decimals.
            assert!((time - expected).abs() < 1e-6 + expected * 1e-7, "{time} at {expected}");
        }
        let bytes = fs::read(&path).unwrap();
        let place_of = |name: &[u8]| bytes.windows(4).position(|window| window == name).unwrap();
        assert!(place_of(b"moov") < place_of(b"mdat"), "the index is at the start of the file");
    }
}

#[test]
fn frames_keep_their_times() {
    let place = TestFolder::new();
    let path = place.path("video.mp4");
    let given = [0.0, 0.033, 0.05, 0.333, 0.334, 1.75, 1.75, 1.7, 4.0, 4.125];
    for (fps, start) in [(25.0, 0.0), (17.342, 95_000.4), (0.1, -3.0)] {
        write_video(&path, Size::new(64, 48), fps, &given.map(|time| start + time));
        let times = times_by_program(&path);
        assert_eq!(times.len(), given.len());
        assert!(times.is_sorted_by(|a, b| a < b), "{times:?}");
        for (time, given) in times.iter().zip(given) {
            // Where a given time is not later than the last, the frame comes as soon as it can.
            let expected = if given == 1.7 { 1.75 } else { given };
            assert!((time - expected).abs() < 3e-5, "{time} at {given}, {fps} frames per second");
        }
        // The last frame lasts as long as the others do on average.
        let average = ratio(&stream(&path)["avg_frame_rate"]);
        assert!((average - 9.0 / 4.125).abs() < 1e-3, "{average}");
    }
}

#[test]
fn odd_sizes_are_extended_by_their_last_row_and_column() {
    let place = TestFolder::new();
    let path = place.path("video.mp4");
    for (width, height) in [(1, 1), (2, 2), (1, 6), (3, 2), (17, 16), (65, 47), (322, 243)] {
        let size = Size::new(width, height);
        write_video(&path, size, 25.0, &[0.0, 0.04, 0.08]);
        let stream = stream(&path);
        assert_eq!(stream["width"], width.next_multiple_of(2), "{size}");
        assert_eq!(stream["height"], height.next_multiple_of(2), "{size}");
        let (frames, warnings, _) = read_all(&path);
        assert_eq!((frames.len(), warnings.len()), (3, 0), "{size}");
        for (frame, number) in frames.iter().zip(1..) {
            let written = stripes(number, size);
            let (right, bottom) = (frame.size.width - 1, frame.size.height - 1);
            let expected = written.pixel(width - 1, height - 1).unwrap();
            // A pixel at the edge of a stripe shares its chroma with its neighbour.
            let is_inside = (width + number) % 8 > 2;
            for (x, y) in [(right, bottom), (right, 0)] {
                let read = frame.pixel(x, y).unwrap();
                let worst = read.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max();
                assert!(!is_inside || worst < Some(25), "{size}: {read:?} for {expected:?}");
            }
        }
    }
}

#[test]
fn colours_are_read_back_as_they_were_written() {
    let place = TestFolder::new();
    let path = place.path("video.mp4");
    let size = Size::new(48, 32);
    let colours = [
        [0, 0, 0],
        [255, 255, 255],
        [255, 0, 0],
        [0, 255, 0],
        [0, 0, 255],
        [128, 128, 128],
        [30, 200, 90],
        [200, 30, 20],
    ];
    let mut video = VideoFile::create(VideoKind::Playback, &path, size, 25.0, None).unwrap();
    for (colour, number) in colours.iter().zip(1..) {
        let frame = Frame::new(number, size, colour.repeat(size.pixels()));
        video.write(&frame, f64::from(number) / 25.0).unwrap();
    }
    video.finish().unwrap();
    let (frames, _, _) = read_all(&path);
    assert_eq!(frames.len(), colours.len());
    for (frame, colour) in frames.iter().zip(colours) {
        for (x, y) in [(0, 0), (24, 16), (47, 31)] {
            let read = frame.pixel(x, y).unwrap();
            let worst = read.iter().zip(colour).map(|(a, b)| a.abs_diff(b)).max();
            assert!(worst <= Some(4), "{read:?} for {colour:?}");
        }
    }
}

#[test]
fn the_shape_of_pixels_is_kept() {
    let place = TestFolder::new();
    let (video, turned, out) = (place.path("video.mp4"), place.path("turned.mp4"), place.path("out"));
    make(
        &video,
        "-f lavfi -i testsrc2=size=96x72:rate=66667/1000:duration=1,setsar=4/3 -frames:v 20 -c:v libx264",
    );
    remux(&video, "", "", &turned);
    set_display_matrix(&turned, [0.0, 1.0, -1.0, 0.0]);
    for (path, aspect, sides) in [(&video, "4:3", (96, 72)), (&turned, "3:4", (72, 96))] {
        works(&["run", text(path), "--out", text(&out), "--annotated"]);
        let stream = stream(&out.join("annotated.mp4"));
        assert_eq!(stream["sample_aspect_ratio"], aspect);
        assert_eq!((&stream["width"], &stream["height"]), (&sides.0.into(), &sides.1.into()));
        assert_eq!(stream["avg_frame_rate"], "66667/1000");
        assert_eq!((&stream["codec_name"], &stream["nb_read_frames"]), (&"h264".into(), &"20".into()));
    }
}

/// Runs the program with these arguments, which ends with status 1; returns what it says.
fn says(command: &mut assert_cmd::Command) -> String {
    let output = command.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    said
}

#[test]
fn a_video_that_no_encoder_accepts_costs_no_other_file() {
    let place = TestFolder::new();
    let (images, small, out) = (place.path("images"), place.path("small"), place.path("out"));
    fs::create_dir(&images).unwrap();
    for number in 1..=3 {
        let picture = RgbImage::from_fn(16_400, 16, |x, y| Rgb([90 + noise(x, y, 0) / 16; 3]));
        picture.save(images.join(format!("in{number:06}.png"))).unwrap();
    }
    let why = "no encoder of FFmpeg's accepts 16400×16 pixels";
    let told = |said: &str, out: &Path| {
        let last = said.lines().last().unwrap();
        let video = out.join("annotated.mp4");
        let start = format!("error: the tables are written, {} is not: ", text(&video));
        assert!(last.starts_with(&start) && last.contains(why), "{said}");
    };
    let arguments = ["run", text(&images), "--out", text(&out), "--annotated"];
    let said = says(&mut occluscope(&[&arguments[..], &["--quiet"]].concat()));
    assert_eq!(said.lines().count(), 1, "{said}");
    told(&said, &out);
    assert_eq!(names(&out), TABLES);

    // Images are written, and a video of an earlier run is not taken for one of this.
    write_images(&small, 3, 1);
    works(&["run", text(&small), "--out", text(&out), "--annotated"]);
    let earlier = fs::read(out.join("annotated.mp4")).unwrap();
    let said = says(&mut occluscope(&[&arguments[..], &["--frames"]].concat()));
    told(&said, &out);
    let note = format!("note: {} is not from this run", text(&out.join("annotated.mp4")));
    assert!(said.lines().any(|line| line == note), "{said}");
    assert_eq!(names(&out.join("frames")).len(), 3);
    assert!(fs::read(out.join("annotated.mp4")).unwrap() == earlier);
    let summary: Value = serde_json::from_slice(&fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["input"]["size"]["width"], 16_400);
}

/// The operating system ends every file at 128 KiB.
#[cfg(unix)]
#[test]
fn a_video_that_cannot_be_stored_ends_the_run() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    fs::create_dir(&images).unwrap();
    for number in 1..=40 {
        let picture = RgbImage::from_fn(160, 120, |x, y| Rgb([60 + noise(x, y, number) / 2; 3]));
        picture.save(images.join(format!("in{number:06}.png"))).unwrap();
    }
    let mut command = assert_cmd::Command::new("sh");
    command.args(["-c", "ulimit -f 256; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_occluscope")]);
    command.args(["run", text(&images), "--out", text(&out), "--annotated", "--quiet"]);
    command.args(["--min-area", "5000"]);
    let said = says(&mut command);
    let video = out.join("annotated.mp4");
    let told = format!(
        "error: {} cannot be written: it exceeds the largest size of a file here; raise it (ulimit -f), or choose another \
         place\n",
        text(&video)
    );
    assert_eq!(said, told);
    assert!(!out.exists());
}
