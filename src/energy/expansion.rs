//! The displacement in several cells of a row at a time: its polynomial and the weights of its singular functions.

use pulp::{Arch, Simd, WithSimd};

use super::basis::{CLASSES, EVEN, NODES, ODD, POLYNOMIALS};
use super::field::Field;
use super::lane::{LANES, Lane, add, combination, difference, sum};
use super::tables::WIDEST;
use super::touching::{FIRSTS, TOUCHING};

/// The displacement in [`LANES`] cells: sum of c_k P_k plus sum of z_f Z_f ([`super::tables`]).
pub(super) struct Expansions {
    pub polynomial: [Lane; POLYNOMIALS],
    pub singular: [Lane; 8],
}

/// The same in one cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expansion {
    pub polynomial: [f64; POLYNOMIALS],
    /// p_j - p_0 of the cells that touch ([`TOUCHING`]).
    pub jumps: [f64; 8],
}

/// Cells from place `k` of a row on.
#[inline(always)]
fn lane(row: &[f64], k: usize) -> &Lane {
    // Frames are wide enough for all that is read.
    row.get(k..).and_then(|row| row.first_chunk()).unwrap_or(&[f64::NAN; LANES])
}

/// Sums of the images of an input, with the signs of a class, and how many there are.
struct Inputs {
    lanes: [Lane; INPUTS],
    count: usize,
}

/// Most inputs of a class: offsets of a near block, singular functions, and the pressure itself.
const INPUTS: usize = (WIDEST + 1) * (WIDEST + 1) + 4;

impl Inputs {
    fn new() -> Self {
        Self { lanes: [[0.0; LANES]; INPUTS], count: 0 }
    }

    #[inline(always)]
    fn push(&mut self, lane: Lane) {
        self.lanes[self.count] = lane;
        self.count += 1;
    }

    /// Adds to each coefficient what its row of weights makes of the inputs: three coefficients at a time, as many as registers hold.
    #[inline(always)]
    fn onto<S: Simd>(&self, simd: S, coefficients: &mut [Lane], weights: &[f64]) {
        let n = self.count;
        let inputs = &self.lanes[..n];
        let mut rows = weights.chunks_exact(n);
        let mut threes = coefficients.chunks_exact_mut(3);
        for three in &mut threes {
            let (Some(u), Some(v), Some(w)) = (rows.next(), rows.next(), rows.next()) else { return };
            let (mut a, mut b, mut c) = (three[0], three[1], three[2]);
            for (((x, u), v), w) in inputs.iter().zip(u).zip(v).zip(w) {
                add(simd, &mut a, *u, x);
                add(simd, &mut b, *v, x);
                add(simd, &mut c, *w, x);
            }
            (three[0], three[1], three[2]) = (a, b, c);
        }
        for (last, v) in threes.into_remainder().iter_mut().zip(rows) {
            for (x, v) in inputs.iter().zip(v) {
                add(simd, last, *v, x);
            }
        }
    }
}

/// Lanes of a row with what the near block needs on either side.
const WIDEST_ROW: usize = (2 * WIDEST).div_ceil(LANES) + 1;

/// Workspace for the inputs of the four classes.
pub(super) struct Workspace([Inputs; 4]);

impl Workspace {
    pub fn new() -> Self {
        Self(std::array::from_fn(|_| Inputs::new()))
    }
}

/// Where expansions are wanted.
struct At<'a> {
    field: &'a Field,
    i: isize,
    j: isize,
    room: &'a mut Workspace,
}

impl WithSimd for At<'_> {
    type Output = Expansions;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Expansions {
        let Self { field, i, j, room } = self;
        let mut all = Expansions { polynomial: [[0.0; LANES]; POLYNOMIALS], singular: [[0.0; LANES]; 8] };
        all.nodes(simd, field, i, j);
        room.0.iter_mut().for_each(|inputs| inputs.count = 0);
        all.pressures(simd, field, i, j, room);
        for (class, inputs) in room.0.iter().enumerate() {
            inputs.onto(simd, &mut all.polynomial[CLASSES[class]..CLASSES[class + 1]], &field.tables.weights[class]);
        }
        all
    }
}

/// Cells of a row whose means make the polynomials of [`LANES`] of them, and a few more: a multiple of those.
const WIDTH: usize = 2 * LANES;

impl Expansions {
    /// In the cells (i, j), (i + 1, j), ...
    pub fn new(field: &Field, i: isize, j: isize, room: &mut Workspace) -> Self {
        Arch::new().dispatch(At { field, i, j, room })
    }

