//! The pages of a TIFF file, each without reading the others.
//!
//! A file is a chain of directories, one for each image. Decoders start at the directory in the header:
//! [`PageReader`] shows them the file with the directory of a page there.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// The tag of the kind of an image, and the kinds that are no pages: a smaller copy, and a mask of another image.
const KIND_TAG: u64 = 254;
const NO_PAGE: u64 = 0b101;

/// Largest number of entries of a directory.
const MAX_ENTRIES: u64 = 65_535;

/// Whether a file starts as TIFF files do.
pub(super) fn is_tiff(path: &Path) -> bool {
    File::open(path).and_then(|file| Header::read(&mut BufReader::new(file))).is_ok()
}

/// The pages of a TIFF file.
pub(super) struct Pages {
    /// The place of the directory of each page in the file.
    pub(super) directories: Vec<u64>,
    /// Whether the file ends before its last directory, so that pages are missing.
    pub(super) is_cut_off: bool,
}

/// Finds up to `most` pages of a TIFF file. Images that are smaller copies or masks of others are no pages.
pub(super) fn pages(path: &Path, most: usize) -> io::Result<Pages> {
    let mut file = BufReader::new(File::open(path)?);
    let header = Header::read(&mut file)?;
    let mut found = Pages { directories: Vec::new(), is_cut_off: false };
    let mut seen = HashSet::new();
    let mut at = header.first;
    // A damaged file may be a chain without an end.
    while at != 0 && found.directories.len() < most && seen.insert(at) {
        match header.directory(&mut file, at) {
            Ok((is_page, next)) => {
                found.directories.extend(is_page.then_some(at));
                at = next;
            }
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                found.is_cut_off = true;
                at = 0;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(found)
}

/// The header of a TIFF file, whose numbers have one of two orders of bytes and one of two lengths.
struct Header {
    is_big_endian: bool,
    /// Whether places and counts have 8 bytes, as in files of more than 4 GiB.
    is_long: bool,
    /// The place of the first directory.
    first: u64,
}

impl Header {
    fn read(file: &mut impl Read) -> io::Result<Self> {
        let mut start = [0; 4];
        file.read_exact(&mut start)?;
        let (is_big_endian, is_long) = match &start {
            b"II*\0" => (false, false),
            b"MM\0*" => (true, false),
            b"II+\0" => (false, true),
            b"MM\0+" => (true, true),
            _ => return Err(io::Error::new(ErrorKind::InvalidData, "it is no TIFF file")),
        };
        let mut header = Self { is_big_endian, is_long, first: 0 };
        if is_long {
            // The length of places, always 8.
            header.number(file, 4)?;
        }
        header.first = header.place(file)?;
        Ok(header)
    }

    /// Whether the directory at a place is that of a page, and the place of the next; 0 where there is none.
    fn directory(&self, file: &mut (impl Read + Seek), at: u64) -> io::Result<(bool, u64)> {
        file.seek(SeekFrom::Start(at))?;
        let entries = self.number(file, if self.is_long { 8 } else { 2 })?;
        if entries > MAX_ENTRIES {
            return Err(io::Error::new(ErrorKind::InvalidData, "a directory in it is damaged"));
        }
        let mut is_page = true;
        for _ in 0..entries {
            let (tag, kind) = (self.number(file, 2)?, self.number(file, 2)?);
            self.place(file)?;
            let mut value = [0; 8];
            let value = &mut value[..self.place_length()];
            file.read_exact(value)?;
            // Kind 3 has 2 bytes, kind 4 has 4.
            let length = if kind == 3 { 2 } else { 4 };
            if tag == KIND_TAG && self.number(&mut &value[..], length)? & NO_PAGE != 0 {
                is_page = false;
            }
        }
        Ok((is_page, self.place(file)?))
    }

    const fn place_length(&self) -> usize {
        if self.is_long { 8 } else { 4 }
    }

    fn place(&self, file: &mut impl Read) -> io::Result<u64> {
        self.number(file, self.place_length())
    }

    fn number(&self, file: &mut impl Read, length: usize) -> io::Result<u64> {
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..length];
        file.read_exact(bytes)?;
        if !self.is_big_endian {
            bytes.reverse();
        }
        Ok(bytes.iter().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }
}

/// A TIFF file whose first directory is that of a page.
pub(super) struct PageReader {
    /// The file, at the position or behind the header.
    file: BufReader<File>,
    header: Vec<u8>,
    position: u64,
}

impl PageReader {
    /// The file with the directory at this place as the first.
    pub(super) fn open(path: &Path, directory: u64) -> io::Result<Self> {
        let mut file = BufReader::new(File::open(path)?);
        let header = Header::read(&mut file)?;
        let length = header.place_length();
        let mut bytes = vec![0; 2 * length];
        file.rewind()?;
        file.read_exact(&mut bytes)?;
        let place = if header.is_big_endian {
            directory.to_be_bytes()[8 - length..].to_vec()
        } else {
            directory.to_le_bytes()[..length].to_vec()
        };
        bytes.splice(length.., place);
        Ok(Self { file, header: bytes, position: 0 })
    }
}

impl Read for PageReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl BufRead for PageReader {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match self.header.get(self.position as usize..) {
            Some(rest) if !rest.is_empty() => Ok(rest),
            _ => self.file.fill_buf(),
        }
    }

    fn consume(&mut self, read: usize) {
        if self.position >= self.header.len() as u64 {
            self.file.consume(read);
        }
        self.position += read as u64;
    }
}

impl Seek for PageReader {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let to = match to {
            SeekFrom::Current(by) => {
                let before = || io::Error::new(ErrorKind::InvalidInput, "a position before the start");
                SeekFrom::Start(self.position.checked_add_signed(by).ok_or_else(before)?)
            }
            to => to,
        };
        self.position = self.file.seek(to)?;
        if self.position < self.header.len() as u64 {
            self.file.seek(SeekFrom::Start(self.header.len() as u64))?;
        }
        Ok(self.position)
    }
}
