//! Images that are broken, odd in size or of unusual kinds of values.

use std::fs::{self, File};
use std::io::{Cursor, Write as _};
use std::path::Path;

use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use occluscope::source::{self, Levels, Options};
use tiff::encoder::{TiffEncoder, TiffValue, colortype};

use crate::common::{TestFolder, noise, occluscope, scene, text, write_images};
use crate::encoded::make;
use crate::{Said, assert_refused, frames_of, has_time, read_all, run};

fn encoded(image: &RgbImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::from(image.clone()).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

const FORMATS: [(&str, ImageFormat); 7] = [
    ("png", ImageFormat::Png),
    ("jpg", ImageFormat::Jpeg),
    ("bmp", ImageFormat::Bmp),
    ("tif", ImageFormat::Tiff),
    ("webp", ImageFormat::WebP),
    ("gif", ImageFormat::Gif),
    ("ppm", ImageFormat::Pnm),
];

#[test]
fn broken_images_are_skipped_with_their_numbers() {
    for &(ending, format) in &FORMATS[..if has_time() { 7 } else { 4 }] {
        let place = TestFolder::new();
        let folder = place.path("images");
        fs::create_dir(&folder).unwrap();
        for t in 1..=12 {
            fs::write(folder.join(format!("in{t:04}.{ending}")), encoded(&scene(t), format)).unwrap();
        }
        let at = |t: u32| folder.join(format!("in{t:04}.{ending}"));
        let whole = fs::read(at(3)).unwrap();
        fs::write(at(2), "").unwrap();
        fs::write(at(4), &whole[..whole.len() / 2]).unwrap();
        fs::write(at(6), &whole[..12]).unwrap();
        fs::write(at(8), "no image").unwrap();
        fs::write(at(10), vec![0; whole.len()]).unwrap();
        let said = run(&place, &folder, &[]);
        let warnings = said.warnings();
        for t in [2, 4, 6, 8, 10] {
            let told = warnings.iter().filter(|line| line.contains(&format!("frame {t} is skipped"))).count();
            assert_eq!(told, 1, "{ending} {t}: {warnings:?}");
        }
        assert_eq!((warnings.len(), frames_of(&place)), (5, (7, 1, 12)), "{ending}: {warnings:?}");
    }
}

#[test]
fn zeros_within_a_jpeg_are_damage() {
    let place = TestFolder::new();
    let folder = place.path("images");
    fs::create_dir(&folder).unwrap();
    let picture =
        |t: u32| RgbImage::from_fn(160, 120, |x, y| Rgb([noise(x / 4, y / 4, t), (x + t) as u8, y as u8]));
    for t in 1..=5 {
        let mut bytes = encoded(&picture(t), ImageFormat::Jpeg);
        if t == 3 {
            let middle = bytes.len() / 2;
            bytes[middle..middle + 1000].fill(0);
        }
        fs::write(folder.join(format!("{t}.jpg")), bytes).unwrap();
    }
    let said = run(&place, &folder, &[]);
    let [warning] = said.warnings()[..] else { panic!("{:?}", said.lines) };
    assert!(warning.contains("frame 3 is skipped") && warning.contains("damaged"), "{warning}");
    assert_eq!(frames_of(&place), (4, 1, 5));
}

#[test]
fn jpegs_of_other_encoders_are_whole() {
    let place = TestFolder::new();
    for (at, options) in [
        "-pix_fmt yuvj420p",
        "-pix_fmt yuvj422p -q:v 2",
        "-pix_fmt yuvj444p -q:v 31",
        "-pix_fmt gray",
        "-pix_fmt yuvj420p -huffman optimal",
        "-pix_fmt yuvj420p -threads 4 -slices 4",
    ]
    .iter()
    .enumerate()
    {
        let folder = place.path(&format!("images{at}"));
        fs::create_dir(&folder).unwrap();
        let input = "-f lavfi -i testsrc2=size=170x90:rate=5:duration=1 -c:v mjpeg -strict -1";
        make(&folder.join("%d.jpg"), &format!("{input} {options}"));
        assert_eq!(read_all(&folder), Ok((5, Vec::new())), "{options}");
    }
}

#[test]
fn no_changed_byte_of_a_small_image_ends_the_program() {
    let place = TestFolder::new();
    let folder = place.path("images");
    fs::create_dir(&folder).unwrap();
    let small = RgbImage::from_fn(5, 4, |x, y| Rgb([(x * 40) as u8, (y * 50) as u8, 90]));
    fs::write(folder.join("1.png"), encoded(&small, ImageFormat::Png)).unwrap();
    let every = if has_time() { 1 } else { 3 };
    for (ending, format) in FORMATS {
        let whole = encoded(&small, format);
        let path = folder.join(format!("2.{ending}"));
        for at in (0..whole.len()).step_by(every) {
            for change in [0x01, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] ^= change;
                fs::write(&path, bytes).unwrap();
                let _ = read_all(&folder);
            }
            fs::write(&path, &whole[..at]).unwrap();
            let _ = read_all(&folder);
        }
        fs::remove_file(path).unwrap();
    }
}

