//! A quarter of a cell as it is integrated where the overlap has a kink, where the extension fades, and where signs have to be known.
//!
//! The quarter is turned so that it is that of s, t > 0, (s, t) in sides of the cell from its centre. Along each half side there are
//! seven points: three of Gauss in the inner half, four of Gauss in the root of the distance from the side in the outer half, where
//! the slopes have a logarithm. They belong to four sub-squares.

use super::basis::{BENDS, DEGREES, POLYNOMIALS, legendre, slopes};
use super::lane::{LANES, Lane};
use super::touching::{FIRSTS, SINGULAR, TOUCHING, Touching};
use crate::numeric::quadrature::GaussLegendre;

/// Points along half a side.
pub(super) const POINTS: usize = 7;

/// Of these in the inner half.
pub(super) const INNER: usize = 3;

/// What the rule may miss of the integrals of |grad(chi r)|^2 and of (chi r)^2 over a sub-square: r = sum of c_k P_k + sum of
/// v_j Z_j, chi bilinear in the quarter with 0 or 1 at each of its corners, or 1 or 2. Divided by the shorter side, and times it, the
/// longer one 1: less than these times the sum of v_j^2 + [`WEIGHTS`] c_k^2, the weight that of the higher of the degrees of P_k.
/// The errors are quadratic forms of (v, c); the test compares them with these numbers as matrices.
pub(super) const MISSED: [[f64; 2]; 4] = [[4e-7, 1e-8], [1e-5, 2.4e-7], [1e-5, 2.4e-7], [1.4e-5, 2.4e-7]];

/// See [`MISSED`].
pub(super) const WEIGHTS: [f64; 5] = [20.0, 200.0, 1000.0, 5000.0, 20000.0];

/// Places along half a side where signs are looked at: corners of sub-squares and points half way.
pub(super) const LATTICE: [f64; CORNERS] = [0.0, 0.125, 0.25, 0.375, 0.5];

/// Their number.
pub(super) const CORNERS: usize = 5;

/// The rule, the polynomials and the displacement by the cells that touch at its points. Numbers along x lie in lanes, as many of
/// them as there are points; the rest is zero.
#[derive(Debug)]
pub(super) struct Rule {
    /// Sides of the cell.
    pub h: [f64; 2],
    /// Places and weights along half a side.
    pub places: [f64; POINTS],
    pub weights: [f64; POINTS],
    /// P_a at the points, and its slope by s: along x, and along y.
    pub along: [[Lane; 5]; 2],
    pub across: [[[f64; 5]; POINTS]; 2],
    /// L_j of the eight cells that touch and its slopes: for each j along y, x in lanes.
    pub singular: [[[Lane; 3]; POINTS]; 8],
    /// P_a at the places of [`LATTICE`], along x and along y.
    pub corners: ([Lane; 5], [[f64; 5]; CORNERS]),
    /// L_j at the same places.
    pub at_corners: [[Lane; CORNERS]; 8],
    /// For each sub-square, x fastest: the largest distance of L_j from the bilinear functions through its values on the lattice; for
    /// the quarter, from the one through its corners.
    pub bends: [[f64; 8]; 5],
    /// Coefficients of the projection of L_j on the polynomials.
    pub projections: [[f64; POLYNOMIALS]; 8],
    /// Bounds of the eight singular functions of the classes, [`super::touching::SINGULAR`], in the cell.
    pub suprema: [f64; 8],
}

fn in_lanes(of: impl Fn(usize) -> f64, count: usize) -> Lane {
    let mut lane = [0.0; LANES];
    lane.iter_mut().enumerate().take(count).for_each(|(k, to)| *to = of(k));
    lane
}

impl Rule {
    /// Without its functions.
    pub fn empty(h: [f64; 2]) -> Self {
        let lane = [0.0; LANES];
        Self {
            h,
            places: [0.0; POINTS],
            weights: [0.0; POINTS],
            along: [[lane; 5]; 2],
            across: [[[0.0; 5]; POINTS]; 2],
            singular: [[[lane; 3]; POINTS]; 8],
            corners: ([lane; 5], LATTICE.map(legendre)),
            at_corners: [[lane; CORNERS]; 8],
            bends: [[0.0; 8]; 5],
            projections: [[0.0; POLYNOMIALS]; 8],
            suprema: [0.0; 8],
        }
    }

