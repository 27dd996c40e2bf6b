//! An independent check of a bracket: direct summation with a quadrature of its own, on other points than the proof used.
//!
//! Nothing is shared with the proof but the gap: no transform, no lattice, no closed form of Love's, no remainder. The
//! displacement of a cell is that of a polygon, edge by edge, where the point is near (Wilton et al. 1984), and a point force
//! with its second moments further out. The checker samples: it can refuse a bracket, and it cannot prove one.

use std::f64::consts::FRAC_1_PI;

use super::{ForceBracket, Side, Theorem};
use crate::gap::Gap;
use crate::grid::Pressure;
use crate::material::EffectiveModulus;

/// Points along each side of a cell; off the lattices that proofs use.
const POINTS: usize = 3;

/// Relative room for the checker's own error: the series of a cell three sides away.
const ROOM: f64 = 2e-4;

/// What the checker found.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// Whether nothing speaks against the bracket.
    pub accepted: bool,
    /// The least force that the upper pressure can prove, from the points looked at.
    pub upper_at_least: f64,
    /// The largest force that the lower pressure can prove, from the points looked at.
    pub lower_at_most: f64,
    /// Points looked at.
    pub points: usize,
}

/// Checks both sides of a bracket from the pressures that it carries.
///
/// # Errors
/// None: a bracket that cannot be confirmed is not accepted.
#[must_use]
pub fn check(gap: &dyn Gap, modulus: EffectiveModulus, depth: f64, bracket: &ForceBracket) -> Verification {
    let (lower, upper) = (bracket.lower_side(), bracket.upper_side());
    let sides =
        [upper, lower].map(|side| Claim { force: side.force(), discs: disc_room(side), pressure: side.pressure() });
    check_claims(gap, modulus, depth, &sides[0], &sides[1])
}

/// One claimed side: a force, the pressure that is said to prove it, and whether discs repaired it.
#[derive(Debug, Clone, Copy)]
pub struct Claim<'a> {
    /// The bound.
    pub force: f64,
    /// Whether the difference of the bound and the pressure's own force pays for discs under the violation; if not, the pressure
    /// must be admissible as it stands.
    pub discs: bool,
    /// The pressure, in units of E*.
    pub pressure: &'a Pressure,
}

fn disc_room(side: &Side) -> bool {
    side.theorem() == Theorem::Discs
}

/// Checks two claimed sides, such as those read from a file.
///
/// On each side the violation v is sampled: f - u where f > 0 (upper), u - f under pressure (lower). Without discs it must be
/// none; with discs the largest v over a radius R, at the least that of the place itself, must be paid for:
/// by a single cell, 2 E* v times half the shorter side of a cell.
#[must_use]
pub fn check_claims(
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    depth: f64,
    upper: &Claim<'_>,
    lower: &Claim<'_>,
) -> Verification {
    let (up, up_points) = sample(gap, modulus, depth, upper.pressure, true);
    let (down, down_points) = sample(gap, modulus, depth, lower.pressure, false);
    let disc = |p: &Pressure, v: f64| modulus.e_star() * v * p.grid.spacing[0].min(p.grid.spacing[1]);
    let (carried_up, carried_down) = (upper.pressure.force(), lower.pressure.force());
    let room = |v: f64| (v - ROOM * depth.abs()).max(0.0);
    let upper_at_least = carried_up + if upper.discs { disc(upper.pressure, room(up)) } else { 0.0 };
    let lower_at_most = carried_down - if lower.discs { disc(lower.pressure, room(down)) } else { 0.0 };
    let honest = (upper.discs || room(up) == 0.0) && (lower.discs || room(down) == 0.0);
    let tiny = 1e-9 * (upper.force.abs() + lower.force.abs());
    let accepted = honest
        && upper.force.is_finite()
        && upper.force + tiny >= upper_at_least
        && lower.force <= lower_at_most + tiny
        && lower.force <= upper.force
        && upper.pressure.values.iter().chain(&lower.pressure.values).all(|&p| p >= 0.0);
    Verification { accepted, upper_at_least, lower_at_most, points: up_points + down_points }
}

