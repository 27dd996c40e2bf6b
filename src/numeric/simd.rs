//! Loops compiled for the widest vector unit of the machine, and a product and a logarithm that such loops can inline.

/// A loop to be compiled for several machines: `run` and all that it calls are `#[inline(always)]`.
pub(crate) trait Kernel {
    /// What it returns.
    type Output;
    /// The loop.
    fn run(self) -> Self::Output;
}

struct Dispatched<K>(K);

impl<K: Kernel> pulp::NullaryFnOnce for Dispatched<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run()
    }
}

/// Runs a kernel compiled for the widest vector unit that the machine has.
#[inline]
pub(crate) fn vectorised<K: Kernel>(kernel: K) -> K::Output {
    pulp::Arch::new().dispatch(Dispatched(kernel))
}

/// Does plain loops over slices with the widest vector unit that the machine has.
#[inline]
pub(crate) fn wide<R>(loops: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(loops)
}

/// a . b, in eight sums side by side.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (mut sums, whole) = ([0.0; 8], a.len() / 8 * 8);
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + a[whole..].iter().zip(&b[whole..]).map(|(a, b)| a * b).sum::<f64>()
}

const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// ln(a/b) of positive normal numbers, without branches, with one division. Error below 2 units in the last place of the result.
///
/// The coefficients of fdlibm's `e_log.c` (Sun Microsystems 1993): x = 2^k (1 + f), s = f/(2 + f), ln(1 + f) = 2 s + s R(s^2). Here
/// s = (a - b)/(a + b) with a scaled by a power of two: where the difference of the mantissas, for that of their logarithms, leaves
/// |s| > 0.1716, beyond which R is not good, by one more.
#[inline(always)]
pub(crate) fn ln_ratio(a: f64, b: f64) -> f64 {
    let shifted = a.to_bits().wrapping_sub(b.to_bits()).wrapping_add((1023 << 52) + (1 << 51));
    let exponent = shifted >> 52;
    // An integer below 2^52 placed in the mantissa of 2^52.
    let k = f64::from_bits(exponent | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + 1023.0);
    let a = f64::from_bits(a.to_bits().wrapping_sub(exponent << 52).wrapping_add(1023 << 52));
    let (above, below) = (a > std::f64::consts::SQRT_2 * b, a < std::f64::consts::FRAC_1_SQRT_2 * b);
    let factor = if above { 0.5 } else { 1.0 } * if below { 2.0 } else { 1.0 };
    let step = if above { 1.0 } else { 0.0 } - if below { 1.0 } else { 0.0 };
    let (a, k) = (a * factor, k + step);
    let s = (a - b) / (a + b);
    let s2 = s * s;
    let s4 = s2 * s2;
    let even = s4 * (0.399_999_999_994_094_2 + s4 * (0.222_221_984_321_497_84 + s4 * 0.153_138_376_992_093_73));
    let odd = s2
        * (0.666_666_666_666_673_5
            + s4 * (0.285_714_287_436_623_9 + s4 * (0.181_835_721_616_180_5 + s4 * 0.147_981_986_051_165_86)));
    k * LN2_HIGH + (2.0 * s + (s * (even + odd) + k * LN2_LOW))
}

/// 2 artanh(x) = ln((1 + x)/(1 - x)) for |x| <= 1/3. Error below 2 units in the last place.
///
/// 2 x + x^3 Q(x^2), Q through 2 (artanh(x) - x)/x^3 at the ten Chebyshev nodes of x^2 on [0, 1/9].
#[inline(always)]
pub(crate) fn twice_artanh(x: f64) -> f64 {
    let z = x * x;
    let z2 = z * z;
    let even = 0.666_666_666_666_666_6
        + z2 * (0.285_714_285_671_087_6
            + z2 * (0.181_817_894_361_328_6 + z2 * (0.133_141_442_096_549_35 + z2 * 0.088_007_384_861_446_74)));
    let odd = 0.400_000_000_000_145_85
        + z2 * (0.222_222_227_174_278_64
            + z2 * (0.153_855_700_649_586_23 + z2 * (0.120_010_728_095_907_13 + z2 * 0.161_640_456_119_435_3)));
    2.0 * x + x * z * (even + z * odd)
}

#[cfg(test)]
mod tests {
    use super::{ln_ratio, twice_artanh};

    #[test]
    fn artanh_agrees_with_the_library() {
        for i in 1..=10_000 {
            let x = f64::from(i) / 30_000.0;
            let exact = x.ln_1p() - (-x).ln_1p();
            assert!((twice_artanh(x) - exact).abs() <= 6e-16 * exact, "{x} {} {exact}", twice_artanh(x));
            assert_eq!(twice_artanh(-x), -twice_artanh(x));
        }
    }

    #[test]
    fn agrees_with_the_library() {
        let mut x = 1e-280_f64;
        while x < 1e-5 {
            for (a, b) in [(x, 1.0), (1.0, x), (x, 1.3 * x), (1.9 * x, x), (1.73 * x, 1.0 - x), (x, x * (1.0 + 1e-9))] {
                let exact = if (a / b - 1.0f64).abs() < 0.5 { ((a - b) / b).ln_1p() } else { (a / b).ln() };
                assert!(
                    (ln_ratio(a, b) - exact).abs() <= 1e-16 + 4.4e-16 * exact.abs(),
                    "{a:e} {b:e} {} {exact}",
                    ln_ratio(a, b)
                );
            }
            x *= 1.213_21;
        }
        for i in 0..1000 {
            let (a, b) = (1.0 + f64::from(i) / 1000.0, 1.0 + f64::from((i * 77) % 1000) / 1000.0);
            let exact = ((a - b) / b).ln_1p();
            assert!((ln_ratio(a, b) - exact).abs() <= 1e-16 + 4.4e-16 * exact.abs(), "{a} {b}");
        }
    }
}
