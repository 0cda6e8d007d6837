//! The colours of identities, components and kinds of events, wherever they are drawn.
//!
//! They can be distinguished with the common kinds of colour blindness and are visible on dark images. No meaning is
//! carried by colour alone: identities also have their number, events their icon, components their rank.

use crate::occlusion::EventKind;
use crate::tracking::Identity;

/// Okabe and Ito's colours without black, with the dark blue lightened for dark images, and three more at a distance
/// from them.
const IDENTITIES: [[u8; 3]; 10] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 178, 128],
    [240, 228, 66],
    [213, 94, 0],
    [204, 121, 167],
    [78, 121, 240],
    [187, 221, 119],
    [255, 170, 187],
    [153, 221, 255],
];

/// A colour for each slot of a mixture of up to eight components. A component keeps its slot while its rank changes,
/// and so its colour is constant over time.
const COMPONENTS: [[u8; 3]; 8] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 178, 128],
    [204, 121, 167],
    [240, 228, 66],
    [213, 94, 0],
    [128, 140, 248],
    [170, 170, 170],
];

/// The colour of a pixel that is foreground in the mask and in the ground truth.
pub const TRUE_POSITIVE: [u8; 3] = [228, 232, 238];
/// The colour of a pixel that is foreground in the mask alone.
pub const FALSE_POSITIVE: [u8; 3] = [232, 92, 28];
/// The colour of a pixel that is foreground in the ground truth alone.
pub const FALSE_NEGATIVE: [u8; 3] = [86, 180, 233];
/// The colour of a pixel that the ground truth ignores.
pub const IGNORED: [u8; 3] = [58, 52, 66];

/// The colour of an object; neighbouring identities differ strongly, and the same identity always has the same.
pub fn identity_colour(id: Identity) -> [u8; 3] {
    IDENTITIES[(id.max(1) - 1) as usize % IDENTITIES.len()]
}

/// The same, darker, for light backgrounds.
pub fn identity_on_light(id: Identity) -> [u8; 3] {
    on_light(identity_colour(id))
}

/// The colour of a mixture's component by its slot, from 0.
pub fn component_colour(slot: usize) -> [u8; 3] {
    COMPONENTS[slot % COMPONENTS.len()]
}

/// The same, darker, for light backgrounds, on which the palette's yellow has no contrast.
pub fn component_on_light(slot: usize) -> [u8; 3] {
    on_light(component_colour(slot))
}

fn on_light(colour: [u8; 3]) -> [u8; 3] {
    colour.map(|channel| (f32::from(channel) * 0.78) as u8)
}

/// Vermilion for foreground, bluish green for background, which can be distinguished with any kind of colour vision.
pub const fn verdict_colour(foreground: bool, on_dark: bool) -> [u8; 3] {
    match (foreground, on_dark) {
        (true, true) => [232, 106, 23],
        (true, false) => [201, 82, 0],
        (false, true) => [0, 178, 128],
        (false, false) => [0, 140, 100],
    }
}

/// The colour of a kind of event: warm for merge, disappear and appear, blue and green for demerge and reappear, gray
/// for enter and exit.
pub const fn event_colour(kind: EventKind) -> [u8; 3] {
    match kind {
        EventKind::Merge => [230, 159, 0],
        EventKind::Demerge => [86, 180, 233],
        EventKind::Disappear => [213, 94, 0],
        EventKind::Reappear => [0, 178, 128],
        EventKind::Appear => [204, 121, 167],
        EventKind::Enter => [168, 180, 190],
        EventKind::Exit => [120, 130, 142],
    }
}

/// The colour of a value at a position 0..=1 of a scale, from dark to bright: a polynomial approximation of viridis,
/// which is perceptually uniform, with any kind of colour vision and in gray.
pub fn ramp(share: f32) -> [u8; 3] {
    const POWERS: [[f32; 3]; 7] = [
        [0.277_727, 0.005_407, 0.334_100],
        [0.105_093, 1.404_614, 1.384_59],
        [-0.330_862, 0.214_848, 0.095_095],
        [-4.634_23, -5.799_101, -19.332_441],
        [6.228_27, 14.179_933, 56.690_55],
        [4.776_385, -13.745_145, -65.353_033],
        [-5.435_456, 4.645_853, 26.312_435],
    ];
    let at = share.clamp(0.0, 1.0);
    std::array::from_fn(|channel| {
        let value = POWERS.iter().rev().fold(0.0, |sum, power| sum * at + power[channel]);
        (value.clamp(0.0, 1.0) * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_one_kind_differ() {
        for (i, a) in EventKind::ALL.iter().enumerate() {
            for b in &EventKind::ALL[i + 1..] {
                assert_ne!(event_colour(*a), event_colour(*b), "{a:?} and {b:?}");
            }
        }
        for i in 0..COMPONENTS.len() {
            for j in i + 1..COMPONENTS.len() {
                assert_ne!(component_colour(i), component_colour(j));
            }
        }
        assert_ne!(identity_colour(1), identity_colour(2));
        assert_eq!(identity_colour(3), identity_colour(3));
    }
}
