//! Files that are no video, or not a whole one.

use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::thread;

use crate::common::{TestFolder, noise, scene, text, works, write_images};
use crate::encoded::{encode, make, remux};
use crate::{assert_refused, frames_of, has_time, read_all, run};

const INPUT: &str = "size=64x48:rate=25:duration=2";

fn random_bytes(count: u32) -> Vec<u8> {
    (0..count).map(|at| noise(at, at >> 8, 7)).collect()
}

/// A video of 50 frames with key frames every ten.
fn video(place: &TestFolder, name: &str, options: &str) -> PathBuf {
    let path = place.path(name);
    let encoder = if name.ends_with("avi") { "mpeg4" } else { "libx264" };
    assert!(encode(&path, INPUT, encoder, &format!("-g 10 {options}")));
    path
}

#[test]
fn what_is_no_video_is_refused_under_any_ending() {
    let place = TestFolder::new();
    let mut zip = Vec::new();
    zip.extend_from_slice(b"PK\x03\x04\x14\0\0\0\0\0");
    zip.extend(random_bytes(2000));
    let mut png = std::io::Cursor::new(Vec::new());
    scene(1).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let json = br#"{"frames": [1, 2, 3]}"#.to_vec();
    let gzip = [&[0x1f, 0x8b, 8, 0][..], &random_bytes(500)].concat();
    let elf = [&b"\x7fELF\x02\x01\x01\0"[..], &random_bytes(500)].concat();
    for ending in ["mp4", "avi", "mkv", "mov", "webm", "ts", "mpg", "gif", "y4m", "xyz", ""] {
        for (name, content) in [
            ("empty", Vec::new()),
            ("random", random_bytes(40_000)),
            ("zeros", vec![0; 5000]),
            ("text", b"a note about the video\n".repeat(50)),
            ("html", b"<!DOCTYPE html><html><body>404</body></html>".to_vec()),
            ("json", json.clone()),
            ("zip", zip.clone()),
            ("gzip", gzip.clone()),
            ("program", elf.clone()),
            ("one-byte", vec![0x47]),
        ] {
            let path = place.path(&format!("{name}.{ending}"));
            fs::write(&path, content).unwrap();
            assert!(read_all(&path).is_err_and(|error| error.contains(" cannot be used: ")), "{path:?}");
            if ending == "mp4" && (has_time() || ["empty", "text", "zip"].contains(&name)) {
                assert_refused(&place, &path, &[" cannot be used: "]);
            }
        }
    }
    // An image under the name of a video.
    let path = place.path("image.mp4");
    fs::write(&path, png.into_inner()).unwrap();
    assert_refused(&place, &path, &["single image"]);
}

#[test]
fn a_video_under_another_ending_is_read() {
    let place = TestFolder::new();
    let whole = video(&place, "a.mp4", "");
    for name in ["a.avi", "a.dat", "a", "a.mp4.part", "a.png.mkv"] {
        let path = place.path(name);
        fs::copy(&whole, &path).unwrap();
        assert_eq!(read_all(&path), Ok((50, Vec::new())), "{name}");
    }
}

#[test]
fn a_cut_video_is_read_to_the_cut_or_refused() {
    let place = TestFolder::new();
    for (name, options) in [
        ("a.mp4", ""),
        ("fast.mp4", "-movflags +faststart"),
        ("pieces.mp4", "-movflags frag_keyframe+empty_moov"),
        ("a.avi", ""),
        ("a.mkv", ""),
        ("a.ts", ""),
    ] {
        let whole = video(&place, name, options);
        let bytes = fs::read(&whole).unwrap();
        for share in [1, 30, 60, 99] {
            let path = place.path(&format!("cut-{share}-{name}"));
            fs::write(&path, &bytes[..bytes.len() * share / 100]).unwrap();
            match read_all(&path) {
                Ok((frames, warnings)) => {
                    // The header of a transport stream has no number of frames.
                    let is_told = frames >= 45 || !warnings.is_empty() || name.ends_with("ts");
                    assert!(frames <= 50 && is_told, "{name} {share}: {frames}");
                }
                Err(error) => assert!(error.contains("check that it is complete"), "{error}"),
            }
        }
    }
}

