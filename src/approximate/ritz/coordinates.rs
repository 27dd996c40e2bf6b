//! An ellipse, and the coordinates in which it is moved: those that turn it into the unit disc.

use nalgebra::{Matrix2, SVector, Vector2};

/// Centre (2) and logarithmic strain of the ellipse (3: along 1, along 2, shear times sqrt 2), in its own coordinates.
pub(super) type Step = SVector<f64, 5>;

/// An ellipse: c + M u, |u| < 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ellipse {
    pub c: Vector2<f64>,
    pub m: Matrix2<f64>,
}

impl Ellipse {
    /// The ellipse one step away.
    pub fn moved(&self, step: &Step) -> Self {
        let shear = step[4] / std::f64::consts::SQRT_2;
        let s = Matrix2::new(step[2], shear, shear, step[3]);
        let exp = Matrix2::identity() + s + s * s / 2.0 + s * s * s / 6.0;
        Self { c: self.c + self.m * Vector2::new(step[0], step[1]), m: self.m * exp }
    }

    /// Semi-axes a >= b, direction of a (a unit vector), and the same direction before M.
    pub fn axes(&self) -> ([f64; 2], Vector2<f64>, Vector2<f64>) {
        let (values, vectors) = eigen(&(self.m * self.m.transpose()));
        let (_, before) = eigen(&(self.m.transpose() * self.m));
        let a = values[1].sqrt();
        ([a, self.m.determinant().abs() / a], vectors.column(1).into(), before.column(1).into())
    }
}

/// Eigenvalues (ascending) and vectors of a symmetric matrix by one Jacobi rotation, which keeps the digits of the small one.
pub(super) fn eigen(q: &Matrix2<f64>) -> ([f64; 2], Matrix2<f64>) {
    let (q11, q12, q22) = (q[(0, 0)], 0.5 * (q[(0, 1)] + q[(1, 0)]), q[(1, 1)]);
    let t = if q12 == 0.0 {
        0.0
    } else {
        let theta = (q22 - q11) / (2.0 * q12);
        theta.signum() / (theta.abs() + theta.hypot(1.0))
    };
    let cos = 1.0 / t.hypot(1.0);
    let sin = t * cos;
    let (low, high) = (q11 - t * q12, q22 + t * q12);
    if low <= high {
        ([low, high], Matrix2::new(cos, sin, -sin, cos))
    } else {
        ([high, low], Matrix2::new(sin, cos, cos, -sin))
    }
}

/// agm(a, b) and its logarithmic derivative with respect to log a, a >= b: (K - E)/(e^2 K), from the differences of the
/// arithmetic-geometric mean, where nothing cancels.
pub(super) fn mean_and_share(a: f64, b: f64) -> (f64, f64) {
    let k = b / a;
    let (mut x, mut y) = (0.5 * (1.0 + k), k.sqrt());
    // c_n^2/e^2 and the running sum of 2^(n-1) c_n^2/e^2.
    let mut c = 0.5 * (1.0 - k);
    let mut ratio = (1.0 - k) / (4.0 * (1.0 + k));
    let mut share = 0.5 + ratio;
    let mut power = 2.0;
    while c > 1e-17 {
        let next = 0.5 * (x + y);
        let factor = c / (4.0 * next);
        ratio *= factor * factor;
        c *= factor;
        share += power * ratio;
        power *= 2.0;
        (x, y) = (next, (x * y).sqrt());
    }
    (a * x, share)
}
