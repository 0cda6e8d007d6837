//! The colours of the regions.

use eframe::egui::Color32;

use crate::app::theme;
use crate::palette::identity_colour;
use crate::pipeline::Analysis;

/// The colour of a region without a track.
pub(super) const UNASSOCIATED_COLOUR: Color32 = Color32::from_rgb(150, 156, 170);
const GROUP_COLOUR: Color32 = Color32::from_rgb(244, 246, 250);

/// The colour of each label: of its object, of an occlusion group, or of a region without a track.
pub(super) fn colours(analysis: &Analysis) -> Vec<Color32> {
    let most = analysis.regions.iter().map(|region| region.label).max().unwrap_or(0) as usize;
    let mut colours = vec![UNASSOCIATED_COLOUR; most + 1];
    for track in analysis.tracks.iter() {
        let colour = if track.group.len() > 1 { GROUP_COLOUR } else { theme::rgb(identity_colour(track.id)) };
        for &label in &track.regions {
            if let Some(of_label) = colours.get_mut(label as usize) {
                *of_label = colour;
            }
        }
    }
    colours
}
