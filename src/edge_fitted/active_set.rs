//! p >= 0, S p - f >= 0, p (S p - f) = 0 on the orbits of cells: block pivoting on dense Cholesky factors.
//!
//! As Kalker's NORM and Hartnett: drop negative pressures, add penetrating cells, solve again. Here the energy
//! <p, S p>/2 - <f, p> of the clipped pressure is watched: a round that does not lower it adds the worst cell only.

use nalgebra::{Matrix3, Vector3};

use super::cholesky::Cholesky;
use super::compliance::Compliance;
use crate::clock::Deadline;

/// Rounds before the best pressure so far is returned.
const ROUNDS: usize = 100;

/// Solves with the cells of `contact` only: S p = rhs there, p = 0 elsewhere.
pub(crate) fn factor(s: &Compliance, contact: &[bool]) -> Option<Cholesky> {
    let cells: Vec<usize> = (0..s.n).filter(|&i| contact[i]).collect();
    let mut matrix = vec![0.0; cells.len() * cells.len()];
    // The lower triangle.
    for ((k, &i), row) in cells.iter().enumerate().zip(matrix.chunks_exact_mut(cells.len().max(1))) {
        row.iter_mut().zip(&cells[..=k]).for_each(|(s_ij, &j)| *s_ij = s.matrix[i * s.n + j]);
    }
    Cholesky::new(matrix, cells.len(), s.threads)
}

/// The pressure with S p = rhs on `contact`, given the factor there.
pub(crate) fn solve_on(factor: &Cholesky, contact: &[bool], rhs: &[f64]) -> Vec<f64> {
    let mut x: Vec<f64> = (0..rhs.len()).filter(|&i| contact[i]).map(|i| rhs[i]).collect();
    factor.solve(&mut x);
    let mut out = vec![0.0; rhs.len()];
    let mut next = x.into_iter();
    for (i, p) in out.iter_mut().enumerate() {
        if contact[i] {
            *p = next.next().unwrap_or(0.0);
        }
    }
    out
}

/// Solves the unilateral problem; `rhs` is the integral of f over each orbit, cells with rhs <= 0 are never loaded.
pub(crate) fn solve(s: &Compliance, rhs: &[f64]) -> Vec<f64> {
    solve_within(s, rhs, &vec![true; rhs.len()])
}

/// The same on some of the cells.
pub(crate) fn solve_within(s: &Compliance, rhs: &[f64], set: &[bool]) -> Vec<f64> {
    settled(s, rhs, set.to_vec(), |i| set[i])
}

/// The same, beginning with the cells where `p` is positive.
pub(crate) fn solve_from(s: &Compliance, rhs: &[f64], p: &[f64]) -> Vec<f64> {
    settled(s, rhs, p.iter().map(|p| *p > 0.0).collect(), |_| true)
}

fn settled(s: &Compliance, rhs: &[f64], mut contact: Vec<bool>, within: impl Fn(usize) -> bool) -> Vec<f64> {
    let allowed = |i: usize| within(i) && rhs[i] > 0.0;
    contact.iter_mut().enumerate().for_each(|(i, c)| *c &= allowed(i));
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut careful = false;
    for _ in 0..ROUNDS {
        let Some(l) = factor(s, &contact) else { break };
        let mut p = solve_on(&l, &contact, rhs);
        let u = s.product(&p);
        let scale = rhs.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        let negative: Vec<usize> = (0..s.n).filter(|&i| contact[i] && p[i] < 0.0).collect();
        let penetrating: Vec<usize> =
            (0..s.n).filter(|&i| !contact[i] && allowed(i) && u[i] - rhs[i] < -1e-12 * scale.min(rhs[i])).collect();
        if negative.is_empty() && penetrating.is_empty() {
            return p;
        }
        for v in &mut p {
            *v = v.max(0.0);
        }
        let energy: f64 = s.product(&p).iter().zip(rhs).zip(&p).map(|((u, f), p)| p * (0.5 * u - f)).sum();
        let lower = best.as_ref().is_none_or(|b| energy < b.0);
        if lower {
            best = Some((energy, p));
        }
        careful = careful || !lower;
        if careful && negative.is_empty() {
            let worst = penetrating.iter().copied().min_by(|&i, &j| (u[i] - rhs[i]).total_cmp(&(u[j] - rhs[j])));
            if let Some(i) = worst {
                contact[i] = true;
            }
        } else {
            for i in negative {
                contact[i] = false;
            }
            if !careful {
                for i in penetrating {
                    contact[i] = true;
                }
            }
        }
    }
    best.map_or_else(|| vec![0.0; s.n], |b| b.1)
}

