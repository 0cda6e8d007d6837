//! Counterfactuals of an event.

use super::*;
use crate::explain::events::event_pairs::EventTolerance;
use crate::occlusion::EventKind;
use crate::settings::Setting;

#[test]
fn a_counterfactual_prevents_the_event_in_the_whole_video() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    let done = watched.wait_until_analysed();
    let merge = done.timeline.events.iter().find(|(_, event)| event.kind == EventKind::Merge);
    let (_, merge) = merge.unwrap().clone();
    watched.request(Request::Explain(Some(Box::new(merge.clone()))));
    let answered =
        |state: &State| state.counterfactual.as_ref().is_some_and(|counterfactual| counterfactual.done);
    let counterfactual = watched.wait_until(answered).counterfactual.unwrap();
    assert!(counterfactual.happens && counterfactual.event == merge);
    assert!(!counterfactual.preventions.is_empty(), "{counterfactual:?}");
    let tolerance = EventTolerance::of(Size::new(WIDTH, HEIGHT), 25.0);
    let happens = |settings: &Settings| {
        let all = single_pass(folder.path(), settings);
        all.iter().any(|shown| shown.analysis.events.iter().any(|event| tolerance.matches(&merge, event)))
    };
    let merges = |settings: &Settings| {
        let all = single_pass(folder.path(), settings);
        let events = all.iter().flat_map(|shown| shown.analysis.events.iter());
        events.filter(|event| event.kind == EventKind::Merge && event.frame <= counterfactual.until).count()
    };
    assert!(happens(&settings()));
    assert!(counterfactual.until >= merge.frame);
    let most = merges(&settings());
    for prevention in counterfactual.preventions.iter().take(4) {
        let mut other = settings();
        Setting::named(prevention.setting).unwrap().set(&mut other, prevention.value).unwrap();
        assert!(!happens(&other), "{}", prevention.words());
        assert!(merges(&other) < most, "{} only delays the event", prevention.words());
    }
    // There are no counterfactuals yet under other settings.
    watched.request(settings_request(Settings { gate: 0.95, ..settings() }, None));
    watched.wait_until(|state| state.counterfactual.is_none());
}
