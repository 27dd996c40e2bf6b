//! placeholder
use crate::grid::Kernel;

/// table
pub struct InfluenceTable {
    shape: [usize; 2],
    values: Vec<f64>,
}
impl InfluenceTable {
    /// new
    pub fn new(kernel: Kernel, spacing: [f64; 2], shape: [usize; 2]) -> Self {
        let mut values = Vec::new();
        for j in 0..shape[1] {
            for i in 0..shape[0] {
                values.push(coefficient(kernel, spacing, [i as i64, j as i64]));
            }
        }
        Self { shape, values }
    }
    /// at
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.values[j * self.shape[0] + i]
    }
}
/// c
pub fn coefficient(kernel: Kernel, h: [f64; 2], o: [i64; 2]) -> f64 {
    let pi = std::f64::consts::PI;
    let (x, y) = (o[0].abs() as f64 * h[0], o[1].abs() as f64 * h[1]);
    match kernel {
        Kernel::Collocation => {
            let t = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a * (b / a.abs()).asinh() };
            let f = |u: f64, v: f64| t(u, v) + t(v, u);
            let (a, b) = (h[0] / 2.0, h[1] / 2.0);
            (f(x + a, y + b) - f(x - a, y + b) - f(x + a, y - b) + f(x - a, y - b)) / pi
        }
        Kernel::Galerkin => {
            let t = |a: f64, b: f64| if a == 0.0 { 0.0 } else { (b / a.abs()).asinh() };
            let g = |x: f64, y: f64| {
                x * x * y / 2.0 * t(x, y) + x * y * y / 2.0 * t(y, x) - (x * x + y * y).powf(1.5) / 6.0
            };
            let mut s = 0.0;
            for (k, u) in [(-1.0, 1.0), (0.0, -2.0), (1.0, 1.0)] {
                for (l, v) in [(-1.0, 1.0), (0.0, -2.0), (1.0, 1.0)] {
                    s += u * v * g(x + k * h[0], y + l * h[1]);
                }
            }
            s / (h[0] * h[1]) / pi
        }
    }
}
