//! Frames of video files are those of the `ffmpeg` program, in order and in any order. The videos are made by it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;
#[path = "common/encoded.rs"]
mod encoded;

use std::f64::consts::FRAC_1_SQRT_2 as ROOT;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use common::TestFolder;
use encoded::{
    assert_as_program, assert_as_program_by, assert_same_in_any_order, assert_same_in_any_order_by,
    count_by_program, damage, encode, make, read_all, read_all_by, remux, set_display_matrix,
    times_by_program,
};
use occluscope::frame::Frame;
use occluscope::source::cache::FrameCache;
use occluscope::source::{self, Options};

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
    assert!(interlaced.contains("interlaced") && interlaced.contains("--deinterlace"), "{interlaced}");
    let pq = "-pix_fmt yuv420p10le -color_trc smpte2084 -colorspace bt2020nc -color_primaries bt2020";
    assert!(told("pq.mp4", SMALL, pq).contains("HDR (PQ)"));

    let path = place.path("two.mkv");
    let source = |size: &str| format!("-f lavfi -i testsrc2=size={size}:rate=25:duration=1");
    let streams = format!("{} {} -map 0 -map 1", source("160x120"), source("80x60"));
    make(&path, &format!("{streams} -c:v libx264 -pix_fmt yuv420p"));
    let [warning] = &check(&path, 10)[..] else { panic!() };
    assert!(warning.contains("holds 2 video streams; stream 0"), "{warning}");
    assert!(warning.contains("--stream"), "{warning}");

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

const DEINTERLACED: Options = Options { deinterlace: true, ..Options::AS_IS };
/// A film of fields of different times, the upper one first.
const FIELDS: &str = "size=160x120:rate=50:duration=3.2,tinterlace=interleave_top";

/// Deinterlaced frames are those of the program, one for each picture, and the same in any order.
#[track_caller]
fn check_deinterlaced(path: &Path, jumps: usize) -> Vec<String> {
    let (frames, warnings, _) = read_all_by(path, DEINTERLACED);
    assert_eq!(frames.len(), count_by_program(path), "{}", path.display());
    assert_as_program_by(path, &frames, "", "-map 0:v:0 -vf bwdif=mode=send_frame:deint=all");
    assert_same_in_any_order_by(path, DEINTERLACED, &frames, jumps);
    warnings
}

#[test]
fn deinterlaced_frames_are_those_of_the_program() {
    const X264: &str = "-pix_fmt yuv420p -bf 3 -flags +ildct+ilme -x264-params keyint=20:scenecut=0";
    let lower = "size=160x120:rate=50:duration=3.2,tinterlace=interleave_bottom";
    let place = TestFolder::new();
    for (name, input, encoder, options) in [
        ("a.mp4", FIELDS, "libx264", X264),
        ("a.ts", FIELDS, "libx264", &format!("{X264}:open-gop=1")),
        ("a.avi", FIELDS, "mpeg4", "-flags +ildct+ilme -g 12"),
        ("lower.mp4", lower, "libx264", &format!("{X264}:bff=1")),
        ("a.mpg", FIELDS, "mpeg2video", "-flags +ildct+ilme -bf 2 -g 12"),
        ("422.mkv", FIELDS, "libx264", "-pix_fmt yuv422p10le -flags +ildct+ilme"),
        ("rgb.mov", FIELDS, "png", "-pix_fmt rgb24"),
    ] {
        let path = place.path(name);
        if encode(&path, input, encoder, options) {
            let warnings = check_deinterlaced(&path, 60);
            // PNG has no mark for it.
            let is_marked = encoder != "png";
            assert_eq!(warnings.is_empty(), is_marked, "{name}: {warnings:?}");
        }
    }
    // With fewer than three frames, none has both neighbours.
    for (name, duration) in [("one.mp4", "0.04"), ("two.mp4", "0.08")] {
        let path = place.path(name);
        let input = format!("size=160x120:rate=50:duration={duration},tinterlace=interleave_top");
        assert!(encode(&path, &input, "libx264", X264));
        check_deinterlaced(&path, 5);
    }
}

#[test]
fn deinterlacing_removes_combs_and_blurs_what_has_none() {
    let place = TestFolder::new();
    let path = place.path("fields.mp4");
    assert!(encode(&path, FIELDS, "libx264", "-pix_fmt yuv420p -crf 8 -flags +ildct+ilme"));
    // Differences between rows that those between every other row do not have.
    let combs = |frames: &[Frame]| {
        let mut sum = 0_i64;
        for frame in frames {
            let row = frame.size.width as usize * 3;
            let level = |at: usize| i64::from(frame.rgb[at]);
            for at in 0..frame.rgb.len() - 2 * row {
                sum += (level(at) - 2 * level(at + row) + level(at + 2 * row)).abs();
            }
        }
        sum
    };
    let (woven, deinterlaced) = (read_all(&path).0, read_all_by(&path, DEINTERLACED).0);
    assert_eq!(woven.len(), deinterlaced.len());
    let (before, after) = (combs(&woven), combs(&deinterlaced));
    assert!(after * 10 < before * 9, "{before} before, {after} after");

    let path = place.path("whole.mp4");
    assert!(encode(&path, SMALL, "libx264", "-pix_fmt yuv420p"));
    let [warning] = &check_deinterlaced(&path, 10)[..] else { panic!() };
    assert!(warning.contains("not marked as interlaced") && warning.contains("leave it out"), "{warning}");
}

