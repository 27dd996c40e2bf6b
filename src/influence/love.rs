//! Near cells: Love's closed form, differences taken in double-double arithmetic.
//!
//! With G_xxyy = 1/r and F = G_xy, where
//!
//!   F = x asinh(y/|x|) + y asinh(x/|y|),
//!   G = x^2 y/2 asinh(y/|x|) + x y^2/2 asinh(x/|y|) - r^3/6,
//!
//! the displacement at the cell's centre is the double difference of F over the corners of the loaded rectangle
//! (Love, Phil. Trans. R. Soc. A 228 (1929) 377), and its mean over a cell the fourth difference of G over two steps.
//! The differences lose (r/h_x)^2 (r/h_y)^2 digits: up to 1e8 for slender neighbours. With 32 digits nothing is seen of it.

use std::collections::HashMap;

use super::double_double::DoubleDouble;
use crate::grid::Kernel;

/// asinh(y/x) for x > 0, y >= 0, with r = hypot(x, y).
fn asinh_ratio(y: DoubleDouble, x: DoubleDouble, r: DoubleDouble) -> DoubleDouble {
    ((y + r) / x).ln()
}

fn hypot(x: DoubleDouble, y: DoubleDouble) -> DoubleDouble {
    (x * x + y * y).sqrt()
}

/// F of the module's header.
fn f(x: DoubleDouble, y: DoubleDouble) -> DoubleDouble {
    let (ax, ay) = (x.abs(), y.abs());
    let r = hypot(ax, ay);
    let magnitude = ax * asinh_ratio(ay, ax, r) + ay * asinh_ratio(ax, ay, r);
    if (x.round() < 0.0) == (y.round() < 0.0) { magnitude } else { -magnitude }
}

/// G of the module's header; even in x and in y.
fn g(x: DoubleDouble, y: DoubleDouble) -> DoubleDouble {
    let (x, y) = (x.abs(), y.abs());
    let r = hypot(x, y);
    let cube = r * r * r / DoubleDouble::from(6.0);
    if x.is_zero() || y.is_zero() {
        return -cube;
    }
    let half = DoubleDouble::from(0.5);
    half * x * y * (x * asinh_ratio(y, x, r) + y * asinh_ratio(x, y, r)) - cube
}

/// F or G at corners, by their place in half steps: cells next to each other share them. Of one kernel and one cell.
#[derive(Default)]
pub(super) struct Corners(HashMap<[i64; 2], DoubleDouble>);

/// Integral of the weight of the kernel over 1/r, over the sides of the cell [`super::coefficient`] (not divided by pi).
pub(super) fn integral(kernel: Kernel, h: [f64; 2], offset: [i64; 2], corners: &mut Corners) -> f64 {
    let node = |k: usize, steps: f64| DoubleDouble::product(offset[k] as f64 + steps, h[k]);
    let weights: &[(f64, f64)] = match kernel {
        Kernel::Galerkin => &[(-1.0, 1.0), (0.0, -2.0), (1.0, 1.0)],
        Kernel::Collocation => &[(-0.5, -1.0), (0.5, 1.0)],
    };
    let mut total = DoubleDouble::from(0.0);
    for &(s, v) in weights {
        for &(t, w) in weights {
            let (x, y) = (node(0, s), node(1, t));
            let place = [(offset[0], s), (offset[1], t)].map(|(n, step)| 2 * n + (2.0 * step) as i64);
            let value = *corners.0.entry(place).or_insert_with(|| match kernel {
                Kernel::Galerkin => g(x, y),
                Kernel::Collocation => f(x, y),
            });
            total = total + value * DoubleDouble::from(v * w);
        }
    }
    match kernel {
        Kernel::Galerkin => total.round() / (h[0] * h[1]),
        Kernel::Collocation => total.round(),
    }
}
