//! Loops compiled for the widest vector unit of the machine, and a logarithm that such loops can inline.

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

/// Bits of sqrt(1/2), where the mantissa's range begins.
const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// Natural logarithm of a positive normal number, without branches. Error below 1 unit in the last place of the result or
/// 2e-16, whichever is larger.
///
/// The method and the coefficients of fdlibm's `e_log.c` (Sun Microsystems 1993): x = 2^k (1 + f), s = f/(2 + f),
/// ln(1 + f) = 2 s + s R(s^2).
#[inline(always)]
pub(crate) fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let shifted = bits.wrapping_sub(SQRT_HALF).wrapping_add(1023 << 52);
    let exponent = shifted >> 52;
    // An integer below 2^52 placed in the mantissa of 2^52.
    let k = f64::from_bits(exponent | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + 1023.0);
    let z = f64::from_bits(bits.wrapping_sub(exponent << 52).wrapping_add(1023 << 52));
    let f = z - 1.0;
    let s = f / (2.0 + f);
    let s2 = s * s;
    let s4 = s2 * s2;
    let even = s4 * (0.399_999_999_994_094_2 + s4 * (0.222_221_984_321_497_84 + s4 * 0.153_138_376_992_093_73));
    let odd = s2
        * (0.666_666_666_666_673_5
            + s4 * (0.285_714_287_436_623_9 + s4 * (0.181_835_721_616_180_5 + s4 * 0.147_981_986_051_165_86)));
    let half = 0.5 * f * f;
    k * LN2_HIGH - ((half - (s * (half + even + odd) + k * LN2_LOW)) - f)
}

#[cfg(test)]
mod tests {
    use super::ln;

    #[test]
    fn agrees_with_the_library() {
        let mut x = 1e-290_f64;
        while x < 1e290 {
            for y in [x, x * 1.37, x * 1.9999] {
                let exact = y.ln();
                assert!((ln(y) - exact).abs() <= 2e-16f64.max(2.3e-16 * exact.abs()), "{y} {} {exact}", ln(y));
            }
            x *= 1.713_21;
        }
        for i in 1..2000 {
            let y = 1.0 + f64::from(i - 1000) * 7.7e-5;
            assert!((ln(y) - y.ln()).abs() <= 2e-16);
        }
    }
}
