//! The displacement in several cells of a row at a time: its polynomial and the weights of its singular functions.

use super::basis::{CLASSES, EVEN, NODES, ODD, POLYNOMIALS};
use super::field::Field;
use super::lane::{LANES, Lane, add};
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

#[inline(always)]
fn sum(a: &Lane, b: &Lane) -> Lane {
    std::array::from_fn(|k| a[k] + b[k])
}

#[inline(always)]
fn difference(a: &Lane, b: &Lane) -> Lane {
    std::array::from_fn(|k| a[k] - b[k])
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

    /// Adds to each coefficient what its row of weights makes of the inputs: two coefficients at a time.
    #[inline(always)]
    fn onto(&self, coefficients: &mut [Lane], weights: &[f64]) {
        let n = self.count;
        let inputs = &self.lanes[..n];
        let mut rows = weights.chunks_exact(n);
        let mut pairs = coefficients.chunks_exact_mut(2);
        for pair in &mut pairs {
            let (Some(v), Some(w)) = (rows.next(), rows.next()) else { return };
            let (mut a, mut b) = (pair[0], pair[1]);
            for ((x, v), w) in inputs.iter().zip(v).zip(w) {
                add(&mut a, *v, x);
                add(&mut b, *w, x);
            }
            (pair[0], pair[1]) = (a, b);
        }
        if let ([last], Some(v)) = (pairs.into_remainder(), rows.next()) {
            for (x, v) in inputs.iter().zip(v) {
                add(last, *v, x);
            }
        }
    }
}

/// Room for the inputs of the four classes.
pub(super) struct Room([Inputs; 4]);

impl Room {
    pub fn new() -> Self {
        Self(std::array::from_fn(|_| Inputs::new()))
    }
}

impl Expansions {
    /// In the cells (i, j), (i + 1, j), ...
    pub fn new(field: &Field, i: isize, j: isize, room: &mut Room) -> Self {
        let mut all = Self { polynomial: [[0.0; LANES]; POLYNOMIALS], singular: [[0.0; LANES]; 8] };
        all.nodes(field, i, j);
        room.0.iter_mut().for_each(|inputs| inputs.count = 0);
        all.pressures(field, i, j, room);
        for (class, inputs) in room.0.iter().enumerate() {
            inputs.onto(&mut all.polynomial[CLASSES[class]..CLASSES[class + 1]], &field.tables.weights[class]);
        }
        all
    }

    /// I u, from the means over 7 x 7 cells.
    #[inline(always)]
    fn nodes(&mut self, field: &Field, i: isize, j: isize) {
        const WIDTH: usize = LANES + 2 * NODES;
        let row = |b: isize| -> &[f64; WIDTH] {
            field.displacements(i - NODES as isize, j + b).first_chunk().unwrap_or(&[f64::NAN; WIDTH])
        };
        // Along y first: coefficients c_0, c_2, c_4, c_1, c_3.
        let middle = row(0);
        let mut sums = [*middle; NODES + 1];
        let mut differences = [[0.0; WIDTH]; NODES];
        for b in 0..NODES {
            let (up, down) = (row(b as isize + 1), row(-(b as isize) - 1));
            for k in 0..WIDTH {
                sums[b + 1][k] = up[k] + down[k];
                differences[b][k] = up[k] - down[k];
            }
        }
        for n in 0..5 {
            let mut column = [0.0; WIDTH];
            if n < 3 {
                for (sum, weight) in sums.iter().zip(EVEN[n]) {
                    (0..WIDTH).for_each(|k| column[k] += weight * sum[k]);
                }
            } else {
                for (difference, weight) in differences.iter().zip(ODD[n - 3]) {
                    (0..WIDTH).for_each(|k| column[k] += weight * difference[k]);
                }
            }
            // Place of the first coefficient that is even in s, and of the first odd one.
            let [even, odd] = if n < 3 { [3 * n, 9 + 2 * n] } else { [15 + 3 * (n - 3), 21 + 2 * (n - 3)] };
            let at = |k: usize| lane(&column, k);
            let [a, b, c] = [1, 2, 3].map(|a| sum(at(NODES + a), at(NODES - a)));
            for (m, [v, w, x, y]) in EVEN.into_iter().enumerate() {
                let middle = at(NODES);
                self.polynomial[even + m] = std::array::from_fn(|k| (v * middle[k] + w * a[k]) + (x * b[k] + y * c[k]));
            }
            let [a, b, c] = [1, 2, 3].map(|a| difference(at(NODES + a), at(NODES - a)));
            for (m, [w, x, y]) in ODD.into_iter().enumerate() {
                self.polynomial[odd + m] = std::array::from_fn(|k| w * a[k] + x * b[k] + y * c[k]);
            }
        }
    }

    /// The near block: inputs by class, in the order of [`super::tables::Tables::weights`].
    #[inline(always)]
    fn pressures(&mut self, field: &Field, i: isize, j: isize, Room(classes): &mut Room) {
        let [nx, ny] = field.tables.near;
        let width = LANES + 2 * nx;
        let mut rows = [[0.0; LANES + 2 * WIDEST]; 2];
        let [even, along, across, both] = classes;
        for b in 0..=ny {
            let from = i - nx as isize;
            let (up, down) = (field.pressures(from, j + b as isize), field.pressures(from, j - b as isize));
            let [sums, differences] = &mut rows;
            for ((s, d), (u, l)) in sums.iter_mut().zip(differences.iter_mut()).zip(up.iter().zip(down)).take(width) {
                (*s, *d) = (u + l, u - l);
            }
            for a in if b <= 1 { 2 } else { 0 }..=nx {
                let (right, left) = (lane(sums, nx + a), lane(sums, nx - a));
                even.push(sum(right, left));
                if a > 0 {
                    along.push(difference(right, left));
                }
                if b > 0 {
                    let (right, left) = (lane(differences, nx + a), lane(differences, nx - a));
                    across.push(sum(right, left));
                    if a > 0 {
                        both.push(difference(right, left));
                    }
                }
            }
        }
        // The cells that touch.
        let [down, middle, up] = [-1, 0, 1].map(|b| field.pressures(i - 1, j + b));
        let p = *lane(middle, 1);
        let at = |row, k| lane(row, k);
        let (e, w) = (at(middle, 2), at(middle, 0));
        let (n, s) = (at(up, 1), at(down, 1));
        let (ne, nw, se, sw) = (at(up, 2), at(up, 0), at(down, 2), at(down, 0));
        for k in 0..LANES {
            let p = p[k];
            let (right, left) = (ne[k] + se[k], nw[k] + sw[k]);
            self.singular[0][k] = e[k] + w[k] - 2.0 * p;
            self.singular[1][k] = n[k] + s[k] - 2.0 * p;
            self.singular[2][k] = right + left - 4.0 * p;
            self.singular[3][k] = e[k] - w[k];
            self.singular[4][k] = right - left;
            self.singular[5][k] = n[k] - s[k];
            self.singular[6][k] = (ne[k] + nw[k]) - (se[k] + sw[k]);
            self.singular[7][k] = (ne[k] - nw[k]) - (se[k] - sw[k]);
        }
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
