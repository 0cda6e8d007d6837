//! Frames of video files are those of the `ffmpeg` program, in order and in any order. The videos are made by it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;
#[path = "common/encoded.rs"]
mod encoded;

use std::f64::consts::FRAC_1_SQRT_2 as ROOT;
use std::fs;
use std::path::Path;

use common::TestFolder;
use encoded::{
    assert_as_program, assert_same_in_any_order, count_by_program, damage, encode, make, read_all, remux,
    set_display_matrix,
};

const SMALL: &str = "size=160x120:rate=25:duration=1.6";
const LONG: &str = "size=160x120:rate=25:duration=8";
const ODD: &str = "size=160x120:rate=25:duration=1.2,scale=161:123:flags=neighbor";
/// Frames at irregular times.
const IRREGULAR: &str = "size=160x120:rate=25:duration=3,select='not(mod(n*n,7))+lt(n,9)'";

const JUMPS: usize = 25;

/// Frames are those of the program, as many as `ffprobe` counts, and the same in any order.
#[track_caller]
fn check(path: &Path, jumps: usize) -> Vec<String> {
    let (frames, warnings, _) = read_all(path);
    assert!(!frames.is_empty());
    assert_eq!(frames.len(), count_by_program(path), "{}", path.display());
    assert_as_program(path, &frames, "");
    assert_same_in_any_order(path, &frames, jumps);
    warnings
}

/// Videos of these names, test pictures, encoders and options are decoded as by the program, without warnings.
fn check_all(cases: &[(&str, &str, &str, &str)]) {
    let place = TestFolder::new();
    for &(name, input, encoder, options) in cases {
        let path = place.path(name);
        if encode(&path, input, encoder, options) {
            assert_eq!(check(&path, JUMPS), Vec::<String>::new(), "{name}");
        }
    }
}

#[test]
fn common_codecs_are_decoded_as_by_the_program() {
    check_all(&[
        ("a.mp4", SMALL, "libx264", "-pix_fmt yuv420p -bf 3 -g 12"),
        ("gray.mp4", SMALL, "libx264", "-pix_fmt gray"),
        ("422.mp4", SMALL, "libx264", "-pix_fmt yuv422p"),
        ("444.mkv", SMALL, "libx264", "-pix_fmt yuv444p"),
        ("10.mp4", SMALL, "libx264", "-pix_fmt yuv420p10le"),
        ("rgb.mp4", SMALL, "libx264rgb", "-pix_fmt rgb24"),
        ("b.mp4", SMALL, "mpeg4", "-bf 2 -g 12"),
        ("b.avi", SMALL, "mpeg4", "-g 12"),
        ("b_frames.avi", SMALL, "mpeg4", "-bf 2 -g 12"),
        ("420.avi", SMALL, "mjpeg", "-pix_fmt yuvj420p"),
        ("444.mov", SMALL, "mjpeg", "-pix_fmt yuvj444p"),
        ("c.mkv", SMALL, "ffv1", "-pix_fmt yuv420p"),
        ("16.mkv", SMALL, "ffv1", "-pix_fmt yuv420p16le"),
        ("d.gif", SMALL, "gif", ""),
        ("bottom_up.avi", SMALL, "rawvideo", "-pix_fmt bgr24"),
        ("packed.mov", SMALL, "rawvideo", "-pix_fmt uyvy422"),
        ("palette.mov", SMALL, "png", "-pix_fmt pal8"),
        ("48.mov", SMALL, "png", "-pix_fmt rgb48be"),
    ]);
}

#[test]
fn other_codecs_are_decoded_as_by_the_program() {
    const HEVC: &str = "-x265-params log-level=none:keyint=12:pools=2";
    const VP9: &str = "-g 12 -cpu-used 8 -deadline realtime";
    check_all(&[
        ("8.mp4", SMALL, "libx265", &format!("{HEVC} -pix_fmt yuv420p")),
        ("10.mkv", SMALL, "libx265", &format!("{HEVC} -pix_fmt yuv420p10le")),
        ("a.webm", SMALL, "libvpx", VP9),
        ("9.webm", SMALL, "libvpx-vp9", VP9),
        ("av1.mkv", SMALL, "libsvtav1", "-pix_fmt yuv420p -g 12 -preset 12"),
        ("2.mpg", SMALL, "mpeg2video", "-bf 2 -g 12"),
        ("1.mpg", SMALL, "mpeg1video", "-bf 2 -g 12"),
        ("422.mov", SMALL, "prores_ks", "-pix_fmt yuv422p10le"),
        ("4444.mov", SMALL, "prores_ks", "-profile:v 4 -pix_fmt yuva444p10le"),
        ("h.avi", SMALL, "huffyuv", ""),
        ("t.ogv", ODD, "libtheora", "-q:v 7"),
        ("w.wmv", SMALL, "wmv2", "-g 12"),
        ("f.flv", SMALL, "flv", "-g 12"),
    ]);
}

