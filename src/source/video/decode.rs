//! Demultiplexing and decoding of a video stream: its pictures in the order of presentation.

use ffmpeg::codec::discard::Discard;
use ffmpeg::format::context::Input;
use ffmpeg::frame::Video as Picture;
use ffmpeg::{Dictionary, Packet, decoder};

use super::Failure;
use super::file::InputFile;
use super::index::Key;
use super::info::StreamInfo;
use super::raw;
use crate::libav::wants_data;

/// Number of errors in a row at the end of a stream after which the decoder is given up.
const MAX_ERRORS_AT_END: u32 = 4096;

/// Number of threads of a decoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Threads {
    /// One per core.
    All,
    /// One.
    One,
}

/// A decoded picture.
pub(super) struct Decoded {
    /// Its planes, in the stream's pixel format.
    pub(super) picture: Picture,
    /// Its time of presentation in ticks of the stream's time base: the file's, or FFmpeg's estimate.
    pub(super) pts: Option<i64>,
    /// Whether the decoder had to fill in what is missing or wrong.
    pub(super) is_damaged: bool,
}

/// The result of a seek.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Landing {
    /// The next picture is that of this key packet or, in an open group of pictures, one shortly before.
    At(Key),
    /// There is no key packet there.
    AtEnd,
    /// The file cannot seek.
    Refused,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Reading,
    Draining,
    Over,
}

/// Demuxer and decoder of a stream. Errors in the stream are counted and skipped, as the `ffmpeg` program does.
pub(super) struct Decoder {
    input: Input,
    codec: decoder::Video,
    info: StreamInfo,
    state: State,
    /// Key packets since the last call of [`Self::take_keys`].
    keys: Vec<Key>,
    /// After a seek: packets before the first key packet are dropped.
    awaits_key: bool,
    /// Pictures before this time that no other depends on are not decoded.
    hurry_until: Option<i64>,
    errors: u64,
}

impl Decoder {
    /// Opens a file at its start.
    pub(super) fn open(file: &InputFile, threads: Threads) -> Result<Self, Failure> {
        raw::count_reported_errors();
        let mut input = open_input(file)?;
        let info = StreamInfo::of(&input, file.stream)?;
        raw::select_stream(&mut input, info.index);
        let stream = input.stream(info.index).ok_or(Failure::NoVideo)?;
        let parameters = stream.parameters();
        let codec = decoder::find(parameters.id()).ok_or_else(|| Failure::NoDecoder(info.codec.clone()))?;
        let mut options = Dictionary::new();
        options.set("threads", if threads == Threads::One { "1" } else { "auto" });
        let time_base = info.time_base;
        options.set("pkt_timebase", format!("{}/{}", time_base.numerator, time_base.denominator));
        let context = ffmpeg::codec::Context::from_parameters(parameters).map_err(|_| Failure::NoVideo)?;
        let decoder = context.decoder().open_as_with(codec, options).and_then(decoder::Opened::video);
        Ok(Self {
            codec: decoder.map_err(|_| Failure::NoFrame)?,
            input,
            info,
            state: State::Reading,
            keys: Vec::new(),
            awaits_key: false,
            hurry_until: None,
            errors: 0,
        })
    }

    /// Properties of the stream.
    pub(super) fn info(&self) -> &StreamInfo {
        &self.info
    }

    /// Number of errors so far.
    pub(super) fn errors(&self) -> u64 {
        self.errors
    }

    /// Takes the key packets that were read since the last call.
    pub(super) fn take_keys(&mut self) -> Vec<Key> {
        std::mem::take(&mut self.keys)
    }

    /// The next picture, `None` after the last.
    pub(super) fn next(&mut self) -> Option<Decoded> {
        let mut errors_in_a_row = 0;
        let mut picture = Picture::empty();
        while self.state != State::Over {
            match self.codec.receive_frame(&mut picture) {
                Ok(()) => {
                    let pts = picture.timestamp();
                    let is_damaged = picture.is_corrupt() || raw::has_errors(&picture);
                    return Some(Decoded { picture, pts, is_damaged });
                }
                Err(ffmpeg::Error::Eof) => self.state = State::Over,
                Err(error) => {
                    // The decoder asks for more data with an error, too.
                    let is_error = !wants_data(error);
                    self.errors += u64::from(is_error);
                    if self.state == State::Reading {
                        self.feed();
                    } else {
                        // Only the end is the end: pictures may follow an error.
                        errors_in_a_row += 1;
                        if errors_in_a_row > MAX_ERRORS_AT_END {
                            self.state = State::Over;
                        }
                    }
                }
            }
        }
        None
    }

    /// Gives the next packet of the stream to the decoder.
    fn feed(&mut self) {
        let Some(packet) = self.next_packet() else {
            self.state = State::Draining;
            // With several threads it may return the error of an earlier packet; the remaining pictures still follow.
            self.errors += u64::from(self.codec.send_eof().is_err());
            return;
        };
        if let Some(until) = self.hurry_until {
            let is_over = packet.dts().is_some_and(|dts| dts >= until);
            let is_before = !is_over && packet.pts().is_some_and(|pts| pts < until);
            self.codec.skip_frame(if is_before { Discard::NonReference } else { Discard::Default });
            if is_over {
                self.hurry_until = None;
            }
        }
        self.errors += u64::from(self.codec.send_packet(&packet).is_err());
    }

    /// The next packet of the stream. What cannot be read is the end.
    fn next_packet(&mut self) -> Option<Packet> {
        loop {
            let mut packet = Packet::empty();
            if let Err(error) = packet.read(&mut self.input) {
                self.errors += u64::from(error != ffmpeg::Error::Eof);
                return None;
            }
            if packet.stream() != self.info.index {
                continue;
            }
            if packet.is_key() {
                self.keys.push(Key { pts: packet.pts(), dts: packet.dts() });
                self.awaits_key = false;
            }
            if !self.awaits_key {
                return Some(packet);
            }
        }
    }

    /// Seeks to a key packet at about this time or before it, in ticks of the stream's time base.
    pub(super) fn seek(&mut self, time: i64) -> Landing {
        let time_base = self.info.time_base;
        let scaled = i128::from(time) * i128::from(time_base.numerator) * 1_000_000;
        // Rounded up: a time rounded down is before the key packet itself.
        let Ok(micros) = i64::try_from(scaled.div_euclid(i128::from(time_base.denominator)) + 1) else {
            return Landing::Refused;
        };
        if self.input.seek(micros, ..=micros).is_err() {
            return Landing::Refused;
        }
        self.codec.flush();
        self.codec.skip_frame(Discard::Default);
        self.state = State::Reading;
        self.hurry_until = None;
        self.keys.clear();
        self.awaits_key = true;
        let Some(packet) = self.next_packet() else { return Landing::AtEnd };
        self.errors += u64::from(self.codec.send_packet(&packet).is_err());
        self.keys.last().map_or(Landing::AtEnd, |key| Landing::At(*key))
    }

    /// Allows to skip pictures before this time that no other depends on.
    pub(super) fn hurry_until(&mut self, time: i64) {
        self.hurry_until = Some(time);
    }
}

fn open_input(file: &InputFile) -> Result<Input, Failure> {
    let address = file.address().ok_or(Failure::NoVideo)?;
    let mut options = Dictionary::new();
    for (name, value) in file.open_options() {
        options.set(name, value);
    }
    ffmpeg::format::input_with_dictionary(&address, options).map_err(|error| {
        if file.is_live() { Failure::Unreachable(error.to_string()) } else { Failure::NoVideo }
    })
}
