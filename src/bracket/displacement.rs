//! Displacement and slopes on a lattice of S x S points a cell: one convolution with a shifted kernel for each point of
//! the lattice, all from one transform of the pressure.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner, num_complex::Complex64};

use super::kernel;

/// Plans for the two-dimensional transform of a real field, x fastest, and its inverse.
pub(super) struct Transform {
    size: [usize; 2],
    forward_x: Arc<dyn RealToComplex<f64>>,
    inverse_x: Arc<dyn ComplexToReal<f64>>,
    forward_y: Arc<dyn Fft<f64>>,
    inverse_y: Arc<dyn Fft<f64>>,
}

/// The least product of small primes, even, at least `n`.
fn fast_size(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for prime in [2_usize, 3, 5] {
            while m.is_multiple_of(prime) {
                m /= prime;
            }
        }
        m == 1
    };
    (n.max(2)..).find(|&m| m.is_multiple_of(2) && smooth(m)).unwrap_or(n)
}

impl Transform {
    fn new(least: [usize; 2]) -> Self {
        let size = least.map(fast_size);
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        Self {
            size,
            forward_x: real.plan_fft_forward(size[0]),
            inverse_x: real.plan_fft_inverse(size[0]),
            forward_y: complex.plan_fft_forward(size[1]),
            inverse_y: complex.plan_fft_inverse(size[1]),
        }
    }

    /// Entries along x of a half spectrum. A spectrum is stored with y fastest.
    fn half(&self) -> usize {
        self.size[0] / 2 + 1
    }

    /// The transform of a field of which only the first rows hold something.
    fn forward(&self, mut field: Vec<f64>, rows: usize) -> Vec<Complex64> {
        let ([mx, my], half) = (self.size, self.half());
        let mut spectrum = vec![Complex64::default(); half * my];
        let mut lines = vec![Complex64::default(); TOGETHER * half];
        let mut scratch = self.forward_x.make_scratch_vec();
        for (block, rows) in field[..rows * mx].chunks_mut(TOGETHER * mx).enumerate() {
            let n = rows.len() / mx;
            for (row, line) in rows.chunks_exact_mut(mx).zip(lines.chunks_exact_mut(half)) {
                // Lengths are those of the plan: the transform cannot fail.
                let _ = self.forward_x.process_with_scratch(row, line, &mut scratch);
            }
            for i in 0..half {
                let to = &mut spectrum[i * my + block * TOGETHER..][..n];
                to.iter_mut().enumerate().for_each(|(j, to)| *to = lines[j * half + i]);
            }
        }
        self.forward_y.process(&mut spectrum);
        spectrum
    }

    /// The first `rows` rows of the field with this spectrum.
    fn inverse(&self, mut spectrum: Vec<Complex64>, rows: usize) -> Vec<f64> {
        let ([mx, my], half) = (self.size, self.half());
        self.inverse_y.process(&mut spectrum);
        let mut field = vec![0.0; mx * rows];
        let mut lines = vec![Complex64::default(); TOGETHER * half];
        let mut scratch = self.inverse_x.make_scratch_vec();
        let norm = 1.0 / (mx * my) as f64;
        for (block, rows) in field.chunks_mut(TOGETHER * mx).enumerate() {
            let n = rows.len() / mx;
            for i in 0..half {
                let from = &spectrum[i * my + block * TOGETHER..][..n];
                from.iter().enumerate().for_each(|(j, from)| lines[j * half + i] = from * norm);
            }
            for (row, line) in rows.chunks_exact_mut(mx).zip(lines.chunks_exact_mut(half)) {
                line[0].im = 0.0;
                line[half - 1].im = 0.0;
                let _ = self.inverse_x.process_with_scratch(line, row, &mut scratch);
            }
        }
        field
    }
}

/// Rows transformed together: their columns then share cache lines.
const TOGETHER: usize = 8;

