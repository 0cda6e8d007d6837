//! Test inputs, and functions that run the program on them.

// Every test file is a separate crate and uses only some of these.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use image::{Rgb, RgbImage};
use tempfile::TempDir;

/// The files that `run` always writes.
pub const TABLES: [&str; 7] = [
    "episodes.csv",
    "events.jsonl",
    "regions.csv",
    "settings.toml",
    "summary.json",
    "tracks.csv",
    "tracks.json",
];

pub const WIDTH: u32 = 96;
pub const HEIGHT: u32 = 72;

/// A temporary folder of a test.
pub struct TestFolder(TempDir);

impl TestFolder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The names in a folder, in order, including hidden ones.
    pub fn names(&self, folder: &str) -> Vec<String> {
        names(&self.path(folder))
    }
}

pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Deterministic noise: 0..=255 from any numbers.
pub fn noise(x: u32, y: u32, t: u32) -> u8 {
    let mut bits = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ t.wrapping_mul(0xC2B2_AE3D);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2C1B_3C6D);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297A_2D39);
    ((bits ^ (bits >> 15)) >> 24) as u8
}

/// A textured wall with little noise; from frame 20 on a red block enters from the left.
pub fn scene(t: u32) -> RgbImage {
    RgbImage::from_fn(WIDTH, HEIGHT, |x, y| {
        let left = i64::from(t) * 2 - 50;
        if (left..left + 10).contains(&i64::from(x)) && (25..50).contains(&y) {
            return Rgb([200, 30, noise(x, y, t) / 32 + 20]);
        }
        let wall = 90 + noise(x / 6, y / 6, 0) / 8 + noise(x, y, t) / 64;
        Rgb([wall, wall, wall + 10])
    })
}

/// Writes the scene's frames 1..=`frames` to a folder, named and numbered from `first` on.
pub fn write_images(folder: &Path, frames: u32, first: u32) {
    fs::create_dir_all(folder).unwrap();
    for t in 1..=frames {
        scene(t).save(folder.join(format!("in{:06}.png", first + t - 1))).unwrap();
    }
}

/// The program, without a terminal.
pub fn occluscope(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_occluscope"));
    command.args(arguments);
    command
}

/// Runs the program, expects success, returns its stdout.
pub fn works(arguments: &[&str]) -> String {
    let output = occluscope(arguments).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs the program, expects this exit status and one line on stderr, returns the line.
pub fn fails(arguments: &[&str], status: i32) -> String {
    let output = occluscope(arguments).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{arguments:?}: {stderr}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    stderr
}

pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}
