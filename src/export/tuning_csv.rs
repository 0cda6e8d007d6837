//! Results for a pixel or a region under other settings, one cell of the grid per row.
//!
//! The first two columns are the values of the two settings; `foreground` (0 or 1) follows for a pixel, and
//! `tp,fp,fn,tn,right,f_measure` for a region, `right` being the accuracy.

use std::io::{self, Write};

use super::number::significant;
use crate::explain::tuning::{SettingAxis, VerdictMap};
use crate::truth::decisions::Decisions;

/// Writes a map: 1 where the pixel is foreground, else 0.
pub fn write_map(out: &mut impl Write, map: &VerdictMap) -> io::Result<()> {
    header(out, &map.axes, "foreground")?;
    each(&map.axes, |column, row, values| {
        writeln!(out, "{values},{}", u8::from(map.is_foreground(column, row)))
    })
}

/// Writes the decisions of each cell, row by row, and the measures computed from them.
pub fn write_decisions(out: &mut impl Write, axes: &[SettingAxis; 2], cells: &[Decisions]) -> io::Result<()> {
    header(out, axes, "tp,fp,fn,tn,right,f_measure")?;
    let mut cells = cells.iter();
    each(axes, |_, _, values| {
        let decisions = cells.next().copied().unwrap_or_default();
        let Decisions { tp, fp, fn_, tn } = decisions;
        let (right, f_measure) = (significant(decisions.right()), significant(decisions.f_measure()));
        writeln!(out, "{values},{tp},{fp},{fn_},{tn},{right},{f_measure}")
    })
}

fn header(out: &mut impl Write, [x, y]: &[SettingAxis; 2], columns: &str) -> io::Result<()> {
    writeln!(out, "{},{},{columns}", x.setting.key(), y.setting.key())
}

/// Calls `write` with each cell: its column, its row, and the values of both settings.
fn each(
    [x, y]: &[SettingAxis; 2],
    mut write: impl FnMut(usize, usize, String) -> io::Result<()>,
) -> io::Result<()> {
    for (row, &up) in y.values.iter().enumerate() {
        for (column, &across) in x.values.iter().enumerate() {
            // The shortest number from which the value is restored exactly.
            let values = format!("{across},{up}");
            write(column, row, values)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::explain::tuning::{TunableSetting, grid, map};
    use crate::export::tests::written;
    use crate::mixture::Parameters;
    use crate::settings::Settings;

    #[test]
    fn each_cell_has_a_row_with_exact_values() {
        let parameters = Parameters::new(&Settings::default());
        let values: Vec<_> = (0..40).map(|n| [if n > 36 { 200.0 } else { 60.0 }; 3]).collect();
        let map = map(&values, &parameters, [TunableSetting::Alpha, TunableSetting::K]);
        let text = written(|out| write_map(out, &map));
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("alpha,k,foreground"));
        for (row, &k) in map.axes[1].values.iter().enumerate() {
            for (column, alpha) in map.axes[0].values.iter().enumerate() {
                let cells: Vec<&str> = lines.next().unwrap().split(',').collect();
                assert_eq!(cells[0].parse::<f32>().unwrap().to_bits(), alpha.to_bits());
                assert_eq!(
                    (cells[1], cells[2]),
                    (&*k.to_string(), if map.is_foreground(column, row) { "1" } else { "0" })
                );
            }
        }
        assert_eq!(lines.next(), None);

        let (axes, cells) = grid(&parameters, [TunableSetting::K, TunableSetting::T]);
        let decisions = vec![Decisions { tp: 1, fp: 1, fn_: 0, tn: 2 }; cells.len()];
        let text = written(|out| write_decisions(out, &axes, &decisions));
        assert_eq!(text.lines().count(), 1 + cells.len());
        assert!(text.starts_with("k,t,tp,fp,fn,tn,right,f_measure\n1,"));
        assert!(text.lines().skip(1).all(|line| line.ends_with(",1,1,0,2,0.75,0.666666667")));
    }
}
