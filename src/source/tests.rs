#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use opencv::core::{CV_8UC3, Mat, Scalar, Size as CvSize};
use opencv::prelude::*;
use opencv::videoio::{CAP_FFMPEG, VideoWriter};
use tempfile::TempDir;

use super::*;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn name(path: impl AsRef<Path>) -> String {
    path.as_ref().to_str().unwrap().to_owned()
}

fn open_error(path: impl AsRef<Path>) -> String {
    let error = open(&name(&path), Options::default()).map(|_| ()).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

fn read_all(path: impl AsRef<Path>) -> (Vec<Frame>, Vec<String>) {
    let mut source = open(&name(path), Options::default()).unwrap();
    let size = source.info().size;
    let mut frames = Vec::new();
    while let Some(frame) = source.next_frame().unwrap() {
        assert_eq!(frame.size, size);
        frames.push(frame);
    }
    assert!(source.next_frame().unwrap().is_none(), "the end is final");
    (frames, source.take_warnings())
}

fn numbers(frames: &[Frame]) -> Vec<u32> {
    frames.iter().map(|frame| frame.number).collect()
}

/// A picture whose pixel values encode their coordinates and the picture's index.
fn picture(width: u32, height: u32, index: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| Rgb([(x * 7) as u8, (y * 11) as u8, (index * 13 + x * y) as u8]))
}

/// Writes frames of a single gray level that rises by 12 per frame.
fn write_video(path: &Path, fourcc: [u8; 4], fps: f64, (width, height): (i32, i32), frames: u32) {
    silence_libraries();
    let [a, b, c, d] = fourcc.map(char::from);
    let fourcc = VideoWriter::fourcc(a, b, c, d).unwrap();
    let mut writer = VideoWriter::new_with_backend(
        path.to_str().unwrap(),
        CAP_FFMPEG,
        fourcc,
        fps,
        CvSize::new(width, height),
        true,
    )
    .unwrap();
    assert!(writer.is_opened().unwrap());
    for index in 0..frames {
        let level = f64::from(level(index));
        let frame =
            Mat::new_rows_cols_with_default(height, width, CV_8UC3, Scalar::new(level, level, level, 0.0))
                .unwrap();
        writer.write(&frame).unwrap();
    }
    writer.release().unwrap();
}

fn level(index: u32) -> u8 {
    (20 + index * 12 % 200) as u8
}

fn assert_levels(frames: &[Frame]) {
    for (index, frame) in (0..).zip(frames) {
        let middle = frame.pixel(frame.size.width / 2, frame.size.height / 2).unwrap();
        for channel in middle {
            assert!(channel.abs_diff(level(index)) <= 5, "frame {}: {middle:?}", frame.number);
        }
    }
}

#[test]
fn videos_are_read_in_order_and_counted() {
    let folder = folder();
    for (file, fourcc, size) in [
        ("a.avi", *b"MJPG", (64, 48)),
        ("b.mp4", *b"mp4v", (66, 50)),
        ("odd name: 50%.avi", *b"MJPG", (34, 18)),
        ("c.mkv", *b"MJPG", (64, 48)),
    ] {
        let path = folder.path().join(file);
        write_video(&path, fourcc, 12.5, size, 23);
        let info = open(&name(&path), Options::default()).unwrap().info().clone();
        assert_eq!((info.fps, info.live), (12.5, false), "{file}");
        assert_eq!(info.size, Size::new(size.0 as u32, size.1 as u32));
        assert!(info.frames.is_some_and(|frames| frames.abs_diff(23) <= 1), "{info:?}");
        let (frames, warnings) = read_all(&path);
        assert_eq!(numbers(&frames), (1..=23).collect::<Vec<_>>(), "{file}");
        assert_eq!(warnings, Vec::<String>::new(), "{file}");
        assert_levels(&frames);
    }
}

#[test]
fn a_truncated_video_is_read_to_its_end() {
    let folder = folder();
    for (file, fourcc) in [("a.avi", *b"MJPG"), ("b.mkv", *b"MJPG"), ("c.avi", *b"mp4v")] {
        let path = folder.path().join(file);
        write_video(&path, fourcc, 25.0, (160, 120), 60);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let (frames, warnings) = read_all(&path);
        let count = frames.len() as u32;
        assert!((15..45).contains(&count), "{file}: {count}");
        assert_eq!(numbers(&frames), (1..=count).collect::<Vec<_>>());
        let [warning] = &warnings[..] else { panic!("{file}: {warnings:?}") };
        assert!(warning.contains(&format!("ends after frame {count}")), "{warning}");
        assert!(warning.contains(file), "{warning}");
    }
}

#[test]
fn a_corrupt_video_is_read_to_the_corruption() {
    let folder = folder();
    let path = folder.path().join("a.avi");
    write_video(&path, *b"MJPG", 25.0, (160, 120), 60);
    let mut bytes = fs::read(&path).unwrap();
    let (third, half) = (bytes.len() / 3, bytes.len() / 2);
    for (index, byte) in bytes[third..half].iter_mut().enumerate() {
        *byte = (index * 31 % 251) as u8;
    }
    fs::write(&path, &bytes).unwrap();
    let (frames, warnings) = read_all(&path);
    assert!(frames.len() >= 8, "{}", frames.len());
    assert_levels(&frames[..8]);
    assert!(warnings.len() == 1 || frames.len() >= 57, "{} frames, {warnings:?}", frames.len());
}