/// Convolutions of one grid with the kernels of a lattice.
pub(super) struct Lattice {
    h: [f64; 2],
    shape: [usize; 2],
    transform: Transform,
    /// Spectra of displacement and slopes for each shift with both parts at most 1/2; the others are mirror images.
    spectra: Vec<Shifted>,
    /// Euclidean norm of the largest kernel table, for the rounding of a product.
    norm: f64,
}

struct Shifted {
    shift: [f64; 2],
    parts: Vec<Vec<Complex64>>,
}

/// Displacement and, when asked for, slopes at one shift, for (nx + 1) x (ny + 1) points, x fastest.
pub(super) struct Layer {
    /// Displacement at (i + shift) h.
    pub u: Vec<f64>,
    /// Slopes along x and y; empty when not asked for.
    pub slopes: [Vec<f64>; 2],
}

impl Lattice {
    pub fn new(h: [f64; 2], shape: [usize; 2]) -> Self {
        let transform = Transform::new(shape.map(|n| 2 * n + 2));
        Self { h, shape, transform, spectra: Vec::new(), norm: 0.0 }
    }

    pub fn pressure(&self, p: &[f64]) -> Vec<Complex64> {
        let ([mx, my], [nx, _]) = (self.transform.size, self.shape);
        let mut field = vec![0.0; mx * my];
        for (j, row) in p.chunks_exact(nx).enumerate() {
            field[j * mx..j * mx + nx].copy_from_slice(row);
        }
        self.transform.forward(field, self.shape[1])
    }

    /// Bound of the rounding error of one product with the pressure `p`: the error of a transform in the Euclidean norm is
    /// at most a few eps log2(M) of it (Higham 2002, theorem 24.2), and three of them make a product.
    pub fn rounding(&self, p: &[f64]) -> f64 {
        let size = (self.transform.size[0] * self.transform.size[1]) as f64;
        let pressure = p.iter().map(|p| p * p).sum::<f64>().sqrt();
        24.0 * f64::EPSILON * size.log2() * self.norm * pressure
    }

    /// Displacement at the points (i + shift) h from the lower left corner, 0 <= shift < 1.
    pub fn layer(&mut self, pressure: &[Complex64], shift: [f64; 2], with_slopes: bool) -> Layer {
        let flip = shift.map(|s| s > 0.5);
        let base = [0, 1].map(|k| if flip[k] { 1.0 - shift[k] } else { shift[k] });
        let known = self.spectra.iter().position(|s| s.shift == base && (!with_slopes || s.parts.len() == 3));
        let known = known.unwrap_or_else(|| {
            let shifted = self.spectra_at(base, with_slopes);
            self.spectra.push(shifted);
            self.spectra.len() - 1
        });
        let parts = &self.spectra[known].parts;
        let product = |k: usize| {
            // A slope changes its sign in the mirror.
            let sign = if k > 0 && flip[k - 1] { -1.0 } else { 1.0 };
            self.product(pressure, &parts[k], flip, sign)
        };
        let slopes = if with_slopes { [product(1), product(2)] } else { [Vec::new(), Vec::new()] };
        Layer { u: product(0), slopes }
    }

    fn spectra_at(&mut self, shift: [f64; 2], with_slopes: bool) -> Shifted {
        let [mx, my] = self.transform.size;
        let mut tables = vec![vec![0.0; mx * my]; if with_slopes { 3 } else { 1 }];
        let signed = |i: usize, m: usize| if 2 * i < m { i as f64 } else { i as f64 - m as f64 };
        for j in 0..my {
            let y = (signed(j, my) + shift[1] - 0.5) * self.h[1];
            for i in 0..mx {
                let x = (signed(i, mx) + shift[0] - 0.5) * self.h[0];
                let values = kernel::displacement(self.h, x, y);
                for (table, value) in tables.iter_mut().zip(values) {
                    table[j * mx + i] = value;
                }
            }
        }
        self.norm = self.norm.max(tables[0].iter().map(|v| v * v).sum::<f64>().sqrt());
        Shifted { shift, parts: tables.into_iter().map(|t| self.transform.forward(t, my)).collect() }
    }

