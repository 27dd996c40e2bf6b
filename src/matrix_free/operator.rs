//! Convolution of a field on a box of cells with an even kernel, by the fast Fourier transform.
//!
//! u = K * p over n_x by n_y cells. Padded with zeros to at least 2n - 1 in each direction the cyclic convolution is the
//! linear one (Hockney 1970; Liu, Wang & Liu, Wear 243 (2000) 101); not padded it is the periodic one, a third of the work.

use std::ops::Range;

use super::convolution::Convolution;
use super::lanes::Workspace;
use super::real::Real;
use super::region::Region;
use super::symbol::Symbol;
use super::transforms::Transforms;
use crate::influence::InfluenceTable;
use crate::numeric::simd::wide;

/// Work beside a transform, for each of its points, over that of one of its passes.
const BESIDE: f64 = 6.0;

/// Work of a transform of so many points, infinite where their number has other factors than 2, 3, 5 and 7. As measured: next to those of
/// 2 and 3 those with one factor of 5 or 7 take a fifth longer, all others (odd ones, 25, 125) up to twice as long.
pub(super) fn cost(m: usize) -> f64 {
    let without = |mut m: usize, p: usize| {
        while m.is_multiple_of(p) {
            m /= p;
        }
        m
    };
    let rest = without(m >> m.trailing_zeros(), 3);
    let slow = match (rest, m.trailing_zeros()) {
        (1, 2..) => 1.0,
        (5 | 7, 3..) => 1.2,
        _ if without(without(rest, 5), 7) == 1 => 1.8,
        _ => return f64::INFINITY,
    };
    m as f64 * (slow * ((m + 1) as f64).log2() + BESIDE)
}

/// A number not below `n` whose transforms are fast: the one that costs least.
pub(super) fn good_length(n: usize) -> usize {
    let n = n.max(1);
    let costs = (n..=n + n / 2 + 1).map(|m| (m, cost(m)));
    costs.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(n, |(m, _)| m)
}

/// As [`good_length`], of rows, whose transforms are of half their length.
pub(super) fn good_width(n: usize) -> usize {
    2 * good_length(n.div_ceil(2))
}

/// Symbol of the displacement of `shape` cells (the upper half of twice as many rows when `mirrored`) by pressure in a region of them,
/// coefficients times `scale`.
pub(super) fn compliance(
    table: &InfluenceTable,
    scale: f64,
    shape: [usize; 2],
    region: &Region,
    mirrored: bool,
    scratch: &Scratch,
) -> Symbol {
    let halves = if mirrored { 2 } else { 1 };
    let rows = halves * shape[1];
    // No two cells that act on each other are farther apart.
    let farthest = |range: &Range<usize>, n: usize| range.end.max(n - range.start);
    let columns = 2 * farthest(&region.columns, shape[0]);
    let lines = if mirrored { shape[1] + region.rows.end } else { 2 * farthest(&region.rows, shape[1]) };
    let length = [good_width(columns), halves * good_length(lines)];
    let symbol = Symbol::of(length, scratch, |j, row| {
        if j < rows {
            for (to, from) in row.iter_mut().zip(&table.row(j)[..shape[0]]) {
                *to = scale * from;
            }
        }
    });
    Symbol { mirrored, ..symbol }
}

/// Symbol of the approximate inverse of [`compliance`].
pub(super) fn preconditioner(
    table: &InfluenceTable,
    scale: f64,
    shape: [usize; 2],
    mirrored: bool,
    scratch: &Scratch,
) -> Symbol {
    let halves = if mirrored { 2 } else { 1 };
    let length = [good_width(shape[0]), halves * good_length(shape[1])];
    let last = table.shape()[1] - 1;
    let mut symbol = Symbol::of(length, scratch, |j, row| {
        if j <= last {
            for (to, from) in row.iter_mut().zip(table.row(j)) {
                *to = scale * from;
            }
        }
    });
    // Of a truncated kernel a value of the symbol could come out negative: kept away from zero.
    let least = 1e-9 * symbol.norm();
    for s in &mut symbol.values {
        *s = 1.0 / s.abs().max(least);
    }
    Symbol { mirrored, ..symbol }
}

/// A symmetric convolution over a box of cells.
#[derive(Clone)]
pub struct Operator(Transforms<f64>);

