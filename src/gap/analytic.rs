//! Gaps with one formula: paraboloid, sphere, cone, power law.

use super::{Gap, Reach, range};
use crate::error::{InputError, finite, positive};
use crate::geometry::Rect;

fn disc(radius: f64) -> Reach {
    if radius > 0.0 { Reach::Within(Rect::around([0.0; 2], [radius; 2])) } else { Reach::Nowhere }
}

/// x^2/(2 R1) + y^2/(2 R2): two bodies of relative principal curvatures 1/R1, 1/R2 (Hertz).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paraboloid {
    radii: [f64; 2],
}

impl Paraboloid {
    /// Relative radii of curvature R1 along x and R2 along y, both greater than zero. An infinite radius is a straight
    /// generator: `[0.02, f64::INFINITY]` is a cylinder of radius 0.02 whose axis lies along y.
    ///
    /// # Errors
    /// Names the radius that is not greater than zero.
    pub fn new(radii: [f64; 2]) -> Result<Self, InputError> {
        for (path, radius) in [("radii[0]", radii[0]), ("radii[1]", radii[1])] {
            if radius.is_nan() || radius <= 0.0 {
                return Err(InputError::new(
                    path,
                    radius,
                    "a number greater than 0, infinite for a straight generator",
                ));
            }
        }
        Ok(Self { radii })
    }

    /// R1 and R2.
    #[must_use]
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }
}

impl Gap for Paraboloid {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let [r1, r2] = self.radii;
        0.5 * (x * (x / r1) + y * (y / r2))
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        Some([x / self.radii[0], y / self.radii[1]])
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        Some(range::of_squares(self.radii.map(|r| 0.5 / r), rect, slope))
    }

    fn homogeneous(&self) -> Option<f64> {
        Some(2.0)
    }

    fn mirrors(&self) -> [bool; 2] {
        [true; 2]
    }

    fn reach(&self, depth: f64) -> Reach {
        if depth <= 0.0 {
            return Reach::Nowhere;
        }
        if self.radii.contains(&f64::INFINITY) {
            return Reach::Unbounded;
        }
        Reach::Within(Rect::around([0.0; 2], self.radii.map(|r| (2.0 * r).sqrt() * depth.sqrt())))
    }

    fn mean(&self, cell: &Rect) -> f64 {
        // Mean of x^2 over an interval of length w about c: c^2 + w^2/12.
        let ([x, y], [w, h], [r1, r2]) = (cell.centre(), cell.size(), self.radii);
        self.gap(x, y) + (w * (w / r1) + h * (h / r2)) / 24.0
    }
}

/// R - sqrt(R^2 - r^2): a true sphere of radius R, no material beyond r = R.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    radius: f64,
}

impl Sphere {
    /// A sphere of this radius, greater than zero.
    ///
    /// # Errors
    /// When the radius is not a finite number greater than zero.
    pub fn new(radius: f64) -> Result<Self, InputError> {
        Ok(Self { radius: positive("radius", radius)? })
    }

    /// R.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl Gap for Sphere {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let rho = x.hypot(y) / self.radius;
        if rho > 1.0 {
            return f64::INFINITY;
        }
        // R (1 - c) = R rho^2/(1 + c) with c = sqrt(1 - rho^2): nothing cancels at the pole.
        self.radius * rho * rho / (1.0 + ((1.0 - rho) * (1.0 + rho)).sqrt())
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let rho = x.hypot(y) / self.radius;
        let height = self.radius * ((1.0 - rho) * (1.0 + rho)).max(0.0).sqrt();
        Some([x / height, y / height])
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        Some(range::of_convex(self, rect, slope))
    }

    fn mirrors(&self) -> [bool; 2] {
        [true; 2]
    }

    fn reach(&self, depth: f64) -> Reach {
        let t = depth / self.radius;
        disc(if t >= 1.0 { self.radius } else { self.radius * (t * (2.0 - t)).max(0.0).sqrt() })
    }
}

/// r tan(inclination): a cone (Love 1939).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    slope: f64,
}

impl Cone {
    /// A cone whose flank makes this angle (radians, in (0, pi/2)) with the surface.
    ///
    /// # Errors
    /// When the inclination is out of range.
    pub fn new(inclination: f64) -> Result<Self, InputError> {
        Ok(Self { slope: slope_of(inclination)? })
    }

    /// A cone whose flank rises by `slope` > 0 a unit of radius.
    ///
    /// # Errors
    /// When the slope is not a finite number greater than zero.
    pub fn with_slope(slope: f64) -> Result<Self, InputError> {
        Ok(Self { slope: positive("slope", slope)? })
    }

    /// Rise a unit of radius.
    #[must_use]
    pub fn slope(&self) -> f64 {
        self.slope
    }
}

/// tan of an inclination in radians, in (0, pi/2). The message speaks of degrees, as scenes do.
pub(super) fn slope_of(inclination: f64) -> Result<f64, InputError> {
    let slope = inclination.tan();
    if inclination > 0.0 && inclination < std::f64::consts::FRAC_PI_2 && slope.is_normal() {
        Ok(slope)
    } else {
        let allowed = "an angle greater than 0 and less than 90 degrees";
        Err(InputError::new("inclination", format!("{} degrees", inclination.to_degrees()), allowed))
    }
}

impl Gap for Cone {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.slope * x.hypot(y)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let r = x.hypot(y);
        Some(if r > 0.0 { [self.slope * (x / r), self.slope * (y / r)] } else { [self.slope, 0.0] })
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        Some(range::of_convex(self, rect, slope))
    }

    fn homogeneous(&self) -> Option<f64> {
        Some(1.0)
    }

    fn mirrors(&self) -> [bool; 2] {
        [true; 2]
    }

    fn reach(&self, depth: f64) -> Reach {
        disc(depth / self.slope)
    }
}

/// c r^n: a power law with real exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Power {
    coefficient: f64,
    exponent: f64,
}

impl Power {
    /// c > 0 (length^(1-n)) and n > 0.
    ///
    /// # Errors
    /// Names the parameter that is not a finite number greater than zero.
    pub fn new(coefficient: f64, exponent: f64) -> Result<Self, InputError> {
        finite("coefficient", coefficient)?;
        Ok(Self { coefficient: positive("coefficient", coefficient)?, exponent: positive("exponent", exponent)? })
    }

    /// c.
    #[must_use]
    pub fn coefficient(&self) -> f64 {
        self.coefficient
    }

    /// n.
    #[must_use]
    pub fn exponent(&self) -> f64 {
        self.exponent
    }
}

impl Gap for Power {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.coefficient * x.hypot(y).powf(self.exponent)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let r = x.hypot(y);
        let slope = self.coefficient * self.exponent * r.powf(self.exponent - 1.0);
        Some(if r > 0.0 { [slope * (x / r), slope * (y / r)] } else { [slope, 0.0] })
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        Some(if self.exponent >= 1.0 {
            range::of_convex(self, rect, slope)
        } else {
            range::of_radial(|r| [self.coefficient * r.powf(self.exponent); 2], rect, slope)
        })
    }

    fn homogeneous(&self) -> Option<f64> {
        Some(self.exponent)
    }

    fn mirrors(&self) -> [bool; 2] {
        [true; 2]
    }

    fn reach(&self, depth: f64) -> Reach {
        disc((depth / self.coefficient).powf(1.0 / self.exponent))
    }
}
