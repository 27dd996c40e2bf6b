//! Bounds of the force, from the pressures that prove them. The checker samples: it can refuse, and it cannot prove.

use super::Verification;
use super::homogeneous::is_homogeneous;
use super::summation::{Receiver, Summation};
use crate::bracket::{Evidence, ForceBracket, Repair, Side};
use crate::gap::{AnyGap, Gap};
use crate::grid::{Grid, Pressure};
use crate::overlap::Overlap;
use crate::problem::EffectiveModulus;

/// Points of a cell at which the checker samples; off the lattices that proofs and solvers use.
const POINTS: [[f64; 2]; 4] = [[0.31, 0.27], [0.73, 0.36], [0.21, 0.69], [0.83, 0.87]];

/// Points at most; on larger grids fewer a cell.
const MOST_POINTS: usize = 240_000;

/// Points a side over what lies beyond the grid.
const BEYOND: usize = 48;

/// The checker's own error of a displacement, relative to the depth.
const OWN_ERROR: f64 = 1e-6;

/// Share of the width of a sampled bracket that its sampling may have missed.
const MISSED: f64 = 0.05;

/// One claimed side of a bracket.
#[derive(Debug, Clone, Copy)]
pub struct Claim<'a> {
    /// The bound.
    pub force: f64,
    /// What stands between it and the force of the pressure.
    pub repair: Repair,
    /// Whether it is said to be proved.
    pub proved: bool,
    /// The pressure, in units of E*.
    pub pressure: &'a Pressure,
}

/// Checks both sides of a bracket from the pressures that it carries.
///
/// ```
/// use contact_patch::bracket::{self, BracketSettings};
/// use contact_patch::{Discrete, EffectiveModulus, Grid, Kernel, Pressure, gap::Cone, geometry::Rect, matrix_free};
/// let (gap, modulus) = (Cone::with_slope(1.0)?, EffectiveModulus::from_e_star(1.0)?);
/// let grid = Grid::over(&Rect::around([0.0; 2], [0.75; 2]), [24, 24]);
/// let problem = Discrete::sample(&gap, 1.0, grid, Kernel::Galerkin);
/// let values = matrix_free::solve(&problem, None, &matrix_free::Settings::default())?.pressure;
/// let bracket = bracket::certify(&gap, modulus, 1.0, &Pressure { grid, values }, &BracketSettings::default())?;
/// assert!(contact_patch::check::bracket(&gap, modulus, 1.0, &bracket).accepted());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn bracket(gap: impl Into<AnyGap>, modulus: EffectiveModulus, depth: f64, bracket: &ForceBracket) -> Verification {
    let gap = &gap.into();
    let side = |side: &Side| (side.force(), side.repair(), side.evidence() == Evidence::Proved);
    let (upper, lower) = (bracket.upper_side(), bracket.lower_side());
    match (upper.pressure(), lower.pressure()) {
        (Some(above), Some(below)) => {
            let claim = |(force, repair, proved), pressure| Claim { force, repair, proved, pressure };
            bounds(gap, modulus, depth, &claim(side(upper), above), &claim(side(lower), below))
        }
        _ => {
            let mut found = Verification::default();
            found.require(false, "the bracket carries no pressure to check it by");
            found
        }
    }
}

/// Checks two claimed sides, such as those read from a file.
///
/// On each side the violation v is sampled: f - S q where f > 0 (upper), S q - f under pressure (lower). What the repair has
/// to make good is recomputed from below: a stack of discs no larger than those that just reach across the points.
#[must_use]
pub fn bounds(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    upper: &Claim<'_>,
    lower: &Claim<'_>,
) -> Verification {
    let gap = &gap.into();
    let mut found = Verification::default();
    let width = upper.force - lower.force;
    found.require(
        lower.force <= upper.force && upper.force.is_finite() && lower.force >= 0.0,
        format!("the bracket [{:e}, {:e}] is in order", lower.force, upper.force),
    );
    for (claim, above) in [(upper, true), (lower, false)] {
        let name = if above { "upper" } else { "lower" };
        if !sound(claim.pressure) {
            found.require(false, format!("{name} bound: its pressure is finite and nowhere tensile"));
            continue;
        }
        let carried = claim.pressure.force();
        let Repair { discs, level, degree } = claim.repair;
        let by = if above { -level / depth } else { level / depth };
        let ratio = if level == 0.0 { 1.0 } else { (1.0 + by).max(0.0).powf(1.0 + 1.0 / degree.unwrap_or(f64::NAN)) };
        let proves = (if above { carried + discs } else { (carried - discs).max(0.0) }) / ratio;
        let rounding = 1e-9 * (carried.abs() + claim.force.abs());
        found.require(
            (claim.force - proves).abs() <= rounding && discs >= 0.0 && level >= 0.0,
            format!("{name} bound {:e}: pressure and repair prove {proves:e}", claim.force),
        );
        if level > 0.0 {
            let similar = degree.is_some_and(|k| depth > 0.0 && is_homogeneous(gap, k, &claim.pressure.grid));
            found.require(similar, format!("{name} bound: the gap is homogeneous, as the use of another depth asks"));
        }
        let Sampled { violations, points } = violations(gap, modulus, depth, claim.pressure, above);
        let worst = violations.iter().map(|v| v.0).fold(0.0, f64::max);
        let needs = modulus.e_star() * least_stack(violations, level + OWN_ERROR * depth.abs());
        let missed = if claim.proved { 0.0 } else { MISSED * width };
        found.require(
            needs <= discs * (1.0 + 1e-6) + missed + rounding,
            format!(
                "{name} bound: violated by at most {worst:.1e} at {points} points; discs of {discs:.1e} make it good, {needs:.1e} needed"
            ),
        );
    }
    found
}

