//! The force from bounds of the energy: for a homogeneous gap P (d - g0) = (2 + 1/k) U, for any other [`any_gap`].

use super::any_gap::{self, Missing};
use super::bracket::{Trial, energy_bracket};
use super::expected::{NoBounds, Sought};
use super::of_gap::GapOverlap;
use super::on_cells::OnCells;
use crate::clock::Deadline;
use crate::gap::{AnyGap, Degree};
use crate::overlap::Scaled;

/// Means of the gap are found to this share of the depth and of the error that is asked for: together they cost no more than twice it.
const OPEN: f64 = 0.02;

/// What units and a few products change a bound by.
const ROUNDING: f64 = 1e-13;

/// Bounds of the force of a gap at a depth by a pressure on a grid, E* = 1; `None` where none can be shown.
///
/// By the law of a homogeneous gap, else by what holds for any gap; only what follows from how the gap is written is used.
///
/// ```
/// use contact_patch::energy::{Trial, force_bracket};
/// use contact_patch::{Discrete, Grid, Kernel, gap::{AnyGap, Sphere}, geometry::Rect, matrix_free};
/// // A ball of radius 4 pressed by 0.5 (Sneddon): a = 1.4142..., P = 1.8907.
/// let gap = AnyGap::from(&Sphere::new(4.0)?);
/// let grid = Grid::over(&Rect::around([0.0; 2], [2.0; 2]), [64, 64]);
/// let problem = Discrete::sample(&gap, 0.5, grid, Kernel::Galerkin);
/// let solved = matrix_free::solve_nested(&problem, &matrix_free::Settings::default()).expect("solved");
/// let trial = Trial { grid: &grid, pressure: &solved.pressure, displacement: Some(&solved.displacement) };
/// let [lower, upper] = force_bracket(&gap, 0.5, &trial).expect("bounded");
/// assert!(lower < upper && upper < 1.01 * lower);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[must_use]
pub fn force_bracket(gap: &AnyGap, depth: f64, trial: &Trial) -> Option<[f64; 2]> {
    let law = gap.known().law.filter(|law| law.degree != Degree::Flat);
    let above_lowest = law.map_or(f64::NAN, |law| depth - law.lowest);
    let above_least = depth - gap.known().floor;
    let (overlap, degree) = (GapOverlap::new(gap, depth), law.map(|law| law.degree));
    bounds(&overlap, degree, above_lowest, above_least, trial, Sought::NARROWEST).ok()
}

/// How narrow bounds are wanted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted {
    sought: Sought,
    /// What means of the gap may be off by, over the depth.
    open: f64,
}

impl Wanted {
    /// Within a tolerance; where they are expected to be `hope` times as wide, none are worked out.
    pub fn within(tolerance: f64, hope: f64) -> Self {
        Self { sought: Sought { enough: tolerance, hope, is_judged: false }, open: OPEN * tolerance }
    }

    /// As narrow as the pressure proves, however long that takes, but for a share of `tolerance`.
    #[cfg(feature = "scene")]
    pub fn narrowest(tolerance: f64) -> Self {
        Self { sought: Sought::NARROWEST, open: OPEN * tolerance }
    }
}

/// Bounds of the force (E* = 1) by a pressure on a grid. For a gap of this degree, or for any gap.
pub(crate) fn force_bounds(
    scaled: &Scaled,
    degree: Option<Degree>,
    trial: &Trial,
    wanted: Wanted,
    deadline: Deadline,
) -> Result<[f64; 2], NoBounds> {
    let overlap = GapOverlap::of(scaled, wanted.open, deadline);
    bounds(&overlap, degree, scaled.above_lowest(), scaled.depth - scaled.gap.known().floor, trial, wanted.sought)
}