#[test]
fn every_frame_of_a_deinterlaced_video_is_kept_when_its_size_changes() {
    let place = TestFolder::new();
    let (small, large) = (place.path("small.ts"), place.path("large.ts"));
    assert!(encode(&small, SMALL, "libx264", "-pix_fmt yuv420p -g 20 -flags +ildct+ilme"));
    let later = "-pix_fmt yuv420p -g 20 -flags +ildct+ilme -output_ts_offset 1.6";
    assert!(encode(&large, "size=200x160:rate=25:duration=1", "libx264", later));
    let path = place.path("sizes.ts");
    fs::write(&path, [fs::read(&small).unwrap(), fs::read(&large).unwrap()].concat()).unwrap();
    let (frames, warnings, _) = read_all_by(&path, DEINTERLACED);
    assert_eq!(frames.len(), count_by_program(&path));
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("at frame 41"), "{warning}");
    assert_same_in_any_order_by(&path, DEINTERLACED, &frames, 60);
}

#[test]
fn a_video_that_changes_is_not_read_again_for_its_damage() {
    let place = TestFolder::new();
    let path = place.path("a.ts");
    assert!(encode(&path, LONG, "libx264", "-pix_fmt yuv420p -bf 2 -g 20"));
    let length = fs::metadata(&path).unwrap().len() as usize;
    damage(&path, length * 2 / 3, 7001);
    let read = |changes: bool| {
        let mut source = source::open(path.to_str().unwrap(), Options::default()).unwrap();
        if changes {
            fs::OpenOptions::new().append(true).open(&path).unwrap().write_all(&[0; 188]).unwrap();
        }
        while source.next_frame()?.is_some() {}
        Ok::<_, source::SourceError>(())
    };
    assert!(read(false).is_ok());
    let error = read(true).unwrap_err().to_string();
    assert!(error.contains("changed while being read"), "{error}");
}

#[test]
fn damaged_video_is_deinterlaced_the_same_way_each_time() {
    let place = TestFolder::new();
    let path = place.path("a.ts");
    assert!(encode(&path, FIELDS, "libx264", "-pix_fmt yuv420p -bf 2 -g 20 -flags +ildct+ilme"));
    damage(&path, 9000, 7001);
    let (frames, warnings, _) = read_all_by(&path, DEINTERLACED);
    assert!(warnings.iter().any(|warning| warning.contains("damaged")), "{warnings:?}");
    assert!(read_all_by(&path, DEINTERLACED).0 == frames);
    assert_same_in_any_order_by(&path, DEINTERLACED, &frames, JUMPS);
}

#[test]
fn frames_that_say_that_they_are_interlaced_are_told_once() {
    let place = TestFolder::new();
    for (name, encoder, options) in [
        ("a.avi", "mpeg4", "-flags +ildct+ilme -g 12"),
        ("a.mkv", "libx264", "-pix_fmt yuv420p -flags +ildct+ilme"),
    ] {
        let path = place.path(name);
        assert!(encode(&path, FIELDS, encoder, options));
        let [warning] = &check(&path, 10)[..] else { panic!("{name}") };
        assert!(warning.contains("is interlaced") && warning.contains("--deinterlace"), "{warning}");
    }
}

#[test]
fn damage_that_the_decoder_only_reports_is_told() {
    let place = TestFolder::new();
    let path = place.path("a.mkv");
    assert!(encode(&path, SMALL, "ffv1", "-pix_fmt yuv420p -level 3 -slicecrc 1"));
    let whole = read_all(&path).0;
    damage(&path, 20_000, 40_009);
    let (frames, warnings, _) = read_all(&path);
    assert!(frames != whole);
    let is_told = |warning: &String| warning.contains("is damaged: the missing parts of");
    assert!(warnings.iter().any(is_told), "{warnings:?}");
    assert_same_in_any_order(&path, &frames, JUMPS);
}

#[test]
fn a_video_that_starts_late_is_not_short() {
    let place = TestFolder::new();
    let (first, late) = (place.path("a.mp4"), place.path("late.mkv"));
    assert!(encode(&first, SMALL, "libx264", "-pix_fmt yuv420p"));
    remux(&first, "-itsoffset 5.5", "", &late);
    assert_eq!(read_all(&late).1, Vec::<String>::new());
}

