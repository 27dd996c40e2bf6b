//! One grid as the solvers see it: what is given, and the state that they improve.

use std::ops::Range;

use super::Operators;
use super::fields::{Fields, PIECE};
use super::operator::Scratch;
use super::region::Region;
use crate::clock::Deadline;
use crate::influence::InfluenceTable;

/// Offsets, in cells, as far as the displacement by a cell that leaves is foreseen.
pub(super) const NEAR: usize = 8;

/// The discrete problem on a box of cells, in units of the largest overlap and with A = 1 from a cell to itself: p and r are
/// then of one size.
pub(super) struct Level<'a> {
    pub(super) shape: [usize; 2],
    /// Overlap in each cell; under a load up to a constant ([`State::deeper`]).
    pub(super) f: &'a [f64],
    /// The sum of the pressures, where that is given in place of the depth.
    pub(super) load: Option<f64>,
    /// A, up to a factor.
    pub(super) table: &'a InfluenceTable,
    /// A at offsets below [`NEAR`], row by row.
    pub(super) near: &'a [[f32; NEAR]; NEAR],
    pub(super) mirrored: bool,
    /// Largest error of the gap allowed.
    pub(super) tolerance: f64,
    pub(super) limit: Limit,
}

/// What ends a solve before its tolerance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    /// Products allowed.
    pub(super) products: usize,
    pub(super) deadline: Deadline,
}

/// Pressure and what belongs to it.
pub(super) struct State {
    pub(super) p: Vec<f64>,
    /// f - A p in every cell, when it was last computed in double precision.
    pub(super) r: Vec<f64>,
    /// What f is larger by everywhere; zero where the depth is given.
    pub(super) deeper: f64,
    pub(super) iterations: usize,
    /// Products in double precision.
    pub(super) products: usize,
    /// Products in single precision.
    pub(super) single_products: usize,
}

impl State {
    /// Moves every cell by as much.
    pub(super) fn deepen(&mut self, fields: &mut Fields, by: f64, scratch: &Scratch) {
        if by.is_finite() {
            self.deeper += by;
            fields.deepen(by, scratch);
        }
    }

    pub(super) fn from(p: Vec<f64>) -> Self {
        Self { p, r: Vec::new(), deeper: 0.0, iterations: 0, products: 0, single_products: 0 }
    }

    pub(super) fn all_products(&self) -> usize {
        self.products + self.single_products
    }
}

impl Level<'_> {
    /// Whether no further product is allowed.
    pub(super) fn is_exhausted(&self, state: &State) -> bool {
        state.all_products() >= self.limit.products || self.limit.deadline.has_passed()
    }

    /// f - A p from scratch, where there is a compliance in double precision.
    pub(super) fn refresh(&self, operators: &Operators, state: &mut State, scratch: &mut Scratch) {
        let [width, height] = self.shape;
        state.r.resize(state.p.len(), 0.0);
        let given = occupied(&state.p, width);
        let Some(compliance) = operators.compliance.as_ref().filter(|_| !given.is_empty()) else {
            state.r.iter_mut().zip(self.f).for_each(|(r, f)| *r = f + state.deeper);
            return;
        };
        compliance.product(&state.p, given, &mut state.r, 0..height, scratch);
        let deeper = state.deeper;
        let pieces = state.r.chunks_mut(PIECE).zip(self.f.chunks(PIECE));
        scratch.each(
            pieces,
            #[inline(always)]
            |(r, f)| r.iter_mut().zip(f).for_each(|(r, f)| *r = f + deeper - *r),
        );
        state.products += 1;
    }

    /// The region with cells outside of it that are penetrated; `None` where there are none.
    pub(super) fn outgrown(&self, region: &Region, state: &State) -> Option<Region> {
        if region.shape() == self.shape {
            return None;
        }
        let width = self.shape[0];
        let outside = |k: usize| state.r[k] > self.tolerance && !region.contains(k, width);
        let found = Region::holding(self.shape, outside)?;
        Some(region.union(&found).widened(self.shape, self.mirrored))
    }

    /// Scales the pressures to the load, where one is given; from nothing they are all the same.
    pub(super) fn scale_to_load(&self, state: &mut State) {
        let Some(load) = self.load else { return };
        let mut sum: f64 = state.p.iter().sum();
        if sum <= 0.0 {
            state.p.iter_mut().zip(self.f).for_each(|(p, f)| *p = if *f > 0.0 { 1.0 } else { 0.0 });
            sum = state.p.iter().sum();
        }
        state.p.iter_mut().for_each(|p| *p *= load / sum);
    }

    /// Takes the pressure out of one cell of a box so wide, and what it did out of the residual: row by row, without a transform.
    pub(super) fn take_out(&self, width: usize, p: &mut [f64], k: usize, residual: &mut [f32]) {
        let (i, j) = (k % width, k / width);
        let p = std::mem::take(&mut p[k]) / self.table.row(0)[0];
        for (y, row) in residual.chunks_exact_mut(width).enumerate() {
            let (left, right) = row.split_at_mut(i);
            let mut add = |offset: usize| {
                let coefficients = self.table.row(offset);
                right.iter_mut().zip(coefficients).for_each(|(r, a)| *r += (p * a) as f32);
                left.iter_mut().rev().zip(&coefficients[1..]).for_each(|(r, a)| *r += (p * a) as f32);
            };
            add(y.abs_diff(j));
            if self.mirrored {
                // By the image at -1 - j.
                add(y + j + 1);
            }
        }
    }

    /// Adds to the residual on the face what it will be more by near the cells that leave.
    pub(super) fn foresee(&self, fields: &mut Fields, leaving: &[usize], rows: &Range<usize>) {
        let [width, height] = fields.shape();
        let Fields { p, face, w: residual, .. } = fields;
        let reach = |at: usize, end: usize| at.saturating_sub(NEAR - 1)..(at + NEAR).min(end);
        for &k in leaving {
            let (i, j, p) = (k % width, k / width, p[k] as f32);
            let mut add = |row: usize, offset: usize| {
                if !rows.contains(&row) {
                    return;
                }
                let along = reach(i, width);
                let face = &face[row * width..][along.clone()];
                let residual = &mut residual[row * width..][along.clone()];
                for ((x, r), m) in along.zip(residual).zip(face) {
                    *r += m * p * self.near[offset][x.abs_diff(i)];
                }
            };
            reach(j, height).for_each(|row| add(row, row.abs_diff(j)));
            if self.mirrored {
                // From the image at -1 - j.
                (0..height.min(NEAR.saturating_sub(j + 1))).for_each(|row| add(row, row + j + 1));
            }
        }
    }

    /// Largest |f - A p| where there is pressure and largest f - A p elsewhere. Only for p >= 0.
    pub(super) fn error(&self, state: &State, scratch: &Scratch) -> f64 {
        let errors = scratch.each(state.p.chunks(PIECE).zip(state.r.chunks(PIECE)), |(p, r)| super::error(p, r));
        errors.into_iter().fold(0.0, f64::max)
    }
}

/// Rows from the first to the last that hold a number other than zero.
pub(super) fn occupied<T: PartialEq + Default>(field: &[T], width: usize) -> Range<usize> {
    let holds = |row: &&[T]| row.iter().any(|v| *v != T::default());
    let rows = field.len() / width;
    let before = field.chunks_exact(width).take_while(|row| !holds(row)).count();
    let after = field.chunks_exact(width).rev().take_while(|row| !holds(row)).count();
    if before == rows { 0..0 } else { before..rows - after }
}
