//! Cones whose tip is not sharp: cut flat, or rounded by the parabola that meets the flank without a corner
//! (Ejike 1969, Maugis & Barquins 1983).
//!
//! Flat radius or end of the rounding b, slope t, contact a > b. With the unknown phi = arccos(b/a), c = cos phi,
//! sigma = sin phi:
//!
//! ```text
//! flat:     d = b t phi/c,                          P = E* t (b/c)^2 [phi + sigma c]
//! rounded:  d = b t [phi + c/(1 + sigma)]/c,        P = E* t (b/c)^2 [phi + sigma c + 2 c^3 (3 + c^2)/(3 (2 + (2 + c^2) sigma))]
//! ```
//!
//! The rounded forms are those with a - sqrt(a^2 - b^2) and 2 a^3 - (2 a^2 + b^2) sqrt(a^2 - b^2), multiplied out so that
//! nothing cancels for a >> b.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{ClosedForm, Hertz, Revolution, r_f};
use crate::error::{InputError, positive};
use crate::numeric::quadrature::adaptive;
use crate::numeric::scalar::root;
use crate::problem::EffectiveModulus;

/// A cone with its tip cut off: gap 0 to r = b, then slope t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatEndedCone {
    e_star: f64,
    flat: f64,
    slope: f64,
}

/// A cone with a parabolic tip: r^2/(2 R) to r = b = R t, then slope t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundedCone {
    modulus: EffectiveModulus,
    tip: f64,
    slope: f64,
}

impl FlatEndedCone {
    /// Radius b of the flat and slope t of the flank, both greater than zero.
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::FlatEndedCone};
    /// let cone = FlatEndedCone::new(EffectiveModulus::from_e_star(1.0)?, 1.0, 1.0)?;
    /// let contact = cone.at_depth(2.0943951023931955)?;
    /// assert!((contact.patch.semi_axes[0] - 2.0).abs() < 1e-14);
    /// assert!((contact.force / 5.9208410123552683 - 1.0).abs() < 1e-14);
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    ///
    /// # Errors
    /// Names the parameter that is not a finite number greater than zero.
    pub fn new(modulus: EffectiveModulus, flat_radius: f64, slope: f64) -> Result<Self, InputError> {
        let (flat, slope) = (positive("flat_radius", flat_radius)?, positive("slope", slope)?);
        Ok(Self { e_star: modulus.e_star(), flat, slope })
    }

    /// The contact at depth d > 0.
    ///
    /// # Errors
    /// When the depth is not a finite number greater than zero.
    pub fn at_depth(&self, depth: f64) -> Result<ClosedForm, InputError> {
        let target = positive("depth", depth)? / self.slope / self.flat;
        let phi = angle(|phi| phi - target * phi.cos());
        let a = (depth / (self.slope * phi)).max(self.flat);
        let force = self.e_star * self.slope * a * (a * cone_load(phi));
        // A load too small for the flank: phi is rounding, the punch is flat.
        let force = if phi > 1e-150 { force } else { 2.0 * self.e_star * self.flat * depth };
        Ok(self.solution(phi, a, force, depth))
    }

    /// The contact under the force P > 0.
    ///
    /// # Errors
    /// When the force is not a finite number greater than zero.
    pub fn at_force(&self, force: f64) -> Result<ClosedForm, InputError> {
        let p = positive("force", force)? / self.e_star / self.slope;
        let target = p / self.flat / self.flat;
        let phi = angle(|phi| cone_load(phi) - target * phi.cos().powi(2));
        let a = (p / cone_load(phi)).sqrt().max(self.flat);
        Ok(self.solution(phi, a, force, a * self.slope * phi))
    }

    fn solution(&self, phi: f64, a: f64, force: f64, depth: f64) -> ClosedForm {
        let shape = FlatContact { flat: self.flat, slope: self.slope, a, phi, depth };
        ClosedForm::disc(self.e_star, force, depth, a, shape)
    }
}

