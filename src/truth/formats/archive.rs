//! The file of tracks in a ZIP archive, as CVAT exports it: "MOT 1.1" or "CVAT for video 1.1".

use std::io::{Cursor, Read};

use zip::ZipArchive;

/// The first bytes of an archive.
const START: &[u8] = b"PK\x03\x04";
/// Largest number of bytes of a file that is unpacked: a small archive can be of any size.
const MAX_BYTES: u64 = 256 << 20;
/// What is read of an archive.
const EXPECTED: &str = "gt/gt.txt of \"MOT 1.1\" or annotations.xml of \"CVAT for video 1.1\"";

/// The file of tracks in an archive.
#[derive(Debug)]
pub(super) struct ArchivedTracks {
    pub bytes: Vec<u8>,
    /// Whether the classes are those of a `labels.txt` beside it.
    pub has_labels: bool,
}

/// Whether a file is a ZIP archive.
pub(super) fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(START)
}

/// Unpacks the only file of tracks in an archive. Fails if there are several, if it is damaged or too large.
pub(super) fn tracks(bytes: &[u8]) -> Result<ArchivedTracks, String> {
    unpack(bytes, MAX_BYTES)
}

fn unpack(bytes: &[u8], max_bytes: u64) -> Result<ArchivedTracks, String> {
    let damaged = |error: &dyn std::fmt::Display| {
        format!("it is a zip archive that cannot be unpacked ({error}); unpack it and give {EXPECTED}")
    };
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    let is_named = |path: &str, name: &str| path == name || path.ends_with(&format!("/{name}"));
    let is_tracks = |path: &&str| ["gt/gt.txt", "annotations.xml"].iter().any(|name| is_named(path, name));
    let paths: Vec<String> = archive.file_names().filter(is_tracks).map(str::to_owned).collect();
    let path = match &paths[..] {
        [path] => path,
        [] => return Err(format!("it is a zip archive without {EXPECTED}; export it as one of these")),
        several => {
            let count = several.len();
            return Err(format!("it is a zip archive of {count} files of tracks; unpack it and give one"));
        }
    };
    let folder = path.strip_suffix("gt.txt");
    let has_labels =
        folder.is_some_and(|folder| archive.index_for_name(&format!("{folder}labels.txt")).is_some());
    let file = archive.by_name(path).map_err(|error| damaged(&error))?;
    let mut bytes = Vec::new();
    file.take(max_bytes + 1).read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
    if bytes.len() as u64 > max_bytes {
        return Err(format!("{path} in it has more than {} MiB; give a part of it", max_bytes >> 20));
    }
    Ok(ArchivedTracks { bytes, has_labels })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::io::Write;

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;

    fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in files {
            writer.start_file(*name, SimpleFileOptions::default()).unwrap();
            writer.write_all(bytes).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    #[test]
    fn the_file_of_tracks_is_unpacked_with_a_bound() {
        let text = b"1,1,0,0,5,5,1,1,1\n".repeat(90);
        let packed = archive(&[("gt/gt.txt", &text), ("gt/labels.txt", b"car")]);
        assert!(is_archive(&packed) && packed.len() < text.len(), "it is compressed");
        let unpacked = tracks(&packed).unwrap();
        assert_eq!((unpacked.bytes.len(), unpacked.has_labels), (text.len(), true));
        let unpacked = tracks(&archive(&[("a/annotations.xml", &text), ("labels.txt", b"")])).unwrap();
        assert_eq!((unpacked.bytes, unpacked.has_labels), (text.clone(), false));
        let size = text.len() as u64;
        assert!(unpack(&packed, size).is_ok());
        for (bytes, max_bytes, word) in [
            (packed.clone(), size - 1, "gt/gt.txt in it has more than"),
            (packed[..packed.len() / 2].to_vec(), size, "cannot be unpacked"),
            (archive(&[("other/gt2.txt", &text)]), size, "without gt/gt.txt"),
            (archive(&[("a/gt/gt.txt", &text), ("b/gt/gt.txt", &text)]), size, "2 files of tracks"),
        ] {
            let why = unpack(&bytes, max_bytes).unwrap_err();
            assert!(why.contains(word) && !why.contains('\n'), "{why}");
        }
    }
}
