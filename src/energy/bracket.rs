//! The energy from below and from above, from any pressure.

use super::basis::NODES;
use super::field::{COEFFICIENTS, Field, RING};
use super::outside::{Loads, clear_beyond};
use super::overlap::OverlapBounds;
use super::residual::{Halves, Norms, Residual};
use crate::grid::Grid;

/// Two-sided bounds of the energy U = max over p >= 0 of <f, p> - <p, S p>/2, E* = 1.
///
/// `lower <= U <= lower + width`, for any pressure that was given; how close they are is another matter.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyBracket {
    /// <f, p> - <p, S p>/2 of the pressure given, rounded down.
    pub lower: f64,
    /// Bound of what it misses; infinite where none could be shown.
    pub width: f64,
    /// Share of each cell of the grid in the width, x fastest; they add up to a little less than it.
    pub shares: Vec<f64>,
}

impl EnergyBracket {
    /// Bounds of the energy.
    #[must_use]
    pub fn bounds(&self) -> [f64; 2] {
        [self.lower, (self.lower + self.width).next_up()]
    }
}

/// A pressure p >= 0 on the cells of a grid, and its displacement.
#[derive(Debug, Clone)]
pub struct Trial<'a> {
    /// The cells.
    pub grid: &'a Grid,
    /// Pressure in each cell, x fastest; not negative.
    pub pressure: &'a [f64],
    /// Cell means of the displacement S p, where a solver has them: by one product in double precision, 0 where they are not known.
    pub displacement: Option<&'a [f64]>,
}

/// A pressure on a larger grid of the same cells: so many more on each side, without pressure.
#[derive(Debug, Clone)]
pub struct Padded {
    grid: Grid,
    pressure: Vec<f64>,
}

impl Padded {
    /// The same pressure, as one whose displacement is not known.
    #[must_use]
    pub fn trial(&self) -> Trial<'_> {
        Trial { grid: &self.grid, pressure: &self.pressure, displacement: None }
    }
}

/// Cells that a grid is enlarged by on each side where its contact ends too close to its border to be sure of what lies beyond: one
/// for so many of the longer side.
const PADDING: [usize; 5] = [32, 16, 8, 5, 3];

