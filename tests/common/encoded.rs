//! Videos that the `ffmpeg` program makes, and what it decodes of them.

// Every test file is a separate crate and uses only some of these.
#![allow(dead_code, unreachable_pub, missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use occluscope::frame::Frame;
use occluscope::source::cache::FrameCache;
use occluscope::source::{self, Options, SourceInfo};

/// Runs the `ffmpeg` program, which must succeed, and returns its output.
fn ffmpeg<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Vec<u8> {
    let mut command = Command::new("ffmpeg");
    command.args(["-nostdin", "-hide_banner", "-loglevel", "error", "-y"]).args(arguments);
    let output = command.output().expect("the ffmpeg program is installed");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
    output.stdout
}

/// Whether this `ffmpeg` has the encoder. The tests print which cases they leave out.
fn has_encoder(name: &str) -> bool {
    static ENCODERS: OnceLock<String> = OnceLock::new();
    let encoders = ENCODERS.get_or_init(|| String::from_utf8(ffmpeg(["-encoders"])).unwrap());
    encoders.lines().any(|line| line.split_whitespace().nth(1) == Some(name))
}

/// Encoders without which the tests fail.
const COMMON_ENCODERS: [&str; 6] = ["libx264", "mpeg4", "mjpeg", "ffv1", "gif", "rawvideo"];

/// Makes the video `path` from a moving test picture: `input` are its properties, such as
/// `size=160x120:rate=25:duration=2`, and `options` those of the encoder. `false` where this `ffmpeg` lacks the encoder.
pub fn encode(path: &Path, input: &str, encoder: &str, options: &str) -> bool {
    if !has_encoder(encoder) {
        assert!(!COMMON_ENCODERS.contains(&encoder), "ffmpeg has no encoder {encoder}");
        println!("{}: left out, ffmpeg has no encoder {encoder}", path.display());
        return false;
    }
    let input = format!("testsrc2={input}");
    let fixed = ["-f", "lavfi", "-i", &input, "-c:v", encoder, "-threads", "1"];
    ffmpeg(fixed.into_iter().chain(options.split_whitespace()).chain([path.to_str().unwrap()]));
    true
}

/// Makes the video `path` with these arguments of the `ffmpeg` program.
pub fn make(path: &Path, arguments: &str) {
    ffmpeg(arguments.split_whitespace().chain([path.to_str().unwrap()]));
}

/// Makes the video `to` from the packets of `from`.
pub fn remux(from: &Path, before: &str, options: &str, to: &Path) {
    let before = before.split_whitespace().chain(["-i", from.to_str().unwrap(), "-c", "copy"]);
    ffmpeg(before.chain(options.split_whitespace()).chain([to.to_str().unwrap()]));
}

/// Writes a display matrix, [a b; c d], into the header of an MP4 file.
pub fn set_display_matrix(path: &Path, [a, b, c, d]: [f64; 4]) {
    let mut bytes = fs::read(path).unwrap();
    let header = bytes.windows(4).position(|window| window == b"tkhd").unwrap();
    assert_eq!(bytes[header + 4], 0, "version");
    let fixed = |value: f64| (value * 65536.0).round() as i32;
    let matrix = [fixed(a), fixed(b), 0, fixed(c), fixed(d), 0, 0, 0, 1 << 30];
    let at = header + 44;
    bytes[at..at + 36].copy_from_slice(&matrix.map(i32::to_be_bytes).concat());
    fs::write(path, bytes).unwrap();
}

/// Overwrites some bytes every `every` bytes from `skip` on, the same at each run.
pub fn damage(path: &Path, skip: usize, every: usize) {
    let mut bytes = fs::read(path).unwrap();
    for (at, byte) in bytes.iter_mut().enumerate().skip(skip) {
        if at % every < 12 {
            *byte = ((at * 7919) >> 3) as u8;
        }
    }
    fs::write(path, bytes).unwrap();
}

/// All frames, the warnings, and the properties of a video.
pub fn read_all(path: &Path) -> (Vec<Frame>, Vec<String>, SourceInfo) {
    read_all_by(path, Options::default())
}

