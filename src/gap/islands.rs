//! Whether what lies below a depth is several places far from one another.

use super::Gap;
use crate::geometry::Rect;
use crate::grid::Grid;

/// Points a side at which a box is looked at for whether {g < depth} fills it.
const LOOKS: usize = 32;

/// What fills this share of its box is one.
const FULL: f64 = 0.3;

/// Rectangles around the separate parts of {g < depth}, which lies in `reach`, at least half the side of either from one
/// another; the whole box when there is but one.
pub(crate) fn islands(gap: &dyn Gap, depth: f64, reach: &Rect) -> Vec<Rect> {
    let lattice = Grid::over(reach, [LOOKS; 2]);
    let enough = (FULL * lattice.len() as f64) as usize;
    let filled = lattice.centres().filter(|[x, y]| gap.gap(*x, *y) < depth).nth(enough).is_some();
    let pieces = if filled { None } else { gap.pieces(depth) };
    pieces.map(merged).filter(|pieces| pieces.len() > 1).unwrap_or_else(|| vec![*reach])
}

/// Rectangles closer together than half the longer side of either are made one.
fn merged(mut pieces: Vec<Rect>) -> Vec<Rect> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{AnyGap, Minimum, Paraboloid, Placed};

    fn tips(at: &[[f64; 2]]) -> Minimum {
        let tip = |&p: &[f64; 2]| AnyGap::new(Placed::new(Paraboloid::new([0.5, 0.5]).unwrap(), p, 0.0).unwrap());
        Minimum::new(at.iter().map(tip).collect()).unwrap()
    }

    fn count(gap: &dyn Gap, depth: f64) -> usize {
        let crate::gap::Reach::Within(reach) = crate::gap::extent(gap, depth) else { panic!("bounded") };
        islands(gap, depth, &reach).len()
    }

    #[test]
    fn tips_are_told_apart_from_two_radii_to_a_million() {
        for far in [4.0, 30.0, 1e6] {
            let gap = tips(&[[0.0, 0.0], [far, 0.0], [0.0, far]]);
            assert_eq!(count(&gap, 1.0), 3, "{far}");
            let formula = |x: f64, y: f64| gap.gap(x, y);
            assert!(far > 1e3 || count(&formula, 1.0) == 3, "{far} by its values");
        }
        assert_eq!(count(&tips(&[[0.0, 0.0], [2.5, 0.0]]), 1.0), 1);
    }

    #[test]
    fn one_slender_contact_is_one() {
        let turned = Placed::new(Paraboloid::new([1e4, 1.0]).unwrap(), [3.0, 1.0], 0.7).unwrap();
        assert_eq!(count(&turned, 1.0), 1);
    }
}
