//! What lies between the samples of a measured gap, as coarser samples of it show.

use std::ops::{Add, Mul};

use super::{AnyGap, Gap};
use crate::numeric::geometry::Rect;

/// What the samples of a measured gap leave open at some place, in parts that add up over places and parts of a gap.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LeftOpen {
    /// What is left of their noise.
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
        let [second, fourth] = self.missed;
        let gain = if fourth > 0.0 { (second / fourth).clamp(1.0 / 16.0, 1.0) } else { 1.0 };
        self.noise + 2.0 * gain * second
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
