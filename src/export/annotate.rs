//! Draws results onto frames.

use super::canvas::{Canvas, Paint, text_width};
use super::joined;
use crate::frame::Frame;
use crate::occlusion::Event;
use crate::palette::{event_colour, identity_colour};
use crate::regions::Rect;
use crate::tracking::{FrameTracks, Identity, Track, TrackState};

/// The length of a trail, in seconds.
pub const TRAIL_SECONDS: f32 = 2.0;
/// The time that an event stays in the banner, in seconds: one frame of a video is too short to read.
pub const EVENT_SECONDS: f32 = 1.0;
/// How long before its own time an annotated frame shows tracks and events, in seconds; the frame before it is always
/// shown.
pub const ANNOTATED_SECONDS: f32 = TRAIL_SECONDS.max(EVENT_SECONDS);

const BLACK: [u8; 3] = [0; 3];
const WHITE: [u8; 3] = [255; 3];

/// The annotations of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameAnnotations<'a> {
    /// The objects of the last frames up to this one, for the length of a trail.
    pub recent: &'a [FrameTracks],
    /// The events of this frame and of those shortly before it.
    pub events: &'a [Event],
}

impl<'a> FrameAnnotations<'a> {
    /// The annotations of the frame at `index`, from the results of a sequence.
    pub fn at(index: usize, tracks: &'a [FrameTracks], events: &'a [Event]) -> Self {
        let Some(now) = tracks.get(index) else { return Self { recent: &[], events: &[] } };
        // Half a millisecond is less than a frame period and more than the error of a sum of them.
        let since = |seconds: f32| now.time - f64::from(seconds) + 0.000_5;
        let first_after = |time: f64| tracks[..index].partition_point(|frame| frame.time < time);
        let start = first_after(since(TRAIL_SECONDS)).min(index.saturating_sub(1));
        let oldest = tracks[first_after(since(EVENT_SECONDS))].number;
        // Events are in order of frames.
        let first = events.partition_point(|event| event.frame < oldest);
        let end = events.partition_point(|event| event.frame <= now.number);
        let recent = &tracks[start..=index];
        Self { recent, events: events.get(first..end).unwrap_or_default() }
    }
}

/// Draws boxes in the identities' colours (dashed where they are predicted), labels, trails, groups, and a banner
/// with the frame's number and events.
pub fn annotate(frame: &mut Frame, annotations: &FrameAnnotations<'_>) {
    let number = frame.number;
    let mut canvas = Canvas::new(frame);
    let style = Style::of(canvas.size().shorter_side());
    let tracks = annotations.recent.last().map_or(&[][..], |frame| &frame.tracks);

    for track in tracks {
        draw_trail(&mut canvas, track, annotations.recent, style);
    }
    let groups = groups(tracks);
    for GroupOutline { outline, .. } in &groups {
        canvas.outline(outline, style.line * 2.0, 0.0, Paint::sheer(BLACK, 0.4));
        canvas.outline(outline, style.line * 0.8, 0.0, Paint::sheer(WHITE, 0.9));
    }
    for track in tracks {
        draw_box(&mut canvas, track, style);
    }
    for event in annotations.events {
        let age = number.saturating_sub(event.frame) as f32;
        let paint = Paint::sheer(event_colour(event.kind), if age == 0.0 { 1.0 } else { 0.5 });
        canvas.circle([event.x, event.y], style.text * 0.5 + age, style.line, paint);
    }
    let banner = draw_banner(&mut canvas, number, annotations.events, style);
    draw_labels(&mut canvas, tracks, &groups, banner, style);
}

/// Sizes in pixels, scaled to the image.
#[derive(Clone, Copy)]
struct Style {
    line: f32,
    text: f32,
    gap: f32,
}

impl Style {
    fn of(shorter_side: u32) -> Self {
        let side = shorter_side as f32;
        let text = (side / 40.0).clamp(11.0, 40.0).round();
        Self { line: (side / 320.0).round().clamp(1.0, 6.0), text, gap: (text / 4.0).round() }
    }

    fn chip_height(self) -> f32 {
        self.text + self.gap
    }

    fn chip_width(self, text: &str) -> f32 {
        text_width(self.text, text) + 2.0 * self.gap
    }
}

fn draw_trail(canvas: &mut Canvas<'_>, track: &Track, recent: &[FrameTracks], style: Style) {
    let centres: Vec<_> = recent
        .iter()
        .rev()
        .map_while(|frame| frame.tracks.iter().find(|other| other.id == track.id))
        .map(|other| other.bbox.centre())
        .collect();
    let steps = centres.len().max(2) as f32;
    for (age, pair) in centres.windows(2).enumerate() {
        let opacity = 0.9 * (1.0 - age as f32 / steps);
        canvas.line(pair[0], pair[1], style.line, Paint::sheer(identity_colour(track.id), opacity));
    }
}

