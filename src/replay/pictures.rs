//! The pictures that a model gives at one frame.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::frame::Frame;
use crate::mixture::Mixture;

/// What a model shows of itself after a frame.
#[derive(Clone)]
pub(super) struct Pictures {
    pub(super) background: Arc<Frame>,
    pub(super) multi_mode: Option<Arc<Frame>>,
    pub(super) background_count: Option<Arc<Vec<u8>>>,
}

impl Pictures {
    /// Those of a mixture whose last frame is `frame`.
    pub(super) fn of_mixture(mixture: &Mixture, frame: &Frame) -> Self {
        let picture = |rgb| Arc::new(Frame::new(frame.number, frame.size, rgb));
        let appearance = mixture.appearance();
        Self {
            background: picture(appearance.mean),
            multi_mode: Some(picture(appearance.multi_mode)),
            background_count: Some(Arc::new(appearance.background_count)),
        }
    }

    /// That of a model which has a background image alone.
    pub(super) const fn of_background(background: Arc<Frame>) -> Self {
        Self { background, multi_mode: None, background_count: None }
    }
}

/// The last pictures that were made, by position: stepping back passes by frames that were
/// replayed a moment ago.
pub(super) struct Recent {
    pictures: VecDeque<(u32, Pictures)>,
    room: usize,
}

impl Recent {
    pub(super) const fn new(room: usize) -> Self {
        Self { pictures: VecDeque::new(), room }
    }

    /// Room for so many.
    pub(super) fn set_room(&mut self, room: usize) {
        self.room = room;
        while self.pictures.len() > self.room {
            self.pictures.pop_front();
        }
    }

    pub(super) fn get(&self, position: u32) -> Option<Pictures> {
        self.pictures.iter().find(|(at, _)| *at == position).map(|(_, pictures)| pictures.clone())
    }

    pub(super) fn insert(&mut self, position: u32, pictures: Pictures) {
        self.pictures.retain(|(at, _)| *at != position);
        self.pictures.push_back((position, pictures));
        while self.pictures.len() > self.room {
            self.pictures.pop_front();
        }
    }
}
