//! Counterfactuals of an event.

use super::*;
use crate::explain::events::event_pairs::EventTolerance;
use crate::occlusion::EventKind;
use crate::settings::Setting;

#[test]
fn a_counterfactual_prevents_the_event_in_the_whole_video() {
    let folder = scene();
    let watched = Watched::open(folder.path(), settings(), Start::First, 1 << 30);
    let done = watched.until_done();
    let merge = done.timeline.events.iter().find(|(_, event)| event.kind == EventKind::Merge);
    let (_, merge) = merge.unwrap().clone();
    watched.session.explain(Some(merge.clone()));
    let answered = |state: &State| state.counterfactual.as_ref().is_some_and(|what_if| what_if.done);
    let what_if = watched.until(answered).counterfactual.unwrap();
    assert!(what_if.happens && what_if.event == merge);
    assert!(!what_if.preventions.is_empty(), "{what_if:?}");
    let tolerance = EventTolerance::of(Size::new(WIDTH, HEIGHT), 25.0);
    let happens = |settings: &Settings| {
        let all = straight(folder.path(), settings);
        all.iter().any(|shown| shown.analysis.events.iter().any(|event| tolerance.matches(&merge, event)))
    };
    let merges = |settings: &Settings| {
        let all = straight(folder.path(), settings);
        let events = all.iter().flat_map(|shown| shown.analysis.events.iter());
        events.filter(|event| event.kind == EventKind::Merge && event.frame <= what_if.until).count()
    };
    assert!(happens(&settings()));
    assert!(what_if.until >= merge.frame);
    let most = merges(&settings());
    for prevention in what_if.preventions.iter().take(4) {
        let mut other = settings();
        Setting::named(prevention.setting).unwrap().set(&mut other, prevention.value).unwrap();
        assert!(!happens(&other), "{}", prevention.words());
        assert!(merges(&other) < most, "{} only delays the event", prevention.words());
    }
    // There are no counterfactuals yet under other settings.
    watched.session.set_settings(Settings { gate: 0.95, ..settings() });
    watched.until(|state| state.counterfactual.is_none());
}
