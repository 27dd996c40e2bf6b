//! The two precisions, and their planners.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::Mul;

use realfft::RealFftPlanner;
use rustfft::num_complex::Complex;
use rustfft::{FftNum, FftPlanner};

/// A precision to compute in.
pub(super) trait Real: FftNum + Mul<Output = Self> + Default {
    /// Calls with the planners of this thread for a length. Twiddle factors outlive an operator: small problems would spend most
    /// of their time on them. A planner builds upon what it has planned before: one that has served other lengths would round
    /// otherwise, and so would another thread.
    fn with_planners<R>(length: usize, work: impl FnOnce(&mut RealFftPlanner<Self>, &mut FftPlanner<Self>) -> R) -> R;

    /// The nearest number of this precision.
    fn of(value: f64) -> Self;

    /// exp(i pi `half_turns`).
    fn turn(half_turns: f64) -> Complex<Self> {
        let (sin, cos) = (std::f64::consts::PI * half_turns).sin_cos();
        Complex { re: Self::of(cos), im: Self::of(sin) }
    }
}

type Planners<T> = RefCell<HashMap<usize, (RealFftPlanner<T>, FftPlanner<T>)>>;

thread_local! {
    static DOUBLE: Planners<f64> = RefCell::default();
    static SINGLE: Planners<f32> = RefCell::default();
}

impl Real for f64 {
    fn with_planners<R>(length: usize, work: impl FnOnce(&mut RealFftPlanner<Self>, &mut FftPlanner<Self>) -> R) -> R {
        DOUBLE.with_borrow_mut(|planners| {
            let (real, complex) = planners.entry(length).or_insert_with(|| (RealFftPlanner::new(), FftPlanner::new()));
            work(real, complex)
        })
    }

    fn of(value: f64) -> Self {
        value
    }
}

impl Real for f32 {
    fn with_planners<R>(length: usize, work: impl FnOnce(&mut RealFftPlanner<Self>, &mut FftPlanner<Self>) -> R) -> R {
        SINGLE.with_borrow_mut(|planners| {
            let (real, complex) = planners.entry(length).or_insert_with(|| (RealFftPlanner::new(), FftPlanner::new()));
            work(real, complex)
        })
    }

    fn of(value: f64) -> Self {
        value as Self
    }
}
