//! A formula far from the origin: its operations on sums of powers of the distance.

use std::f64::consts::{PI, TAU};

use super::functions::{Number, One, Two};
use super::tape::Tape;
use crate::gap::Growth;
use crate::numeric::Interval;

impl Number for Growth {
    fn constant(value: f64) -> Self {
        Growth::constant(value)
    }

    fn one(self, f: One) -> Self {
        match f {
            One::Negate => self.times(Interval::point(-1.0)),
            One::Abs => self.abs(),
            One::Sqrt => self.powf(0.5),
            One::Cbrt => self.cbrt(),
            other => self.map(|range| range.one(other)),
        }
    }

    fn two(self, b: Self, f: Two) -> Self {
        match f {
            Two::Add => self.plus(&b),
            Two::Subtract => self.plus(&b.times(Interval::point(-1.0))),
            Two::Multiply => self.product(&b),
            Two::Divide => self.quotient(&b),
            Two::Power => match b.is_number() {
                Some(exponent) => self.powf(exponent),
                None => self.map(|base| base.powf(b.range())),
            },
            Two::Min => self.lesser(&b),
            Two::Max => self.greater(&b),
            Two::Atan2 => self.atan2(&b),
            Two::Hypot => self.hypot(&b),
        }
    }

    fn whole(self, n: i32) -> Self {
        Growth::whole(&self, n)
    }
}

/// Bounds along the rays whose angles lie in `sector`, for r >= `from`.
pub(super) fn growth(tape: &Tape, sector: Interval, from: f64) -> Option<Growth> {
    let along = |c: Interval| Growth::power(1.0, c, from);
    // theta counts from -pi to pi.
    let theta = if sector.lo >= -PI && sector.hi <= PI {
        sector
    } else if sector.lo > PI {
        sector - Interval::new(TAU.next_down(), TAU.next_up())
    } else if sector.hi < -PI {
        sector + Interval::new(TAU.next_down(), TAU.next_up())
    } else {
        Interval::new(-PI.next_up(), PI.next_up())
    };
    let angle = Growth::power(0.0, theta, from);
    Some(tape.run([along(sector.cos()), along(sector.sin()), along(Interval::point(1.0)), angle]))
}
