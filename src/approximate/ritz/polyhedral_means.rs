//! The means over an ellipse for polyhedral gaps, in closed form.
//!
//! In the coordinates that make the ellipse the unit disc the flat-punch pressure is w = (1 - rho^2)^(-1/2)/(2 pi), the
//! projection of a uniform sphere. The gap is plane but for its ridges; on a ridge at distance q from the centre, t along
//! it, n across it, its slope jumps by kappa n. By the divergence theorem, with z = (1 - q^2 - t^2)^(1/2) and
//! theta = atan2(t, z), every mean is a sum over the ridges of differences between the ends of their segment in the disc:
//!
//! ```text
//! mean g             = g(0) + sum kappa [t z/2 + (1 + q^2) theta/2 - |q| atan2(t, |q| z)]/(2 pi)
//! mean grad g (x) u  = sum kappa n (x) n [t z + (1 - q^2) theta]/(4 pi)
//! mean grad g        = (mean of grad g on the rim) - sum kappa n [q theta - atan2(t q (1 - z), q^2 z + t^2)]/(2 pi)
//! second derivatives = sum kappa (int w (n . dx)^2 dt),  int w (1, t, t^2) dt = [theta, -z, ((1 - q^2) theta - t z)/2]/(2 pi)
//! ```
//!
//! A ridge that crosses the disc from rim to rim cuts off a cap, the share (1 - |q|)/2 of the sphere, and its mean is
//! kappa (1 - |q|)^2/4: nothing cancels, and nothing has to converge, however thin the caps beyond the edge of a blunt tip are.

use std::f64::consts::{PI, SQRT_2, TAU};

use nalgebra::{SMatrix, Vector2};

use super::coordinates::{Ellipse, Step};
use super::disc::Means;
use crate::approximate::fabrikant::ScaledOverlap;
use crate::gap::{Gap, Ridges};

/// Second derivatives in the coordinates of a [`Step`].
pub(super) type Hessian = SMatrix<f64, 5, 5>;

/// A polyhedral gap, with the buffers of its evaluation.
pub(super) struct PolyhedralMeans<'a> {
    pub overlap: &'a ScaledOverlap,
    pub ridges: Ridges,
    /// The corners in the coordinates of the ellipse, and whether each lies in the disc.
    corners: Vec<(Vector2<f64>, bool)>,
    /// Angles at which ridges cross the rim, with the jump met there counter-clockwise.
    crossings: Vec<(f64, Vector2<f64>)>,
    /// Ridges from rim to rim: distance, and jump of the slope.
    chords: Vec<(f64, Vector2<f64>)>,
    /// What rounding may have left in the last mean.
    pub rounding: f64,
}

/// The segment of one ridge inside the disc.
struct RidgeSegment {
    kappa: f64,
    n: Vector2<f64>,
    along: Vector2<f64>,
    q: f64,
    ends: [f64; 2],
    /// Whether it ends there at the rim.
    at_rim: [bool; 2],
}

impl<'a> PolyhedralMeans<'a> {
    /// `None` when the gap is not polyhedral.
    pub fn of(overlap: &'a ScaledOverlap) -> Option<Self> {
        let ridges = overlap.gap.ridges()?;
        let corners = Vec::with_capacity(ridges.corners.len());
        let crossings = Vec::with_capacity(2 * ridges.all.len());
        let chords = Vec::with_capacity(ridges.all.len());
        Some(Self { overlap, ridges, corners, crossings, chords, rounding: 0.0 })
    }

