//! The best ellipse of a convex gap: the maximum of a concave function, and so the only one.
//!
//! Write the ellipse as c + M u with M symmetric and positive. The overlap f = d - g is concave, hence so is its mean over
//! the disc as a function of (c, M); and the stiffness, the arithmetic-geometric mean of the eigenvalues of M, is concave
//! too. The logarithm of their product, log P, is concave: whatever stands still is the maximum over all ellipses.
//!
//! Newton's method with all second derivatives finds it, each step cut where the slope along it has fallen enough. Beyond an
//! edge of a blunt tip the second derivative grows without limit as the overhang shrinks; where Newton's steps then stall (34 of
//! 220 blunt punches at depths of 1e-9 to 1), the ellipsoid method (Shor 1977; with deep cuts, Bland, Goldfarb & Todd 1981)
//! converges whatever the shape of the function. By the quadrature of `smooth.rs` instead, five irregular faces take 1.4 times the time of
//! the whole answer, means lose eight digits or more, and a thousand faces have no answer.

use nalgebra::{Matrix2, Vector2};

use super::coordinates::{Ellipse, Step, eigen, mean_and_share};
use super::disc::{Means, logarithmic_slope};
use super::diverged;
use super::polyhedral_means::{Hessian, PolyhedralMeans};
use crate::solution::Unsolved;

/// Newton steps before the ellipsoid method is called.
const MOST_STEPS: usize = 60;
/// Trials along one step.
const MOST_TRIALS: usize = 60;
/// Share of the slope that may be left at the end of a step.
const ENOUGH: f64 = 0.5;
/// Cuts of the ellipsoid method: five unknowns lose a factor of 1e9 in their range.
const MOST_CUTS: usize = 3000;
/// Half the range in which the ellipsoid method looks, in sizes of the ellipse that it starts from.
const RANGE: f64 = 4.0;

/// The maximum that was found.
pub(super) struct Maximum {
    pub e: Ellipse,
    pub mean: f64,
    /// Newton's decrement: the length of the last step in units of the curvature; log P gains half its square by it.
    pub decrement: f64,
    /// Largest eigenvalue of the second variation of log P.
    pub largest: f64,
    pub steps: usize,
}

/// One place: log of P over 2 E*, its gradient, the means, and the second derivatives of the mean gap.
struct Place {
    e: Ellipse,
    log: f64,
    gradient: Step,
    means: Means,
    mean_hessian: Hessian,
}

/// Log P over the ellipses of a polyhedral gap, or over its circles.
pub(super) struct Concave<'a, 'b> {
    pub polyhedral: &'b mut PolyhedralMeans<'a>,
    pub circles: bool,
}

impl Concave<'_, '_> {
    /// From `start`, until half the square of Newton's decrement is below `allowed` squared, or rounding ends it.
    pub fn maximise(&mut self, start: Ellipse, allowed: f64) -> Result<Maximum, Unsolved> {
        let mut place = self.loaded(start)?;
        let mut steps = 0;
        // Less is not worth a step: rounding, or what the force need not be known to.
        let little = (1e-3 * allowed).max(1e-15);
        for _ in 0..2 {
            let top = self.newton(&mut place, allowed, &mut steps);
            if 0.5 * top.decrement * top.decrement <= little {
                return Ok(top);
            }
            let left = self.ellipsoid_method(&mut place, little, &mut steps);
            if left <= little {
                let top = self.newton(&mut place, allowed, &mut steps);
                return Ok(Maximum { decrement: top.decrement.min((2.0 * left).sqrt()), ..top });
            }
        }
        Err(diverged(
            "the largest force over ellipses was not found by Newton's method, nor in 3000 cuts of an ellipsoid",
        ))
    }

    fn at(&mut self, e: Ellipse) -> Option<Place> {
        let mut mean_hessian = Hessian::zeros();
        let means = self.polyhedral.means(&e, Some(&mut mean_hessian))?;
        let (force, gradient) = logarithmic_slope(&e, &means, self.circles)?;
        Some(Place { e, log: force.ln(), gradient, means, mean_hessian })
    }

