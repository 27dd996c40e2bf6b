//! Integrals of one variable: Gauss-Legendre, adaptive Gauss-Kronrod, double exponential. Each gives its error.

use std::f64::consts::{FRAC_PI_2, PI};

/// The value of an integral, and how far it may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integral {
    /// The integral.
    pub value: f64,
    /// Estimate of the absolute error, rounding included.
    pub error: f64,
    /// How often the integrand was evaluated.
    pub evaluations: usize,
}

impl Integral {
    /// Nothing.
    pub const ZERO: Self = Self { value: 0.0, error: 0.0, evaluations: 0 };

    /// Both together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            error: self.error + other.error,
            evaluations: self.evaluations + other.evaluations,
        }
    }

    /// The same integrand times a constant.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { value: factor * self.value, error: factor.abs() * self.error, ..self }
    }

    /// Error over value; infinite when the value is zero or not finite and the error is not zero.
    #[must_use]
    pub fn relative_error(&self) -> f64 {
        if self.error == 0.0 {
            0.0
        } else if self.value == 0.0 {
            f64::INFINITY
        } else {
            self.error / self.value.abs()
        }
    }
}

/// The Gauss-Legendre rule of n points on [-1, 1], exact to degree 2n - 1.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussLegendre {
    nodes: Vec<(f64, f64)>,
}

impl GaussLegendre {
    /// The rule of n points, n >= 1 (0 counts as 1). Newton's method on P_n from Tricomi's guess.
    ///
    /// ```
    /// use contact_patch::quadrature::GaussLegendre;
    /// let rule = GaussLegendre::new(8);
    /// let integral = rule.integrate(f64::exp, 0.0, 1.0);
    /// assert!((integral.value - 1f64.exp_m1()).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn new(n: usize) -> Self {
        let n = n.max(1);
        let node = |i: usize| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..20 {
                let (p, dp) = legendre(n, x);
                slope = dp;
                let step = p / dp;
                x -= step;
                if step.abs() <= 1e-16 {
                    slope = legendre(n, x).1;
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x) * (1.0 + x) * slope * slope))
        };
        let mut nodes: Vec<_> = (0..n).map(node).collect();
        if n % 2 == 1 {
            nodes[n / 2].0 = 0.0;
        }
        nodes.reverse();
        Self { nodes }
    }

    /// (node, weight) on [-1, 1], nodes increasing.
    #[must_use]
    pub fn nodes(&self) -> &[(f64, f64)] {
        &self.nodes
    }

    /// The integral of f over [a, b] by this rule; the error is the difference to the rule over the two halves,
    /// whose (better) value is returned.
    pub fn integrate(&self, f: impl Fn(f64) -> f64, a: f64, b: f64) -> Integral {
        let middle = 0.5 * (a + b);
        let whole = self.sum(&f, a, b);
        let halves = self.sum(&f, a, middle) + self.sum(&f, middle, b);
        let error = (whole - halves).abs() + f64::EPSILON * halves.abs();
        Integral { value: halves, error, evaluations: 3 * self.nodes.len() }
    }

    /// The bare sum of the rule over [a, b], without an error.
    pub fn sum(&self, f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
        let (centre, half) = (0.5 * (a + b), 0.5 * (b - a));
        half * self.nodes.iter().map(|(x, w)| w * f(centre + half * x)).sum::<f64>()
    }
}

/// P_n(x) and its derivative by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut p) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
    }
    (p, n as f64 * (before - x * p) / ((1.0 - x) * (1.0 + x)))
}

/// Positive abscissae of the 21-point Kronrod rule with its weights and those of the 10-point Gauss rule in it
/// (QUADPACK, Piessens et al. 1983).
const KRONROD: [(f64, f64, f64); 11] = [
    (0.995_657_163_025_808_1, 0.011_694_638_867_371_874, 0.0),
    (0.973_906_528_517_171_7, 0.032_558_162_307_964_725, 0.066_671_344_308_688_14),
    (0.930_157_491_355_708_2, 0.054_755_896_574_351_995, 0.0),
    (0.865_063_366_688_984_5, 0.075_039_674_810_919_96, 0.149_451_349_150_580_6),
    (0.780_817_726_586_416_9, 0.093_125_454_583_697_6, 0.0),
    (0.679_409_568_299_024_4, 0.109_387_158_802_297_64, 0.219_086_362_515_982_04),
    (0.562_757_134_668_604_7, 0.123_491_976_262_065_84, 0.0),
    (0.433_395_394_129_247_2, 0.134_709_217_311_473_34, 0.269_266_719_309_996_35),
    (0.294_392_862_701_460_2, 0.142_775_938_577_060_09, 0.0),
    (0.148_874_338_981_631_22, 0.147_739_104_901_338_5, 0.295_524_224_714_752_87),
    (0.0, 0.149_445_554_002_916_9, 0.0),
];

