//! Contacts that have a formula: Hertz, gaps of revolution with a disc for a contact, flat discs and ellipses.
//!
//! Every form is a struct made from an [`EffectiveModulus`](crate::EffectiveModulus) and the parameters of the gap, with
//! `at_depth` and `at_force`. Both give a [`ClosedForm`]. Units: any consistent set. Depth is counted from first touch.
//!
//! For gaps of revolution, with D(s) = s int_0^s g'(r)/sqrt(s^2 - r^2) dr (Sneddon 1965) and q(s) = d - D(s):
//!
//! ```text
//! q(a) = 0,   P = 2 E* int_0^a q ds,   U = E* int_0^a q^2 ds,   p(r) = (E*/pi) int_r^a D'(s)/sqrt(s^2 - r^2) ds
//! ```

mod carlson;
mod disc_contact;
#[cfg(all(feature = "plot", feature = "scene"))]
pub(crate) mod drawn;
mod flat_punch;
mod generatrix;
mod hertz;
mod inside_an_edge;
mod interpolated;
mod power;
pub(crate) mod select;
mod sneddon;
mod sphere;
mod tipped_cone;

pub use carlson::{r_d, r_f};
pub use flat_punch::{FlatPunch, tilt_stiffness};
pub use hertz::{Hertz, Quadratic};
pub use power::{Cone, Power};
pub use sneddon::Sneddon;
pub use sphere::Sphere;
pub use tipped_cone::{FlatEndedCone, RoundedCone};

use std::f64::consts::{PI, TAU};
use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::{Matrix3, Rotation2, Vector2};

/// An ellipse in the plane: the contact of every closed form.
///
/// ```
/// use contact_patch::closed_form::Ellipse;
/// let patch = Ellipse { centre: [1.0, 0.0], semi_axes: [2.0, 1.0], orientation: std::f64::consts::FRAC_PI_2 };
/// assert!(patch.inside([1.0, 1.9]) > 0.0 && patch.inside([2.9, 0.0]) < 0.0);
/// assert_eq!(patch.boundary(64).len(), 64);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Centre.
    pub centre: [f64; 2],
    /// Semi-axes a >= b > 0.
    pub semi_axes: [f64; 2],
    /// Angle from x to the axis of a, in radians, counter-clockwise.
    pub orientation: f64,
}

impl Ellipse {
    /// A disc about the origin.
    #[must_use]
    pub fn disc(radius: f64) -> Self {
        Self { centre: [0.0; 2], semi_axes: [radius; 2], orientation: 0.0 }
    }

    /// pi a b.
    #[must_use]
    pub fn area(&self) -> f64 {
        PI * self.semi_axes[0] * self.semi_axes[1]
    }

    /// Whether both semi-axes are the same.
    #[must_use]
    pub fn is_disc(&self) -> bool {
        self.semi_axes[0] == self.semi_axes[1]
    }

    /// The point in the frame of the axes, from the centre.
    #[must_use]
    pub fn local(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let from_centre = Vector2::new(x - self.centre[0], y - self.centre[1]);
        if self.orientation == 0.0 {
            return from_centre.into();
        }
        (Rotation2::new(-self.orientation) * from_centre).into()
    }

    /// 1 - x^2/a^2 - y^2/b^2 at a point: positive inside, negative outside.
    #[must_use]
    pub fn inside(&self, point: [f64; 2]) -> f64 {
        let ([x, y], [a, b]) = (self.local(point), self.semi_axes);
        let rho = (x / a).hypot(y / b);
        (1.0 - rho) * (1.0 + rho)
    }

    /// Lower left and upper right corner of the rectangle around it.
    #[must_use]
    pub fn extent(&self) -> [[f64; 2]; 2] {
        let ([a, b], (sin, cos)) = (self.semi_axes, self.orientation.sin_cos());
        let half = [(a * cos).hypot(b * sin), (a * sin).hypot(b * cos)];
        [-1.0, 1.0].map(|sign| [0, 1].map(|m| self.centre[m] + sign * half[m]))
    }