    /// I u, from the means over 7 x 7 cells.
    #[inline(always)]
    fn nodes<S: Simd>(&mut self, simd: S, field: &Field, i: isize, j: isize) {
        const { assert!(WIDTH >= LANES + 2 * NODES) };
        let row = |b: isize| -> &[f64; WIDTH] {
            field.displacements(i - NODES as isize, j + b).first_chunk().unwrap_or(&[f64::NAN; WIDTH])
        };
        // Along y first: coefficients c_0, c_2, c_4, c_1, c_3.
        let (rows, middle) = ([1, 2, 3].map(|b| [row(b), row(-b)]), row(0));
        let [a, b, c] = rows.map(|[up, down]| sum(simd, up, down));
        let sums = [*middle, a, b, c];
        let differences = rows.map(|[up, down]| difference(simd, up, down));
        for n in 0..5 {
            let column =
                if n < 3 { combination(simd, &EVEN[n], &sums) } else { combination(simd, &ODD[n - 3], &differences) };
            // Place of the first coefficient that is even in s, and of the first odd one.
            let [even, odd] = if n < 3 { [3 * n, 9 + 2 * n] } else { [15 + 3 * (n - 3), 21 + 2 * (n - 3)] };
            let at = |k: usize| lane(&column, k);
            let images = [1, 2, 3].map(|a| [at(NODES + a), at(NODES - a)]);
            let [a, b, c] = images.map(|[right, left]| sum(simd, right, left));
            let along = [*at(NODES), a, b, c];
            for (m, row) in EVEN.iter().enumerate() {
                self.polynomial[even + m] = combination(simd, row, &along);
            }
            let along = images.map(|[right, left]| difference(simd, right, left));
            for (m, row) in ODD.iter().enumerate() {
                self.polynomial[odd + m] = combination(simd, row, &along);
            }
        }
    }

    /// The near block: inputs by class, in the order of [`super::tables::Tables::weights`].
    #[inline(always)]
    fn pressures<S: Simd>(&mut self, simd: S, field: &Field, i: isize, j: isize, Workspace(classes): &mut Workspace) {
        let [nx, ny] = field.tables.near;
        let width = (2 * nx).div_ceil(LANES) + 1;
        let mut rows = [[[0.0; LANES]; WIDEST_ROW]; 2];
        let [even, along, across, both] = classes;
        for b in 0..=ny {
            let from = i - nx as isize;
            let (up, down) = (field.pressures(from, j + b as isize), field.pressures(from, j - b as isize));
            let [sums, differences] = &mut rows;
            for k in 0..width {
                let (up, down) = (lane(up, k * LANES), lane(down, k * LANES));
                (sums[k], differences[k]) = (sum(simd, up, down), difference(simd, up, down));
            }
            let (sums, differences) = (sums.as_flattened(), differences.as_flattened());
            for a in if b <= 1 { 2 } else { 0 }..=nx {
                let (right, left) = (lane(sums, nx + a), lane(sums, nx - a));
                even.push(sum(simd, right, left));
                if a > 0 {
                    along.push(difference(simd, right, left));
                }
                if b > 0 {
                    let (right, left) = (lane(differences, nx + a), lane(differences, nx - a));
                    across.push(sum(simd, right, left));
                    if a > 0 {
                        both.push(difference(simd, right, left));
                    }
                }
            }
        }
        // The cells that touch.
        let [down, middle, up] = [-1, 0, 1].map(|b| field.pressures(i - 1, j + b));
        let p = *lane(middle, 1);
        let rise = [0, 1, 2].map(|k| sum(simd, lane(up, k), lane(down, k)));
        let fall = [0, 1, 2].map(|k| difference(simd, lane(up, k), lane(down, k)));
        let minus = |times: f64, mut of: Lane| {
            add(simd, &mut of, -times, &p);
            of
        };
        let [w, e] = [lane(middle, 0), lane(middle, 2)];
        self.singular = [
            minus(2.0, sum(simd, e, w)),
            minus(2.0, rise[1]),
            minus(4.0, sum(simd, &rise[2], &rise[0])),
            difference(simd, e, w),
            difference(simd, &rise[2], &rise[0]),
            fall[1],
            sum(simd, &fall[2], &fall[0]),
            difference(simd, &fall[2], &fall[0]),
        ];
        for (class, inputs) in [even, along, across, both].into_iter().enumerate() {
            self.singular[FIRSTS[class]..FIRSTS[class + 1]].iter().for_each(|z| inputs.push(*z));
            if class == 0 {
                inputs.push(p);
            }
        }
    }

    /// That of one of the cells.
    pub fn cell(&self, field: &Field, i: isize, j: isize, k: usize) -> Expansion {
        let p = field.pressures(i + k as isize, j)[0];
        let rows = [-1, 0, 1].map(|b| field.pressures(i + k as isize - 1, j + b));
        let jump = |[a, b]: [i32; 2]| rows[(b + 1) as usize][(a + 1) as usize] - p;
        Expansion { polynomial: self.polynomial.map(|lane| lane[k]), jumps: TOUCHING.map(jump) }
    }
}