#[test]
fn mixed_sizes_and_formats_are_refused() {
    let place = TestFolder::new();
    let folder = place.path("images");
    write_images(&folder, 5, 1);
    RgbImage::new(20, 30).save(folder.join("in000003.png")).unwrap();
    assert_refused(&place, &folder, &["differ in size", "96×72", "in000003.png", "20×30"]);
    fs::remove_file(folder.join("in000003.png")).unwrap();
    scene(2).save(folder.join("in000002.jpg")).unwrap();
    assert_refused(&place, &folder, &["copies of one image", "in000002.jpg"]);
}

#[test]
fn gaps_in_numbers_are_kept() {
    let place = TestFolder::new();
    let folder = place.path("images");
    write_images(&folder, 9, 100);
    for number in [103, 104, 107] {
        fs::remove_file(folder.join(format!("in000{number}.png"))).unwrap();
    }
    run(&place, &folder, &["--masks"]).warnings();
    assert_eq!(frames_of(&place), (6, 100, 108));
    let masks = crate::common::names(&place.path("out/masks"));
    assert_eq!(masks.len(), 6);
    assert!(masks.contains(&"bin000108.png".to_owned()) && !masks.contains(&"bin000104.png".to_owned()));
}

#[cfg(unix)]
#[test]
fn links_that_lead_nowhere_or_in_circles_are_skipped() {
    let place = TestFolder::new();
    let folder = place.path("images");
    write_images(&folder, 6, 1);
    for (number, to) in [(2, "gone.png"), (4, "in000004.png"), (5, ".")] {
        let link = folder.join(format!("in00000{number}.png"));
        fs::remove_file(&link).unwrap();
        std::os::unix::fs::symlink(to, link).unwrap();
    }
    let said = run(&place, &folder, &[]);
    let warnings = said.warnings();
    assert!(warnings.iter().any(|line| line.contains("frame 2 is skipped")), "{warnings:?}");
    assert!(warnings.iter().any(|line| line.contains("frame 4 is skipped")), "{warnings:?}");
    assert_eq!(frames_of(&place), (3, 1, 6));
}

#[test]
fn the_smallest_images_are_analysed() {
    let sizes = [(1, 1), (1, 50), (50, 1), (2, 2), (3, 1)];
    for &(width, height) in &sizes[..if has_time() { 5 } else { 2 }] {
        let place = TestFolder::new();
        let folder = place.path("images");
        fs::create_dir(&folder).unwrap();
        for t in 1..=8 {
            let level = |x, y| Rgb([noise(x, y, t / 5), 90, (t * 20) as u8]);
            RgbImage::from_fn(width, height, level).save(folder.join(format!("{t}.png"))).unwrap();
        }
        for flags in [
            &["--masks", "--annotated", "--frames", "--background", "--plain-frames", "--labels"][..],
            &["--background-model", "mog2"],
            &["--background-model", "knn"],
            &["--scale", "0.3"],
        ] {
            run(&place, &folder, flags).warnings();
            assert_eq!(frames_of(&place), (8, 1, 8), "{width}×{height} {flags:?}");
        }
        let said = Said::of(&["pixel", text(&folder), "--at", "0,0"]);
        assert_eq!(said.stdout.lines().count(), 9, "{width}×{height}");
    }
}

/// Writes a PGM file of black pixels, of which the file system need not store any.
fn write_black(path: &Path, width: u32, height: u32) {
    let mut file = File::create(path).unwrap();
    let header = format!("P5 {width} {height} 255\n");
    file.write_all(header.as_bytes()).unwrap();
    file.set_len(header.len() as u64 + u64::from(width) * u64::from(height)).unwrap();
}

