//! Regular polyhedral punches in closed form: equations (17) to (19) and (25), Table 1 for any number of faces.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::approximation::Error;
use crate::error::InputError;
use crate::gap::Polyhedron;
use crate::numeric::quadrature::GaussLegendre;
use crate::solution::{Unsolved, Verdict};

/// The stationary boundary of an n-faced regular punch, in units of depth = 1 and tan(inclination) = 1.
///
/// With kappa = D/D_end, D_end = 4/(3 pi) the end of the admissible interval, equation (18) reads
/// a = 2 D_end (1 + sqrt(1 - kappa cos theta))/(2 cos theta) about the middle of each face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegularPolyhedron {
    /// n.
    pub faces: usize,
    /// D/D_end, the first row of Table 1.
    pub kappa: f64,
    /// P tan(alpha)/(E* d^2); twice this is the paper's group (1 - nu) P tan(alpha)/(mu d^2), the second row of Table 1.
    pub force: f64,
    /// Area of the region over (d/tan(alpha))^2.
    pub area: f64,
    /// dP/dd tan(alpha)/(E* d) = 2 P/d.
    pub stiffness: f64,
}

/// D at the end of the admissible interval, times tan(alpha)/d^2: beyond it equation (17) has no root at theta = 0.
const D_END: f64 = 4.0 / (3.0 * PI);

impl RegularPolyhedron {
    /// Solves equation (15) for n >= 3 faces.
    ///
    /// ```
    /// let tetrahedron = contact_patch::fabrikant::RegularPolyhedron::new(3)?;
    /// assert!((2.0 * tetrahedron.force - 1.6960382).abs() < 1e-7);
    /// assert!((tetrahedron.kappa - 0.99905).abs() < 1e-5); // the paper says 1
    /// # Ok::<(), contact_patch::fabrikant::Error>(())
    /// ```
    ///
    /// # Errors
    /// With two faces the contact has no end (`Unbounded`); fewer are an input error.
    pub fn new(faces: usize) -> Result<Self, Error> {
        if faces < 2 {
            return Err(InputError::new("faces", faces, "a whole number, at least 2").into());
        }
        if faces == 2 {
            return Err(Unsolved::new(Verdict::Unbounded, "a wedge is in contact along the whole of its ridge").into());
        }
        // Dinkelbach: D <- N/L, from the cone's kappa = 3/4, below every n's.
        let mut kappa = 0.75;
        let mut sums = sums_at(faces, kappa);
        for _ in 0..30 {
            let next = sums.n / sums.l / D_END;
            let done = (next - kappa).abs() <= 1e-15;
            kappa = next.min(1.0);
            if done {
                break;
            }
            let before = kappa;
            sums = sums_at(faces, kappa);
            if (sums.n / sums.l / D_END - before).abs() <= 4e-16 {
                break;
            }
        }
        Ok(Self::from(faces, kappa, &sums))
    }

    /// The boundary of equation (19): D at the end of the admissible interval, where the paper puts n = 3.
    /// For n > 3 it is not the maximum.
    #[must_use]
    pub fn at_end(faces: usize) -> Self {
        Self::from(faces, 1.0, &sums_at(faces.max(3), 1.0))
    }

    /// The same for a punch of the general kind, when it is regular and pointed.
    #[must_use]
    pub fn of(punch: &Polyhedron) -> Option<Result<Self, Error>> {
        punch.regular().map(|(faces, _)| Self::new(faces))
    }

    fn from(faces: usize, kappa: f64, sums: &Sums) -> Self {
        let force = 2.0 * sums.n / sums.l;
        Self { faces, kappa, force, area: sums.area, stiffness: 4.0 * sums.area / sums.l }
    }

    /// a(theta) tan(alpha)/d, theta in radians from the middle of a face (equation 18, upper sign).
    #[must_use]
    pub fn radius(&self, theta: f64) -> f64 {
        let sector = 2.0 * PI / self.faces as f64;
        let theta = theta - sector * (theta / sector).round();
        radius(theta.cos(), (1.0 - self.kappa * theta.cos()).max(0.0).sqrt())
    }
}

/// Equation (18) from cos theta and the root.
fn radius(cos: f64, root: f64) -> f64 {
    D_END * (1.0 + root) / cos
}

/// N, L and the area.
struct Sums {
    n: f64,
    l: f64,
    area: f64,
}

/// Integrals over half a face, times 2n. With sin(theta/2) = s sinh u, s^2 = (1 - kappa)/(2 kappa), the root in (18) is
/// sqrt(1 - kappa) cosh u: the near-kink at theta = 0 when kappa is close to 1 is gone, and 24 Gauss points give 1e-13.
fn sums_at(faces: usize, kappa: f64) -> Sums {
    static RULE: OnceLock<GaussLegendre> = OnceLock::new();
    let rule = RULE.get_or_init(|| GaussLegendre::new(24)).nodes();
    let half = 0.5 * PI / faces as f64;
    let mut sums = Sums { n: 0.0, l: 0.0, area: 0.0 };
    let mut add = |cos: f64, weight: f64, root: f64| {
        let a = radius(cos, root);
        sums.l += weight * a;
        sums.area += weight * 0.5 * a * a;
        // G = a^2 - (pi/4) a^3 cos theta.
        sums.n += weight * a * a * (1.0 - 0.25 * PI * a * cos);
    };
    let scale = 2.0 * faces as f64;
    if kappa >= 1.0 {
        // sqrt(1 - cos theta) = sqrt(2) sin(theta/2): smooth on this side of the kink.
        for (x, w) in rule {
            let theta = half * (1.0 + x);
            add(theta.cos(), scale * half * w, std::f64::consts::SQRT_2 * (0.5 * theta).sin());
        }
    } else {
        let s = ((1.0 - kappa) / (2.0 * kappa)).sqrt();
        let last = (half.sin() / s).asinh();
        for (x, w) in rule {
            let e = (0.5 * last * (1.0 + x)).exp();
            let (sinh, cosh) = (0.5 * (e - 1.0 / e), 0.5 * (e + 1.0 / e));
            let sine = s * sinh;
            let cosine = (1.0 - sine * sine).sqrt();
            add(1.0 - 2.0 * sine * sine, scale * w * last * s * cosh / cosine, (1.0 - kappa).sqrt() * cosh);
        }
    }
    sums
}
