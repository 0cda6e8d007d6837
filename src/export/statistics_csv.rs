//! Statistics over a range of frames of a pixel, in one row.
//!
//! Mean and variance are in levels and squared levels, `time_constant` is 1/α in frames; the other columns are the
//! fields of [`Statistics`].

use std::io::{self, Write};
use std::ops::Range;

use super::channel_columns;
use super::number::significant;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::statistics::Statistics;

/// Writes header and row: the numbers of the first and last frame, and the statistics over the states between.
pub fn write(out: &mut impl Write, history: &PixelHistory, range: Range<usize>) -> io::Result<()> {
    let statistics = Statistics::new(history, range.clone());
    let end = range.end.min(history.states.len());
    let ends =
        [range.start, end.saturating_sub(1)].map(|at| history.states.get(at).map_or(0, |state| state.number));
    let channels = history.parameters.channels();
    writeln!(
        out,
        "from,to,frames,{},{},foreground,births,replacements,mean_background_count,most_background_count,used,time_constant",
        channel_columns("mean", channels),
        channel_columns("variance", channels)
    )?;
    write!(out, "{},{},{}", ends[0], ends[1], statistics.frames)?;
    for values in [statistics.mean, statistics.variance] {
        for value in &values[..channels] {
            write!(out, ",{}", significant(*value))?;
        }
    }
    writeln!(
        out,
        ",{},{},{},{},{},{},{}",
        statistics.foreground,
        statistics.births,
        statistics.replacements,
        significant(statistics.mean_modes),
        statistics.most_modes,
        statistics.used,
        significant(1.0 / history.parameters.alpha)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings, Space};

    fn table(settings: &Settings, range: Range<usize>) -> Vec<String> {
        let colours = (1..=10).map(|n| (n + 100, if n == 10 { [200, 0, 0] } else { [20, 40, 60] }));
        let history = PixelHistory::of_colours((1, 2), Parameters::new(settings), colours);
        written(|out| write(out, &history, range)).lines().map(str::to_owned).collect()
    }

    #[test]
    fn a_row_equals_the_statistics() {
        let rows = table(&Settings { alpha: 0.01, ..Settings::preset(Preset::Plain) }, 0..10);
        assert_eq!(
            rows[0],
            "from,to,frames,mean_r,mean_g,mean_b,variance_r,variance_g,variance_b,foreground,births,replacements,\
             mean_background_count,most_background_count,used,time_constant"
        );
        assert_eq!(rows[1], "101,110,10,38,36,54,2916,144,324,1,2,0,1,1,2,100");
        assert_eq!(rows.len(), 2);
    }

    #[test]
    fn gray_has_one_mean_and_a_range_has_its_own_frames() {
        let gray = Settings { alpha: 0.01, space: Space::Gray, ..Settings::preset(Preset::Plain) };
        let rows = table(&gray, 2..5);
        assert!(rows[0].starts_with("from,to,frames,mean,variance,foreground"));
        assert!(rows[1].starts_with("103,105,3,36,0,0,0,0,1,1,1,100"), "{}", rows[1]);
    }
}
