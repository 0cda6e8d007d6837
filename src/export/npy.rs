//! Arrays as files of NumPy: `.npy`, version 1.0, 32-bit floats of low byte first, in C order.

/// The alignment of the data, in bytes.
const ALIGNMENT: usize = 64;

/// An array, as the bytes of its file.
pub struct Array {
    bytes: Vec<u8>,
    /// The place of the first value.
    start: usize,
}

impl Array {
    /// An array of zeros.
    pub fn zeros(shape: &[usize]) -> Self {
        let sides: String = shape.iter().map(|side| side.to_string() + ", ").collect();
        let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({sides}), }}");
        // Magic bytes, version and length take ten bytes, the end of the line one.
        let padding = (header.len() + 11).next_multiple_of(ALIGNMENT) - header.len() - 11;
        header.extend(std::iter::repeat_n(' ', padding));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.into_bytes());
        let start = bytes.len();
        bytes.resize(start + 4 * shape.iter().product::<usize>(), 0);
        Self { bytes, start }
    }

    /// Sets the value at an index in C order, which must be within the array.
    pub fn set(&mut self, index: usize, value: f32) {
        let at = self.start + 4 * index;
        self.bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_has_type_and_shape_and_aligns_the_data() {
        let mut array = Array::zeros(&[2, 3]);
        array.set(4, 1.5);
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, ), }";
        let bytes = array.bytes();
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(bytes[10..10 + header.len()], *header.as_bytes());
        assert!(bytes[10 + header.len()..127].iter().all(|&byte| byte == b' '));
        assert_eq!((bytes[127], bytes.len()), (b'\n', 128 + 24));
        assert_eq!(bytes[128 + 16..128 + 20], 1.5_f32.to_le_bytes());
        assert_eq!(Array::zeros(&[]).bytes().len(), 128 + 4, "a single number");
    }
}
