//! Complementarity to rounding: solve on the cells in contact by a dense Cholesky factor, drop cells in tension, take
//! in cells that penetrate, repeat.
//!
//! All changes at once (Kalker's NORM, Hartnett 1980) is fast and ends in three to seven rounds, without proof. When the
//! number of wrong cells has not fallen for a few rounds, only the last wrong cell is changed, which must end for
//! any positive definite matrix (Murty 1974); the mixture is that of Judice & Pires, Comput. Oper. Res. 21, 587 (1994).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::{Mat, Par, Spec};

use super::reduced::Reduced;
use crate::clock::Deadline;

/// Rounds after which the set is taken to cycle.
const MOST_ROUNDS: usize = 500;

/// Rounds without progress that are allowed before single changes.
const PATIENCE: usize = 8;

/// Gap and tension, relative to the largest overlap and pressure, that count as zero.
const ROUNDING: f64 = 1e-13;

/// What the rounds end with.
pub(super) struct Outcome {
    /// y of [`Reduced`].
    pub pressure: Vec<f64>,
    /// Whether every condition holds to rounding.
    pub closed: bool,
    pub factorisations: usize,
}

/// From all candidates in contact.
pub(super) fn solve(reduced: &Reduced, deadline: Deadline) -> Outcome {
    rounds(reduced, vec![true; reduced.len()], deadline).unwrap_or_else(|factorisations| Outcome {
        pressure: vec![0.0; reduced.len()],
        closed: false,
        factorisations,
    })
}

/// From an interior point: a cell touches when its pressure, relative to the largest, exceeds its relative gap.
/// Keeps the interior point, cut to y >= 0, when the rounds do not end.
pub(super) fn polish(reduced: &Reduced, interior: &[f64], deadline: Deadline) -> Outcome {
    let strongest = interior.iter().zip(&reduced.weight).map(|(y, w)| y / w).fold(0.0, f64::max);
    let touching = (0..reduced.len())
        .map(|k| {
            let gap = product(reduced, k, interior) - reduced.overlap[k];
            interior[k] / strongest > gap
        })
        .collect();
    rounds(reduced, touching, deadline).unwrap_or_else(|factorisations| Outcome {
        pressure: interior.iter().map(|y| y.max(0.0)).collect(),
        closed: false,
        factorisations,
    })
}

fn product(reduced: &Reduced, row: usize, y: &[f64]) -> f64 {
    reduced.matrix.col_as_slice(row).iter().zip(y).map(|(s, y)| s * y).sum()
}

fn rounds(reduced: &Reduced, mut touching: Vec<bool>, deadline: Deadline) -> Result<Outcome, usize> {
    let n = reduced.len();
    let (mut fewest_wrong, mut patience) = (usize::MAX, PATIENCE);
    for round in 1..=MOST_ROUNDS {
        if deadline.has_passed() {
            return Err(round - 1);
        }
        let set: Vec<usize> = (0..n).filter(|&k| touching[k]).collect();
        let y = on_set(reduced, &set).ok_or(round)?;
        let strongest = y.iter().zip(&reduced.weight).map(|(y, w)| y / w).fold(0.0, f64::max);
        let wrong: Vec<usize> = (0..n)
            .filter(|&k| {
                if touching[k] {
                    y[k] < -ROUNDING * strongest * reduced.weight[k]
                } else {
                    let u: f64 = set.iter().map(|&m| reduced.matrix[(m, k)] * y[m]).sum();
                    reduced.overlap[k] - u > ROUNDING * reduced.weight[k]
                }
            })
            .collect();
        if wrong.is_empty() {
            let pressure = y.into_iter().map(|y| y.max(0.0)).collect();
            return Ok(Outcome { pressure, closed: true, factorisations: round });
        }
        if wrong.len() < fewest_wrong {
            (fewest_wrong, patience) = (wrong.len(), PATIENCE);
        } else {
            patience = patience.saturating_sub(1);
        }
        let change = if patience > 0 { &wrong[..] } else { &wrong[wrong.len() - 1..] };
        for &k in change {
            touching[k] = !touching[k];
        }
    }
    Err(MOST_ROUNDS)
}

/// y on the set, zero elsewhere; `None` when the matrix is not positive definite in floating point.
pub(super) fn on_set(reduced: &Reduced, set: &[usize]) -> Option<Vec<f64>> {
    let m = set.len();
    let mut y = vec![0.0; reduced.len()];
    if m == 0 {
        return Some(y);
    }
    let mut factor = Mat::from_fn(m, m, |i, j| reduced.matrix[(set[i], set[j])]);
    let rhs = Mat::from_fn(m, 1, |i, _| reduced.overlap[set[i]]);
    let mut x = rhs.clone();
    // One thread: the caller decides how many cores a solve may take.
    let par = Par::Seq;
    let mut scratch = MemBuffer::new(llt::factor::cholesky_in_place_scratch::<f64>(m, par, Spec::default()));
    let stack = MemStack::new(&mut scratch);
    llt::factor::cholesky_in_place(factor.as_mut(), Default::default(), par, stack, Spec::default()).ok()?;
    llt::solve::solve_in_place(factor.as_ref(), x.as_mut(), par, stack);
    // One step of refinement: the compliance matrix of a fine grid is ill-conditioned enough to cost two digits.
    let mut residual = Mat::from_fn(m, 1, |i, _| {
        reduced.overlap[set[i]] - (0..m).map(|j| reduced.matrix[(set[j], set[i])] * x[(j, 0)]).sum::<f64>()
    });
    llt::solve::solve_in_place(factor.as_ref(), residual.as_mut(), par, stack);
    for (i, &k) in set.iter().enumerate() {
        y[k] = x[(i, 0)] + residual[(i, 0)];
    }
    Some(y)
}