/// Largest violation at the points of the checker, and their number.
fn sample(gap: &dyn Gap, modulus: EffectiveModulus, depth: f64, pressure: &Pressure, above: bool) -> (f64, usize) {
    let (grid, [nx, _]) = (&pressure.grid, pressure.grid.shape);
    let loaded: Vec<([f64; 2], f64)> = (0..grid.len())
        .filter(|&k| pressure.values[k] > 0.0)
        .map(|k| (grid.centre_of(k), pressure.values[k] / modulus.e_star()))
        .collect();
    let (mut worst, mut points) = (0.0_f64, 0);
    for k in 0..grid.len() {
        let cell = grid.cell(k % nx, k / nx);
        if !above && pressure.values[k] <= 0.0 {
            continue;
        }
        for n in 0..POINTS * POINTS {
            let at = |m: usize, n: usize| cell.min[m] + cell.size()[m] * (n as f64 + 0.41) / POINTS as f64;
            let [x, y] = [at(0, n % POINTS), at(1, n / POINTS)];
            let f = depth - gap.gap(x, y);
            if above && f <= 0.0 {
                continue;
            }
            points += 1;
            let u: f64 = loaded.iter().map(|(c, p)| p * cell_displacement(grid.spacing, [x - c[0], y - c[1]])).sum();
            worst = worst.max(if above { f - u } else { u - f });
        }
    }
    (worst, points)
}

/// Displacement at the offset from the middle of a cell under unit pressure.
fn cell_displacement([a, b]: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    let square = x * x + y * y;
    if square > 9.0 * (a * a + b * b) {
        // 1/r and the second moments a^2/12, b^2/12.
        let r = square.sqrt();
        let moment = a * a * (3.0 * x * x / square - 1.0) + b * b * (3.0 * y * y / square - 1.0);
        return FRAC_1_PI * a * b / r * (1.0 + moment / (24.0 * square));
    }
    // The integral of 1/r over a polygon: for each edge, distance times the difference of ln(R + l).
    let corners = [
        [-0.5 * a - x, -0.5 * b - y],
        [0.5 * a - x, -0.5 * b - y],
        [0.5 * a - x, 0.5 * b - y],
        [-0.5 * a - x, 0.5 * b - y],
    ];
    let mut sum = 0.0;
    for k in 0..4 {
        let (p, q) = (corners[k], corners[(k + 1) % 4]);
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        let along = [(q[0] - p[0]) / length, (q[1] - p[1]) / length];
        let distance = p[0] * along[1] - p[1] * along[0];
        let (l1, l2) = (p[0] * along[0] + p[1] * along[1], q[0] * along[0] + q[1] * along[1]);
        let (r1, r2) = (p[0].hypot(p[1]), q[0].hypot(q[1]));
        if distance != 0.0 {
            sum += distance * if l1 + l2 >= 0.0 { ((r2 + l2) / (r1 + l1)).ln() } else { ((r1 - l1) / (r2 - l2)).ln() };
        }
    }
    FRAC_1_PI * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacement_of_a_cell_by_two_routes() {
        // Love, in the middle of a unit square: 4 asinh(1)/pi.
        let middle = cell_displacement([1.0, 1.0], [0.0, 0.0]);
        assert!((middle - 4.0 * FRAC_1_PI * 1f64.asinh()).abs() < 1e-14);
        let h = [1.0, 0.7];
        for at in [[0.3, 0.1], [0.9, -0.6], [2.0, 1.0], [3.5, 0.4], [-8.0, 3.0]] {
            let other = super::super::kernel::displacement(h, at[0], at[1])[0];
            assert!((cell_displacement(h, at) / other - 1.0).abs() < 0.5 * ROOM, "{at:?}");
        }
    }
}