/// As [`read_all`], read with these options.
pub fn read_all_by(path: &Path, options: Options) -> (Vec<Frame>, Vec<String>, SourceInfo) {
    let source = source::open(path.to_str().unwrap(), options);
    let mut source = source.unwrap_or_else(|error| panic!("{error}"));
    let mut frames = Vec::new();
    while let Some(frame) = source.next_frame().unwrap() {
        assert_eq!((frame.number as usize, frame.size), (frames.len() + 1, source.info().size));
        frames.push(frame);
    }
    (frames, source.take_warnings(), source.info().clone())
}

/// The bytes of all frames that the `ffmpeg` program decodes, as RGB.
fn decoded_by_program(path: &Path, input_options: &str, output_options: &str) -> Vec<u8> {
    let input = input_options.split_whitespace().chain(["-i", path.to_str().unwrap()]);
    let output = output_options.split_whitespace();
    ffmpeg(input.chain(output).chain(["-vsync", "passthrough", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]))
}

/// The number of frames according to `ffprobe`.
pub fn count_by_program(path: &Path) -> usize {
    let mut command = Command::new("ffprobe");
    command.args(["-v", "quiet", "-count_frames", "-select_streams", "v:0"]);
    command.args(["-show_entries", "stream=nb_read_frames", "-of", "default=nokey=1:noprint_wrappers=1"]);
    let output = command.arg(path).output().expect("the ffprobe program is installed");
    String::from_utf8(output.stdout).unwrap().lines().next().unwrap().trim().parse().unwrap()
}

/// The presentation time of each frame according to `ffprobe`, in seconds.
pub fn times_by_program(path: &Path) -> Vec<f64> {
    let mut command = Command::new("ffprobe");
    command.args([
        "-v",
        "quiet",
        "-select_streams",
        "v:0",
        "-show_entries",
        "frame=best_effort_timestamp_time",
    ]);
    let output =
        command.args(["-of", "csv=p=0"]).arg(path).output().expect("the ffprobe program is installed");
    let text = String::from_utf8(output.stdout).unwrap();
    // Side data of a frame add a comma and an empty line.
    let times = text.lines().map(|line| line.trim_end_matches(',')).filter(|line| !line.is_empty());
    times.map(|time| time.parse().unwrap()).collect()
}

/// Asserts that the frames are those of the `ffmpeg` program with these options of the input, to one level.
pub fn assert_as_program(path: &Path, frames: &[Frame], options: &str) {
    assert_as_program_by(path, frames, options, "-map 0:v:0");
}

/// As [`assert_as_program`], with these options of the output besides.
pub fn assert_as_program_by(path: &Path, frames: &[Frame], input_options: &str, output_options: &str) {
    let expected = decoded_by_program(path, input_options, output_options);
    let bytes = frames.first().map_or(0, |frame| frame.rgb.len());
    assert_eq!(frames.len() * bytes, expected.len(), "{}: {} frames", path.display(), frames.len());
    for (frame, expected) in frames.iter().zip(expected.chunks_exact(bytes.max(1))) {
        let worst = frame.rgb.iter().zip(expected).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst <= Some(1), "{}: frame {} differs by {worst:?}", path.display(), frame.number);
    }
}

/// Asserts that frames that are read again in any order are those that were read in order.
pub fn assert_same_in_any_order(path: &Path, frames: &[Frame], jumps: usize) {
    assert_same_in_any_order_by(path, Options::default(), frames, jumps);
}

/// As [`assert_same_in_any_order`], read with these options.
pub fn assert_same_in_any_order_by(path: &Path, options: Options, frames: &[Frame], jumps: usize) {
    let mut cache = FrameCache::open(path.to_str().unwrap(), options, 0).unwrap();
    assert!(cache.get(frames.len() as u32).unwrap().is_none());
    let mut random = 12345_u64;
    for _ in 0..jumps {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let position = (random >> 33) as usize % frames.len();
        let frame = cache.get(position as u32).unwrap();
        assert!(frame.as_deref() == Some(&frames[position]), "{}: position {position}", path.display());
    }
}