fn draw_box(canvas: &mut Canvas<'_>, track: &Track, style: Style) {
    let dash = if track.state == TrackState::Visible { 0.0 } else { style.line * 4.0 };
    // Whole pixels around the object, so that lines are sharp and do not cover it.
    let Rect { x, y, .. } = track.bbox;
    let (left, top) = (x.round() - style.line / 2.0, y.round() - style.line / 2.0);
    let (right, bottom) =
        (track.bbox.right().round() + style.line / 2.0, track.bbox.bottom().round() + style.line / 2.0);
    let around = Rect::new(left, top, right - left, bottom - top);
    // A dark rim separates the line from a background of similar colour.
    canvas.outline(&around, style.line + 2.0, dash, Paint::sheer(BLACK, 0.35));
    canvas.outline(&around, style.line, dash, Paint::solid(identity_colour(track.id)));
}

/// An occlusion group and the rectangle around it.
struct GroupOutline {
    members: Vec<Identity>,
    outline: Rect,
}

/// The outlines of the groups among these objects.
fn groups(tracks: &[Track]) -> Vec<GroupOutline> {
    let mut groups: Vec<GroupOutline> = Vec::new();
    for track in tracks.iter().filter(|track| track.group.len() > 1) {
        match groups.iter_mut().find(|group| group.members == track.group) {
            Some(group) => group.outline = group.outline.union(&track.bbox),
            None => groups.push(GroupOutline { members: track.group.clone(), outline: track.bbox }),
        }
    }
    let margin = 5.0;
    for GroupOutline { outline, .. } in &mut groups {
        *outline = Rect::new(
            outline.x - margin,
            outline.y - margin,
            outline.w + 2.0 * margin,
            outline.h + 2.0 * margin,
        );
    }
    groups
}

/// Draws the banner into the upper left corner; returns the rectangles that it covers.
fn draw_banner(canvas: &mut Canvas<'_>, number: u32, events: &[Event], style: Style) -> Vec<Rect> {
    let mut chips = vec![(format!("frame {number}"), Paint::sheer(BLACK, 0.7), WHITE)];
    // The newest first.
    for event in events.iter().rev() {
        let text = if event.objects == event.becomes || event.becomes.is_empty() || event.objects.is_empty() {
            let objects = if event.objects.is_empty() { &event.becomes } else { &event.objects };
            format!("{} {}", event.kind.label(), joined(objects))
        } else {
            format!("{} {} → {}", event.kind.label(), joined(&event.objects), joined(&event.becomes))
        };
        if event.frame == number {
            chips.push((text, Paint::solid(event_colour(event.kind)), BLACK));
        } else {
            chips.push((text, Paint::sheer(BLACK, 0.7), event_colour(event.kind)));
        }
    }
    let size = canvas.size();
    let (mut x, mut y) = (style.gap, style.gap);
    let mut places = Vec::new();
    for (text, ground, ink) in chips {
        let width = style.chip_width(&text);
        if x > style.gap && x + width + style.gap > size.width as f32 {
            (x, y) = (style.gap, y + style.chip_height() + style.gap);
        }
        // The banner covers at most a third of the image's height.
        if y + style.chip_height() > size.height as f32 / 3.0 && !places.is_empty() {
            break;
        }
        let place = Rect::new(x, y, width, style.chip_height());
        draw_chip(canvas, &place, &text, ground, ink, style);
        x += width + style.gap;
        places.push(place);
    }
    places
}

/// Draws each object's label next to the object, at the position of the least overlap.
fn draw_labels(
    canvas: &mut Canvas<'_>,
    tracks: &[Track],
    groups: &[GroupOutline],
    banner: Vec<Rect>,
    style: Style,
) {
    let objects: Vec<_> = tracks.iter().map(|track| track.bbox).collect();
    let mut taken = banner;
    let chips = tracks.iter().map(|track| (track.id.to_string(), track.bbox, identity_colour(track.id)));
    let group_chips = groups.iter().map(|group| (joined(&group.members), group.outline, WHITE));
    for (text, around, colour) in chips.chain(group_chips) {
        let (w, h) = (style.chip_width(&text), style.chip_height());
        let rim = style.line;
        let (left, right) = (around.x - rim / 2.0, around.right() + rim / 2.0 - w);
        let (above, below) = (around.y - h - rim, around.bottom() + rim);
        let places = [
            [left, above],
            [right, above],
            [left, below],
            [right, below],
            [around.right() + rim, around.y],
            [around.x - rim - w, around.y],
            [around.right() + rim, around.bottom() - h],
            [around.x - rim - w, around.bottom() - h],
        ];
        let size = canvas.size();
        let inside = |[x, y]: [f32; 2]| {
            let (most_x, most_y) = ((size.width as f32 - w).max(0.0), (size.height as f32 - h).max(0.0));
            Rect::new(x.clamp(0.0, most_x), y.clamp(0.0, most_y), w, h)
        };
        let covered = |place: &Rect| {
            let over =
                |others: &[Rect]| others.iter().map(|other| place.intersection(other).area()).sum::<f32>();
            3.0 * over(&taken) + over(&objects)
        };
        let best = places
            .into_iter()
            .filter(|place| place.iter().all(|value| value.is_finite()))
            .map(inside)
            .min_by(|a, b| covered(a).total_cmp(&covered(b)));
        if let Some(place) = best {
            draw_chip(canvas, &place, &text, Paint::sheer(colour, 0.9), BLACK, style);
            taken.push(place);
        }
    }
}

