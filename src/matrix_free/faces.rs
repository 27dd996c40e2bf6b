//! One grid: primal-dual faces, each relaxed by flexible conjugate gradients.
//!
//! A face is a guess of the contact. On it A p = f is relaxed until the residual has fallen by a fraction; then the
//! cells in tension leave and the penetrating cells enter. In the terms of Hintermueller, Ito & Kunisch
//! (SIAM J. Optim. 13 (2002) 865) the new face is { p + c (f - A p) > 0 }, a semismooth Newton step solved inexactly; on the
//! face, where the residual is on its way to zero, the sign of p decides alone (c = 0: what the residual would still change
//! is for the cells of the face together, and measured, cells that left for it came back).
//!
//! The direction of a step is nearly the solution of the same face on a surface that repeats: the unpadded circulant of A, a third
//! of the work of A, with its inverse as preconditioner, the mask of the face on both sides of either (that inverse alone:
//! Vollebregt, J. Comput. Phys. 257 (2014) 333). The circulant misses nothing at the edge of the contact, where the inverse fails,
//! and what it misses far away is smooth: a product with A gains a digit. Directions are conjugate to the last one alone
//! (Notay, SIAM J. Sci. Comput. 22 (2000) 1444), whatever happened to the face in between. A departure: the step that takes p to
//! zero in the cells that leave also takes the first step on the new face, with the length that the last face ended with and
//! with what the cells that leave will do to their neighbours; a change of face costs no product of its own.
//!
//! All of this runs in single precision on the residual, which single precision can follow down to [`FALL`] of where it
//! began. Then it is computed anew in double precision, from a pressure that is kept in double precision throughout:
//! iterative refinement (Wilkinson 1963). Nothing is believed but the residual of the last double-precision product.
//!
//! No proof of convergence covers every A. When the residual stops falling, [`super::monotone`] takes over, which has one.

use super::fixed::{Fixed, STEPS, STEPS_UNDER_LOAD, dot, largest};
use super::level::{Level, State, occupied};
use super::operator::Scratch;

/// Fall of the residual on a face before the face is looked at again.
const INNER: f32 = 0.35;

/// The residual on the face that is aimed at, in tolerances: what is left is for the pressures rounded up to zero.
const AIM: f64 = 0.9;

/// Fall of the residual that single precision can follow: measured, it has then lost a tenth of its digits at most.
pub(super) const FALL: f64 = 2e-6;

/// A tolerance that a residual in single precision is good enough for from the start.
const WITHIN_SINGLE: f64 = 5e-6;

/// Cells that leave are taken out one by one when they are no more: a product is dearer than their sums, and the next step is
/// then free to have its best length.
const FEW: usize = 8;

/// A face of which one cell in so many has changed has a flat punch of its own.
const STALE: usize = 16;

/// Changes of face without halving the residual before the face is given up.
const PATIENCE: i32 = 12;

/// Double-precision products without halving the error before the safe method takes over.
const MOST_STALLS: usize = 2;

/// Fields in single precision.
struct Work {
    /// f - A p.
    r: Vec<f32>,
    /// The preconditioned residual.
    z: Vec<f32>,
    /// The direction of the step, and A times it.
    d: Vec<f32>,
    ad: Vec<f32>,
    /// The residual on the face, used up on the way to z with a direction and its image.
    w: Vec<f32>,
    own: Vec<f32>,
    image: Vec<f32>,
    /// 1 on the face and 0 elsewhere.
    face: Vec<f32>,
    /// Under a load: nearly the pressure of a flat punch on a face before.
    flat: Vec<f32>,
}

impl Work {
    fn new(n: usize) -> Self {
        let [r, z, d, ad, w, own, image, face] = [(); 8].map(|()| vec![0.0; n]);
        Self { r, z, d, ad, w, own, image, face, flat: Vec::new() }
    }
}

/// Relaxes until the error is within the tolerance: true. False when it stalls or the limit is met; `state` then holds
/// p >= 0 and its residual, recomputed. Without a compliance in double precision the residual is not looked at again.
pub(super) fn relax(level: &Level, state: &mut State, scratch: &mut Scratch) -> bool {
    let mut work = Work::new(state.p.len());
    level.scale_to_load(state);
    if level.compliance.is_none() {
        begin(level, state, &mut work, scratch);
        let reached = descend(level, state, &mut work, level.tolerance, scratch);
        project(state);
        return reached;
    }
    if level.tolerance >= WITHIN_SINGLE {
        // The first residual need not be better than the last.
        begin(level, state, &mut work, scratch);
        descend(level, state, &mut work, level.tolerance, scratch);
        project(state);
        level.scale_to_load(state);
    }
    level.refresh(state, scratch);
    let mut error = level.error(state);
    let mut stalls = 0;
    while error > level.tolerance {
        if stalls > MOST_STALLS || level.is_exhausted(state) {
            return false;
        }
        for (single, r) in work.r.iter_mut().zip(&state.r) {
            *single = *r as f32;
        }
        // From the second stall on something was rounded up to zero that mattered: aim lower.
        let goal = level.tolerance.max(FALL * error) * 0.3_f64.powi(stalls as i32);
        descend(level, state, &mut work, goal, scratch);
        project(state);
        level.scale_to_load(state);
        level.refresh(state, scratch);
        let now = level.error(state);
        stalls = if now <= 0.5 * error { 0 } else { stalls + 1 };
        error = now;
    }
    true
}

