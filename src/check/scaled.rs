//! A pressure field in the units of its contact, and what the energy proves from it.

use crate::EffectiveModulus;
use crate::clock::Deadline;
use crate::energy::{self, Trial, Wanted};
use crate::gap::AnyGap;
use crate::grid::{Grid, Pressure};
use crate::overlap::{Overlap, Scaled};

/// The error that bounds are worked out again for: less than any that is claimed costs.
const CLOSER: f64 = 1e-6;

/// By so much of a cell from where the field is written they are worked out as well.
const ASIDE: f64 = 5e-13;

/// E* = 1, the depth and the size of the contact about 1.
pub(super) struct ScaledField {
    scaled: Scaled,
    e_star: f64,
    grid: Grid,
    pressure: Vec<f64>,
}

impl ScaledField {
    /// `None` where the bodies do not overlap.
    pub fn of(gap: &AnyGap, modulus: EffectiveModulus, depth: f64, field: &Pressure) -> Option<Self> {
        let scaled = Overlap::of(gap, depth).ok()??.scaled();
        let (units, e_star) = (scaled.units, modulus.e_star());
        let grid = Grid {
            origin: units.inward(field.grid.origin),
            spacing: field.grid.spacing.map(|h| h / units.length),
            shape: field.grid.shape,
        };
        let pressure = field.values.iter().map(|p| p / (e_star * units.height / units.length)).collect();
        Some(Self { scaled, e_star, grid, pressure })
    }

    fn trial(&self) -> Trial<'_> {
        Trial { grid: &self.grid, pressure: &self.pressure, displacement: None }
    }

    /// Bounds of the force that the energy of the field proves, until they are `enough`. Where a kink of the gap runs along a side of cells, they
    /// turn on the last digit that the field was written with; any pressure proves bounds, and so do the same a little aside.
    pub fn force_bounds(&self, enough: impl Fn([f64; 2]) -> bool) -> Option<[f64; 2]> {
        let mut found: Option<[f64; 2]> = None;
        for [x, y] in [[0.0, 0.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]] {
            let [low, high] = found.unwrap_or([0.0, f64::INFINITY]);
            found = self.bounds_aside([x * ASIDE, y * ASIDE]).map(|[a, b]| [a.max(low), b.min(high)]).or(found);
            if found.is_some_and(&enough) {
                break;
            }
        }
        found
    }

    /// Of the field so many cells from where it is written.
    fn bounds_aside(&self, aside: [f64; 2]) -> Option<[f64; 2]> {
        let degree = self.scaled.gap.known().law.map(|law| law.degree);
        let mut grid = self.grid;
        (0..2).for_each(|m| grid.origin[m] += aside[m] * grid.spacing[m]);
        let trial = Trial { grid: &grid, ..self.trial() };
        let wanted = Wanted::narrowest(CLOSER);
        let bounds = energy::force_bounds(&self.scaled, degree, &trial, wanted, Deadline::NEVER).ok()?;
        let units = self.scaled.units;
        Some(bounds.map(|force| force * self.e_star * units.height * units.length))
    }

    /// Bounds of the moments about the user's origin.
    pub fn moment_bounds(&self) -> Option<[[f64; 2]; 2]> {
        energy::moment_bounds(&self.scaled, self.e_star, &self.trial(), CLOSER, Deadline::NEVER)
    }

    /// The stiffness by the force and by what dilations leave of a law; `growing`: the pressure of a flat punch on the pressed cells at unit
    /// depth, E* = 1. `None` where the gap tells nothing.
    pub fn stiffness(&self, growing: &[f64], force: f64) -> Option<f64> {
        let Self { scaled, e_star, .. } = self;
        let units = scaled.units;
        let growing: Vec<f64> = growing.iter().map(|m| m * units.length).collect();
        let force = force / (e_star * units.height * units.length);
        let [found, _] =
            energy::stiffness(&scaled.gap, scaled.depth, &self.trial(), &growing, force).filter(|_| scaled.certain)?;
        Some(found * e_star * units.length)
    }
}
