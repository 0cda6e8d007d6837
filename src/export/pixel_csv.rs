//! One pixel's mixture at every frame, a frame a row.

use std::io::{self, Write};

use super::number::significant;
use crate::mixture::{Parameters, PixelState};

/// Writes the header for these parameters.
pub fn write_header(out: &mut impl Write, parameters: &Parameters) -> io::Result<()> {
    let channels = |name: &str| match parameters.channels() {
        3 => format!("{name}_r,{name}_g,{name}_b"),
        _ => name.to_owned(),
    };
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
        significant(outcome.rho.into()),
        significant(outcome.p.into()),
    )?;
    for component in state.pixel.components() {
        write!(out, ",{}", significant(component.weight.into()))?;
        for &mean in &component.mean[..channels] {
            write!(out, ",{}", significant(mean.into()))?;
        }
        write!(out, ",{}", significant(component.variance.into()))?;
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::mixture::PixelHistory;
    use crate::settings::{Preset, Settings, Space};

    fn table(settings: &Settings, colours: &[[u8; 3]]) -> Vec<String> {
        let parameters = Parameters::new(settings);
        let history = PixelHistory::of_colours((0, 0), parameters, (1..).zip(colours.iter().copied()));
        let mut text = Vec::new();
        write_header(&mut text, &parameters).unwrap();
        for state in &history.states {
            write_row(&mut text, &parameters, state).unwrap();
        }
        String::from_utf8(text).unwrap().lines().map(str::to_owned).collect()
    }

    #[test]
    fn rgb_has_three_columns_a_value_and_a_mean() {
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
    fn gray_has_one() {
        let settings = Settings { k: 1, space: Space::Gray, ..Settings::preset(Preset::Plain) };
        let rows = table(&settings, &[[10, 10, 10]]);
        assert_eq!(rows[0], "frame,value,matched,rank,background_count,foreground,rho,p,w1,mu1,var1");
        assert_eq!(rows[1], "1,10,0,1,1,0,0,0,1,10,400");
    }
}