/// The residual of the start, in single precision.
fn begin(level: &Level, state: &mut State, work: &mut Work, scratch: &mut Scratch) {
    let [width, height] = level.shape();
    let given = occupied(&state.p, width);
    for (d, p) in work.d.iter_mut().zip(&state.p) {
        *d = *p as f32;
    }
    if given.is_empty() {
        work.ad.fill(0.0);
    } else {
        level.single.product(&work.d, given, &mut work.ad, 0..height, scratch);
        state.single_products += 1;
    }
    for ((r, f), ad) in work.r.iter_mut().zip(level.f).zip(&work.ad) {
        *r = (f + state.deeper - f64::from(*ad)) as f32;
    }
}

/// Relaxes in single precision until the error is within the tolerance, or as far as it goes.
fn descend(level: &Level, state: &mut State, work: &mut Work, tolerance: f64, scratch: &mut Scratch) -> bool {
    let [width, height] = level.shape();
    let aim = (AIM * tolerance) as f32;
    let mut step = 1.0;
    let mut best = (f64::INFINITY, 0_i32);
    work.face.fill(0.0);
    let mut dad_old = 0.0;
    // Cells that joined or left the face since the flat punch was found, and those of the face then.
    let (mut stale, mut known) = (0, 0);
    if level.load.is_some() {
        // Weighted by the pressures that are there.
        let (sum, moment) =
            state.p.iter().zip(&work.r).fold((0.0, 0.0), |(s, m), (p, r)| (s + p, m + p * f64::from(*r)));
        if sum > 0.0 {
            deepen(&mut state.deeper, &mut work.r, -moment / sum);
        }
    }
    loop {
        // The new face, and how far the present state is from a solution.
        let (mut worst, mut changed, mut leaving) = (0.0_f64, false, false);
        for (((inside, &p), &r), &f) in work.face.iter_mut().zip(&state.p).zip(&work.r).zip(level.f) {
            let r = f64::from(r);
            let is = f + state.deeper > 0.0
                && match *inside > 0.0 {
                    true => p > 0.0,
                    false => p + r > 0.0 && (p > 0.0 || r > 0.5 * tolerance),
                };
            worst = worst.max(if is { r.abs() } else { r.max(p.abs()) });
            let is = f32::from(u8::from(is));
            changed |= is != *inside;
            stale += usize::from(is != *inside);
            leaving |= is == 0.0 && p != 0.0;
            *inside = is;
        }
        best = if worst <= 0.5 * best.0 { (worst, 0) } else { (best.0, best.1 + 1) };
        let here = largest(&work.face, &work.r);
        if here <= aim && worst <= tolerance {
            return true;
        }
        if best.1 > PATIENCE || level.is_exhausted(state) {
            return false;
        }
        // Rows in which anything happens: the face and what leaves it.
        let mut rows = occupied(&work.face, width);
        if leaving {
            let loaded = occupied(&state.p, width);
            rows = if rows.is_empty() { loaded } else { rows.start.min(loaded.start)..rows.end.max(loaded.end) };
        }
        if rows.is_empty() {
            return true;
        }
        let cells = rows.start * width..rows.end * width;
        let Work { r, z, d, ad, w, own, image, face, flat } = work;
        let steps = if level.load.is_some() { STEPS_UNDER_LOAD } else { STEPS };
        let periodic = level.periodic.map(|periodic| (periodic, steps));
        let near_inverse = Fixed { single: level.single, periodic, preconditioner: level.preconditioner, face };
        if level.load.is_some() && STALE * stale >= known {
            flat.resize(face.len(), 0.0);
            w[cells.clone()].copy_from_slice(&face[cells.clone()]);
            near_inverse.approach(w, flat, [own, image], rows.clone(), scratch);
            (stale, known) = (0, face[cells.clone()].iter().filter(|m| **m > 0.0).count());
        }
        let (face, z, d) = (&face[cells.clone()], &mut z[..], &mut d[..]);
        let flat = if level.load.is_some() { &mut flat[cells.clone()] } else { &mut [] };
        flat.iter_mut().zip(face).for_each(|(flat, m)| *flat *= m);
        let stiffness = sum(flat);
        if level.load.is_some() {
            let by = -dot(flat, &r[cells.clone()]) / stiffness;
            deepen(&mut state.deeper, r, by);
        }

        // Relax on the face. The first step also empties the cells that left.
        leaving &= changed;
        if leaving {
            let left = cells.clone().zip(face).filter(|(k, m)| **m == 0.0 && state.p[*k] != 0.0);
            let left: Vec<usize> = left.map(|(k, _)| k).take(FEW + 1).collect();
            if left.len() <= FEW && level.load.is_none() {
                left.into_iter().for_each(|k| level.take_out(&mut state.p, k, r));
                leaving = false;
            }
        }
        // Cells that leave and come back were judged too early: the longer nothing is gained, the better a face is solved.
        let fall = INNER.powi(1 + (best.1 / 2).min(5));
        let mut from = here;
        while !level.is_exhausted(state) {
            // z, near the solution on the face for the residual.
            for ((w, m), r) in w[cells.clone()].iter_mut().zip(face).zip(&r[cells.clone()]) {
                *w = m * r;
            }
            if leaving {
                level.foresee(&state.p, cells.clone(), face, w);
            }
            near_inverse.approach(w, z, [own, image], rows.clone(), scratch);
            let zad = dot(&z[cells.clone()], &ad[cells.clone()]);
            let (z, direction) = (&z[cells.clone()], &mut d[cells.clone()]);
            let p = &mut state.p[cells.clone()];
            if leaving {
                for (((d, z), m), p) in direction.iter_mut().zip(z).zip(face).zip(&*p) {
                    *d = if *m > 0.0 { step as f32 * z } else { -*p as f32 };
                }
            } else if dad_old == 0.0 {
                direction.copy_from_slice(z);
            } else {
                let beta = (-zad / dad_old).max(0.0) as f32;
                for ((d, z), m) in direction.iter_mut().zip(z).zip(face) {
                    *d = z + beta * m * *d;
                }
            }
            if let Some(load) = level.load {
                // The load stays; what the cells that leave carried goes where a flat punch would carry it.
                let missing = if leaving { load - p.iter().sum::<f64>() } else { 0.0 };
                let share = ((missing - sum(direction)) / stiffness) as f32;
                direction.iter_mut().zip(&*flat).for_each(|(d, flat)| *d += share * flat);
            }
            level.single.product(d, rows.clone(), ad, 0..height, scratch);
            let direction = &d[cells.clone()];
            state.single_products += 1;
            state.iterations += 1;
            let mut alpha = 1.0;
            if leaving {
                dad_old = 0.0;
            } else {
                let (dr, dad) = (dot(direction, &r[cells.clone()]), dot(direction, &ad[cells.clone()]));
                if !(dad > 0.0 && dr.is_finite()) {
                    dad_old = 0.0;
                    break;
                }
                step = dr / dad;
                dad_old = dad;
                alpha = step;
            }
            for (p, d) in p.iter_mut().zip(direction) {
                *p += alpha * f64::from(*d);
            }
            for (r, ad) in r.iter_mut().zip(&*ad) {
                *r -= alpha as f32 * ad;
            }
            if level.load.is_some() {
                let by = -dot(flat, &r[cells.clone()]) / stiffness;
                deepen(&mut state.deeper, r, by);
            }
            let now = largest(face, &r[cells.clone()]);
            if leaving {
                // p - p, to the last bit.
                for (p, m) in p.iter_mut().zip(face) {
                    *p *= f64::from(*m);
                }
                leaving = false;
                from = now;
            }
            if now <= (fall * from).max(aim) {
                break;
            }
        }
    }
}

/// Moves every cell by as much.
fn deepen(deeper: &mut f64, r: &mut [f32], by: f64) {
    if by.is_finite() {
        *deeper += by;
        r.iter_mut().for_each(|r| *r += by as f32);
    }
}

/// Of all numbers: short sums in single precision, summed in double.
fn sum(numbers: &[f32]) -> f64 {
    let piece = |numbers: &[f32]| {
        let mut sums = [0.0_f32; 8];
        for numbers in numbers.chunks(8) {
            sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
        }
        sums.iter().map(|s| f64::from(*s)).sum::<f64>()
    };
    numbers.chunks(512).map(piece).sum()
}

fn project(state: &mut State) {
    for p in &mut state.p {
        *p = p.max(0.0);
    }
}