    /// The ellipse, halved until it carries load.
    fn loaded(&mut self, mut e: Ellipse) -> Result<Place, Unsolved> {
        for _ in 0..200 {
            if let Some(place) = self.at(e) {
                return Ok(place);
            }
            e.m *= 0.5;
        }
        Err(diverged("no ellipse carries load"))
    }

    /// Newton's method from `place`, which it moves.
    fn newton(&mut self, place: &mut Place, allowed: f64, steps: &mut usize) -> Maximum {
        let top = |place: &Place, decrement: f64, largest: f64, steps: usize| Maximum {
            e: place.e,
            mean: place.means.f,
            decrement,
            largest,
            steps,
        };
        let mut last = top(place, f64::INFINITY, f64::NAN, *steps);
        for _ in 0..MOST_STEPS {
            let hessian = self.second_variation(place);
            let Some((step, largest)) = uphill(&hessian, &place.gradient) else { break };
            let decrement = place.gradient.dot(&step).max(0.0).sqrt();
            last = top(place, decrement, largest, *steps);
            if decrement <= allowed {
                break;
            }
            match self.line_search(place, &step) {
                Some(next) => *place = next,
                None => break,
            }
            *steps += 1;
        }
        last
    }

    /// A place with more force along the step, where the slope along it has fallen enough.
    fn line_search(&mut self, from: &Place, step: &Step) -> Option<Place> {
        let rise = from.gradient.dot(step);
        let most = step.amax();
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut share = if most > 0.7 { 0.7 / most } else { 1.0 };
        let mut best: Option<Place> = None;
        for _ in 0..MOST_TRIALS {
            let next = self.at(from.e.moved(&(step * share)));
            let slope = next.as_ref().map(|p| p.gradient.dot(&carried(step, share)));
            match (next, slope) {
                (Some(place), Some(slope)) if place.log >= from.log && slope >= -ENOUGH * rise => {
                    let enough = slope <= ENOUGH * rise || share >= 1.0;
                    let better = best.as_ref().is_none_or(|b| place.log > b.log);
                    if better {
                        best = Some(place);
                    }
                    if enough {
                        return best;
                    }
                    low = share;
                }
                _ => high = share,
            }
            share = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * share };
            if !(share * most > 1e-17) || high - low <= 1e-3 * high {
                break;
            }
        }
        best
    }

    /// Second derivatives of log P in the logarithmic strain.
    fn second_variation(&self, place: &Place) -> Hessian {
        let (f, t) = (place.means.f, &place.means.moment);
        let shear = 0.5 * (t[(0, 1)] + t[(1, 0)]);
        let slope = Step::new(
            -place.means.slope.x,
            -place.means.slope.y,
            -t[(0, 0)],
            -t[(1, 1)],
            -std::f64::consts::SQRT_2 * shear,
        ) / f;
        // exp(S) = 1 + S + S^2/2: the mean slope along S^2 u.
        let mut stretch = Hessian::zeros();
        stretch[(2, 2)] = t[(0, 0)];
        stretch[(3, 3)] = t[(1, 1)];
        stretch[(4, 4)] = 0.5 * (t[(0, 0)] + t[(1, 1)]);
        for k in [2, 3] {
            stretch[(k, 4)] = shear / std::f64::consts::SQRT_2;
            stretch[(4, k)] = stretch[(k, 4)];
        }
        let hessian = stiffness_hessian(&place.e) - (place.mean_hessian + stretch) / f - slope * slope.transpose();
        if !self.circles {
            return hessian;
        }
        // Within the three directions of a circle; the others are held.
        let within = circle_directions();
        within * hessian * within - (Hessian::identity() - within)
    }

    /// The ellipsoid method about `best`, which it moves: until no other place can have `gain` more in log P. Returns how much
    /// more any other can have.
    fn ellipsoid_method(&mut self, best: &mut Place, gain: f64, steps: &mut usize) -> f64 {
        // M = L (1 + S) L with L = M^(1/2) symmetric: linear in S, so that log P is concave in (v, S).
        let frame = EllipseChart::of(&best.e);
        let within = if self.circles { circle_directions() } else { Hessian::identity() };
        let n: f64 = if self.circles { 3.0 } else { 5.0 };
        let mut centre = Step::zeros();
        let mut shape = within * (RANGE * RANGE);
        let mut left = f64::INFINITY;
        for _ in 0..MOST_CUTS {
            *steps += 1;
            let at = frame.ellipse(&centre).and_then(|e| self.at(e));
            // The maximum lies where slope . (x - centre) >= more.
            let loaded = at.is_some();
            let (slope, more) = match at {
                Some(place) => {
                    let slope = frame.gradient(&place);
                    let more = best.log - place.log;
                    if place.log > best.log {
                        *best = place;
                    }
                    (slope, more.max(0.0))
                }
                None => (frame.towards_load(&centre, self.polyhedral), 0.0),
            };
            let slope = within * slope;
            let width = slope.dot(&(shape * slope)).sqrt();
            // Upper bound of what the ellipsoid can still hold, by the gradient at a place with load.
            if loaded {
                left = left.min((width - more).max(0.0));
            }
            let depth = more / width;
            if left <= gain || !(depth < 1.0) {
                break;
            }
            let b = shape * slope / width;
            centre += b * ((1.0 + n * depth) / (n + 1.0));
            let factor = n * n / (n * n - 1.0) * (1.0 - depth * depth);
            shape = (shape - b * b.transpose() * (2.0 * (1.0 + n * depth) / ((n + 1.0) * (1.0 + depth)))) * factor;
        }
        left
    }
}