#[test]
fn sound_alone_is_no_video() {
    let place = TestFolder::new();
    let path = place.path("a.mp4");
    make(&path, "-f lavfi -i sine=duration=1 -c:a aac");
    let error = source::open(path.to_str().unwrap(), Options::default()).map(drop).unwrap_err().to_string();
    assert!(error.contains("no video stream"), "{error}");
}

#[test]
fn the_chosen_stream_is_read() {
    let place = TestFolder::new();
    let path = place.path("three.mkv");
    let video = |size: &str| format!("-f lavfi -i testsrc2=size={size}:rate=25:duration=2");
    let inputs = format!("{} -f lavfi -i sine=duration=2 {}", video("160x120"), video("80x60"));
    make(&path, &format!("{inputs} -map 0 -map 1 -map 2 -c:v libx264 -g 12 -pix_fmt yuv420p -c:a pcm_s16le"));
    for (stream, width) in [(0, 160), (2, 80)] {
        let options = Options { stream: Some(stream), ..Options::default() };
        let (frames, warnings, info) = read_all_by(&path, options);
        assert_eq!((frames.len(), info.size.width, warnings), (50, width, Vec::new()));
        assert_as_program_by(&path, &frames, "", &format!("-map 0:{stream}"));
        assert_same_in_any_order_by(&path, options, &frames, JUMPS);
    }
    for stream in [1, 3, u32::MAX] {
        let options = Options { stream: Some(stream), ..Options::default() };
        let error = source::open(path.to_str().unwrap(), options).map(drop).unwrap_err().to_string();
        assert!(error.contains(&format!("no video stream {stream}")) && !error.contains('\n'), "{error}");
        assert!(error.contains("0 (h264, 160×120, 25 fps), 2 (h264, 80×60, 25 fps)"), "{error}");
    }
}

/// Answers every request at an address with these bytes, or with nothing.
fn serve(answer: Option<Vec<u8>>) -> String {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}/a.ts", server.local_addr().unwrap());
    thread::spawn(move || {
        for connection in server.incoming() {
            let mut connection = connection.unwrap();
            let mut request = [0; 4096];
            let _ = connection.read(&mut request);
            if let Some(answer) = &answer {
                let _ = connection.write_all(answer);
            }
        }
    });
    address
}

#[test]
fn a_network_stream_is_read_once() {
    let place = TestFolder::new();
    let path = place.path("a.ts");
    assert!(encode(&path, SMALL, "libx264", "-pix_fmt yuv420p -g 12"));
    let header = "HTTP/1.0 200 OK\r\nContent-Type: video/mp2t\r\n\r\n";
    let address = serve(Some([header.as_bytes(), &fs::read(&path).unwrap()].concat()));
    let (frames, warnings, info) = read_all(Path::new(&address));
    assert!(info.live && info.frames.is_none() && info.name == address);
    assert!(frames == read_all(&path).0);
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("sends no more frames after frame 40"), "{warning}");

    let mut cache = FrameCache::open(&address, Options::default(), 0).unwrap();
    assert!(cache.get(30).unwrap().is_some());
    assert!(cache.get(3).unwrap().is_none(), "it cannot be read again");
}

#[test]
fn an_address_that_cannot_be_read_is_told_in_one_line() {
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    for (address, why) in [
        (format!("http://{free}/a.mp4"), "Connection refused"),
        (format!("rtsp://{free}/a"), "Connection refused"),
        (serve(Some(b"HTTP/1.0 404 Not Found\r\n\r\n".to_vec())), "404"),
        // FFmpeg reads text as a video of a terminal where only the name says what it is.
        (serve(Some(b"HTTP/1.0 200 OK\r\n\r\nno video".to_vec())), ""),
        (serve(None), ""),
    ] {
        let error = source::open(&address, Options::default()).map(drop).unwrap_err().to_string();
        assert!(error.starts_with(&address) && error.contains(why) && !error.contains('\n'), "{error}");
        assert!(error.contains("check the address"), "{error}");
    }
}

