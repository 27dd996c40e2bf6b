//! Where a formula of the distance from an axis has kinks: an abs, min, max, sign or floor changes sides, a root or a logarithm begins to have
//! a value. The radii are sampled: integrals begin anew at them, and one that is missed costs steps, not digits; what lies between two of
//! them is enclosed by who proves by it.

use super::functions::{Number, One, Two};
use super::tape::{Op, Tape};
use crate::numeric::scalar::{TO_THE_LAST_DIGIT, bisected};

/// A value, and a mark that differs where any comparison on the way to it fell out in another way.
#[derive(Clone, Copy)]
struct Sided {
    value: f64,
    sides: u64,
}

impl Sided {
    fn mark(value: f64, sides: u64, side: u64) -> Self {
        Self { value, sides: sides.rotate_left(5) ^ side.wrapping_mul(0x9e37_79b9_7f4a_7c15) }
    }
}

impl Number for Sided {
    fn constant(value: f64) -> Self {
        Self { value, sides: 0 }
    }

    fn one(self, f: One) -> Self {
        let value = self.value.one(f);
        match f {
            One::Abs | One::Sign => Self::mark(value, self.sides, 1 + u64::from(self.value < 0.0)),
            One::Floor | One::Ceil => Self::mark(value, self.sides, value.to_bits()),
            // Where a value ends, and not where it was none before.
            One::Sqrt | One::Ln | One::Log10 | One::Log2 | One::Asin | One::Acos if !self.value.is_nan() => {
                Self::mark(value, self.sides, 1 + u64::from(value.is_nan()))
            }
            _ => Self { value, ..self },
        }
    }

    fn two(self, b: Self, f: Two) -> Self {
        let sides = self.sides.rotate_left(17) ^ b.sides;
        let value = self.value.two(b.value, f);
        match f {
            Two::Min | Two::Max => Self::mark(value, sides, 1 + u64::from(self.value < b.value)),
            _ => Self { value, sides },
        }
    }

    fn whole(self, n: i32) -> Self {
        Self { value: self.value.whole(n), ..self }
    }
}

/// Samples to a doubling of the radius, and doublings on each side of 1.
const STEPS: i32 = 8;
const DOUBLINGS: i32 = 60;

/// With more kinks than that none is told: integrals find their own way.
const MOST: usize = 64;

/// Radii of kinks about `axis`, rising.
pub(super) fn radii(tape: &Tape, [x, y]: [f64; 2]) -> Vec<f64> {
    let compares = |op: &Op| match op {
        Op::One(One::Abs | One::Sign | One::Floor | One::Ceil) | Op::Two(Two::Min | Two::Max) => true,
        Op::One(f) => matches!(f, One::Sqrt | One::Ln | One::Log10 | One::Log2 | One::Asin | One::Acos),
        _ => false,
    };
    if !tape.ops().iter().any(compares) {
        return Vec::new();
    }
    let sides = |radius: f64| {
        let x = x + radius;
        tape.run([x, y, x.hypot(y), y.atan2(x)].map(Sided::constant)).sides
    };
    let mut found = Vec::new();
    let radius = |k: i32| (f64::from(k) / f64::from(STEPS)).exp2();
    let ends = -DOUBLINGS * STEPS..DOUBLINGS * STEPS;
    let mut before = sides(radius(ends.start));
    for k in ends {
        let after = sides(radius(k + 1));
        if after != before {
            found.push(bisected(|r| sides(r) == before, [radius(k), radius(k + 1)], TO_THE_LAST_DIGIT)[1]);
            if found.len() > MOST {
                return Vec::new();
            }
        }
        before = after;
    }
    found
}

#[cfg(test)]
mod tests {
    use crate::gap::{Formula, Gap};

    #[test]
    fn kinks_of_formulas_of_the_distance() {
        let cases = [
            ("max(0, r - 0.9) + 0.01*r^2", vec![0.9]),
            ("abs(r - 3) + abs(r - 0.25)", vec![0.25, 3.0]),
            ("min(r^2, 4) * 2", vec![2.0]),
            ("r^2", vec![]),
            ("0*sqrt(r - 0.3) + sqrt(7 - r)", vec![0.3, 7.0]),
        ];
        for (expression, radii) in cases {
            let mut kinks = Vec::new();
            Formula::new(expression).unwrap().ray_kinks([0.0; 2], [1.0, 0.0], &mut kinks);
            kinks.sort_by(f64::total_cmp);
            assert_eq!(kinks.len(), radii.len(), "{expression}: {kinks:?}");
            assert!(kinks.iter().zip(&radii).all(|(a, b)| (a / b - 1.0).abs() < 1e-15), "{expression}: {kinks:?}");
        }
    }

    #[test]
    fn a_ray_that_passes_the_axis_crosses_both_sides() {
        let mut kinks = Vec::new();
        Formula::new("max(0, r - 1)").unwrap().ray_kinks([-2.0, 0.6], [1.0, 0.0], &mut kinks);
        kinks.sort_by(f64::total_cmp);
        assert_eq!(kinks.len(), 2);
        assert!((kinks[0] - 1.2).abs() < 1e-14 && (kinks[1] - 2.8).abs() < 1e-14, "{kinks:?}");
    }
}
