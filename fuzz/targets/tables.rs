//! Files of results that are read again: the table of a sweep, events, episodes, and the JSON of a run.

use occluscope::export::sweep_csv;
use occluscope::source::Options;
use occluscope::sweep::data_set;
use occluscope::truth::analysed_frames::AnalysedFrames;
use occluscope::truth::event_scoring::{self, ScoredEvent};
use occluscope::truth::measures::{COLUMNS, Measures};

use super::check_message;
use super::folder::Folder;

pub fn run(data: &[u8]) {
    let folder = Folder::new();
    let sweep = folder.write("sweep.csv", data);
    match sweep_csv::read(&sweep) {
        Ok(table) => {
            let mut text = Vec::new();
            sweep_csv::write(&mut text, &table).unwrap();
            let again = sweep_csv::read(&folder.write("again.csv", &text)).unwrap();
            assert_eq!((again.rows.len(), &again.sequences), (table.rows.len(), &table.sequences));
            for measure in &COLUMNS {
                let _ = (table.best_overall(measure), table.equally_best_overall(measure));
            }
        }
        Err(error) => check_message(&error.to_string()),
    }
    let path = folder.write("events.jsonl", data);
    check_events(event_scoring::read_events(&path));
    check_events(event_scoring::read_episodes(&path));

    folder.write("scene.json", data);
    std::fs::create_dir(folder.path().join("truth")).unwrap();
    folder.write("truth/gt.txt", b"");
    data_set::sequences_below(folder.path()).unwrap();

    if let Ok(frames) = serde_json::from_slice::<AnalysedFrames>(data) {
        let (first, last) = frames.span();
        assert!(first <= last && frames.contains(first) && frames.contains(last) && frames.count() > 0);
        let numbers: Vec<u32> = frames.numbers().take(1000).collect();
        assert!(numbers.is_sorted_by(|a, b| a < b) && numbers.iter().all(|&number| frames.contains(number)));
        let text = serde_json::to_string(&frames).unwrap();
        assert_eq!(serde_json::from_str::<AnalysedFrames>(&text).unwrap(), frames);
    }
    if let Ok(options) = serde_json::from_slice::<Options>(data)
        && options.is_valid()
    {
        let text = serde_json::to_string(&options).unwrap();
        assert_eq!(serde_json::from_str::<Options>(&text).unwrap(), options);
    }
    if let Ok(measures) = serde_json::from_slice::<Measures>(data) {
        let text = serde_json::to_string(&measures).unwrap();
        assert_eq!(serde_json::from_str::<Measures>(&text).unwrap(), measures);
    }
}

fn check_events(events: Result<Vec<ScoredEvent>, impl ToString>) {
    match events {
        Ok(events) => {
            // They agree with themselves.
            let people = events.iter().flat_map(|event| event.objects.iter().map(|&id| (id, id))).collect();
            let total = event_scoring::total(&event_scoring::compare(&events, &events, &people, 8));
            assert_eq!([total.truth, total.reported, total.matched], [events.len(); 3]);
        }
        Err(error) => check_message(&error.to_string()),
    }
}