    /// `n` points of the boundary at equal eccentric angles, counter-clockwise, not closed.
    #[must_use]
    pub fn boundary(&self, n: usize) -> Vec<[f64; 2]> {
        let ([a, b], [cx, cy], turn) = (self.semi_axes, self.centre, Rotation2::new(self.orientation));
        let point = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / n as f64).sin_cos();
            let p = turn * Vector2::new(a * cos, b * sin);
            [cx + p.x, cy + p.y]
        };
        (0..n).map(point).collect()
    }
}

/// What a formula says about a contact.
///
/// ```
/// use contact_patch::{EffectiveModulus, closed_form::Hertz};
/// let contact = Hertz::circular(EffectiveModulus::from_e_star(1e11)?, 0.01)?.at_force(10.0)?;
/// let moved = contact.clone().placed([1.0, 2.0], 0.0);
/// let p0 = 1.5 * contact.mean_pressure();
/// assert!((contact.max_pressure().unwrap() / p0 - 1.0).abs() < 1e-14);
/// assert!((moved.pressure(1.0, 2.0) / p0 - 1.0).abs() < 1e-14);
/// assert!((contact.energy() / (0.4 * contact.force * contact.depth) - 1.0).abs() < 1e-14);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ClosedForm {
    /// P, the normal force.
    pub force: f64,
    /// d, the depth at the origin: f = d + tilt . (x, y) - g.
    pub depth: f64,
    /// The tilt (dimensionless slopes along x and y); zero unless it was asked for.
    pub tilt: [f64; 2],
    /// dP/dd at fixed tilt: the stiffness of a flat punch with the present contact for its plan-form.
    pub stiffness: f64,
    /// Estimate of the relative error of force and depth: rounding, or the quadrature's own estimate.
    pub error: f64,
    /// The contact.
    pub patch: Ellipse,
    e_star: f64,
    pressure: Distribution,
}

/// Relative error of the forms that need no quadrature: a few roundings and a root to the last digit.
const ROUNDING: f64 = 1e-14;

/// Digits that a pressure has less than the force.
const PEAK: f64 = 100.0;

/// How the pressure varies over the patch, in the frame of its axes.
#[derive(Debug, Clone)]
enum Distribution {
    /// peak sqrt(1 - rho^2); the energy beside it.
    Hertz { peak: f64, energy: f64 },
    /// (c0 + c1 x + c2 y)/sqrt(1 - rho^2).
    Punch { c: [f64; 3], energy: f64 },
    /// Known in the radius only.
    Revolution(Arc<dyn Revolution>),
}

/// A solved contact of revolution with E* = 1: what is computed only when somebody asks.
trait Revolution: Debug + Send + Sync {
    /// Pressure at radius r < a.
    fn pressure(&self, r: f64) -> f64;
    /// The same to a few digits: where it is largest.
    fn rough_pressure(&self, r: f64) -> f64 {
        self.pressure(r)
    }
    /// U/P, a length, where U alone may be beyond the range of numbers; `force`: P for E* = 1.
    fn energy_over_force(&self, force: f64) -> f64;
    /// The largest pressure; `None` when it is infinite.
    fn peak(&self) -> Option<f64>;
    /// Relative error of that, besides what the force errs by.
    fn peak_error(&self) -> f64 {
        0.0
    }
}

impl ClosedForm {
    /// A disc about the origin: P, d and a from the formula, the rest from the shape.
    fn disc(e_star: f64, force: f64, depth: f64, a: f64, shape: impl Revolution + 'static) -> Self {
        Self {
            force,
            depth,
            tilt: [0.0; 2],
            stiffness: 2.0 * e_star * a,
            error: ROUNDING,
            patch: Ellipse::disc(a),
            e_star,
            pressure: Distribution::Revolution(Arc::new(shape)),
        }
    }

    /// U, the elastic energy stored: dU/dd = P, dU/dP = P dd/dP.
    #[must_use]
    pub fn energy(&self) -> f64 {
        match &self.pressure {
            Distribution::Hertz { energy, .. } | Distribution::Punch { energy, .. } => *energy,
            Distribution::Revolution(shape) => self.force * shape.energy_over_force(self.force / self.e_star),
        }
    }

