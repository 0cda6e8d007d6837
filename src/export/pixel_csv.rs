//! The mixture of one pixel, one frame per row.
//!
//! Columns: the frame number, the value X (levels), `matched` (rank before the update, 0 if none), `rank` (after it),
//! `background_count` (B), `foreground` (0 or 1), `rho`, `p`, and for each component in rank order `w`, `mu` (levels)
//! and `var` (squared levels).

use std::io::{self, Write};

use super::channel_columns;
use super::number::significant;
use crate::explain::pixel::{PixelHistory, PixelState};
use crate::mixture::Parameters;

/// Writes the header for these parameters.
pub fn write_header(out: &mut impl Write, parameters: &Parameters) -> io::Result<()> {
    let channels = |name: &str| channel_columns(name, parameters.channels());
    write!(out, "frame,{},matched,rank,background_count,foreground,rho,p", channels("value"))?;
    for k in 1..=parameters.k {
        write!(out, ",w{k},{},var{k}", channels(&format!("mu{k}")))?;
    }
    writeln!(out)
}

/// Writes the row of one frame: the state after its update, in rank order.
pub fn write_row(out: &mut impl Write, parameters: &Parameters, state: &PixelState) -> io::Result<()> {
    let channels = parameters.channels();
    let outcome = &state.outcome;
    write!(out, "{}", state.number)?;
    for value in &state.value[..channels] {
        write!(out, ",{value}")?;
    }
    write!(
        out,
        ",{},{},{},{},{},{}",
        outcome.matched,
        outcome.rank,
        outcome.background_count,
        u8::from(outcome.foreground),
        significant(outcome.rho),
        significant(outcome.p),
    )?;
    for component in state.pixel.components() {
        write!(out, ",{}", significant(component.weight))?;
        for &mean in &component.mean[..channels] {
            write!(out, ",{}", significant(mean))?;
        }
        write!(out, ",{}", significant(component.variance))?;
    }
    writeln!(out)
}

/// Writes several pixels in sequence, with the pixel's number and coordinates before every row. All have the
/// parameters of the first.
pub fn write_pins(out: &mut impl Write, pins: &[(u8, &PixelHistory)]) -> io::Result<()> {
    let Some((_, first)) = pins.first() else { return Ok(()) };
    write!(out, "pin,x,y,")?;
    write_header(out, &first.parameters)?;
    for (pin, history) in pins {
        let (x, y) = history.source_pixel();
        for state in &history.states {
            write!(out, "{pin},{x},{y},")?;
            write_row(out, &first.parameters, state)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::settings::{Preset, Settings, Space};

    fn table(settings: &Settings, colours: &[[u8; 3]]) -> Vec<String> {
        let parameters = Parameters::new(settings);
        let history = PixelHistory::of_colours((0, 0), parameters, (1..).zip(colours.iter().copied()));
        let text = written(|out| {
            write_header(out, &parameters)?;
            history.states.iter().try_for_each(|state| write_row(out, &parameters, state))
        });
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn rgb_has_three_columns_per_value_and_mean() {
        let settings = Settings { k: 2, ..Settings::preset(Preset::Plain) };
        let rows = table(&settings, &[[10, 20, 30], [10, 20, 30], [200, 20, 30]]);
        assert_eq!(
            rows[0],
            "frame,value_r,value_g,value_b,matched,rank,background_count,foreground,rho,p,\
             w1,mu1_r,mu1_g,mu1_b,var1,w2,mu2_r,mu2_g,mu2_b,var2"
        );
        assert_eq!(rows[1], "1,10,20,30,0,1,1,0,0,0,1,10,20,30,400,0,0,0,0,0");
        // ρ = α / 1, σ² = 0.99·400; p = 1 / (2π·400)^(3/2).
        assert!(rows[2].starts_with("2,10,20,30,1,1,1,0,0.00999999978,7.9367"), "{}", rows[2]);
        assert!(rows[3].starts_with("3,200,20,30,0,2,1,1,0,"), "{}", rows[3]);
    }

    #[test]
    fn rows_of_pins_begin_with_number_and_coordinates() {
        let parameters = Parameters::new(&Settings { k: 1, ..Settings::preset(Preset::Plain) });
        let of = |at, level| PixelHistory::of_colours(at, parameters, (1..=2).map(|n| (n, [level; 3])));
        let (one, other) = (of((3, 4), 90), of((70, 8), 20));
        let text = written(|out| write_pins(out, &[(1, &one), (4, &other)]));
        let rows: Vec<_> = text.lines().collect();
        assert_eq!(rows.len(), 5);
        assert!(rows[0].starts_with("pin,x,y,frame,value_r,value_g,value_b,matched"), "{}", rows[0]);
        assert!(rows[2].starts_with("1,3,4,2,90,90,90,1,"), "{}", rows[2]);
        assert!(rows[3].starts_with("4,70,8,1,20,20,20,0,"), "{}", rows[3]);
        assert!(rows.iter().all(|row| row.matches(',').count() == rows[0].matches(',').count()));
        assert_eq!(written(|out| write_pins(out, &[])), "");
    }

    #[test]
    fn gray_has_one_column_per_value_and_mean() {
        let settings = Settings { k: 1, space: Space::Gray, ..Settings::preset(Preset::Plain) };
        let rows = table(&settings, &[[10, 10, 10]]);
        assert_eq!(rows[0], "frame,value,matched,rank,background_count,foreground,rho,p,w1,mu1,var1");
        assert_eq!(rows[1], "1,10,0,1,1,0,0,0,1,10,400");
    }
}