impl Trial<'_> {
    /// What `bounds` finds on the grid itself, else on larger and larger ones, as far as that is worth while; those beyond which the load
    /// alone does not rule out contact are not tried.
    pub(crate) fn first_that<T>(&self, overlap: &dyn OverlapBounds, bounds: impl Fn(&Trial) -> Option<T>) -> Option<T> {
        let try_on = |trial: &Trial| trial.is_clear_beyond(overlap).then(|| bounds(trial)).flatten();
        let longer = self.grid.shape[0].max(self.grid.shape[1]);
        let enlarged = || PADDING.iter().find_map(|part| try_on(&self.padded(longer.div_ceil(*part)).trial()));
        try_on(self).or_else(enlarged)
    }

    /// Whether the load rules out all contact beyond the grid: nothing is bounded where it does not.
    fn is_clear_beyond(&self, overlap: &dyn OverlapBounds) -> bool {
        let nx = self.grid.shape[0];
        clear_beyond(self.grid, overlap, &Loads::new(self.grid, |j| &self.pressure[j * nx..(j + 1) * nx]))
    }

    /// With so many more cells on each side: where the contact ends close to the grid, nothing can be shown of what lies beyond.
    #[must_use]
    pub fn padded(&self, by: usize) -> Padded {
        let Grid { origin, spacing, shape } = *self.grid;
        let grid = Grid {
            origin: [0, 1].map(|m| origin[m] - by as f64 * spacing[m]),
            spacing,
            shape: shape.map(|n| n + 2 * by),
        };
        let mut pressure = vec![0.0; grid.len()];
        for (j, row) in self.pressure.chunks_exact(shape[0]).enumerate() {
            pressure[(j + by) * grid.shape[0] + by..][..shape[0]].copy_from_slice(row);
        }
        Padded { grid, pressure }
    }

    /// Pressure and displacement on the cells, made even where the overlap has a mirror in the middle of the grid.
    pub(super) fn field(&self, overlap: &dyn OverlapBounds, known: bool) -> Option<(Field, Halves)> {
        let halves = self.halves(overlap);
        let even = |field: &[f64]| evened(field, self.grid.shape, halves);
        let p = even(self.pressure);
        let field = match self.displacement.filter(|_| known) {
            Some(u) => Field::known(self.grid, &p, &even(u)),
            None => Field::new(self.grid, &p),
        };
        Some((field?, halves))
    }

    /// Whether the displacement is known as far around every cell under pressure as it is looked at there.
    pub(super) fn displacement_reaches(&self) -> bool {
        let Some(u) = self.displacement else { return false };
        let ([nx, ny], far) = (self.grid.shape, NODES + RING);
        let known = |i: usize, j: usize| {
            let steps = [0, far, 2 * far];
            let inside = |k: usize, n: usize| k >= far && k - far < n;
            steps.iter().all(|b| {
                steps.iter().all(|a| {
                    let (x, y) = (i + a, j + b);
                    inside(x, nx) && inside(y, ny) && u[(y - far) * nx + x - far] != 0.0
                })
            })
        };
        (0..self.pressure.len()).filter(|k| self.pressure[*k] > 0.0).all(|k| known(k % nx, k / nx))
    }

    pub(super) fn halves(&self, overlap: &dyn OverlapBounds) -> Halves {
        let mirrors = overlap.mirrors();
        let mut halves = [0, 1].map(|m| mirrors[m].is_some_and(|c| self.grid.is_centred_on(m, c)));
        // A pressure that is not even would lose by being made so.
        let strongest = self.pressure.iter().copied().fold(0.0, f64::max);
        for (axis, half) in halves.iter_mut().enumerate().filter(|(_, half)| **half) {
            let alike = |k: usize| {
                (self.pressure[k] - self.pressure[image(k, self.grid.shape, axis)]).abs() <= SAME * strongest
            };
            *half = (0..self.pressure.len()).all(alike);
        }
        halves
    }
}

/// Pressures that differ by less than this share of the largest are made even.
const SAME: f64 = 1e-4;

fn image(k: usize, [nx, ny]: [usize; 2], axis: usize) -> usize {
    let (i, j) = (k % nx, k / nx);
    if axis == 0 { j * nx + nx - 1 - i } else { (ny - 1 - j) * nx + i }
}

pub(super) fn evened(field: &[f64], shape: [usize; 2], halves: Halves) -> Vec<f64> {
    let mut field = field.to_vec();
    for axis in (0..2).filter(|axis| halves[*axis]) {
        for k in 0..field.len() {
            let other = image(k, shape, axis);
            if other > k {
                let mean = 0.5 * (field[k] + field[other]);
                (field[k], field[other]) = (mean, mean);
            }
        }
    }
    field
}

