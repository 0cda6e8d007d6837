//! FFmpeg's encoders of the two kinds of video, and how they are set.

use ffmpeg::codec::{Context, Flags};
use ffmpeg::encoder::video::Encoder;
use ffmpeg::filter::{self, Graph};
use ffmpeg::format::Pixel;
use ffmpeg::util::color;
use ffmpeg::{Dictionary, Rational, encoder};

use crate::frame::Size;

/// What a video is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VideoKind {
    /// Playback, also in browsers: MP4 with H.264 High, 4:2:0 chroma, BT.709 in limited range; MPEG-4 part 2, which browsers do
    /// not play, where there is no encoder for H.264.
    Playback,
    /// The exact bits of the frames: AVI, which has a constant frame rate, with FFV1 in RGB.
    Lossless,
}

impl VideoKind {
    /// The ending of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Playback => "mp4",
            Self::Lossless => "avi",
        }
    }

    /// The names of its encoders, the better first.
    pub(super) fn encoders(self) -> &'static [&'static str] {
        match self {
            Self::Playback => &["libx264", "libopenh264", MPEG4],
            Self::Lossless => &[FFV1],
        }
    }

    /// The name of its best encoder.
    pub(super) fn best_encoder(self) -> &'static str {
        self.encoders()[0]
    }

    /// The size of the encoder's pictures: 4:2:0 chroma needs even sides.
    pub(super) fn encoded_size(self, size: Size) -> Size {
        match self {
            Self::Playback => Size::new(size.width.next_multiple_of(2), size.height.next_multiple_of(2)),
            Self::Lossless => size,
        }
    }

    fn pixel_format(self) -> Pixel {
        match self {
            Self::Playback => Pixel::YUV420P,
            Self::Lossless => Pixel::BGRZ,
        }
    }

    /// The steps from RGB to the encoder's pixel format, in the language of FFmpeg's filters.
    fn conversion(self) -> &'static str {
        match self {
            Self::Playback => {
                "[in]scale=flags=bicubic+accurate_rnd:out_color_matrix=bt709:out_range=limited,\
                 format=pix_fmts=yuv420p[out]"
            }
            Self::Lossless => "[in]format=pix_fmts=bgr0[out]",
        }
    }
}

/// FFmpeg's own encoder of MPEG-4 part 2.
pub(super) const MPEG4: &str = "mpeg4";
/// FFmpeg's own encoder of FFV1.
const FFV1: &str = "ffv1";

/// Least number of ticks per second: the clock of MPEG, finer than the milliseconds of Matroska.
const MIN_TICKS: i32 = 90_000;
/// Largest number of ticks per second in MPEG-4 part 2.
const MAX_MPEG4_TICKS: i32 = 65_535;

/// The rate as a fraction: whole, of NTSC, over at most 100 seconds (as where every third frame is taken), or in
/// thousandths.
pub(super) fn rate(fps: f32) -> Rational {
    let frames_in = |seconds: i32| f64::from(fps) * f64::from(seconds);
    // An f32 has seven digits.
    let is_whole = |frames: f64| (frames - frames.round()).abs() < 1e-7 * frames;
    let seconds =
        [1, 1001].into_iter().chain(2..=100).find(|&seconds| is_whole(frames_in(seconds))).unwrap_or(1000);
    Rational::new((frames_in(seconds).round() as i32).max(1), seconds).reduce()
}

/// The unit of time of an encoder for playback, in seconds, of which a frame at this rate has a whole number.
fn tick(encoder: &str, rate: Rational) -> Rational {
    let frames = rate.numerator();
    let ticks = match encoder {
        MPEG4 if frames > MAX_MPEG4_TICKS => MAX_MPEG4_TICKS,
        MPEG4 => MAX_MPEG4_TICKS / frames * frames,
        _ => frames.saturating_mul((MIN_TICKS - 1) / frames + 1),
    };
    Rational::new(1, ticks)
}

