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

use super::Operators;
use super::fields::{Fields, Look, Near, PIECE};
use super::level::{Level, State, occupied};
use super::operator::Scratch;
use super::region::Region;

/// Fall of the residual on a face before the face is looked at again.
const INNER: f32 = 0.35;

/// The residual on the face that is aimed at, in tolerances: what is left is for the pressures rounded up to zero.
const AIM: f64 = 0.9;

/// Fall of the residual that single precision can follow: measured, it has then lost a tenth of its digits at most.
pub(super) const FALL: f64 = 4e-6;

/// A tolerance that a residual in single precision is good enough for.
pub(super) const WITHIN_SINGLE: f64 = 1e-5;

/// Cells that leave are taken out one by one when they are no more: a product is dearer than their sums, and the next step is
/// then free to have its best length.
const FEW: usize = 8;

/// A face of which one cell in so many has changed has a flat punch of its own.
const STALE: usize = 16;

/// Changes of face without halving the residual before the face is given up.
const PATIENCE: i32 = 12;

/// Double-precision products without halving the error before the safe method takes over.
const MOST_STALLS: usize = 2;

/// The length of a step before one is known.
const USUAL: f64 = 0.4;

/// Pressures that count as none, in those that move a cell by the depth: in single precision they are.
const NOTHING: f64 = 1e-30;

/// Relaxes until the error is within the tolerance: true. False when it stalls or the limit is met; `state` then holds
/// p >= 0 and its residual, recomputed. Without a compliance in double precision the residual is not looked at again.
pub(super) fn relax(level: &Level, operators: &Operators, state: &mut State, scratch: &mut Scratch) -> bool {
    level.scale_to_load(state);
    let mut fields = Fields::of(level, &operators.region, state, scratch);
    begin(level, operators, &mut fields, state, scratch);
    // The first residual need not be better than the last.
    let reached = descend(level, &operators.near, &mut fields, state, level.tolerance.max(FALL), scratch);
    project(level, &operators.region, &fields, state, scratch);
    if operators.compliance.is_none() {
        return reached;
    }
    let mut grown: Option<Operators> = None;
    let (mut before, mut stalls) = (f64::INFINITY, 0);
    loop {
        level.scale_to_load(state);
        level.refresh(grown.as_ref().unwrap_or(operators), state, scratch);
        let error = level.error(state, scratch);
        if error <= level.tolerance {
            return true;
        }
        stalls = if error <= 0.5 * before { 0 } else { stalls + 1 };
        before = error;
        if stalls > MOST_STALLS || level.is_exhausted(state) {
            return false;
        }
        if let Some(larger) = level.outgrown(&grown.as_ref().unwrap_or(operators).region, state) {
            fields = Fields::of(level, &larger, state, scratch);
            grown = Some(Operators::new(level.table, level.shape, larger, level.mirrored, true, scratch));
            (before, stalls) = (f64::INFINITY, 0);
        }
        let Operators { region, near, .. } = grown.as_ref().unwrap_or(operators);
        fields.restart(level, region, state, scratch);
        // From the second stall on something was rounded up to zero that mattered: aim lower.
        let goal = level.tolerance.max(FALL * error) * 0.3_f64.powi(stalls as i32);
        descend(level, near, &mut fields, state, goal, scratch);
        project(level, region, &fields, state, scratch);
    }
}

/// The residual of the start, in single precision.
fn begin(level: &Level, operators: &Operators, fields: &mut Fields, state: &mut State, scratch: &mut Scratch) {
    let [width, height] = fields.shape();
    let given = occupied(&fields.p, width);
    scratch.each(
        fields.d.chunks_mut(PIECE).zip(fields.p.chunks(PIECE)),
        #[inline(always)]
        |(d, p)| d.iter_mut().zip(p).for_each(|(d, p)| *d = *p as f32),
    );
    if given.is_empty() {
        fields.ad.fill(0.0);
    } else {
        operators.near.single.product(&fields.d, given, &mut fields.ad, 0..height, scratch);
        state.single_products += 1;
    }
    let rows = fields.r.chunks_exact_mut(width).zip(fields.ad.chunks_exact(width));
    let deeper = state.deeper;
    scratch.each(
        rows.zip(operators.region.of(level.f, level.shape[0])),
        #[inline(always)]
        |((r, ad), f)| {
            for ((r, ad), f) in r.iter_mut().zip(ad).zip(f) {
                *r = (f + deeper - f64::from(*ad)) as f32;
            }
        },
    );
}

