//! A convolution with 1/r over a box as two: what is near on all cells, what is far on a few.
//!
//! Within a distance a the kernel is parted, 1/r = (1/r - g(r)) + g(r), with the smooth g(r) = P(r^2/a^2)/a that meets 1/r at a with
//! three derivatives (Skeel, Tezcan & Hardy, J. Comput. Chem. 23 (2002) 673; for contacts by sums, Brandt & Lubrecht, J. Comput. Phys. 90
//! (1990) 348). The near part ends at a: a transform of the box and a margin of a is enough. The far part is summed over points several
//! cells apart, padded transforms of a few per cent of the cells; pressures are handed to those points and displacements back by one
//! interpolation of the fifth degree, so that the whole stays symmetric. A third of the work of one padded transform, to five digits.

use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

use super::lanes::{Workspace, first, share};
use super::operator::{Scratch, cost, good_length, good_width};
use super::real::Real;
use super::symbol::Symbol;
use super::transforms::Transforms;
use crate::influence::InfluenceTable;
use crate::numeric::simd::wide;

/// The distance at which the kernel is parted, in steps of the far points: what interpolation errs by falls with its sixth power.
const REACH: f64 = 8.0;

/// Points of an interpolation.
const POINTS: usize = 6;

/// Steps of the far points that are weighed against each other, in longest sides of a cell.
const STEPS: [usize; 5] = [2, 4, 8, 16, 32];

/// Share of the padded transforms' work from which on they are left alone.
const WORTH: f64 = 0.75;

/// Work for handing a cell's pressure to the far points and taking its displacement from there, over that of one pass of a transform.
const HANDED: f64 = 6.0;

/// Two convolutions that make one.
#[derive(Debug)]
pub(super) struct Split<T> {
    near: Transforms<T>,
    far: Transforms<T>,
    along: Spread<T>,
    across: Spread<T>,
}

/// The smooth part of 1/r, in units of the distance at which it begins to be all of it: the Taylor series of (s^2)^(-1/2) about 1.
fn smooth(s: f64) -> f64 {
    let s = s * s;
    (35.0 + s * (-35.0 + s * (21.0 - 5.0 * s))) / 16.0
}

/// The far part of a table's coefficients, from a distance on all of them.
struct Far<'a> {
    table: &'a InfluenceTable,
    h: [f64; 2],
    reach: f64,
}

impl Far<'_> {
    /// At an offset in cells, of a cell whose longer side is 1.
    fn at(&self, i: usize, j: usize) -> f64 {
        let [nx, ny] = self.table.shape();
        let r = (i as f64 * self.h[0]).hypot(j as f64 * self.h[1]);
        let area = FRAC_1_PI * self.h[0] * self.h[1];
        if r < self.reach {
            area * smooth(r / self.reach) / self.reach
        } else if i < nx && j < ny {
            self.table.row(j)[i]
        } else {
            area / r
        }
    }
}

