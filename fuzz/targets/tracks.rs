//! Files of tracks: MOTChallenge's text, CVAT's and CAVIAR's XML, COCO's JSON, and their scores.

use occluscope::frame::Size;
use occluscope::placement::{Crop, Placement};
use occluscope::truth::Truth;
use occluscope::truth::analysed_frames::AnalysedFrames;
use occluscope::truth::boxes::{Boxes, span};
use occluscope::truth::comparison::Comparison;
use occluscope::truth::external::ExternalResults;
use occluscope::truth::formats::{self, Role, TrackFile};

use super::check_message;
use super::folder::Folder;

pub fn run(data: &[u8]) {
    let folder = Folder::new();
    let path = folder.write("tracks", data);
    // Labels beside a file change what its classes mean.
    if data.len() % 2 == 1 {
        folder.write("labels.txt", b"");
    }
    let files = [Role::Truth, Role::Results].map(|role| match formats::read(&path, role) {
        Ok(file) => {
            check_file(&file);
            Some(file)
        }
        Err(error) => {
            let message = error.to_string();
            check_message(&message);
            assert!(message.starts_with(&path.display().to_string()), "{message}");
            None
        }
    });
    let external = ExternalResults::read(&path);
    assert_eq!(external.is_ok(), files[1].is_some());
    if let [Some(truth), Some(results)] = &files {
        check_scores(truth, results);
    }
    if let Ok(truth) = Truth::read(&path) {
        check_placement(&truth);
    }
}

fn check_file(file: &TrackFile) {
    let judged = file.boxes.values().flat_map(|boxes| boxes.values());
    for bounds in judged.chain(file.ignored.values().flatten()) {
        let sides = bounds.0;
        assert!(sides.iter().all(|side| side.is_finite()) && sides[2] >= 0.0 && sides[3] >= 0.0, "{sides:?}");
    }
    file.remarks.iter().for_each(|remark| check_message(remark));
}

/// All scores are numbers, and a file agrees with itself.
fn check_scores(truth: &TrackFile, results: &TrackFile) {
    let analysed = AnalysedFrames::of_results(span(&results.boxes));
    for offset in [0, -1, 1 << 33] {
        let comparison = Comparison::new(truth, results, &analysed, offset);
        let score = comparison.score();
        for matches in [&score.strict, &score.loose] {
            let shares = [matches.precision, matches.recall, matches.idf1];
            assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{matches:?}");
            assert!(matches.mota <= 1.0, "{matches:?}");
        }
        let parts = [score.hota.hota, score.hota.deta, score.hota.assa, score.hota.loca];
        assert!(parts.iter().all(|part| (0.0..=1.0).contains(part)), "{:?}", score.hota);
        let _ = (comparison.better_offset(), comparison.note());
        if let Err(error) = comparison.check_frames("x".as_ref()) {
            check_message(&error.to_string());
        }
    }
    // A side that rounding cannot lose.
    let has_area = |boxes: &Boxes| {
        let mut all = boxes.values().flat_map(|boxes| boxes.values());
        all.all(|bounds| {
            bounds.0.iter().all(|side| side.abs() < 1e6) && bounds.0[2] > 1e-3 && bounds.0[3] > 1e-3
        })
    };
    if truth.ignored.is_empty() && truth.count() > 0 && truth.boxes == results.boxes && has_area(&truth.boxes)
    {
        let score = Comparison::new(truth, results, &analysed, 0).score();
        assert_eq!((score.strict.mota, score.strict.idf1), (1.0, 1.0), "{:?}", score.strict);
    }
}

fn check_placement(truth: &Truth) {
    let crop = Crop { x: 3, y: 2, width: 10, height: 8 };
    let placements = [Placement::new(Size::new(16, 12), Some(crop), Some(0.5))];
    for placement in placements.into_iter().flatten() {
        let moved = truth.in_frames(&placement);
        let boxes = moved.boxes.iter().flat_map(|boxes| boxes.values().flat_map(|boxes| boxes.values()));
        for bounds in boxes {
            assert!(bounds.0[2] >= 0.0 && bounds.0[3] >= 0.0, "{bounds:?}");
        }
    }
}
