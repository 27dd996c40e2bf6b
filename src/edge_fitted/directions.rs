//! What cells in two directions leave of a contact that ends among them, told by fewer in one or in both.

use super::Limits;
use super::estimated::Solved;
use super::rows::{LEAST_GROWTH, wanted};

/// Of the cells in each direction, those of the meshes that tell the error: with the second order four fifths of the change are left.
const FEWER: f64 = 2.0 / 3.0;

/// The contact ends among the cells, anywhere in one: P_A of a set of cells that is too wide or too narrow by a share delta is too small by
/// the order of delta^2, by chance more on one mesh than on another. With one change for each direction alone, errors of 547 rollers by lot
/// were up to 4.8 times what is stated where rows are few, and 2.1 times where the ends are kinks.
const SAFE: f64 = 1.5;

/// Of the cells in both directions, those of one mesh more, and the factor of its change: with the second order 1.8 of it are left. With
/// 1.8 one of 547 was off by 1.06 times what is stated, with 2.5 none by more than 0.6 times.
const LESS: f64 = 0.8;
const SAFE_AGAIN: f64 = 2.2;

/// Order that the next round relies on, and share of the tolerance that each direction aims at: what a round misses by is more than it
/// should be by chance, and less of it is left by the next.
const ORDER: f64 = 2.5;
const AIM: f64 = 0.45;

/// The mesh that answers, with fewer cells in both directions, in the first, and in the second.
pub(super) struct Meshes<S> {
    pub fine: S,
    pub nearer: S,
    pub fewer: [S; 2],
}

/// What they tell, relative to the values of the finest.
pub(super) struct Told {
    /// Of force and energy, what the cells of each direction leave.
    pub left: [f64; 2],
    /// Changes of the energy, of dP/dd, of the area and of the largest pressure, of both directions together.
    pub energy: f64,
    pub stiffness: f64,
    pub area: f64,
    pub largest: f64,
}

/// Fewer cells in one direction.
pub(super) fn fewer(counts: [usize; 2], direction: usize) -> [usize; 2] {
    [0, 1].map(|k| if k == direction { times(FEWER, counts[k]) } else { counts[k] })
}

/// Fewer in both.
pub(super) fn less(counts: [usize; 2]) -> [usize; 2] {
    counts.map(|n| times(LESS, n))
}

fn times(share: f64, n: usize) -> usize {
    (share * n as f64).round() as usize
}

impl<S> Meshes<S> {
    /// So many cells in each direction, and fewer.
    pub fn of(counts: [usize; 2], solve: impl Fn([usize; 2]) -> Option<S>) -> Option<Self> {
        let nearer = solve(less(counts))?;
        let fine = solve(counts)?;
        Some(Self { fine, nearer, fewer: [solve(fewer(counts, 0))?, solve(fewer(counts, 1))?] })
    }

    pub fn all(&self) -> [&S; 4] {
        let [shorter, coarse] = &self.fewer;
        [&self.fine, &self.nearer, shorter, coarse]
    }

    /// `own`: what was solved, and its area of contact.
    pub fn told(&self, own: impl Fn(&S) -> (&Solved, f64)) -> Told {
        let change = |other: &S, of: &dyn Fn(&Solved) -> f64| (of(own(&self.fine).0) / of(own(other).0) - 1.0).abs();
        let both = |of: &dyn Fn(&Solved) -> f64| self.fewer.iter().map(|fewer| change(fewer, of)).sum::<f64>();
        let largest = |other: &S| change(other, &|s| s.force).max(change(other, &|s| s.energy));
        let left = [0, 1].map(|k| SAFE * largest(&self.fewer[k]));
        // Of both directions, told twice: a change may be small by where lines and cells happen to lie.
        let again = SAFE_AGAIN * largest(&self.nearer);
        let more = (again / (left[0] + left[1])).max(1.0);
        Told {
            left: left.map(|left| more * left),
            energy: both(&|s| s.energy),
            stiffness: both(&|s| s.stiffness),
            area: self.fewer.iter().map(|fewer| (own(&self.fine).1 / own(fewer).1 - 1.0).abs()).sum(),
            largest: both(&Solved::largest),
        }
    }
}

/// How many cells the next meshes should have in each direction; `None` where that is no more than these, or more than may be solved.
pub(super) fn next(counts: [usize; 2], left: [f64; 2], unknowns: usize, limits: &Limits) -> Option<[usize; 2]> {
    let aim = AIM * limits.tolerance;
    let more = [0, 1].map(|k| wanted(counts[k], left[k], ORDER, aim));
    let more = if more == counts { counts.map(|n| n + n / 4) } else { more };
    // No more of both together than may be solved.
    let growth = |more: [usize; 2]| (more[0] * more[1]) as f64 / (counts[0] * counts[1]) as f64;
    let most = limits.unknowns as f64 / unknowns as f64;
    let less = (most / growth(more)).min(1.0).sqrt();
    let more = more.map(|n| (less * n as f64) as usize);
    (less >= 1.0 || growth(more) >= LEAST_GROWTH).then_some(more)
}