impl RoundedCone {
    /// Radius of curvature R of the tip and slope t of the flank, both greater than zero.
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::RoundedCone};
    /// let cone = RoundedCone::new(EffectiveModulus::from_e_star(1.0)?, 1.0, 1.0)?;
    /// let contact = cone.at_depth(2.6302934872554409)?;
    /// assert!((contact.force / 6.1952028336086712 - 1.0).abs() < 1e-14);
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    ///
    /// # Errors
    /// Names the parameter that is not a finite number greater than zero.
    pub fn new(modulus: EffectiveModulus, tip_radius: f64, slope: f64) -> Result<Self, InputError> {
        Ok(Self { modulus, tip: positive("tip_radius", tip_radius)?, slope: positive("slope", slope)? })
    }

    /// The contact at depth d > 0: Hertz' while a <= b.
    ///
    /// # Errors
    /// When the depth is not a finite number greater than zero.
    pub fn at_depth(&self, depth: f64) -> Result<ClosedForm, InputError> {
        let target = positive("depth", depth)? / self.slope / self.rim();
        if target <= 1.0 {
            return Hertz::circular(self.modulus, self.tip)?.at_depth(depth);
        }
        let phi = angle(|phi| rounded_depth(phi) - target * phi.cos());
        let a = depth / (self.slope * rounded_depth(phi));
        let force = self.modulus.e_star() * self.slope * a * (a * rounded_load(phi));
        Ok(self.solution(a, force, depth))
    }

    /// The contact under the force P > 0: Hertz' while a <= b.
    ///
    /// # Errors
    /// When the force is not a finite number greater than zero.
    pub fn at_force(&self, force: f64) -> Result<ClosedForm, InputError> {
        let p = positive("force", force)? / self.modulus.e_star() / self.slope;
        let target = p / self.rim() / self.rim();
        if target <= 4.0 / 3.0 {
            return Hertz::circular(self.modulus, self.tip)?.at_force(force);
        }
        let phi = angle(|phi| rounded_load(phi) - target * phi.cos().powi(2));
        let a = (p / rounded_load(phi)).sqrt();
        Ok(self.solution(a, force, a * self.slope * rounded_depth(phi)))
    }

    /// b.
    fn rim(&self) -> f64 {
        self.tip * self.slope
    }

    fn solution(&self, a: f64, force: f64, depth: f64) -> ClosedForm {
        let shape = RoundedContact { rim: self.rim(), slope: self.slope, a, depth };
        ClosedForm::disc(self.modulus.e_star(), force, depth, a, shape)
    }
}

/// The root of an equation that is not positive at phi = 0 and positive at pi/2.
fn angle(mismatch: impl FnMut(f64) -> f64) -> f64 {
    root(mismatch, 0.0, FRAC_PI_2).map_or(FRAC_PI_2, |found| found.at)
}

/// phi + sin phi cos phi: a cone's load with its tip missing.
fn cone_load(phi: f64) -> f64 {
    phi + phi.sin() * phi.cos()
}

/// phi + c/(1 + sigma).
fn rounded_depth(phi: f64) -> f64 {
    phi + phi.cos() / (1.0 + phi.sin())
}

/// The bracket of the rounded cone's load.
fn rounded_load(phi: f64) -> f64 {
    let (sigma, c) = phi.sin_cos();
    cone_load(phi) + 2.0 * c.powi(3) * (3.0 + c * c) / (3.0 * (2.0 + (2.0 + c * c) * sigma))
}

#[derive(Debug)]
struct FlatContact {
    flat: f64,
    slope: f64,
    a: f64,
    phi: f64,
    depth: f64,
}

impl FlatContact {
    /// sqrt(a^2 - b^2), which a alone does not tell when a is b to rounding.
    fn span(&self) -> f64 {
        self.a * self.phi.sin()
    }
}

impl Revolution for FlatContact {
    /// D' = t [arccos(b/s) + b/sqrt(s^2 - b^2)] beyond b, so that with m = max(r, b)
    /// p = (E* t/pi) [ int_m^a arccos(b/s)/sqrt(s^2 - r^2) ds + b int_m^a ds/sqrt((s^2 - b^2)(s^2 - r^2)) ];
    /// the second is 2 R_F of DLMF 19.29.4.
    fn pressure(&self, r: f64) -> f64 {
        let (b, a) = (self.flat, self.a);
        if r == b {
            return f64::INFINITY;
        }
        let inner = r.max(b);
        // sqrt(a^2 - r^2), through sqrt(a^2 - b^2).
        let to_rim =
            if r < b { ((b - r) * (b + r)).sqrt().hypot(self.span()) } else { ((a - r) * (a + r)).max(0.0).sqrt() };
        let reach = if r < b { self.span() } else { to_rim };
        if reach <= 0.0 {
            return 0.0;
        }
        // s^2 = m^2 + w^2.
        let first = |w: f64| {
            let s = inner.hypot(w);
            let (from_b, from_r) =
                if r < b { (w, w.hypot(((b - r) * (b + r)).sqrt())) } else { (w.hypot(((r - b) * (r + b)).sqrt()), w) };
            // ds = w dw/s; arccos(b/s) = atan2(sqrt(s^2 - b^2), b).
            from_b.atan2(b) / from_r * (w / s)
        };
        let corner = ((inner - r.min(b)) * (inner + r.min(b))).sqrt().min(0.5 * reach);
        let first = adaptive(first, 0.0, reach, &[corner], 1e-12).value;
        // Factors s - m, s + m, s - n, s + n at s = a (upper) and s = m (lower); that of s - m is zero below.
        let n = r.min(b);
        let a_minus_m = reach * reach / (a + inner);
        let upper = [a_minus_m, a + inner, a - n, a + n].map(f64::sqrt);
        let lower = [0.0, 2.0 * inner, inner - n, inner + n].map(f64::sqrt);
        // U_ij = (X_i X_j Y_k Y_l + Y_i Y_j X_k X_l)/(a - m), and Y_1 = 0.
        let u = |j: usize, k: usize, l: usize| (upper[0] * upper[j] * lower[k] * lower[l] / a_minus_m).powi(2);
        let second = 2.0 * b * r_f(u(1, 2, 3), u(2, 1, 3), u(3, 1, 2));
        self.slope / PI * (first + second)
    }

