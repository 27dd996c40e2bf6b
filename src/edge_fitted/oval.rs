//! Oval rings: contacts that are closed strips with two mirrors, on rows of cells ([`super::rows`]) at stations of a quarter.

use std::f64::consts::{FRAC_PI_2, PI};

use super::Limits;
use super::estimated::Estimated;
use super::mesh::Point;
use super::rows::{Strip, between, refined};
use super::symmetry::{Isometry, mirrors};

/// Share of the half width that a straight cell may leave the curved strip by.
const SAGITTA: f64 = 0.06;

/// Cells across it to each side, to begin with.
const ACROSS: usize = 3;

/// The contact of an overlap (`f`, about the crossing of its mirrors x = 0 and y = 0) that is positive along every ray between the
/// distances that `strip` gives, and nowhere else. `None` where no such contact is found, and once the time is used up.
pub(crate) fn oval(
    f: &dyn Fn(Point) -> f64,
    strip: &dyn Fn(f64) -> Option<[f64; 2]>,
    limits: &Limits,
) -> Option<Estimated> {
    let slenderness = (0..=8)
        .map(|k| strip(FRAC_PI_2 * f64::from(k) / 8.0).map(|[a, b]| (a + b) / (0.7 * (b - a))))
        .try_fold(0.0, |m: f64, s| s.map(|s| m.max(s)))?;
    // What is straight instead of curved errs by the square.
    let sagitta = SAGITTA * (limits.tolerance / 1e-3).max(1.0).sqrt();
    let rows = (0.25 * PI * (0.5 * slenderness / sagitta).sqrt()).ceil().clamp(9.0, 120.0) as usize;
    refined(f, &Quarters { strip, mirrors: mirrors([0.0; 2], [true; 2]) }, (rows, ACROSS), limits)
}

/// A strip around the crossing of its mirrors, by a quarter.
struct Quarters<'a> {
    strip: &'a dyn Fn(f64) -> Option<[f64; 2]>,
    mirrors: Vec<Isometry>,
}

impl Strip for Quarters<'_> {
    fn overlap(&self, along: f64) -> Option<[f64; 2]> {
        (self.strip)(FRAC_PI_2 * along)
    }

    fn moves(&self) -> [bool; 2] {
        [true; 2]
    }

    fn all_rows(&self, rows: usize) -> usize {
        4 * rows
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn point(&self, line: usize, stations: &[[f64; 2]], share: f64) -> Point {
        point(line, stations.len() - 1, |i| between(stations[i], share))
    }

    fn group(&self) -> &[Isometry] {
        &self.mirrors
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
            let found = oval(&f, &move |_| Some([1.0 - w, 1.0 + w]), &Limits::default()).unwrap();
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
}