    /// The means, and the second derivatives of the mean gap if `hessian` is given.
    pub fn means(&mut self, e: &Ellipse, mut hessian: Option<&mut Hessian>) -> Option<Means> {
        let inward = e.m.try_inverse()?;
        let into = |p: [f64; 2]| inward * (Vector2::from(p) - e.c);
        self.corners.clear();
        self.corners.extend(self.ridges.corners.iter().map(|&c| {
            let u = into(c);
            (u, u.norm_squared() < 1.0)
        }));
        self.crossings.clear();
        self.chords.clear();
        let mut means = Means { f: self.overlap.at(e.c.into()), slope: Vector2::zeros(), moment: Default::default() };
        self.rounding = f64::EPSILON * means.f.abs();
        for ridge in &self.ridges.all {
            let jump = e.m.tr_mul(&Vector2::from(ridge.jump));
            let Some(stretch) = stretch(jump, into(ridge.point), inward * Vector2::from(ridge.direction), |k| {
                ridge.ends[k].map(|corner| self.corners[corner])
            }) else {
                continue;
            };
            let RidgeSegment { kappa, n, along, q, ends, at_rim } = stretch;
            let hh = ((1.0 - q) * (1.0 + q)).max(0.0);
            let reach = q.abs();
            let mut sums = [0.0; 6];
            for (t, rim, sign) in [(ends[0], at_rim[0], -1.0), (ends[1], at_rim[1], 1.0)] {
                // On the rim z is zero: rounding under the root would leave half the digits.
                let z = if rim { 0.0 } else { (hh - t * t).max(0.0).sqrt() };
                let theta = t.atan2(z);
                let tz = t * z;
                sums[0] += sign * (0.5 * tz + 0.5 * (1.0 + q * q) * theta - reach * t.atan2(reach * z));
                // 1 - z without cancellation.
                let sunk = (q * q + t * t) / (1.0 + z);
                sums[1] += sign * (q * theta - (t * q * sunk).atan2(q * q * z + t * t));
                sums[2] += sign * 0.5 * (tz + hh * theta);
                sums[3] += sign * theta;
                sums[4] -= sign * z;
                sums[5] += sign * 0.5 * (hh * theta - tz);
            }
            let share = kappa / TAU;
            let chord = at_rim == [true; 2];
            if chord {
                sums[0] = 0.5 * PI * (1.0 - reach) * (1.0 - reach);
                self.chords.push((q, jump));
            } else {
                self.rounding += f64::EPSILON * share;
            }
            means.f -= share * sums[0];
            if !chord {
                means.slope -= n * (share * sums[1]);
            }
            means.moment += n * n.transpose() * (share * sums[2]);
            if let Some(hessian) = hessian.as_deref_mut() {
                let squares =
                    |a: Vector2<f64>, b: Vector2<f64>| [a.x * b.x, a.y * b.y, (a.x * b.y + a.y * b.x) / SQRT_2];
                let ([a, b, c], [d, f, g]) = (squares(n, n), squares(n, along));
                let fixed = Step::new(n.x, n.y, q * a, q * b, q * c);
                let rate = Step::new(0.0, 0.0, d, f, g);
                let mixed = fixed * rate.transpose();
                *hessian += (fixed * fixed.transpose() * sums[3]
                    + (mixed + mixed.transpose()) * sums[4]
                    + rate * rate.transpose() * sums[5])
                    * share;
            }
            for k in 0..2 {
                if at_rim[k] {
                    let u = n * q + along * ends[k];
                    // Counter-clockwise along the rim: across the ridge along n or against it.
                    let sense = (u.x * n.y - u.y * n.x).signum();
                    self.crossings.push((u.y.atan2(u.x), if chord { Vector2::zeros() } else { jump * sense }));
                }
            }
        }
        means.slope += self.rim(e);
        Some(means)
    }

    /// Mean of the slope over the rim: that in the middle of the widest stretch without a ridge, and the jumps from there.
    fn rim(&mut self, e: &Ellipse) -> Vector2<f64> {
        let crossings = &mut self.crossings;
        crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let n = crossings.len();
        let turn = |k: usize| (crossings[(k + 1) % n].0 - crossings[k].0).rem_euclid(TAU);
        let start = match (0..n).max_by(|&a, &b| turn(a).total_cmp(&turn(b))) {
            // A single crossing leaves all of the turn.
            Some(k) => crossings[k].0 + 0.5 * if n == 1 { TAU } else { turn(k) },
            None => 0.0,
        };
        let (sin, cos) = start.sin_cos();
        let at = e.c + e.m * Vector2::new(cos, sin);
        let mut mean = e.m.tr_mul(&Vector2::from(self.overlap.slope(at.into(), 0.0)));
        for (angle, jump) in crossings {
            let left = (start - *angle).rem_euclid(TAU);
            mean += *jump * (left / TAU);
        }
        for (q, jump) in &self.chords {
            // The share of the other side.
            let beyond = jump.x * cos + jump.y * sin > q * jump.norm();
            mean += *jump * if beyond { -0.5 * (1.0 + q) } else { 0.5 * (1.0 - q) };
        }
        mean
    }
}

