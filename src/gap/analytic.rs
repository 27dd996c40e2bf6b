//! Gaps with one formula: paraboloid, sphere, cone, power law.

use super::radial::{self, Profile, distances};
use super::{Axis, Degree, Gap, Generatrix, Growth, Known, Law, Material, Quadratic, Reach, Taylor};
use crate::error::{InputError, finite, positive};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Room for the rounding of a radius.
const ROUNDING: f64 = 1.0 + 1e-14;

/// A radius beyond the range of numbers is none.
pub(super) fn disc(radius: f64) -> Reach {
    if radius == f64::INFINITY {
        Reach::Unbounded { from: [0.0; 2], along: 0.0 }
    } else if radius > 0.0 {
        Reach::Within(Rect::around([0.0; 2], [radius * ROUNDING; 2]))
    } else {
        Reach::Nowhere
    }
}

/// What bodies of revolution about the origin that rise from 0 there have in common.
pub(super) fn rising(generatrix: Generatrix) -> Known {
    Known {
        floor: 0.0,
        axis: Some(Axis { at: [0.0; 2], generatrix }),
        material: Material::Everywhere,
        mirrors: [true; 2],
        ..Known::nothing()
    }
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

    fn describe(&self) -> Known {
        let [r1, r2] = self.radii;
        let round = (r1 == r2 && r1.is_finite()).then(|| Generatrix::Power {
            coefficient: 0.5 / r1,
            exponent: 2.0,
            lowest: 0.0,
        });
        Known {
            floor: 0.0,
            law: Some(Law { degree: Degree::Power(2.0), lowest: 0.0 }),
            quadratic: Some(Quadratic {
                about: [0.0; 2],
                value: 0.0,
                gradient: [0.0; 2],
                hessian: [r1.recip(), 0.0, r2.recip()],
            }),
            axis: round.map(|generatrix| Axis { at: [0.0; 2], generatrix }),
            material: Material::Everywhere,
            mirrors: [true; 2],
            ..Known::nothing()
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        if depth <= 0.0 {
            return Reach::Nowhere;
        }
        if let Some(axis) = (0..2).find(|&m| self.radii[m] == f64::INFINITY) {
            return Reach::Unbounded { from: [0.0; 2], along: axis as f64 * std::f64::consts::FRAC_PI_2 };
        }
        Reach::Within(Rect::around([0.0; 2], self.radii.map(|r| (2.0 * r).sqrt() * depth.sqrt() * ROUNDING)))
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        self.taylor(rect).map(|t| t.bounds(rect.size(), slope))
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let c = rect.centre().map(Interval::point);
        let curvature = self.radii.map(|r| Interval::point(1.0) / Interval::point(r));
        let curvature = [0, 1].map(|m| if self.radii[m] == f64::INFINITY { Interval::ZERO } else { curvature[m] });
        let gradient = [0, 1].map(|m| curvature[m] * c[m]);
        let value = Interval::point(0.5) * (gradient[0] * c[0] + gradient[1] * c[1]);
        Taylor { value, gradient, hessian: [curvature[0], Interval::ZERO, curvature[1]] }.finite()
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        let [a, b] = self.radii.map(|r| Interval::point(0.5 / r));
        Some(Growth::power(2.0, a * sector.cos().powi(2) + b * sector.sin().powi(2), from))
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

    fn describe(&self) -> Known {
        let around = Rect::around([0.0; 2], [self.radius; 2]);
        Known { material: Material::Within(around), ..rising(Generatrix::Sphere { radius: self.radius, lowest: 0.0 }) }
    }

    fn reach(&self, depth: f64) -> Reach {
        let t = depth / self.radius;
        disc(if t >= 1.0 { self.radius } else { self.radius * (t * (2.0 - t)).max(0.0).sqrt() })
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        Some(radial::bounds(rect, slope, self.profile(distances(rect)).value, || self.taylor(rect)))
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        radial::taylor(rect, |r| self.profile(r))
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Growth::ended(&Rect::around([0.0; 2], [self.radius; 2]), from)
    }
}

impl Sphere {
    /// g = R rho^2/(1 + c), g'/r = 1/(R c), g'' = 1/(R c^3) with rho = r/R, c = sqrt(1 - rho^2).
    fn profile(&self, r: Interval) -> Profile {
        let (one, radius) = (Interval::point(1.0), Interval::point(self.radius));
        let rho = r / radius;
        let c = ((one - rho) * (one + rho)).sqrt();
        let value = |rho: Interval, c: Interval| radius * rho.powi(2) / (one + c);
        // g rises with r: its bounds lie at the ends.
        let end = |rho: f64| {
            let rho = Interval::point(rho);
            value(rho, ((one - rho) * (one + rho)).sqrt())
        };
        let top = if c.defined { end(rho.hi).hi } else { self.radius.next_up() };
        Profile {
            value: if c.is_empty() {
                Interval::EMPTY
            } else {
                Interval { lo: end(rho.lo).lo.max(0.0), hi: top, defined: c.defined }
            },
            slope_over_r: one / (radius * c),
            curvature: one / (radius * c.powi(3)),
        }
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

    fn describe(&self) -> Known {
        Known {
            law: Some(Law { degree: Degree::Power(1.0), lowest: 0.0 }),
            ..rising(Generatrix::Power { coefficient: self.slope, exponent: 1.0, lowest: 0.0 })
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        disc(depth / self.slope)
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let value = Interval::point(self.slope) * distances(rect);
        let [low, high] = radial::bounds(rect, slope, value, || self.taylor(rect));
        // The cone lies above each of its tangent planes, also across the apex.
        let [x, y] = rect.centre();
        let below = |t: [f64; 2]| {
            let [w, h] = rect.size();
            let plane = Interval::point(t[0]) * Interval::point(x) + Interval::point(t[1]) * Interval::point(y);
            let rest = (t[0] - slope[0]).abs() * w + (t[1] - slope[1]).abs() * h;
            plane.lo - (0.5 * rest).next_up()
        };
        // A slope slightly less than the cone's: rounding keeps the plane below.
        let tangent = self.gradient(x, y).map_or([0.0; 2], |g| g.map(|g| g * (1.0 - 4.0 * f64::EPSILON)));
        Some([low.max(below(tangent)), high])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let slope = Interval::point(self.slope);
        radial::taylor(rect, |r| Profile { value: slope * r, slope_over_r: slope / r, curvature: Interval::ZERO })
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        radial::slopes(rect, Interval::point(self.slope))
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Some(radial::power(self.slope, 1.0, from))
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

    fn describe(&self) -> Known {
        let (coefficient, exponent) = (self.coefficient, self.exponent);
        Known {
            law: Some(Law { degree: Degree::Power(exponent), lowest: 0.0 }),
            quadratic: (exponent == 2.0).then_some(Quadratic {
                about: [0.0; 2],
                value: 0.0,
                gradient: [0.0; 2],
                hessian: [2.0 * coefficient, 0.0, 2.0 * coefficient],
            }),
            ..rising(Generatrix::Power { coefficient, exponent, lowest: 0.0 })
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        // Large powers of a quotient that is off by rounding are off by their share of it.
        let room = 1.0 + 4.0 * f64::EPSILON / self.exponent;
        disc((depth / self.coefficient).powf(1.0 / self.exponent) * room)
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let value = Interval::point(self.coefficient) * distances(rect).powf(Interval::point(self.exponent));
        Some(radial::bounds(rect, slope, value, || self.taylor(rect)))
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let (n, one) = (Interval::point(self.exponent), Interval::point(1.0));
        let c = Interval::point(self.coefficient);
        let lowered = |r: Interval| if self.exponent == 2.0 { c } else { c * r.powf(n - Interval::point(2.0)) };
        radial::taylor(rect, |r| Profile {
            value: c * r.powf(n),
            slope_over_r: n * lowered(r),
            curvature: if self.exponent == 1.0 { Interval::ZERO } else { n * (n - one) * lowered(r) },
        })
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        let (n, one) = (Interval::point(self.exponent), Interval::point(1.0));
        let steep = if self.exponent == 1.0 { one } else { radial::distances(rect).powf(n - one) };
        radial::slopes(rect, n * Interval::point(self.coefficient) * steep)
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Some(radial::power(self.coefficient, self.exponent, from))
    }
}
