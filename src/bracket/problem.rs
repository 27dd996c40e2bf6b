//! The problem of a bracket in units of its own, and the way in and out.

use super::ForceBracket;
use crate::gap::{AnyGap, Degree, Gap};
use crate::grid::{Grid, Pressure};
use crate::numeric::geometry::Rect;
use crate::overlap::{Overlap, Units};
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// What `work` makes of the problem in its own units, or the bracket around nothing when the bodies do not touch.
pub(super) fn within(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    pressure: &Pressure,
    work: impl FnOnce(&BracketProblem, Vec<f64>) -> ForceBracket,
) -> Result<ForceBracket, Unsolved> {
    Ok(match BracketProblem::enter(gap, modulus, depth, pressure)? {
        Some((problem, q)) => work(&problem, q),
        None => {
            ForceBracket::no_contact(Some(Pressure { grid: pressure.grid, values: vec![0.0; pressure.values.len()] }))
        }
    })
}

/// Cells around the load that are looked at one by one, and one more for so many of its width.
const MARGIN: [usize; 2] = [4, 32];

/// The pressure on the cells that carry some and a margin of empty ones, which may reach beyond the grid; what lies further out is
/// looked at as a whole. A pressure of nothing stays as it is.
fn around_load(pressure: &Pressure) -> Pressure {
    let Pressure { grid, values } = pressure;
    let [nx, ny] = grid.shape;
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for (k, _) in values.iter().enumerate().filter(|(_, p)| **p > 0.0) {
        let at = [k % nx, k / nx];
        low = [0, 1].map(|m| low[m].min(at[m]));
        high = [0, 1].map(|m| high[m].max(at[m] + 1));
    }
    if low[0] == usize::MAX {
        return pressure.clone();
    }
    let margin = [0, 1].map(|m| MARGIN[0] + (high[m] - low[m]) / MARGIN[1]);
    let shape = [0, 1].map(|m| high[m] - low[m] + 2 * margin[m]);
    let first = [0, 1].map(|m| low[m] as f64 - margin[m] as f64);
    let origin = [0, 1].map(|m| grid.origin[m] + first[m] * grid.spacing[m]);
    let mut around = vec![0.0; shape[0] * shape[1]];
    for j in low[1]..high[1].min(ny) {
        let to = (j - low[1] + margin[1]) * shape[0] + margin[0];
        around[to..to + high[0] - low[0]].copy_from_slice(&values[j * nx + low[0]..j * nx + high[0]]);
    }
    Pressure { grid: Grid { origin, shape, ..*grid }, values: around }
}

/// k of a gap that is homogeneous and 0 at its lowest point; infinite for a flat.
pub(super) fn degree_of(gap: &AnyGap) -> Option<f64> {
    gap.known().degree().map(|degree| match degree {
        Degree::Power(k) => k,
        Degree::Flat => f64::INFINITY,
    })
}

/// Longer over shorter side of a cell up to which there are tables: about a second and 30 MB at this limit.
const MOST_SLENDER: f64 = 100.0;

/// The problem with E* = 1 and lengths of order 1: a pressure is proved in these units.
pub(super) struct BracketProblem {
    pub gap: AnyGap,
    pub units: Units,
    pub depth: f64,
    pub grid: Grid,
    /// Holds {f > 0}.
    pub reach: Rect,
    /// Whether that is certain.
    pub reach_certain: bool,
    /// k when the gap is homogeneous about its centre and zero there, and the depth greater.
    pub degree: Option<f64>,
    pub unit_pressure: f64,
    pub unit_force: f64,
    pub given: Grid,
}