/// Bounds of the energy from a pressure.
///
/// The width is infinite for cells more slender than 2:1, where the contact may reach beyond the grid, and where the overlap jumps
/// within the contact.
///
/// ```
/// use contact_patch::energy::{GapOverlap, Trial, energy_bracket};
/// use contact_patch::{Grid, gap::{AnyGap, Paraboloid}, geometry::Rect};
/// // Hertz's pressure for R = d = E* = 1, at the centres of 64 x 64 cells; U = 2/5 P d = 8/15.
/// let grid = Grid::over(&Rect::around([0.0; 2], [1.2; 2]), [64, 64]);
/// let hertz = |[x, y]: [f64; 2]| 2.0 / std::f64::consts::PI * (1.0 - x * x - y * y).max(0.0).sqrt();
/// let pressure: Vec<f64> = grid.centres().map(hertz).collect();
/// let gap = AnyGap::from(&Paraboloid::new([1.0, 1.0])?);
/// let trial = Trial { grid: &grid, pressure: &pressure, displacement: None };
/// let [lower, upper] = energy_bracket(&GapOverlap::new(&gap, 1.0), &trial).bounds();
/// assert!(lower <= 8.0 / 15.0 && 8.0 / 15.0 <= upper && upper < 1.05 * lower, "{lower} {upper}");
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[must_use]
pub fn energy_bracket(overlap: &dyn OverlapBounds, trial: &Trial) -> EnergyBracket {
    let unknown = || EnergyBracket { lower: f64::NEG_INFINITY, width: f64::INFINITY, shares: Vec::new() };
    let positive =
        trial.pressure.len() == trial.grid.len() && trial.pressure.iter().all(|p| *p >= 0.0 && p.is_finite());
    if !positive || trial.grid.is_empty() {
        return unknown();
    }
    for known in [trial.displacement_reaches(), false] {
        let Some((field, halves)) = trial.field(overlap, known) else { return unknown() };
        let bracket = of_field(overlap, &field, halves);
        if !known || bracket.width.is_finite() && bracket.lower.is_finite() {
            return bracket;
        }
    }
    unknown()
}

fn of_field(overlap: &dyn OverlapBounds, field: &Field, halves: Halves) -> EnergyBracket {
    let residual = Residual { field, overlap, halves };
    let [lower, open] = lower(&residual, |_, _, _| {});
    let norms = residual.admissible().map(|set| residual.norms(&set));
    match norms {
        Some(norms) if norms.energy().is_finite() => {
            EnergyBracket { lower, width: 0.5 * norms.energy() + open, shares: shares(&norms) }
        }
        _ => EnergyBracket { lower, width: f64::INFINITY, shares: Vec::new() },
    }
}

/// a(w, w)/2 <= (l |grad w|^2 + |w|^2/l)/8 with the best l, cell by cell.
fn shares(norms: &Norms) -> Vec<f64> {
    let l = (norms.value / norms.gradient).sqrt();
    if !(l > 0.0 && l.is_finite()) {
        return vec![0.0; norms.cells.len()];
    }
    norms.cells.iter().map(|[gradient, value]| 0.125 * (l * gradient + value / l)).collect()
}

/// <f, p> - <p, S p>/2, rounded down, and how much less that may be than the number itself. Calls `seen` with the bounds of the mean of
/// f in the cells under pressure.
pub(super) fn lower(residual: &Residual, mut seen: impl FnMut(usize, usize, [f64; 2])) -> [f64; 2] {
    let field = residual.field;
    let grid = &field.grid;
    let [nx, ny] = grid.shape;
    let first = [0, 1].map(|m| if residual.halves[m] { grid.shape[m] / 2 } else { 0 });
    let (mut work, mut elastic, mut size, mut open) = (0.0, 0.0, 0.0, 0.0);
    for j in first[1]..ny {
        let row = j as isize;
        let (p, u) = (field.pressures(0, row), field.displacements(0, row));
        for i in (first[0]..nx).filter(|i| p[*i] != 0.0) {
            let images = residual.images(i as isize, row);
            let [mean, high] = residual.overlap.mean(&residual.rect(i as isize, row));
            seen(i, j, [mean, high]);
            let (p, u) = (images * p[i], u[i] * field.scale);
            work += p * mean;
            open += p * (high - mean);
            elastic += p * u;
            size += p.abs() * (mean.abs() + u.abs() + field.rounding * field.scale);
        }
    }
    // Each sum of n terms errs by n eps at most; of the displacements by their own rounding, and that of the coefficients.
    let load = size * (f64::EPSILON * (grid.len() + 8) as f64 + 2.0 * COEFFICIENTS);
    let rounding = 0.5 * field.rounding * field.scale * grid.len() as f64 * field.strongest;
    let sum = work - 0.5 * elastic;
    let rounded = grid.cell_area() * (1.0 + 1e-12);
    [grid.cell_area() * (sum - load - rounding), rounded * (2.0 * (load + rounding) + open)]
}