/// The projection on centre and equal strain.
fn circle_directions() -> Hessian {
    let mut within = Hessian::zeros();
    within[(0, 0)] = 1.0;
    within[(1, 1)] = 1.0;
    within.fixed_view_mut::<2, 2>(2, 2).fill(0.5);
    within
}

/// The direction of a step as seen from the place that a share of it leads to.
fn carried(step: &Step, share: f64) -> Step {
    let shear = step[4] / std::f64::consts::SQRT_2;
    let s = Matrix2::new(step[2], shear, shear, step[3]) * share;
    let back = Matrix2::identity() - s + s * s / 2.0 - s * s * s / 6.0;
    let v = back * Vector2::new(step[0], step[1]);
    Step::new(v.x, v.y, step[2], step[3], step[4])
}

/// Newton's step with the Hessian made negative where it is not, and its largest eigenvalue.
fn uphill(hessian: &Hessian, gradient: &Step) -> Option<(Step, f64)> {
    if !hessian.iter().all(|h| h.is_finite()) {
        return None;
    }
    let eigen = hessian.symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(gradient);
    let floor = 1e-3;
    let step = eigen.eigenvectors * along.zip_map(&eigen.eigenvalues, |g, h| g / (-h).max(floor));
    Some((step, eigen.eigenvalues.max()))
}

/// Second derivatives of log agm(M exp S). With a = e^(m + delta), b = e^(m - delta) it is m + h(delta); a shear s of the
/// axes changes delta by s^2 coth(2 delta).
fn stiffness_hessian(e: &Ellipse) -> Hessian {
    let ([a, b], _, v) = e.axes();
    let delta = 0.5 * (a / b).ln();
    // h'(delta) = 2 share - 1, odd.
    let first = |delta: f64| {
        let (_, share) = mean_and_share(1.0, (-2.0 * delta.abs()).exp());
        (2.0 * share - 1.0) * delta.signum()
    };
    const H: f64 = 1e-3;
    let second = (first(delta + H) - first(delta - H)) / (2.0 * H);
    let shearing = if delta < H { second } else { 2.0 * first(delta) / (2.0 * delta).tanh() };
    let root = std::f64::consts::SQRT_2;
    let (c, s) = (v.x * v.x - v.y * v.y, v.x * v.y);
    let apart = Step::new(0.0, 0.0, 0.5 * c, -0.5 * c, root * s);
    let shear = Step::new(0.0, 0.0, -s, s, c / root);
    apart * apart.transpose() * second + shear * shear.transpose() * shearing
}

/// Linear coordinates about one ellipse.
struct EllipseChart {
    c: Vector2<f64>,
    root: Matrix2<f64>,
}