/// Workspace for the transforms of an [`Operator`]; owned by the caller, grown as needed, kept from product to product.
#[derive(Debug, Default)]
pub struct Scratch {
    double: Workspace<f64>,
    single: Workspace<f32>,
    parallel: bool,
}

impl Scratch {
    /// Workspace for products by one thread.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Workspace for products by all threads of the rayon pool that the product is called in.
    #[cfg(feature = "parallel")]
    #[must_use]
    pub fn parallel() -> Self {
        Self { parallel: true, ..Self::default() }
    }

    /// The same room, for all threads of the pool or for the one that asks.
    pub(super) fn shared(&mut self, parallel: bool) -> &mut Self {
        self.parallel = parallel;
        self
    }

    /// Whether all threads of the pool work.
    pub(super) fn is_shared(&self) -> bool {
        self.parallel
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.double.bytes() + self.single.bytes()
    }

    /// Does the work for each piece, by all threads that there are; what it gives, in the order of the pieces.
    pub(super) fn each<P: Send, S: Send>(
        &self,
        pieces: impl Iterator<Item = P>,
        work: impl Fn(P) -> S + Sync + Send,
    ) -> Vec<S> {
        #[cfg(feature = "parallel")]
        if self.parallel {
            use rayon::prelude::*;
            let pieces: Vec<P> = pieces.collect();
            return pieces
                .into_par_iter()
                .map(|piece| {
                    wide(
                        #[inline(always)]
                        || work(piece),
                    )
                })
                .collect();
        }
        pieces
            .map(|piece| {
                wide(
                    #[inline(always)]
                    || work(piece),
                )
            })
            .collect()
    }

    fn lanes(&self) -> usize {
        #[cfg(feature = "parallel")]
        if self.parallel {
            return rayon::current_num_threads();
        }
        let _ = self.parallel;
        1
    }
}

/// A precision that [`Scratch`] has room for.
pub(super) trait HasWorkspace: Real {
    /// Its room.
    fn room(scratch: &mut Scratch) -> &mut Workspace<Self>;
}

impl HasWorkspace for f64 {
    fn room(scratch: &mut Scratch) -> &mut Workspace<Self> {
        &mut scratch.double
    }
}

impl HasWorkspace for f32 {
    fn room(scratch: &mut Scratch) -> &mut Workspace<Self> {
        &mut scratch.single
    }
}

impl<T: HasWorkspace> Convolution<T> {
    /// As [`Operator::apply`].
    pub(super) fn product(
        &self,
        p: &[T],
        given: Range<usize>,
        u: &mut [T],
        wanted: Range<usize>,
        scratch: &mut Scratch,
    ) {
        let lanes = scratch.lanes();
        match self {
            Self::Sums(sums) => sums.apply(p, given, u, wanted),
            Self::Transforms(transforms) => transforms.apply(p, given, u, wanted, T::room(scratch), lanes),
            Self::Split(split) => split.apply(p, given, u, wanted, T::room(scratch), lanes),
        }
    }
}

impl std::fmt::Debug for Operator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Operator").field("shape", &self.shape()).field("length", &self.length()).finish()
    }
}

impl Operator {
    /// Displacement by pressure (E* = 1) over `shape` cells of these sides. The table must have their aspect ratio and
    /// at least `shape` offsets.
    #[must_use]
    pub fn compliance(table: &InfluenceTable, spacing: [f64; 2], shape: [usize; 2]) -> Self {
        let symbol =
            compliance(table, InfluenceTable::scale(spacing), shape, &Region::whole(shape), false, &Scratch::new());
        Self(Transforms::new(shape, &symbol))
    }

    /// Its approximate inverse: the inverse of the periodic convolution with the same coefficients on a grid that is not
    /// padded (Strang's circulant; close to the symbol |q|/2 of the half-space). Positive definite.
    #[must_use]
    pub fn preconditioner(table: &InfluenceTable, spacing: [f64; 2], shape: [usize; 2]) -> Self {
        let symbol = preconditioner(table, InfluenceTable::scale(spacing), shape, false, &Scratch::new());
        Self(Transforms::new(shape, &symbol))
    }

