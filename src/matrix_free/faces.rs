//! One grid: primal-dual faces, each relaxed by preconditioned conjugate gradients.
//!
//! A face is a guess of the contact. On it A p = f is relaxed until the residual has fallen by a fraction; then the
//! cells in tension leave and the penetrating cells enter. In the terms of Hintermueller, Ito & Kunisch
//! (SIAM J. Optim. 13 (2002) 865) the new face is { p + c (f - A p) > 0 }, a semismooth Newton step solved inexactly.
//! The preconditioner is the mask of the face on both sides of an unpadded circulant (as Vollebregt, J. Comput. Phys. 257
//! (2014) 333). A departure: the step that takes p to zero in the cells that leave also takes the first step
//! on the new face, with the length that the last face ended with; a change of face costs no product of its own.
//!
//! No proof of convergence covers every A. When the residual stops falling, [`super::monotone`] takes over, which has one.

use std::ops::Range;

use super::operator::{Operator, Scratch};

/// Fall of the residual on a face before the face is looked at again.
const INNER: f64 = 0.25;

/// The residual on the face that is aimed at, in tolerances: what is left is for the pressures rounded up to zero.
const AIM: f64 = 0.7;

/// Changes of face without halving the residual before the safe method takes over.
const PATIENCE: usize = 12;

/// The discrete problem on a box of cells.
pub(super) struct Level<'a> {
    /// Overlap in each cell.
    pub(super) f: &'a [f64],
    pub(super) compliance: &'a Operator,
    pub(super) preconditioner: &'a Operator,
    /// Largest error of the gap allowed, a length.
    pub(super) tolerance: f64,
    /// Products allowed.
    pub(super) limit: usize,
}

/// Pressure and what belongs to it.
pub(super) struct State {
    pub(super) p: Vec<f64>,
    /// f - A p in every cell.
    pub(super) r: Vec<f64>,
    pub(super) iterations: usize,
    pub(super) products: usize,
}

impl Level<'_> {
    fn width(&self) -> usize {
        self.compliance.shape()[0]
    }

    fn rows(&self) -> Range<usize> {
        0..self.compliance.shape()[1]
    }

    /// f - A p from scratch.
    pub(super) fn refresh(&self, state: &mut State, scratch: &mut Scratch) {
        let given = occupied(&state.p, self.width());
        if given.is_empty() {
            state.r.copy_from_slice(self.f);
            return;
        }
        self.compliance.apply(&state.p, given, &mut state.r, self.rows(), scratch);
        for (r, f) in state.r.iter_mut().zip(self.f) {
            *r = f - *r;
        }
        state.products += 1;
    }

    /// Largest |f - A p| where there is pressure and largest f - A p elsewhere. Only for p >= 0.
    pub(super) fn error(&self, state: &State) -> f64 {
        state.p.iter().zip(&state.r).fold(0.0, |e: f64, (&p, &r)| e.max(if p > 0.0 { r.abs() } else { r }))
    }
}

/// Rows from the first to the last that hold a number other than zero.
pub(super) fn occupied(field: &[f64], width: usize) -> Range<usize> {
    let holds = |row: &&[f64]| row.iter().any(|&v| v != 0.0);
    let rows = field.len() / width;
    let before = field.chunks_exact(width).take_while(|row| !holds(row)).count();
    let after = field.chunks_exact(width).rev().take_while(|row| !holds(row)).count();
    if before == rows { 0..0 } else { before..rows - after }
}

