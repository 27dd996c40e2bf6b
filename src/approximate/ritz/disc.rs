//! The quadrature over an ellipse: means of the overlap and of the slopes under the flat-punch pressure.

use nalgebra::{Matrix2, Vector2};

use super::coordinates::{Ellipse, Step, mean_and_share};
use crate::approximate::fabrikant::{DIFFERENCE_STEP, QuadratureNode, RadialRule, ScaledOverlap, Sectors};
use crate::gap::Gap;

/// Evaluations of the gap after which the search for the maximum is cut short.
const MOST_EVALUATIONS: usize = 4_000_000;

/// What finding the kinks along a ray counts for.
const RAY: usize = 40;

/// Rays between two looks at the clock.
const CHECKED: usize = 16;

/// Means of the overlap and of the gradient of the gap under the flat-punch pressure, in the ellipse's own coordinates.
pub(super) struct Means {
    pub f: f64,
    pub slope: Vector2<f64>,
    pub moment: Matrix2<f64>,
}

/// The quadrature, with its buffers.
pub(super) struct Disc<'a> {
    pub overlap: &'a ScaledOverlap,
    pub sectors: Sectors,
    pub rule_level: usize,
    pub nodes: Vec<QuadratureNode>,
    pub values: Vec<f64>,
    directions: Vec<f64>,
    kinks: Vec<f64>,
    /// Evaluations of the gap so far.
    pub work: usize,
    /// Those of the last means.
    last: usize,
    /// Whether the sectors follow the ridges of the gap.
    pub follow_ridges: bool,
    /// Whether the rays are split at the kinks of the gap.
    pub follow_kinks: bool,
}

impl<'a> Disc<'a> {
    pub fn new(overlap: &'a ScaledOverlap, sectors: Sectors, rule_level: usize) -> Self {
        let (nodes, values, directions, kinks) = Default::default();
        Self {
            overlap,
            sectors,
            rule_level,
            nodes,
            values,
            directions,
            kinks,
            work: 0,
            last: 0,
            follow_ridges: true,
            follow_kinks: true,
        }
    }

    pub fn lay(&mut self, e: &Ellipse) {
        if !self.follow_ridges {
            if self.nodes.is_empty() {
                self.sectors.nodes(&mut self.nodes);
                self.values.resize(self.nodes.len(), 0.0);
            }
            return;
        }
        self.directions.clear();
        self.overlap.gap.kink_directions(e.c.into(), &mut self.directions);
        if let Some(inverse) = e.m.try_inverse() {
            for angle in &mut self.directions {
                let (sin, cos) = angle.sin_cos();
                let back = inverse * Vector2::new(cos, sin);
                *angle = back.y.atan2(back.x);
            }
        }
        self.sectors.move_to(&self.directions);
        self.sectors.nodes(&mut self.nodes);
        self.values.resize(self.nodes.len(), 0.0);
    }

