//! Tracks in MOTChallenge's format: `frame,id,x,y,w,h,conf,-1,-1,-1`, no header. Boxes are in pixels, and the upper
//! left pixel is (0, 0).

use std::io::{self, Write};

use super::number::significant;
use crate::tracking::{FrameTracks, TrackState};

/// Writes the objects of a frame.
pub fn write_frame(out: &mut impl Write, FrameTracks { number, tracks, .. }: &FrameTracks) -> io::Result<()> {
    for track in tracks {
        let [x, y, w, h] = [track.bbox.x, track.bbox.y, track.bbox.w, track.bbox.h].map(significant);
        let conf = confidence(track.state);
        writeln!(out, "{number},{},{x},{y},{w},{h},{conf},-1,-1,-1", track.id)?;
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
    use crate::tracking::Track;

    #[test]
    fn rows_are_in_motchallenge_format() {
        let hidden = Track { state: TrackState::Hidden, ..track(7, 10.5, 20.25) };
        let tracks = [vec![track(3, 1.0, 2.0)], vec![], vec![track(3, 2.0, 2.0), hidden]];
        let frames: Vec<_> =
            (4..).zip(tracks).map(|(number, tracks)| FrameTracks { number, time: 0.0, tracks }).collect();
        assert_eq!(
            written(|out| frames.iter().try_for_each(|frame| write_frame(out, frame))),
            "4,3,1,2,8,16,1,-1,-1,-1\n6,3,2,2,8,16,1,-1,-1,-1\n6,7,10.5,20.25,8,16,0.5,-1,-1,-1\n"
        );
    }
}