/// Relaxes until the error is within the tolerance: true. False when it stalls or the limit is met; `state` then holds
/// p >= 0 and its residual, recomputed.
pub(super) fn relax(level: &Level, state: &mut State, scratch: &mut Scratch) -> bool {
    let (n, width) = (level.f.len(), level.width());
    // Pressure on one cell per depth it gives: the unit that compares p with r.
    let c = stiffness_of_a_cell(level);
    let (mut z, mut d, mut ad) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut face = vec![false; n];
    let mut step = 1.0;
    let mut best = (f64::INFINITY, 0);
    loop {
        // The new face, and how far the present state is from a solution.
        let mut worst = 0.0_f64;
        let mut changed = false;
        for (k, inside) in face.iter_mut().enumerate() {
            let (p, r) = (state.p[k], state.r[k]);
            let is = level.f[k] > 0.0 && p + c * r > 0.0 && (p > 0.0 || r > 0.5 * level.tolerance);
            worst = worst.max(if is { r.abs() } else { r.max(p.abs() / c) });
            changed |= is != *inside;
            *inside = is;
        }
        if worst <= 0.5 * best.0 {
            best = (worst, 0);
        } else {
            best.1 += 1;
        }
        if best.1 > PATIENCE || state.products >= level.limit {
            project(state);
            level.refresh(state, scratch);
            return level.error(state) <= level.tolerance;
        }
        let on_face = |r: &[f64]| face.iter().zip(r).fold(0.0_f64, |e, (&is, r)| if is { e.max(r.abs()) } else { e });
        if on_face(&state.r) <= AIM * level.tolerance && worst <= level.tolerance {
            project(state);
            level.refresh(state, scratch);
            if level.error(state) <= level.tolerance {
                return true;
            }
            continue;
        }

        // Relax on the face. The first step also empties the cells that left.
        let mut leaving = changed && (0..n).any(|k| !face[k] && state.p[k] != 0.0);
        let mut from = if leaving { f64::INFINITY } else { on_face(&state.r) };
        let mut rz_old = 0.0;
        let mut first = true;
        while state.products < level.limit {
            // z = mask C mask r.
            for k in 0..n {
                ad[k] = if face[k] { state.r[k] } else { 0.0 };
            }
            let rows = occupied(&ad, width);
            if rows.is_empty() && !leaving {
                break;
            }
            level.preconditioner.apply(&ad, rows.clone(), &mut z, rows.clone(), scratch);
            z[..rows.start * width].fill(0.0);
            z[rows.end * width..].fill(0.0);
            let mut rz = 0.0;
            for k in 0..n {
                z[k] = if face[k] { z[k] } else { 0.0 };
                rz += z[k] * state.r[k];
            }
            if leaving {
                for k in 0..n {
                    d[k] = if face[k] { step * z[k] } else { -state.p[k] };
                }
            } else {
                let beta = if first { 0.0 } else { rz / rz_old };
                for k in 0..n {
                    d[k] = if face[k] { z[k] + beta * d[k] } else { 0.0 };
                }
            }
            let given = occupied(&d, width);
            if given.is_empty() {
                break;
            }
            level.compliance.apply(&d, given, &mut ad, level.rows(), scratch);
            state.products += 1;
            state.iterations += 1;
            let alpha = if leaving {
                1.0
            } else {
                let (mut dr, mut dad) = (0.0, 0.0);
                for k in 0..n {
                    dr += d[k] * state.r[k];
                    dad += d[k] * ad[k];
                }
                if !(dad > 0.0 && dr.is_finite()) {
                    break;
                }
                step = dr / dad;
                step
            };
            for k in 0..n {
                state.p[k] += alpha * d[k];
                state.r[k] -= alpha * ad[k];
            }
            rz_old = rz;
            first = leaving;
            let now = on_face(&state.r);
            if leaving {
                for k in 0..n {
                    if !face[k] {
                        state.p[k] = 0.0;
                    }
                }
                leaving = false;
                from = now;
            }
            if now <= (INNER * from).max(AIM * level.tolerance) {
                break;
            }
        }
    }
}

/// 1/A_00, from the mean of the symbol.
fn stiffness_of_a_cell(level: &Level) -> f64 {
    1.0 / level.compliance.at_origin()
}

fn project(state: &mut State) {
    for p in &mut state.p {
        *p = p.max(0.0);
    }
}
