//! Encodes images on separate threads during the analysis.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::{io, mem};

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

    /// Waits until all images are written. An error names the image that could not be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.join()
    }

    fn join(&mut self) -> io::Result<()> {
        self.jobs = None;
        let mut result = Ok(());
        for thread in mem::take(&mut self.threads) {
            let outcome = thread.join().unwrap_or_else(|_| Err(io::Error::other("a writer thread failed")));
            result = result.and(outcome);
        }
        result
    }
}

impl Drop for PictureQueue {
    fn drop(&mut self) {
        let _ = self.join();
    }
}

fn work(waiting: &Receiver<(PathBuf, Picture)>) -> io::Result<()> {
    for (path, picture) in waiting {
        let written = match &picture {
            Picture::Frame(frame) => write_frame(&path, frame),
            Picture::Mask(mask) => write_mask(&path, mask),
            Picture::Labels(image) => write_labels(&path, image),
        };
        written.map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", path.display())))?;
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
}