pub(super) fn sound(pressure: &Pressure) -> bool {
    let grid = &pressure.grid;
    grid.len() == pressure.values.len()
        && !grid.is_empty()
        && grid.spacing.iter().all(|&h| h > 0.0 && h.is_finite())
        && grid.origin.iter().all(|x| x.is_finite())
        && pressure.values.iter().all(|&p| p >= 0.0 && p.is_finite())
}

#[cfg(feature = "scene")]
pub(super) fn loaded(pressure: &Pressure) -> impl Iterator<Item = [f64; 2]> + '_ {
    pressure.grid.loaded(&pressure.values).map(|(at, _)| at)
}

/// Violations of a condition.
pub(super) struct Sampled {
    /// Height and place of each.
    pub violations: Vec<(f64, [f64; 2])>,
    points: usize,
}

pub(super) fn violations(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    pressure: &Pressure,
    above: bool,
) -> Sampled {
    let (grid, nx) = (&pressure.grid, pressure.grid.shape[0]);
    let q: Vec<f64> = pressure.values.iter().map(|p| p / modulus.e_star()).collect();
    let summation = Summation::new(grid, &q);
    let mut found = Sampled { violations: Vec::new(), points: 0 };
    let overlap = |[x, y]: [f64; 2]| depth - gap.gap(x, y);
    for share in POINTS {
        let place =
            |k: usize| [0, 1].map(|m| grid.origin[m] + ([k % nx, k / nx][m] as f64 + share[m]) * grid.spacing[m]);
        let f: Vec<f64> = (0..grid.len()).map(|k| overlap(place(k))).collect();
        let wanted: Vec<bool> = (0..grid.len()).map(|k| if above { f[k] > 0.0 } else { q[k] > 0.0 }).collect();
        let u = summation.in_cells(Receiver::Point(share), &wanted);
        let cells = wanted.iter().filter(|&&w| w).count();
        found.points += cells;
        for k in (0..grid.len()).filter(|&k| wanted[k]) {
            let v = if above { f[k] - u[k] } else { u[k] - f[k] };
            if v > 0.0 {
                found.violations.push((v, place(k)));
            }
        }
        if found.points + cells > MOST_POINTS {
            break;
        }
    }
    if above && let Ok(Some(Overlap { reach, .. })) = Overlap::of(gap, depth) {
        let (inside, lattice) = (grid.extent(), Grid::over(&reach, [BEYOND; 2]));
        let points: Vec<[f64; 2]> = lattice.centres().filter(|p| !inside.contains(*p) && overlap(*p) > 0.0).collect();
        found.points += points.len();
        for (point, u) in points.iter().zip(summation.at(&points)) {
            let v = overlap(*point) - u;
            if v > 0.0 {
                found.violations.push((v, *point));
            }
        }
    }
    found
}

/// The least force (E* = 1) of any stack of discs over what exceeds the level: a disc across two points has at least half
/// their distance for a radius.
fn least_stack(mut violations: Vec<(f64, [f64; 2])>, level: f64) -> f64 {
    const DIRECTIONS: usize = 8;
    violations.retain(|v| v.0 > level);
    violations.sort_by(|a, b| b.0.total_cmp(&a.0));
    let directions: [(f64, f64); DIRECTIONS] =
        std::array::from_fn(|k| (std::f64::consts::PI * k as f64 / DIRECTIONS as f64).sin_cos());
    let mut spans = [[f64::INFINITY, f64::NEG_INFINITY]; DIRECTIONS];
    let mut force = 0.0;
    for (k, (height, [x, y])) in violations.iter().enumerate() {
        for (span, (sin, cos)) in spans.iter_mut().zip(directions) {
            let along = x * cos + y * sin;
            *span = [span[0].min(along), span[1].max(along)];
        }
        let diameter = spans.iter().map(|s| s[1] - s[0]).fold(0.0, f64::max);
        force += diameter * (height - violations.get(k + 1).map_or(level, |v| v.0));
    }
    force
}
