//! `occluscope synth`: renders a scene with its ground truth.

use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use super::console::Console;
use super::{interrupt, standard_output};
use crate::frame::Size;
use crate::synth::noise::CameraNoise;
use crate::synth::{self, SceneParameters, catalogue};
use crate::truth::counted;

/// Defines the subcommand. All invalid values are detected here, as wrong usage.
pub fn command() -> Command {
    let names = catalogue::entries().map(|entry| entry.name);
    Command::new("synth")
        .about("Render a scene with exact ground truth")
        .arg(
            Arg::new("scene")
                .value_name("SCENE")
                .required_unless_present("list")
                .value_parser(PossibleValuesParser::new(names))
                .hide_possible_values(true)
                .help("Name of the scene; --list prints all names"),
        )
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .required_unless_present("list")
                .value_parser(value_parser!(PathBuf))
                .help("Output folder for SCENE.mp4, truth/ and scene.json; created if it does not exist"),
        )
        .arg(Arg::new("list").long("list").action(ArgAction::SetTrue).help("List the scenes and exit"))
        .arg(
            Arg::new("seed")
                .long("seed")
                .value_name("N")
                .default_value("1")
                .value_parser(value_parser!(u64))
                .help("Random seed for textures, noise, clothes and variations of speed"),
        )
        .arg(
            Arg::new("frames")
                .long("frames")
                .value_name("N")
                .value_parser(value_parser!(u32).range(1..=999_999))
                .help("Number of frames [default: until all people have left]"),
        )
        .arg(
            Arg::new("size")
                .long("size")
                .value_name("WxH")
                .default_value("320x240")
                .value_parser(parse_size)
                .help("Image size in pixels, both sides even, 64 to 4096"),
        )
        .arg(
            Arg::new("noise")
                .long("noise")
                .value_name("SIGMA")
                .default_value("4")
                .value_parser(|text: &str| parse_number(text, 0.0, 64.0))
                .help("Standard deviation of the camera noise in grey levels, 0 to 64"),
        )
        .arg(
            Arg::new("photon-noise")
                .long("photon-noise")
                .action(ArgAction::SetTrue)
                .help("Noise increases with brightness; SIGMA applies to mid grey"),
        )
        .arg(
            Arg::new("speed")
                .long("speed")
                .value_name("F")
                .default_value("1")
                .value_parser(|text: &str| parse_number(text, 0.1, 10.0))
                .help("Speed factor for all people, 0.1 to 10"),
        )
        .arg(
            Arg::new("shadows")
                .long("shadows")
                .action(ArgAction::SetTrue)
                .help("People cast a soft shadow at their feet"),
        )
        .arg(
            Arg::new("lossless")
                .long("lossless")
                .action(ArgAction::SetTrue)
                .help("Write SCENE.avi (lossless FFV1) instead of SCENE.mp4"),
        )
}

/// Runs the subcommand. Its errors are failures of the work; wrong usage is detected earlier.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    if matches.get_flag("list") {
        return list();
    }
    let parameters = parameters(matches);
    // Both are required by the command line.
    let (Some(name), Some(out)) = (matches.get_one::<String>("scene"), matches.get_one::<PathBuf>("out"))
    else {
        anyhow::bail!("synth needs SCENE and --out DIR; see `occluscope synth --help`");
    };
    let Some(scene) = catalogue::scene(name, &parameters) else {
        anyhow::bail!("there is no scene {name}; `occluscope synth --list` shows them");
    };

    let console = Console::new(matches);
    interrupt::watch();
    let bar = console.progress("rendering", Some(scene.frames));
    let mut so_far = 0;
    let video = synth::write(&scene, &parameters, out, matches.get_flag("lossless"), |done| {
        bar.advance((done - so_far) as usize);
        so_far = done;
        if interrupt::is_stop_requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    drop(bar);
    console.note(&format!(
        "{}: {} of {}, with ground truth",
        video.display(),
        counted(scene.frames as usize, "frame", "frames"),
        scene.size
    ));
    Ok(())
}

fn parameters(matches: &ArgMatches) -> SceneParameters {
    let usual = SceneParameters::default();
    let number = |name: &str, usual: f32| matches.get_one::<f32>(name).copied().unwrap_or(usual);
    SceneParameters {
        size: matches.get_one::<Size>("size").copied().unwrap_or(usual.size),
        frames: matches.get_one::<u32>("frames").copied(),
        seed: matches.get_one::<u64>("seed").copied().unwrap_or(usual.seed),
        noise: CameraNoise {
            sigma: number("noise", usual.noise.sigma),
            signal_dependent: matches.get_flag("photon-noise"),
        },
        speed: number("speed", usual.speed),
        shadows: matches.get_flag("shadows"),
    }
}

fn list() -> anyhow::Result<()> {
    standard_output::write(|out| {
        for entry in catalogue::entries() {
            writeln!(out, "{:17} {}", entry.name, entry.description)?;
        }
        Ok(())
    })
}

fn parse_size(text: &str) -> Result<Size, String> {
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let Some((width, height)) = sides else { return Err("give it as in 320x240".to_owned()) };
    for side in [width, height] {
        if !(64..=4096).contains(&side) || side % 2 == 1 {
            return Err(format!("{side} is not an even number from 64 to 4096"));
        }
    }
    Ok(Size::new(width, height))
}

fn parse_number(text: &str, least: f32, most: f32) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("it is not a number from {least} to {most}"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

    use super::super::flags;
    use super::*;

    fn parse(words: &str) -> Result<ArgMatches, clap::Error> {
        flags::with_common(command())
            .try_get_matches_from(std::iter::once("synth").chain(words.split_whitespace()))
    }

    #[test]
    fn the_command_is_valid_and_its_defaults_equal_the_library_s() {
        command().debug_assert();
        let matches = parse("crossing --out there").unwrap();
        assert_eq!(parameters(&matches), SceneParameters::default());
    }

    #[test]
    fn flags_become_parameters() {
        let matches = parse(
            "tree --out d --seed 7 --frames 50 --size 640x480 --noise 4 --speed 1.5 --photon-noise --shadows",
        );
        let expected = SceneParameters {
            size: Size::new(640, 480),
            frames: Some(50),
            seed: 7,
            noise: CameraNoise { sigma: 4.0, signal_dependent: true },
            speed: 1.5,
            shadows: true,
        };
        assert_eq!(parameters(&matches.unwrap()), expected);
    }

    #[test]
    fn wrong_usage_is_refused_with_status_2() {
        for words in [
            "",
            "crossing",
            "--out d",
            "nowhere --out d",
            "tree --out d --size 321x240",
            "tree --out d --size 32x32",
            "tree --out d --size big",
            "tree --out d --noise -1",
            "tree --out d --noise nan",
            "tree --out d --speed 0",
            "tree --out d --speed inf",
            "tree --out d --frames 0",
            "tree --out d --seed x",
        ] {
            let error = parse(words).expect_err(words);
            assert_eq!(error.exit_code(), 2, "{words}");
        }
        assert!(parse("--list").is_ok());
    }

    #[test]
    fn it_writes_a_scene() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("scene");
        let line = format!("empty --frames 3 --size 64x64 --out {}", out.display());
        run(&parse(&line).unwrap()).unwrap();
        assert!(out.join("empty.mp4").is_file() && out.join("truth/gt.txt").is_file());
    }
}
