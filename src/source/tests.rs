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
    let is_told =
        warnings.iter().any(|warning| warning.contains("damaged") || warning.contains("are missing"));
    assert!(is_told && warnings.len() <= 2, "{} frames, {warnings:?}", frames.len());
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
fn options_of_videos_are_refused_for_other_sources() {
    let folder = folder();
    picture(8, 8, 1).save(folder.path().join("in1.png")).unwrap();
    let deinterlace = Options { deinterlace: true, ..Options::default() };
    let stream = Options { stream: Some(0), ..Options::default() };
    for source in [name(folder.path()), name(folder.path().join("in%d.png")), "camera:0".to_owned()] {
        for (options, flag) in [(deinterlace, "--deinterlace"), (stream, "--stream")] {
            let error = open(&source, options).map(drop).unwrap_err().to_string();
            assert!(error.contains(&format!("{flag} is for video files")), "{error}");
            assert!(error.starts_with(&source) && error.ends_with("leave it out"), "{error}");
        }
    }
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

/// Adds an APP1 segment with one TIFF entry, the orientation.
fn set_orientation(jpeg: &mut Vec<u8>, orientation: u8) {
    let mut tiff = *b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    tiff[18] = orientation;
    let mut exif = vec![0xff, 0xe1, 0, (2 + 6 + tiff.len()) as u8];
    exif.extend(b"Exif\0\0");
    exif.extend(tiff);
    jpeg.splice(2..2, exif);
}

#[test]
fn exif_orientation_is_applied_to_picture_and_size() {
    let mut image = RgbImage::from_pixel(32, 16, Rgb([250, 250, 250]));
    (0..8).for_each(|i| (0..8).for_each(|j| image.put_pixel(i, j, Rgb([0, 0, 0]))));
    // Where the upper left corner comes to lie: in the last or first column, the last or first row.
    let corners = [
        (1, [0, 0]),
        (2, [1, 0]),
        (3, [1, 1]),
        (4, [0, 1]),
        (5, [0, 0]),
        (6, [1, 0]),
        (7, [1, 1]),
        (8, [0, 1]),
    ];
    for (orientation, [right, low]) in corners {
        let folder = folder();
        let path = folder.path().join("turned.jpg");
        image.save(&path).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        set_orientation(&mut bytes, orientation);
        fs::write(&path, bytes).unwrap();
        let (frames, warnings) = read_all(folder.path());
        assert_eq!(warnings, Vec::<String>::new());
        let size = if orientation < 5 { Size::new(32, 16) } else { Size::new(16, 32) };
        assert_eq!(frames[0].size, size, "{orientation}");
        let level = |right: u32, low: u32| {
            frames[0].pixel(2 + right * (size.width - 5), 2 + low * (size.height - 5)).unwrap()[0]
        };
        for (x, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let is_dark = [x, y] == [right, low];
            assert_eq!(level(x, y) < 100, is_dark, "{orientation}: {x} {y}: {}", level(x, y));
        }
    }
}

#[test]
fn unreadable_images_are_skipped_with_their_numbers() {
    let folder = folder();
    let path =
        |index: u32, extension: &str| -> PathBuf { folder.path().join(format!("f{index}.{extension}")) };
    for index in [1, 2, 3, 5, 7, 8] {
        picture(32, 24, index).save(path(index, "png")).unwrap();
    }
    fs::write(path(7, "png"), "").unwrap();
    picture(32, 24, 4).save(path(4, "jpg")).unwrap();
    picture(32, 24, 6).save(path(6, "jpg")).unwrap();
    // No header, a header without pixels, and the first half of a JPEG.
    fs::write(path(2, "png"), "no image at all").unwrap();
    let bytes = fs::read(path(3, "png")).unwrap();
    fs::write(path(3, "png"), &bytes[..bytes.len() / 2]).unwrap();
    let bytes = fs::read(path(4, "jpg")).unwrap();
    fs::write(path(4, "jpg"), &bytes[..bytes.len() * 3 / 4]).unwrap();
    let (frames, warnings) = read_all(folder.path());
    assert_eq!(numbers(&frames), [1, 5, 6, 8]);
    assert_eq!(warnings.len(), 4, "{warnings:?}");
    assert!(warnings[3].contains("the file is empty"), "{}", warnings[3]);
    let skipped = [(2, "f2.png"), (3, "f3.png"), (4, "f4.jpg"), (7, "f7.png")];
    for (warning, (number, file)) in warnings.iter().zip(skipped) {
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
fn images_in_both_orientations_are_refused_at_opening() {
    let folder = folder();
    for (file, orientation) in [("a1.jpg", 1), ("a2.jpg", 3), ("a3.jpg", 6)] {
        let path = folder.path().join(file);
        picture(32, 16, 1).save(&path).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        set_orientation(&mut bytes, orientation);
        fs::write(&path, bytes).unwrap();
    }
    let error = open_error(folder.path());
    for part in ["both orientations", "a1.jpg is landscape (32×16)", "a3.jpg is portrait (16×32)"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn images_that_are_no_frames_are_left_out_and_reported() {
    let folder = folder();
    let path = |file: &str| folder.path().join(file);
    for index in 480..485 {
        picture(8, 6, index).save(path(&format!("in{index:06}.png"))).unwrap();
    }
    picture(8, 6, 0).save(path("in000480 (1).png")).unwrap();
    picture(20, 20, 0).save(path("roi.png")).unwrap();
    let (frames, warnings) = read_all(folder.path());
    assert_eq!(numbers(&frames), [480, 481, 482, 483, 484]);
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(
        warning.contains("2 of 7 images are left out") && warning.contains("in000480 (1).png"),
        "{warning}"
    );

    picture(8, 6, 481).save(path("in000481.jpg")).unwrap();
    let error = open_error(folder.path());
    assert!(
        error.contains("in000481.jpg and in000481.png are copies") && error.contains("in%06d."),
        "{error}"
    );
    assert_eq!(numbers(&read_all(path("in%06d.png")).0), [480, 481, 482, 483, 484]);
}

#[cfg(unix)]
#[test]
fn links_that_lead_nowhere_are_skipped_with_their_numbers() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    let path = |file: &str| folder.path().join(file);
    picture(8, 6, 1).save(path("kept.bin.png")).unwrap();
    fs::rename(path("kept.bin.png"), path("kept.bin")).unwrap();
    for index in [1, 3] {
        symlink(path("kept.bin"), path(&format!("{index}.png"))).unwrap();
    }
    symlink(path("gone.bin"), path("2.png")).unwrap();
    for video in [name(folder.path()), name(path("%d.png"))] {
        let (frames, warnings) = read_all(video);
        assert_eq!(numbers(&frames), [1, 3]);
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        assert!(
            warning.starts_with("frame 2 is skipped") && warning.contains("a link to a file"),
            "{warning}"
        );
    }
}

#[test]
fn jpegs_with_data_behind_their_end_are_whole() {
    let folder = folder();
    for index in 1..=3 {
        let path = folder.path().join(format!("{index}.jpg"));
        picture(32, 24, index).save(&path).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        bytes.resize(bytes.len() * index as usize * 2, 0);
        fs::write(&path, bytes).unwrap();
    }
    let (frames, warnings) = read_all(folder.path());
    assert_eq!((numbers(&frames), warnings), (vec![1, 2, 3], Vec::new()));
}

/// How the numbers of a TIFF file are written: the last byte first, and places with eight bytes.
#[derive(Clone, Copy, Debug)]
struct TiffForm {
    is_big_endian: bool,
    is_long: bool,
}

impl TiffForm {
    fn put(self, file: &mut Vec<u8>, length: usize, number: u64) {
        let mut bytes = number.to_be_bytes()[8 - length..].to_vec();
        if !self.is_big_endian {
            bytes.reverse();
        }
        file.extend(bytes);
    }

    /// A file of gray pages of 16 bits; a page is its width, its values and its kind (tag 254).
    fn write(self, path: &Path, pages: &[(usize, Vec<u16>, u64)]) {
        let place = if self.is_long { 8 } else { 4 };
        let mut file = if self.is_big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        self.put(&mut file, 2, if self.is_long { 43 } else { 42 });
        if self.is_long {
            self.put(&mut file, 2, 8);
            self.put(&mut file, 2, 0);
        }
        // The place where that of the next directory is to be written.
        let mut next = file.len();
        self.put(&mut file, place, 0);
        for (width, values, kind) in pages {
            let at = file.len() as u64;
            for &value in values {
                self.put(&mut file, 2, value.into());
            }
            let mut directory = Vec::new();
            self.put(&mut directory, place, file.len() as u64);
            file.splice(next..next + place, directory);
            let (width, height) = (*width as u64, (values.len() / width) as u64);
            // Kind, width, height, bits, no compression, black is 0, place, samples, rows, bytes.
            let entries = [
                (254, 4, *kind),
                (256, 4, width),
                (257, 4, height),
                (258, 3, 16),
                (259, 3, 1),
                (262, 3, 1),
                (273, 4, at),
                (277, 3, 1),
                (278, 4, height),
                (279, 4, 2 * width * height),
            ];
            self.put(&mut file, if self.is_long { 8 } else { 2 }, entries.len() as u64);
            for (tag, of, value) in entries {
                self.put(&mut file, 2, tag);
                self.put(&mut file, 2, of);
                self.put(&mut file, place, 1);
                let length = if of == 3 { 2 } else { 4 };
                self.put(&mut file, length, value);
                file.resize(file.len() + place - length, 0);
            }
            next = file.len();
            self.put(&mut file, place, 0);
        }
        fs::write(path, file).unwrap();
    }
}

const LITTLE: TiffForm = TiffForm { is_big_endian: false, is_long: false };

/// Pages of 6×4 pixels with different values.
fn gray_pages(count: u16) -> Vec<(usize, Vec<u16>, u64)> {
    (0..count).map(|page| (6, (0..24).map(|at| 257 * (page * 3 + at)).collect(), 0)).collect()
}

#[test]
fn the_pages_of_a_tiff_file_are_frames() {
    let folder = folder();
    let path = folder.path().join("stack.tif");
    for (is_big_endian, is_long) in [(false, false), (true, false), (false, true), (true, true)] {
        let form = TiffForm { is_big_endian, is_long };
        let mut pages = gray_pages(9);
        // A smaller copy of the first page, and a mask of it.
        pages.insert(1, (3, vec![7; 6], 1));
        pages.insert(2, (6, vec![9; 24], 4));
        form.write(&path, &pages);
        let mut source = open(&name(&path), Options::default()).unwrap();
        let info = source.info().clone();
        assert_eq!((info.size, info.frames, info.live), (Size::new(6, 4), Some(9), false), "{form:?}");
        assert_eq!((info.fps, info.fps_from), (25.0, FpsFrom::Assumed));
        let (frames, warnings) = read_all(&path);
        assert_eq!(numbers(&frames), (1..=9).collect::<Vec<_>>());
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        assert!(warning.contains("page 1 of") && warning.contains("--levels 0..16383"), "{warning}");
        for (page, frame) in (0..).zip(&frames) {
            let levels: Vec<u8> = (0..24).flat_map(|at| [page * 3 + at; 3]).collect();
            assert_eq!(frame.rgb, levels, "{form:?}, page {page}");
        }
        while source.next_frame().unwrap().is_some() {}
        assert_same_again(source.as_ref(), &frames);
    }
    fs::rename(&path, folder.path().join("stack of another ending")).unwrap();
    assert_eq!(read_all(folder.path().join("stack of another ending")).0.len(), 9);
}

/// Asserts that a source that was read to its end gives the same frames in another order.
fn assert_same_again(source: &dyn Source, frames: &[Frame]) {
    let mut again = source.random_access().unwrap();
    let fingerprints: Vec<_> = frames.iter().map(random_access::fingerprint).collect();
    for position in (0..frames.len()).rev() {
        let goal = position as u32;
        let step = again.step(goal, goal, &fingerprints).unwrap();
        let random_access::Step::Frame(at, frame) = step else { panic!("no frame") };
        assert_eq!((at, &frame.rgb), (goal, &frames[position].rgb));
    }
}

#[test]
fn a_damaged_tiff_file_is_read_as_far_as_it_goes() {
    let folder = folder();
    let path = folder.path().join("stack.tif");
    LITTLE.write(&path, &gray_pages(9));
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let (frames, warnings) = read_all(&path);
    assert_eq!(numbers(&frames), [1, 2, 3, 4]);
    assert!(
        warnings.iter().any(|warning| warning.contains("truncated; it is read to page 4")),
        "{warnings:?}"
    );
    // The last directory leads back to the first.
    let mut looped = bytes.clone();
    let end = looped.len() - 4;
    let first: [u8; 4] = bytes[4..8].try_into().unwrap();
    looped[end..].copy_from_slice(&first);
    fs::write(&path, looped).unwrap();
    assert_eq!(read_all(&path).0.len(), 9);

    let mut pages = gray_pages(3);
    pages[2].0 = 4;
    LITTLE.write(&path, &pages);
    let error = open_error(&path);
    for part in ["both orientations", "page 1 is landscape (6×4)", "page 3 is portrait (4×6)"] {
        assert!(error.contains(part), "{error}");
    }
    LITTLE.write(&path, &gray_pages(1));
    assert!(open_error(&path).contains("single image"));
    LITTLE.write(&path, &[]);
    assert!(open_error(&path).contains("single image"));
}

#[test]
fn files_of_several_pictures_in_a_folder_are_reported() {
    let pages = |path: &Path| LITTLE.write(path, &gray_pages(2));
    let animation = |path: &Path| {
        let mut encoder = image::codecs::gif::GifEncoder::new(fs::File::create(path).unwrap());
        for index in 0..2 {
            let picture = DynamicImage::from(picture(6, 4, index)).into_rgba8();
            encoder.encode_frame(image::Frame::new(picture)).unwrap();
        }
    };
    let single = |path: &Path| picture(6, 4, 1).save(path).unwrap();
    for (ending, make, expected) in [
        ("tif", &pages as &dyn Fn(&Path), Some("has several pages")),
        ("gif", &animation, Some("is animated")),
        ("png", &single, None),
        ("webp", &single, None),
    ] {
        let folder = folder();
        for index in 1..=3 {
            make(&folder.path().join(format!("{index}.{ending}")));
        }
        let options = Options { levels: "0..65535".parse().ok(), ..Options::default() };
        let mut source = open(&name(folder.path()), options).unwrap();
        let frames: Vec<_> = std::iter::from_fn(|| source.next_frame().unwrap()).collect();
        let warnings = source.take_warnings();
        assert_eq!((frames.len(), warnings.len()), (3, usize::from(expected.is_some())), "{warnings:?}");
        if let Some(expected) = expected {
            assert!(
                warnings[0].contains(expected) && warnings[0].contains(&format!("1.{ending}")),
                "{warnings:?}"
            );
        }
    }
}

#[test]
fn levels_are_those_given_or_measured_over_the_sequence() {
    let folder = folder();
    for index in 1..=40_u16 {
        let image: ImageBuffer<Luma<u16>, Vec<u16>> =
            ImageBuffer::from_fn(4, 3, |x, _| Luma([[100, 1000, 3000, 80 + index * 100][x as usize]]));
        image.save(folder.path().join(format!("{index}.png"))).unwrap();
    }
    let read = |levels: &str| {
        let options = Options { levels: Some(levels.parse().unwrap()), ..Options::default() };
        let mut source = open(&name(folder.path()), options).unwrap();
        let frames: Vec<_> = std::iter::from_fn(|| source.next_frame().unwrap()).collect();
        assert_eq!(source.take_warnings(), Vec::<String>::new());
        assert_same_again(source.as_ref(), &frames);
        frames
    };
    let row = |frame: &Frame| -> Vec<u8> { (0..4).map(|x| frame.pixel(x, 2).unwrap()[1]).collect() };
    let scaled =
        |value: u32, low: u32, high: u32| ((value - low) as f64 * 255.0 / (high - low) as f64).round() as u8;
    let frames = read("0..4095");
    assert_eq!(row(&frames[0]), [100, 1000, 3000, 180].map(|value| scaled(value, 0, 4095)));
    let frames = read("auto");
    // From the first image to the last: 100 to 4080.
    assert_eq!(row(&frames[39]), [100, 1000, 3000, 4080].map(|value| scaled(value, 100, 4080)));
    assert_eq!(row(&frames[0])[3], scaled(180, 100, 4080), "the same for all frames");
    let (frames, warnings) = read_all(folder.path());
    assert_eq!(row(&frames[0]), [0, 4, 12, 1]);
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("--levels 0..4095") && warning.contains("1.png"), "{warning}");
}

#[test]
fn levels_that_cannot_be_used_are_refused() {
    let folder = folder();
    let with = |path: &Path, levels: &str| {
        let options = Options { levels: levels.parse().ok(), ..Options::default() };
        open(&name(path), options).map(|_| ()).unwrap_err().to_string()
    };
    write_video(&folder.path().join("a.avi"), *b"MJPG", 25.0, (64, 48), 3);
    let error = with(&folder.path().join("a.avi"), "0..100");
    assert!(error.contains("--levels is for images"), "{error}");
    let images = folder.path().join("images");
    fs::create_dir(&images).unwrap();
    RgbImage::from_pixel(4, 4, Rgb([9; 3])).save(images.join("1.png")).unwrap();
    let error = with(&images, "auto");
    assert!(error.contains("all its values are 9"), "{error}");
    let options = Options { levels: "9..9".parse().ok(), ..Options::default() };
    assert!(options.levels.is_some() && !options.is_valid());
}

#[test]
fn the_folder_of_a_sequence_means_its_images() {
    let folder = folder();
    let images = folder.path().join("input");
    fs::create_dir(&images).unwrap();
    for index in 1..=3 {
        picture(8, 6, index).save(images.join(format!("in{index:06}.png"))).unwrap();
    }
    picture(8, 6, 9).save(folder.path().join("ROI.bmp")).unwrap();
    let (frames, warnings) = read_all(folder.path());
    assert_eq!((numbers(&frames), warnings), (vec![1, 2, 3], Vec::new()));
    let info = open(&name(folder.path()), Options::default()).unwrap().info().clone();
    assert_eq!((info.name, info.fps_from), (name(folder.path()), FpsFrom::Assumed));
    assert_eq!(frames, read_all(&images).0);
    // An image of its own makes it a folder of images.
    fs::remove_file(folder.path().join("ROI.bmp")).unwrap();
    picture(9, 9, 7).save(folder.path().join("7.png")).unwrap();
    assert!(read_all(folder.path()).0.iter().all(|frame| frame.size == Size::new(9, 9)));
}

#[cfg(unix)]
#[test]
fn the_rate_of_a_sequence_is_that_of_its_folder_even_where_its_images_are_a_link() {
    let (folder, elsewhere) = (folder(), folder());
    picture(8, 6, 1).save(elsewhere.path().join("000001.png")).unwrap();
    std::os::unix::fs::symlink(elsewhere.path(), folder.path().join("frames")).unwrap();
    fs::write(folder.path().join("seqinfo.ini"), "[Sequence]\nimDir=frames\nframeRate=14\n").unwrap();
    let info = open(&name(folder.path()), Options::default()).unwrap().info().clone();
    assert_eq!((info.fps, info.fps_from, info.frames), (14.0, FpsFrom::SeqInfo, Some(1)));
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