/// What of a ridge lies in the disc: `jump` of the slope, a `point`, a `direction`, and its ends where it has any.
fn stretch(
    jump: Vector2<f64>,
    point: Vector2<f64>,
    direction: Vector2<f64>,
    end: impl Fn(usize) -> Option<(Vector2<f64>, bool)>,
) -> Option<RidgeSegment> {
    let kappa = jump.norm();
    if !(kappa > 0.0) {
        return None;
    }
    let n = jump / kappa;
    let q = n.dot(&point);
    let across = Vector2::new(-n.y, n.x);
    let along = if across.dot(&direction) < 0.0 { -across } else { across };
    let half = ((1.0 - q) * (1.0 + q)).max(0.0).sqrt();
    let place = |k: usize, beyond: f64| match end(k) {
        Some((corner, inside)) => (along.dot(&corner), inside),
        None => (beyond, false),
    };
    let (from, to) = (place(0, f64::NEG_INFINITY), place(1, f64::INFINITY));
    if !from.1 && !to.1 && !(half > 0.0 && from.0 < 0.0 && to.0 > 0.0) {
        return None;
    }
    let ends = [if from.1 { from.0 } else { -half }, if to.1 { to.0 } else { half }];
    Some(RidgeSegment { kappa, n, along, q, ends, at_rim: [!from.1, !to.1] })
}

#[cfg(test)]
mod tests {
    use super::super::disc::Disc;
    use super::*;
    use crate::approximate::fabrikant::{ScaledOverlap, Sectors, THIRD};
    use crate::gap::{AnyGap, Polyhedron};
    use nalgebra::Matrix2;

    fn overlap(gap: impl Into<AnyGap>) -> ScaledOverlap {
        ScaledOverlap::unscaled(gap.into())
    }

    fn gaps() -> [Polyhedron; 4] {
        let planes = vec![[1.0, 0.0, 0.0], [0.4, 0.8, 0.1], [-0.7, 0.6, 0.0], [-0.8, -0.5, 0.05], [0.3, -1.1, 0.0]];
        [
            Polyhedron::pyramid(3, 0.7).unwrap(),
            Polyhedron::new(planes).unwrap(),
            Polyhedron::truncated_pyramid(6, 0.7, 0.4).unwrap(),
            Polyhedron::pyramid(2, 0.7).unwrap(),
        ]
    }

    fn ellipses() -> Vec<Ellipse> {
        let m = Matrix2::new(0.7, 0.1, -0.2, 0.4);
        [[0.0, 0.0], [0.05, -0.1], [0.4, 0.3], [-0.9, 1.2]]
            .into_iter()
            .flat_map(|c: [f64; 2]| [m, m * 3.0, m * 0.05].map(|m| Ellipse { c: c.into(), m }))
            .collect()
    }