fn bounds(
    overlap: &GapOverlap,
    degree: Option<Degree>,
    above_lowest: f64,
    above_least: f64,
    trial: &Trial,
    sought: Sought,
) -> Result<[f64; 2], NoBounds> {
    if !is_positive(trial) {
        return Err(NoBounds::NONE);
    }
    let [lower, upper] = match degree {
        None => {
            let [force] = of_any_gap(overlap, above_least, trial, sought, [[1.0, 0.0, 0.0]])?;
            force
        }
        Some(degree) => {
            let bounds = |trial: &Trial| energy_bracket(&OnCells::new(overlap, trial.grid), trial).bounds();
            let [lower, upper] = trial
                .first_that(overlap, |trial| Some(bounds(trial)).filter(|[_, upper]| upper.is_finite()))
                .ok_or(NoBounds::NONE)?;
            let per_energy = (2.0 + degree.inverse()) / above_lowest;
            [lower * per_energy * (1.0 - ROUNDING), upper * per_energy * (1.0 + ROUNDING)]
        }
    };
    if lower > 0.0 && upper < f64::INFINITY { Ok([lower, upper]) } else { Err(NoBounds::NONE) }
}

/// Bounds of the integrals of p (c_0 + c_1 x + c_2 y), without a law.
fn of_any_gap<const N: usize>(
    overlap: &GapOverlap,
    above_least: f64,
    trial: &Trial,
    sought: Sought,
    wanted: [[f64; 3]; N],
) -> Result<[[f64; 2]; N], NoBounds> {
    // Where it is not known that the overlap ends, samples would have to prove it.
    if !overlap.is_certain() {
        return Err(NoBounds::NONE);
    }
    let bounds = |trial: &Trial| any_gap::bounds(overlap, above_least * (1.0 + ROUNDING), trial, sought, wanted);
    // Only contact beyond the grid is a reason to enlarge it.
    let found = trial.first_that(overlap, |trial| Some(bounds(trial)).filter(|found| *found != Err(Missing::Beyond)));
    found.unwrap_or(Err(Missing::Beyond)).map_err(|missing| match missing {
        Missing::TooWide(expected) => expected,
        Missing::Beyond => NoBounds::NONE,
    })
}

/// Bounds of the moments (Mx, My) about the user's origin by a pressure on a grid, as narrow as it proves, in the user's units; `None` where
/// none are had.
pub(crate) fn moment_bounds(
    scaled: &Scaled,
    e_star: f64,
    trial: &Trial,
    tolerance: f64,
    deadline: Deadline,
) -> Option<[[f64; 2]; 2]> {
    if !is_positive(trial) {
        return None;
    }
    let overlap = GapOverlap::of(scaled, OPEN * tolerance, deadline);
    let above_least = scaled.depth - scaled.gap.known().floor;
    let [x, y] = scaled.units.inward([0.0; 2]);
    // y and -x from that origin.
    let wanted = [[-y, 0.0, 1.0], [x, -1.0, 0.0]];
    let bounds = of_any_gap(&overlap, above_least, trial, Sought::NARROWEST, wanted).ok()?;
    // Places are known to their last digits.
    let force = trial.pressure.iter().sum::<f64>() * trial.grid.cell_area();
    let [w, h] = trial.grid.extent().size();
    let place = force * (x.abs() + y.abs() + w + h);
    let unit = e_star * scaled.units.height * scaled.units.length.powi(2);
    let outward = |[low, high]: [f64; 2]| {
        let rounding = ROUNDING * (place + low.abs().max(high.abs()));
        [(low - rounding) * unit, (high + rounding) * unit]
    };
    let finite = bounds.iter().flatten().all(|end| end.is_finite());
    finite.then(|| bounds.map(outward))
}

/// Whether a trial is one: no pressure negative, some positive, all numbers.
fn is_positive(trial: &Trial) -> bool {
    let numbers = trial.pressure.iter().all(|p| *p >= 0.0 && p.is_finite());
    numbers && trial.pressure.len() == trial.grid.len() && trial.pressure.iter().any(|p| *p > 0.0)
}
