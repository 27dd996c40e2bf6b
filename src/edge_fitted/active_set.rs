//! p >= 0, S p - f >= 0, p (S p - f) = 0 on the orbits of cells: block pivoting on dense Cholesky factors.
//!
//! As Kalker's NORM and Hartnett: drop negative pressures, add penetrating cells, solve again. Here the energy
//! <p, S p>/2 - <f, p> of the clipped pressure is watched: a round that does not lower it adds the worst cell only.

use super::cholesky::Cholesky;
use super::compliance::Compliance;

/// Rounds before the best pressure so far is returned.
const ROUNDS: usize = 100;

/// Solves with the cells of `contact` only: S p = rhs there, p = 0 elsewhere.
pub(crate) fn factor(s: &Compliance, contact: &[bool]) -> Option<Cholesky> {
    let cells: Vec<usize> = (0..s.n).filter(|&i| contact[i]).collect();
    let mut matrix = Vec::with_capacity(cells.len() * cells.len());
    for &i in &cells {
        matrix.extend(cells.iter().map(|&j| s.matrix[i * s.n + j]));
    }
    Cholesky::new(matrix, cells.len())
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
    let mut contact: Vec<bool> = rhs.iter().map(|f| *f > 0.0).collect();
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut careful = false;
    for _ in 0..ROUNDS {
        let Some(l) = factor(s, &contact) else { break };
        let mut p = solve_on(&l, &contact, rhs);
        let u = s.product(&p);
        let scale = rhs.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        let negative: Vec<usize> = (0..s.n).filter(|&i| contact[i] && p[i] < 0.0).collect();
        let penetrating: Vec<usize> =
            (0..s.n).filter(|&i| !contact[i] && rhs[i] > 0.0 && u[i] - rhs[i] < -1e-12 * scale.min(rhs[i])).collect();
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