impl EllipseChart {
    fn of(e: &Ellipse) -> Self {
        let (squares, vectors) = eigen(&(e.m * e.m.transpose()));
        let fourth = Matrix2::from_diagonal(&Vector2::from(squares).map(|s| s.sqrt().sqrt()));
        Self { c: e.c, root: vectors * fourth * vectors.transpose() }
    }

    fn strain(x: &Step) -> Matrix2<f64> {
        let shear = x[4] / std::f64::consts::SQRT_2;
        Matrix2::new(1.0 + x[2], shear, shear, 1.0 + x[3])
    }

    /// The ellipse at these coordinates, if it is one.
    fn ellipse(&self, x: &Step) -> Option<Ellipse> {
        let strain = Self::strain(x);
        let ([low, _], _) = eigen(&strain);
        (low > 1e-12).then(|| Ellipse {
            c: self.c + self.root * self.root * Vector2::new(x[0], x[1]),
            m: self.root * strain * self.root,
        })
    }

    /// The gradient of log P in these coordinates: that in the ellipse's own, carried over.
    fn gradient(&self, place: &Place) -> Step {
        let Some(inward) = place.e.m.try_inverse() else { return Step::zeros() };
        let g = &place.gradient;
        let shear = g[4] / std::f64::consts::SQRT_2;
        let own = Matrix2::new(g[2], shear, shear, g[3]);
        // d log P = tr(own M^-1 L dS L).
        let s = self.root * own * inward * self.root;
        let v = self.root * self.root * inward.transpose() * Vector2::new(g[0], g[1]);
        Step::new(v.x, v.y, s[(0, 0)], s[(1, 1)], (s[(0, 1)] + s[(1, 0)]) / std::f64::consts::SQRT_2)
    }

    /// From where there is no load: towards more overlap, or towards an ellipse again.
    fn towards_load(&self, x: &Step, polyhedral: &mut PolyhedralMeans) -> Step {
        let Some(e) = self.ellipse(x) else {
            let (_, vectors) = eigen(&Self::strain(x));
            let w = vectors.column(0);
            return Step::new(0.0, 0.0, w[0] * w[0], w[1] * w[1], std::f64::consts::SQRT_2 * w[0] * w[1]);
        };
        let (Some(means), Some(inward)) = (polyhedral.means(&e, None), e.m.try_inverse()) else { return Step::zeros() };
        let t = -means.moment;
        let s = self.root * (0.5 * (t + t.transpose())) * inward * self.root;
        let v = -(self.root * self.root * inward.transpose() * means.slope);
        Step::new(v.x, v.y, s[(0, 0)], s[(1, 1)], (s[(0, 1)] + s[(1, 0)]) / std::f64::consts::SQRT_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::approximate::fabrikant::ScaledOverlap;
    use crate::gap::{AnyGap, Polyhedron};

    /// The second variation is the derivative of the gradient.
    #[test]
    fn second_variation_by_differences() {
        let punch = Polyhedron::new(vec![[1.0, 0.0, 0.0], [-0.4, 0.8, -0.1], [-0.3, -0.9, 0.0], [0.0; 3]]).unwrap();
        let gap = &AnyGap::from(&punch);
        let f = ScaledOverlap::unscaled(gap);
        let mut polyhedral = PolyhedralMeans::of(&f).unwrap();
        let mut concave = Concave { polyhedral: &mut polyhedral, circles: false };
        for m in [Matrix2::new(0.7, 0.1, -0.2, 0.4), Matrix2::identity() * 0.3] {
            let e = Ellipse { c: Vector2::new(0.03, -0.08), m };
            let here = concave.at(e).unwrap();
            let hessian = concave.second_variation(&here);
            for k in 0..5 {
                const H: f64 = 1e-4;
                let log = |concave: &mut Concave, h: f64| {
                    // exp(S) to the second order is enough for second differences.
                    concave.at(e.moved(&Step::ith(k, h))).unwrap().log
                };
                let second = (log(&mut concave, H) + log(&mut concave, -H) - 2.0 * here.log) / (H * H);
                assert!((second - hessian[(k, k)]).abs() < 1e-5 * (1.0 + second.abs()), "{k} {second}");
            }
        }
    }
}