#[test]
fn large_images_are_analysed_when_they_are_scaled() {
    let place = TestFolder::new();
    let folder = place.path("images");
    fs::create_dir(&folder).unwrap();
    for t in 1..=2 {
        write_black(&folder.join(format!("{t}.pgm")), 12_000, 9000);
    }
    assert!(run(&place, &folder, &["--scale", "0.01"]).warnings().is_empty());
    assert_eq!(frames_of(&place), (2, 1, 2));
}

/// The starts of files of each format that claim this size.
fn claims(side: u32) -> Vec<(&'static str, Vec<u8>)> {
    let small = RgbImage::from_fn(16, 16, |x, y| Rgb([x as u8, y as u8, 9]));
    let both = |bytes: [u8; 4]| [bytes, bytes].concat();
    let short = |bytes: [u8; 2]| [bytes, bytes].concat();
    let put = |format: ImageFormat, at: usize, size: Vec<u8>| {
        let mut bytes = encoded(&small, format);
        bytes[at..at + size.len()].copy_from_slice(&size);
        bytes
    };
    let mut png = put(ImageFormat::Png, 16, both(side.to_be_bytes()));
    let sum = crc32fast::hash(&png[12..29]);
    png[29..33].copy_from_slice(&sum.to_be_bytes());
    let jpeg = encoded(&small, ImageFormat::Jpeg);
    let frame = jpeg.windows(2).position(|window| window == [0xff, 0xc0]).unwrap();
    let mut all = vec![
        ("png", png),
        ("jpg", put(ImageFormat::Jpeg, frame + 5, short((side as u16).to_be_bytes()))),
        ("bmp", put(ImageFormat::Bmp, 18, both(side.to_le_bytes()))),
        ("gif", put(ImageFormat::Gif, 6, short((side as u16).to_le_bytes()))),
        ("pgm", format!("P5 {side} {side} 255\n0000").into_bytes()),
        ("ppm", format!("P6 {side} {side} 65535\n0000").into_bytes()),
        ("pbm", format!("P4 {side} {side}\n0000").into_bytes()),
    ];
    let mut tiff = encoded(&small, ImageFormat::Tiff);
    // The entries of width and height: tag, kind, count, value.
    for tag in [256_u16, 257] {
        let start = [tag.to_le_bytes(), 4_u16.to_le_bytes()].concat();
        let at = tiff.windows(4).position(|window| window == start).unwrap();
        tiff[at + 8..at + 12].copy_from_slice(&side.to_le_bytes());
    }
    all.push(("tif", tiff));
    all
}

#[cfg(unix)]
#[test]
fn a_size_that_an_image_only_claims_is_not_allocated() {
    let place = TestFolder::new();
    for (ending, content) in claims(60_000) {
        let folder = place.path(&format!("images-{ending}"));
        fs::create_dir(&folder).unwrap();
        for t in 1..=3 {
            fs::write(folder.join(format!("{t}.{ending}")), &content).unwrap();
        }
        // A tenth of the address space that one picture would need, beside that of the libraries.
        let program = occluscope(&[]).get_program().to_owned();
        let mut limited = assert_cmd::Command::new("sh");
        limited.args(["-c", "ulimit -v 6000000; exec \"$@\"", "sh"]).arg(program);
        let out = place.path("out");
        limited.args(["run", text(&folder), "--out", text(&out), "--threads", "2"]);
        let said = Said::by(&mut limited);
        let error = said.error();
        assert!(said.status == 1 && error.contains("images-"), "{ending}: {error}");
        // The decoder of TIFF finds that the data is of another size.
        let is_told = error.contains("60000×60000") && error.contains("million pixels");
        assert!(is_told || (ending == "tif" && error.contains("inconsistent sizes")), "{ending}: {error}");
    }
}

#[test]
fn unusual_kinds_of_values_are_read() {
    let place = TestFolder::new();
    for (at, (ending, options)) in [
        ("png", "-pix_fmt pal8"),
        ("png", "-pix_fmt rgba"),
        ("png", "-pix_fmt ya8"),
        ("png", "-pix_fmt ya16be"),
        ("png", "-pix_fmt rgba64be"),
        ("png", "-pix_fmt rgb48be"),
        ("png", "-pix_fmt gray16be"),
        ("png", "-pix_fmt monob"),
        ("bmp", "-pix_fmt pal8"),
        ("bmp", "-pix_fmt bgra"),
        ("bmp", "-pix_fmt rgb565le"),
        ("tif", "-pix_fmt rgba"),
        ("tif", "-pix_fmt rgb48le"),
        ("tif", "-pix_fmt gray16le"),
        ("pgm", "-pix_fmt gray16be"),
        ("pbm", "-pix_fmt monow"),
    ]
    .iter()
    .enumerate()
    {
        let folder = place.path(&format!("images{at}"));
        fs::create_dir(&folder).unwrap();
        let input = "-f lavfi -i testsrc2=size=64x48:rate=5:duration=1";
        make(&folder.join(format!("%d.{ending}")), &format!("{input} {options}"));
        assert_eq!(read_all(&folder), Ok((5, Vec::new())), "{ending} {options}");
    }
}

