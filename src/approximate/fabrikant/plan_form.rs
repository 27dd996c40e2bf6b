//! A flat gap: the boundary is the edge of the plan-form, whatever the depth, and equations (10) and (11) are all there is.

use std::f64::consts::TAU;

use super::approximation::{Approximation, Boundary, Error, Family, Settings};
use super::flat_punch::FlatPunch;
use super::problem::Problem;
use crate::gap::{AnyGap, Degree, Gap};
use crate::numeric::quadrature::GaussLegendre;
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// Crossings of the edge that differ by less than this share are one: a corner.
const CORNER: f64 = 1e-9;

/// Sectors, besides those that the corners make, and Gauss points in each.
const SECTORS: usize = 12;
const POINTS: usize = 24;

/// Moves of the centre to the centroid: the second is already exact where everything is seen from the first.
const MOST_MOVES: usize = 8;

/// The answer for a gap that is known to be flat within an edge about its centre; `None` for any other.
pub(super) fn flat(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
) -> Option<Result<Approximation, Error>> {
    (gap.known().degree() == Some(Degree::Flat)).then(|| solve(gap, modulus, depth, settings))
}

/// Where the ray at this angle meets the edge, nearest first.
fn edge(gap: &AnyGap, from: [f64; 2], angle: f64) -> Vec<f64> {
    let mut crossings = Vec::new();
    gap.ray_kinks(from, [angle.cos(), angle.sin()], &mut crossings);
    crossings.sort_by(f64::total_cmp);
    crossings.dedup_by(|b, a| *b - *a <= CORNER * *b);
    crossings
}

/// The centroid of the plan-form as seen from a point inside, and the area; star-shaped or not.
fn centroid_and_area(gap: &AnyGap, from: [f64; 2]) -> ([f64; 2], f64) {
    let mut ends = vec![];
    gap.kink_directions(from, &mut ends);
    ends.iter_mut().for_each(|angle| *angle = angle.rem_euclid(TAU));
    ends.extend((0..=SECTORS).map(|k| TAU * k as f64 / SECTORS as f64));
    ends.sort_by(f64::total_cmp);
    let rule = GaussLegendre::new(POINTS);
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for pair in ends.windows(2).filter(|pair| pair[1] - pair[0] > 1e-14) {
        for (x, w) in rule.nodes() {
            let angle = pair[0] + 0.5 * (1.0 + x) * (pair[1] - pair[0]);
            let weight = 0.5 * w * (pair[1] - pair[0]);
            // Out, and in again, and out.
            for (k, r) in edge(gap, from, angle).into_iter().enumerate() {
                let sign = if k % 2 == 0 { weight } else { -weight };
                area += sign * r * r / 2.0;
                moment = [
                    moment[0] + sign * r.powi(3) / 3.0 * angle.cos(),
                    moment[1] + sign * r.powi(3) / 3.0 * angle.sin(),
                ];
            }
        }
    }
    (moment.map(|m| m / area), area)
}

fn solve(gap: &AnyGap, modulus: EffectiveModulus, depth: f64, settings: &Settings) -> Result<Approximation, Error> {
    Problem::new(gap, modulus, depth)?;
    let mut centre = gap.known().centre;
    for _ in 0..MOST_MOVES {
        let (off, area) = centroid_and_area(gap, centre);
        centre = [centre[0] + off[0], centre[1] + off[1]];
        if !gap.gap(centre[0], centre[1]).is_finite() {
            let reason = "the centroid of the plan-form lies outside of it: it is not star-shaped about it";
            return Err(Unsolved::new(Verdict::NotStarShaped, reason).into());
        }
        if off[0].hypot(off[1]) <= 1e-12 * area.sqrt() {
            break;
        }
    }
    let mut corners = Vec::new();
    gap.kink_directions(centre, &mut corners);
    let radius = |angle: f64| match edge(gap, centre, angle)[..] {
        // Seen once and only once: star-shaped.
        [only] => only,
        _ => f64::NAN,
    };
    let (l, area, error) = FlatPunch::integrals(radius, &corners)?;
    let d = 2.0 * area / l * depth;
    let even = (0..settings.boundary_points).map(|k| TAU * k as f64 / settings.boundary_points as f64);
    let mut angles: Vec<f64> = even.chain(corners.iter().map(|a| a.rem_euclid(TAU))).collect();
    angles.sort_by(f64::total_cmp);
    let outline = angles.iter().map(|&angle| [angle, radius(angle)]).filter(|p| p[1].is_finite()).collect();
    Ok(Approximation {
        family: Family::Stationary,
        why: String::new(),
        force: 2.0 * modulus.e_star() * d,
        stiffness: 4.0 * modulus.e_star() * (area / l),
        d,
        second_variation: None,
        residual: 0.0,
        margin: None,
        boundary: Boundary { centre, outline },
        area,
        centroid: centre,
        quadrature_error: [error, 0.0],
        rays: corners.len(),
        iterations: 1,
        lower_bound: None,
    })
}