    /// The pressure at (x, y), zero outside the patch. Infinite where the formula is: on the rim of a flat punch, at the
    /// tip of a cone, at a corner of a generatrix.
    #[must_use]
    pub fn pressure(&self, x: f64, y: f64) -> f64 {
        let inside = self.patch.inside([x, y]);
        let [u, v] = self.patch.local([x, y]);
        match &self.pressure {
            _ if inside < 0.0 || inside.is_nan() => 0.0,
            Distribution::Hertz { peak, .. } => peak * inside.sqrt(),
            Distribution::Punch { c, .. } => (c[0] + c[1] * u + c[2] * v).max(0.0) / inside.sqrt(),
            Distribution::Revolution(shape) => self.e_star * shape.pressure(u.hypot(v)),
        }
    }

    /// The same to a few digits, and sooner.
    pub(crate) fn rough_pressure(&self, x: f64, y: f64) -> f64 {
        match &self.pressure {
            Distribution::Revolution(shape) if self.patch.inside([x, y]) >= 0.0 => {
                let [u, v] = self.patch.local([x, y]);
                self.e_star * shape.rough_pressure(u.hypot(v))
            }
            _ => self.pressure(x, y),
        }
    }

    /// The largest pressure; `None` when it is infinite (flat punch, cone, any corner of the generatrix).
    #[must_use]
    pub fn max_pressure(&self) -> Option<f64> {
        match &self.pressure {
            Distribution::Hertz { peak, .. } => Some(*peak),
            Distribution::Punch { .. } => None,
            Distribution::Revolution(shape) => shape.peak().map(|p| self.e_star * p),
        }
    }

    /// Relative error of the largest pressure: digits that it, an integral next to a square root, has less than the force, and what its
    /// own quadrature leaves.
    pub(crate) fn max_pressure_error(&self) -> f64 {
        let own = match &self.pressure {
            Distribution::Revolution(shape) => shape.peak_error(),
            Distribution::Hertz { .. } | Distribution::Punch { .. } => 0.0,
        };
        own.max(PEAK * self.error)
    }

    /// Force over area of the patch.
    #[must_use]
    pub fn mean_pressure(&self) -> f64 {
        self.force / self.patch.area()
    }

    /// Where the line of action of the force meets the surface: int p (x, y) over P.
    #[must_use]
    pub fn line_of_action(&self) -> [f64; 2] {
        let Distribution::Punch { c, .. } = &self.pressure else { return self.patch.centre };
        // int u (c1 u)/sqrt(1 - rho^2) = (2 pi/3) a^3 b c1 and P = 2 pi a b c0.
        let [a, b] = self.patch.semi_axes;
        let arm = Vector2::new(a * a * c[1], b * b * c[2]) / (3.0 * c[0]);
        let arm = Rotation2::new(self.patch.orientation) * arm;
        [self.patch.centre[0] + arm.x, self.patch.centre[1] + arm.y]
    }

    /// The derivative of (P, int p x, int p y) with respect to (depth, tilt x, tilt y), about the origin.
    ///
    /// The contact grows where the pressure is zero, so the incremental stiffness is that of a flat punch on the patch.
    #[must_use]
    pub fn stiffness_with_tilt(&self) -> Matrix3<f64> {
        tilt_stiffness(self.e_star, &self.patch)
    }

    /// The same contact rotated counter-clockwise by `rotate` radians about the origin, then moved to `at`.
    /// Depth and tilt stay those of the moved point.
    #[must_use]
    pub fn placed(mut self, at: [f64; 2], rotate: f64) -> Self {
        let turn = Rotation2::new(rotate);
        let centre = turn * Vector2::from(self.patch.centre);
        self.patch.centre = [at[0] + centre.x, at[1] + centre.y];
        self.tilt = (turn * Vector2::from(self.tilt)).into();
        self.patch.orientation += rotate;
        self
    }
}