#[test]
fn containers_give_the_same_frames() {
    let place = TestFolder::new();
    let first = place.path("a.mp4");
    assert!(encode(&first, SMALL, "libx264", "-pix_fmt yuv420p -bf 3 -g 12"));
    let (expected, _, info) = read_all(&first);
    assert_eq!((info.fps, info.frames), (25.0, Some(40)));
    for (name, options) in [
        ("a.mkv", ""),
        ("a.mov", ""),
        ("a.ts", ""),
        ("a.mts", "-f mpegts -mpegts_m2ts_mode 1"),
        ("a.flv", ""),
        ("a.h264", ""),
        ("fragments.mp4", "-movflags frag_keyframe+empty_moov"),
        ("late.ts", "-output_ts_offset 95000"),
        ("name: 50%.mp4", ""),
    ] {
        let path = place.path(name);
        remux(&first, "", options, &path);
        let (frames, warnings, info) = read_all(&path);
        assert_eq!((info.fps, warnings), (25.0, Vec::new()), "{name}");
        assert!(frames == expected, "{name}: {} frames", frames.len());
        assert_same_in_any_order(&path, &frames, JUMPS);
    }
    // An edit list removes the frames before 0.7 s.
    let cut = place.path("cut.mp4");
    remux(&first, "-ss 0.7", "", &cut);
    assert_eq!(check(&cut, JUMPS), Vec::<String>::new());
}

#[test]
fn any_frame_of_a_long_video_is_reached_exactly() {
    let place = TestFolder::new();
    let x264 = "-pix_fmt yuv420p -preset veryfast -x264-params scenecut=0:bframes=3";
    for (name, options, jumps) in [
        ("closed.mp4", format!("{x264}:keyint=25"), 200),
        ("open.mp4", format!("{x264}:keyint=20:open-gop=1"), 200),
        ("open.mkv", format!("{x264}:keyint=20:open-gop=1"), 200),
        ("open.ts", format!("{x264}:keyint=20:open-gop=1"), 200),
        ("one_key.mp4", format!("{x264}:keyint=9999"), 50),
        ("refresh.mp4", format!("{x264}:keyint=25:intra-refresh=1"), 50),
    ] {
        let path = place.path(name);
        assert!(encode(&path, LONG, "libx264", &options));
        let (frames, warnings, _) = read_all(&path);
        assert_eq!((frames.len(), warnings), (200, Vec::new()), "{name}");
        assert_same_in_any_order(&path, &frames, jumps);
    }
    for (name, encoder) in [("a.avi", "mpeg4"), ("a.mpg", "mpeg2video"), ("a.webm", "libvpx")] {
        let path = place.path(name);
        if encode(&path, LONG, encoder, "-g 25") {
            let (frames, _, _) = read_all(&path);
            assert_same_in_any_order(&path, &frames, 200);
        }
    }
}

#[test]
fn still_pictures_do_not_confuse_jumps() {
    let place = TestFolder::new();
    let path = place.path("still.mp4");
    let still = "size=160x120:rate=25:duration=8,loop=120:1:20";
    assert!(encode(&path, still, "libx264", "-pix_fmt yuv420p -g 50"));
    let (frames, _, _) = read_all(&path);
    assert_same_in_any_order(&path, &frames, 100);
}

#[test]
fn colours_follow_the_matrix_and_range_of_the_file() {
    let place = TestFolder::new();
    let mut colours = Vec::new();
    for (name, tags) in [
        ("untagged", ""),
        ("601", "-colorspace smpte170m"),
        ("709", "-colorspace bt709"),
        ("2020", "-colorspace bt2020nc"),
        ("240", "-colorspace smpte240m"),
        ("full", "-colorspace bt709 -color_range pc"),
    ] {
        let path = place.path(&format!("{name}.mp4"));
        let input = "size=160x120:rate=25:duration=0.4,scale=out_color_matrix=bt709";
        assert!(encode(&path, input, "libx264", &format!("-pix_fmt yuv420p -crf 1 {tags}")));
        assert_eq!(check(&path, 10), Vec::<String>::new(), "{name}");
        colours.push(read_all(&path).0.swap_remove(0).pixel(30, 60).unwrap());
    }
    assert_eq!(colours[0], colours[1], "BT.601 where nothing is said");
    colours.dedup();
    assert_eq!(colours.len(), 5, "{colours:?}");
}

