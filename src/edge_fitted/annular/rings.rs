//! Ring elements and their compliance, everything along one radius.
//! u = sum over the radii a_k of the jumps of pressure times the displacement of the disc of that radius.

use std::f64::consts::PI;

use super::super::compliance::Compliance;
use super::super::gauss::legendre;
use super::disc::disc;

/// Concentric rings, the first `loaded` groups of which may carry pressure.
#[derive(Debug, Clone)]
pub(crate) struct Rings {
    /// Radii of each ring, inner and outer, by rising radius.
    pub rings: Vec<[f64; 2]>,
    /// May carry pressure; the others only hold the fade.
    pub loaded: Vec<bool>,
    /// Area of each ring.
    pub areas: Vec<f64>,
}

impl Rings {
    pub fn new(rings: Vec<[f64; 2]>, loaded: Vec<bool>) -> Self {
        let areas = rings.iter().map(|[a, b]| PI * (b - a) * (b + a)).collect();
        Self { rings, loaded, areas }
    }

    /// Jumps of a pressure: (radius, pressure inside less outside).
    pub fn jumps(&self, p: &[f64]) -> Vec<(f64, f64)> {
        let mut list: Vec<(f64, f64)> = Vec::new();
        let mut add = |r: f64, jump: f64| match list.last_mut() {
            Some(last) if last.0 == r => last.1 += jump,
            _ => list.push((r, jump)),
        };
        for ([a, b], p) in self.rings.iter().zip(p) {
            add(*a, -p);
            add(*b, *p);
        }
        list.retain(|j| j.1 != 0.0 && j.0 > 0.0);
        list
    }

    /// The compliance matrix by quadrature, good for solving (no bound of its error is needed: the energy is summed by
    /// [`Rings::norm`]).
    pub fn compliance(&self) -> Compliance {
        let n = self.rings.len();
        let mut matrix = vec![0.0; n * n];
        for (i, own) in self.rings.iter().enumerate() {
            for (r, weight, from) in graded_points(*own) {
                for (j, [a, b]) in self.rings.iter().enumerate() {
                    // r - a and r - b, exactly where the ring's own ends are meant.
                    let beyond = |end: f64| {
                        if end == own[0] {
                            from[0]
                        } else if end == own[1] {
                            -from[1]
                        } else {
                            r - end
                        }
                    };
                    let v = disc(r, *b, beyond(*b))[0] - disc(r, *a, beyond(*a))[0];
                    matrix[i * n + j] += weight * v;
                }
            }
        }
        for i in 0..n {
            for j in 0..i {
                let mean = 0.5 * (matrix[i * n + j] + matrix[j * n + i]);
                matrix[i * n + j] = mean;
                matrix[j * n + i] = mean;
            }
        }
        Compliance { n, matrix, error: vec![0.0; n * n], threads: 1 }
    }
}

/// Points of a ring graded to both ends: radius, weight 2 pi r dr, distances from both ends.
fn graded_points([a, b]: [f64; 2]) -> Vec<(f64, f64, [f64; 2])> {
    let half = 0.5 * (b - a);
    let (x, w) = legendre(12);
    let mut list = Vec::new();
    for high in [false, true] {
        for (x, w) in x.iter().zip(w) {
            let t = 0.5 * (1.0 + x);
            let s = half * t.powi(3);
            let weight = 0.5 * w * half * 3.0 * t * t;
            let r = if high { b - s } else { a + s };
            let from = if high { [b - a - s, s] } else { [s, b - a - s] };
            list.push((r, 2.0 * PI * r * weight, from));
        }
    }
    list
}
