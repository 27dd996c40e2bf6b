//! Whether {g < depth} consists of parts that lie far from one another.

use crate::numeric::geometry::Rect;

/// Rectangles closer together than half the longer side of either are made one.
pub(super) fn merged(mut pieces: Vec<Rect>) -> Vec<Rect> {
    let half = |r: &Rect| 0.5 * r.size()[0].max(r.size()[1]);
    let close = |a: &Rect, b: &Rect| {
        let apart = |m: usize| (a.min[m] - b.max[m]).max(b.min[m] - a.max[m]).max(0.0);
        apart(0).hypot(apart(1)) <= half(a).max(half(b))
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