    /// `projections`: those of the cells (1, 0), (0, 1), (1, 1) on the polynomials, row b, column a.
    pub fn new(h: [f64; 2], projections: &[[[f64; 5]; 5]; 3]) -> Self {
        let mut rule = Self::empty(h);
        let (inner, outer) = (GaussLegendre::new(INNER), GaussLegendre::new(POINTS - INNER));
        for (k, (x, w)) in inner.nodes().iter().enumerate() {
            (rule.places[k], rule.weights[k]) = (0.125 * (1.0 + x), 0.125 * w);
        }
        for (k, (x, w)) in outer.nodes().iter().enumerate() {
            let t = 0.5 * (1.0 - x);
            (rule.places[INNER + k], rule.weights[INNER + k]) = (0.5 - 0.25 * t * t, 0.25 * t * w);
        }
        let places = rule.places;
        for a in 0..5 {
            rule.along[0][a] = in_lanes(|k| legendre(places[k])[a], POINTS);
            rule.along[1][a] = in_lanes(|k| slopes(places[k])[a], POINTS);
            rule.corners.0[a] = in_lanes(|k| legendre(LATTICE[k])[a], CORNERS);
        }
        rule.across = [places.map(legendre), places.map(slopes)];
        let (at_points, at_lattice) = (Touching::new(h, &places, &places), Touching::new(h, &LATTICE, &LATTICE));
        for (n, offset) in TOUCHING.into_iter().enumerate() {
            let cell = match offset.map(i32::abs) {
                [1, 0] => 0,
                [0, 1] => 1,
                _ => 2,
            };
            // The projection of an image has the signs of odd powers turned.
            let sign = |m: usize, a: usize| if offset[m] < 0 && a % 2 == 1 { -1.0 } else { 1.0 };
            rule.projections[n] = DEGREES.map(|[a, b]| projections[cell][b][a] * sign(0, a) * sign(1, b));
            for y in 0..POINTS {
                for m in 0..3 {
                    rule.singular[n][y][m] = in_lanes(|x| at_points.at(x, y, offset)[m], POINTS);
                }
            }
            for y in 0..CORNERS {
                rule.at_corners[n][y] = in_lanes(|x| at_lattice.at(x, y, offset)[0], CORNERS);
            }
            for square in 0..16 {
                let place = [square % 4, square / 4];
                let whole = &mut rule.bends[place[0] / 2 + 2 * (place[1] / 2)][n];
                *whole = whole.max(bend(h, offset, place, 0.125));
            }
            rule.bends[4][n] = bend(h, offset, [0, 0], 0.5);
        }
        rule.suprema(projections, &at_lattice);
        rule
    }

    /// Each function has a parity: its values on the lattice of the quarter, and how far it may be from them in between.
    fn suprema(&mut self, projections: &[[[f64; 5]; 5]; 3], at_lattice: &Touching) {
        let q2 = (LATTICE[1] - LATTICE[0]).powi(2);
        for class in 0..4 {
            for (f, cell) in (FIRSTS[class]..).zip(SINGULAR[class]) {
                let own = |a: usize, b: usize| a % 2 == class & 1 && b % 2 == class >> 1;
                let terms = || DEGREES.into_iter().filter(|[a, b]| own(*a, *b));
                let c = |a: usize, b: usize| projections[*cell][b][a];
                let mut most = 0.0_f64;
                for (y, t) in LATTICE.into_iter().enumerate() {
                    for (x, s) in LATTICE.into_iter().enumerate() {
                        let (p, q) = (legendre(s), legendre(t));
                        let projection: f64 = terms().map(|[a, b]| c(a, b) * p[a] * q[b]).sum();
                        most = most.max((at_lattice.of_class([x, y], *cell, class)[0] - projection).abs());
                    }
                }
                let smooth: f64 = terms().map(|[a, b]| c(a, b).abs() * 0.125 * q2 * (BENDS[a] + BENDS[b])).sum();
                // The mean of the images bends no more than the one that bends most.
                let of_cell = |offset: [i32; 2]| offset.map(i32::abs) == [[1, 0], [0, 1], [1, 1]][*cell];
                let images = TOUCHING.into_iter().enumerate().filter(|(_, offset)| of_cell(*offset));
                let bends = images.map(|(n, _)| self.bends[..4].iter().map(|b| b[n]).fold(0.0, f64::max));
                self.suprema[f] = most + smooth + bends.fold(0.0, f64::max);
            }
        }
    }
}