    /// Number of cells along x and y.
    #[must_use]
    pub fn shape(&self) -> [usize; 2] {
        self.0.shape()
    }

    /// Lengths of the transforms.
    #[must_use]
    pub fn length(&self) -> [usize; 2] {
        self.0.length()
    }

    /// Writes the rows `wanted` of K * p to `u`; the rest of `u` is left as it is. Only the rows `given` of `p` are read:
    /// the others must be zero. Fields have the operator's shape, x fastest.
    pub fn apply(&self, p: &[f64], given: Range<usize>, u: &mut [f64], wanted: Range<usize>, scratch: &mut Scratch) {
        let lanes = scratch.lanes();
        self.0.apply(p, given, u, wanted, &mut scratch.double, lanes);
    }
}

#[cfg(test)]
mod tests {
    use super::super::convolution::Sums;
    use super::*;
    use crate::grid::Kernel;

    #[test]
    fn product_is_the_sum() {
        for (shape, h) in [
            ([5, 4], [1.0, 1.0]),
            ([1, 9], [0.5, 2.0]),
            ([7, 1], [1.0, 0.1]),
            ([1, 1], [1.0, 1.0]),
            ([12, 11], [0.2, 0.1]),
            // Longer ones.
            ([70, 3], [1.0, 1.0]),
            ([3, 71], [1.0, 1.0]),
            ([65, 67], [1.0, 0.7]),
        ] {
            let table = InfluenceTable::new(Kernel::Galerkin, h, shape);
            let operator = Operator::compliance(&table, h, shape);
            let n = shape[0] * shape[1];
            let p: Vec<f64> = (0..n).map(|k| ((k * 7919) % 13) as f64 - 3.0).collect();
            let mut u = vec![0.0; n];
            operator.apply(&p, 0..shape[1], &mut u, 0..shape[1], &mut Scratch::new());
            for (k, &uk) in u.iter().enumerate() {
                let sum: f64 = (0..n)
                    .map(|l| {
                        table.get((k % shape[0]).abs_diff(l % shape[0]), (k / shape[0]).abs_diff(l / shape[0])) * p[l]
                    })
                    .sum();
                assert!((uk - sum).abs() < 1e-13 * n as f64, "{shape:?} {k}: {uk} {sum}");
            }
        }
    }

    #[test]
    fn rows_left_out_change_nothing() {
        let (shape, h) = ([9, 14], [1.0, 1.0]);
        let table = InfluenceTable::new(Kernel::Collocation, h, shape);
        let operator = Operator::compliance(&table, h, shape);
        let p: Vec<f64> = (0..126).map(|k| if (36..81).contains(&k) { (k % 5) as f64 } else { 0.0 }).collect();
        let (mut whole, mut part) = (vec![0.0; 126], vec![0.0; 126]);
        let mut scratch = Scratch::new();
        operator.apply(&p, 0..14, &mut whole, 0..14, &mut scratch);
        operator.apply(&p, 4..9, &mut part, 3..12, &mut scratch);
        for k in 27..108 {
            assert!((whole[k] - part[k]).abs() < 1e-13);
        }
        assert_eq!(part[0], 0.0);
    }

    #[test]
    fn sums_are_the_transforms() {
        for (shape, h, mirrored, given, wanted) in [
            ([5, 4], [1.0, 1.0], false, 0..4, 0..4),
            ([5, 4], [1.0, 1.0], true, 0..4, 0..4),
            ([13, 7], [1.0, 1.0], true, 2..7, 0..6),
            ([20, 11], [1.0, 1.7], false, 3..4, 2..9),
            ([1, 1], [1.0, 1.0], true, 0..1, 0..1),
            ([1, 9], [1.0, 0.2], true, 0..9, 0..9),
        ] {
            let [nx, ny] = shape;
            let table = InfluenceTable::new(Kernel::Galerkin, h, [nx, 2 * ny]);
            let p: Vec<f64> = (0..nx * ny)
                .map(|k| if given.contains(&(k / nx)) { ((k * 7919) % 13) as f64 - 3.0 } else { 0.0 })
                .collect();
            let direct = Sums::new(shape, mirrored, |i, j| table.row(j)[i]);
            let inverse = preconditioner(&table, 1.0, shape, mirrored, &Scratch::new());
            let kernel = inverse.kernel();
            let approximate = Sums::new(shape, mirrored, |i, j| kernel.at(i, j));
            for (sums, symbol) in [
                (direct, compliance(&table, 1.0, shape, &Region::whole(shape), mirrored, &Scratch::new())),
                (approximate, inverse),
            ] {
                let [mut u, mut v] = [0, 1].map(|_| vec![7.0; nx * ny]);
                let mut scratch = Scratch::new();
                Convolution::Sums(sums).product(&p, given.clone(), &mut u, wanted.clone(), &mut scratch);
                Convolution::new(shape, &symbol).product(&p, given.clone(), &mut v, wanted.clone(), &mut scratch);
                for (k, (u, v)) in u.iter().zip(&v).enumerate() {
                    assert!((u - v).abs() < 1e-12, "{shape:?} {mirrored} {k}: {u} {v}");
                }
            }
        }
    }

