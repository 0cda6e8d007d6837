//! Label images: the identity of each pixel in the offline result, 0 for the background and for regions without an
//! identity.
//!
//! All pixels of a region of one object have its identity. So have those of a region of several objects whose episode
//! knows the one in front. Otherwise each pixel has the identity of the object whose box is nearest; of several boxes
//! that contain it, of the one with the nearest centre.

use std::collections::BTreeMap;

use crate::frame::Size;
use crate::occlusion::Episode;
use crate::placement::Placement;
use crate::regions::{LabelRun, Labels};
use crate::tracking::{FrameTracks, Identity, Track};

/// The identity of each pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelImage {
    /// Width and height.
    pub size: Size,
    /// An identity or 0 for each pixel, row by row.
    pub data: Vec<u16>,
}

/// An identity does not fit into 16 bits.
#[derive(Debug, thiserror::Error)]
#[error(
    "identity {identity} in frame {frame} is too large for label images, which hold 65535; run again without --labels"
)]
pub struct IdentityTooLarge {
    identity: Identity,
    frame: u32,
}

impl LabelImage {
    /// The image of a frame from its labels, its tracks in the pixels of the labels, and all episodes.
    pub fn new(labels: &Labels, frame: &FrameTracks, episodes: &[Episode]) -> Result<Self, IdentityTooLarge> {
        let mut objects: BTreeMap<u32, Vec<&Track>> = BTreeMap::new();
        for track in &frame.tracks {
            for &label in &track.regions {
                let sharing = objects.entry(label).or_default();
                // A region may be listed twice for one object.
                if sharing.last().is_none_or(|last| last.id != track.id) {
                    sharing.push(track);
                }
            }
        }
        let pixel = |identity: Identity| {
            u16::try_from(identity).map_err(|_| IdentityTooLarge { identity, frame: frame.number })
        };
        let fronts: BTreeMap<u32, Identity> = objects
            .iter()
            .filter_map(|(&label, sharing)| Some((label, front(sharing, frame.number, episodes)?)))
            .collect();
        let mut data = vec![0; labels.size.pixels()];
        for run in &labels.runs {
            if let Some(&identity) = fronts.get(&run.label) {
                data[run.pixels()].fill(pixel(identity)?);
            } else if let Some(sharing) = objects.get(&run.label) {
                for (index, at) in run.pixels().zip(centres(*run, labels.size)) {
                    data[index] = nearest(sharing, at).map_or(Ok(0), pixel)?;
                }
            }
        }
        Ok(Self { size: labels.size, data })
    }

    /// The image in the source's pixels, 0 outside the crop.
    pub fn in_source(&self, placement: &Placement) -> Self {
        Self { size: placement.source(), data: placement.source_values(&self.data, 0) }
    }
}

/// The identity of all pixels of a region of these objects: the only one, or the one in front, where known.
fn front(sharing: &[&Track], frame: u32, episodes: &[Episode]) -> Option<Identity> {
    let has = |identity: Identity| sharing.iter().any(|track| track.id == identity);
    match sharing {
        [only] => Some(only.id),
        _ => episodes
            .iter()
            .filter(|episode| (episode.start..=episode.end).contains(&frame))
            .find(|episode| sharing.iter().all(|track| episode.objects.contains(&track.id)))
            .and_then(|episode| episode.front)
            .filter(|&front| has(front)),
    }
}

/// The identity of the object whose box is nearest to a point, then whose centre is, then the first.
fn nearest(sharing: &[&Track], [x, y]: [f32; 2]) -> Option<Identity> {
    let distances = |track: &Track| {
        let bounds = track.bbox;
        let outside = |at: f32, low: f32, high: f32| (low - at).max(at - high).max(0.0);
        let [dx, dy] = [outside(x, bounds.x, bounds.right()), outside(y, bounds.y, bounds.bottom())];
        let [cx, cy] = bounds.centre();
        (dx.hypot(dy), (x - cx).hypot(y - cy))
    };
    let nearest = sharing
        .iter()
        .map(|track| (distances(track), track.id))
        .min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    nearest.map(|(_, identity)| identity)
}

