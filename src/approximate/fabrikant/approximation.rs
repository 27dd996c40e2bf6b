//! What the approximate methods are asked and what they answer.

use super::ray_fan::radius_in;
use crate::clock::Deadline;
use crate::error::InputError;
use crate::solution::{Unsolved, Verdict};

/// What the boundary is chosen from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// Every boundary: equation (15).
    Stationary,
    /// Circles, of any centre. Exact flat-punch pressure, so a lower bound.
    Circle,
    /// Ellipses, of any centre, axes and orientation (section 2.2). Exact flat-punch pressure, so a lower bound.
    Ellipse,
    /// a = q_0 + sum over k = 1..m of (q_k cos k theta + s_k sin k theta) about the centroid.
    Fourier(usize),
    /// The contour of the gap at the present depth (the plan-form of the punch), scaled about its centroid.
    PlanForm,
}

/// What can go wrong: the input, or the method.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The problem cannot be built from this value.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The method has no answer, and says why.
    #[error(transparent)]
    Unsolved(#[from] Unsolved),
}

impl Error {
    /// The verdict, when it is one.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        match self {
            Self::Input(_) => None,
            Self::Unsolved(unsolved) => Some(unsolved.verdict),
        }
    }
}

/// How finely the approximate methods compute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Relative error allowed in the quadrature of the force. Not the error of the method, which is of the order of a
    /// per cent: default 1e-9.
    pub tolerance: f64,
    /// Most rays of the quadrature over the angle; when they do not suffice, the error reached is reported all the same.
    pub most_rays: usize,
    /// Equally spaced points of the boundary computed besides those of the quadrature; 0 saves their time.
    pub boundary_points: usize,
    /// When to stop with the verdict [`Verdict::TimeLimit`]; never unless said.
    pub deadline: Deadline,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-9, most_rays: 4_000, boundary_points: 180, deadline: Deadline::NEVER }
    }
}

impl Settings {
    /// The default with this tolerance, and no boundary points besides those of the quadrature.
    #[must_use]
    pub fn with_tolerance(tolerance: f64) -> Self {
        Self { tolerance, boundary_points: 0, ..Self::default() }
    }

    pub(crate) fn checked(&self) -> Result<Self, InputError> {
        if self.tolerance > 0.0 && self.tolerance < 1.0 {
            Ok(Self { tolerance: self.tolerance.max(1e-14), ..*self })
        } else {
            Err(InputError::new("tolerance", self.tolerance, "a number greater than 0 and less than 1"))
        }
    }
}

/// A boundary r = a(theta) about a centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundary {
    /// The centre, units of length.
    pub centre: [f64; 2],
    /// (theta, a), theta in radians, ascending in [0, 2 pi); a in units of length.
    pub outline: Vec<[f64; 2]>,
}

impl Boundary {
    /// a(theta), theta in radians: exact at the points of the outline, on their chords in between.
    #[must_use]
    pub fn radius(&self, theta: f64) -> f64 {
        radius_in(&self.outline, theta, std::f64::consts::TAU)
    }

    /// The boundary as a polyline, counter-clockwise, not closed.
    #[must_use]
    pub fn polyline(&self) -> Vec<[f64; 2]> {
        let point = |&[theta, a]: &[f64; 2]| {
            let (sin, cos) = theta.sin_cos();
            [self.centre[0] + a * cos, self.centre[1] + a * sin]
        };
        self.outline.iter().map(point).collect()
    }
}

/// A rigorous lower bound of the force, from the exact flat-punch pressure of an ellipse. Only the Ritz method makes it.
///
/// Rigorous but for rounding and for the quadrature of the gap, whose error estimate is taken off.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct LowerBound(pub(crate) f64);

impl LowerBound {
    /// The bound, units of force.
    #[must_use]
    pub fn force(self) -> f64 {
        self.0
    }
}

/// What the approximate method found.
#[derive(Debug, Clone, PartialEq)]
pub struct Approximation {
    /// What ran.
    pub family: Family,
    /// Why it ran, when the choice was left to [`crate::approximate::auto`]; empty otherwise.
    pub why: String,
    /// P, units of force.
    pub force: f64,
    /// dP/dd, force per length: the flat punch of this plan-form, 4 E* A/L (for an ellipse, the exact one).
    ///
    /// P(A) is stationary, so dP/dd is its derivative at fixed A. It is exact where the centre does not move with the
    /// depth; where the centroid wanders, the force depends on it to first order and this is an estimate
    /// (8e-4 low for one unsymmetric five-faced punch).
    pub stiffness: f64,
    /// D = P/(2E*), units of length squared (equation 15).
    pub d: f64,
    /// Largest G_aa over the boundary, units of length (the second variation); negative at a strict local maximum.
    /// For a family, the largest eigenvalue of its second variation, scaled likewise. `None` where no part is free.
    pub second_variation: Option<f64>,
    /// Largest |G_a - D|/D over the free boundary: how well equation (15) holds. For a family, of its own equations.
    pub residual: f64,
    /// Room left before the stationary boundary ceases to exist: least top of G_a over D, less 1; with its direction
    /// (radians). `None` for families.
    pub margin: Option<(f64, f64)>,
    /// The boundary.
    pub boundary: Boundary,
    /// Area A of the region.
    pub area: f64,
    /// Centroid of the region.
    pub centroid: [f64; 2],
    /// Estimated relative error of the force by quadrature: over the angle, and along the rays.
    pub quadrature_error: [f64; 2],
    /// Rays of the quadrature.
    pub rays: usize,
    /// Layouts of rays, and moves of the centre, that it took.
    pub iterations: usize,
    /// A rigorous lower bound, where there is one (ellipses).
    pub lower_bound: Option<LowerBound>,
}

impl Approximation {
    /// Shorter over longer axis of an ellipse, from the extremes of its boundary (exact where its points hold both ends).
    pub(crate) fn axis_ratio(&self) -> f64 {
        let radii = self.boundary.outline.iter().map(|p| p[1]);
        radii.clone().fold(f64::INFINITY, f64::min) / radii.fold(0.0, f64::max)
    }
}