/// Relaxes in single precision until the error is within the tolerance, or as far as it goes.
fn descend(
    level: &Level,
    near: &Near,
    fields: &mut Fields,
    state: &mut State,
    tolerance: f64,
    scratch: &mut Scratch,
) -> bool {
    let width = fields.shape()[0];
    let aim = (AIM * tolerance) as f32;
    let loaded = level.load.is_some();
    let mut step = USUAL;
    let mut best = (f32::INFINITY, 0_i32);
    fields.face.fill(0.0);
    let mut dad_old = 0.0;
    // Cells that joined or left the face since the flat punch was found, and those of the face then.
    let (mut stale, mut known) = (0, 0);
    if loaded {
        // Weighted by the pressures that are there.
        let (sum, moment) =
            fields.p.iter().zip(&fields.r).fold((0.0, 0.0), |(s, m), (p, r)| (s + p, m + p * f64::from(*r)));
        if sum > 0.0 {
            state.deepen(fields, -moment / sum, scratch);
        }
    }
    loop {
        // The new face, and how far the present state is from a solution.
        let Look { worst, here, changed, inside, leaving: left } =
            fields.look(state.deeper, (0.5 * tolerance) as f32, scratch);
        best = if worst <= 0.5 * best.0 { (worst, 0) } else { (best.0, best.1 + 1) };
        if here <= aim && f64::from(worst) <= tolerance {
            return true;
        }
        if best.1 > PATIENCE || level.is_exhausted(state) {
            return false;
        }
        // Rows in which anything happens: the face and what leaves it.
        let mut rows = occupied(&fields.face, width);
        if !left.is_empty() {
            let loaded = occupied(&fields.p, width);
            rows = if rows.is_empty() { loaded } else { rows.start.min(loaded.start)..rows.end.max(loaded.end) };
        }
        if rows.is_empty() {
            return true;
        }
        stale += changed;
        if loaded && STALE * stale >= known {
            fields.find_flat(near, &rows, scratch);
            (stale, known) = (0, inside);
        }
        let mut stiffness = 0.0;
        if loaded {
            let [sum, moment] = fields.mask_flat(&rows, scratch);
            stiffness = sum;
            state.deepen(fields, -moment / stiffness, scratch);
        }

        // Relax on the face. The first step also empties the cells that left.
        let mut leaving = !left.is_empty() && changed > 0;
        if leaving && left.len() <= FEW && !loaded {
            left.iter().for_each(|&k| level.take_out(width, &mut fields.p, k, &mut fields.r));
            leaving = false;
        }
        // Cells that leave and come back were judged too early: the longer nothing is gained, the better a face is solved.
        let fall = INNER.powi(1 + (best.1 / 2).min(5));
        let mut from = here;
        fields.mask(&rows, scratch);
        while !level.is_exhausted(state) {
            if leaving {
                level.foresee(fields, &left, &rows);
            }
            let zad = fields.solve_nearly(near, &rows, scratch);
            let (sum, pressed) = if leaving {
                let [sum, pressed] = fields.turn_out(step as f32, &rows, scratch);
                (sum, pressed)
            } else {
                let beta = if dad_old == 0.0 { 0.0 } else { (-zad / dad_old).max(0.0) };
                (fields.turn(beta as f32, &rows, scratch), 0.0)
            };
            if let Some(load) = level.load {
                // The load stays; what the cells that leave carried goes where a flat punch would carry it.
                let missing = if leaving { load - pressed } else { 0.0 };
                fields.share_out(((missing - sum) / stiffness) as f32, &rows, scratch);
            }
            let [dr, dad, moment] = fields.displace(near, &rows, scratch);
            state.single_products += 1;
            state.iterations += 1;
            let mut alpha = 1.0;
            dad_old = 0.0;
            if !leaving {
                if !(dad > 0.0 && dr.is_finite()) {
                    break;
                }
                alpha = dr / dad;
                (step, dad_old) = (alpha, dad);
            }
            // The flat punch feels no mean residual.
            let by = if loaded { alpha * moment / stiffness } else { 0.0 };
            let by = if by.is_finite() { by } else { 0.0 };
            state.deeper += by;
            let now = fields.advance([alpha, by], leaving, &rows, scratch);
            if leaving {
                leaving = false;
                from = now;
            }
            if now <= (fall * from).max(aim) {
                break;
            }
        }
    }
}

/// What a descent has found, tension left out.
fn project(level: &Level, region: &Region, fields: &Fields, state: &mut State, scratch: &Scratch) {
    let rows = region.of_mut(&mut state.p, level.shape[0]).zip(fields.p.chunks_exact(region.columns.len()));
    scratch.each(
        rows,
        #[inline(always)]
        |(to, from)| {
            for (to, from) in to.iter_mut().zip(from) {
                *to = if *from > NOTHING { *from } else { 0.0 };
            }
        },
    );
}
