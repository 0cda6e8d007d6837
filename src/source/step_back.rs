//! Reads earlier frames again on a separate thread, before the consumer who steps back requests them.

use std::ops::Range;
use std::sync::{Arc, Weak};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded, unbounded};

use super::random_access::{Fingerprint, RandomAccess, Step};
use crate::frame::Frame;

/// The longest that the consumer waits for a frame at once: it has other work.
const MAX_WAIT: Duration = Duration::from_millis(5);

/// A reader of runs of frames. It reads one run at a time; a new one replaces it.
pub(super) struct StepBackReader {
    /// Until the thread starts.
    reader: Option<Box<dyn RandomAccess>>,
    runs: Option<Sender<Run>>,
    thread: Option<JoinHandle<()>>,
    present: Option<PresentRun>,
}

/// Frames to read.
struct Run {
    positions: Range<u32>,
    fingerprints: Vec<Fingerprint>,
    frames: Sender<Frame>,
    /// Dead when the run is not wanted any more.
    wanted: Weak<()>,
}

/// The run that is being read or was read.
struct PresentRun {
    /// The positions of the frames that were not taken.
    positions: Range<u32>,
    frames: Receiver<Frame>,
    _wanted: Arc<()>,
}

impl StepBackReader {
    /// A reader that starts its thread when it is used first. Without `reader` it reads nothing.
    pub(super) const fn new(reader: Option<Box<dyn RandomAccess>>) -> Self {
        Self { reader, runs: None, thread: None, present: None }
    }

    /// Whether the frame at `position` is in the run and was not taken.
    pub(super) fn covers(&self, position: u32) -> bool {
        self.present.as_ref().is_some_and(|run| run.positions.contains(&position))
    }

    /// Reads the frames at these positions, in order, in place of those of the present run. `fingerprints` are those of
    /// all frames up to them.
    pub(super) fn start(&mut self, positions: Range<u32>, fingerprints: &[Fingerprint]) {
        self.present = None;
        if let Some(reader) = self.reader.take() {
            let (sender, runs) = unbounded();
            let work = move || read_runs(reader, &runs);
            // Without a thread the frames are read when they are requested.
            self.thread = thread::Builder::new().name("decode again".into()).spawn(work).ok();
            self.runs = self.thread.is_some().then_some(sender);
        }
        let Some(runs) = &self.runs else { return };
        let (sender, frames) = bounded(positions.len());
        let wanted = Arc::new(());
        let fingerprints = fingerprints.iter().take(positions.end as usize).copied().collect();
        let weak = Arc::downgrade(&wanted);
        let run = Run { positions: positions.clone(), fingerprints, frames: sender, wanted: weak };
        if runs.send(run).is_ok() {
            self.present = Some(PresentRun { positions, frames, _wanted: wanted });
        }
    }

    /// The next frame of the run, `None` where it cannot be read. Waits for it a short time.
    pub(super) fn next(&mut self) -> Option<Step> {
        let run = self.present.as_mut()?;
        let received = if run.positions.is_empty() {
            Err(RecvTimeoutError::Disconnected)
        } else {
            run.frames.recv_timeout(MAX_WAIT)
        };
        match received {
            Ok(frame) => run.positions.next().map(|position| Step::Frame(position, frame)),
            Err(RecvTimeoutError::Timeout) => Some(Step::OnTheWay),
            Err(RecvTimeoutError::Disconnected) => {
                self.present = None;
                None
            }
        }
    }
}

impl Drop for StepBackReader {
    fn drop(&mut self) {
        // The thread ends after its current step. It must not be inside a decoder when the process ends.
        (self.present, self.runs) = (None, None);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn read_runs(mut reader: Box<dyn RandomAccess>, runs: &Receiver<Run>) {
    for run in runs {
        for position in run.positions.clone() {
            let frame = read(&mut *reader, position, &run);
            // A frame that is worth a warning is left to the reader whose warnings are told.
            let is_sent = frame
                .is_some_and(|frame| reader.take_warnings().is_empty() && run.frames.send(frame).is_ok());
            if !is_sent {
                break;
            }
        }
    }
}

/// The frame at `position`; `None` where it cannot be read or is not wanted any more.
fn read(reader: &mut dyn RandomAccess, position: u32, run: &Run) -> Option<Frame> {
    while run.wanted.strong_count() > 0 {
        match reader.step(position, position, &run.fingerprints).ok()? {
            Step::Frame(at, frame) if at == position => return Some(frame),
            Step::Frame(..) | Step::OnTheWay => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::frame::Size;
    use crate::source::SourceError;

    const SIZE: Size = Size::new(1, 1);

    /// Frames 0 to 99; reading the last one fails, and 50 is worth a warning.
    struct Hundred {
        warnings: Vec<String>,
    }

    impl RandomAccess for Hundred {
        fn step(&mut self, _: u32, goal: u32, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
            assert!(fingerprints.len() > goal as usize);
            if goal == 50 {
                self.warnings.push("odd".into());
            }
            let frame = Frame::new(goal, SIZE, vec![goal as u8; 3]);
            if goal < 99 { Ok(Step::Frame(goal, frame)) } else { Err(SourceError::changed("hundred")) }
        }

        fn take_warnings(&mut self) -> Vec<String> {
            std::mem::take(&mut self.warnings)
        }
    }

    fn behind() -> StepBackReader {
        StepBackReader::new(Some(Box::new(Hundred { warnings: Vec::new() })))
    }

    fn next(behind: &mut StepBackReader) -> Option<u32> {
        loop {
            if let Step::Frame(position, frame) = behind.next()? {
                assert_eq!(frame.number, position);
                return Some(position);
            }
        }
    }

    fn taken(behind: &mut StepBackReader) -> Vec<u32> {
        std::iter::from_fn(|| next(behind)).collect()
    }

    #[test]
    fn a_run_is_read_in_order_and_a_new_one_replaces_it() {
        let mut behind = behind();
        assert!(!behind.covers(3) && behind.next().is_none());
        behind.start(3..6, &[0; 100]);
        assert!(behind.covers(3) && behind.covers(5) && !behind.covers(6));
        assert_eq!(next(&mut behind), Some(3));
        assert!(!behind.covers(3) && behind.covers(4));
        behind.start(10..14, &[0; 14]);
        assert!(!behind.covers(4));
        assert_eq!(taken(&mut behind), [10, 11, 12, 13]);
        assert!(!behind.covers(13));
    }

    #[test]
    fn a_run_ends_before_a_frame_that_cannot_be_read_or_is_worth_a_warning() {
        let mut behind = behind();
        behind.start(97..100, &[0; 100]);
        assert_eq!(taken(&mut behind), [97, 98]);
        behind.start(48..52, &[0; 100]);
        assert_eq!(taken(&mut behind), [48, 49]);
        behind.start(20..21, &[0; 100]);
        assert_eq!(taken(&mut behind), [20]);
    }

    #[test]
    fn without_a_reader_nothing_is_read() {
        let mut behind = StepBackReader::new(None);
        behind.start(3..6, &[0; 100]);
        assert!(!behind.covers(3) && behind.next().is_none());
    }
}
