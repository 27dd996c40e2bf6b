//! The safe method: modified proportioning with reduced gradient projections (Dostal & Schoeberl,
//! Comput. Optim. Appl. 30 (2005) 23). Every step lowers the energy J = p.A p/2 - f.p and keeps p >= 0; it converges
//! for every symmetric positive definite A. Slower than [`super::faces`] where that works.
//!
//! With the gradient g = A p - f: free part phi_i = g_i where p_i > 0, chopped part beta_i = min(g_i, 0) where p_i = 0.
//! While |beta| is not the larger, conjugate gradients on the face, cut at the first pressure that vanishes and followed by
//! a projected step of fixed length 1/|A|; else a step along -beta.

use super::faces::{Level, State, occupied};
use super::operator::Scratch;

/// From p >= 0 with its residual to the tolerance: true. False when the limit of products is met first.
pub(super) fn minimise(level: &Level, state: &mut State, scratch: &mut Scratch) -> bool {
    let n = level.f.len();
    let [width, height] = level.compliance.shape();
    let fixed = 1.0 / level.compliance.norm();
    let (mut z, mut d, mut work) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut restart = true;
    let mut rz_old = 0.0;
    let mut since = 0;
    while state.products < level.limit {
        if level.error(state) <= level.tolerance {
            // The residual was carried along: looked at once more from scratch.
            if since == 0 {
                return true;
            }
            level.refresh(state, scratch);
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
            for k in 0..n {
                work[k] = if state.p[k] > 0.0 { state.r[k] } else { 0.0 };
            }
            let rows = occupied(&work, width);
            level.preconditioner.apply(&work, rows.clone(), &mut z, rows.clone(), scratch);
            let mut rz = 0.0;
            for k in 0..n {
                let inside = rows.contains(&(k / width)) && state.p[k] > 0.0;
                z[k] = if inside { z[k] } else { 0.0 };
                rz += z[k] * state.r[k];
            }
            let beta = if restart { 0.0 } else { rz / rz_old };
            for k in 0..n {
                d[k] = if state.p[k] > 0.0 { z[k] + beta * d[k] } else { 0.0 };
            }
            (rz_old, restart) = (rz, false);
        } else {
            for k in 0..n {
                d[k] = if state.p[k] > 0.0 { 0.0 } else { state.r[k].max(0.0) };
            }
            restart = true;
        }
        level.compliance.apply(&d, occupied(&d, width), &mut work, 0..height, scratch);
        state.products += 1;
        state.iterations += 1;
        since += 1;
        let (mut dr, mut dad, mut feasible) = (0.0, 0.0, f64::INFINITY);
        for k in 0..n {
            dr += d[k] * state.r[k];
            dad += d[k] * work[k];
            if d[k] < 0.0 {
                feasible = feasible.min(-state.p[k] / d[k]);
            }
        }
        if !(dad > 0.0 && dr > 0.0) {
            // Rounding has eaten the direction: start again from a fresh residual, or give up if it was fresh.
            if since == 1 {
                return false;
            }
            level.refresh(state, scratch);
            (since, restart) = (0, true);
            continue;
        }
        let alpha = (dr / dad).min(feasible);
        for k in 0..n {
            state.p[k] = (state.p[k] + alpha * d[k]).max(0.0);
            state.r[k] -= alpha * work[k];
        }
        if alpha == feasible {
            // Cells at the bound leave at once: projected step along the free gradient.
            for (p, r) in state.p.iter_mut().zip(&state.r) {
                if *p > 0.0 {
                    *p = (*p + fixed * r).max(0.0);
                }
            }
            level.refresh(state, scratch);
            (since, restart) = (0, true);
        }
    }
    level.refresh(state, scratch);
    level.error(state) <= level.tolerance
}