impl<T: Real> Split<T> {
    /// Over `shape` cells (the upper half of twice as many rows when `mirrored`), coefficients times `scale`; `None` where padded
    /// transforms are no more work.
    pub(super) fn new(
        table: &InfluenceTable,
        scale: f64,
        shape: [usize; 2],
        mirrored: bool,
        scratch: &Scratch,
    ) -> Option<Self> {
        let longer = InfluenceTable::scale(table.spacing());
        let h = table.spacing().map(|h| h / longer);
        let halves = if mirrored { 2 } else { 1 };
        let lengths = |step: usize| {
            let reach = REACH * step as f64;
            let all = [shape[0], halves * shape[1]];
            // No longer than the step, whatever the sides of a cell, nor than all cells.
            let steps =
                [0, 1].map(|m| 1_usize << ((step as f64 / h[m]).min(shape[m] as f64).log2() + 1e-9).floor() as u32);
            let margin = [0, 1].map(|m| (reach / h[m]).min(all[m] as f64).ceil() as usize);
            let near = [good_width(shape[0] + margin[0]), good_length(shape[1] + margin[1].div_ceil(halves))];
            let spreads = [Spread::new(shape[0], steps[0], false), Spread::new(shape[1], steps[1], mirrored)];
            let far = [good_width(2 * spreads[0].nodes), good_length(2 * spreads[1].nodes)];
            (reach, near, spreads, far)
        };
        let work = |[x, y]: [usize; 2]| cost(x) * y as f64 + cost(y) * x as f64;
        let whole = work([good_width(2 * shape[0]), good_length(2 * shape[1])]);
        let handed = HANDED * (shape[0] * shape[1]) as f64;
        let tried = STEPS.map(lengths).into_iter().map(|parts| (work(parts.1) + work(parts.3) + handed, parts));
        let (least, (reach, near, [along, across], far)) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
        if least > WORTH * whole {
            return None;
        }
        let coefficients = Far { table, h, reach };
        let rows = halves * shape[1];
        let symbol = Symbol::of([near[0], halves * near[1]], scratch, |j, row| {
            let y = j as f64 * h[1];
            if j < rows && y < reach {
                let within = ((reach * reach - y * y).sqrt() / h[0]).ceil() as usize;
                for (i, (to, from)) in row.iter_mut().zip(&table.row(j)[..shape[0]]).enumerate().take(within) {
                    *to = scale * (from - coefficients.at(i, j));
                }
            }
        });
        let near = Transforms::new(shape, &Symbol { mirrored, ..symbol });
        let nodes = [along.nodes, across.nodes];
        let symbol = Symbol::of([far[0], halves * far[1]], scratch, |j, row| {
            if j < halves * nodes[1] {
                for (i, to) in row.iter_mut().enumerate().take(nodes[0]) {
                    *to = scale * coefficients.at(i * along.step, j * across.step);
                }
            }
        });
        let far = Transforms::new(nodes, &Symbol { mirrored, ..symbol });
        Some(Self { near, far, along, across })
    }

    /// Number of cells along x and y.
    pub(super) fn shape(&self) -> [usize; 2] {
        self.near.shape()
    }

    /// As [`Transforms::apply`].
    pub(super) fn apply(
        &self,
        p: &[T],
        given: Range<usize>,
        u: &mut [T],
        wanted: Range<usize>,
        room: &mut Workspace<T>,
        lanes: usize,
    ) {
        let nx = self.shape()[0];
        self.near.apply(p, given.clone(), u, wanted.clone(), room, lanes);
        if given.is_empty() || wanted.is_empty() {
            return;
        }
        let [mx, my] = self.far.shape();
        let [mut kept, mut between] = [&mut room.points, &mut room.spread].map(std::mem::take);
        let (points, along) = (first(&mut kept, 2 * mx * my), first(&mut between, given.len() * mx));
        let (loads, moved) = points.split_at_mut(mx * my);
        let wide_row = self.along.room();
        share(&mut room.lanes, along, mx, |lane, j, sums| {
            let row = lane.row(wide_row);
            self.along.gather(&p[(given.start + j) * nx..][..nx], row, sums);
        });
        let along = &*along;
        share(&mut room.lanes, loads, mx, |_, node, loads| {
            loads.fill(T::of(0.0));
            self.across.cells(node, &given, |weight, j| add(loads, weight, &along[(j - given.start) * mx..][..mx]));
        });
        self.far.apply(loads, 0..my, moved, 0..my, room, lanes);
        let moved = &*moved;
        share(&mut room.lanes, &mut u[wanted.start * nx..wanted.end * nx], nx, |lane, j, row| {
            let (points, cells) = lane.row(mx + wide_row).split_at_mut(mx);
            points.fill(T::of(0.0));
            for (weight, node) in self.across.points(wanted.start + j) {
                add(points, weight, &moved[node * mx..][..mx]);
            }
            self.along.spread(points, cells, row);
        });
        (room.points, room.spread) = (kept, between);
    }
}

/// to + weight from.
fn add<T: Real>(to: &mut [T], weight: T, from: &[T]) {
    wide(
        #[inline(always)]
        || to.iter_mut().zip(from).for_each(|(to, from)| *to = *to + weight * *from),
    );
}

/// Sums done side by side.
const LANES: usize = 8;

