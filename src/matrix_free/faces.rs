//! One grid: primal-dual faces, each relaxed by preconditioned conjugate gradients.
//!
//! A face is a guess of the contact. On it A p = f is relaxed until the residual has fallen by a fraction; then the
//! cells in tension leave and the penetrating cells enter. In the terms of Hintermueller, Ito & Kunisch
//! (SIAM J. Optim. 13 (2002) 865) the new face is { p + c (f - A p) > 0 }, a semismooth Newton step solved inexactly.
//! The preconditioner is the mask of the face on both sides of an unpadded circulant (as Vollebregt, J. Comput. Phys. 257
//! (2014) 333). A departure: the step that takes p to zero in the cells that leave also takes the first step
//! on the new face, with the length that the last face ended with and with what the cells that leave will do to their
//! neighbours; a change of face costs no product of its own.
//!
//! All of this runs in single precision on the residual, which single precision can follow down to [`FALL`] of where it
//! began. Then it is computed anew in double precision, from a pressure that is kept in double precision throughout:
//! iterative refinement (Wilkinson 1963). Nothing is believed but the residual of the last double-precision product.
//!
//! No proof of convergence covers every A. When the residual stops falling, [`super::monotone`] takes over, which has one.

use std::ops::Range;

use super::convolution::Convolution;
use super::operator::Scratch;

/// Fall of the residual on a face before the face is looked at again.
const INNER: f32 = 0.2;

/// The residual on the face that is aimed at, in tolerances: what is left is for the pressures rounded up to zero.
const AIM: f64 = 0.9;

/// Fall of the residual that single precision can follow: measured, it has then lost a tenth of its digits at most.
pub(super) const FALL: f64 = 2e-6;

/// Length of a step whose direction has no product yet; those of conjugate gradients are 0.3 to 0.6.
const STEP: f64 = 0.4;

/// Offsets, in cells, as far as the displacement by a cell that leaves is foreseen.
pub(super) const NEAR: usize = 8;

/// Changes of face without halving the residual before the face is given up.
const PATIENCE: i32 = 12;

/// Double-precision products without halving the error before the safe method takes over.
const MOST_STALLS: usize = 2;

/// The discrete problem on a box of cells, in units of the largest overlap and with A = 1 from a cell to itself: p and r are
/// then of one size.
pub(super) struct Level<'a> {
    /// Overlap in each cell.
    pub(super) f: &'a [f64],
    /// The compliance; none where a start for the next grid is all that is wanted.
    pub(super) compliance: Option<&'a Convolution<f64>>,
    pub(super) single: &'a Convolution<f32>,
    pub(super) preconditioner: &'a Convolution<f32>,
    /// A at offsets below [`NEAR`], row by row.
    pub(super) near: &'a [[f32; NEAR]; NEAR],
    pub(super) mirrored: bool,
    /// Largest error of the gap allowed.
    pub(super) tolerance: f64,
    /// Products allowed.
    pub(super) limit: usize,
}

/// Pressure and what belongs to it.
pub(super) struct State {
    pub(super) p: Vec<f64>,
    /// f - A p in every cell, when it was last computed in double precision.
    pub(super) r: Vec<f64>,
    pub(super) iterations: usize,
    /// Products in double precision.
    pub(super) products: usize,
    /// Products in single precision.
    pub(super) single_products: usize,
}

impl State {
    pub(super) fn from(p: Vec<f64>) -> Self {
        Self { p, r: Vec::new(), iterations: 0, products: 0, single_products: 0 }
    }

    pub(super) fn all_products(&self) -> usize {
        self.products + self.single_products
    }
}

impl Level<'_> {
    pub(super) fn shape(&self) -> [usize; 2] {
        self.single.shape()
    }

    /// f - A p from scratch, where there is a compliance in double precision.
    pub(super) fn refresh(&self, state: &mut State, scratch: &mut Scratch) {
        let [width, height] = self.shape();
        state.r.resize(state.p.len(), 0.0);
        let given = occupied(&state.p, width);
        let Some(compliance) = self.compliance.filter(|_| !given.is_empty()) else {
            state.r.copy_from_slice(self.f);
            return;
        };
        compliance.product(&state.p, given, &mut state.r, 0..height, scratch);
        for (r, f) in state.r.iter_mut().zip(self.f) {
            *r = f - *r;
        }
        state.products += 1;
    }

    /// Adds to the residual on the face what it will be more by near the cells that leave.
    fn foresee(&self, p: &[f64], cells: Range<usize>, face: &[f32], residual: &mut [f32]) {
        let [width, height] = self.shape();
        let reach = |at: usize, end: usize| at.saturating_sub(NEAR - 1)..(at + NEAR).min(end);
        for (k, _) in p[cells.clone()].iter().zip(face).enumerate().filter(|(_, (p, m))| **m == 0.0 && **p != 0.0) {
            let k = cells.start + k;
            let (i, j, p) = (k % width, k / width, p[k] as f32);
            let mut add = |row: usize, offset: usize| {
                for x in reach(i, width) {
                    if let Some(1.0) = (row * width + x).checked_sub(cells.start).and_then(|at| face.get(at)).copied() {
                        residual[row * width + x] += p * self.near[offset][x.abs_diff(i)];
                    }
                }
            };
            reach(j, height).for_each(|row| add(row, row.abs_diff(j)));
            if self.mirrored {
                // From the image at -1 - j.
                (0..height.min(NEAR.saturating_sub(j + 1))).for_each(|row| add(row, row + j + 1));
            }
        }
    }

    /// Largest |f - A p| where there is pressure and largest f - A p elsewhere. Only for p >= 0.
    pub(super) fn error(&self, state: &State) -> f64 {
        super::error(&state.p, &state.r)
    }
}

