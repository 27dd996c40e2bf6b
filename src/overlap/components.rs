//! Whether {g < depth} consists of parts that lie far from one another.

use crate::numeric::geometry::Rect;

/// A contact this small beside another is lost between the cells of a grid that holds both.
const NEEDLE: f64 = 1.0 / 64.0;

/// How far apart two contacts lie in the longer side of the larger one, to be solved apart with all digits.
pub(super) const APART: f64 = 0.5;

/// The least such distance: four digits of what they do to one another.
pub(super) const NEAR: f64 = 0.1;

/// Whether a contact is lost between the cells of a grid over a rectangle.
pub(super) fn is_needle(piece: &Rect, beside: f64) -> bool {
    piece.longer_side() < NEEDLE * beside
}

/// Rectangles closer together than `share` of the longer side of either are made one, and those of needles closer than a tenth.
pub(super) fn merged(mut pieces: Vec<Rect>, share: f64) -> Vec<Rect> {
    let close = |a: &Rect, b: &Rect| {
        let apart = |m: usize| (a.min[m] - b.max[m]).max(b.min[m] - a.max[m]).max(0.0);
        let longer = a.longer_side().max(b.longer_side());
        let least = if is_needle(a, longer) || is_needle(b, longer) { NEAR } else { share };
        apart(0).hypot(apart(1)) <= least * longer
    };
    let mut k = 0;
    while k < pieces.len() {
        match (k + 1..pieces.len()).find(|&m| close(&pieces[k], &pieces[m])) {
            Some(m) => {
                let other = pieces.swap_remove(m);
                pieces[k] = pieces[k].union(&other);
                // The larger one may be close to those before it.
                k = 0;
            }
            None => k += 1,
        }
    }
    pieces
}
