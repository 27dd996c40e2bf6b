//! The displacement of a disc under unit pressure, E* = 1, and its slope.
//!
//! With k the ratio of the smaller to the larger of the distance rho from the axis and the radius a:
//!
//! ```text
//! rho <= a:  u = 4 a/pi E(k),                          du/drho = 4/pi (E(k) - K(k))/k
//! rho >= a:  u = 4 rho/pi (E(k) - (1 - k^2) K(k)),     du/drho = 4/pi (E(k) - K(k))
//! ```

use std::f64::consts::{FRAC_PI_2, PI};

/// K(k) and K(k) - E(k) from the complementary modulus k' (0 < k' <= 1), by the arithmetic-geometric mean:
/// K = pi/(2 agm(1, k')), K - E = K sum of 2^(n-1) c_n^2 (DLMF 19.8.5-6).
fn elliptic(k: f64, complement: f64) -> [f64; 2] {
    let (mut a, mut b) = (1.0, complement);
    let mut sum = 0.5 * k * k;
    let mut weight = 0.5;
    for _ in 0..40 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        weight *= 2.0;
        sum += weight * c * c;
        if c.abs() <= 1e-9 * a {
            break;
        }
    }
    // One more step of the mean: quadratic convergence.
    let first = FRAC_PI_2 / (0.5 * (a + b));
    [first, first * sum]
}

/// u and du/drho at `rho` of the unit pressure on the disc of radius `a` > 0, given rho - a (which may be known better than
/// the difference). The slope is infinite at rho = a.
pub(crate) fn disc(rho: f64, a: f64, beyond: f64) -> [f64; 2] {
    if a == 0.0 {
        return [0.0; 2];
    }
    if rho == 0.0 {
        return [2.0 * a, 0.0];
    }
    let (small, large) = if beyond < 0.0 { (rho, a) } else { (a, rho) };
    let k = small / large;
    let complement = ((rho + a) * beyond.abs()).sqrt() / large;
    if complement == 0.0 {
        return [4.0 * a / PI, f64::NEG_INFINITY];
    }
    let [first, difference] = elliptic(k, complement);
    let second = first - difference;
    if beyond < 0.0 {
        [4.0 * a / PI * second, -4.0 / PI * difference / k]
    } else {
        [4.0 * rho / PI * (second - complement * complement * first), -4.0 / PI * difference]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_slopes() {
        assert!((disc(0.0, 0.7, -0.7)[0] - 1.4).abs() < 1e-15);
        // Far away: area/(pi rho) (1 + 1/8 (a/rho)^2 + ...).
        let far = disc(50.0, 1.0, 49.0)[0];
        assert!((far / (1.0 / 50.0) - 1.0 - 0.125 / 2500.0).abs() < 1e-7);
        for (rho, a) in [(0.3, 1.0), (0.99, 1.0), (1.01, 1.0), (3.0, 1.0), (0.2, 0.25)] {
            let h = 1e-6;
            let u = |r: f64| disc(r, a, r - a)[0];
            let slope = (u(rho + h) - u(rho - h)) / (2.0 * h);
            assert!((slope - disc(rho, a, rho - a)[1]).abs() < 2e-9, "{rho} {a}");
        }
        // int of u over the disc itself: 8 a^3 2/3.
        let n = 20000;
        let sum: f64 = (0..n)
            .map(|i| {
                let r = (i as f64 + 0.5) / n as f64;
                2.0 * PI * r * disc(r, 1.0, r - 1.0)[0] / n as f64
            })
            .sum();
        assert!((sum - 16.0 / 3.0).abs() < 1e-7);
    }
}