#[test]
fn zeros_within_a_stream_cost_only_the_frames_that_they_hit() {
    let place = TestFolder::new();
    for name in ["a.mp4", "a.avi", "a.mkv", "a.ts"] {
        let path = video(&place, name, "-b:v 400k");
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle..middle + 400].fill(0);
        fs::write(&path, bytes).unwrap();
        let said = run(&place, &path, &[]);
        let warnings = said.warnings();
        // Packets that a transport stream has lost look like those between two joined streams, which are whole.
        let is_told = !warnings.is_empty() || name.ends_with("ts");
        assert!(is_told && warnings.iter().all(|line| line.contains(name)), "{warnings:?}");
        assert!(frames_of(&place).0 >= 40, "{name}: {:?}", frames_of(&place));
    }
}

#[test]
fn no_changed_byte_of_a_small_video_ends_the_program() {
    let place = TestFolder::new();
    for (name, encoder) in [("a.mp4", "libx264"), ("a.avi", "mjpeg"), ("a.mkv", "ffv1"), ("a.gif", "gif")] {
        let path = place.path(name);
        assert!(encode(&path, "size=16x16:rate=5:duration=1", encoder, ""));
        let whole = fs::read(&path).unwrap();
        let all = if has_time() { 10_000 } else { 60 };
        for change in 0..all {
            let mut bytes = whole.clone();
            for times in 0..=change % 3 {
                let at = (u64::from(change) * 7919 + u64::from(times) * 104_729) % bytes.len() as u64;
                bytes[at as usize] ^= noise(change, times, 3) | 1;
            }
            fs::write(&path, bytes).unwrap();
            // The checks are those of every reading.
            let _ = read_all(&path);
        }
    }
}

/// Overwrites a number of 32 bits `after` bytes behind the first or last occurrence of a name in a file.
fn set_number(path: &Path, name: &[u8], after: usize, number: [u8; 4]) {
    let mut bytes = fs::read(path).unwrap();
    let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + after;
    bytes[at..at + 4].copy_from_slice(&number);
    fs::write(path, bytes).unwrap();
}

/// FFV1 has nothing else that tells a changed byte from the right one.
#[test]
fn a_changed_byte_of_a_lossless_scene_is_told() {
    let place = TestFolder::new();
    let scene = place.path("scene");
    let line = ["synth", "empty", "--frames", "9", "--size", "64x64", "--lossless", "--quiet", "--out"];
    works(&[&line[..], &[text(&scene)]].concat());
    let video = scene.join("empty.avi");
    let whole = fs::read(&video).unwrap();
    for share in [3, 5, 7] {
        let mut bytes = whole.clone();
        bytes[whole.len() * share / 10] ^= 0x55;
        fs::write(&video, bytes).unwrap();
        let (frames, warnings) = read_all(&video).unwrap();
        assert_eq!(frames, 9);
        assert!(warnings.iter().any(|warning| warning.contains("is damaged")), "{warnings:?}");
    }
}

#[test]
fn the_number_of_frames_in_a_header_is_not_believed() {
    let place = TestFolder::new();
    let claimed = [0, u32::MAX, 1, 7, 1_000_000_u32];
    for &frames in &claimed[..if has_time() { 5 } else { 2 }] {
        let path = video(&place, "a.avi", "");
        // In the main header, and in that of the stream.
        set_number(&path, b"avih", 8 + 16, frames.to_le_bytes());
        set_number(&path, b"strh", 8 + 32, frames.to_le_bytes());
        let said = run(&place, &path, &[]);
        assert_eq!(frames_of(&place), (50, 1, 50), "{frames}");
        assert!(said.warnings().len() <= 1, "{:?}", said.lines);
        // The duration in an MP4 file: that of the file, of the track and of its media.
        let path = video(&place, "a.mp4", "");
        for (name, after) in [(&b"mvhd"[..], 20), (b"tkhd", 24), (b"mdhd", 20)] {
            set_number(&path, name, after, frames.to_be_bytes());
        }
        run(&place, &path, &[]).warnings();
        assert_eq!(frames_of(&place), (50, 1, 50), "{frames}");
    }
}