    pub fn means(&mut self, e: &Ellipse, rule: &RadialRule) -> Means {
        self.lay(e);
        let (has_gradient, before) = (self.overlap.has_gradient(), self.work);
        let f0 = self.overlap.at(e.c.into());
        let mut means = Means { f: 0.0, slope: Vector2::zeros(), moment: Matrix2::zeros() };
        for (k, (node, value)) in self.nodes.iter().zip(&mut self.values).enumerate() {
            if k % CHECKED == CHECKED - 1 && self.overlap.deadline.has_passed() {
                // No means: the caller checks the deadline, too.
                means.f = f64::NAN;
                break;
            }
            let (sin, cos) = node.angle.sin_cos();
            let direction = Vector2::new(cos, sin);
            let ray = e.m * direction;
            let length = ray.norm();
            self.kinks.clear();
            if self.follow_kinks {
                self.overlap.gap.ray_kinks(e.c.into(), (ray / length).into(), &mut self.kinks);
                self.kinks.iter_mut().for_each(|r| *r /= length);
                self.kinks.sort_unstable_by(f64::total_cmp);
            }
            let pieces = 1 + self.kinks.partition_point(|&k| k < 1.0);
            self.work += RAY + pieces * rule.whole.len() * if has_gradient { 1 } else { 5 };
            let (mut f, mut slope, mut moment) = (0.0, Vector2::zeros(), Vector2::zeros());
            rule.visit(&self.kinks, 1.0, |node| {
                let x = e.c + ray * node.sin;
                let g = if has_gradient {
                    e.m.tr_mul(&Vector2::from(self.overlap.slope(x.into(), 0.0)))
                } else {
                    let across = |u: Vector2<f64>| {
                        let h = e.m * u * DIFFERENCE_STEP;
                        (self.overlap.at((x - h).into()) - self.overlap.at((x + h).into())) / (2.0 * DIFFERENCE_STEP)
                    };
                    Vector2::new(across(Vector2::x()), across(Vector2::y()))
                };
                // int f sin t dt = f(c) - int (dg/dr) cos^2 t dt.
                f += if has_gradient {
                    -node.weight * node.cos * node.cos * g.dot(&direction)
                } else {
                    node.weight * node.sin * self.overlap.at(x.into())
                };
                slope += g * (node.weight * node.sin);
                moment += g * (node.weight * node.sin * node.sin);
            });
            *value = if has_gradient { f0 + f } else { f };
            let share = node.fine / std::f64::consts::TAU;
            means.f += share * *value;
            means.slope += slope * share;
            means.moment += moment * direction.transpose() * share;
        }
        self.last = self.work - before;
        // What symmetry makes zero comes out as rounding; a centre moved by rounding would lose the symmetry of the rays.
        let noise = 1e-14 * (means.f.abs() + means.moment.amax());
        means.slope.apply(|s| *s = if s.abs() < noise { 0.0 } else { *s });
        means
    }

    /// Whether the gap was evaluated more often than any smooth one takes: the caps beyond a kink that the gap does not name are so thin
    /// that no rule converges; or whether the time is used up.
    pub fn out_of_budget(&self) -> bool {
        self.work > MOST_EVALUATIONS || self.overlap.deadline.has_passed()
    }

    /// Whether there is room for another search with rays twice as many or twice as fine.
    pub fn may_refine(&self) -> bool {
        self.work + 20 * self.last <= MOST_EVALUATIONS
    }

    pub fn rule(&self) -> &'static RadialRule {
        RadialRule::level(self.rule_level).unwrap_or_else(RadialRule::finest)
    }

    /// Force (in units of 2E*), its logarithmic gradient, and the means.
    pub fn force_and_gradient(&mut self, e: &Ellipse, circles: bool) -> Option<(f64, Step, Means)> {
        let means = self.means(e, self.rule());
        let (force, step) = logarithmic_slope(e, &means, circles)?;
        Some((force, step, means))
    }
}

/// P (in units of 2E*) and the gradient of log P in the ellipse's own coordinates; `None` without load.
pub(super) fn logarithmic_slope(e: &Ellipse, means: &Means, circles: bool) -> Option<(f64, Step)> {
    let ([a, b], _, before) = e.axes();
    let (agm, share) = mean_and_share(a, b);
    let force = agm * means.f;
    if !(force > 0.0 && force.is_finite() && means.moment.iter().all(|m| m.is_finite())) {
        return None;
    }
    // d log agm = share along the long axis, 1 - share along the short one.
    let stiffer = Matrix2::identity() * (1.0 - share) + before * before.transpose() * (2.0 * share - 1.0);
    let s = stiffer - (means.moment + means.moment.transpose()) / (2.0 * means.f);
    let v = -means.slope / means.f;
    let step = if circles {
        let scale = 0.5 * s.trace();
        Step::new(v.x, v.y, scale, scale, 0.0)
    } else {
        Step::new(v.x, v.y, s[(0, 0)], s[(1, 1)], std::f64::consts::SQRT_2 * s[(0, 1)])
    };
    Some((force, step))
}