/// Points in a row, `step` cells apart, and what each has to do with the cells between them.
#[derive(Debug)]
struct Spread<T> {
    cells: usize,
    /// A power of 2.
    step: usize,
    nodes: usize,
    /// The first cell of the six steps of point 0, before the cells.
    start: isize,
    /// Weights of a point in the cells of its six steps, and zeros up to a multiple of [`LANES`].
    weights: Vec<T>,
    mirrored: bool,
}

impl<T: Real> Spread<T> {
    fn new(cells: usize, step: usize, mirrored: bool) -> Self {
        // Two points lie before the first cell, or there is a mirror half a step before point 0.
        let half = if mirrored { 1 } else { -5 };
        // The first cell behind point B.
        let behind = |point: isize| ((2 * point + half) * step as isize).div_euclid(2);
        let within = if step.is_multiple_of(2) { 0.5 } else { 0.0 };
        let mut weights = vec![T::of(0.0); (POINTS * step).next_multiple_of(LANES)];
        for m in 0..step {
            let at = (m as f64 + within) / step as f64;
            for point in 0..POINTS {
                // Of the points -2 to 3 around it.
                let own = point as f64 - 2.0;
                let others = (0..POINTS).filter(|k| *k != point).map(|k| k as f64 - 2.0);
                weights[(POINTS - 1 - point) * step + m] = T::of(others.map(|k| (at - k) / (own - k)).product());
            }
        }
        let last = (0..).take_while(|&point| behind(point) < cells as isize).last().unwrap_or(0);
        Self { cells, step, nodes: last as usize + 4, start: behind(-3), weights, mirrored }
    }

    /// Cells from the first step of point 0 to the last one of the last point, and what the weights are longer by.
    fn room(&self) -> usize {
        (self.nodes + POINTS) * self.step + LANES
    }

    /// The sums of a row of cells under the weights of the points; `padded` is room for it. No mirror.
    fn gather(&self, row: &[T], padded: &mut [T], sums: &mut [T]) {
        let before = -self.start as usize;
        padded[..before].fill(T::of(0.0));
        padded[before..][..row.len()].copy_from_slice(row);
        padded[before + row.len()..].fill(T::of(0.0));
        wide(
            #[inline(always)]
            || {
                for (to, cells) in sums.iter_mut().zip((0..).step_by(self.step)) {
                    let mut lanes = [T::of(0.0); LANES];
                    let (cells, weights) =
                        (padded[cells..].as_chunks::<LANES>().0, self.weights.as_chunks::<LANES>().0);
                    for (cells, weights) in cells.iter().zip(weights) {
                        for ((sum, p), weight) in lanes.iter_mut().zip(cells).zip(weights) {
                            *sum = *sum + *p * *weight;
                        }
                    }
                    *to = lanes.iter().fold(T::of(0.0), |a, b| a + *b);
                }
            },
        );
    }

    /// Adds to a row of cells what its points make of them; `padded` is room for it. No mirror.
    fn spread(&self, points: &[T], padded: &mut [T], row: &mut [T]) {
        wide(
            #[inline(always)]
            || match self.step {
                1 => self.between::<1>(points, padded),
                2 => self.between::<2>(points, padded),
                4 => self.between::<4>(points, padded),
                _ => self.between::<LANES>(points, padded),
            },
        );
        // The first steps that are worked out are those behind point 2.
        let before = (-self.start) as usize - 5 * self.step;
        add(row, T::of(1.0), &padded[before..][..self.cells]);
    }

    /// The cells of the steps behind point 2 and those after it, `W` at a time.
    #[inline(always)]
    fn between<const W: usize>(&self, points: &[T], padded: &mut [T]) {
        let weights: [&[[T; W]]; POINTS] =
            std::array::from_fn(|k| self.weights[(POINTS - 1 - k) * self.step..][..self.step].as_chunks().0);
        for (points, cells) in points.windows(POINTS).zip(padded.chunks_exact_mut(self.step)) {
            for (m, cells) in cells.as_chunks_mut::<W>().0.iter_mut().enumerate() {
                let mut sums = [T::of(0.0); W];
                for (point, weights) in points.iter().zip(&weights) {
                    for (sum, weight) in sums.iter_mut().zip(&weights[m]) {
                        *sum = *sum + *point * *weight;
                    }
                }
                *cells = sums;
            }
        }
    }