#[test]
fn a_size_that_changes_in_the_middle_is_told() {
    let place = TestFolder::new();
    let (first, second, both) = (place.path("1.ts"), place.path("2.ts"), place.path("both.ts"));
    assert!(encode(&first, "size=64x48:rate=25:duration=1", "libx264", ""));
    assert!(encode(&second, "size=96x64:rate=25:duration=1", "libx264", "-output_ts_offset 1"));
    fs::write(&both, [fs::read(&first).unwrap(), fs::read(&second).unwrap()].concat()).unwrap();
    let said = run(&place, &both, &[]);
    let warnings = said.warnings();
    assert!(
        warnings.iter().any(|line| line.contains("changes its size from 64×48 to 96×64")),
        "{warnings:?}"
    );
    assert_eq!(frames_of(&place), (50, 1, 50));
}

#[test]
fn a_size_that_a_header_only_claims_is_not_allocated() {
    let place = TestFolder::new();
    // A frame of a codec whose packets have a header of their own, in a file that claims another size.
    for (name, encoder) in [("a.avi", "mjpeg"), ("b.avi", "rawvideo"), ("c.avi", "ffv1")] {
        let path = place.path(name);
        assert!(encode(&path, "size=64x48:rate=25:duration=1", encoder, ""));
        let mut bytes = fs::read(&path).unwrap();
        let at = bytes.windows(4).position(|window| window == b"strf").unwrap() + 8;
        bytes[at + 4..at + 12]
            .copy_from_slice(&[60_000_u32.to_le_bytes(), 60_000_u32.to_le_bytes()].concat());
        fs::write(&path, bytes).unwrap();
        let said = run(&place, &path, &[]);
        assert!(said.status < 2, "{:?}", said.lines);
    }
}

#[test]
fn the_smallest_videos_are_analysed() {
    let place = TestFolder::new();
    for size in ["1x1", "1x40", "40x1", "2x2"] {
        let path = place.path("small.mkv");
        make(&path, &format!("-f lavfi -i color=c=gray:s={size}:r=5:d=1,format=gbrp -c:v ffv1"));
        assert!(run(&place, &path, &["--masks", "--annotated", "--labels"]).warnings().is_empty(), "{size}");
        assert_eq!(frames_of(&place), (5, 1, 5), "{size}");
    }
    let path = place.path("one-frame.mp4");
    make(&path, "-f lavfi -i testsrc2=size=64x48:rate=25:duration=0.04 -c:v libx264");
    run(&place, &path, &["--annotated"]).warnings();
    assert_eq!(frames_of(&place), (1, 1, 1));
}

#[test]
fn files_without_pictures_are_refused() {
    let place = TestFolder::new();
    let sound = place.path("sound.mp4");
    make(&sound, "-f lavfi -i sine=duration=1 -c:a aac");
    assert_refused(&place, &sound, &["no video stream"]);
    let subtitles = place.path("subtitles.srt");
    fs::write(&subtitles, "1\n00:00:00,000 --> 00:00:01,000\nHello\n").unwrap();
    assert_refused(&place, &subtitles, &["text, not a video"]);
    // A file with a stream of pictures that has none.
    let (whole, none) = (video(&place, "whole.mkv", ""), place.path("none.mkv"));
    remux(&whole, "", "-frames:v 0", &none);
    assert_refused(&place, &none, &["check that it is complete"]);
}

