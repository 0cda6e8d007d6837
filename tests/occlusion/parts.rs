//! Ablation of the occlusion reasoning: scenes with correct results, which become wrong as soon as one part is
//! switched off.

use occluscope::settings::Settings;
use occluscope::synth::Scene;

use super::judge::JudgedRun;
use super::mill::Mill;
use super::parameters;

/// The expected loss.
#[derive(Clone, Copy, Debug)]
enum Loss {
    /// At least this many additional differences from the truth, in events, episodes and identities.
    Differences(usize),
    /// A decrease of IDF1, at an IoU of .5, by at least this.
    Idf1(f64),
}

struct Row {
    scene: fn() -> Scene,
    /// The least IDF1 and the largest number of differences by default, without identity confusions.
    by_default: (f64, usize),
    /// The setting, its value, and the expected loss.
    changes: &'static [(&'static str, &'static str, Loss)],
}

fn catalogued(name: &str, seed: u64, speed: f32) -> Scene {
    let parameters = parameters(seed, (320, 240), speed, 4.0);
    occluscope::synth::catalogue::scene(name, &parameters).expect("a scene of the catalogue")
}

const RIGHT: (f64, usize) = (0.85, 1);

const ROWS: &[Row] = &[
    // Two walkers enter side by side. Both are tracked; their enter and merge events are late.
    Row {
        scene: || Mill::Abreast.scene(2012),
        by_default: (0.75, 8),
        changes: &[("count_heads", "off", Loss::Idf1(0.15))],
    },
    // One of two people walks away from the camera behind the other, and emerges smaller.
    Row {
        scene: || Mill::Deep.scene(1007),
        by_default: RIGHT,
        changes: &[("placing", "predicted", Loss::Idf1(0.1)), ("find_again", "off", Loss::Idf1(0.1))],
    },
    Row {
        scene: || Mill::Deep.scene(1072),
        by_default: RIGHT,
        changes: &[("perspective", "off", Loss::Idf1(0.05))],
    },
    // One merge event is 14 frames early.
    Row {
        scene: || Mill::Mixed.scene(9),
        by_default: (0.85, 4),
        changes: &[("placing", "predicted", Loss::Idf1(0.1))],
    },
    // One of two people walks behind a wall as they meet. The box includes an occluded part only where an occluder is
    // known.
    Row { scene: || Mill::Mixed.scene(3), by_default: (0.8, 0), changes: &[] },
    Row {
        scene: || Mill::Mixed.scene(86),
        by_default: (0.85, 6),
        changes: &[("size_step", "2", Loss::Differences(3))],
    },
    // A short loss of detection: without the fitness its hypothesis is kept and takes another object's region.
    Row {
        scene: || Mill::Deep.scene(13),
        by_default: RIGHT,
        changes: &[
            ("min_fitness", "0.0001", Loss::Differences(6)),
            ("null_factor", "0.99", Loss::Differences(6)),
        ],
    },
    // Two people enter one behind the other as one region, so that events are missing; the identities of later frames
    // are not.
    Row {
        scene: || Mill::Mixed.scene(183),
        by_default: (0.85, 13),
        changes: &[("max_hypotheses", "1", Loss::Idf1(0.2))],
    },
    Row {
        scene: || Mill::Mixed.scene(69),
        by_default: RIGHT,
        changes: &[("border", "0.5", Loss::Differences(3)), ("border", "6", Loss::Differences(3))],
    },
    Row {
        scene: || catalogued("crossing-steep", 3, 0.7),
        by_default: RIGHT,
        changes: &[("border", "6", Loss::Differences(6))],
    },
];

#[test]
fn every_ablation_makes_a_scene_wrong() {
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let rows: Vec<_> = ROWS.iter().map(|row| scope.spawn(|| failures(row))).collect();
        rows.into_iter().flat_map(|row| row.join().expect("the analysis must not panic")).collect()
    });
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn failures(row: &Row) -> Vec<String> {
    let scene = (row.scene)();
    let name = format!("{} {}", scene.name, scene.seed);
    let mut run = JudgedRun::new(&scene, 1.0, &Settings::default());
    let (differences, idf1) = (run.differences(), run.score().idf1);
    let mut wrong = Vec::new();
    let (least, most) = row.by_default;
    if differences.len() > most || !run.confusions().is_empty() || idf1 < least {
        wrong.push(format!("{name} by default, IDF1 {idf1}: {differences:?}"));
    }
    for (setting, value, loss) in row.changes {
        let mut settings = Settings::default();
        settings.set(setting, value).expect("a setting in its range");
        run.track_again(&settings, scene.fps);
        let (more, lost) =
            (run.differences().len().saturating_sub(differences.len()), idf1 - run.score().idf1);
        let fails = match *loss {
            Loss::Differences(least) => more >= least,
            Loss::Idf1(least) => lost >= least,
        };
        if !fails {
            wrong
                .push(format!("{name} with {setting} {value}: {more} differences more, IDF1 {lost:.3} less"));
        }
    }
    wrong
}
