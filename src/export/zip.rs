//! ZIP files of stored, uncompressed files, with the format's zero date.

use std::io::{self, Write};

/// 1980-01-01, the first date of the format.
const DATE: u16 = (1 << 5) | 1;
/// The version of the format that is needed to read stored files.
const VERSION: u16 = 10;

/// Writes files, given by name and contents. Fails where the sum of them exceeds the format's 4 GiB.
pub fn write(out: &mut impl Write, files: &[(&str, &[u8])]) -> io::Result<()> {
    let mut written: u32 = 0;
    let mut directory = Vec::new();
    for (name, bytes) in files {
        let mut header = Vec::new();
        // Flags: the name is UTF-8. Method: stored. Time 0:00.
        for field in [VERSION, 1 << 11, 0, 0, DATE] {
            header.extend(field.to_le_bytes());
        }
        let size = small(bytes.len())?;
        for field in [crc32fast::hash(bytes), size, size, u32::from(shorter(name.len())?)] {
            header.extend(field.to_le_bytes());
        }
        let local = [b"PK\x03\x04", &header[..], name.as_bytes()].concat();
        directory.extend([b"PK\x01\x02", &VERSION.to_le_bytes()[..], &header].concat());
        // No comment, on the first disk, attributes 0, the place of the local header.
        directory.extend([0; 10]);
        directory.extend(written.to_le_bytes());
        directory.extend(name.as_bytes());
        out.write_all(&local)?;
        out.write_all(bytes)?;
        written = small(written as usize + local.len() + bytes.len())?;
    }
    out.write_all(&directory)?;
    let count = shorter(files.len())?.to_le_bytes();
    out.write_all(b"PK\x05\x06\0\0\0\0")?;
    out.write_all(&[count, count].concat())?;
    out.write_all(&small(directory.len())?.to_le_bytes())?;
    out.write_all(&written.to_le_bytes())?;
    out.write_all(&[0; 2])
}

fn small(length: usize) -> io::Result<u32> {
    u32::try_from(length).map_err(|_| io::Error::other("it would exceed 4 GiB, the limit of ZIP files"))
}

fn shorter(length: usize) -> io::Result<u16> {
    u16::try_from(length).map_err(|_| io::Error::other("it would exceed 65535, a limit of ZIP files"))
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn number(bytes: &[u8], at: usize, length: usize) -> usize {
        bytes[at..at + length].iter().rev().fold(0, |number, &byte| (number << 8) | usize::from(byte))
    }

    /// The names and contents of the files of a ZIP file, by its directory; each local header must agree with it.
    pub(crate) fn contents(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
        let end = bytes.len() - 22;
        assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
        let (count, length) = (number(bytes, end + 10, 2), number(bytes, end + 12, 4));
        let mut entry = number(bytes, end + 16, 4);
        assert_eq!(entry + length, end);
        let mut files = Vec::new();
        for _ in 0..count {
            assert_eq!(&bytes[entry..entry + 4], b"PK\x01\x02");
            let local = number(bytes, entry + 42, 4);
            assert_eq!(&bytes[local..local + 4], b"PK\x03\x04");
            assert_eq!(bytes[local + 4..local + 30], bytes[entry + 6..entry + 32]);
            let (size, name) = (number(bytes, local + 18, 4), number(bytes, local + 26, 2));
            assert_eq!(bytes[local + 30..local + 30 + name], bytes[entry + 46..entry + 46 + name]);
            let data = &bytes[local + 30 + name..local + 30 + name + size];
            assert_eq!(number(bytes, local + 14, 4), crc32fast::hash(data) as usize);
            let path = String::from_utf8(bytes[local + 30..local + 30 + name].to_vec()).unwrap();
            files.push((path, data.to_vec()));
            entry += 46 + name;
        }
        assert_eq!(entry, end);
        files
    }

    #[test]
    fn files_are_read_back() {
        let mut bytes = Vec::new();
        write(&mut bytes, &[("a/ü.txt", b"123456789"), ("empty", b"")]).unwrap();
        let expected = [("a/ü.txt", "123456789"), ("empty", "")];
        assert_eq!(contents(&bytes), expected.map(|(name, text)| (name.to_owned(), text.into())));
        assert_eq!(number(&bytes, 14, 4), 0xCBF4_3926, "the check value of this CRC");
        bytes.clear();
        write(&mut bytes, &[]).unwrap();
        assert_eq!(bytes.len(), 22);
    }
}
