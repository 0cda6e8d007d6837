//! Encodes images on separate threads during the analysis.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::{io, mem, panic};

use crossbeam_channel::{Receiver, Sender, bounded};

use super::label_image::LabelImage;
use super::picture::{write_frame, write_labels, write_mask};
use crate::frame::{Frame, Mask};

/// An image to be written.
pub enum Picture {
    /// An RGB image.
    Frame(Arc<Frame>),
    /// A mask, in gray.
    Mask(Arc<Mask>),
    /// A label image, in gray of 16 bits.
    Labels(LabelImage),
}

/// Threads that write images. Dropping it completes the queued images.
pub struct PictureQueue {
    jobs: Option<Sender<(PathBuf, Picture)>>,
    threads: Vec<JoinHandle<io::Result<()>>>,
}

impl PictureQueue {
    /// Starts this many threads, at least one.
    pub fn start(threads: usize) -> io::Result<Self> {
        let threads = threads.max(1);
        // The queue is short: images are large, and a disk slower than the analysis has to limit its speed.
        let (jobs, waiting) = bounded(2 * threads);
        let threads = (0..threads)
            .map(|_| {
                let waiting = waiting.clone();
                thread::Builder::new().name("pictures".to_owned()).spawn(move || work(&waiting))
            })
            .collect::<io::Result<_>>()?;
        Ok(Self { jobs: Some(jobs), threads })
    }

    /// Queues an image for writing to `path`; blocks while the queue is full. Fails if all threads have failed; other
    /// errors are returned by [`Self::finish`].
    pub fn write(&mut self, path: PathBuf, picture: Picture) -> io::Result<()> {
        let taken = self.jobs.as_ref().is_some_and(|jobs| jobs.send((path, picture)).is_ok());
        // All threads have failed; joining them returns the error.
        if taken { Ok(()) } else { self.join() }
    }

    /// Waits until all images are written. An error names the image that could not be written; a panic of a thread goes
    /// on in this one.
    pub fn finish(mut self) -> io::Result<()> {
        self.join()
    }

    fn join(&mut self) -> io::Result<()> {
        self.jobs = None;
        let (mut result, mut panicked) = (Ok(()), None);
        for thread in mem::take(&mut self.threads) {
            match thread.join() {
                Ok(outcome) => result = result.and(outcome),
                Err(payload) => panicked = Some(payload),
            }
        }
        match panicked {
            Some(payload) if !thread::panicking() => panic::resume_unwind(payload),
            _ => result,
        }
    }
}

impl Drop for PictureQueue {
    fn drop(&mut self) {
        let _ = self.join();
    }
}

fn work(waiting: &Receiver<(PathBuf, Picture)>) -> io::Result<()> {
    for (path, picture) in waiting {
        match &picture {
            Picture::Frame(frame) => write_frame(&path, frame),
            Picture::Mask(mask) => write_mask(&path, mask),
            Picture::Labels(image) => write_labels(&path, image),
        }?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::frame::Size;

    #[test]
    fn all_images_are_written_at_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let mut queue = PictureQueue::start(3).unwrap();
        let mask = Arc::new(Mask::empty(Size::new(40, 30)));
        for number in 0..50 {
            queue.write(folder.path().join(format!("{number}.png")), Picture::Mask(mask.clone())).unwrap();
        }
        queue.finish().unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 50);
    }

    #[test]
    fn an_error_is_returned_and_nothing_blocks() {
        let mut queue = PictureQueue::start(2).unwrap();
        let mask = Arc::new(Mask::empty(Size::new(4, 3)));
        let mut refused = Ok(());
        for _ in 0..50 {
            refused = refused.and(queue.write("/nowhere/at/all.png".into(), Picture::Mask(mask.clone())));
        }
        assert!(refused.and(queue.finish()).unwrap_err().to_string().contains("/nowhere/at/all.png"));
    }

    #[test]
    fn a_panic_of_a_thread_goes_on_in_the_caller() {
        let folder = tempfile::tempdir().unwrap();
        let mut queue = PictureQueue::start(1).unwrap();
        let broken = Arc::new(Mask { size: Size::new(4, 3), data: vec![0; 5] });
        queue.write(folder.path().join("a.png"), Picture::Mask(broken)).unwrap();
        assert!(panic::catch_unwind(panic::AssertUnwindSafe(|| queue.finish())).is_err());
    }
}