/// One panel by Gauss-Kronrod (10, 21). The error is QUADPACK's: (200 |G - K|)^1.5 in units of the mean deviation
/// of f, which is what |G - K| of the lower rule says about the higher one, and never less than rounding.
fn kronrod(f: &mut impl FnMut(f64) -> f64, a: f64, b: f64) -> Integral {
    let (centre, half) = (0.5 * (a + b), 0.5 * (b - a));
    let mut values = [[0.0; 2]; 11];
    let (mut fine, mut coarse, mut size) = (0.0, 0.0, 0.0);
    for (value, (x, w, v)) in values.iter_mut().zip(KRONROD) {
        *value = if x == 0.0 { [f(centre), 0.0] } else { [f(centre - half * x), f(centre + half * x)] };
        let both = value[0] + value[1];
        fine += w * both;
        coarse += v * both;
        size += w * (value[0].abs() + value[1].abs());
    }
    let mean = 0.5 * fine;
    let spread: f64 = values
        .iter()
        .zip(KRONROD)
        .map(|(v, (x, w, _))| w * ((v[0] - mean).abs() + if x == 0.0 { 0.0 } else { (v[1] - mean).abs() }))
        .sum();
    let half = half.abs();
    let difference = (fine - coarse).abs();
    let error = if spread > 0.0 { spread * (200.0 * difference / spread).powf(1.5).min(1.0) } else { difference };
    let value = if b < a { -fine * half } else { fine * half };
    let error = half * error.max(2.0 * f64::EPSILON * size);
    Integral { value, error: if value.is_finite() { error } else { f64::INFINITY }, evaluations: 21 }
}

/// Most panels that [`adaptive`] splits an interval into.
const PANELS: usize = 200;

/// Halvings that neither change the integral nor lessen its error, after which the rest is the rounding of f (QUADPACK).
const USELESS: usize = 8;

/// The integral of f over [a, b], the panel with the largest error halved until the sum of errors is below
/// `tolerance` times the integral of |f| is reached, rounding stops it, or there are 200 panels. f is never
/// evaluated at a or b. `breaks` are points between which f is smooth; those outside (a, b) are ignored.
///
/// ```
/// use contact_patch::quadrature::adaptive;
/// let integral = adaptive(|x: f64| (x - 0.3).abs(), 0.0, 1.0, &[0.3], 1e-12);
/// assert!((integral.value - 0.29).abs() < 1e-15 && integral.error < 1e-12);
/// ```
pub fn adaptive(mut f: impl FnMut(f64) -> f64, a: f64, b: f64, breaks: &[f64], tolerance: f64) -> Integral {
    let mut ends: Vec<f64> = breaks.iter().copied().filter(|&x| (x - a) * (x - b) < 0.0).collect();
    ends.push(b);
    ends.sort_by(|p, q| (p - a).abs().total_cmp(&(q - a).abs()));
    let mut panels = Vec::with_capacity(ends.len());
    let mut from = a;
    for to in ends {
        panels.push((from, to, kronrod(&mut f, from, to)));
        from = to;
    }
    let mut evaluations = 21 * panels.len();
    let mut useless = 0;
    loop {
        let total = panels.iter().fold(Integral::ZERO, |sum, (_, _, part)| sum.plus(*part));
        let size: f64 = panels.iter().map(|(_, _, part)| part.value.abs()).sum();
        let worst = (0..panels.len()).max_by(|&i, &j| panels[i].2.error.total_cmp(&panels[j].2.error));
        let Some(worst) = worst else { return Integral::ZERO };
        let (p, q, part) = panels[worst];
        let middle = 0.5 * (p + q);
        // A panel at its own rounding cannot get better by halving.
        let at_rounding = part.error <= 4.0 * f64::EPSILON * part.value.abs() || middle == p || middle == q;
        let full = panels.len() >= PANELS + breaks.len() || useless >= USELESS;
        if total.error <= tolerance * size || at_rounding || full {
            return Integral { evaluations, ..total };
        }
        let halves = [kronrod(&mut f, p, middle), kronrod(&mut f, middle, q)];
        let both = halves[0].plus(halves[1]);
        if (both.value - part.value).abs() <= 1e-10 * both.value.abs() && both.error >= 0.99 * part.error {
            useless += 1;
        }
        panels[worst] = (p, middle, halves[0]);
        panels.push((middle, q, halves[1]));
        evaluations += 42;
    }
}

/// Finest step of [`double_exponential`] is 2^-DEEPEST.
const DEEPEST: u32 = 7;

