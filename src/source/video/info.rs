//! Properties of a video stream that its header gives.

use ffmpeg::codec::field_order::FieldOrder;
use ffmpeg::ffi::AV_NOPTS_VALUE;
use ffmpeg::format::context::Input;
use ffmpeg::format::stream::Disposition;
use ffmpeg::media::Type;
use ffmpeg::packet::side_data;
use ffmpeg::{Rational, Stream};

use super::Failure;
use super::rotate::{self, DisplayMatrix};
use crate::source::rate;

/// Largest number of pictures that are held back for reordering.
const MAX_REORDERED: usize = 16;

/// Pixels narrower than this, or as much wider, are an error in the header.
const MIN_ASPECT: f64 = 0.05;

/// Properties of a video stream.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StreamInfo {
    /// Index of the stream in the file.
    pub(super) index: usize,
    /// Number of video streams in the file, without cover pictures.
    pub(super) video_streams: usize,
    /// The short name of its codec, such as `h264`.
    pub(super) codec: String,
    /// The unit of its times, in seconds.
    pub(super) time_base: Ratio,
    /// Width and height of a stored pixel, before rotation; `None` where it is square or not given.
    pub(super) pixel_aspect: Option<Ratio>,
    /// Number of frames per second, if the header gives a plausible one: the average, else the lowest rate that has a
    /// tick for every frame.
    pub(super) rate: Option<f64>,
    /// The time at which it starts, in ticks of the time base, although its first pictures may not be decodable.
    pub(super) start: Option<i64>,
    /// Number of frames; an estimate.
    pub(super) frames: Option<u64>,
    /// Largest number of pictures that are shown before one that was decoded before them.
    pub(super) reordered: usize,
    /// Whether the header says that the pictures consist of two fields of different times.
    pub(super) is_interlaced: bool,
    /// The display matrix in the header.
    pub(super) display_matrix: Option<DisplayMatrix>,
}

/// A positive ratio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ratio {
    pub(super) numerator: i32,
    pub(super) denominator: i32,
}

impl Ratio {
    /// `None` where a part is not positive.
    fn new(ratio: Rational) -> Option<Self> {
        let (numerator, denominator) = (ratio.numerator(), ratio.denominator());
        (numerator > 0 && denominator > 0).then_some(Self { numerator, denominator })
    }

    /// The quotient.
    pub(super) fn value(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }
}

impl StreamInfo {
    /// The properties of the video stream with this index, or else of the one that the `ffmpeg` program selects.
    pub(super) fn of(input: &Input, selected: Option<u32>) -> Result<Self, Failure> {
        let streams: Vec<usize> = input.streams().filter(is_video).map(|stream| stream.index()).collect();
        let best = input.streams().best(Type::Video).map(|best| best.index());
        let best = best.filter(|best| streams.contains(best)).or_else(|| streams.first().copied());
        let index = match (best, selected.map(|index| index as usize)) {
            (Some(_), Some(index)) if !streams.contains(&index) => {
                return Err(Failure::NoStream { index, streams: list(input) });
            }
            (Some(best), selected) => selected.unwrap_or(best),
            (None, _) if input.nb_streams() > 0 => return Err(Failure::NoVideoStream),
            (None, _) => return Err(Failure::NoVideo),
        };
        Self::of_stream(input, index, streams.len()).ok_or(Failure::NoVideo)
    }

    /// `None` where the stream has no valid time base.
    fn of_stream(input: &Input, index: usize, video_streams: usize) -> Option<Self> {
        let stream = input.stream(index)?;
        let parameters = stream.parameters();
        let time_base = Ratio::new(stream.time_base())?;
        let rate = rate_of(&stream);
        let seconds = |ticks: i64, tick: f64| (ticks > 0).then_some(ticks as f64 * tick);
        let frames_in = |seconds: Option<f64>| Some((seconds? * rate?).round() as u64);
        // MP4's header counts frames that an edit list removes; the stream's duration does not contain them.
        let has_edit_lists = input.format().name().starts_with("mov");
        let by_header = u64::try_from(stream.frames()).ok().filter(|&frames| frames > 0);
        let by_stream = frames_in(seconds(stream.duration(), time_base.value()));
        let by_file = || frames_in(seconds(input.duration(), 1e-6));
        let frames = match (by_header, by_stream) {
            (Some(header), Some(stream)) if has_edit_lists => Some(header.min(stream)),
            (header, stream) => header.or(stream).or_else(by_file),
        };
        Some(Self {
            index,
            video_streams,
            codec: parameters.id().name().to_owned(),
            time_base,
            pixel_aspect: pixel_aspect(&stream),
            rate,
            start: Some(stream.start_time()).filter(|&start| start != AV_NOPTS_VALUE),
            frames,
            reordered: usize::try_from(parameters.video_delay()).unwrap_or(0).min(MAX_REORDERED),
            is_interlaced: !matches!(parameters.field_order(), FieldOrder::Unknown | FieldOrder::Progressive),
            display_matrix: display_matrix(&stream),
        })
    }

    /// The length of a frame in ticks of the time base.
    pub(super) fn ticks_per_frame(&self) -> i64 {
        let rate = self.rate.unwrap_or(f64::from(rate::ASSUMED));
        (1.0 / (rate * self.time_base.value())).round().max(1.0) as i64
    }
}

/// Whether a stream is video and not a cover picture.
fn is_video(stream: &Stream<'_>) -> bool {
    stream.parameters().medium() == Type::Video && !stream.disposition().contains(Disposition::ATTACHED_PIC)
}

/// The aspect of a stream's pixels that the container gives, else the codec.
fn pixel_aspect(stream: &Stream<'_>) -> Option<Ratio> {
    let by_codec = || Ratio::new(stream.parameters().sample_aspect_ratio());
    let aspect = Ratio::new(stream.sample_aspect_ratio()).or_else(by_codec)?;
    let is_plausible = (MIN_ASPECT..=1.0 / MIN_ASPECT).contains(&aspect.value());
    (is_plausible && aspect.numerator != aspect.denominator).then_some(aspect)
}

/// The frame rate in the header, if it is plausible.
fn rate_of(stream: &Stream<'_>) -> Option<f64> {
    let rates = [stream.avg_frame_rate(), stream.rate()].into_iter();
    rates.filter_map(Ratio::new).map(Ratio::value).find(|&fps| rate::is_plausible(fps))
}

/// The video streams of a file, in words.
fn list(input: &Input) -> String {
    let streams = input.streams().filter(is_video).map(|stream| {
        let parameters = stream.parameters();
        let (codec, width, height) = (parameters.id().name(), parameters.width(), parameters.height());
        let rate = rate_of(&stream).map_or_else(String::new, |fps| format!(", {} fps", fps as f32));
        format!("{} ({codec}, {width}×{height}{rate})", stream.index())
    });
    streams.collect::<Vec<_>>().join(", ")
}

/// Side data of a stream where the crate has no method for it, with FFmpeg 8 and newer: these attach it to the frames.
///
/// Where the crate has the method, it takes precedence over this one.
#[allow(dead_code, reason = "used where the crate has no method")]
trait NoSideData {
    fn side_data(&self) -> std::iter::Empty<ffmpeg::packet::SideData<'_>> {
        std::iter::empty()
    }
}

impl NoSideData for Stream<'_> {}

fn display_matrix(stream: &Stream<'_>) -> Option<DisplayMatrix> {
    let mut all = stream.side_data();
    rotate::display_matrix(all.find(|data| data.kind() == side_data::Type::DisplayMatrix)?.data())
}
