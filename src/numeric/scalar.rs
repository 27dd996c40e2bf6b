//! Roots and maxima of one variable, by brackets that only shrink. Each gives the bracket it ended with.

/// A root: where it is, and between which neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root {
    /// The end of the bracket with the smaller |f|.
    pub at: f64,
    /// f changes sign between these two.
    pub bracket: [f64; 2],
    /// How often f was evaluated.
    pub evaluations: usize,
}

/// More steps than bisection of any bracket of floats takes when every third step halves it.
const STEPS: usize = 3 * 1100;

/// The root of f in [a, b] to the last digit, by Chandrupatla's method (Adv. Eng. Software 28, 1997): inverse quadratic
/// interpolation where it is safe, bisection where not. `None` when f has the same sign (or NaN) at both ends.
///
/// ```
/// use contact_patch::scalar::root;
/// let found = root(|x| x * x - 2.0, 0.0, 2.0).unwrap();
/// assert!((found.at - 2f64.sqrt()).abs() < 1e-15);
/// ```
pub fn root(mut f: impl FnMut(f64) -> f64, a: f64, b: f64) -> Option<Root> {
    let (mut a, mut b) = (a, b);
    let (mut fa, mut fb) = (f(a), f(b));
    let mut evaluations = 2;
    if fa == 0.0 || fb == 0.0 {
        let at = if fa == 0.0 { a } else { b };
        return Some(Root { at, bracket: [at, at], evaluations });
    }
    if !(fa < 0.0 && fb > 0.0 || fa > 0.0 && fb < 0.0) {
        return None;
    }
    let mut t = 0.5;
    for _ in 0..STEPS {
        let x = a + t * (b - a);
        let fx = f(x);
        evaluations += 1;
        // (c, fc): the point that leaves the bracket.
        let (c, fc);
        if (fx < 0.0) == (fa < 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc) = (b, fb);
            (b, fb) = (a, fa);
        }
        (a, fa) = (x, fx);
        let (best, f_best) = if fa.abs() < fb.abs() { (a, fa) } else { (b, fb) };
        // Half the width in which floats near the root can be told apart.
        let share = 2.0 * f64::EPSILON * best.abs() / (b - a).abs();
        if f_best == 0.0 || share > 0.5 || a == b || fx.is_nan() {
            return Some(Root { at: best, bracket: [a.min(b), a.max(b)], evaluations });
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        let inverse_quadratic = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
        t = if inverse_quadratic {
            fa / (fb - fa) * (fc / (fb - fc)) + (c - a) / (b - a) * (fa / (fc - fa)) * (fb / (fc - fb))
        } else {
            0.5
        };
        t = t.clamp(share, 1.0 - share);
    }
    Some(Root { at: if fa.abs() < fb.abs() { a } else { b }, bracket: [a.min(b), a.max(b)], evaluations })
}

/// Where a condition that holds at `low` and not at `high` ceases to hold, to the last digit by halving; the side on which it holds.
pub(crate) fn last(holds: impl Fn(f64) -> bool, mut low: f64, mut high: f64) -> f64 {
    while high - low > f64::EPSILON * high.abs() {
        let middle = 0.5 * (low + high);
        // Neighbours among the numbers, which below the least normal one are far apart.
        if !(low < middle && middle < high) {
            break;
        }
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// A maximum: where it is, how high, and between which neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Maximum {
    /// The best point seen.
    pub at: f64,
    /// f there.
    pub value: f64,
    /// A local maximum of f lies between these two.
    pub bracket: [f64; 2],
}

/// Golden sections to 1e-8 of the start; a bracket of a few subnormal numbers would never come so far.
const GOLDEN_STEPS: usize = 39;

/// The largest of `samples` + 1 equidistant values of f on [a, b], sharpened between its neighbours by golden sections
/// until the bracket is 1e-8 of its start: f is then known to rounding where it is smooth. A peak narrower than the
/// spacing of the samples can be missed.
///
/// ```
/// use contact_patch::scalar::maximum;
/// let found = maximum(|x: f64| x.sin(), 0.0, 4.0, 8);
/// assert!((found.value - 1.0).abs() < 1e-15);
/// ```
pub fn maximum(mut f: impl FnMut(f64) -> f64, a: f64, b: f64, samples: usize) -> Maximum {
    let n = samples.max(2);
    let point = |k: usize| a + (b - a) * k as f64 / n as f64;
    let (mut k, mut best) = (0, (a, f(a)));
    for j in 1..=n {
        let value = f(point(j));
        if value > best.1 {
            (k, best) = (j, (point(j), value));
        }
    }
    let (mut low, mut high) = (point(k.saturating_sub(1)), point((k + 1).min(n)));
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut left = high - golden * (high - low);
    let mut right = low + golden * (high - low);
    let (mut f_left, mut f_right) = (f(left), f(right));
    for _ in 0..GOLDEN_STEPS {
        for (x, value) in [(left, f_left), (right, f_right)] {
            if value > best.1 {
                best = (x, value);
            }
        }
        if f_left > f_right {
            (high, right, f_right) = (right, left, f_left);
            left = high - golden * (high - low);
            f_left = f(left);
        } else {
            (low, left, f_left) = (left, right, f_right);
            right = low + golden * (high - low);
            f_right = f(right);
        }
    }
    Maximum { at: best.0, value: best.1, bracket: [low.min(high), low.max(high)] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_maximum_among_subnormal_numbers_is_found() {
        let found = maximum(|x| -x, 0.0, 3.0 * f64::from_bits(1), 8);
        assert_eq!((found.at, found.value), (0.0, 0.0));
    }

    #[test]
    fn roots_to_the_last_digit_in_few_steps() {
        for (k, target) in [1e-300, 1e-12, 0.1, 0.5, 0.999_999, 1.0].into_iter().enumerate() {
            let found = root(|x| x * x * x - target, 0.0, 1.0).unwrap();
            assert!((found.at / f64::cbrt(target) - 1.0).abs() < 1e-15, "{k}: {found:?}");
            assert!(found.evaluations < 400);
        }
        let found = root(|x: f64| x.exp() - 2.0, 0.0, 1.0).unwrap();
        assert!(found.evaluations < 14, "{found:?}");
    }

    #[test]
    fn no_sign_change_is_no_root() {
        assert!(root(|x| x * x + 1.0, -1.0, 1.0).is_none());
        assert!(root(|_| f64::NAN, -1.0, 1.0).is_none());
    }

    #[test]
    fn a_maximum_at_an_end_is_found() {
        assert!((maximum(|x| x, 0.0, 3.0, 5).value - 3.0).abs() < 1e-15);
        assert!((maximum(|x| -x, 0.0, 3.0, 5).at).abs() < 1e-15);
    }
}
