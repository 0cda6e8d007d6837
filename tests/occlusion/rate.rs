//! Frame rate: the same walk at low and high frame rates, and with a wrong frame rate.

use occluscope::frame::Size;
use occluscope::settings::Settings;
use occluscope::synth::{SceneParameters, catalogue};

use super::judge::JudgedRun;

#[test]
fn identities_are_kept_at_any_frame_rate_and_with_a_wrong_one() {
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let runs: Vec<_> =
            ["crossing", "tree"].map(|name| scope.spawn(move || differences(name))).into_iter().collect();
        runs.into_iter().flat_map(|run| run.join().expect("the analysis must not panic")).collect()
    });
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn differences(name: &str) -> Vec<String> {
    let settings = Settings::default();
    let mut wrong = Vec::new();
    for fps in [7.0, 10.0, 25.0, 50.0] {
        // The same speed in pixels per second at any frame rate.
        let speed = catalogue::FPS / fps;
        let parameters = SceneParameters { size: Size::new(240, 180), speed, ..SceneParameters::default() };
        let mut scene = catalogue::scene(name, &parameters).expect("a scene of the catalogue");
        scene.fps = fps;
        let mut run = JudgedRun::new(&scene, speed, &settings);
        for rate_factor in [1.0, 0.5, 2.0] {
            if rate_factor != 1.0 {
                run.track_again(&settings, rate_factor * fps);
            }
            let differences = run.differences().into_iter();
            wrong.extend(
                differences.map(|what| format!("{name} at {fps}, taken for {}: {what}", rate_factor * fps)),
            );
        }
    }
    wrong
}