    fn product(&self, pressure: &[Complex64], kernel: &[Complex64], flip: [bool; 2], sign: f64) -> Vec<f64> {
        let [mx, my] = self.transform.size;
        let half = self.transform.half();
        let mut spectrum = Vec::with_capacity(half * my);
        // Mirrored along x: the conjugate at minus ky (the table is real); along y: at minus ky.
        for (p, k) in pressure.chunks_exact(my).zip(kernel.chunks_exact(my)) {
            match flip {
                [false, false] => spectrum.extend(p.iter().zip(k).map(|(p, k)| p * k * sign)),
                [true, true] => spectrum.extend(p.iter().zip(k).map(|(p, k)| p * k.conj() * sign)),
                [along_x, _] => {
                    let turned = k[..1].iter().chain(k[1..].iter().rev());
                    let product = |(p, k): (&Complex64, &Complex64)| p * if along_x { k.conj() } else { *k } * sign;
                    spectrum.extend(p.iter().zip(turned).map(product));
                }
            }
        }
        debug_assert_eq!(spectrum.len(), half * my);
        let [nx, ny] = self.shape;
        let field = self.transform.inverse(spectrum, ny + 1);
        let mut points = Vec::with_capacity((nx + 1) * (ny + 1));
        for j in 0..=ny {
            points.extend_from_slice(&field[j * mx..j * mx + nx + 1]);
        }
        points
    }

    /// The product with any symmetric kernel of the offset in cells, at the cells themselves.
    pub fn convolve(&self, pressure: &[Complex64], kernel: impl Fn([usize; 2]) -> f64) -> Vec<f64> {
        let ([mx, my], [nx, ny]) = (self.transform.size, self.shape);
        let mut table = vec![0.0; mx * my];
        for j in 0..my {
            for i in 0..mx {
                table[j * mx + i] = kernel([i.min(mx - i), j.min(my - j)]);
            }
        }
        let spectrum = self.transform.forward(table, my);
        let product = spectrum.iter().zip(pressure).map(|(k, p)| k * p).collect();
        let field = self.transform.inverse(product, ny);
        (0..ny).flat_map(|j| field[j * mx..j * mx + nx].to_vec()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shift_agrees_with_the_sum() {
        let (h, shape) = ([0.3, 0.2], [5, 7]);
        let p: Vec<f64> = (0..35).map(|k| ((k * 17 % 11) as f64).sqrt()).collect();
        let mut lattice = Lattice::new(h, shape);
        let spectrum = lattice.pressure(&p);
        for shift in [[0.125, 0.375], [0.625, 0.375], [0.125, 0.875], [0.875, 0.625], [0.0, 0.5], [0.75, 0.0]] {
            let layer = lattice.layer(&spectrum, shift, true);
            for (k, &u) in layer.u.iter().enumerate() {
                let (i, j) = (k % (shape[0] + 1), k / (shape[0] + 1));
                let mut sum = [0.0; 3];
                for (c, p) in p.iter().enumerate() {
                    let x = (i as f64 + shift[0] - (c % shape[0]) as f64 - 0.5) * h[0];
                    let y = (j as f64 + shift[1] - (c / shape[0]) as f64 - 0.5) * h[1];
                    let value = kernel::displacement(h, x, y);
                    (0..3).for_each(|m| sum[m] += p * value[m]);
                }
                assert!((u - sum[0]).abs() < 1e-13, "{shift:?} {i} {j}");
                assert!((layer.slopes[0][k] - sum[1]).abs() < 1e-12 && (layer.slopes[1][k] - sum[2]).abs() < 1e-12);
            }
        }
        assert!(lattice.rounding(&p) < 1e-11);
    }
}
