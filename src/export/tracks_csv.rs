//! Tracks in MOTChallenge's format: `frame,id,x,y,w,h,conf,-1,-1,-1`, no header. Boxes are in pixels, and the upper
//! left pixel is (0, 0).

use std::io::{self, Write};

use super::number::significant;
use crate::tracking::{Track, TrackState};

/// Writes the objects of each frame, `(frame number, tracks)` in order.
pub fn write(out: &mut impl Write, frames: &[(u32, Vec<Track>)]) -> io::Result<()> {
    for (number, tracks) in frames {
        for track in tracks {
            let [x, y, w, h] = [track.bbox.x, track.bbox.y, track.bbox.w, track.bbox.h].map(significant);
            let conf = confidence(track.state);
            writeln!(out, "{number},{},{x},{y},{w},{h},{conf},-1,-1,-1", track.id)?;
        }
    }
    Ok(())
}

/// 1 for a visible object, 0.5 where its box is predicted.
pub fn confidence(state: TrackState) -> f32 {
    match state {
        TrackState::Visible => 1.0,
        TrackState::Merged | TrackState::Hidden => 0.5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::{track, written};

    #[test]
    fn rows_are_in_motchallenge_format() {
        let hidden = Track { state: TrackState::Hidden, ..track(7, 10.5, 20.25) };
        let frames = vec![(4, vec![track(3, 1.0, 2.0)]), (5, vec![]), (6, vec![track(3, 2.0, 2.0), hidden])];
        assert_eq!(
            written(|out| write(out, &frames)),
            "4,3,1,2,8,16,1,-1,-1,-1\n6,3,2,2,8,16,1,-1,-1,-1\n6,7,10.5,20.25,8,16,0.5,-1,-1,-1\n"
        );
    }
}