/// The integral of f over (0, b), where f may be singular at 0 like x^s, s > -1: the tanh-sinh rule (Takahasi & Mori
/// 1974), step halved until two results agree to `tolerance`. Abscissae near 0 keep all their digits, which s near -1
/// needs. The error is that of the last halving but one, squared, as the rule converges; never less than rounding.
///
/// ```
/// use contact_patch::quadrature::double_exponential;
/// let integral = double_exponential(|x: f64| x.powf(-0.9), 1.0, 1e-13);
/// assert!((integral.value - 10.0).abs() < 1e-11);
/// ```
pub fn double_exponential(mut f: impl FnMut(f64) -> f64, b: f64, tolerance: f64) -> Integral {
    // x = b / (1 + exp(-pi sinh t)), dx/dt = x (1 - x/b) pi cosh t; t from -6.1 reaches x = 1e-304 b.
    let mut evaluations = 0;
    let mut term = |t: f64| {
        let e = (-2.0 * FRAC_PI_2 * t.sinh()).exp();
        let x = b / (1.0 + e);
        let weight = x * (e / (1.0 + e)) * PI * t.cosh();
        if !(x > 0.0 && x < b && weight > 0.0) {
            return 0.0;
        }
        evaluations += 1;
        let value = weight * f(x);
        if value.is_nan() { f64::INFINITY } else { value }
    };
    let (low, high) = (-6.1_f64, 3.2_f64);
    let mut step = 0.5;
    let mut sum = 0.0;
    let mut size = 0.0;
    let mut add = |from: f64, by: f64, sum: &mut f64, size: &mut f64| {
        let mut k = (low - from).div_euclid(by) + 1.0;
        while from + k * by < high {
            let value = term(from + k * by);
            *sum += value;
            *size += value.abs();
            k += 1.0;
        }
    };
    add(0.0, step, &mut sum, &mut size);
    let mut value = step * sum;
    let mut error = f64::INFINITY;
    for _ in 0..DEEPEST {
        add(0.5 * step, step, &mut sum, &mut size);
        step *= 0.5;
        let finer = step * sum;
        let (scale, change) = (step * size, (finer - value).abs());
        value = finer;
        let converging =
            if error.is_finite() { change * (change / scale).max(change / error).min(1.0) } else { change };
        error = change;
        if converging <= tolerance * scale || !value.is_finite() {
            error = converging;
            break;
        }
    }
    let error = if value.is_finite() { error.max(4.0 * f64::EPSILON * step * size) } else { f64::INFINITY };
    Integral { value, error, evaluations }
}

/// The integral of f over (0, b), b > 0, when f is smooth but perhaps not at 0: one Gauss-Kronrod panel where that is
/// enough, else [`double_exponential`], else (a kink that nobody named) [`adaptive`].
pub fn from_zero(mut f: impl FnMut(f64) -> f64, b: f64, tolerance: f64) -> Integral {
    let panel = kronrod(&mut f, 0.0, b);
    if panel.error <= tolerance * panel.value.abs() || b == 0.0 {
        return panel;
    }
    let singular = double_exponential(&mut f, b, tolerance);
    let evaluations = panel.evaluations + singular.evaluations;
    // The rounding of the double exponential rule is somewhat above that of the others.
    if singular.error <= tolerance.max(1e-14) * singular.value.abs() {
        return Integral { evaluations, ..singular };
    }
    let split = adaptive(&mut f, 0.0, b, &[], tolerance);
    let evaluations = evaluations + split.evaluations;
    if split.error < singular.error { Integral { evaluations, ..split } } else { Integral { evaluations, ..singular } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_is_exact_to_its_degree() {
        for n in 1..40 {
            let rule = GaussLegendre::new(n);
            let degree = 2 * n as i32 - 1;
            let value = rule.sum(|x| x.powi(degree) + x.powi(degree - 1), 0.0, 1.0);
            let exact = 1.0 / f64::from(degree + 1) + 1.0 / f64::from(degree);
            assert!((value / exact - 1.0).abs() < 2e-14, "{n}: {value} {exact}");
            assert!(rule.nodes().windows(2).all(|w| w[0].0 < w[1].0));
        }
    }

    #[test]
    fn adaptive_reports_an_error_that_holds() {
        type Case = (fn(f64) -> f64, f64);
        let cases: [Case; 5] = [
            (f64::exp, std::f64::consts::E - 1.0),
            (f64::sqrt, 2.0 / 3.0),
            (|x| -x.ln(), 1.0),
            (|x| 1.0 / (1e-4 + (x - 0.5).powi(2)), 200.0 * 50f64.atan()),
            (|x| (x - std::f64::consts::FRAC_1_PI).signum(), 1.0 - 2.0 * std::f64::consts::FRAC_1_PI),
        ];
        for (k, (f, exact)) in cases.into_iter().enumerate() {
            let integral = adaptive(f, 0.0, 1.0, &[], 1e-12);
            let off = (integral.value - exact).abs();
            assert!(off <= integral.error && off < 2e-12 * exact, "{k}: off {off:e}, said {:e}", integral.error);
        }
    }

    #[test]
    fn double_exponential_takes_strong_singularities() {
        // Larger s only magnify the rounding of x.
        for s in [-0.95, -0.9, -0.5, 0.0, 0.3, 4.0, 10.0] {
            let integral = double_exponential(|x| x.powf(s), 2.0, 1e-14);
            let exact = 2f64.powf(s + 1.0) / (s + 1.0);
            assert!((integral.value / exact - 1.0).abs() < 2e-13, "{s}: {integral:?} {exact}");
            assert!((integral.value - exact).abs() <= 2.0 * integral.error, "{s}: {integral:?} {exact}");
        }
    }

    #[test]
    fn an_integral_that_does_not_exist_says_so() {
        assert!(adaptive(|x| 1.0 / x, 0.0, 1.0, &[], 1e-10).relative_error() > 1e-10);
        assert!(double_exponential(|_| f64::NAN, 1.0, 1e-10).error.is_infinite());
    }
}