/// The centres of a run's pixels.
fn centres(run: LabelRun, size: Size) -> impl Iterator<Item = [f32; 2]> {
    let width = size.width.max(1);
    let (row, left) = (run.start / width, run.start % width);
    (left..left + run.length).map(move |column| [column as f32 + 0.5, row as f32 + 0.5])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::export::tests::track;
    use crate::occlusion::EpisodeKind;
    use crate::regions::Rect;

    const SIZE: Size = Size::new(8, 2);

    /// Region 1 in the first four columns of the first row, region 2 in all of the second, noise at the upper right.
    fn labels() -> Labels {
        let run = |start, length, label| LabelRun { start, length, label };
        Labels { size: SIZE, runs: vec![run(0, 4, 1), run(7, 1, 0), run(8, 8, 2)] }
    }

    fn object(id: Identity, regions: &[u32], x: f32, w: f32) -> Track {
        let bbox = Rect::new(x, 0.0, w, 2.0);
        Track { bbox, regions: regions.to_vec(), ..track(id, 0.0, 0.0) }
    }

    fn image(tracks: Vec<Track>, episodes: &[Episode]) -> Result<Vec<u16>, IdentityTooLarge> {
        let frame = FrameTracks { number: 5, time: 0.0, tracks };
        LabelImage::new(&labels(), &frame, episodes).map(|image| image.data)
    }

    fn episode(objects: &[Identity], start: u32, front: Identity) -> Episode {
        Episode {
            kind: EpisodeKind::InterObject,
            objects: objects.to_vec(),
            start,
            end: 9,
            least_visible: 0.5,
            front: Some(front),
            identities_kept: true,
        }
    }

    #[test]
    fn a_region_has_the_identity_of_its_object_and_noise_has_none() {
        let of_one = image(vec![object(3, &[1, 1], 0.0, 4.0)], &[]).unwrap();
        assert_eq!(of_one, [3, 3, 3, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        let of_both = image(vec![object(65535, &[1, 2], 0.0, 4.0)], &[]).unwrap();
        assert_eq!(of_both[..8], [65535, 65535, 65535, 65535, 0, 0, 0, 0]);
        assert_eq!(of_both[8..], [65535; 8]);
    }

    #[test]
    fn a_shared_region_has_the_identity_in_front() {
        let both = || vec![object(3, &[2], 0.0, 4.0), object(4, &[2], 4.0, 4.0)];
        assert_eq!(image(both(), &[episode(&[3, 4, 5], 5, 4)]).unwrap()[8..], [4; 8]);
        let nearest = [3, 3, 3, 3, 4, 4, 4, 4];
        for other in [episode(&[3, 4], 6, 4), episode(&[3, 5], 1, 3), episode(&[3, 4, 5], 1, 5)] {
            assert_eq!(image(both(), &[other]).unwrap()[8..], nearest);
        }
    }

    #[test]
    fn without_one_in_front_the_nearest_box_decides_then_the_nearest_centre() {
        let shared = |boxes: [(f32, f32); 2]| {
            let [(x, w), (other, wide)] = boxes;
            let tracks = vec![object(3, &[2], x, w), object(4, &[2], other, wide)];
            image(tracks, &[]).unwrap()[8..].to_vec()
        };
        assert_eq!(shared([(0.0, 2.0), (5.0, 2.0)]), [3, 3, 3, 3, 4, 4, 4, 4], "halfway between boxes");
        assert_eq!(shared([(0.0, 6.0), (2.0, 6.0)]), [3, 3, 3, 3, 4, 4, 4, 4], "both contain the middle");
        assert_eq!(shared([(0.0, 8.0), (6.0, 2.0)]), [3, 3, 3, 3, 3, 3, 4, 4], "the smaller is within");
    }

    #[test]
    fn an_identity_of_more_than_16_bits_is_refused() {
        let refused = image(vec![object(65536, &[1], 0.0, 4.0)], &[]).unwrap_err().to_string();
        assert!(refused.contains("65536") && refused.contains("frame 5"), "{refused}");
        assert_eq!(image(vec![object(65536, &[], 0.0, 4.0)], &[]).unwrap(), [0; 16], "it has no pixel");
    }
}
