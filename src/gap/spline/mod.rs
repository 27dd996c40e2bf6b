//! Cubic splines through measured values, and smoothing ones: what profiles and height maps are made of.

pub(super) mod bernstein;
mod piecewise;
mod smoothing;

pub(super) use piecewise::PiecewiseCubic;
pub(super) use smoothing::{runs, smoothed, smoothed_grid};

/// What is asked of a spline at its two ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    /// One cubic over the first two and the last two steps: fourth order up to the ends.
    NotAKnot,
    /// No curvature: the smoothing spline's own condition.
    Natural,
}

/// Slopes at the knots of the cubic spline through these values; a parabola through three, a line through two.
///
/// De Boor, *A Practical Guide to Splines* (2001), chapter IV, equations (9) to (15): continuity of the second derivative.
pub(super) fn slopes(knots: &[f64], values: &[f64], ends: Ends) -> Vec<f64> {
    let n = knots.len();
    let step = |k: usize| knots[k + 1] - knots[k];
    let rise = |k: usize| (values[k + 1] - values[k]) / step(k);
    match (n, ends) {
        (0 | 1, _) => return vec![0.0; n],
        (2, _) => return vec![rise(0); 2],
        (3, Ends::NotAKnot) => {
            let (h, g) = (step(0), step(1));
            let bend = (rise(1) - rise(0)) / (h + g);
            return vec![rise(0) - bend * h, rise(0) + bend * h, rise(1) + bend * g];
        }
        _ => {}
    }
    // Rows (lower, diagonal, upper, right side), eliminated on the way down.
    let row = |k: usize| -> [f64; 4] {
        let end = |h: f64, g: f64, d: f64, e: f64| match ends {
            Ends::NotAKnot => [g, h + g, ((h + 2.0 * (h + g)) * g * d + h * h * e) / (h + g)],
            Ends::Natural => [2.0, 1.0, 3.0 * d],
        };
        if k == 0 {
            let [diagonal, upper, right] = end(step(0), step(1), rise(0), rise(1));
            [0.0, diagonal, upper, right]
        } else if k == n - 1 {
            let [diagonal, lower, right] = end(step(n - 2), step(n - 3), rise(n - 2), rise(n - 3));
            [lower, diagonal, 0.0, right]
        } else {
            let (h, g) = (step(k - 1), step(k));
            [g, 2.0 * (h + g), h, 3.0 * (g * rise(k - 1) + h * rise(k))]
        }
    };
    let (mut upper, mut found) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for k in 0..n {
        let [a, b, c, d] = row(k);
        let (before, last) = if k == 0 { (0.0, 0.0) } else { (upper[k - 1], found[k - 1]) };
        let pivot: f64 = b - a * before;
        upper.push(c / pivot);
        found.push((d - a * last) / pivot);
    }
    for k in (0..n - 1).rev() {
        found[k] -= upper[k] * found[k + 1];
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOTS: [f64; 7] = [-1.0, -0.7, 0.1, 0.4, 1.3, 1.5, 2.0];

    #[test]
    fn a_cubic_is_its_own_spline() {
        let (f, df) = (|x: f64| x * x * x - 2.0 * x, |x: f64| 3.0 * x * x - 2.0);
        let found = slopes(&KNOTS, &KNOTS.map(f), Ends::NotAKnot);
        assert!(found.iter().zip(KNOTS).all(|(s, x)| (s - df(x)).abs() < 1e-13), "{found:?}");
        let three = slopes(&KNOTS[..3], &KNOTS.map(|x| x * x)[..3], Ends::NotAKnot);
        assert!(three.iter().zip(KNOTS).all(|(s, x)| (s - 2.0 * x).abs() < 1e-13), "{three:?}");
    }

    #[test]
    fn a_natural_spline_ends_straight_and_has_one_curvature_at_each_knot() {
        let values = KNOTS.map(|x: f64| (3.0 * x).sin());
        let found = slopes(&KNOTS, &values, Ends::Natural);
        let bend = |k: usize, at_end: bool| {
            let h = KNOTS[k + 1] - KNOTS[k];
            let b = bernstein::cubic([values[k], values[k + 1]], [found[k] * h, found[k + 1] * h]);
            bernstein::value(&bernstein::curvature(&b), if at_end { 1.0 } else { 0.0 }) / (h * h)
        };
        assert!(bend(0, false).abs() < 1e-12 && bend(5, true).abs() < 1e-12);
        for k in 0..5 {
            assert!((bend(k, true) - bend(k + 1, false)).abs() < 1e-11);
        }
    }
}
