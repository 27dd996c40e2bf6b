//! What lies between the samples of a measured gap, as coarser samples of it show.

use std::ops::{Add, Mul};

use super::{AnyGap, Gap};
use crate::numeric::geometry::{Rect, distance};

/// What the samples of a measured gap leave open at some place, in parts that add up over places and parts of a gap.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LeftOpen {
    /// What is left of their noise, and of where depths are counted from.
    pub noise: f64,
    /// By how much splines through every second and every fourth sample miss those between.
    pub missed: [f64; 2],
}

impl LeftOpen {
    /// Where there are values enough for one of the two, or for none: by how much all of them vary.
    pub(super) fn of(noise: f64, second: Option<f64>, fourth: Option<f64>, varies: impl FnOnce() -> f64) -> Self {
        let missed = match (second, fourth) {
            (Some(second), Some(fourth)) => [second, fourth],
            (Some(second), None) => [second; 2],
            _ => [0.5 * varies(); 2],
        };
        Self { noise, missed }
    }

    /// How far the gap may be off: its noise, and what splines through all samples miss. That falls on as it fell from every fourth to every
    /// second, and is taken twice; a cubic spline gains a factor of 16 at most.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.noise + 2.0 * self.gain() * self.missed[0]
    }

    /// What is missed over what is missed by samples twice as far apart.
    fn gain(&self) -> f64 {
        let [second, fourth] = self.missed;
        if fourth > 0.0 { (second / fourth).clamp(1.0 / 16.0, 1.0) } else { 1.0 }
    }

    /// Of the least of these heights, which is 0 and which depths are counted from: of n that may be it the noise is about (2 ln n)^(1/2)
    /// times that of each. A tip between the samples may be `lower` by this, which is taken twice as well: noise may have
    /// blunted it.
    pub(super) fn of_least(self, heights: impl Iterator<Item = f64>, lower: f64) -> Self {
        let most = MAY_BE_LEAST * self.size();
        let n = heights.filter(|height| *height <= most).count();
        let spread = (2.0 * (n as f64).max(1.0).ln()).sqrt().max(1.0);
        let noise = spread * self.noise;
        Self { noise: (Self { noise, ..self }.size()).max(noise + 2.0 * lower), missed: [0.0; 2] }
    }

    /// The one that leaves more open.
    pub(super) fn larger(self, other: Self) -> Self {
        if other.size() > self.size() { other } else { self }
    }
}

impl Add for LeftOpen {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let [a, b] = self.missed;
        Self { noise: self.noise + other.noise, missed: [a + other.missed[0], b + other.missed[1]] }
    }
}

impl Mul<f64> for LeftOpen {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { noise: self.noise * factor, missed: self.missed.map(|m| m * factor) }
    }
}

/// Coarser samples that are laid against all: every second and every fourth, begun at the first of them and at a later one.
pub(super) const COARSER: [[usize; 2]; 2] = [[2, 1], [4, 2]];

/// Samples beyond an interval that a coarser spline over it is laid on: what its ends do has died away there.
pub(super) const MARGIN: usize = 24;

/// A slope near the lowest place, and what of it leads away from there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rising {
    pub slope: f64,
    pub away: f64,
}

/// By how much a tip may be lower than 0 within a rectangle, where values at points around it and the slopes there allow for it: looked for
/// at places of it. A tip has slopes beside it as large as further away, which rise on from it; those of a smooth body fall to nothing, and
/// those of a wave turn back.
pub(super) fn tip(
    within: &Rect,
    points: &[([f64; 2], f64)],
    beside: &[Rising],
    further: &[Rising],
    smoothed: bool,
) -> f64 {
    let known = |slopes: &[Rising]| -> Vec<Rising> { slopes.iter().copied().filter(|s| s.slope.is_finite()).collect() };
    let (beside, further) = (known(beside), known(further));
    let steepest = beside.iter().chain(&further).map(|s| s.slope).fold(0.0, f64::max);
    let least = |share: f64, n: usize| share * steepest * n as f64;
    let is_steep = beside.iter().map(|s| s.slope).sum::<f64>() > least(TIP[usize::from(smoothed)], beside.len());
    let rises_on = further.iter().map(|s| s.away).sum::<f64>() > least(RISES_ON, further.len());
    if !(is_steep && rises_on) {
        return 0.0;
    }
    let points = || points.iter().filter(|(_, z)| z.is_finite());
    let least = |at: [f64; 2]| points().map(|(p, z)| z - steepest * distance(*p, at)).fold(f64::NEG_INFINITY, f64::max);
    let lowest = |within: &Rect| {
        let side = |m: usize, k: usize| within.min[m] + k as f64 / PLACES as f64 * (within.max[m] - within.min[m]);
        let places = (0..=PLACES).flat_map(|j| (0..=PLACES).map(move |i| [side(0, i), side(1, j)]));
        places.map(|at| (at, least(at))).fold((within.centre(), 0.0), |a, b| if b.1 < a.1 { b } else { a })
    };
    let (at, _) = lowest(within);
    let steps = within.size().map(|side| side / PLACES as f64);
    -lowest(&Rect::around(at, steps)).1
}

/// Mean slope beside a tip over the steepest one, at least: 0.2 of a paraboloid, 0.4 of r^1.5, 0.7 of a wave of ten samples, 0.9 of a cone;
/// and where noise was taken out, and some of the tip with it.
const TIP: [f64; 2] = [0.75, 0.4];

/// The mean of what of those further away leads away from it, at least: 0.4 of a wave of nine samples, 0.75 of three faces.
const RISES_ON: f64 = 0.6;

/// Places along each side for that.
const PLACES: usize = 16;

/// Samples beside a tip, and further away from it.
pub(super) const BESIDE: usize = 1;
pub(super) const FURTHER: usize = 4;

/// Of what the least gap leaves open: samples above it by more are not it.
const MAY_BE_LEAST: f64 = 3.0;

/// What those of several parts of a gap that are measured leave open at the same places.
pub(super) fn joined(
    parts: &[AnyGap],
    places: &[Rect],
    join: impl Fn(LeftOpen, LeftOpen) -> LeftOpen,
) -> Vec<LeftOpen> {
    let both = |a: Vec<LeftOpen>, b: Vec<LeftOpen>| a.into_iter().zip(b).map(|(a, b)| join(a, b)).collect();
    let measured = parts.iter().filter(|part| part.is_measured());
    measured.map(|part| part.left_open(places)).reduce(both).unwrap_or_else(|| vec![LeftOpen::default(); places.len()])
}
