//! The mixtures of an image as arrays of NumPy in one `.npz` file: `mean` (K × height × width × channels, in levels),
//! `variance` (K × height × width, in squared levels) and `weight` (K × height × width), in rank order. Unused components
//! are 0.

use std::io::{self, Write};

use super::npy::Array;
use super::zip;
use crate::mixture::Mixture;

/// Writes the arrays.
pub fn write(out: &mut impl Write, mixture: &Mixture) -> io::Result<()> {
    let (size, k, channels) = (mixture.size(), mixture.parameters().k, mixture.parameters().channels());
    let (height, width) = (size.height as usize, size.width as usize);
    let mut mean = Array::zeros(&[k, height, width, channels]);
    let [mut variance, mut weight] = [(); 2].map(|()| Array::zeros(&[k, height, width]));
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    for (pixel, at) in pixels.filter_map(|(x, y)| mixture.pixel(x, y)).zip(0..) {
        for (component, rank) in pixel.components().iter().zip(0..) {
            let index = rank * size.pixels() + at;
            variance.set(index, component.variance);
            weight.set(index, component.weight);
            for (channel, &value) in component.mean[..channels].iter().enumerate() {
                mean.set(index * channels + channel, value);
            }
        }
    }
    let files =
        [("mean.npy", mean.bytes()), ("variance.npy", variance.bytes()), ("weight.npy", weight.bytes())];
    zip::write(out, &files)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::export::zip::tests::contents;
    use crate::frame::{Frame, Size};
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings, Space};

    /// The shape in the header of an array, and its values.
    fn array(bytes: &[u8]) -> (String, Vec<f32>) {
        let header = String::from_utf8(bytes[10..128].to_vec()).unwrap();
        let shape = header.split_once("'shape': (").unwrap().1.split_once(')').unwrap().0.to_owned();
        let values = bytes[128..].chunks(4).map(|value| f32::from_le_bytes(value.try_into().unwrap()));
        (shape, values.collect())
    }

    #[test]
    fn arrays_have_the_components_of_each_pixel() {
        let size = Size::new(5, 4);
        for (space, channels) in [(Space::Rgb, 3), (Space::Gray, 1)] {
            let settings = Settings { k: 2, space, ..Settings::preset(Preset::Plain) };
            let mut mixture = Mixture::new(size, Parameters::new(&settings));
            for (number, factor) in [(1, 1), (2, 1), (3, 12)] {
                let rgb = (0..size.pixels() * 3).map(|at| (at * factor) as u8).collect();
                mixture.step(&Frame::new(number, size, rgb));
            }
            let mut bytes = Vec::new();
            write(&mut bytes, &mixture).unwrap();
            let files = contents(&bytes);
            let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
            assert_eq!(names, ["mean.npy", "variance.npy", "weight.npy"]);
            let arrays: Vec<_> = files.iter().map(|(_, bytes)| array(bytes)).collect();
            assert_eq!(arrays[0].0, format!("2, 4, 5, {channels}, "));
            assert_eq!((arrays[1].0.as_str(), arrays[2].0.as_str()), ("2, 4, 5, ", "2, 4, 5, "));
            let (mut index, mut used) = (0, 0);
            for rank in 0..2 {
                for (x, y) in (0..4).flat_map(|y| (0..5).map(move |x| (x, y))) {
                    let component = mixture.pixel(x, y).unwrap().components()[rank];
                    assert_eq!(arrays[0].1[index * channels..][..channels], component.mean[..channels]);
                    assert_eq!(
                        (arrays[1].1[index], arrays[2].1[index]),
                        (component.variance, component.weight)
                    );
                    used += usize::from(rank == 1 && component.weight > 0.0);
                    index += 1;
                }
            }
            assert_eq!(index, arrays[1].1.len());
            assert!(used > 5, "second components");
        }
    }
}
