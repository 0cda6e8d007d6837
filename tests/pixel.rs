//! The CSV of `pixel` against the library, and against a second implementation of the pixel process.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;

use common::{TestFolder, noise, text, works};
use occluscope::mixture::{Parameters, Pixel};
use occluscope::settings::{Preset, Settings};

const FRAMES: u32 = 80;
const SIDE: u32 = 12;

/// A pixel that flickers between two surfaces and is occasionally occluded.
fn colour(x: u32, y: u32, t: u32) -> [u8; 3] {
    let shake = |channel: u32| noise(x + 1000 * channel, y, t) / 24;
    let base = match noise(x, y, 7 * t + 1) {
        0..=120 => [70, 80, 90],
        121..=220 => [150, 140, 100],
        _ => [noise(x, t, 1), noise(x, t, 2), noise(y, t, 3)],
    };
    [0, 1, 2].map(|channel| base[channel as usize].saturating_add(shake(channel)))
}

fn write_images(folder: &Path) {
    fs::create_dir(folder).unwrap();
    for t in 1..=FRAMES {
        let picture = image::RgbImage::from_fn(SIDE, SIDE, |x, y| image::Rgb(colour(x, y, t)));
        picture.save(folder.join(format!("{t:04}.png"))).unwrap();
    }
}

fn table(csv: &str) -> Vec<Vec<f32>> {
    csv.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

/// One Gaussian of the second implementation.
#[derive(Clone, Default)]
struct Gaussian {
    w: f32,
    mu: Vec<f32>,
    var: f32,
}

/// The pixel process, implemented from the text of the method only.
struct Reference<'a> {
    settings: &'a Settings,
    mixture: Vec<Gaussian>,
    t: u32,
    /// The number of consecutive foreground frames, the share of frames with a change, and the last verdict under T.
    run: u32,
    unrest: f32,
    strict: bool,
    learnt: u32,
    /// Learned frames in which the pixel changed between component 1 and others.
    changes: Vec<u32>,
    away: bool,
}

impl<'a> Reference<'a> {
    fn new(settings: &'a Settings) -> Self {
        Self {
            settings,
            mixture: Vec::new(),
            t: 0,
            run: 0,
            unrest: 0.0,
            strict: false,
            learnt: 0,
            changes: Vec::new(),
            away: false,
        }
    }

    fn value(&self, rgb: [u8; 3]) -> Vec<f32> {
        if self.settings.space.word() == "rgb" {
            return rgb.iter().map(|&channel| f32::from(channel)).collect();
        }
        let luma = 0.299 * f64::from(rgb[0]) + 0.587 * f64::from(rgb[1]) + 0.114 * f64::from(rgb[2]);
        vec![luma.round() as f32]
    }

    fn density(x: &[f32], gaussian: &Gaussian) -> f64 {
        let n = x.len() as f64;
        let var = f64::from(gaussian.var);
        (-0.5 * f64::from(distance(x, &gaussian.mu)) / var).exp()
            / (std::f64::consts::TAU * var).powf(n / 2.0)
    }

    /// Learns from the first frames. Classification starts with the dominant component; for a pixel that never stayed
    /// with any for long, with all components that are background to a restless pixel.
    fn learn(&mut self, colours: impl IntoIterator<Item = [u8; 3]>) {
        for rgb in colours {
            self.learnt = self.t + 1;
            self.step(rgb);
        }
        if self.learnt > 0 {
            let ends = self.changes.iter().copied().chain([self.learnt]);
            let stays = [0].into_iter().chain(self.changes.iter().copied()).zip(ends);
            let longest = stays.map(|(from, to)| to - from).max().unwrap_or(0);
            let s = self.settings;
            let on = s.hold != 1.0 || s.restless_learning != 1.0 || s.restless_t > 0.0;
            let recurs = on && longest as f32 <= 0.1 * self.learnt as f32;
            let kept = if recurs { self.background(s.t.max(s.restless_t)).max(1) } else { 1 };
            let empty = Gaussian { w: 0.0, mu: vec![0.0; self.mixture[0].mu.len()], var: 0.0 };
            self.mixture[kept..].fill(empty);
            if kept == 1 {
                self.mixture[0].w = 1.0;
            }
            let sum = self.mixture.iter().fold(0.0, |sum, g| sum + g.w);
            self.mixture.iter_mut().for_each(|g| g.w /= sum);
            (self.run, self.strict) = (0, false);
            self.unrest = if kept > 1 { s.unrest_full } else { 0.0 };
        }
    }

