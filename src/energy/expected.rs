//! What bounds of a force may be expected to leave, from some of the cells: whether they are worth their time, no more.

use super::functional::RING;
use super::parts::Parts;
use super::pressed::Pressed;
use super::residual::{Residual, Seen};
use super::virial::Virial;

/// How narrow bounds are to be, and from where on they are not worked out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sought {
    /// Bounds no wider than this, relative to the force, are not made narrower; 0: as narrow as they can be.
    pub enough: f64,
    /// How many times as wide they may be expected to be and still be worked out.
    pub hope: f64,
    /// Whether that has been judged by some of the cells.
    pub is_judged: bool,
}

impl Sought {
    /// As narrow as the pressure proves.
    pub const NARROWEST: Self = Self { enough: 0.0, hope: f64::INFINITY, is_judged: false };

    /// What is likely of bounds that are too wide to work them out at best.
    pub fn beyond_hope(self, expected: Expected) -> Option<NoBounds> {
        (self.enough > 0.0 && expected.times[0] > self.hope).then(|| expected.likely())
    }
}

/// That no bounds were had.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NoBounds {
    /// How many times as wide as enough those of this grid are expected to be; infinite where that cannot be told.
    pub times: f64,
    /// The order in which they narrow with finer cells.
    pub order: f64,
}

impl NoBounds {
    pub(super) const NONE: Self = Self { times: f64::INFINITY, order: OF_PLAIN.order };
}

/// How many times as wide as enough bounds are expected to be, at least and most likely.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    times: Likely,
    order: f64,
}

impl Expected {
    pub fn likely(self) -> NoBounds {
        NoBounds { times: self.times[1], order: self.order }
    }
}

/// The least and the most likely value.
type Likely = [f64; 2];

/// Widths over what [`left_by`] tells, and the order in which they narrow.
struct Widths {
    over: Likely,
    order: f64,
}

/// Where T = 1: 1.04 to 1.19, orders 1.3 to 1.66 (5 to 95 % of 540 proofs for waves, tips, worn indenters, rollers, rings).
const OF_PLAIN: Widths = Widths { over: [1.0, 1.1], order: 1.4 };

/// Where T is what dilations leave: 3.1 to 10, orders 1.9 to 3.0 of the same.
const OF_FITTED: Widths = Widths { over: [3.0, 5.0], order: 1.9 };

/// Cells that are looked at for kinks, and rows of cells side by side for the residual.
const LOOKED_AT: usize = 64;

/// The fewest rows of cells that tell anything.
const FEWEST_ROWS: usize = 12;

/// Of the cells around those under pressure, how many may touch at least and most likely (5 to 95 % of 500 proofs of waves, tips, worn
/// indenters, rollers and rings: 1.3 to 2.7).
const TOUCHING: Likely = [1.3, 2.2];

/// Share of cells with kinks from which on bounds are too wide to be worth their time.
const KINKED: f64 = 0.4;

/// What (5) may leave: by the punch of a disc of the area of the contact, and the share of it that is left.
fn left_by(punch: f64, left: f64, ring: f64, gamma: f64) -> f64 {
    left * (2.0 * gamma * RING[0] * ring * punch).sqrt()
}

/// What bounds may be expected to leave where T is of this size, over what is enough; `ring`: what may touch besides, over the cells under
/// pressure, at least and most likely.
pub(super) fn expected(pressed: &Pressed, left: f64, ring: Likely, gamma: f64, sought: Sought) -> Expected {
    let Widths { over, order } = if left < 1.0 { OF_FITTED } else { OF_PLAIN };
    let enough = sought.enough * pressed.force();
    Expected { times: [0, 1].map(|k| over[k] * left_by(pressed.disc(), left, ring[k], gamma) / enough), order }
}

/// Whether f has kinks in so many cells under pressure that little can be shown.
pub(super) fn is_rough(residual: &Residual, pressed: &Pressed) -> bool {
    let step = pressed.cells.len().div_ceil(LOOKED_AT).max(1);
    let looked_at = || pressed.cells.iter().step_by(step);
    let kinked = looked_at().filter(|(i, j, _)| residual.overlap.jet(&residual.rect(*i, *j)).is_none());
    kinked.count() as f64 > KINKED * looked_at().count() as f64
}

/// The same as [`Sought::beyond_hope`] by the residual in some cells, where there are many.
pub(super) fn seen_beyond_hope(
    residual: &Residual,
    pressed: &Pressed,
    parts: &Parts,
    sought: Sought,
) -> Option<NoBounds> {
    let field = residual.field;
    let [nx, ny] = field.grid.shape.map(|n| n as isize);
    let inside = |i: isize, j: isize| (0..nx).contains(&i) && (0..ny).contains(&j);
    let loaded = |i: isize, j: isize| inside(i, j) && field.pressure(i, j) > 0.0;
    let beside = |i: isize, j: isize| [[1, 0], [-1, 0], [0, 1], [0, -1]].iter().any(|[a, b]| loaded(i + a, j + b));
    let all = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
    let around = all.filter(|&(i, j)| !loaded(i, j) && beside(i, j)).count() as f64;
    let ring = TOUCHING.map(|share| share * around / pressed.count());
    let Seen { energy, divided } = residual.seen(LOOKED_AT, FEWEST_ROWS)?;
    let times = |left: f64| expected(pressed, left, ring, 0.5 * energy, sought);
    let plain = times(1.0);
    // Where f is so much less known than u in a cell, bounds cost many solves and miss what a grid leaves.
    if divided > KINKED && plain.times[0] > 1.0 {
        return Some(plain.likely());
    }
    sought.beyond_hope(plain)?;
    let fitted = times(Virial::fitted(pressed, parts, [1.0, 0.0, 0.0], &[]).left);
    // More than is under pressure bounds nothing for use.
    if ring[0] > 1.0 { Some(fitted.likely()) } else { sought.beyond_hope(fitted) }
}