/// The pressures m_j that displace some of the cells by (1, x, y)_j.
pub(crate) struct Planes(pub [Vec<f64>; 3]);

impl Planes {
    /// `weights`: the integrals of 1, x, y over each cell.
    pub fn on(s: &Compliance, weights: &[Vec<f64>; 3], contact: &[bool]) -> Option<Self> {
        let own = factor(s, contact)?;
        Some(Self([0, 1, 2].map(|k| solve_on(&own, contact, &weights[k]))))
    }

    /// K_ij = <(1, x, y)_i, m_j>.
    pub fn stiffness(&self, weights: &[Vec<f64>; 3]) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.0[j].iter().zip(&weights[i]).map(|(m, w)| m * w).sum::<f64>())
    }

    /// The pressure that displaces them by g . (1, x, y).
    pub fn combined(&self, g: &Vector3<f64>) -> Vec<f64> {
        let [one, x, y] = &self.0;
        (0..one.len()).map(|i| g[0] * one[i] + g[1] * x[i] + g[2] * y[i]).collect()
    }
}

/// The pressure p >= 0 with given integrals of p, p x and p y (`weights`: of 1, x, y over each cell), and the plane g that it balances
/// at: S p >= g . weights, equal where p > 0. On a set of cells the pressure is the combination of those of three unit planes that has the
/// integrals; negative ones are dropped, penetrating cells added, all at once while that lowers their number, one by one else (Judice &
/// Pires 1994). The first set is where `p` is positive. `None` where no pressure balances, as far as it was looked, and once the time is
/// used up.
pub(crate) fn balance(
    s: &Compliance,
    weights: &[Vec<f64>; 3],
    wanted: Vector3<f64>,
    p: &[f64],
    deadline: Deadline,
) -> Option<(Vec<f64>, Vector3<f64>)> {
    let n = s.n;
    let mut contact: Vec<bool> = p.iter().map(|p| *p > 0.0).collect();
    // The least number of wrong cells so far, and rounds that may pass without a lower one.
    let (mut fewest, mut patience) = (n + 1, PATIENCE);
    for _ in 0..ROUNDS {
        if deadline.has_passed() {
            return None;
        }
        let planes = Planes::on(s, weights, &contact)?;
        let g = planes.stiffness(weights).try_inverse()? * wanted;
        let p = planes.combined(&g);
        let u = s.product(&p);
        let f = |i: usize| g[0] * weights[0][i] + g[1] * weights[1][i] + g[2] * weights[2][i];
        let size =
            |i: usize| (g[0] * weights[0][i]).abs() + (g[1] * weights[1][i]).abs() + (g[2] * weights[2][i]).abs();
        let negative = |i: usize| contact[i] && p[i] < 0.0;
        let penetrating = |i: usize| !contact[i] && u[i] - f(i) < -1e-12 * size(i);
        let wrong: Vec<usize> = (0..n).filter(|&i| negative(i) || penetrating(i)).collect();
        if wrong.is_empty() {
            return Some((p, g));
        }
        if wrong.len() < fewest {
            (fewest, patience) = (wrong.len(), PATIENCE);
        } else {
            patience = patience.saturating_sub(1);
        }
        let all = patience > 0;
        for &i in wrong.iter().rev().take(if all { n } else { 1 }) {
            contact[i] = !contact[i];
        }
    }
    None
}

/// Rounds in which the number of wrong cells need not fall.
const PATIENCE: usize = 6;
