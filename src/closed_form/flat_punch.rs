//! Flat rigid punches: disc (Boussinesq, Galin) and ellipse (Green & Sneddon 1950), upright or tilted.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Rotation2, Vector2};

use super::{ClosedForm, Distribution, Ellipse, ROUNDING, r_d, r_f};
use crate::error::{InputError, finite, positive};
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// A flat punch of elliptic plan-form, with sharp edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatPunch {
    e_star: f64,
    patch: Ellipse,
}

/// Stiffnesses of an ellipse about its own axes, k = b/a:
///
/// ```text
/// P = pi E* a d/R_F(0, k^2, 1),   int p x = pi E* a^3 tilt_x/R_D(0, k^2, 1),   int p y = pi E* a^3 tilt_y/R_D(0, 1, k^2)
/// ```
///
/// for f = d + tilt_x x + tilt_y y. Disc: 2 E* a and 4/3 E* a^3. The last two follow from the first derivative of
/// the potential of Hertz' pressure, whose density is x (1 - rho^2)^(-1/2).
fn principal_stiffness(e_star: f64, [a, b]: [f64; 2]) -> [f64; 3] {
    let k = b / a;
    let k2 = k * k;
    let stiff = PI * e_star * a;
    [stiff / r_f(0.0, k2, 1.0), stiff * a * a / r_d(0.0, k2, 1.0), stiff * a * a / r_d(0.0, 1.0, k2)]
}

/// The symmetric matrix that takes (d, tilt_x, tilt_y) of f = d + tilt_x x + tilt_y y to (P, int p x, int p y) for a flat
/// punch of this plan-form: E* in units of stress, moments about the origin.
///
/// ```
/// use contact_patch::closed_form::{Ellipse, tilt_stiffness};
/// let k = tilt_stiffness(1.0, &Ellipse::disc(3.0));
/// assert!((k[(0, 0)] - 2.0 * 3.0).abs() < 1e-13);
/// assert!((k[(1, 1)] - 4.0 / 3.0 * 27.0).abs() < 1e-12);
/// ```
#[must_use]
pub fn tilt_stiffness(e_star: f64, patch: &Ellipse) -> Matrix3<f64> {
    let [s, su, sv] = principal_stiffness(e_star, patch.semi_axes);
    let ([cx, cy], (sin, cos)) = (patch.centre, patch.orientation.sin_cos());
    let xx = su * cos * cos + sv * sin * sin;
    let xy = (su - sv) * sin * cos;
    let yy = su * sin * sin + sv * cos * cos;
    Matrix3::new(
        s,
        s * cx,
        s * cy,
        s * cx,
        xx + s * cx * cx,
        xy + s * cx * cy,
        s * cy,
        xy + s * cx * cy,
        yy + s * cy * cy,
    )
}