/// Rows from the first to the last that hold a number other than zero.
pub(super) fn occupied<T: PartialEq + Default>(field: &[T], width: usize) -> Range<usize> {
    let holds = |row: &&[T]| row.iter().any(|v| *v != T::default());
    let rows = field.len() / width;
    let before = field.chunks_exact(width).take_while(|row| !holds(row)).count();
    let after = field.chunks_exact(width).rev().take_while(|row| !holds(row)).count();
    if before == rows { 0..0 } else { before..rows - after }
}

/// Fields in single precision.
struct Work {
    /// f - A p.
    r: Vec<f32>,
    /// The preconditioned residual.
    z: Vec<f32>,
    /// The direction of the step, and A times it.
    d: Vec<f32>,
    ad: Vec<f32>,
    /// 1 on the face and 0 elsewhere.
    face: Vec<f32>,
}

impl Work {
    fn new(n: usize) -> Self {
        let [r, z, d, ad, face] = [(); 5].map(|()| vec![0.0; n]);
        Self { r, z, d, ad, face }
    }
}

/// Relaxes until the error is within the tolerance: true. False when it stalls or the limit is met; `state` then holds
/// p >= 0 and its residual, recomputed. Without a compliance in double precision the residual is not looked at again.
pub(super) fn relax(level: &Level, state: &mut State, scratch: &mut Scratch) -> bool {
    let mut work = Work::new(state.p.len());
    if level.compliance.is_none() {
        begin(level, state, &mut work, scratch);
        let reached = descend(level, state, &mut work, level.tolerance, scratch);
        project(state);
        return reached;
    }
    level.refresh(state, scratch);
    let mut error = level.error(state);
    let mut stalls = 0;
    while error > level.tolerance {
        if stalls > MOST_STALLS || state.all_products() >= level.limit {
            return false;
        }
        for (single, r) in work.r.iter_mut().zip(&state.r) {
            *single = *r as f32;
        }
        // From the second stall on something was rounded up to zero that mattered: aim lower.
        let goal = level.tolerance.max(FALL * error) * 0.3_f64.powi(stalls as i32);
        descend(level, state, &mut work, goal, scratch);
        project(state);
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
        *r = (f - f64::from(*ad)) as f32;
    }
}