#[test]
fn files_that_are_not_video_are_refused() {
    let folder = folder();
    let path = |file: &str| folder.path().join(file);
    assert!(open_error(path("nothing.avi")).ends_with("nothing.avi does not exist; check the path"));
    assert!(open_error("/dev/null").contains("neither a file nor a folder"));

    fs::write(path("empty.avi"), b"").unwrap();
    assert!(open_error(path("empty.avi")).contains("is empty"));
    fs::write(path("notes.txt"), "some notes\n".repeat(100)).unwrap();
    assert!(open_error(path("notes.txt")).contains("text, not a video"));
    fs::write(path("noise.mp4"), (0..20_000_u32).map(|i| ((i * i) >> 5) as u8).collect::<Vec<_>>()).unwrap();
    assert!(open_error(path("noise.mp4")).contains("not a decodable video"));
    picture(8, 8, 0).save(path("one.png")).unwrap();
    assert!(open_error(path("one.png")).contains("single image"));

    // The index of an mp4 is at its end: nothing can be read without it.
    write_video(&path("cut.mp4"), *b"mp4v", 25.0, (160, 120), 30);
    let bytes = fs::read(path("cut.mp4")).unwrap();
    fs::write(path("cut.mp4"), &bytes[..bytes.len() * 2 / 3]).unwrap();
    assert!(open_error(path("cut.mp4")).contains("not a decodable video"));

    // A header without a frame.
    write_video(&path("head.avi"), *b"MJPG", 25.0, (160, 120), 30);
    let bytes = fs::read(path("head.avi")).unwrap();
    let movi = bytes.windows(4).position(|window| window == b"movi").unwrap();
    fs::write(path("head.avi"), &bytes[..movi + 4]).unwrap();
    let error = open_error(path("head.avi"));
    assert!(error.contains("frames can be decoded") || error.contains("not a decodable"), "{error}");
}

#[test]
fn missing_cameras_are_refused() {
    assert!(open_error("camera:front").contains("by number"));
    assert!(open_error("camera:-1").contains("by number"));
    assert!(open_error("camera:97").contains("no such camera"));
}

#[test]
fn folders_are_read_in_natural_order_and_numbered_by_name() {
    let folder = folder();
    for index in [470, 9, 10, 101] {
        picture(13, 7, index).save(folder.path().join(format!("in{index}.png"))).unwrap();
    }
    fs::write(folder.path().join("readme.txt"), "not an image").unwrap();
    fs::write(folder.path().join(".in5.png"), "hidden").unwrap();
    fs::create_dir(folder.path().join("in7.png")).unwrap();
    let source = open(&name(folder.path()), Options::default()).unwrap();
    let info = source.info();
    assert_eq!((info.fps, info.frames, info.live), (25.0, Some(4), false));
    let (frames, warnings) = read_all(folder.path());
    assert_eq!(numbers(&frames), [9, 10, 101, 470]);
    assert_eq!(warnings, Vec::<String>::new());
    for frame in frames {
        assert_eq!(frame.rgb, picture(13, 7, frame.number).into_raw(), "bit for bit");
    }
}

#[test]
fn patterns_take_frame_numbers_from_file_names() {
    let folder = folder();
    for index in [3, 5, 4, 120] {
        picture(6, 5, index).save(folder.path().join(format!("in{index:06}.png"))).unwrap();
    }
    picture(9, 9, 0).save(folder.path().join("mean.png")).unwrap();
    let (frames, _) = read_all(folder.path().join("in%06d.png"));
    assert_eq!(numbers(&frames), [3, 4, 5, 120]);
    assert_eq!(frames[3].rgb, picture(6, 5, 120).into_raw());
    assert!(open_error(folder.path().join("im%06d.png")).contains("no file matches"));
    assert!(open_error(folder.path().join("in%s.png")).contains("not a pattern"));
    assert!(open_error(folder.path().join("gone/in%d.png")).contains("does not exist"));
}