/// Opens the encoder of this name; it and its unit of time.
pub(super) fn open_encoder(
    kind: VideoKind,
    name: &str,
    size: Size,
    rate: Rational,
    pixel_aspect: Option<(u32, u32)>,
) -> Result<(Encoder, Rational), ffmpeg::Error> {
    let codec = encoder::find_by_name(name).ok_or(ffmpeg::Error::EncoderNotFound)?;
    let tick = match kind {
        VideoKind::Playback => tick(name, rate),
        VideoKind::Lossless => rate.invert(),
    };
    // libx264 refuses a context that was made for any codec.
    let mut video = Context::new_with_codec(codec).encoder().video()?;
    video.set_width(size.width);
    video.set_height(size.height);
    video.set_format(kind.pixel_format());
    video.set_time_base(tick);
    video.set_frame_rate(Some(rate));
    if let Some((width, height)) = pixel_aspect {
        video.set_aspect_ratio(Rational::new(width as i32, height as i32));
    }
    video.set_max_b_frames(0);
    // Both files hold the codec's header once, apart from the frames.
    video.set_flags(Flags::GLOBAL_HEADER);
    let mut options = Dictionary::new();
    if kind == VideoKind::Playback {
        video.set_colorspace(color::Space::BT709);
        video.set_color_range(color::Range::MPEG);
        options.set("color_primaries", "bt709");
        options.set("color_trc", "bt709");
    }
    match name {
        // FFmpeg's slices of a picture two pixels wide lose bits.
        FFV1 if size.shorter_side() < 3 => {}
        FFV1 => {
            // Each slice has a checksum, by which a decoder notices damage.
            options.set("level", "3");
            options.set("slices", "4");
            options.set("slicecrc", "1");
        }
        "libx264" => {
            options.set("profile", "high");
            // Files and quality as with `medium`, the default, in four fifths of the time.
            options.set("preset", "fast");
            // Hardly to be told from the input, also around thin lines and small letters.
            options.set("crf", "18");
            // The bytes depend on the number of threads: the same on any machine.
            options.set("threads", "4");
        }
        MPEG4 => {
            options.set("flags", "+qscale");
            // A quantiser of 2, in FFmpeg's unit of 1/118.
            options.set("global_quality", "236");
        }
        _ => {
            options.set("profile", "high");
            // It has no constant quality: a fifth of a bit per pixel, which suffices for noisy video.
            let bits = 0.2 * size.pixels() as f64 * f64::from(rate);
            options.set("b", bits.clamp(500e3, 100e6).round().to_string());
        }
    }
    Ok((video.open_as_with(codec, options)?, tick))
}

/// Converts RGB to the encoder's pixel format.
pub(super) fn converter(kind: VideoKind, Size { width, height }: Size) -> Result<Graph, ffmpeg::Error> {
    let find = |name| filter::find(name).ok_or(ffmpeg::Error::FilterNotFound);
    let mut graph = Graph::new();
    let source = format!("video_size={width}x{height}:pix_fmt=rgb24:time_base=1/1000");
    graph.add(&find("buffer")?, "in", &source)?;
    graph.add(&find("buffersink")?, "out", "")?;
    graph.output("in", 0)?.input("out", 0)?.parse(kind.conversion())?;
    graph.validate()?;
    Ok(graph)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_rates_are_fractions_with_a_whole_number_of_ticks_per_frame() {
        for (fps, (frames, seconds), ticks, mpeg4_ticks) in [
            (25.0, (25, 1), 90_000, 65_525),
            (12.5, (25, 2), 90_000, 65_525),
            (25.0 / 3.0, (25, 3), 90_000, 65_525),
            (29.97, (2997, 100), 92_907, 62_937),
            (30_000.0 / 1001.0, (30_000, 1001), 90_000, 60_000),
            (24_000.0 / 1001.0, (24_000, 1001), 96_000, 48_000),
            (66.667, (66_667, 1000), 133_334, 65_535),
            (211.222, (105_611, 500), 105_611, 65_535),
            (0.1, (1, 10), 90_000, 65_535),
            (0.05, (1, 20), 90_000, 65_535),
            (1000.0, (1000, 1), 90_000, 65_000),
            (17.342_18, (8671, 500), 95_381, 60_697),
            (0.0, (1, 1000), 90_000, 65_535),
        ] {
            let rate = rate(fps);
            assert_eq!((rate.numerator(), rate.denominator()), (frames, seconds), "{fps}");
            assert_eq!(tick("libx264", rate), Rational::new(1, ticks), "{fps}");
            assert_eq!(tick(MPEG4, rate), Rational::new(1, mpeg4_ticks), "{fps}");
        }
    }
}
