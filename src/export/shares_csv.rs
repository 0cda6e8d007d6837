//! The share of foreground around a pixel, 0..=1, before and after cleaning, one frame per row: `frame,model,cleaned`.

use std::io::{self, Write};

use super::number::significant;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::region_shares::RegionShares;

/// Writes header and rows: the number of each frame, and the shares before and after cleaning. `history` is that of
/// the centre pixel, which has the frame numbers.
pub fn write(out: &mut impl Write, history: &PixelHistory, shares: &RegionShares) -> io::Result<()> {
    writeln!(out, "frame,model,cleaned")?;
    let both = shares.model.iter().zip(&shares.cleaned);
    history.states.iter().zip(both).try_for_each(|(state, (&model, &cleaned))| {
        writeln!(out, "{},{},{}", state.number, significant(model), significant(cleaned))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    #[test]
    fn a_row_has_both_shares_of_a_frame() {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let history = PixelHistory::of_colours((4, 5), parameters, (11..=13).map(|n| (n, [90; 3])));
        let (model, cleaned) = (vec![0.0, 1.0 / 3.0, 1.0], vec![0.0, 0.25]);
        let shares = RegionShares { at: (4, 5), side: 3, pixels: 9, model, cleaned };
        let text = written(|out| write(out, &history, &shares));
        let third = significant(1.0_f32 / 3.0);
        assert_eq!(text, format!("frame,model,cleaned\n11,0,0\n12,{third},0.25\n"));
    }
}