#[test]
fn every_pixel_format_is_converted_to_rgb() {
    let folder = folder();
    let path = |file: &str| folder.path().join(file);
    GrayImage::from_fn(4, 3, |x, y| Luma([(x * 50 + y) as u8])).save(path("1.png")).unwrap();
    let deep: ImageBuffer<Rgb<u16>, Vec<u16>> =
        ImageBuffer::from_fn(4, 3, |x, y| Rgb([(x * 257) as u16 * 60, (y * 257) as u16 * 80, u16::MAX]));
    deep.save(path("2.png")).unwrap();
    let deep_gray: ImageBuffer<Luma<u16>, Vec<u16>> =
        ImageBuffer::from_fn(4, 3, |x, _| Luma([[0, 128, 129, 65535][x as usize]]));
    deep_gray.save(path("3.tiff")).unwrap();
    RgbaImage::from_fn(4, 3, |x, _| Rgba([10, 20, 30, (x * 80) as u8])).save(path("4.png")).unwrap();
    DynamicImage::from(picture(4, 3, 5)).save(path("5.bmp")).unwrap();
    DynamicImage::from(picture(4, 3, 6)).save(path("6.ppm")).unwrap();
    let (frames, warnings) = read_all(folder.path());
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(numbers(&frames), [1, 2, 3, 4, 5, 6]);
    assert_eq!(frames[0].pixel(2, 1), Some([101; 3]), "gray is replicated");
    assert_eq!(frames[1].pixel(3, 2), Some([180, 160, 255]), "16 bits are scaled");
    let scaled: Vec<_> = (0..4).map(|x| frames[2].pixel(x, 0).unwrap()[0]).collect();
    assert_eq!(scaled, [0, 0, 1, 255], "and rounded");
    assert!((0..4).all(|x| frames[3].pixel(x, 0) == Some([10, 20, 30])), "alpha is dropped");
    assert_eq!(frames[4].rgb, picture(4, 3, 5).into_raw());
    assert_eq!(frames[5].rgb, picture(4, 3, 6).into_raw());
}

#[test]
fn exif_orientation_is_applied_to_picture_and_size() {
    let folder = folder();
    let plain = folder.path().join("plain.jpg");
    let mut image = RgbImage::from_pixel(32, 16, Rgb([250, 250, 250]));
    (0..8).for_each(|i| (0..8).for_each(|j| image.put_pixel(i, j, Rgb([0, 0, 0]))));
    image.save(&plain).unwrap();
    // APP1 with one TIFF entry: orientation 6, to be turned a quarter to the right.
    let tiff = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let mut exif = vec![0xff, 0xe1, 0, (2 + 6 + tiff.len()) as u8];
    exif.extend(b"Exif\0\0");
    exif.extend(tiff);
    let mut bytes = fs::read(&plain).unwrap();
    bytes.splice(2..2, exif);
    fs::remove_file(&plain).unwrap();
    fs::write(folder.path().join("turned.jpg"), bytes).unwrap();
    let (frames, warnings) = read_all(folder.path());
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(frames[0].size, Size::new(16, 32));
    assert!(frames[0].pixel(14, 2).unwrap()[0] < 60, "the dark corner is now on the right");
    assert!(frames[0].pixel(2, 2).unwrap()[0] > 200);
}

#[test]
fn unreadable_images_are_skipped_with_their_numbers() {
    let folder = folder();
    let path =
        |index: u32, extension: &str| -> PathBuf { folder.path().join(format!("f{index}.{extension}")) };
    for index in [1, 2, 3, 5] {
        picture(32, 24, index).save(path(index, "png")).unwrap();
    }
    picture(32, 24, 4).save(path(4, "jpg")).unwrap();
    picture(32, 24, 6).save(path(6, "jpg")).unwrap();
    // No header, a header without pixels, and the first half of a JPEG.
    fs::write(path(2, "png"), "no image at all").unwrap();
    let bytes = fs::read(path(3, "png")).unwrap();
    fs::write(path(3, "png"), &bytes[..bytes.len() / 2]).unwrap();
    let bytes = fs::read(path(4, "jpg")).unwrap();
    fs::write(path(4, "jpg"), &bytes[..bytes.len() * 3 / 4]).unwrap();
    let (frames, warnings) = read_all(folder.path());
    assert_eq!(numbers(&frames), [1, 5, 6]);
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    for (warning, (number, file)) in warnings.iter().zip([(2, "f2.png"), (3, "f3.png"), (4, "f4.jpg")]) {
        assert!(
            warning.contains(&format!("frame {number} is skipped")) && warning.contains(file),
            "{warning}"
        );
    }
}

#[test]
fn images_of_different_sizes_are_refused_at_opening() {
    let folder = folder();
    for index in 1..=4 {
        picture(20, if index == 4 { 11 } else { 10 }, index)
            .save(folder.path().join(format!("{index}.png")))
            .unwrap();
    }
    let error = open_error(folder.path());
    for part in ["differ in size", "1.png is 20×10", "4.png is 20×11"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn folders_without_a_usable_image_are_refused() {
    let folder = folder();
    assert!(open_error(folder.path()).contains("the folder is empty"));
    fs::write(folder.path().join("notes.txt"), "text").unwrap();
    assert!(open_error(folder.path()).contains("holds no images"));
    fs::write(folder.path().join("a.png"), "text").unwrap();
    assert!(open_error(folder.path()).contains("none of its images can be read"));
}

#[test]
fn libraries_write_nothing_to_the_terminal() {
    // Run in a separate process: the test harness does not capture the output of C code.
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .arg("--nocapture")
        .args(
            ["a_truncated", "a_corrupt", "files_that", "missing_cameras"]
                .map(|test| format!("source::tests::{test}")),
        )
        .env_remove("RUST_BACKTRACE")
        .output()
        .unwrap();
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stdout).contains("4 passed"));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}