    /// The same mean by the quadrature, with panels without end; the slopes are its derivatives, tested below.
    #[test]
    fn closed_form_and_quadrature_agree() {
        for gap in &gaps() {
            let f = overlap(gap);
            for e in ellipses() {
                let exact = PolyhedralMeans::of(&f).unwrap().means(&e, None).unwrap();
                let mut directions = Vec::new();
                gap.kink_directions([0.0; 2], &mut directions);
                let mut disc = Disc::new(&f, Sectors::between(&directions, THIRD), 2);
                let mut error = f64::INFINITY;
                let mut means = disc.means(&e, disc.rule());
                for _ in 0..20 {
                    let (nodes, values) = (disc.nodes.clone(), disc.values.clone());
                    error = disc.sectors.error(&nodes, &values);
                    if error < 1e-15 || !disc.sectors.refine(&nodes, &values, 1e-15, 30_000) {
                        break;
                    }
                    means = disc.means(&e, disc.rule());
                }
                // Where ridges cross the rim the sum over the angle is good to 1e-8, whatever it thinks of itself.
                assert!((means.f - exact.f).abs() < 5e-8 + error, "{} {}", means.f, exact.f);
            }
        }
    }

    /// Slope and moment are the derivatives of the mean, and the Hessian theirs.
    #[test]
    fn derivatives_are_those_of_the_mean() {
        for gap in &gaps() {
            let f = overlap(gap);
            let mut polyhedral = PolyhedralMeans::of(&f).unwrap();
            for e in ellipses() {
                let mut hessian = Hessian::zeros();
                let here = polyhedral.means(&e, Some(&mut hessian)).unwrap();
                let gradient = |m: &Means| {
                    let t = &m.moment;
                    Step::new(m.slope.x, m.slope.y, t[(0, 0)], t[(1, 1)], (t[(0, 1)] + t[(1, 0)]) / SQRT_2)
                };
                for k in 0..5 {
                    const H: f64 = 1e-5;
                    let shift = |sign: f64| {
                        let x = Step::ith(k, sign * H);
                        let s = x[4] / SQRT_2;
                        let linear = Matrix2::new(1.0 + x[2], s, s, 1.0 + x[3]);
                        Ellipse { c: e.c + e.m * Vector2::new(x[0], x[1]), m: e.m * linear }
                    };
                    let (up, down) = [1.0, -1.0].map(|s| polyhedral.means(&shift(s), None).unwrap()).into();
                    let scale = 1.0 + here.f.abs();
                    let [far_up, far_down] = [1e-4, -1e-4].map(|h| polyhedral.means(&shift(h / H), None).unwrap().f);
                    let second = (2.0 * here.f - far_up - far_down) / 1e-8;
                    assert!((second - hessian[(k, k)]).abs() < 1e-3 * scale, "{k} {second} {}", hessian[(k, k)]);
                    assert!(((down.f - up.f) / (2.0 * H) - gradient(&here)[k]).abs() < 1e-7 * scale, "{k}");
                    if k < 2 {
                        let bent = (gradient(&up) - gradient(&down)) / (2.0 * H);
                        assert!((bent - hessian.column(k)).norm() < 1e-5 * scale, "{k} {bent} {hessian}");
                    }
                }
            }
        }
    }

    /// A corner in the very middle, and one on the rim.
    #[test]
    fn corners_in_awkward_places() {
        let gap = Polyhedron::pyramid(3, 0.25 * PI).unwrap();
        let f = overlap(&gap);
        let mut polyhedral = PolyhedralMeans::of(&f).unwrap();
        let r = 0.5;
        let mean = |polyhedral: &mut PolyhedralMeans, x: f64| {
            polyhedral.means(&Ellipse { c: Vector2::new(x, 0.0), m: Matrix2::identity() * r }, None).unwrap()
        };
        // Section 4.3: the mean of the gap over a circle about the apex is (pi/4) r (3/pi) sin(pi/3).
        let here = mean(&mut polyhedral, 0.0);
        assert!((here.f - (1.0 - 0.25 * PI * r * 3.0 / PI * (PI / 3.0).sin())).abs() < 1e-15);
        assert!(here.slope.norm() < 1e-15);
        for x in [1e-17, 1e-15, 1e-12, r, r * (1.0 - 1e-16), r * (1.0 + 3e-16)] {
            let (near, there) = (mean(&mut polyhedral, x + 1e-9), mean(&mut polyhedral, x));
            assert!((near.slope - there.slope).norm() < 1e-6 && (near.f - there.f).abs() < 1e-8, "{x}");
        }
    }
}
