//! Carlson's symmetric elliptic integrals R_F and R_D (DLMF 19.16) by duplication (DLMF 19.36.1-2; Carlson 1995).
//!
//! Only sums, products and roots of positive numbers: nothing cancels, at any ratio of the arguments.

/// The largest deviation Q of the arguments from their mean at which the series of degree 7 has converged: its error is
/// of the order of (Q/A)^8, with small factors (DLMF 19.36.1).
const CONVERGED: f64 = 2e-3;

/// R_F(x, y, z) = 1/2 int_0^inf dt / sqrt((t + x)(t + y)(t + z)), at most one argument zero, none negative.
///
/// Relative error about 1e-15. Infinite when two arguments are zero, NaN when one is negative.
///
/// ```
/// // The complete integral K(m) = R_F(0, 1 - m, 1); K(0) = pi/2.
/// use contact_patch::closed_form::r_f;
/// assert!((r_f(0.0, 1.0, 1.0) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
/// ```
#[must_use]
pub fn r_f(x: f64, y: f64, z: f64) -> f64 {
    let zeros = [x, y, z].iter().filter(|&&v| v == 0.0).count();
    if !(x >= 0.0 && y >= 0.0 && z >= 0.0) {
        return f64::NAN;
    }
    if zeros > 1 {
        return f64::INFINITY;
    }
    let (mut x, mut y, mut z) = (x, y, z);
    loop {
        let mean = (x + y + z) / 3.0;
        let (dx, dy, dz) = (1.0 - x / mean, 1.0 - y / mean, 1.0 - z / mean);
        if dx.abs().max(dy.abs()).max(dz.abs()) < CONVERGED || !mean.is_finite() {
            let (e2, e3) = (dx * dy - dz * dz, dx * dy * dz);
            let series = 1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 * e2 * e3 / 44.0 - 5.0 * e2.powi(3) / 208.0
                + 3.0 * e3 * e3 / 104.0
                + e2 * e2 * e3 / 16.0;
            return series / mean.sqrt();
        }
        let (sx, sy, sz) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = sx * sy + sy * sz + sz * sx;
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
    }
}

/// R_D(x, y, z) = 3/2 int_0^inf dt / ((t + z) sqrt((t + x)(t + y)(t + z))), at most one of x and y zero, z > 0.
///
/// Relative error about 1e-15. Infinite when z or both x and y are zero, NaN when one is negative.
///
/// ```
/// use contact_patch::closed_form::r_d;
/// assert!((r_d(0.0, 1.0, 1.0) - 0.75 * std::f64::consts::PI).abs() < 1e-14);
/// ```
#[must_use]
pub fn r_d(x: f64, y: f64, z: f64) -> f64 {
    if !(x >= 0.0 && y >= 0.0 && z >= 0.0) {
        return f64::NAN;
    }
    if z == 0.0 || (x == 0.0 && y == 0.0) {
        return f64::INFINITY;
    }
    let (mut x, mut y, mut z) = (x, y, z);
    let (mut sum, mut scale) = (0.0, 1.0);
    loop {
        let mean = (x + y + 3.0 * z) / 5.0;
        let (dx, dy, dz) = (1.0 - x / mean, 1.0 - y / mean, 1.0 - z / mean);
        if dx.abs().max(dy.abs()).max(dz.abs()) < CONVERGED || !mean.is_finite() {
            let (xy, zz) = (dx * dy, dz * dz);
            let (e2, e3, e4, e5) = (xy - 6.0 * zz, (3.0 * xy - 8.0 * zz) * dz, 3.0 * (xy - zz) * zz, xy * zz * dz);
            let series =
                1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0 - 3.0 * e4 / 22.0 - 9.0 * e2 * e3 / 52.0
                    + 3.0 * e5 / 26.0
                    - e2.powi(3) / 16.0
                    + 3.0 * e3 * e3 / 40.0
                    + 3.0 * e2 * e4 / 20.0
                    + 45.0 * e2 * e2 * e3 / 272.0
                    - 9.0 * (e3 * e4 + e2 * e5) / 68.0;
            return 3.0 * sum + scale * series / (mean * mean.sqrt());
        }
        let (sx, sy, sz) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = sx * sy + sy * sz + sz * sx;
        sum += scale / (sz * (z + lambda));
        scale *= 0.25;
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn tabulated_values() {
        // Arguments of Carlson, Numer. Algorithms 10 (1995), section 3; digits by mpmath 1.3 (elliprf, elliprd).
        assert_relative_eq!(r_f(1.0, 2.0, 0.0), 1.311_028_777_146_059_9, max_relative = 2e-15);
        assert_relative_eq!(r_f(2.0, 3.0, 4.0), 0.584_082_841_677_151_7, max_relative = 2e-15);
        assert_relative_eq!(r_d(0.0, 2.0, 1.0), 1.797_210_352_103_388_3, max_relative = 2e-15);
        assert_relative_eq!(r_d(2.0, 3.0, 4.0), 0.165_105_272_942_610_53, max_relative = 2e-15);
    }

    #[test]
    fn homogeneous_and_connected() {
        for k2 in [1e-24, 1e-12, 1e-3, 0.3, 1.0] {
            assert_relative_eq!(r_f(0.0, 4.0 * k2, 4.0), 0.5 * r_f(0.0, k2, 1.0), max_relative = 4e-15);
            assert_relative_eq!(r_d(0.0, 4.0 * k2, 4.0), 0.125 * r_d(0.0, k2, 1.0), max_relative = 4e-15);
            // K = (K - E)/e^2 + (E - k^2 K)/e^2, each by its own R_D.
            let sum = r_d(0.0, k2, 1.0) + k2 * r_d(0.0, 1.0, k2);
            assert_relative_eq!(sum, 3.0 * r_f(0.0, k2, 1.0), max_relative = 1e-14);
        }
    }
}
