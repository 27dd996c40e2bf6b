//! The safe method: modified proportioning with reduced gradient projections (Dostal & Schoeberl,
//! Comput. Optim. Appl. 30 (2005) 23). Every step lowers the energy J = p.A p/2 - f.p and keeps p >= 0; it converges
//! for every symmetric positive definite A. Slower than [`super::faces`] where that works.
//!
//! With the gradient g = A p - f: free part phi_i = g_i where p_i > 0, chopped part beta_i = min(g_i, 0) where p_i = 0.
//! While |beta| is not the larger, conjugate gradients on the face, cut at the first pressure that vanishes and followed by
//! a projected step of fixed length 1/|A|; else a step along -beta.

use super::Operators;
use super::level::{Level, State, occupied};
use super::operator::Scratch;
use crate::numeric::simd::dot;

/// From p >= 0 with its residual to the tolerance: true. False when the limit of products is met first. Operators of the whole grid.
pub(super) fn minimise(level: &Level, operators: &Operators, state: &mut State, scratch: &mut Scratch) -> bool {
    let n = level.f.len();
    let [width, height] = level.shape;
    let Some(compliance) = &operators.compliance else { return false };
    let fixed = 1.0 / operators.norm;
    let (mut z, mut d, mut work) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    // The preconditioner works in single precision.
    let (mut given, mut taken) = (vec![0.0_f32; n], vec![0.0_f32; n]);
    let mut restart = true;
    let mut rz_old = 0.0;
    let mut since = 0;
    while !level.is_exhausted(state) {
        if level.error(state, scratch) <= level.tolerance {
            // The residual was carried along: looked at once more from scratch.
            if since == 0 {
                return true;
            }
            level.refresh(operators, state, scratch);
            (since, restart) = (0, true);
            continue;
        }
        let (mut free, mut chopped) = (0.0, 0.0);
        for (&p, &r) in state.p.iter().zip(&state.r) {
            if p > 0.0 {
                free += r * r;
            } else if r > 0.0 {
                chopped += r * r;
            }
        }
        let proportional = chopped <= free;
        if proportional {
            for ((w, p), r) in work.iter_mut().zip(&state.p).zip(&state.r) {
                *w = if *p > 0.0 { *r } else { 0.0 };
            }
            let largest = work.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
            for (given, w) in given.iter_mut().zip(&work) {
                *given = (w / largest) as f32;
            }
            let rows = occupied(&given, width);
            taken.fill(0.0);
            operators.near.preconditioner.product(&given, rows.clone(), &mut taken, rows, scratch);
            for (z, taken) in z.iter_mut().zip(&taken) {
                *z = largest * f64::from(*taken);
            }
            // work is r on the face: its product with z leaves out the rest.
            let rz = dot(&z, &work);
            let beta = if restart { 0.0 } else { rz / rz_old };
            for ((d, z), p) in d.iter_mut().zip(&z).zip(&state.p) {
                *d = if *p > 0.0 { z + beta * *d } else { 0.0 };
            }
            (rz_old, restart) = (rz, false);
        } else {
            for ((d, p), r) in d.iter_mut().zip(&state.p).zip(&state.r) {
                *d = if *p > 0.0 { 0.0 } else { r.max(0.0) };
            }
            restart = true;
        }
        compliance.product(&d, occupied(&d, width), &mut work, 0..height, scratch);
        state.products += 1;
        state.iterations += 1;
        since += 1;
        let (dr, dad) = (dot(&d, &state.r), dot(&d, &work));
        let feasible = d
            .iter()
            .zip(&state.p)
            .filter(|(d, _)| **d < 0.0)
            .fold(f64::INFINITY, |least: f64, (d, p)| least.min(-p / d));
        if !(dad > 0.0 && dr > 0.0) {
            // Rounding has eaten the direction: start again from a fresh residual, or give up if it was fresh.
            if since == 1 {
                return false;
            }
            level.refresh(operators, state, scratch);
            (since, restart) = (0, true);
            continue;
        }
        let alpha = (dr / dad).min(feasible);
        for (((p, r), d), ad) in state.p.iter_mut().zip(&mut state.r).zip(&d).zip(&work) {
            *p = (*p + alpha * d).max(0.0);
            *r -= alpha * ad;
        }
        if alpha == feasible {
            // Cells at the bound leave at once: projected step along the free gradient.
            for (p, r) in state.p.iter_mut().zip(&state.r) {
                if *p > 0.0 {
                    *p = (*p + fixed * r).max(0.0);
                }
            }
            level.refresh(operators, state, scratch);
            (since, restart) = (0, true);
        }
    }
    level.refresh(operators, state, scratch);
    level.error(state, scratch) <= level.tolerance
}
