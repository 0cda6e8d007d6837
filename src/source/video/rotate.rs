//! The display matrix of a video: how its pictures are rotated and mirrored to be upright.

/// Nine numbers, row by row; the upper left 2 × 2 are 16.16 fixed point.
pub(super) type DisplayMatrix = [i32; 9];

/// The matrix in the bytes of FFmpeg's side data, which are in the machine's byte order.
pub(super) fn display_matrix(bytes: &[u8]) -> Option<DisplayMatrix> {
    let mut matrix = [0; 9];
    let (words, _) = bytes.as_chunks::<4>();
    if words.len() < matrix.len() {
        return None;
    }
    for (number, word) in matrix.iter_mut().zip(words) {
        *number = i32::from_ne_bytes(*word);
    }
    Some(matrix)
}

/// The filters that make the pictures upright, the same that the `ffmpeg` program inserts; none where they are
/// upright or the matrix is degenerate.
pub(super) fn filters(matrix: &DisplayMatrix) -> Vec<String> {
    let fixed = |at: usize| f64::from(matrix[at]) / 65536.0;
    let scale = (fixed(0).hypot(fixed(3)), fixed(1).hypot(fixed(4)));
    if scale.0 == 0.0 || scale.1 == 0.0 {
        return Vec::new();
    }
    let angle = (fixed(1) / scale.1).atan2(fixed(0) / scale.0).to_degrees().round();
    // Clockwise, in 0..360; the program's 0.9 makes an angle just below 360 one just below 0.
    let angle = angle - 360.0 * (angle / 360.0 + 0.9 / 360.0).floor();
    let is_near = |other: f64| (angle - other).abs() < 1.0;
    let filters: &[&str] = if is_near(90.0) {
        if matrix[3] > 0 { &["transpose=cclock_flip"] } else { &["transpose=clock"] }
    } else if is_near(180.0) {
        match (matrix[0] < 0, matrix[4] < 0) {
            (true, true) => &["hflip", "vflip"],
            (true, false) => &["hflip"],
            (false, true) => &["vflip"],
            (false, false) => &[],
        }
    } else if is_near(270.0) {
        if matrix[3] < 0 { &["transpose=clock_flip"] } else { &["transpose=cclock"] }
    } else if angle.abs() > 1.0 {
        return vec![format!("rotate={angle}*PI/180")];
    } else if matrix[4] < 0 {
        &["vflip"]
    } else {
        &[]
    };
    filters.iter().map(|&filter| filter.to_owned()).collect()
}

/// Whether the upright pictures have the stored pictures' width as their height.
pub(super) fn swaps_sides(matrix: &DisplayMatrix) -> bool {
    filters(matrix).iter().any(|filter| filter.starts_with("transpose"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: i32 = 1 << 16;

    fn of(a: i32, b: i32, c: i32, d: i32) -> String {
        filters(&[a, b, 0, c, d, 0, 0, 0, 1 << 30]).join(",")
    }

    #[test]
    fn every_quarter_turn_and_mirror_has_its_filters() {
        let of = |a: i32, b: i32, c: i32, d: i32| of(a * ONE, b * ONE, c * ONE, d * ONE);
        assert_eq!(of(1, 0, 0, 1), "");
        assert_eq!(of(0, 1, -1, 0), "transpose=clock", "a phone held upright");
        assert_eq!(of(-1, 0, 0, -1), "hflip,vflip");
        assert_eq!(of(0, -1, 1, 0), "transpose=cclock");
        assert_eq!(of(-1, 0, 0, 1), "hflip");
        assert_eq!(of(1, 0, 0, -1), "vflip");
        assert_eq!(of(0, 1, 1, 0), "transpose=cclock_flip");
        assert_eq!(of(0, -1, -1, 0), "transpose=clock_flip");
        assert_eq!(of(0, 0, 0, 0), "", "not a matrix");
    }

    #[test]
    fn quarter_turns_swap_the_sides() {
        let of = |a: i32, b: i32, c: i32, d: i32| {
            swaps_sides(&[a * ONE, b * ONE, 0, c * ONE, d * ONE, 0, 0, 0, 1 << 30])
        };
        assert!(of(0, 1, -1, 0) && of(0, -1, 1, 0) && of(0, 1, 1, 0));
        assert!(!of(1, 0, 0, 1) && !of(-1, 0, 0, -1) && !of(-1, 0, 0, 1));
    }

    #[test]
    fn other_angles_are_rotated_and_scales_do_not_matter() {
        let (sine, cosine) = (45_f64.to_radians().sin() * 65536.0, 45_f64.to_radians().cos() * 65536.0);
        assert_eq!(of(cosine as i32, sine as i32, -sine as i32, cosine as i32), "rotate=45*PI/180");
        assert_eq!(of(0, 3 * ONE, -3 * ONE, 0), "transpose=clock");
        assert_eq!(of(i32::MIN, 0, 0, i32::MIN), "hflip,vflip");
    }

    #[test]
    fn short_side_data_is_no_matrix() {
        assert_eq!(display_matrix(&[0; 35]), None);
        let bytes: Vec<u8> = (1..=9_i32).flat_map(i32::to_ne_bytes).collect();
        assert_eq!(display_matrix(&bytes), Some([1, 2, 3, 4, 5, 6, 7, 8, 9]));
    }
}