    /// [d^2 b + int_b^a (d - t s arccos(b/s))^2 ds]/P, s = b/cos v.
    fn energy_over_force(&self, force: f64) -> f64 {
        let (b, t, d) = (self.flat, self.slope, self.depth);
        let integrand = |v: f64| {
            let s = b / v.cos();
            (1.0 - t * s * v / d).powi(2) * s * v.tan()
        };
        // b/cos loses the digits of s near pi/2; there s itself is the variable.
        let middle = self.phi.min(1.0);
        let near = adaptive(integrand, 0.0, middle, &[], 1e-13).value;
        let outer = |s: f64| (1.0 - t * s * (((s - b) * (s + b)).sqrt()).atan2(b) / d).powi(2);
        let far = if self.phi > middle { adaptive(outer, b / middle.cos(), self.a, &[], 1e-13).value } else { 0.0 };
        d * (d / force * (b + near + far))
    }

    fn peak(&self) -> Option<f64> {
        None
    }
}

#[derive(Debug)]
struct RoundedContact {
    rim: f64,
    slope: f64,
    a: f64,
    depth: f64,
}

impl RoundedContact {
    /// D'(s)/s: 2/R to b, then 2 b/(R (s + sqrt(s^2 - b^2))) (b/s) + t arccos(b/s)/s.
    fn abel_slope(&self, s: f64) -> f64 {
        let (b, t) = (self.rim, self.slope);
        if s <= b {
            return 2.0 * t / b;
        }
        let root = ((s - b) * (s + b)).sqrt();
        (2.0 * b / (s + root) + root.atan2(b)) * t / s
    }

    /// D(s).
    fn abel(&self, s: f64) -> f64 {
        let (b, t) = (self.rim, self.slope);
        if s <= b {
            return t * s * (s / b);
        }
        let root = ((s - b) * (s + b)).sqrt();
        s * t * (b / (s + root) + root.atan2(b))
    }
}

impl Revolution for RoundedContact {
    fn pressure(&self, r: f64) -> f64 {
        let (b, a) = (self.rim, self.a);
        // int_0^W D'(s)/s dw, s^2 = r^2 + w^2; the tip's share is in closed form, the rest from w_b on.
        let width = ((a - r) * (a + r)).max(0.0).sqrt();
        let tip = ((b - r) * (b + r)).max(0.0).sqrt().min(width);
        // From w_b on D'/s falls like 1/s: logarithmic steps where W >> w_b, r.
        let scale = b.max(r);
        let (from, to) = ((tip / scale).asinh(), (width / scale).asinh());
        let flank = |u: f64| self.abel_slope(r.hypot(scale * u.sinh())) * scale * u.cosh();
        let flank = adaptive(flank, from, to, &[], 1e-12).value;
        (2.0 * self.slope * (tip / b) + flank) / PI
    }

    /// int_0^a q^2 ds/P.
    fn energy_over_force(&self, force: f64) -> f64 {
        let d = self.depth;
        let q2 = |s: f64| (1.0 - self.abel(s) / d).powi(2);
        let corners = [self.rim, (2.0 * self.rim).min(0.5 * (self.a + self.rim))];
        d * (d / force * adaptive(q2, 0.0, self.a, &corners, 1e-12).value)
    }

    fn peak(&self) -> Option<f64> {
        // D'(s)/s does not grow with s, so that the pressure falls from the centre out.
        Some(self.pressure(0.0))
    }
}
