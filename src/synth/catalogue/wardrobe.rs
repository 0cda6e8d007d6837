//! The clothes of people.

use crate::regions::Rgb;
use crate::synth::scene::Clothes;
use crate::synth::texture::unit;

/// The outfits. Any two of them differ clearly in shirt and trousers taken together, and all of them from the ground
/// colours.
const WARDROBE: [Clothes; 4] = [
    Clothes {
        shirt: [176, 34, 40],
        trousers: [38, 44, 66],
        shoes: [44, 34, 30],
        hair: [52, 34, 22],
        skin: [222, 174, 146],
        coat: false,
    },
    Clothes {
        shirt: [34, 74, 140],
        trousers: [84, 66, 48],
        shoes: [30, 30, 34],
        hair: [28, 24, 24],
        skin: [150, 102, 74],
        coat: false,
    },
    Clothes {
        shirt: [226, 178, 52],
        trousers: [32, 34, 38],
        shoes: [214, 208, 200],
        hair: [88, 58, 32],
        skin: [234, 190, 164],
        coat: false,
    },
    Clothes {
        shirt: [92, 36, 92],
        trousers: [24, 30, 52],
        shoes: [60, 44, 34],
        hair: [166, 128, 80],
        skin: [230, 186, 158],
        coat: true,
    },
];

/// The outfits, shuffled by the seed; seed 1 has them in the order of the table.
fn shuffled(seed: u64) -> [Clothes; 4] {
    let mut order = WARDROBE;
    if seed != 1 {
        for place in (1..order.len()).rev() {
            order.swap(place, (unit(seed, place as i64, 990) * (place + 1) as f32) as usize);
        }
    }
    order
}

/// Shirts and trousers of a crowd; all else is from the table of outfits.
const MORE: [(Rgb, Rgb); 8] = [
    ([36, 112, 58], [70, 62, 54]),
    ([214, 108, 30], [40, 44, 60]),
    ([228, 226, 220], [44, 58, 92]),
    ([30, 30, 34], [116, 96, 70]),
    ([24, 130, 138], [34, 34, 38]),
    ([206, 92, 140], [60, 58, 62]),
    ([112, 70, 38], [150, 142, 126]),
    ([126, 168, 214], [48, 36, 32]),
];

/// Outfit `number`; the first four are in an order determined by the seed, and after the twelfth the sequence
/// repeats.
pub(super) fn outfit(seed: u64, number: usize) -> Clothes {
    let wardrobe = shuffled(seed);
    let number = number % (wardrobe.len() + MORE.len());
    let usual = wardrobe[number % wardrobe.len()];
    match number.checked_sub(wardrobe.len()).map(|more| MORE[more]) {
        Some((shirt, trousers)) => Clothes { shirt, trousers, coat: false, ..usual },
        None => usual,
    }
}
