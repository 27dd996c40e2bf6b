//! A true sphere (Segedin 1957, Sneddon 1965): the gap R - sqrt(R^2 - r^2), not its parabola.
//!
//! With the unknown y = artanh(a/R), which stays a good number when a comes to R:
//!
//! ```text
//! d/R = y tanh y,   a = R tanh y,   P = E* R^2 [(1 + x^2) y - x],  x = tanh y,   D(s) = s artanh(s/R)
//! ```
//!
//! The surface is still taken as a half-space: that the strain is small is the user's assumption.

use std::f64::consts::PI;

use super::{ClosedForm, Revolution};
use crate::error::{InputError, positive};
use crate::numeric::quadrature::adaptive;
use crate::numeric::scalar::{maximum, root};
use crate::problem::EffectiveModulus;

/// A rigid sphere, or two bodies whose gap is that of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    e_star: f64,
    radius: f64,
}

impl Sphere {
    /// A sphere of this radius.
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::Sphere};
    /// let sphere = Sphere::new(EffectiveModulus::from_e_star(1.0)?, 1.0)?;
    /// let contact = sphere.at_depth(0.27465307216702742)?;
    /// assert!((contact.patch.semi_axes[0] - 0.5).abs() < 1e-14);
    /// assert!((contact.force / 0.18663268041756856 - 1.0).abs() < 1e-13);
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    ///
    /// # Errors
    /// When the radius is not a finite number greater than zero.
    pub fn new(modulus: EffectiveModulus, radius: f64) -> Result<Self, InputError> {
        Ok(Self { e_star: modulus.e_star(), radius: positive("radius", radius)? })
    }

    /// The contact at depth d > 0. Beyond a few radii the contact is the whole sphere to rounding.
    ///
    /// # Errors
    /// When the depth is not a finite number greater than zero.
    pub fn at_depth(&self, depth: f64) -> Result<ClosedForm, InputError> {
        let target = positive("depth", depth)? / self.radius;
        // y tanh y <= y^2 and <= y; tanh y >= y/(1 + y).
        let (low, high) = (target.max(target.sqrt()), target + target.sqrt());
        let y = root(|y| y * y.tanh() - target, low, high).map_or(low, |found| found.at);
        Ok(self.solution(y, self.e_star * self.force_over_modulus(y), depth))
    }

    /// The contact under the force P > 0.
    ///
    /// # Errors
    /// When the force is not a finite number greater than zero.
    pub fn at_force(&self, force_wanted: f64) -> Result<ClosedForm, InputError> {
        let target = positive("force", force_wanted)? / self.e_star;
        let per_area = target / self.radius / self.radius;
        // P/(E* R^2) lies between 4/3 y^3 / (1 + y)^2 and both 4/3 y^3 and 2 y.
        let low = ((0.75 * target).cbrt() / self.radius.cbrt().powi(2)).max(0.5 * per_area);
        let mut high = 2.0 * low;
        while self.force_over_modulus(high) < target {
            high *= 2.0;
        }
        let y = root(|y| self.force_over_modulus(y) - target, 0.5 * low, high).map_or(low, |found| found.at);
        Ok(self.solution(y, force_wanted, self.radius * (y * y.tanh())))
    }

    /// P/E*: y^3, which it goes with at small y, may be below the range of numbers.
    fn force_over_modulus(&self, y: f64) -> f64 {
        self.radius * y * (self.radius * force_over_y(y))
    }

    fn solution(&self, y: f64, force: f64, depth: f64) -> ClosedForm {
        let a = self.radius * y.tanh();
        ClosedForm::disc(self.e_star, force, depth, a, Contact { radius: self.radius, y })
    }
}

/// P/(E* R^2 y) = x^2 + (y - x)/y, x = tanh y; y = artanh x is x + x^3/3 + x^5/5 + ..., where the difference would lose digits.
fn force_over_y(y: f64) -> f64 {
    let x = y.tanh();
    if x > 0.3 {
        return x * x + (y - x) / y;
    }
    let x2 = x * x;
    let series = (1..=16).rev().fold(0.0, |sum, k| sum * x2 + 1.0 / f64::from(2 * k + 1));
    x2 * (1.0 + x / y * series)
}

#[derive(Debug)]
struct Contact {
    radius: f64,
    y: f64,
}

impl Revolution for Contact {
    /// With R = 1, s^2 = r^2 + w^2 and W^2 = a^2 - r^2: D'(s)/s = artanh(s)/s + 1/(1 - s^2), so that
    /// p = (E*/pi) [int_0^W artanh(s)/s dw + artanh(W/C)/C], C^2 = 1 - r^2.
    fn pressure(&self, r: f64) -> f64 {
        let (x, y) = (r / self.radius, self.y);
        let a = y.tanh();
        let width = ((a - x) * (a + x)).max(0.0).sqrt();
        let c = ((1.0 - x) * (1.0 + x)).max(0.0).sqrt();
        let ratio = width / c;
        let second = if ratio == 0.0 || ratio.is_nan() {
            0.0
        } else if ratio < 0.9 {
            ratio.atanh() / c
        } else {
            // artanh(W/C) = ln((C + W)/sqrt(1 - a^2)) and 1 - a^2 = sech^2 y.
            ((c + width).ln() + y + (0.5 * (1.0 + (-2.0 * y).exp())).ln()) / c
        };
        let first = |w: f64| {
            let s = x.hypot(w);
            if s > 0.0 { s.atanh().min(y) / s } else { 1.0 }
        };
        (adaptive(first, 0.0, width, &[], 1e-13).value + second) / PI
    }

    /// int_0^a (d - D)^2 ds/P with s = R tanh v = R tanh(y t): d^2 R y int_0^1 (1 - v tanh v/(y tanh y))^2 sech^2 v dt/P.
    fn energy_over_force(&self, _: f64) -> f64 {
        let (y, x) = (self.y, self.y.tanh());
        let integrand = |t: f64| ((1.0 - t * (y * t).tanh() / x) / (y * t).cosh()).powi(2);
        // sech^2 v is below 1e-30 from 36 on.
        let integral = adaptive(integrand, 0.0, (36.0 / y).min(1.0), &[], 1e-13).value;
        let depth = y * x;
        self.radius * depth * (depth / force_over_y(y) * integral)
    }

    fn peak(&self) -> Option<f64> {
        // At the centre until a is near R, where it moves to the rim.
        Some(maximum(|r| self.pressure(r), 0.0, self.radius * self.y.tanh(), 32).value)
    }
}