#[test]
fn steps_back_with_little_memory_give_the_same_frames() {
    let place = TestFolder::new();
    let path = long_groups(&place, "160x120");
    let (frames, _, _) = read_all(&path);
    let mut cache = FrameCache::open(path.to_str().unwrap(), Options::default(), 40 * 160 * 120 * 3).unwrap();
    assert!(cache.get(500).unwrap().is_none());
    for position in (350..500).rev().chain((90..140).rev()) {
        let frame = cache.get(position).unwrap();
        assert!(frame.as_deref() == Some(&frames[position as usize]), "position {position}");
        cache.view(position);
    }
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

/// Frames at irregular times, as of a phone in low light.
const VARIABLE: &str = "size=160x120:rate=30:duration=3,select='lt(mod(n,11),8)*not(between(n,40,66))'";

#[test]
fn times_are_those_of_the_file() {
    let place = TestFolder::new();
    let first = place.path("variable.mp4");
    assert!(encode(&first, VARIABLE, "libx264", "-pix_fmt yuv420p -vsync vfr -bf 2 -g 12"));
    for (name, options) in [("a.mkv", ""), ("a.ts", ""), ("late.ts", "-output_ts_offset 4000"), ("a.mp4", "")]
    {
        let path = place.path(name);
        remux(&first, "", options, &path);
        let expected = times_by_program(&path);
        let (frames, ..) = read_all(&path);
        assert_eq!(frames.len(), expected.len(), "{name}");
        for (frame, time) in frames.iter().zip(&expected) {
            assert!((frame.time - (time - expected[0])).abs() < 2e-6, "{name}: frame {}", frame.number);
        }
        let longest = frames.windows(2).map(|pair| pair[1].time - pair[0].time).fold(0.0, f64::max);
        assert!(longest > 0.8, "{name}: {longest}");

        let mut cache = FrameCache::open(path.to_str().unwrap(), Options::default(), 0).unwrap();
        assert!(cache.get(frames.len() as u32).unwrap().is_none());
        for position in [30, 2, 41, 0] {
            let again = cache.get(position).unwrap().unwrap();
            assert_eq!(again.time, frames[position as usize].time, "{name}: position {position}");
        }
        let options = Options { fps: Some(8.0), ..Options::default() };
        let mut source = source::open(path.to_str().unwrap(), options).unwrap();
        let third = (0..3).map(|_| source.next_frame().unwrap().unwrap()).last();
        assert_eq!(third.unwrap().time, 0.25, "{name}: a given rate is constant");
    }
}

/// A film of 500 frames with a key frame every 250, as large as `size`.
fn long_groups(place: &TestFolder, size: &str) -> PathBuf {
    let path = place.path("groups.mp4");
    let x264 = "-pix_fmt yuv420p -preset veryfast -x264-params keyint=250:scenecut=0:bframes=3";
    let input = format!("size={size}:rate=25:duration=20,noise=alls=6:allf=t");
    assert!(encode(&path, &input, "libx264", x264));
    path
}

/// Run by hand: `cargo test --release --locked --test decode -- --ignored --nocapture the_time_of_steps_back`.
#[test]
#[ignore = "a measurement"]
fn the_time_of_steps_back_with_little_memory() {
    let place = TestFolder::new();
    let path = long_groups(&place, "1920x1080");
    for pause in [0, 33, 100, 200] {
        let mut cache =
            FrameCache::open(path.to_str().unwrap(), Options::default(), 64 * 1920 * 1080 * 3).unwrap();
        assert!(cache.get(500).unwrap().is_none());
        let mut times: Vec<f64> = (300..500)
            .rev()
            .map(|position| {
                let started = Instant::now();
                assert!(cache.get(position).unwrap().is_some());
                cache.view(position);
                let time = started.elapsed().as_secs_f64() * 1000.0;
                thread::sleep(Duration::from_millis(pause));
                time
            })
            .collect();
        let total: f64 = times.iter().sum();
        times.sort_by(f64::total_cmp);
        let slow = times.iter().filter(|&&time| time > 100.0).count();
        println!(
            "{pause} ms between steps: median {:.1} ms, longest {:.0} ms, {slow} of 200 above 100 ms, waited {total:.0} ms",
            times[100], times[199]
        );
    }
}

/// Run by hand: `cargo test --release --locked --test decode -- --ignored --nocapture the_time_of_decoding`.
#[test]
#[ignore = "a measurement"]
fn the_time_of_decoding() {
    let place = TestFolder::new();
    let path = long_groups(&place, "1920x1080");
    let name = path.to_str().unwrap();
    let threads = thread::available_parallelism().unwrap().to_string();
    let program = |options: &[&str]| {
        let started = Instant::now();
        let mut command = std::process::Command::new("ffmpeg");
        command.args(["-nostdin", "-loglevel", "error", "-threads", &threads, "-i", name]).args(options);
        assert!(command.args(["-f", "null", "-"]).status().unwrap().success());
        started.elapsed().as_secs_f64()
    };
    let ours = || {
        let started = Instant::now();
        let mut source = source::open(name, Options::default()).unwrap();
        while source.next_frame().unwrap().is_some() {}
        started.elapsed().as_secs_f64()
    };
    for _ in 0..5 {
        let (decoded, ours, converted) = (program(&[]), ours(), program(&["-pix_fmt", "rgb24"]));
        println!(
            "ffmpeg {decoded:.2} s, with RGB {converted:.2} s; here {ours:.2} s: {:.2} and {:.2} of them",
            ours / decoded,
            ours / converted
        );
    }
}
