//! What the name of a source refers to.

use std::fs;
use std::io::ErrorKind;

use super::{Options, SourceError, path_of, shown, tiff_pages, video};

/// The prefix of the name of a camera.
pub(super) const CAMERA: &str = "camera:";

/// A kind of source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// A camera of this machine.
    Camera,
    /// The address of a network stream.
    Network,
    /// A printf pattern of images.
    Pattern,
    /// A folder of images, or of a data set's sequence.
    Folder,
    /// A TIFF file of several pages.
    Pages,
    /// A video file.
    Video,
}

impl SourceKind {
    /// The kind of the source of this name. Fails where there is nothing of this name, or neither a file nor a folder.
    pub fn of(name: &str) -> Result<Self, SourceError> {
        let path = path_of(name);
        // A file can have such a name, too.
        if let Some(index) = name.strip_prefix(CAMERA)
            && (index.parse::<u32>().is_ok() || !path.exists())
        {
            return Ok(Self::Camera);
        }
        if video::is_address(name) {
            return Ok(Self::Network);
        }
        match fs::metadata(&path) {
            Ok(metadata) if metadata.is_dir() => Ok(Self::Folder),
            Ok(metadata) if metadata.is_file() && tiff_pages::is_tiff(&path) => Ok(Self::Pages),
            Ok(metadata) if metadata.is_file() => Ok(Self::Video),
            Ok(_) => {
                let why = "it is neither a file nor a folder; cameras are camera:0, camera:1, …";
                Err(SourceError::unusable(name, why))
            }
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                if name.contains('%') {
                    Ok(Self::Pattern)
                } else {
                    Err(SourceError::Missing(shown(name).into_owned()))
                }
            }
            Err(error) => Err(SourceError::unusable(name, format!("{error}; check its permissions"))),
        }
    }

    /// Whether the source consists of images, whose levels can be chosen.
    pub const fn is_images(self) -> bool {
        matches!(self, Self::Pattern | Self::Folder | Self::Pages)
    }

    /// Whether the source has streams of pictures, which can be selected and deinterlaced.
    pub const fn is_video(self) -> bool {
        matches!(self, Self::Video | Self::Network)
    }

    /// Fails where an option is given that a source of this kind does not have.
    pub(super) fn check(self, name: &str, options: Options) -> Result<(), SourceError> {
        let why = if let Some(flag) = options.flag_of_videos().filter(|_| !self.is_video()) {
            let kind = if self.is_images() { "images" } else { "cameras" };
            format!("{flag} is for video files, not for {kind}; leave it out")
        } else if options.levels.is_some() && !self.is_images() {
            // Stretching levels of 8 bits would only leave gaps between them.
            let remedy = if self == Self::Video { "convert it to 16-bit images, or omit" } else { "omit" };
            format!("--levels is for images, and video is decoded to 8 bits; {remedy} --levels")
        } else {
            return Ok(());
        };
        Err(SourceError::unusable(name, why))
    }
}
