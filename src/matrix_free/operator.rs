//! Displacement from pressure by a zero-padded fast Fourier transform (Hockney 1970; Liu, Wang & Liu 2000).

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

use crate::InfluenceTable;

/// Columns that are transformed together: a cache line of complex numbers is read at a time.
const BLOCK: usize = 8;

/// Least length >= n whose only prime factors are 2, 3 and 5.
pub(super) fn good_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m % p == 0 {
                m /= p;
            }
        }
        m == 1
    };
    (n.max(2)..).find(|&m| m % 2 == 0 && smooth(m)).expect("there is a power of two")
}

/// u = A p on a rectangle of cells, or any other convolution with a real even kernel.
pub(super) struct Operator {
    shape: [usize; 2],
    padded: [usize; 2],
    /// Transform of the kernel over the padded rectangle, divided by its size: real and even, so a quarter is kept.
    /// Column by column, ky fastest.
    symbol: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    backward: Arc<dyn ComplexToReal<f64>>,
    down: Arc<dyn Fft<f64>>,
    up: Arc<dyn Fft<f64>>,
}

/// Memory for one product at a time.
pub(super) struct Scratch {
    spectrum: Vec<Complex64>,
    columns: Vec<Complex64>,
    row: Vec<f64>,
    work: Vec<Complex64>,
    empty: Vec<bool>,
}

impl Operator {
    /// The compliance operator of `shape` cells: no cell meets its periodic image.
    pub fn compliance(table: &InfluenceTable, shape: [usize; 2]) -> Self {
        let padded = shape.map(|n| good_length(2 * n - 1));
        let mut operator = Self::plan(shape, padded);
        let kernel = |i: usize, j: usize| if i < shape[0] && j < shape[1] { table.get(i, j) } else { 0.0 };
        operator.symbol = operator.transform_of(kernel);
        operator
    }

    /// A convolution on the cells themselves, periodic, whose symbol is given at the wave numbers (kx, ky), both
    /// from 0 to half the length of a period.
    pub fn periodic(shape: [usize; 2], symbol: impl Fn(usize, usize, [usize; 2]) -> f64) -> Self {
        let padded = shape.map(good_length);
        let mut operator = Self::plan(shape, padded);
        let size = (padded[0] * padded[1]) as f64;
        let wave = |kx: usize| (0..=padded[1] / 2).map(move |ky| (kx, ky));
        operator.symbol = (0..=padded[0] / 2).flat_map(wave).map(|(kx, ky)| symbol(kx, ky, padded) / size).collect();
        operator
    }

    fn plan(shape: [usize; 2], padded: [usize; 2]) -> Self {
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        Self {
            shape,
            padded,
            symbol: Vec::new(),
            forward: real.plan_fft_forward(padded[0]),
            backward: real.plan_fft_inverse(padded[0]),
            down: complex.plan_fft_forward(padded[1]),
            up: complex.plan_fft_inverse(padded[1]),
        }
    }

    /// Transform of a kernel given for offsets 0..=half, mirrored.
    fn transform_of(&self, kernel: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let [px, py] = self.padded;
        let (half_x, half_y) = (px / 2, py / 2);
        let size = (px * py) as f64;
        let mut rows = vec![Complex64::default(); (half_x + 1) * (half_y + 1)];
        let (mut row, mut work) = (vec![0.0; px], self.forward.make_scratch_vec());
        for (j, spectrum) in rows.chunks_exact_mut(half_x + 1).enumerate() {
            for (i, value) in row.iter_mut().enumerate() {
                *value = kernel(i.min(px - i), j);
            }
            self.forward.process_with_scratch(&mut row, spectrum, &mut work).expect("lengths agree");
        }
        let mut symbol = Vec::with_capacity((half_x + 1) * (half_y + 1));
        let mut column = vec![Complex64::default(); py];
        for kx in 0..=half_x {
            for (j, value) in column.iter_mut().enumerate() {
                *value = Complex64::new(rows[j.min(py - j) * (half_x + 1) + kx].re, 0.0);
            }
            self.down.process(&mut column);
            symbol.extend(column[..=half_y].iter().map(|c| c.re / size));
        }
        symbol
    }

