//! The fuzz targets of `fuzz/` on their seeds and on mutations of these, always the same.
//!
//! With `OCCLUSCOPE_LONG` set, fifty times as many.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../fuzz/targets/mod.rs"]
mod targets;

use std::fs;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

/// Longest mutation, in bytes.
const LONGEST: usize = 4096;

#[test]
fn arguments() {
    holds_for_mutations("arguments", 100);
}

#[test]
fn images() {
    holds_for_mutations("images", 1000);
}

#[test]
fn names() {
    holds_for_mutations("names", 600);
}

#[test]
fn pipeline() {
    holds_for_mutations("pipeline", 150);
}

#[test]
fn results() {
    holds_for_mutations("results", 500);
}

#[test]
fn settings() {
    holds_for_mutations("settings", 1000);
}

#[test]
fn tables() {
    holds_for_mutations("tables", 2000);
}

#[test]
fn tracks() {
    holds_for_mutations("tracks", 3000);
}

#[test]
fn videos() {
    holds_for_mutations("videos", 200);
}

#[test]
fn every_target_has_a_program_and_seeds() {
    for (name, _) in targets::ALL {
        assert!(fuzz_folder().join("fuzz_targets").join(format!("{name}.rs")).is_file(), "{name}");
        assert!(!seeds(name).is_empty(), "{name}");
    }
    let seeds = fs::read_dir(fuzz_folder().join("seeds")).unwrap();
    assert_eq!(seeds.count(), targets::ALL.len(), "seeds of no target");
}

/// Runs a target on its seeds and on this many mutations of them.
fn holds_for_mutations(name: &str, mutations: usize) {
    let (_, target) = targets::ALL.into_iter().find(|(other, _)| *other == name).unwrap();
    let seeds = seeds(name);
    for (path, seed) in &seeds {
        holds(target, seed, &path.display().to_string());
    }
    let words = words();
    let mut random = Pcg32::seed_from_u64(19);
    let times = if std::env::var_os("OCCLUSCOPE_LONG").is_some() { 50 } else { 1 };
    for number in 0..times * mutations {
        let mut input = seeds[random.random_range(0..seeds.len())].1.clone();
        for _ in 0..random.random_range(1..6) {
            let other = &seeds[random.random_range(0..seeds.len())].1;
            mutate(&mut input, other, &words, &mut random);
        }
        holds(target, &input, &format!("mutation {number}"));
    }
}

/// Runs a target, and tells the input if it fails.
fn holds(target: fn(&[u8]), input: &[u8], what: &str) {
    if let Err(bug) = panic::catch_unwind(AssertUnwindSafe(|| target(input))) {
        eprintln!("{what} is b\"{}\"; keep it in fuzz/seeds", input.escape_ascii());
        panic::resume_unwind(bug);
    }
}

fn mutate(input: &mut Vec<u8>, other: &[u8], words: &[Vec<u8>], random: &mut Pcg32) {
    let at = random.random_range(0..=input.len());
    let end = (at + random.random_range(0..16)).min(input.len());
    match random.random_range(0..8) {
        0 => drop(input.drain(at..end)),
        1 => input.truncate(at),
        2 => {
            let part = input[at..end].to_vec();
            drop(input.splice(at..at, part));
        }
        3 => drop(input.splice(at..at, words[random.random_range(0..words.len())].iter().copied())),
        4 => drop(input.splice(at..end, words[random.random_range(0..words.len())].iter().copied())),
        5 => {
            let from = random.random_range(0..=other.len());
            drop(input.splice(at..end, other[from..].iter().copied()));
        }
        6 if at < input.len() => input[at] = random.random(),
        _ if at < input.len() => input[at] ^= 1 << random.random_range(0..8),
        _ => input.push(random.random()),
    }
    input.truncate(LONGEST);
}

fn fuzz_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz")
}

/// The seeds of a target, by name.
fn seeds(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let files = fs::read_dir(fuzz_folder().join("seeds").join(name)).unwrap();
    let mut paths: Vec<_> = files.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

/// The words of libFuzzer's dictionary.
fn words() -> Vec<Vec<u8>> {
    let text = fs::read_to_string(fuzz_folder().join("words.dict")).unwrap();
    text.lines().filter_map(|line| Some(unescaped(line.strip_prefix('"')?.strip_suffix('"')?))).collect()
}

/// The bytes of a word with `\xAB`, `\"` and `\\`.
fn unescaped(word: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = word;
    while !rest.is_empty() {
        if let Some(hexadecimal) = rest.strip_prefix("\\x") {
            bytes.push(u8::from_str_radix(&hexadecimal[..2], 16).unwrap());
            rest = &hexadecimal[2..];
        } else {
            rest = rest.strip_prefix('\\').unwrap_or(rest);
            let (first, others) = rest.split_at(rest.chars().next().map_or(0, char::len_utf8));
            bytes.extend_from_slice(first.as_bytes());
            rest = others;
        }
    }
    bytes
}
