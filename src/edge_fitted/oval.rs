//! Oval rings: contacts that are closed strips, on rows of cells ([`super::rows`]) at stations of a quarter where they have two mirrors.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::Limits;
use super::estimated::Estimated;
use super::mesh::Point;
use super::rows::{Strip, between, refined};
use super::symmetry::{Isometry, mirrors};

/// Share of the half width that a straight cell may leave the curved strip by.
const SAGITTA: f64 = 0.06;

/// Cells across it to each side, to begin with.
const ACROSS: usize = 3;

/// What has to be solved of a ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quarters {
    /// Mirrors x = 0 and y = 0.
    One,
    /// No mirrors.
    All,
}

impl Quarters {
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::All => 4,
        }
    }

    /// Up to which rays reach.
    pub fn angle(self) -> f64 {
        match self {
            Self::One => FRAC_PI_2,
            Self::All => TAU,
        }
    }
}

/// The contact of an overlap (`f`, about the crossing of its mirrors or another point inside of the ring) that is positive along every ray
/// between the distances that `strip` gives, and nowhere else. `None` where no such contact is found, and once the time is used up.
pub(crate) fn oval(
    f: &dyn Fn(Point) -> f64,
    strip: &dyn Fn(f64) -> Option<[f64; 2]>,
    quarters: Quarters,
    limits: &Limits,
) -> Option<Estimated> {
    let looks = 8 * quarters.count();
    let slenderness = (0..=looks)
        .map(|k| strip(quarters.angle() * k as f64 / looks as f64).map(|[a, b]| (a + b) / (0.7 * (b - a))))
        .try_fold(0.0, |m: f64, s| s.map(|s| m.max(s)))?;
    // What is straight instead of curved errs by the square.
    let sagitta = SAGITTA * (limits.tolerance / 1e-3).max(1.0).sqrt();
    let rows = (0.25 * PI * (0.5 * slenderness / sagitta).sqrt()).ceil().clamp(9.0, 120.0) as usize;
    let group = mirrors([0.0; 2], [quarters == Quarters::One; 2]);
    refined(f, &Ring { strip, quarters, group }, (rows * quarters.count(), ACROSS), limits)
}

/// A strip around the crossing of its mirrors, by a quarter, or around another point.
struct Ring<'a> {
    strip: &'a dyn Fn(f64) -> Option<[f64; 2]>,
    quarters: Quarters,
    group: Vec<Isometry>,
}

impl Strip for Ring<'_> {
    fn overlap(&self, along: f64) -> Option<[f64; 2]> {
        (self.strip)(self.quarters.angle() * along)
    }

    fn moves(&self) -> [bool; 2] {
        [true; 2]
    }

    fn all_rows(&self, rows: usize) -> usize {
        4 * rows / self.quarters.count()
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn point(&self, line: usize, stations: &[[f64; 2]], share: f64) -> Point {
        let rows = stations.len() - 1;
        match self.quarters {
            Quarters::One => point(line, rows, |i| between(stations[i], share)),
            Quarters::All => {
                let (sin, cos) = (TAU * line as f64 / rows as f64).sin_cos();
                let r = between(stations[line], share);
                [r * cos, r * sin]
            }
        }
    }

    fn group(&self) -> &[Isometry] {
        &self.group
    }

    /// That of a ring of this radius: the potential on it is 2 ln(8 r/c), that of a line in its middle 2 ln(2 s/c).
    fn reaches(&self, along: f64) -> [f64; 2] {
        let r = self.overlap(along).map_or(0.0, |[a, b]| 0.5 * (a + b));
        [4.0 * r; 2]
    }

    fn length(&self, _: usize, _: usize) -> f64 {
        1.0
    }
}

