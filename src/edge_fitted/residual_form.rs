//! Bounds of a(w, w) for the residuals w of all planes in contact, from those of three.
//!
//! On one set of cells w is linear in its plane: w = sum of c_k w_k. The sums of (2) are quadratic forms of c, with
//! 2 (w_i, w_j) = |w_i + w_j|^2 - |w_i|^2 - |w_j|^2 for both, and what interpolation leaves out of w is at most the sum of |c_k| times what it
//! leaves out of w_k (Minkowski). Residuals of different signs under mirrors are orthogonal in a(., .) (`mirrored`), and have forms of their
//! own.

use nalgebra::{Matrix3, Vector3};

use super::integrand::Sums;

/// What sums of squares may change a form by, of the size of its terms.
const ROUNDING: f64 = 1e-11;

/// The planes w_k, and the sums of (2).
#[derive(Debug, Clone)]
pub(super) struct ResidualForm {
    /// c of (1, x, y)_j.
    coordinates: Matrix3<f64>,
    alpha: Matrix3<f64>,
    beta: Matrix3<f64>,
    /// Roots of what is left out of both.
    left_out: [Vector3<f64>; 2],
    /// The parts that are orthogonal to all others.
    parts: &'static [&'static [usize]],
}

impl ResidualForm {
    /// `own`: of the residuals of `planes`; `pairs`, `joint`: of sums of two of them, of the same part.
    pub fn new(
        planes: [Vector3<f64>; 3],
        parts: &'static [&'static [usize]],
        own: &[Sums; 3],
        pairs: &[[usize; 2]],
        joint: &[Sums],
    ) -> Option<Self> {
        let coordinates = Matrix3::from_columns(&planes).try_inverse()?;
        let form = |of: fn(&Sums) -> f64| {
            let mut form = Matrix3::from_diagonal(&Vector3::from_fn(|k, _| of(&own[k])));
            for (&[i, j], both) in pairs.iter().zip(joint) {
                let product = 0.5 * (of(both) - of(&own[i]) - of(&own[j]));
                (form[(i, j)], form[(j, i)]) = (product, product);
            }
            form
        };
        let root = |of: fn(&Sums) -> f64| Vector3::from_fn(|k, _| of(&own[k]).sqrt());
        Some(Self {
            coordinates,
            alpha: form(|sums| sums.alpha),
            beta: form(|sums| sums.beta),
            left_out: [root(|sums| sums.alpha_rest), root(|sums| sums.beta_rest)],
            parts,
        })
    }

    /// Of g . (1, x, y).
    pub fn of(&self, plane: &Vector3<f64>) -> f64 {
        let c = self.coordinates * plane;
        let of_part = |part: &&[usize]| {
            let own = Vector3::from_fn(|k, _| if part.contains(&k) { c[k] } else { 0.0 });
            let form = |form: &Matrix3<f64>| {
                let size = Vector3::from_fn(|k, _| own[k].abs() * form[(k, k)].sqrt()).sum();
                (own.dot(&(form * own)) + ROUNDING * size * size).max(0.0)
            };
            let rest = |roots: &Vector3<f64>| own.abs().dot(roots).powi(2);
            let [alpha_rest, beta_rest] = self.left_out.each_ref().map(rest);
            Sums { alpha: form(&self.alpha), beta: form(&self.beta), alpha_rest, beta_rest }.bound()
        };
        self.parts.iter().map(of_part).sum()
    }
}
