//! No library speaks to the user, whatever the environment asks of it.

use std::fs;

use crate::common::{TestFolder, names, noise, occluscope, text, write_images};
use crate::encoded::{damage, encode};
use crate::has_time;

/// Variables that make OpenCV, FFmpeg and what they use say more. OpenCV answers `OPENCV_DUMP_CONFIG` and `OPENCV_TRACE`
/// when it is loaded, before the program begins.
const TALKATIVE: [(&str, &str); 12] = [
    ("OPENCV_LOG_LEVEL", "DEBUG"),
    ("OPENCV_FFMPEG_LOGLEVEL", "56"),
    ("OPENCV_FFMPEG_DEBUG", "1"),
    ("OPENCV_VIDEOIO_DEBUG", "1"),
    ("OPENCV_VIDEOCAPTURE_DEBUG", "1"),
    ("OPENCV_VIDEOWRITER_DEBUG", "1"),
    ("OPENCV_DUMP_ERRORS", "1"),
    ("OPENCV_FOR_THREADS_NUM", "64"),
    ("OPENCV_LOG_TIMESTAMP", "1"),
    ("GST_DEBUG", "4"),
    ("AV_LOG_FORCE_COLOR", "1"),
    ("RUST_LOG", "trace"),
];

#[test]
fn only_the_program_writes_to_stderr() {
    let place = TestFolder::new();
    let (images, video, broken) = (place.path("images"), place.path("a.mp4"), place.path("broken.avi"));
    write_images(&images, 30, 1);
    for (number, content) in [(5, &b"\x89PNG\r\n\x1a\nrest"[..]), (7, b"\xff\xd8\xff\xe0\0\x10JFIF\0")] {
        fs::write(images.join(format!("in{number:06}.png")), content).unwrap();
    }
    assert!(encode(&video, "size=96x72:rate=25:duration=2", "libx264", ""));
    assert!(encode(&broken, "size=96x72:rate=25:duration=2", "mpeg4", ""));
    damage(&broken, 4000, 900);
    let random = place.path("random.mp4");
    fs::write(&random, (0..5000).map(|at| noise(at, 1, 2)).collect::<Vec<_>>()).unwrap();
    let (out, scene) = (place.path("out"), place.path("scene"));
    let gone = place.path("gone/out.csv");
    for arguments in [
        &["run", text(&images), "--annotated", "--frames", "--labels", "--out", text(&out)][..],
        &["run", text(&images), "--out", text(&out), "--background-model", "mog2"],
        &["run", text(&images), "--out", text(&out), "--background-model", "knn"],
        &["run", text(&video), "--annotated", "--out", text(&out)],
        &["run", text(&broken), "--annotated", "--out", text(&out)],
        &["run", text(&broken), "--deinterlace", "--out", text(&out)],
        &["run", text(&random), "--out", text(&out)],
        &["run", "camera:97", "--out", text(&out)],
        &["pixel", text(&video), "--at", "5,5", "--out", text(&gone)],
        &["bench", text(&video), "--frames", "40"],
        &["synth", "crossing", "--out", text(&scene), "--frames", "5"],
    ] {
        for threads in [&[][..], &["--threads", "64"]].into_iter().skip(usize::from(!has_time())) {
            let mut command = occluscope(&[arguments, threads].concat());
            let output = command.current_dir(place.path(".")).envs(TALKATIVE).output().unwrap();
            let stderr = String::from_utf8(output.stderr).unwrap();
            let ours = |line: &str| {
                ["error: ", "warning: ", "note: "].iter().any(|start| line.starts_with(start))
                    || line.contains("; written to ")
                    || line.ends_with(", with ground truth")
            };
            let foreign: Vec<_> = stderr.lines().filter(|line| !ours(line)).collect();
            assert!(foreign.is_empty(), "{arguments:?} {threads:?}: {foreign:#?}");
            assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}: {stderr}");
            let stdout = String::from_utf8_lossy(&output.stdout);
            assert!(
                arguments[0] == "bench" || arguments[0] == "synth" || stdout.is_empty(),
                "{arguments:?}: {stdout}"
            );
        }
    }
    let left: Vec<_> = names(&place.path("."));
    assert_eq!(
        left,
        ["a.mp4", "broken.avi", "gone", "images", "out", "random.mp4", "scene"],
        "nothing is written that was not named"
    );
}