/// Relaxes in single precision until the error is within the tolerance, or as far as it goes.
fn descend(level: &Level, state: &mut State, work: &mut Work, tolerance: f64, scratch: &mut Scratch) -> bool {
    let [width, height] = level.shape();
    let aim = (AIM * tolerance) as f32;
    let mut step = STEP;
    let mut best = (f64::INFINITY, 0_i32);
    work.face.fill(0.0);
    let mut rz_old = 0.0;
    loop {
        // The new face, and how far the present state is from a solution.
        let (mut worst, mut changed, mut leaving) = (0.0_f64, false, false);
        for (((inside, &p), &r), &f) in work.face.iter_mut().zip(&state.p).zip(&work.r).zip(level.f) {
            let r = f64::from(r);
            let is = f > 0.0
                && match *inside > 0.0 {
                    // The cells of a face have made up their minds with the others; what r would still do is theirs to decide.
                    true => p > 0.0,
                    false => p + r > 0.0 && (p > 0.0 || r > 0.5 * tolerance),
                };
            worst = worst.max(if is { r.abs() } else { r.max(p.abs()) });
            let is = f32::from(u8::from(is));
            changed |= is != *inside;
            leaving |= is == 0.0 && p != 0.0;
            *inside = is;
        }
        best = if worst <= 0.5 * best.0 { (worst, 0) } else { (best.0, best.1 + 1) };
        let here = largest(&work.face, &work.r);
        if here <= aim && worst <= tolerance {
            return true;
        }
        if best.1 > PATIENCE || state.all_products() >= level.limit {
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
        let Work { r, z, d, ad, face } = work;
        let (face, z, d) = (&face[cells.clone()], &mut z[..], &mut d[..]);

        // Relax on the face. The first step also empties the cells that left.
        leaving &= changed;
        // Cells that leave and come back were judged too early: the longer nothing is gained, the better a face is solved.
        let fall = INNER.powi(1 + (best.1 / 2).min(5));
        let mut from = here;
        let mut first = changed || rz_old == 0.0;
        while state.all_products() < level.limit {
            // z = mask C mask r.
            for ((w, m), r) in ad[cells.clone()].iter_mut().zip(face).zip(&r[cells.clone()]) {
                *w = m * r;
            }
            if leaving {
                level.foresee(&state.p, cells.clone(), face, ad);
            }
            level.preconditioner.product(ad, rows.clone(), z, rows.clone(), scratch);
            for (z, m) in z[cells.clone()].iter_mut().zip(face) {
                *z *= m;
            }
            let rz = dot(&z[cells.clone()], &r[cells.clone()]);
            let (z, direction) = (&z[cells.clone()], &mut d[cells.clone()]);
            let p = &mut state.p[cells.clone()];
            if leaving {
                for (((d, z), m), p) in direction.iter_mut().zip(z).zip(face).zip(&*p) {
                    *d = if *m > 0.0 { step as f32 * z } else { -*p as f32 };
                }
            } else {
                let beta = if first { 0.0 } else { (rz / rz_old) as f32 };
                for (d, z) in direction.iter_mut().zip(z) {
                    *d = z + beta * *d;
                }
            }
            level.single.product(d, rows.clone(), ad, 0..height, scratch);
            let direction = &d[cells.clone()];
            state.single_products += 1;
            state.iterations += 1;
            let mut alpha = 1.0;
            if !leaving {
                let (dr, dad) = (dot(direction, &r[cells.clone()]), dot(direction, &ad[cells.clone()]));
                if !(dad > 0.0 && dr.is_finite()) {
                    break;
                }
                step = dr / dad;
                alpha = step;
            }
            for (p, d) in p.iter_mut().zip(direction) {
                *p += alpha * f64::from(*d);
            }
            for (r, ad) in r.iter_mut().zip(&*ad) {
                *r -= alpha as f32 * ad;
            }
            rz_old = rz;
            first = leaving;
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

/// A face that stays.
pub(super) struct Fixed<'a> {
    pub(super) single: &'a Convolution<f32>,
    pub(super) preconditioner: &'a Convolution<f32>,
    /// 1 on the face and 0 elsewhere.
    pub(super) face: &'a [f32],
}

impl Fixed<'_> {
    /// Lowers the residual to `goal`, as far as `limit` products allow; calls `step` with length and direction of each step.
    /// Returns the products it took.
    pub(super) fn relax(
        &self,
        r: &mut [f32],
        goal: f32,
        limit: usize,
        scratch: &mut Scratch,
        mut step: impl FnMut(f64, &[f32]),
    ) -> usize {
        let (n, rows) = (r.len(), 0..self.single.shape()[1]);
        let [mut z, mut d, mut ad] = [(); 3].map(|()| vec![0.0; n]);
        let mut rz_old = 0.0;
        for products in 0..limit {
            if largest(self.face, r) <= goal {
                return products;
            }
            self.preconditioner.product(r, rows.clone(), &mut z, rows.clone(), scratch);
            let rz = dot(r, &z);
            let beta = if products == 0 { 0.0 } else { (rz / rz_old) as f32 };
            rz_old = rz;
            for ((d, z), m) in d.iter_mut().zip(&z).zip(self.face) {
                *d = m * z + beta * *d;
            }
            self.single.product(&d, rows.clone(), &mut ad, rows.clone(), scratch);
            let alpha = rz / dot(&d, &ad);
            if !alpha.is_finite() {
                return products + 1;
            }
            step(alpha, &d);
            for ((r, ad), m) in r.iter_mut().zip(&ad).zip(self.face) {
                *r -= alpha as f32 * m * ad;
            }
        }
        limit
    }
}

/// Largest |r| on the face.
fn largest(face: &[f32], r: &[f32]) -> f32 {
    let mut most = [0.0_f32; 8];
    let more = |most: &mut f32, m: &f32, r: &f32| {
        let size = (m * r).abs();
        *most = if size > *most { size } else { *most };
    };
    for (face, r) in face.chunks(8).zip(r.chunks(8)) {
        for ((most, m), r) in most.iter_mut().zip(face).zip(r) {
            more(most, m, r);
        }
    }
    most.iter().fold(0.0, |a, b| a.max(*b))
}

/// a . b: short sums side by side in single precision, summed in double.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    let piece = |a: &[f32], b: &[f32]| {
        let mut sums = [0.0_f32; 8];
        for (a, b) in a.chunks(8).zip(b.chunks(8)) {
            for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
                *sum += a * b;
            }
        }
        sums.iter().map(|s| f64::from(*s)).sum::<f64>()
    };
    a.chunks(512).zip(b.chunks(512)).map(|(a, b)| piece(a, b)).sum()
}

fn project(state: &mut State) {
    for p in &mut state.p {
        *p = p.max(0.0);
    }
}
