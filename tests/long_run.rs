//! A camera that runs for a day: memory does not grow with time.

#[path = "common/blocks.rs"]
mod blocks;

use blocks::{Block, regions};
use occluscope::frame::Size;
use occluscope::occlusion::Tracker;
use occluscope::settings::{Settings, Span};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

const SIZE: Size = Size::new(160, 120);

/// A walker's path through the image, in cells.
struct Passer {
    from: u32,
    left: bool,
    row: i32,
    pace: i32,
    colour: [u8; 3],
    /// Frames in which the walker is not visible.
    behind: std::ops::Range<u32>,
}

impl Passer {
    fn new(from: u32, random: &mut Pcg32) -> Self {
        let hidden = random.random_range(10..60);
        Self {
            from,
            left: random.random(),
            row: random.random_range(5..25),
            pace: random.random_range(1..3),
            colour: std::array::from_fn(|_| random.random()),
            behind: if random.random_bool(0.3) { hidden..hidden + 15 } else { 0..0 },
        }
    }

    fn seen(&self, number: u32) -> Option<Block> {
        let frames = number - self.from;
        if self.behind.contains(&frames) {
            return None;
        }
        let way = frames as i32 * self.pace - 8;
        Block::new((if self.left { way } else { 72 - way }, self.row), (7, 20), self.colour, SIZE)
    }
}

/// Least numbers of identities and occlusions, so that the test is meaningful.
struct Busy {
    identities: u32,
    occlusions: usize,
    /// Number of occlusions of more than four objects.
    large: usize,
}

/// The maximum memory of the tracker in each thousand frames of people who enter, merge, disappear and exit.
fn remembered(every: u32, frames: u32, least: &Busy) -> Vec<usize> {
    let mut random = Pcg32::seed_from_u64(7);
    let settings = Settings { max_hidden: Span::Frames(100), ..Settings::default() };
    let mut tracker = Tracker::new(&settings, SIZE, 25.0);
    let mut passers: Vec<Passer> = Vec::new();
    let mut most = vec![0; frames as usize / 1000];
    let mut busy = Busy { identities: 0, occlusions: 0, large: 0 };
    for number in 1..=frames {
        if number.is_multiple_of(every) {
            passers.push(Passer::new(number, &mut random));
        }
        passers.retain(|passer| number - passer.from < 100);
        let blocks: Vec<Block> = passers.iter().filter_map(|passer| passer.seen(number)).collect();
        let seen = tracker.step(number, f64::from(number) / 25.0, &regions(&blocks, SIZE));
        busy.identities = seen.tracks.iter().map(|track| track.id).fold(busy.identities, u32::max);
        let episodes = &seen.settled.episodes;
        busy.occlusions += episodes.len();
        busy.large += episodes.iter().filter(|episode| episode.objects.len() > 4).count();
        let most = &mut most[(number as usize - 1) / 1000];
        *most = tracker.retained_items().max(*most);
    }
    assert!(busy.identities >= least.identities, "{} identities", busy.identities);
    assert!(busy.occlusions >= least.occlusions, "{} occlusions", busy.occlusions);
    assert!(busy.large >= least.large, "{} occlusions of more than four", busy.large);
    most
}

#[test]
fn memory_does_not_grow() {
    // Few people at a time, and a crowd that is rarely separate, so that its occlusions are few and large.
    let few = Busy { identities: 600, occlusions: 400, large: 1 };
    let crowd = Busy { identities: 250, occlusions: 60, large: 4 };
    for (every, frames, least) in [(25, 20_000, few), (8, 12_000, crowd)] {
        let most = remembered(every, frames, &least);
        let (first, last) = most.split_at(most.len() / 2);
        let largest = |half: &[usize]| half.iter().copied().max().unwrap_or(0);
        assert!(largest(last) <= largest(first) + 50, "one every {every} frames: {most:?}");
    }
}