    /// Processes one frame; returns the table's row from `matched` on.
    fn step(&mut self, rgb: [u8; 3]) -> Vec<f32> {
        let s = self.settings;
        let x = self.value(rgb);
        self.t += 1;
        let k = s.k as usize;
        let first_variance = s.initial_sigma * s.initial_sigma;
        if self.t == 1 {
            self.mixture = vec![Gaussian { w: 0.0, mu: vec![0.0; x.len()], var: 0.0 }; k];
            self.mixture[0] = Gaussian { w: 1.0, mu: x, var: first_variance };
            return self.row(0, 1, 1, false, 0.0, 0.0);
        }
        let pace = match self.run {
            0 => 1.0,
            run if run <= s.hold_after => {
                1.0 + (s.restless_learning - 1.0) * f32::min(self.unrest / s.unrest_full, 1.0)
            }
            _ => s.hold,
        };
        let alpha = if self.t <= s.warm_up.max(self.learnt) {
            s.alpha.max(1.0 / self.t as f32)
        } else {
            (s.alpha * pace).min(1.0)
        };
        let p: f64 =
            self.mixture.iter().filter(|g| g.w > 0.0).map(|g| f64::from(g.w) * Self::density(&x, g)).sum();

        let limit = s.match_sigmas * s.match_sigmas;
        let matched = self.mixture.iter().position(|g| g.w > 0.0 && distance(&x, &g.mu) <= limit * g.var);
        let away = matched != Some(0);
        if self.t <= self.learnt && away != self.away {
            self.changes.push(self.t);
            self.away = away;
        }
        for (index, g) in self.mixture.iter_mut().enumerate() {
            let m = if matched == Some(index) { 1.0 } else { 0.0 };
            g.w = (1.0 - alpha) * g.w + alpha * m;
        }
        let mut rho = 0.0;
        let mut place = k - 1;
        if let Some(index) = matched {
            let g = &mut self.mixture[index];
            rho = match s.rate.word() {
                "density" => (f64::from(alpha) * Self::density(&x, g)) as f32,
                "weight" => alpha / g.w,
                _ => alpha,
            };
            rho = rho.min(1.0);
            g.mu = g.mu.iter().zip(&x).map(|(mu, x)| (1.0 - rho) * mu + rho * x).collect();
            g.var = ((1.0 - rho) * g.var + rho * distance(&x, &g.mu)).max(s.min_sigma * s.min_sigma);
            place = index;
        } else {
            self.mixture[place] = Gaussian { w: s.initial_weight, mu: x, var: first_variance };
            let sum = self.mixture.iter().fold(0.0, |sum, g| sum + g.w);
            self.mixture.iter_mut().for_each(|g| g.w /= sum);
        }
        let fitness = |g: &Gaussian| if g.w > 0.0 { g.w / g.var.sqrt() } else { 0.0 };
        while place > 0 && fitness(&self.mixture[place]) > fitness(&self.mixture[place - 1]) {
            self.mixture.swap(place, place - 1);
            place -= 1;
        }
        let is_foreground = |background: usize| matched.is_none() || place + 1 > background;
        let strict = is_foreground(self.background(s.t));
        let memory = s.unrest_memory as f32;
        self.unrest *= 1.0 - 1.0 / memory;
        if strict != self.strict {
            self.unrest += 1.0 / memory;
        }
        self.strict = strict;
        let restless = f32::min(self.unrest / s.unrest_full, 1.0);
        let background = self.background(s.t + (s.restless_t.max(s.t) - s.t) * restless);
        let foreground = is_foreground(background);
        self.run = if foreground { self.run + 1 } else { 0 };
        self.row(matched.map_or(0, |index| index + 1), place + 1, background, foreground, rho, p)
    }

    /// B under this T.
    fn background(&self, t: f32) -> usize {
        let mut sum = 0.0;
        for (index, g) in self.mixture.iter().enumerate() {
            sum += g.w;
            if sum > t {
                return index + 1;
            }
        }
        self.mixture.iter().filter(|g| g.w > 0.0).count()
    }

    fn row(
        &self,
        matched: usize,
        rank: usize,
        background: usize,
        foreground: bool,
        rho: f32,
        p: f64,
    ) -> Vec<f32> {
        let mut row = vec![
            matched as f32,
            rank as f32,
            background as f32,
            f32::from(u8::from(foreground)),
            rho,
            p as f32,
        ];
        for g in &self.mixture {
            row.push(g.w);
            row.extend(&g.mu);
            row.push(g.var);
        }
        row
    }
}

fn distance(x: &[f32], mu: &[f32]) -> f32 {
    x.iter().zip(mu).map(|(x, mu)| (x - mu) * (x - mu)).fold(0.0, |sum, square| sum + square)
}