/// Bound of the distance, anywhere in a square of this side, of L_j from the bilinear function through its values at the corners.
///
/// Linear interpolation over a length q errs by M q^2/8 at most where the second derivative is at most M, and by M q/e where it is at
/// most M/x at the distance x from one end. With u the distance along an axis from one end of the cell j, and v_1, v_2 the distances
/// across the axis from its two sides,
///
///   pi L_uu = +-(v_2/r_2 - v_1/r_1)/u, summed over the two ends:
///
/// less than 2/u beside the cell, less than 1/u and 1/(2 v_1) where it lies aside, and of opposite signs at the two ends for a point
/// beyond both of them.
fn bend(h: [f64; 2], offset: [i32; 2], square: [usize; 2], side: f64) -> f64 {
    let q = [side * h[0], side * h[1]];
    // From 0 and from the far ends of the cell to the square, along an axis.
    let from = |k: usize| square[k] as f64 * q[k];
    let to = |k: usize| 0.5 * h[k] - from(k) - q[k];
    let mut sum = 0.0;
    for m in 0..2 {
        let near = |k: usize| match offset[k] {
            0 => 0.0,
            1 => to(k),
            _ => 0.5 * h[k] + from(k),
        };
        let (aside, v) = (offset[1 - m] != 0, near(1 - m));
        let error = |u: f64| {
            // u = 0 but for rounding: an end.
            let along = (q[m] / (8.0 * u.max(0.0))).min((-1.0_f64).exp());
            let bound = if aside { along.min(q[m] / (16.0 * v)) } else { 2.0 * along };
            std::f64::consts::FRAC_1_PI * q[m] * bound
        };
        sum += match offset[m] {
            // Between the ends of the cell.
            0 => error(to(m)) + error(0.5 * h[m] + from(m)),
            _ => error(near(m)),
        };
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::tables::Tables;
    use super::*;

    #[test]
    fn suprema_do_not_hang_on_the_rounding_of_sides() {
        for k in 0..400 {
            let h = 0.5 + 0.5 * f64::from(k) / 400.0;
            for h in [[1.0, h], [h, 1.0]] {
                let projections = [[[0.0; 5]; 5]; 3];
                let rule = Rule::new(h, &projections);
                assert!(rule.bends.iter().flatten().chain(&rule.suprema).all(|most| *most < 1.0), "{h:?}");
            }
        }
    }

    #[test]
    fn no_point_of_a_sub_square_lies_further_from_its_corners_than_stated() {
        let n = 24;
        let fine: Vec<f64> = (0..=4 * n).map(|k| 0.125 * k as f64 / n as f64).collect();
        for h in [[1.0, 1.0], [0.7, 1.0], [1.0, 0.55]] {
            let tables = Tables::of(h).unwrap();
            let touching = Touching::new(h, &fine, &fine);
            for (j, offset) in TOUCHING.into_iter().enumerate() {
                let l = |x: usize, y: usize| touching.at(x, y, offset)[0];
                // Squares of 1, and of 4 steps of the lattice.
                for (square, step) in (0..16).map(|k| (k, n)).chain([(0, 4 * n)]) {
                    let [a, b] = [square % 4 * n, square / 4 * n];
                    let mut largest = 0.0_f64;
                    for y in 0..=step {
                        for x in 0..=step {
                            let (s, t) = (x as f64 / step as f64, y as f64 / step as f64);
                            let bilinear = (1.0 - t) * ((1.0 - s) * l(a, b) + s * l(a + step, b))
                                + t * ((1.0 - s) * l(a, b + step) + s * l(a + step, b + step));
                            largest = largest.max((l(a + x, b + y) - bilinear).abs());
                        }
                    }
                    let stated = tables.rule.bends[if step > n { 4 } else { square % 4 / 2 + 2 * (square / 8) }][j];
                    assert!(largest < stated, "{h:?} {offset:?} {square} {step}: {largest} {stated}");
                }
            }
        }
    }
}