/// Writes a TIFF image of 4 × 2 pixels of a colour type.
fn write_tiff<C: colortype::ColorType>(path: &Path, values: &[C::Inner])
where
    [C::Inner]: TiffValue,
{
    let mut encoder = TiffEncoder::new(File::create(path).unwrap()).unwrap();
    encoder.write_image::<C>(4, 2, values).unwrap();
}

/// The red levels of the first frame of a folder, and the warnings.
fn levels(folder: &Path, levels: Option<&str>) -> (Vec<u8>, Vec<String>) {
    let levels: Option<Levels> = levels.map(|levels| levels.parse().unwrap());
    let mut source = source::open(text(folder), Options { levels, ..Options::default() }).unwrap();
    let frame = source.next_frame().unwrap().unwrap();
    let red = (0..8).map(|at| frame.pixel(at % 4, at / 4).unwrap()[0]).collect();
    (red, source.take_warnings())
}

#[test]
fn real_and_long_numbers_in_tiff_files_are_scaled() {
    let place = TestFolder::new();
    let folder = place.path("images");
    fs::create_dir(&folder).unwrap();
    let path = folder.join("1.tif");
    let ramp = [0.0_f32, 0.25, 0.5, 0.75, 1.0, f32::NAN, -1.0, 9.0];
    write_tiff::<colortype::Gray32Float>(&path, &ramp);
    let (red, warnings) = levels(&folder, None);
    assert_eq!(red, [0, 64, 128, 191, 255, 0, 0, 255]);
    assert!(warnings[0].contains("from -1 to 9") && warnings[0].contains("--levels -1..9"), "{warnings:?}");
    assert_eq!(levels(&folder, Some("-1..9")).0, [26, 32, 38, 45, 51, 0, 0, 255]);
    assert_eq!(levels(&folder, Some("auto")).0, [26, 32, 38, 45, 51, 0, 0, 255]);
    write_tiff::<colortype::RGB32Float>(&path, &ramp.iter().flat_map(|&v| [v, 0.5, 0.5]).collect::<Vec<_>>());
    assert_eq!(levels(&folder, None).0, [0, 64, 128, 191, 255, 0, 0, 255]);
    write_tiff::<colortype::Gray64Float>(&path, &ramp.map(f64::from));
    assert_eq!(levels(&folder, None).0, [0, 64, 128, 191, 255, 0, 0, 255]);
    let whole = [0_u32, 100, 200, 300, 400, 500, 600, 1000];
    let expected = [0, 26, 51, 77, 102, 128, 153, 255];
    write_tiff::<colortype::Gray32>(&path, &whole);
    assert_eq!(levels(&folder, Some("auto")).0, expected);
    write_tiff::<colortype::Gray64>(&path, &whole.map(u64::from));
    assert_eq!(levels(&folder, Some("0..1000")).0, expected);
    write_tiff::<colortype::GrayI16>(&path, &whole.map(|value| value as i16 - 500));
    assert_eq!(levels(&folder, Some("-500..500")).0, expected);
    write_tiff::<colortype::GrayI32>(&path, &whole.map(|value| value as i32 - 500));
    assert_eq!(levels(&folder, Some("-500..500")).0, expected);
    write_tiff::<colortype::CMYK8>(&path, &[0, 255, 255, 0].repeat(8));
    assert_eq!(levels(&folder, None).0, [255; 8]);
    // Through the program.
    write_tiff::<colortype::Gray32Float>(&path, &ramp);
    run(&place, &folder, &["--levels", "auto"]).warnings();
    assert_eq!(frames_of(&place), (1, 1, 1));
}

#[test]
fn tiff_files_that_are_not_read_say_what_they_are() {
    let place = TestFolder::new();
    let folder = place.path("images");
    fs::create_dir(&folder).unwrap();
    make(
        &folder.join("1.tif"),
        "-f lavfi -i testsrc2=size=64x48:rate=5:duration=0.2 -pix_fmt pal8 -frames:v 1",
    );
    assert_refused(&place, &folder, &["1.tif", "convert them to PNG"]);
}