    pub fn scratch(&self) -> Scratch {
        let [px, py] = self.padded;
        let work = self.down.get_inplace_scratch_len().max(self.up.get_inplace_scratch_len());
        let work = work.max(self.forward.get_scratch_len()).max(self.backward.get_scratch_len());
        Scratch {
            spectrum: vec![Complex64::default(); self.shape[1] * (px / 2 + 1)],
            columns: vec![Complex64::default(); BLOCK * py],
            row: vec![0.0; px],
            work: vec![Complex64::default(); work],
            empty: vec![false; self.shape[1]],
        }
    }

    /// `out` = kernel * `field`, both over `shape`, x fastest.
    pub fn apply(&self, field: &[f64], out: &mut [f64], scratch: &mut Scratch) {
        let [nx, ny] = self.shape;
        let [px, py] = self.padded;
        let width = px / 2 + 1;
        let Scratch { spectrum, columns, row, work, empty } = scratch;
        for (j, line) in field.chunks_exact(nx).enumerate() {
            let into = &mut spectrum[j * width..(j + 1) * width];
            empty[j] = line.iter().all(|&v| v == 0.0);
            if empty[j] {
                into.fill(Complex64::default());
                continue;
            }
            row[..nx].copy_from_slice(line);
            row[nx..].fill(0.0);
            self.forward.process_with_scratch(row, into, work).expect("lengths agree");
        }
        let half = py / 2;
        for first in (0..width).step_by(BLOCK) {
            let block = BLOCK.min(width - first);
            for j in 0..ny {
                for (b, value) in spectrum[j * width + first..][..block].iter().enumerate() {
                    columns[b * py + j] = *value;
                }
            }
            for b in 0..block {
                let column = &mut columns[b * py..(b + 1) * py];
                column[ny..].fill(Complex64::default());
                self.down.process_with_scratch(column, work);
                let symbol = &self.symbol[(first + b) * (half + 1)..][..=half];
                for (value, s) in column[..=half].iter_mut().zip(symbol) {
                    *value *= s;
                }
                for (value, s) in column[half + 1..].iter_mut().zip(symbol[1..half].iter().rev()) {
                    *value *= s;
                }
                self.up.process_with_scratch(column, work);
            }
            for j in 0..ny {
                for (b, value) in spectrum[j * width + first..][..block].iter_mut().enumerate() {
                    *value = columns[b * py + j];
                }
            }
        }
        for (j, line) in out.chunks_exact_mut(nx).enumerate() {
            let from = &mut spectrum[j * width..(j + 1) * width];
            // Real up to rounding there; the transform insists on exact zeros.
            from[0].im = 0.0;
            from[width - 1].im = 0.0;
            self.backward.process_with_scratch(from, row, work).expect("lengths agree");
            line.copy_from_slice(&row[..nx]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Kernel;

    #[test]
    fn the_product_is_the_sum_over_cells() {
        let shape = [7, 12];
        let table = InfluenceTable::new(Kernel::Galerkin, [0.3, 0.2], shape);
        let operator = Operator::compliance(&table, shape);
        let p: Vec<f64> = (0..84).map(|k| if k / 7 == 3 { 0.0 } else { (1.3 * k as f64).sin() }).collect();
        let mut u = vec![0.0; 84];
        operator.apply(&p, &mut u, &mut operator.scratch());
        for k in 0..84 {
            let sum: f64 =
                (0..84).map(|m| p[m] * table.get((k % 7usize).abs_diff(m % 7), (k / 7usize).abs_diff(m / 7))).sum();
            assert!((u[k] - sum).abs() < 1e-14, "{k}: {} {sum}", u[k]);
        }
    }
}