fn draw_chip(canvas: &mut Canvas<'_>, place: &Rect, text: &str, ground: Paint, ink: [u8; 3], style: Style) {
    canvas.fill(place, ground);
    canvas.text([place.x + style.gap, place.y + style.gap / 2.0], style.text, text, Paint::solid(ink));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::export::tests::track;
    use crate::frame::Size;
    use crate::occlusion::{EventKind, Evidence};

    fn event(frame: u32, kind: EventKind, objects: &[Identity]) -> Event {
        let objects = objects.to_vec();
        Event {
            frame,
            kind,
            becomes: objects.clone(),
            objects,
            pieces: Vec::new(),
            x: 60.0,
            y: 60.0,
            front: None,
            evidence: Evidence::default(),
        }
    }

    /// The objects of a frame of a video of 10 frames per second.
    fn frame_tracks(number: u32, tracks: Vec<Track>) -> FrameTracks {
        FrameTracks { number, time: f64::from(number) / 10.0, tracks }
    }

    fn grey(number: u32, size: Size) -> Frame {
        Frame::new(number, size, vec![100; size.pixels() * 3])
    }

    #[test]
    fn a_box_has_the_colour_of_its_identity_and_does_not_cover_the_object() {
        let object = Track { bbox: Rect::new(40.0, 50.0, 20.0, 40.0), ..track(4, 0.0, 0.0) };
        let tracks = vec![frame_tracks(9, vec![object])];
        let mut frame = grey(9, Size::new(200, 120));
        annotate(&mut frame, &FrameAnnotations::at(0, &tracks, &[]));
        assert_eq!(frame.pixel(39, 70), Some(identity_colour(4)));
        assert_eq!(frame.pixel(60, 70), Some(identity_colour(4)));
        for y in 53..87 {
            for x in 43..57 {
                assert_eq!(frame.pixel(x, y), Some([100; 3]), "({x}, {y})");
            }
        }
        let label = (40..60).flat_map(|x| (30..50).map(move |y| (x, y)));
        let inked =
            label.filter(|&(x, y)| frame.pixel(x, y).is_some_and(|[r, g, b]| r < 90 && g < 90 && b < 60));
        assert!(inked.count() > 3, "the label is written above the box");
    }

    #[test]
    fn a_predicted_box_is_dashed() {
        let hidden = Track {
            state: TrackState::Hidden,
            bbox: Rect::new(40.0, 40.0, 60.0, 60.0),
            ..track(1, 0.0, 0.0)
        };
        let tracks = vec![frame_tracks(9, vec![hidden])];
        let mut frame = grey(9, Size::new(200, 120));
        annotate(&mut frame, &FrameAnnotations::at(0, &tracks, &[]));
        let coloured = (40..100).filter(|&y| frame.pixel(100, y) == Some(identity_colour(1))).count();
        assert!((15..45).contains(&coloured), "{coloured} of 60");
    }

    #[test]
    fn annotations_contain_recent_tracks_and_events() {
        let mut tracks: Vec<_> =
            (1..=50).map(|number| frame_tracks(number, vec![track(1, 0.0, 0.0)])).collect();
        let events: Vec<_> = (1..=50).map(|frame| event(frame, EventKind::Merge, &[1, 2])).collect();
        let annotations = FrameAnnotations::at(39, &tracks, &events);
        assert_eq!((annotations.recent[0].number, annotations.recent.last().unwrap().number), (21, 40));
        assert_eq!((annotations.events[0].frame, annotations.events.last().unwrap().frame), (31, 40));
        let first = FrameAnnotations::at(0, &tracks, &events);
        assert_eq!((first.recent.len(), first.events.len()), (1, 1));
        // Five seconds pass after frame 30.
        for frame in &mut tracks[30..] {
            frame.time += 5.0;
        }
        let after = FrameAnnotations::at(30, &tracks, &events);
        assert_eq!(after.recent.len(), 2, "a line needs two points");
        assert_eq!(after.events[0].frame, 31);
    }

    #[test]
    fn any_size_and_any_box_can_be_drawn() {
        let boxes = [
            Rect::new(-50.0, -50.0, 10.0, 10.0),
            Rect::new(f32::NAN, 0.0, 1.0, 1.0),
            Rect::new(0.0, 0.0, 0.0, 0.0),
            Rect::new(-1e7, -1e7, 3e7, 3e7),
        ];
        let group: Vec<_> = (1..=4).collect();
        let tracks = boxes
            .iter()
            .zip(1..)
            .map(|(&bbox, id)| Track {
                bbox,
                state: TrackState::Merged,
                group: group.clone(),
                ..track(id, 0.0, 0.0)
            })
            .collect();
        let frames = vec![frame_tracks(1, tracks)];
        let events = vec![event(1, EventKind::Merge, &group); 30];
        for size in [Size::new(1, 1), Size::new(20, 300), Size::new(333, 21)] {
            annotate(&mut grey(1, size), &FrameAnnotations::at(0, &frames, &events));
        }
    }
}