#[test]
fn folders_of_videos_are_no_folders_of_images() {
    let place = TestFolder::new();
    let folder = place.path("clips");
    fs::create_dir(&folder).unwrap();
    for name in ["one.mp4", "two.avi"] {
        fs::write(folder.join(name), "").unwrap();
    }
    assert_refused(&place, &folder, &["2 videos and no images", "one.mp4"]);
    make(&folder.join("three.gif"), "-f lavfi -i testsrc2=size=32x24:rate=5:duration=1 -c:v gif");
    assert_refused(&place, &folder, &["2 videos and 1 image;", "one.mp4"]);
    // A video among images is left out.
    write_images(&folder, 5, 1);
    fs::remove_file(folder.join("three.gif")).unwrap();
    run(&place, &folder, &[]).warnings();
    assert_eq!(frames_of(&place), (5, 1, 5));
}

#[test]
fn playlists_name_the_parts_that_are_missing() {
    let place = TestFolder::new();
    let list = place.path("list.m3u8");
    make(
        &list,
        "-f lavfi -i testsrc2=size=64x48:rate=25:duration=6 -c:v libx264 -g 25 -hls_time 1 -hls_list_size 0",
    );
    assert!(run(&place, &list, &[]).warnings().is_empty());
    assert_eq!(frames_of(&place), (150, 1, 150));
    for part in 2..4 {
        fs::remove_file(place.path(&format!("list{part}.ts"))).unwrap();
    }
    let said = run(&place, &list, &[]);
    let warnings = said.warnings();
    assert!(
        warnings
            .iter()
            .any(|line| line.contains("2 of its 6 parts do not exist, the first of them list2.ts")),
        "{warnings:?}"
    );
    assert_eq!(frames_of(&place).0, 100);
    fs::remove_dir_all(place.path("out")).unwrap();
    for (content, part) in [
        ("#EXTM3U\n#EXTINF:2,\ngone.ts\n#EXT-X-ENDLIST\n", "gone.ts"),
        ("#EXTM3U\n#EXTINF:2,\nhttp://127.0.0.1:9/a.ts\n", "on the network"),
        ("#EXTM3U\n", "without parts"),
    ] {
        fs::write(&list, content).unwrap();
        assert_refused(&place, &list, &["playlist", part]);
    }
}

/// Serves the files of a folder on this machine; returns the address.
fn serve(folder: PathBuf) -> String {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}", server.local_addr().unwrap());
    thread::spawn(move || {
        for stream in server.incoming().flatten() {
            let mut request = String::new();
            let mut reader = BufReader::new(&stream);
            while reader.read_line(&mut request).is_ok_and(|length| length > 2) {}
            let name = request.split(['/', ' ']).nth(2).unwrap_or_default();
            let (status, content) = match fs::read(folder.join(name)) {
                Ok(content) => ("200 OK", content),
                Err(_) => ("404 Not Found", Vec::new()),
            };
            let head = format!(
                "HTTP/1.1 {status}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
                content.len()
            );
            let _ = (&stream).write_all(head.as_bytes()).and_then(|()| (&stream).write_all(&content));
        }
    });
    address
}

#[test]
fn a_stream_without_one_of_its_parts_is_told() {
    let place = TestFolder::new();
    let list = place.path("list.m3u8");
    make(
        &list,
        "-f lavfi -i testsrc2=size=64x48:rate=25:duration=4 -c:v libx264 -g 25 -hls_time 1 -hls_list_size 0",
    );
    let address = serve(place.path("."));
    let stream = format!("{address}/list.m3u8");
    assert_eq!(read_all(Path::new(&stream)).unwrap().0, 100);
    fs::remove_file(place.path("list2.ts")).unwrap();
    let said = run(&place, Path::new(&stream), &[]);
    let told = said
        .lines
        .iter()
        .any(|line| line.starts_with("warning: ") && line.contains("lacks a part after frame"));
    assert!(told, "{:?}", said.lines);
    assert_eq!(frames_of(&place).0, 75);
}
