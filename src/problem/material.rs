//! Materials: one or two bodies, rigid or elastic, and the effective modulus they make.

use crate::error::{InputError, positive};

/// One of the two bodies: rigid, or linear elastic and isotropic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// (1 - nu^2)/E, the share of this body in 1/E*; zero for a rigid one.
    compliance: f64,
}

impl Body {
    /// A body that does not deform.
    pub const RIGID: Self = Self { compliance: 0.0 };

    /// An elastic body from Young's modulus E > 0 and Poisson's ratio nu in (-1, 0.5].
    ///
    /// # Errors
    /// Names `youngs_modulus` or `poissons_ratio` when out of range.
    pub fn elastic(youngs_modulus: f64, poissons_ratio: f64) -> Result<Self, InputError> {
        let nu = checked_ratio(poissons_ratio)?;
        let e = positive("youngs_modulus", youngs_modulus)?;
        Self::with_compliance("youngs_modulus", e, (1.0 - nu) * (1.0 + nu) / e)
    }

    /// An elastic body from the shear modulus mu > 0 and Poisson's ratio nu in (-1, 0.5]:
    /// (1 - nu^2)/E = (1 - nu)/(2 mu).
    ///
    /// # Errors
    /// Names `shear_modulus` or `poissons_ratio` when out of range.
    pub fn elastic_in_shear(shear_modulus: f64, poissons_ratio: f64) -> Result<Self, InputError> {
        let nu = checked_ratio(poissons_ratio)?;
        let mu = positive("shear_modulus", shear_modulus)?;
        Self::with_compliance("shear_modulus", mu, (1.0 - nu) / 2.0 / mu)
    }

    /// Whether the body does not deform.
    #[must_use]
    pub fn is_rigid(self) -> bool {
        self.compliance == 0.0
    }

    fn with_compliance(path: &str, modulus: f64, compliance: f64) -> Result<Self, InputError> {
        if compliance.is_normal() {
            Ok(Self { compliance })
        } else {
            Err(InputError::new(path, modulus, "a modulus whose reciprocal can be represented (1e-300 to 1e300)"))
        }
    }
}

fn checked_ratio(nu: f64) -> Result<f64, InputError> {
    if nu > -1.0 && nu <= 0.5 {
        Ok(nu)
    } else {
        Err(InputError::new("poissons_ratio", nu, "a number greater than -1 and at most 0.5"))
    }
}

/// E*, the effective (contact, plane-strain) modulus of a pair, in units of stress.
///
/// It cannot be made from a bare number that might be Young's modulus: use [`EffectiveModulus::of_pair`],
/// or say that the number is E* with [`EffectiveModulus::from_e_star`].
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct EffectiveModulus(f64);

impl EffectiveModulus {
    /// 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; a rigid body adds nothing.
    ///
    /// ```
    /// use contact_patch::{Body, EffectiveModulus};
    /// let steel = Body::elastic(2.1e11, 0.3)?;
    /// let modulus = EffectiveModulus::of_pair(steel, Body::RIGID)?;
    /// assert!((modulus.e_star() - 2.1e11 / 0.91).abs() < 1.0);
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    ///
    /// # Errors
    /// When both bodies are rigid: nothing deforms, so there is no contact problem.
    pub fn of_pair(a: Body, b: Body) -> Result<Self, InputError> {
        let compliance = a.compliance + b.compliance;
        if compliance > 0.0 && compliance.is_finite() {
            Ok(Self(1.0 / compliance))
        } else {
            Err(InputError::new("bodies", "two rigid bodies", "at least one of the two bodies is elastic"))
        }
    }

    /// A number that is E* already, greater than zero.
    ///
    /// # Errors
    /// When it is not a finite number greater than zero, or so small that it has lost digits.
    pub fn from_e_star(e_star: f64) -> Result<Self, InputError> {
        let e_star = positive("effective_modulus", e_star)?;
        if e_star < f64::MIN_POSITIVE {
            let allowed = "a number of at least 2.3e-308, which has all its digits";
            return Err(InputError::new("effective_modulus", e_star, allowed));
        }
        Ok(Self(e_star))
    }

    /// E*, in units of stress.
    #[must_use]
    pub fn e_star(self) -> f64 {
        self.0
    }
}
