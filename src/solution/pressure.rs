//! How the pressure is spread over the patch.

use crate::grid::{Grid, Pressure};

/// Why the exact pressure is infinite somewhere in a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Singular {
    /// Along a line: the end of the material, or a sharp ridge.
    Edge,
    /// At a point: a cone, the apex of a pyramid, any tip that is not rounded.
    Tip,
}

impl Singular {
    /// The word in results.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Edge => "edge",
            Self::Tip => "tip",
        }
    }
}

/// How the pressure is spread.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PressureSummary {
    /// Largest pressure found; `None` where the exact one is infinite ([`PressureSummary::singular`]) or not given by the method.
    pub max: Option<f64>,
    /// Relative error of the largest pressure: an estimate from several grids, rounding for closed forms; `None` when nothing is known.
    pub max_error: Option<f64>,
    /// Why the exact pressure is infinite somewhere, where it is known to be.
    pub singular: Option<Singular>,
    /// Force over area; `None` without contact.
    pub mean: Option<f64>,
    /// Where the largest pressure was found.
    pub at: Option<[f64; 2]>,
    /// The field on its grid, when asked for.
    pub field: Option<Pressure>,
    /// The gap that is left after loading, cell by cell, when asked for; infinite where there is no material.
    pub gap: Option<(Grid, Vec<f64>)>,
}