    /// Calls with the weight of a point in each of these cells.
    fn cells(&self, node: usize, cells: &Range<usize>, mut with: impl FnMut(T, usize)) {
        let first = self.start + (node * self.step) as isize;
        let end = first + (POINTS * self.step) as isize;
        for cell in first.max(cells.start as isize)..end.min(cells.end as isize) {
            let mut weight = self.weights[(cell - first) as usize];
            let image = -1 - cell;
            if self.mirrored && image >= first {
                weight = weight + self.weights[(image - first) as usize];
            }
            with(weight, cell as usize);
        }
        // Cells whose images alone are in its steps.
        if self.mirrored && first < 0 {
            for cell in (end.max(0)..-first).filter(|cell| cells.contains(&(*cell as usize))) {
                with(self.weights[(-1 - cell - first) as usize], cell as usize);
            }
        }
    }

    /// The weights of a cell and their points.
    fn points(&self, cell: usize) -> impl Iterator<Item = (T, usize)> + '_ {
        let from_start = cell as isize - self.start;
        let behind = from_start.div_euclid(self.step as isize) - 3;
        let within = from_start.rem_euclid(self.step as isize) as usize;
        (0..POINTS).map(move |point| {
            let node = behind + point as isize - 2;
            let node = if node < 0 { -1 - node } else { node };
            (self.weights[(POINTS - 1 - point) * self.step + within], node as usize)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::convolution::Convolution;
    use super::super::operator::compliance;
    use super::super::region::Region;
    use super::*;
    use crate::grid::Kernel;

    #[test]
    fn needle_cells_take_no_more_room_than_all_of_them() {
        for h in [[1e-9, 1.0], [1.0, 1e-9], [1e-300, 1.0]] {
            let table = InfluenceTable::new(Kernel::Galerkin, h, [64, 64]);
            let split = Split::<f64>::new(&table, 1.0, [64, 64], false, &Scratch::new());
            let room = |spread: &Spread<f64>| spread.weights.len();
            assert!(split.is_none_or(|split| room(&split.along).max(room(&split.across)) <= POINTS * 64 + LANES));
        }
    }

    #[test]
    fn the_two_parts_make_the_whole() {
        for (shape, h, mirrored) in [
            ([160, 150], [1.0, 1.0], false),
            ([160, 150], [1.0, 1.0], true),
            ([301, 129], [0.25, 0.5], false),
            ([401, 139], [0.09, 0.5], true),
            ([150, 401], [1.0, 0.3], true),
            ([600, 90], [1.0, 1.0], true),
        ] {
            let halves = if mirrored { 2 } else { 1 };
            let table = InfluenceTable::new(Kernel::Galerkin, h, [shape[0], halves * shape[1]]);
            let scale = 1.0 / table.row(0)[0];
            let split = Split::<f64>::new(&table, scale, shape, mirrored, &Scratch::new()).expect("worth it");
            let whole = Convolution::<f64>::new(
                shape,
                &compliance(&table, scale, shape, &Region::whole(shape), mirrored, &Scratch::new()),
            );
            let p: Vec<f64> = (0..shape[0] * shape[1])
                .map(|k| {
                    let (i, j) = (k % shape[0], k / shape[0]);
                    f64::from(u8::from((i * 7919 + j * 104_729) % 37 < 11 || i < 20 && j < 9))
                })
                .collect();
            let [mut a, mut b] = [(); 2].map(|()| vec![0.0; p.len()]);
            let mut scratch = Scratch::new();
            let given = 0..shape[1] - 3;
            let p: Vec<f64> =
                p.into_iter().enumerate().map(|(k, p)| if k < shape[0] * given.end { p } else { 0.0 }).collect();
            whole.product(&p, given.clone(), &mut a, 0..shape[1], &mut scratch);
            Convolution::Split(Box::new(split)).product(&p, given, &mut b, 2..shape[1], &mut scratch);
            let largest = a.iter().copied().fold(0.0, f64::max);
            let off = a.iter().zip(&b).skip(2 * shape[0]).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(off < 2e-5 * largest, "{shape:?} {h:?} {mirrored}: {:e}", off / largest);
        }
    }
}