impl FlatPunch {
    /// A flat disc about the origin.
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::FlatPunch};
    /// let punch = FlatPunch::disc(EffectiveModulus::from_e_star(1e11)?, 1e-3)?;
    /// assert!((punch.at_depth(1e-6)?.force - 2e11 * 1e-3 * 1e-6).abs() < 1e-8);
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    ///
    /// # Errors
    /// When the radius is not a finite number greater than zero.
    pub fn disc(modulus: EffectiveModulus, radius: f64) -> Result<Self, InputError> {
        Ok(Self { e_star: modulus.e_star(), patch: Ellipse::disc(positive("disc", radius)?) })
    }

    /// A flat ellipse about the origin with these semi-axes along x and y, in any order.
    ///
    /// # Errors
    /// Names the semi-axis that is not a finite number greater than zero.
    pub fn ellipse(modulus: EffectiveModulus, [along_x, along_y]: [f64; 2]) -> Result<Self, InputError> {
        positive("ellipse[0]", along_x)?;
        positive("ellipse[1]", along_y)?;
        let orientation = if along_x >= along_y { 0.0 } else { 0.5 * PI };
        let semi_axes = [along_x.max(along_y), along_x.min(along_y)];
        Ok(Self { e_star: modulus.e_star(), patch: Ellipse { centre: [0.0; 2], semi_axes, orientation } })
    }

    /// The contact at depth d > 0: P = pi E* a d/R_F(0, k^2, 1), p = P/(2 pi a b) (1 - rho^2)^(-1/2).
    ///
    /// # Errors
    /// When the depth is not a finite number greater than zero.
    pub fn at_depth(&self, depth: f64) -> Result<ClosedForm, InputError> {
        Ok(self.solution(positive("depth", depth)?, [0.0; 2]))
    }

    /// The contact under the force P > 0 through the centre.
    ///
    /// # Errors
    /// When the force is not a finite number greater than zero.
    pub fn at_force(&self, force: f64) -> Result<ClosedForm, InputError> {
        let stiffness = principal_stiffness(self.e_star, self.patch.semi_axes)[0];
        Ok(self.solution(positive("force", force)? / stiffness, [0.0; 2]))
    }

    /// The contact at depth d with a tilt, f = d + tilt_x x + tilt_y y, as long as the whole base touches.
    ///
    /// # Errors
    /// `NotApplicable` when a number is not finite or the depth not positive; `NoClosedForm` when a part of the base
    /// would have to pull.
    pub fn at_tilted_depth(&self, depth: f64, tilt: [f64; 2]) -> Result<ClosedForm, Unsolved> {
        let refuse = |e: InputError| Unsolved::new(Verdict::NotApplicable, e.to_string());
        positive("depth", depth).map_err(refuse)?;
        finite("tilt[0]", tilt[0]).map_err(refuse)?;
        finite("tilt[1]", tilt[1]).map_err(refuse)?;
        let solution = self.solution(depth, tilt);
        let Distribution::Punch { c, .. } = &solution.pressure else { return Ok(solution) };
        let [a, b] = self.patch.semi_axes;
        let share = (a * c[1]).hypot(b * c[2]) / c[0];
        if share > 1.0 {
            let reason = format!("the base lifts on one side: the tilt takes {share:.4} of the pressure of the depth");
            return Err(Unsolved::new(Verdict::NoClosedForm, reason));
        }
        Ok(solution)
    }

    /// The contact under the force P > 0 whose line of action meets the surface at `through`, free to tilt: full contact
    /// while x^2/a^2 + y^2/b^2 <= 1/9 there.
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::FlatPunch};
    /// let punch = FlatPunch::disc(EffectiveModulus::from_e_star(1.0)?, 1.0)?;
    /// let tilted = punch.at_force_through(1.0, [0.2, 0.0])?;
    /// assert!((tilted.tilt[0] - 0.15).abs() < 1e-14 && (tilted.line_of_action()[0] - 0.2).abs() < 1e-14);
    /// assert!(punch.at_force_through(1.0, [0.34, 0.0]).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`FlatPunch::at_tilted_depth`].
    pub fn at_force_through(&self, force: f64, through: [f64; 2]) -> Result<ClosedForm, Unsolved> {
        let [s, su, sv] = principal_stiffness(self.e_star, self.patch.semi_axes);
        let [u, v] = self.patch.local(through);
        let tilt = Rotation2::new(self.patch.orientation) * Vector2::new(force * u / su, force * v / sv);
        self.at_tilted_depth(force / s, tilt.into())
    }

    fn solution(&self, depth: f64, tilt: [f64; 2]) -> ClosedForm {
        let ([a, b], stiffness) = (self.patch.semi_axes, principal_stiffness(self.e_star, self.patch.semi_axes));
        let [s, su, sv] = stiffness;
        let t = Rotation2::new(-self.patch.orientation) * Vector2::from(tilt);
        // P = 2 pi a b c0, int p u = (2 pi/3) a^3 b c1, int p v = (2 pi/3) a b^3 c2.
        let twice_area = 2.0 * PI * a * b;
        // One length after the other: their product may be beyond the range of numbers.
        let slope = |stiffness: f64, tilt: f64, length: f64| 3.0 * (stiffness / twice_area) * tilt / length / length;
        let c = [s * depth / twice_area, slope(su, t.x, a), slope(sv, t.y, b)];
        let energy = 0.5 * (s * depth * depth + su * t.x * t.x + sv * t.y * t.y);
        ClosedForm {
            force: s * depth,
            depth,
            tilt,
            stiffness: s,
            error: ROUNDING,
            patch: self.patch,
            e_star: self.e_star,
            pressure: Distribution::Punch { c, energy },
        }
    }
}