impl BracketProblem {
    /// The problem and the pressure in it; `None` when the bodies do not touch.
    fn enter(
        gap: &AnyGap,
        modulus: EffectiveModulus,
        depth: f64,
        pressure: &Pressure,
    ) -> Result<Option<(Self, Vec<f64>)>, Unsolved> {
        let given = pressure.grid;
        let numbers = given.origin.iter().chain(&given.spacing).chain(&pressure.values);
        let sides = given.spacing.iter().all(|&h| h > 0.0);
        if !(depth.is_finite() && sides && !given.is_empty() && given.len() == pressure.values.len())
            || numbers.into_iter().any(|v| !v.is_finite())
        {
            let reason = "the pressure needs one finite number a cell, and its cells sides greater than zero";
            return Err(Unsolved::new(Verdict::NotApplicable, reason));
        }
        let [a, b] = given.spacing;
        let slenderness = a.max(b) / a.min(b);
        if !(slenderness <= MOST_SLENDER) {
            let reason = format!(
                "the cells are {slenderness:.1e} times as long as wide; brackets take cells of up to {MOST_SLENDER}: the \
                 tables of what a cell does around it grow with that"
            );
            return Err(Unsolved::new(Verdict::NotApplicable, reason));
        }
        // What is certain may be larger than what is found; a strip of it is not worth a proof.
        let Some(Overlap { reach, certain: reach_certain, .. }) = Overlap::of(gap, depth)? else { return Ok(None) };
        let Pressure { grid: given, values } = &around_load(pressure);
        let given = *given;
        let [w, h] = given.extent().size();
        let length = 0.5 * w.max(h);
        let origin = given.extent().centre();
        let [cx, cy] = gap.known().centre;
        let lattice = Grid::over(&reach, [33, 33]);
        let points = given.centres().chain(lattice.centres());
        let deepest = points.map(|[x, y]| depth - gap.gap(x, y)).fold(depth - gap.gap(cx, cy), f64::max);
        let height = if deepest > 0.0 { deepest } else { depth.abs().max(f64::MIN_POSITIVE) };
        let units = Units { origin, length, height };
        units.resolve()?;
        let scaled = gap.scaled(origin, length, height);
        let grid =
            Grid { origin: units.inward(given.origin), spacing: given.spacing.map(|h| h / length), shape: given.shape };
        let unit_pressure = modulus.e_star() * height / length;
        let q = values.iter().map(|p| (p / unit_pressure).max(0.0)).collect();
        // A hair more than the gap says: its own rounding.
        let reach = units.rect_inward(&reach).scaled(1.0 + 1e-9);
        let unit_force = modulus.e_star() * height * length;
        let degree = degree_of(gap).filter(|_| depth > 0.0);
        let depth = depth / height;
        Ok(Some((
            Self { gap: scaled, units, depth, grid, reach, reach_certain, degree, unit_pressure, unit_force, given },
            q,
        )))
    }

    /// A point of a cell, in sides from its centre.
    pub fn place(&self, cell: usize, at: [f64; 2]) -> [f64; 2] {
        let grid = &self.grid;
        let corner = [cell % grid.shape[0], cell / grid.shape[0]];
        [0, 1].map(|m| grid.origin[m] + (corner[m] as f64 + 0.5 + at[m]) * grid.spacing[m])
    }

    /// f at such a point.
    pub fn overlap(&self, cell: usize, at: [f64; 2]) -> f64 {
        let [x, y] = self.place(cell, at);
        self.depth - self.gap.gap(x, y)
    }

    /// Supremum of f over a rectangle; where the gap proves none, its largest at 5 x 5 points.
    pub fn most_overlap(&self, rect: &Rect) -> f64 {
        if let Some([low, _]) = self.gap.bounds(rect, [0.0; 2]) {
            return self.depth - low + 1e-13 * self.depth.abs();
        }
        let [w, h] = rect.size();
        let points =
            (0..25).map(|k| [rect.min[0] + 0.25 * w * f64::from(k % 5), rect.min[1] + 0.25 * h * f64::from(k / 5)]);
        points.map(|[x, y]| self.depth - self.gap.gap(x, y)).fold(f64::NEG_INFINITY, f64::max)
    }
}
