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

    /// How many times too wide bounds are expected to be, where that is too much to work them out.
    pub fn beyond_hope(self, times: f64) -> Option<f64> {
        (self.enough > 0.0 && times > self.hope).then_some(times)
    }
}

/// Cells that are looked at for kinks, and rows of cells side by side for the residual.
const LOOKED_AT: usize = 64;

/// Of the cells around those under pressure, the share that may touch at least.
const TOUCHING: f64 = 0.5;

/// Share of cells with kinks from which on bounds are too wide to be worth their time.
const KINKED: f64 = 0.4;

/// What (5) may leave: by the punch of a disc of the area of the contact, and the share of it that is left.
pub(super) fn left_by(punch: f64, left: f64, ring: f64, gamma: f64) -> f64 {
    left * (2.0 * gamma * RING[0] * ring * punch).sqrt()
}

/// Whether f has kinks in so many cells under pressure that little can be shown.
pub(super) fn is_rough(residual: &Residual, pressed: &Pressed) -> bool {
    let step = pressed.cells.len().div_ceil(LOOKED_AT).max(1);
    let looked_at = || pressed.cells.iter().step_by(step);
    let kinked = looked_at().filter(|(i, j, _)| residual.overlap.jet(&residual.rect(*i, *j)).is_none());
    kinked.count() as f64 > KINKED * looked_at().count() as f64
}

/// The same as [`Sought::beyond_hope`] by the residual in some cells, where there are many.
pub(super) fn seen_beyond_hope(residual: &Residual, pressed: &Pressed, parts: &Parts, sought: Sought) -> Option<f64> {
    let field = residual.field;
    let [nx, ny] = field.grid.shape.map(|n| n as isize);
    let inside = |i: isize, j: isize| (0..nx).contains(&i) && (0..ny).contains(&j);
    let loaded = |i: isize, j: isize| inside(i, j) && field.pressure(i, j) > 0.0;
    let beside = |i: isize, j: isize| [[1, 0], [-1, 0], [0, 1], [0, -1]].iter().any(|[a, b]| loaded(i + a, j + b));
    let all = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
    let around = all.filter(|&(i, j)| !loaded(i, j) && beside(i, j)).count() as f64;
    let ring = TOUCHING * around / pressed.count();
    if ring > 1.0 {
        return Some(f64::INFINITY);
    }
    let Seen { energy, divided } = residual.seen(LOOKED_AT)?;
    let gamma = 0.5 * energy;
    let times = |left: f64| left_by(pressed.disc(), left, ring, gamma) / (sought.enough * pressed.force());
    let plain = times(1.0);
    // Where f is so much less known than u in a cell, bounds cost many solves and miss what a grid leaves.
    if divided > KINKED && plain > 1.0 {
        return Some(plain);
    }
    sought.beyond_hope(plain)?;
    sought.beyond_hope(times(Virial::fitted(pressed, parts, [1.0, 0.0, 0.0], &[]).left))
}
