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
const INNER: f64 = 0.1;

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
    // 1 on the face and 0 elsewhere.
    let mut face = vec![0.0; n];
    let mut step = 1.0;
    let mut best = (f64::INFINITY, 0);
    let mut aim = AIM * level.tolerance;
    loop {
        // The new face, and how far the present state is from a solution.
        let (mut worst, mut changed, mut leaving) = (0.0_f64, false, false);
        for (((inside, &p), &r), &f) in face.iter_mut().zip(&state.p).zip(&state.r).zip(level.f) {
            let is = f > 0.0 && p + c * r > 0.0 && (p > 0.0 || r > 0.5 * level.tolerance);
            worst = worst.max(if is { r.abs() } else { r.max(p.abs() / c) });
            let is = f64::from(is);
            changed |= is != *inside;
            leaving |= is == 0.0 && p != 0.0;
            *inside = is;
        }
        best = if worst <= 0.5 * best.0 { (worst, 0) } else { (best.0, best.1 + 1) };
        let here = residual_on(&face, &state.r);
        let done = here <= aim && worst <= level.tolerance;
        if done || best.1 > PATIENCE || state.products >= level.limit {
            project(state);
            level.refresh(state, scratch);
            if !done || level.error(state) <= level.tolerance {
                return level.error(state) <= level.tolerance;
            }
            // What was rounded up to zero was too much: aim lower.
            aim *= 0.3;
            continue;
        }

        // Relax on the face. The first step also empties the cells that left.
        leaving &= changed;
        let mut from = here;
        let mut rz_old = 0.0;
        let mut first = true;
        while state.products < level.limit {
            // z = mask C mask r.
            for ((w, m), r) in ad.iter_mut().zip(&face).zip(&state.r) {
                *w = m * r;
            }
            let rows = occupied(&ad, width);
            let cells = rows.start * width..rows.end * width;
            level.preconditioner.apply(&ad, rows.clone(), &mut z, rows, scratch);
            z[..cells.start].fill(0.0);
            z[cells.end..].fill(0.0);
            let mut rz = 0.0;
            for ((z, m), r) in z[cells.clone()].iter_mut().zip(&face[cells.clone()]).zip(&state.r[cells]) {
                *z *= m;
                rz += *z * r;
            }
            if leaving {
                for (((d, z), m), p) in d.iter_mut().zip(&z).zip(&face).zip(&state.p) {
                    *d = if *m > 0.0 { step * z } else { -p };
                }
            } else {
                let beta = if first { 0.0 } else { rz / rz_old };
                for (d, z) in d.iter_mut().zip(&z) {
                    *d = z + beta * *d;
                }
            }
            let given = occupied(&d, width);
            if given.is_empty() {
                break;
            }
            level.compliance.apply(&d, given, &mut ad, level.rows(), scratch);
            state.products += 1;
            state.iterations += 1;
            let mut alpha = 1.0;
            if !leaving {
                let (dr, dad) = (dot(&d, &state.r), dot(&d, &ad));
                if !(dad > 0.0 && dr.is_finite()) {
                    break;
                }
                step = dr / dad;
                alpha = step;
            }
            for (((p, r), d), ad) in state.p.iter_mut().zip(&mut state.r).zip(&d).zip(&ad) {
                *p += alpha * d;
                *r -= alpha * ad;
            }
            rz_old = rz;
            first = leaving;
            let now = residual_on(&face, &state.r);
            if leaving {
                // p - p, to the last bit.
                for (p, m) in state.p.iter_mut().zip(&face) {
                    *p *= m;
                }
                leaving = false;
                from = now;
            }
            if now <= (INNER * from).max(aim) {
                break;
            }
        }
    }
}

/// Largest |r| on the face.
fn residual_on(face: &[f64], r: &[f64]) -> f64 {
    face.iter().zip(r).fold(0.0, |e: f64, (m, r)| e.max((m * r).abs()))
}

/// a . b, in eight sums side by side.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (mut sums, whole) = ([0.0; 8], a.len() / 8 * 8);
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + a[whole..].iter().zip(&b[whole..]).map(|(a, b)| a * b).sum::<f64>()
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
