//! The cubic with given values and slopes at both ends of an interval, after Hermite.

/// A place in an interval, as a share `t` of its length `h`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cubic {
    pub t: f64,
    pub h: f64,
}

impl Cubic {
    /// The n-th derivative, up to the second, of the cubic with [value, slope] at both ends.
    pub fn value(self, n: usize, a: [f64; 2], b: [f64; 2]) -> f64 {
        let Self { t, h } = self;
        let rise = b[0] - a[0];
        match n {
            0 => a[0] + t * t * (3.0 - 2.0 * t) * rise + h * t * (1.0 - t) * ((1.0 - t) * a[1] - t * b[1]),
            1 => 6.0 * t * (1.0 - t) * rise / h + (1.0 - t) * (1.0 - 3.0 * t) * a[1] + t * (3.0 * t - 2.0) * b[1],
            _ => 6.0 * (1.0 - 2.0 * t) * rise / (h * h) + ((6.0 * t - 4.0) * a[1] + (6.0 * t - 2.0) * b[1]) / h,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_and_their_derivatives() {
        let (h, p) = (0.7, |x: f64| [1.0 + x * (2.0 + x * (3.0 - x)), 2.0 + x * (6.0 - 3.0 * x), 6.0 - 6.0 * x]);
        for t in [0.0, 0.3, 1.0] {
            for (n, truth) in p(h * t).into_iter().enumerate() {
                let (a, b) = (p(0.0), p(h));
                let own = Cubic { t, h }.value(n, [a[0], a[1]], [b[0], b[1]]);
                assert!((own - truth).abs() < 1e-12, "{n} at {t}: {own} {truth}");
            }
        }
    }
}
