//! A face that stays: conjugate gradients in single precision, and the sums they are made of.

use std::ops::Range;

use super::convolution::Convolution;
use super::operator::Scratch;

/// A face that stays.
pub(super) struct Fixed<'a> {
    pub(super) single: &'a Convolution<f32>,
    /// The near compliance that [`Fixed::approach`] takes its steps with, and how many; without it there is one, of a usual length.
    pub(super) periodic: Option<(&'a Convolution<f32>, usize)>,
    pub(super) preconditioner: &'a Convolution<f32>,
    /// 1 on the face and 0 elsewhere.
    pub(super) face: &'a [f32],
}

/// Steps of [`Fixed::approach`]: with 2 the solver takes a quarter more products with A, with 4 hardly fewer.
pub(super) const STEPS: usize = 3;

/// The same under a load: what the circulant errs by in the mean is taken out by the flat punch.
pub(super) const STEPS_UNDER_LOAD: usize = 2;

/// Cells up to which there is one step, of a usual length: on a small grid a product with A costs hardly more than one of them.
pub(super) const SMALL: usize = 4096;
const USUAL: f32 = 0.4;

impl Fixed<'_> {
    /// A few steps of conjugate gradients from zero: `z` is then near the solution on the face for the residual `r`, which is used
    /// up. The last step is as long as the one before: its own length would take a product more.
    pub(super) fn approach(
        &self,
        r: &mut [f32],
        z: &mut [f32],
        [d, image]: [&mut [f32]; 2],
        rows: Range<usize>,
        scratch: &mut Scratch,
    ) {
        let width = self.preconditioner.shape()[0];
        let cells = rows.start * width..rows.end * width;
        let face = &self.face[cells.clone()];
        let (mut rz_old, mut alpha) = (0.0, USUAL);
        let steps = self.periodic.map_or(1, |(_, steps)| steps);
        z[cells.clone()].fill(0.0);
        for step in 0..steps {
            self.preconditioner.product(r, rows.clone(), image, rows.clone(), scratch);
            let rz = dot(&r[cells.clone()], &image[cells.clone()]);
            let beta = if step == 0 { 0.0 } else { (rz / rz_old) as f32 };
            rz_old = rz;
            for ((d, z), m) in d[cells.clone()].iter_mut().zip(&image[cells.clone()]).zip(face) {
                *d = m * z + beta * *d;
            }
            if let Some((periodic, _)) = self.periodic.filter(|_| step + 1 < steps) {
                periodic.product(d, rows.clone(), image, rows.clone(), scratch);
                alpha = (rz / dot(&d[cells.clone()], &image[cells.clone()])) as f32;
                for ((r, ad), m) in r[cells.clone()].iter_mut().zip(&image[cells.clone()]).zip(face) {
                    *r -= alpha * m * ad;
                }
            }
            // Nothing is left to gain.
            if !alpha.is_finite() {
                return;
            }
            for (z, d) in z[cells.clone()].iter_mut().zip(&d[cells.clone()]) {
                *z += alpha * d;
            }
        }
    }

    /// Lowers the residual to `goal`, as far as `limit` products allow; calls `step` with length and direction of each step.
    /// Returns the products it took.
    pub(super) fn relax(
        &self,
        r: &mut [f32],
        goal: f32,
        limit: usize,
        scratch: &mut Scratch,
        mut step: impl FnMut(f64, &[f32]),
    ) -> usize {
        let (n, rows) = (r.len(), 0..self.single.shape()[1]);
        let [mut z, mut d, mut ad] = [(); 3].map(|()| vec![0.0; n]);
        let mut rz_old = 0.0;
        for products in 0..limit {
            if largest(self.face, r) <= goal {
                return products;
            }
            self.preconditioner.product(r, rows.clone(), &mut z, rows.clone(), scratch);
            let rz = dot(r, &z);
            let beta = if products == 0 { 0.0 } else { (rz / rz_old) as f32 };
            rz_old = rz;
            for ((d, z), m) in d.iter_mut().zip(&z).zip(self.face) {
                *d = m * z + beta * *d;
            }
            self.single.product(&d, rows.clone(), &mut ad, rows.clone(), scratch);
            let alpha = rz / dot(&d, &ad);
            if !alpha.is_finite() {
                return products + 1;
            }
            step(alpha, &d);
            for ((r, ad), m) in r.iter_mut().zip(&ad).zip(self.face) {
                *r -= alpha as f32 * m * ad;
            }
        }
        limit
    }
}

/// Largest |r| on the face.
pub(super) fn largest(face: &[f32], r: &[f32]) -> f32 {
    let mut most = [0.0_f32; 8];
    let more = |most: &mut f32, m: &f32, r: &f32| {
        let size = (m * r).abs();
        *most = if size > *most { size } else { *most };
    };
    for (face, r) in face.chunks(8).zip(r.chunks(8)) {
        for ((most, m), r) in most.iter_mut().zip(face).zip(r) {
            more(most, m, r);
        }
    }
    most.iter().fold(0.0, |a, b| a.max(*b))
}

/// a . b: short sums side by side in single precision, summed in double.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f64 {
    let piece = |a: &[f32], b: &[f32]| {
        let mut sums = [0.0_f32; 8];
        for (a, b) in a.chunks(8).zip(b.chunks(8)) {
            for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
                *sum += a * b;
            }
        }
        sums.iter().map(|s| f64::from(*s)).sum::<f64>()
    };
    a.chunks(512).zip(b.chunks(512)).map(|(a, b)| piece(a, b)).sum()
}