#[test]
fn the_table_equals_the_second_implementation() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images);
    let (mut replaced, mut several) = (0, 0);
    for (flags, at) in [
        (&["--preset", "plain"][..], (3, 4)),
        (&["--preset", "plain", "--k", "1"], (0, 0)),
        (&["--preset", "plain", "--k", "8", "--t", "0.9"], (11, 11)),
        (&["--preset", "plain", "--space", "gray", "--k", "3"], (5, 6)),
        (&["--preset", "plain", "--rate", "constant", "--alpha", "0.05", "--k", "2"], (7, 1)),
        (&["--preset", "plain", "--warm-up", "30", "--match-sigmas", "1.5", "--min-sigma", "0.5"], (2, 9)),
        (&["--preset", "opencv-mog"], (8, 8)),
        (&["--preset", "paper", "--k", "3"], (1, 10)),
        (&["--preset", "default"], (6, 6)),
        (&["--preset", "plain", "--bootstrap", "30", "--warm-up", "50"], (3, 4)),
        (&["--preset", "default", "--bootstrap", "1.2s", "--space", "gray"], (9, 2)),
        (&["--preset", "paper", "--bootstrap", "1"], (5, 5)),
        // Learns from the whole of a short clip.
        (&["--preset", "plain", "--bootstrap", "9s"], (2, 2)),
    ] {
        let out = place.path("pixel.csv");
        let at_text = format!("{},{}", at.0, at.1);
        let arguments = [&["pixel", text(&images), "--at", &at_text, "--out", text(&out)], flags].concat();
        works(&arguments);
        let rows = table(&fs::read_to_string(&out).unwrap());
        assert_eq!(rows.len(), FRAMES as usize);

        let settings = settings_of(flags);
        let approximate = settings.rate.word() == "density";
        let mut reference = Reference::new(&settings);
        let to_learn = settings.bootstrap.frames(25.0).min(FRAMES);
        reference.learn((1..=to_learn).map(|t| colour(at.0, at.1, t)));
        for (row, t) in rows.iter().zip(1..) {
            let x = reference.value(colour(at.0, at.1, t));
            assert_eq!(row[0], t as f32, "{flags:?}");
            assert_eq!(row[1..=x.len()], x, "{flags:?}, frame {t}");
            let (row, expected) = (&row[x.len() + 1..], reference.step(colour(at.0, at.1, t)));
            assert_eq!(row.len(), expected.len());
            for (index, (&found, &expected)) in row.iter().zip(&expected).enumerate() {
                // Densities need an exponential, and so do all values that depend on ρ = α·η.
                let exact = index < 4 || (index != 5 && !approximate);
                let close = (found - expected).abs() <= 2e-5 * expected.abs();
                assert!(
                    if exact { found == expected } else { close },
                    "{flags:?}, frame {t}, column {index}: {found}, not {expected}"
                );
            }
            replaced += u32::from(t > 1 && row[0] == 0.0);
            several += u32::from(row[2] > 1.0);
        }
    }
    assert!(replaced > 50 && several > 50, "the sequence has too few changes: {replaced}, {several}");
}

fn settings_of(flags: &[&str]) -> Settings {
    let mut settings = Settings::preset(Preset::from_word(flags[1]).unwrap());
    for pair in flags[2..].chunks(2) {
        settings.set(pair[0].trim_start_matches("--"), pair[1]).unwrap();
    }
    settings
}

#[test]
fn the_table_equals_the_library_bit_for_bit() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images);
    for preset in Preset::ALL {
        // Without --out the table is written to stdout.
        let rows = table(&works(&["pixel", text(&images), "--at", "4,7", "--preset", preset.word()]));
        let parameters = Parameters::new(&Settings::preset(preset));
        let mut pixel = Pixel::unseen(parameters.k);
        let learnt = Settings::preset(preset).bootstrap.frames(25.0).min(FRAMES);
        let parameters = Parameters { learnt, ..parameters };
        for t in 1..=learnt {
            pixel.update(parameters.value(colour(4, 7, t)), t, &parameters);
        }
        for (row, t) in rows.iter().zip(1..) {
            let outcome = pixel.update(parameters.value(colour(4, 7, t)), learnt + t, &parameters);
            assert_eq!((row[8], row[9]), (outcome.rho, outcome.p));
            for (cells, component) in row[10..].chunks(5).zip(pixel.components()) {
                assert_eq!(cells[0], component.weight);
                assert_eq!(cells[1..4], component.mean);
                assert_eq!(cells[4], component.variance);
            }
        }
    }
}

#[test]
fn a_range_starts_the_model_there_and_keeps_the_numbers() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images);
    let all = works(&["pixel", text(&images), "--at", "4,7", "--bootstrap", "0"]);
    let some = works(&["pixel", text(&images), "--at", "4,7", "--bootstrap", "0", "--range", "21..30"]);
    assert_eq!(some.lines().count(), 11);
    assert!(some.lines().nth(1).unwrap().starts_with("21,"));
    assert!(some.lines().last().unwrap().starts_with("30,"));
    assert!(some.lines().nth(1).unwrap().contains(",0,1,1,0,0,0,1,"), "the first frame of the model");
    assert_eq!(some.lines().next(), all.lines().next());
    assert_ne!(some.lines().last(), all.lines().nth(30));
}

#[test]
fn with_a_range_learning_starts_at_its_first_frame() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images);
    let of = |folder: &Path, more: &[&str]| {
        let rows = works(&[&["pixel", text(folder), "--at", "4,7", "--bootstrap", "12"], more].concat());
        rows.lines().skip(1).map(|row| row.split_once(',').unwrap().1.to_owned()).collect::<Vec<_>>()
    };
    let some = of(&images, &["--range", "21..50"]);
    let part = place.path("part");
    fs::create_dir(&part).unwrap();
    for t in 21..=50 {
        fs::copy(images.join(format!("{t:04}.png")), part.join(format!("{t:04}.png"))).unwrap();
    }
    assert_eq!(some, of(&part, &[]));
    assert_eq!(some.len(), 30);
    assert!(!some[0].contains(",0,1,1,0,0,0,1,"), "frame 21 is not a first frame: {}", some[0]);
}
