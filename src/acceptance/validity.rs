//! How far a state is from what small-strain half-space theory assumes.

use std::f64::consts::PI;

use crate::gap::{AnyGap, Gap, Generatrix};
use crate::numeric::geometry::{centroid, distance};
use crate::problem::Contact;
use crate::solution::Validity;

/// Slope from which on small-strain theory is doubtful.
const STEEP: f64 = 0.3;

/// Size over radius, likewise (a half-space approximates a body ten times as large well).
const LARGE: f64 = 0.3;

/// Mean pressure over E*, likewise.
const HARD: f64 = 0.1;

/// Points of a boundary at which slopes are looked at.
const LOOKS: usize = 64;

/// Of the way from its middle to the line: a gap may end there.
const ON_LINE: f64 = 1.0 - 1e-6;

impl Validity {
    /// Of a patch with these boundaries under a force, the gap that of the contact without tilt.
    pub(crate) fn of(contact: &Contact, boundary: &[Vec<[f64; 2]>], area: f64, force: f64) -> Option<Self> {
        let (gap, e_star) = (contact.gap(), contact.modulus().e_star());
        let points: usize = boundary.iter().map(Vec::len).sum();
        let every = points.div_ceil(LOOKS).max(1);
        let mut slope = 0.0_f64;
        let known = gap.known();
        // The slope of a quadratic form is largest on the line.
        let shares: &[f64] = if known.quadratic.is_some() { &[ON_LINE] } else { &[ON_LINE, 0.5] };
        for line in boundary.iter().filter(|line| !line.is_empty()) {
            let middle = centroid(line);
            // Around an axis of revolution the farthest point stands for all.
            let round = known.axis.is_some_and(|axis| distance(middle, axis.at) <= 1e-9 * area.sqrt());
            let away = |p: &&[f64; 2]| distance(**p, middle);
            let farthest = || line.iter().max_by(|p, q| away(p).total_cmp(&away(q))).copied();
            let looks: Vec<[f64; 2]> =
                if round { farthest().into_iter().collect() } else { line.iter().step_by(every).copied().collect() };
            // On a line, and half way to its middle.
            for point in looks {
                for &share in shares {
                    let at = [0, 1].map(|m| middle[m] + share * (point[m] - middle[m]));
                    slope = slope.max(steepness(gap, at, 1e-6 * area.sqrt()).unwrap_or(0.0));
                }
            }
        }
        let size = (area / PI).sqrt();
        let size_over_radius = radius(gap).map(|radius| size / radius).filter(|s| s.is_finite());
        let pressure_over_modulus = force / area / e_star;
        (points > 0 && slope.is_finite() && pressure_over_modulus.is_finite()).then_some(Self {
            slope,
            size_over_radius,
            pressure_over_modulus,
        })
    }

    /// What is doubtful, in words.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let Self { slope, size_over_radius, pressure_over_modulus } = *self;
        let doubts = [
            (slope > STEEP, "slope"),
            (size_over_radius.is_some_and(|size| size > LARGE), "size over radius"),
            (pressure_over_modulus > HARD, "mean pressure over E*"),
        ];
        let large: Vec<&str> = doubts.into_iter().filter(|(holds, _)| *holds).map(|(_, what)| what).collect();
        if large.is_empty() {
            return Vec::new();
        }
        vec![format!(
            "small-strain half-space theory is doubtful here, for what should be small is not: {}; the answer is that of the theory",
            large.join(", ")
        )]
    }
}

/// |grad g| at a point, by differences where the gap does not tell.
fn steepness(gap: &AnyGap, [x, y]: [f64; 2], step: f64) -> Option<f64> {
    if let Some([gx, gy]) = gap.gradient(x, y) {
        return Some(gx.hypot(gy)).filter(|s| s.is_finite());
    }
    let along = |dx: f64, dy: f64| (gap.gap(x + dx, y + dy) - gap.gap(x - dx, y - dy)) / (2.0 * step);
    Some(along(step, 0.0).hypot(along(0.0, step))).filter(|s| s.is_finite())
}

/// The radius of curvature of a gap that has one: the geometric mean of both.
pub(super) fn radius(gap: &AnyGap) -> Option<f64> {
    let known = gap.known();
    if let Some(Generatrix::Sphere { radius, .. }) = known.axis.map(|axis| axis.generatrix) {
        return Some(radius);
    }
    mean_radius(known.quadratic?.hessian)
}

/// That of second derivatives xx, xy, yy.
pub(super) fn mean_radius([xx, xy, yy]: [f64; 3]) -> Option<f64> {
    let gauss = xx * yy - xy * xy;
    (gauss > 0.0).then(|| 1.0 / gauss.sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::remarks::mixed_units;
    use super::*;
    use crate::gap::{Cone, Paraboloid};
    use crate::{EffectiveModulus, Loading};

    fn circle(radius: f64) -> Vec<Vec<[f64; 2]>> {
        let point = |k: i32| [radius * (0.1 * f64::from(k)).cos(), radius * (0.1 * f64::from(k)).sin()];
        vec![(0..63).map(point).collect()]
    }

    #[test]
    fn a_ball_is_valid_while_it_is_larger_than_its_patch() {
        let modulus = EffectiveModulus::from_e_star(2e11).unwrap();
        let ball = Contact::new(modulus, Paraboloid::new([2.0, 8.0]).unwrap(), Loading::depth(1.0)).unwrap();
        for (size, doubted) in [(1e-3, false), (3.0, true)] {
            let area = PI * size * size;
            let found = Validity::of(&ball, &circle(size), area, 2e9 * area).unwrap();
            // Slopes are x/2 and y/8.
            assert!(
                (found.slope / (0.5 * size) - 1.0).abs() < 1e-4 && (found.pressure_over_modulus - 0.01).abs() < 1e-9
            );
            assert!((found.size_over_radius.unwrap() - size / 4.0).abs() < 1e-9 * size);
            assert_eq!(!found.remarks().is_empty(), doubted);
            assert_eq!(mixed_units(&ball, area, None).is_some(), doubted);
        }
    }

    #[test]
    fn a_cone_has_a_slope_and_no_radius() {
        let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
        let cone = Contact::new(modulus, Cone::with_slope(0.2).unwrap(), Loading::depth(1.0)).unwrap();
        let found = Validity::of(&cone, &circle(1.0), PI, 0.1).unwrap();
        assert!((found.slope - 0.2).abs() < 1e-9 && found.size_over_radius.is_none() && found.remarks().is_empty());
        assert!(mixed_units(&cone, PI, None).is_none());
    }
}
