//! A camera that is open for a day: what is remembered does not grow with the time.

#[path = "common/blocks.rs"]
mod blocks;

use blocks::{Block, regions};
use occluscope::frame::Size;
use occluscope::occlusion::Reasoner;
use occluscope::settings::{Settings, Span};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

const SIZE: Size = Size::new(160, 120);

/// A path of a walker through the image, in cells.
struct Passer {
    from: u32,
    left: bool,
    row: i32,
    pace: i32,
    colour: [u8; 3],
    /// Frames of their way in which nothing is seen of them.
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

/// How much a reasoner remembers at most in each thousand frames of people who come, meet, hide and leave.
fn remembered(every: u32, frames: u32) -> Vec<usize> {
    let mut random = Pcg32::seed_from_u64(7);
    let settings = Settings { max_hidden: Span::Frames(100), ..Settings::default() };
    let mut reasoner = Reasoner::new(&settings, SIZE, 25.0);
    let mut passers: Vec<Passer> = Vec::new();
    let (mut most, mut identities, mut occlusions) = (vec![0; frames as usize / 1000], 0, 0);
    for number in 1..=frames {
        if number.is_multiple_of(every) {
            passers.push(Passer::new(number, &mut random));
        }
        passers.retain(|passer| number - passer.from < 100);
        let blocks: Vec<Block> = passers.iter().filter_map(|passer| passer.seen(number)).collect();
        let seen = reasoner.step(number, &regions(&blocks, SIZE));
        identities = seen.tracks.iter().map(|track| track.id).fold(identities, u32::max);
        occlusions += seen.settled.episodes.len();
        let most = &mut most[(number as usize - 1) / 1000];
        *most = reasoner.remembered().max(*most);
    }
    assert!(identities > 150 && occlusions > 80, "{identities} identities, {occlusions} occlusions");
    most
}

#[test]
fn what_is_remembered_does_not_grow() {
    // Few at a time, and a crowd that never parts.
    for (every, frames) in [(25, 20_000), (8, 6000)] {
        let most = remembered(every, frames);
        let (first, last) = most.split_at(most.len() / 2);
        let largest = |half: &[usize]| half.iter().copied().max().unwrap_or(0);
        assert!(largest(last) <= largest(first) + 50, "one every {every} frames: {most:?}");
    }
}
