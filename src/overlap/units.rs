//! The units of the solvers: E* = 1, the deepest overlap = 1, half the longer side of {f > 0} = 1.

use super::Overlap;
use crate::gap::AnyGap;
use crate::grid::Grid;
use crate::numeric::geometry::Rect;
use crate::solution::{Unsolved, Verdict};

/// Where the origin of a dimensionless problem lies, and its units in the user's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Units {
    /// The dimensionless origin.
    pub origin: [f64; 2],
    /// Length along the surface.
    pub length: f64,
    /// Height along the normal.
    pub height: f64,
}

impl Units {
    /// A dimensionless point in the user's frame.
    pub fn outward(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.origin[0] + self.length * x, self.origin[1] + self.length * y]
    }

    /// A point of the user's frame, dimensionless.
    pub fn inward(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.origin[0]) / self.length, (y - self.origin[1]) / self.length]
    }

    /// A rectangle of the user's frame, dimensionless.
    pub fn rect_inward(&self, rect: &Rect) -> Rect {
        Rect { min: self.inward(rect.min), max: self.inward(rect.max) }
    }

    /// A dimensionless grid in the user's frame.
    pub fn grid_outward(&self, grid: &Grid) -> Grid {
        let (origin, spacing) = (self.outward(grid.origin), grid.spacing.map(|h| h * self.length));
        Grid { origin, spacing, shape: grid.shape }
    }

    /// A dimensionless rectangle in the user's frame.
    pub fn rect_outward(&self, rect: &Rect) -> Rect {
        Rect { min: self.outward(rect.min), max: self.outward(rect.max) }
    }
}

/// Half the longer side of an overlap in its distance from the origin, below which coordinates do not tell its points apart.
const LEAST: f64 = 1e-10;

impl Units {
    /// # Errors
    /// `NotApplicable` where the overlap is so small and so far from the origin that the rounding of coordinates is no small part of a cell.
    pub fn resolve(&self) -> Result<(), Unsolved> {
        let Self { origin: [x, y], length, .. } = *self;
        if length >= LEAST * x.abs().max(y.abs()) {
            return Ok(());
        }
        let reason = format!(
            "the bodies overlap over {length:.1e} at ({x:e}, {y:e}): coordinates of 16 digits do not tell the points of the contact apart"
        );
        Err(Unsolved::new(Verdict::NotApplicable, reason)
            .with_hint("move the gap nearer to the origin (\"at\"), or a larger load"))
    }
}

/// An overlap in units of its own.
#[derive(Debug, Clone)]
pub(crate) struct Scaled {
    /// The gap in these units.
    pub gap: AnyGap,
    /// The depth in the same units. Not 1 when the gap is not zero at its lowest point.
    pub depth: f64,
    /// A rectangle that holds {f > 0}.
    pub reach: Rect,
    /// Whether that follows from the construction of the gap.
    pub certain: bool,
    /// The units.
    pub units: Units,
}

impl Scaled {
    /// The depth above the lowest point of a gap with a law, or above zero.
    pub fn above_lowest(&self) -> f64 {
        self.depth - self.gap.known().law.map_or(0.0, |law| law.lowest)
    }
}

impl Overlap {
    /// The same in units of its own.
    pub fn scaled(&self) -> Scaled {
        let [w, h] = self.reach.size();
        let units = Units { origin: self.reach.centre(), length: 0.5 * w.max(h), height: self.deepest };
        Scaled {
            gap: self.gap.scaled(units.origin, units.length, units.height),
            depth: self.depth / units.height,
            reach: units.rect_inward(&self.reach),
            certain: self.certain,
            units,
        }
    }
}
