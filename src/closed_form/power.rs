//! Power laws g = c r^n with any real exponent n > 0 (Galin 1946, Sneddon 1965), and Love's cone (1939), n = 1.
//!
//! ```text
//! d = c k_n a^n,   k_n = sqrt(pi) Gamma(n/2 + 1)/Gamma((n + 1)/2),   P = 2 E* n/(n + 1) a d,   U = n/(2 n + 1) P d,
//! p(r) = (E*/pi) c n k_n int_r^a s^(n-1)/sqrt(s^2 - r^2) ds
//! ```

use std::f64::consts::PI;

use super::{ClosedForm, Revolution};
use crate::error::{InputError, positive};
use crate::numeric::quadrature::adaptive;
use crate::numeric::scalar::maximum;
use crate::problem::EffectiveModulus;

/// The gap c r^n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Power {
    e_star: f64,
    coefficient: f64,
    exponent: f64,
    /// k_n.
    k: f64,
}

impl Power {
    /// c > 0 (length^(1-n)) and n > 0.
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::Power};
    /// let quartic = Power::new(EffectiveModulus::from_e_star(1.0)?, 1.0, 4.0)?.at_depth(1.0)?;
    /// assert!((quartic.force / 1.2520676640586299 - 1.0).abs() < 1e-14);
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    ///
    /// # Errors
    /// Names the parameter that is not a finite number greater than zero.
    pub fn new(modulus: EffectiveModulus, coefficient: f64, exponent: f64) -> Result<Self, InputError> {
        positive("coefficient", coefficient)?;
        positive("exponent", exponent)?;
        let k = PI.sqrt() * half_step(0.5 * (exponent + 1.0));
        Ok(Self { e_star: modulus.e_star(), coefficient, exponent, k })
    }

    /// The contact at depth d > 0: a = (d/(c k_n))^(1/n).
    ///
    /// # Errors
    /// When the depth is not a finite number greater than zero, or the contact radius cannot be represented.
    pub fn at_depth(&self, depth: f64) -> Result<ClosedForm, InputError> {
        let Self { e_star, coefficient: c, exponent: n, k } = *self;
        let a = (positive("depth", depth)? / (c * k)).powf(1.0 / n);
        if !(a.is_normal() && (a * depth).is_normal()) {
            return Err(InputError::new("depth", depth, "a depth whose contact radius can be represented"));
        }
        let force = 2.0 * e_star * (n / (n + 1.0)) * a * depth;
        Ok(ClosedForm::disc(e_star, force, depth, a, Contact { a, depth, exponent: n }))
    }

    /// The contact under the force P > 0: a = (P (n + 1)/(2 E* n c k_n))^(1/(n+1)).
    ///
    /// # Errors
    /// When the force is not a finite number greater than zero, or the contact radius cannot be represented.
    pub fn at_force(&self, force: f64) -> Result<ClosedForm, InputError> {
        let Self { e_star, coefficient: c, exponent: n, k } = *self;
        // a d from the force.
        let moment = positive("force", force)? / (2.0 * e_star) * ((n + 1.0) / n);
        let a = (moment / (c * k)).powf(1.0 / (n + 1.0));
        let depth = moment / a;
        if !(a.is_normal() && depth.is_normal()) {
            return Err(InputError::new("force", force, "a force whose contact radius can be represented"));
        }
        Ok(ClosedForm::disc(e_star, force, depth, a, Contact { a, depth, exponent: n }))
    }
}

/// The gap r tan(inclination).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    law: Power,
}

impl Cone {
    /// A cone whose flank rises by `slope` > 0 a unit of radius: d = (pi/2) slope a, P = E* a d,
    /// p = (E*/2) slope arcosh(a/r).
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::Cone};
    /// let cone = Cone::with_slope(EffectiveModulus::from_e_star(1.0)?, 1.0)?.at_depth(1.0)?;
    /// assert!((cone.force - 2.0 / std::f64::consts::PI).abs() < 1e-15);
    /// assert!(cone.max_pressure().is_none());
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    ///
    /// # Errors
    /// When the slope is not a finite number greater than zero.
    pub fn with_slope(modulus: EffectiveModulus, slope: f64) -> Result<Self, InputError> {
        positive("slope", slope)?;
        Ok(Self { law: Power { e_star: modulus.e_star(), coefficient: slope, exponent: 1.0, k: 0.5 * PI } })
    }

    /// The contact at depth d > 0.
    ///
    /// # Errors
    /// As [`Power::at_depth`].
    pub fn at_depth(&self, depth: f64) -> Result<ClosedForm, InputError> {
        self.law.at_depth(depth)
    }

    /// The contact under the force P > 0.
    ///
    /// # Errors
    /// As [`Power::at_force`].
    pub fn at_force(&self, force: f64) -> Result<ClosedForm, InputError> {
        self.law.at_force(force)
    }
}

/// Gamma(x + 1/2)/Gamma(x), x > 0: the ratio steps by x/(x + 1/2), and beyond 40 eight terms of its series in 1/x
/// (DLMF 5.11.13) leave less than rounding. No gamma function, so no overflow.
fn half_step(x: f64) -> f64 {
    let (mut x, mut down) = (x, 1.0);
    while x < 40.0 {
        down *= x / (x + 0.5);
        x += 1.0;
    }
    const SERIES: [f64; 8] = [
        1.0,
        -1.0 / 8.0,
        1.0 / 128.0,
        5.0 / 1024.0,
        -21.0 / 32_768.0,
        -399.0 / 262_144.0,
        869.0 / 4_194_304.0,
        39_325.0 / 33_554_432.0,
    ];
    down * x.sqrt() * SERIES.iter().rev().fold(0.0, |sum, term| sum / x + term)
}

#[derive(Debug)]
struct Contact {
    a: f64,
    depth: f64,
    exponent: f64,
}

impl Revolution for Contact {
    fn pressure(&self, r: f64) -> f64 {
        let Self { a, depth, exponent: n } = *self;
        // With s = a sigma: p = n d/(pi a) int_x^1 sigma^(n-1)/sqrt(sigma^2 - x^2) dsigma.
        let x = r / a;
        let edge = ((1.0 - x) * (1.0 + x)).max(0.0).sqrt();
        let integral = if n == 2.0 {
            edge
        } else if x == 0.0 {
            if n > 1.0 { 1.0 / (n - 1.0) } else { f64::INFINITY }
        } else {
            // sigma = x cosh u takes the root away.
            let end = (edge / x).asinh();
            if n == 1.0 { end } else { adaptive(|u| (x * u.cosh()).powf(n - 1.0), 0.0, end, &[], 1e-13).value }
        };
        n * depth / (PI * a) * integral
    }

    /// d/(2 + 1/k), k the exponent.
    fn energy_over_force(&self, _: f64) -> f64 {
        let Self { depth, exponent: n, .. } = *self;
        n / (2.0 * n + 1.0) * depth
    }

    fn peak(&self) -> Option<f64> {
        match self.exponent {
            n if n <= 1.0 => None,
            n if n <= 2.0 => Some(self.pressure(0.0)),
            // Blunter than a paraboloid: the peak leaves the centre for the rim.
            _ => Some(maximum(|r| self.pressure(r), 0.0, self.a, 32).value),
        }
    }
}