/// The point of station k of 4 rows, at the distance that a quarter has there; mirrored ones are mirrored exactly.
fn point(k: usize, rows: usize, distance: impl Fn(usize) -> f64) -> Point {
    let (i, sx, sy) = match k / rows {
        0 => (k, 1.0, 1.0),
        1 => (2 * rows - k, -1.0, 1.0),
        2 => (k - 2 * rows, -1.0, -1.0),
        _ => (4 * rows - k, 1.0, -1.0),
    };
    let (sin, cos) = match i {
        0 => (0.0, 1.0),
        i if i == rows => (1.0, 0.0),
        i => (FRAC_PI_2 * i as f64 / rows as f64).sin_cos(),
    };
    let r = distance(i);
    [sx * r * cos, sy * r * sin]
}

#[cfg(test)]
mod tests {
    use super::super::annular::tests::Quadratic;
    use super::super::mesh::Bilinear;
    use super::super::{Law, Span, annular};
    use super::*;

    #[test]
    fn a_round_ring_is_that_of_concentric_rings() {
        // f = 1 - (r - 1)^2/w^2, by concentric rings that are proved.
        for w in [0.3, 0.02] {
            let f = move |[x, y]: Point| 1.0 - ((x.hypot(y) - 1.0) / w).powi(2);
            let found = oval(&f, &move |_| Some([1.0 - w, 1.0 + w]), Quarters::One, &Limits::default()).unwrap();
            assert!(found.error <= 1e-3, "{found:?}");
            let c = 1.0 / (w * w);
            let span = Span { radii: [1.0 - w, 1.0 + w], edges: [false, false] };
            let rings =
                annular(&Quadratic([1.0 - c, 2.0 * c, -c]), &[span], Law::Depth(1.0), &Limits::default()).unwrap();
            assert!(rings.proved);
            let off = [rings.force[0] / found.force - 1.0, 1.0 - rings.force[1] / found.force];
            assert!(off.iter().all(|off| *off <= found.error), "{off:?}, {}", found.error);
            let off = rings.stiffness / found.stiffness - 1.0;
            assert!(off.abs() <= found.stiffness_error + 1e-3, "{off}, {}", found.stiffness_error);
            let area: f64 = found.cells.iter().map(|(c, _)| Bilinear::new(*c).area()).sum();
            assert!((area / found.area - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_ring_without_mirrors_is_the_mirrored_one_where_it_has_them() {
        // An ellipse, seen from its centre and from a point beside it.
        let f = |[x, y]: Point| 1.0 - ((x.hypot(1.2 * y) - 1.0) / 0.1).powi(2);
        let along = |[a, b]: Point, angle: f64| {
            // r of x = a + r cos, y = b + r sin with hypot(x, 1.2 y) = level.
            let (sin, cos) = angle.sin_cos();
            let (p, q) = (cos * cos + 1.44 * sin * sin, a * cos + 1.44 * b * sin);
            [0.9_f64, 1.1].map(|level| {
                let c = a * a + 1.44 * b * b - level * level;
                (-q + (q * q - p * c).sqrt()) / p
            })
        };
        let limits = Limits::default();
        let quarter = oval(&f, &|angle| Some(along([0.0; 2], angle)), Quarters::One, &limits).unwrap();
        for [a, b] in [[0.0; 2], [0.15, -0.1]] {
            let beside = |[x, y]: Point| f([x + a, y + b]);
            let all = oval(&beside, &|angle| Some(along([a, b], angle)), Quarters::All, &limits).unwrap();
            assert!(all.error <= 1e-3 && quarter.error <= 1e-3);
            let off = |of: fn(&Estimated) -> f64| (of(&all) / of(&quarter) - 1.0).abs();
            assert!(off(|s| s.force) <= all.error + quarter.error);
            assert!(off(|s| s.energy) <= all.error + quarter.error);
            assert!(off(|s| s.stiffness) <= all.stiffness_error + quarter.stiffness_error);
            assert!(off(|s| s.area) <= all.area_error + quarter.area_error);
            let [x, y] = all.centre();
            assert!((x + a).hypot(y + b) < 1e-3, "{x} {y}");
        }
    }
}
