//! Settings files and regions of interest that are damaged, of another version, or none.

use std::fs;
use std::path::Path;

use occluscope::settings::Settings;

use crate::common::{TestFolder, text, write_images};
use crate::{Said, has_time};

fn apply(text: &str) -> Result<Settings, String> {
    let mut settings = Settings::default();
    settings.apply_toml(text, Path::new("my.toml")).map_err(|error| error.to_string())?;
    Ok(settings)
}

#[test]
fn damaged_settings_are_refused_with_the_file_and_the_key() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 2, 1);
    let file = place.path("my.toml");
    for (content, part) in [
        (&b"k = \"three\""[..], "`k`"),
        (b"k = 3.5", "`k`"),
        (b"k = -1", "`k`"),
        (b"k = 99999999999999999999", ""),
        (b"k = true", "`k`"),
        (b"k = [3]", "`k`"),
        (b"[k]\nvalue = 3", "`k`"),
        (b"k = 1979-05-27", "`k`"),
        (b"alpha = nan", "`alpha`"),
        (b"alpha = inf", "`alpha`"),
        (b"alpha = -inf", "`alpha`"),
        (b"alpha = 1e400", ""),
        (b"max_hidden = \"NaNs\"", "`max_hidden`"),
        (b"max_hidden = \"-3s\"", "`max_hidden`"),
        (b"max_hidden = \"1e30s\"", "`max_hidden`"),
        (b"max_hidden = nan", "`max_hidden`"),
        (b"rate = 3", "`rate`"),
        (b"of_a_newer_version = 1", "`of_a_newer_version`"),
        (b"version = 7\nk = 3", "`version`"),
        (b"k = 3\nk = 4", ""),
        (b"k 3", ""),
        (b"{\"k\": 3}", ""),
        (b"k = 3\0", ""),
        (b"\xff\xfek\0=\0", ""),
        (b"k = \"\xe9\"", ""),
        (b"\x89PNG\r\n\x1a\n\0\0", ""),
    ] {
        if let Ok(text) = str::from_utf8(content) {
            let error = apply(text).unwrap_err();
            assert!(error.contains("my.toml") && error.contains(part), "{text}: {error}");
            assert!(!error.contains('\n'), "{error}");
            if !has_time() && part != "`k`" {
                continue;
            }
        }
        fs::write(&file, content).unwrap();
        let out = place.path("out");
        let said = Said::of(&["run", text(&images), "--out", text(&out), "--settings", text(&file)]);
        let error = said.error();
        assert!(error.contains("my.toml") && error.contains(part), "{}: {error}", content.escape_ascii());
        assert!(!out.exists());
    }
    for content in ["", "\n\n", "# only a comment", "\u{feff}k = 3", "k = 3\r\nalpha = 0.5\r\n"] {
        fs::write(&file, content).unwrap();
        assert_eq!(Said::of(&["settings", "--settings", text(&file)]).status, 0, "{content:?}");
    }
    for (path, part) in [(place.path("."), ""), (place.path("gone.toml"), "gone.toml")] {
        let said = Said::of(&["settings", "--settings", text(&path)]);
        assert!(said.error().contains("cannot be read") && said.error().contains(part), "{:?}", said.lines);
    }
}

#[test]
fn no_change_or_cut_of_a_settings_file_is_a_panic() {
    let whole = Settings::default().to_toml();
    let plain: String =
        whole.lines().filter(|line| !line.starts_with('#')).flat_map(|line| [line, "\n"]).collect();
    assert_eq!(apply(&plain), Ok(Settings::default()));
    for at in (0..plain.len()).step_by(if has_time() { 1 } else { 11 }) {
        let _ = apply(&plain[..at]);
        for change in 0..8 {
            let mut bytes = plain.clone().into_bytes();
            bytes[at] ^= 1 << change;
            if let Err(error) = apply(&String::from_utf8_lossy(&bytes)) {
                assert!(error.contains("my.toml") && !error.contains('\n'), "{error}");
            }
        }
    }
    let deep = format!("k = {}3{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(apply(&deep).is_err());
}

#[test]
fn regions_of_interest_that_are_no_mask_are_refused() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 2, 1);
    let mask = |name: &str, width: u32, height: u32, level: u8| {
        let path = place.path(name);
        image::GrayImage::from_pixel(width, height, image::Luma([level])).save(&path).unwrap();
        path
    };
    let text_file = place.path("text.png");
    fs::write(&text_file, "no image").unwrap();
    let cut = mask("cut.png", 96, 72, 255);
    let bytes = fs::read(&cut).unwrap();
    fs::write(&cut, &bytes[..bytes.len() - 20]).unwrap();
    for (path, part) in [
        (mask("small.png", 20, 20, 255), "20×20"),
        (mask("dark.png", 96, 72, 100), "dark"),
        (text_file, "cannot be read"),
        (cut, "cannot be read"),
        (place.path("gone.png"), "cannot be read"),
        (images.clone(), "cannot be read"),
    ] {
        let out = place.path("out");
        let said = Said::of(&["run", text(&images), "--out", text(&out), "--roi", text(&path)]);
        let error = said.error();
        assert!(error.contains(text(&path)) && error.contains(part), "{error}");
        assert!(!out.exists());
    }
}