#[test]
fn pictures_are_upright() {
    let place = TestFolder::new();
    let plain = place.path("plain.mp4");
    assert!(encode(&plain, SMALL, "libx264", "-pix_fmt yuv420p"));
    let upright = read_all(&plain).0.swap_remove(0);
    let path = place.path("turned.mp4");
    let oblique = [ROOT, ROOT, -ROOT, ROOT];
    for (matrix, size, corner) in [
        ([0.0, 1.0, -1.0, 0.0], (120, 160), (119, 0)),
        ([-1.0, 0.0, 0.0, -1.0], (160, 120), (159, 119)),
        ([0.0, -1.0, 1.0, 0.0], (120, 160), (0, 159)),
        ([-1.0, 0.0, 0.0, 1.0], (160, 120), (159, 0)),
        ([1.0, 0.0, 0.0, -1.0], (160, 120), (0, 119)),
        ([0.0, 1.0, 1.0, 0.0], (120, 160), (0, 0)),
        ([0.0, -1.0, -1.0, 0.0], (120, 160), (119, 159)),
        (oblique, (160, 120), (0, 0)),
    ] {
        fs::copy(&plain, &path).unwrap();
        set_display_matrix(&path, matrix);
        assert_eq!(check(&path, 10), Vec::<String>::new(), "{matrix:?}");
        let first = read_all(&path).0.swap_remove(0);
        assert_eq!((first.size.width, first.size.height), size, "{matrix:?}");
        if matrix != oblique {
            let (turned, plain) = (first.pixel(corner.0, corner.1).unwrap(), upright.pixel(0, 0).unwrap());
            let distance = turned.iter().zip(plain).map(|(a, b)| a.abs_diff(b)).max();
            assert!(distance <= Some(6), "{matrix:?}: {turned:?}, not {plain:?}");
        }
    }
    for (name, input, pixels) in [("422.mp4", SMALL, "yuv422p"), ("odd.mp4", ODD, "yuv444p")] {
        let path = place.path(name);
        assert!(encode(&path, input, "libx264", &format!("-pix_fmt {pixels}")));
        set_display_matrix(&path, [0.0, 1.0, -1.0, 0.0]);
        assert_eq!(check(&path, 10), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn odd_sizes_and_pixel_shapes_are_decoded_as_by_the_program() {
    check_all(&[
        ("420.mkv", ODD, "ffv1", "-pix_fmt yuv420p"),
        ("411.mkv", ODD, "ffv1", "-pix_fmt yuv411p"),
        ("444.mp4", ODD, "libx264", "-pix_fmt yuv444p"),
        ("420.avi", ODD, "mjpeg", "-pix_fmt yuvj420p"),
        ("raw.avi", ODD, "rawvideo", "-pix_fmt bgr24"),
        ("9.webm", ODD, "libvpx-vp9", "-cpu-used 8 -deadline realtime"),
        ("cropped.mp4", "size=162x126:rate=25:duration=1", "libx264", "-pix_fmt yuv420p"),
        ("wide.mp4", SMALL, "libx264", "-pix_fmt yuv420p -aspect 16:9"),
    ]);
}

#[test]
fn irregular_times_neither_drop_nor_repeat_frames() {
    check_all(&[
        ("a.mp4", IRREGULAR, "libx264", "-vsync vfr -pix_fmt yuv420p -g 10"),
        ("a.mkv", IRREGULAR, "libx264", "-vsync vfr -pix_fmt yuv420p -g 10"),
        ("a.gif", IRREGULAR, "gif", "-vsync vfr"),
        ("rate.mp4", "size=160x120:rate=66.667:duration=0.6", "libx264", "-pix_fmt yuv420p"),
    ]);
}

#[test]
fn sound_does_not_end_a_video() {
    let place = TestFolder::new();
    let path = place.path("a.mov");
    // Sound of more bytes than the demuxer reads between two pictures.
    let sound = "-f lavfi -i aevalsrc=0:d=6:c=16c:s=48000";
    let video = "-f lavfi -i testsrc2=size=160x120:rate=1:duration=6";
    let codecs = "-pix_fmt yuv420p -c:v libx264 -c:a pcm_s16le";
    make(&path, &format!("{video} {sound} {sound} {sound} -map 0 -map 1 -map 2 -map 3 {codecs}"));
    assert_eq!(check(&path, 10), Vec::<String>::new());
    let path = place.path("b.mkv");
    let tones = "-f lavfi -i sine=duration=2 -f lavfi -i sine=f=880:duration=2";
    let video = "-f lavfi -i testsrc2=size=160x120:rate=25:duration=2";
    make(&path, &format!("{tones} {video} -map 0 -map 1 -map 2 -c:v mpeg4 -g 12 -c:a pcm_s16le"));
    assert_eq!(check(&path, 10), Vec::<String>::new());
}

#[test]
fn what_is_unusual_is_told_in_one_line() {
    let place = TestFolder::new();
    let told = |name: &str, input: &str, options: &str| {
        let path = place.path(name);
        assert!(encode(&path, input, "libx264", options));
        let [warning] = &check(&path, 10)[..] else { panic!("{name}") };
        assert!(warning.contains(name) && !warning.contains('\n'), "{warning}");
        warning.clone()
    };
    let interlaced = told("fields.mp4", SMALL, "-pix_fmt yuv420p -flags +ildct+ilme -x264-params tff=1");
    assert!(interlaced.contains("interlaced"), "{interlaced}");
    let pq = "-pix_fmt yuv420p10le -color_trc smpte2084 -colorspace bt2020nc -color_primaries bt2020";
    assert!(told("pq.mp4", SMALL, pq).contains("HDR (PQ)"));

    let path = place.path("two.mkv");
    let source = |size: &str| format!("-f lavfi -i testsrc2=size={size}:rate=25:duration=1");
    let streams = format!("{} {} -map 0 -map 1", source("160x120"), source("80x60"));
    make(&path, &format!("{streams} -c:v libx264 -pix_fmt yuv420p"));
    let [warning] = &check(&path, 10)[..] else { panic!() };
    assert!(warning.contains("holds 2 video streams; stream 0"), "{warning}");

    // Two sizes in one stream.
    let (small, large) = (place.path("small.ts"), place.path("large.ts"));
    assert!(encode(&small, SMALL, "libx264", "-pix_fmt yuv420p -g 20"));
    let later = "-pix_fmt yuv420p -g 20 -output_ts_offset 1.6";
    assert!(encode(&large, "size=200x160:rate=25:duration=1", "libx264", later));
    let path = place.path("sizes.ts");
    fs::write(&path, [fs::read(&small).unwrap(), fs::read(&large).unwrap()].concat()).unwrap();
    let warnings = check(&path, 60);
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("changes its size from 160×120 to 200×160 at frame 41"), "{warning}");
}

#[test]
fn a_video_that_breaks_off_is_read_to_its_end() {
    let place = TestFolder::new();
    for (name, encoder) in [("a.mkv", "libx264"), ("a.avi", "mpeg4"), ("b.avi", "mjpeg")] {
        let path = place.path(name);
        assert!(encode(&path, SMALL, encoder, "-pix_fmt yuv420p -g 12"));
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() * 6 / 10]).unwrap();
        let warnings = check(&path, JUMPS);
        let [warning] = &warnings[..] else { panic!("{name}: {warnings:?}") };
        assert!(warning.contains("ends after frame") && warning.contains("are missing"), "{warning}");
    }
}

#[test]
fn damage_is_concealed_the_same_way_each_time() {
    let place = TestFolder::new();
    for (name, encoder, options) in [
        ("a.ts", "libx264", "-pix_fmt yuv420p -bf 2 -g 20"),
        ("a.mkv", "libx264", "-pix_fmt yuv420p -bf 2 -g 20"),
        ("a.avi", "mpeg4", "-g 20"),
        ("b.avi", "mjpeg", "-pix_fmt yuvj420p"),
        ("b.ts", "mpeg2video", "-bf 2 -g 12"),
    ] {
        let path = place.path(name);
        if !encode(&path, SMALL, encoder, options) {
            continue;
        }
        damage(&path, 9000, 7001);
        let (frames, warnings, _) = read_all(&path);
        // FFmpeg's JPEG decoder does not report all that it conceals.
        let is_told = warnings.iter().any(|warning| warning.contains("damaged"));
        assert!(is_told || encoder == "mjpeg", "{name}: {warnings:?}");
        assert_as_program(&path, &frames, "-threads 1");
        assert!(read_all(&path).0 == frames, "{name}");
        assert_same_in_any_order(&path, &frames, JUMPS);
    }
}