    #[test]
    fn lengths_are_long_enough_and_fast() {
        for n in 1..3000 {
            let (m, width) = (good_length(n), good_width(n));
            let mut rest = m;
            for prime in [2, 3, 5, 7] {
                while rest.is_multiple_of(prime) {
                    rest /= prime;
                }
            }
            assert!(m >= n && 2 * m <= 3 * n + 2 && rest == 1, "{n}: {m}");
            assert!(width >= n && width.is_multiple_of(2), "{n}: {width}");
        }
        assert_eq!([500, 512, 1000, 2048].map(good_length), [512, 512, 1024, 2048]);
    }

    #[test]
    fn a_mirror_halves_the_work_and_changes_nothing() {
        for (shape, h, given, wanted) in [
            ([5, 4], [1.0, 1.0], 0..4, 0..4),
            ([6, 5], [1.0, 2.0], 1..4, 0..5),
            ([3, 9], [1.0, 0.3], 2..5, 3..9),
            ([4, 8], [1.0, 1.0], 3..4, 1..2),
            ([1, 1], [1.0, 1.0], 0..1, 0..1),
            // Longer ones.
            ([70, 5], [1.0, 1.0], 0..5, 1..4),
            ([4, 67], [1.0, 1.0], 0..67, 0..67),
            ([5, 80], [1.0, 0.5], 11..40, 3..80),
            ([66, 75], [1.0, 1.0], 12..65, 7..70),
        ] {
            let [nx, m] = shape;
            let whole = [nx, 2 * m];
            let table = InfluenceTable::new(Kernel::Galerkin, h, whole);
            let full = Operator::compliance(&table, h, whole);
            let half: Convolution<f64> = Convolution::new(
                shape,
                &compliance(&table, InfluenceTable::scale(h), shape, &Region::whole(shape), true, &Scratch::new()),
            );
            let p: Vec<f64> = (0..nx * m)
                .map(|k| if given.contains(&(k / nx)) { ((k * 7919) % 13) as f64 - 3.0 } else { 0.0 })
                .collect();
            let row = |j: usize| if j < m { m - 1 - j } else { j - m };
            let unfolded: Vec<f64> = (0..nx * 2 * m).map(|k| p[row(k / nx) * nx + k % nx]).collect();
            let (mut u, mut v) = (vec![0.0; nx * 2 * m], vec![0.0; nx * m]);
            full.apply(&unfolded, 0..2 * m, &mut u, 0..2 * m, &mut Scratch::new());
            half.product(&p, given.clone(), &mut v, wanted.clone(), &mut Scratch::new());
            for k in wanted.start * nx..wanted.end * nx {
                assert!((v[k] - u[nx * m + k]).abs() < 1e-12, "{shape:?} {k}: {} {}", v[k], u[nx * m + k]);
            }
            let single: Convolution<f32> = Convolution::new(
                shape,
                &compliance(&table, InfluenceTable::scale(h), shape, &Region::whole(shape), true, &Scratch::new()),
            );
            let (p, mut w): (Vec<f32>, _) = (p.iter().map(|&p| p as f32).collect(), vec![0.0; nx * m]);
            single.product(&p, given, &mut w, wanted.clone(), &mut Scratch::new());
            for k in wanted.start * nx..wanted.end * nx {
                assert!((f64::from(w[k]) - v[k]).abs() < 1e-4);
            }
        }
    }
}
