//! The integrals over the angle of a fan of rays: P(A) itself, its errors, and where finer rules are wanted.

use super::radial::RadialRule;
use super::ray_fan::{Ray, RayFan};

impl RayFan<'_> {
    /// The sum over the rays with the weights of the fine rule.
    pub fn sum(&self, value: impl Fn(&Ray) -> f64) -> f64 {
        self.rays.iter().map(|r| r.node.fine * value(r)).sum()
    }

    /// int G / L, which is P/(2E*) of the present boundary (equation 12).
    pub fn quotient(&self) -> f64 {
        self.sum(|r| r.along.g) / self.sum(|r| r.a)
    }

    /// Centroid of the region, relative to the centre, and its area.
    pub fn centroid_and_area(&self) -> ([f64; 2], f64) {
        let (mut moment, mut twice) = ([0.0; 2], 0.0);
        for r in &self.rays {
            let aa = r.node.fine * r.a * r.a;
            twice += aa;
            moment[0] += aa * r.a * r.direction[0] / 3.0;
            moment[1] += aa * r.a * r.direction[1] / 3.0;
        }
        // Several turns that leave the region as it is leave its centroid at the centre.
        let repeated = self.sectors.turns() > 1;
        (moment.map(|m| if repeated { 0.0 } else { 2.0 * m / twice }), 0.5 * twice)
    }

    /// Relative error of the quotient: that over the angles, that along the rays.
    ///
    /// The sum that matters is that of G - D a: at the stationary boundary it is smoother than the boundary.
    pub fn errors(&mut self, quotient: f64) -> [f64; 2] {
        let scale = quotient.abs() * self.sum(|r| r.a);
        for (value, r) in self.values.iter_mut().zip(&self.rays) {
            *value = r.along.g - quotient * r.a;
        }
        let angular = self.sectors.error(&self.nodes, &self.values) / scale;
        let radial = self.finer_rule().filter(|_| !self.overlap.has_planes()).map_or(f64::NAN, |finer| {
            self.sum(|r| self.line(r).g(self.overlap, self.f0, &r.position, finer) - r.along.g).abs() / scale
        });
        [angular, if radial.is_nan() { f64::EPSILON } else { radial }]
    }

    /// Makes the rule finer where `errors` (just computed) say so. False when that is not possible.
    pub fn refine(&mut self, errors: [f64; 2], tolerance: f64, quotient: f64, most_rays: usize) -> bool {
        // Another ten sweeps with twice the rays, or rays twice as fine.
        let sweep: usize = self.rays.iter().map(|ray| self.price(ray)).sum();
        if self.spent.get() + 20 * sweep > self.budget {
            return false;
        }
        let mut finer = false;
        if errors[1] > 0.5 * tolerance && RadialRule::can_refine(self.rule_level) {
            self.rule_level += 1;
            finer = true;
        }
        if errors[0] > 0.5 * tolerance {
            let allowed = 0.5 * tolerance * quotient.abs() * self.sum(|r| r.a);
            if self.sectors.refine(&self.nodes, &self.values, allowed, most_rays) {
                let outline = self.outline();
                self.lay(&outline);
                finer = true;
            }
        }
        finer
    }
}
