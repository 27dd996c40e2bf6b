//! The residual in a quarter of a cell, turned so that the middle of the cell is at its lower left.

use pulp::{Arch, Simd, WithSimd};

use super::basis::{DEGREES, of_taylor};
use super::expansion::Expansion;
use super::field::Field;
use super::lane::{LANES, Lane, add, add_product, add_square, combination};
use super::overlap::Taylor;
use super::quarter::{CORNERS, INNER, LATTICE, POINTS, Rule};

/// f over a sub-square: a polynomial about the centre of the cell, and how far f may be from it.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    pub taylor: Taylor,
    /// Whether w >= f - u has to hold: there may be material.
    pub bound: bool,
}

/// Integrals of |grad w|^2 and w^2 over a quarter or more.
pub(super) type Integrals = [f64; 2];

/// Bounds of a value of which nothing is known, and those of no value.
pub(super) const ANYTHING: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
pub(super) const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Sign of each coordinate in a quarter; bit 0: s > 0, bit 1: t > 0.
pub(super) fn signs(quarter: usize) -> [f64; 2] {
    [0, 1].map(|m| if quarter >> m & 1 == 1 { 1.0 } else { -1.0 })
}

/// The displacement in a cell.
pub(super) struct Displacement<'a> {
    pub field: &'a Field,
    pub expansion: Expansion,
    /// u = sum of these c_k P_k + sum of jumps L_j: row b, column a.
    pub polynomial: [[f64; 5]; 5],
    /// Largest |u_ss| and |u_tt| of the polynomial part, times 1/8.
    pub bend: [f64; 2],
    /// What the expansion leaves out.
    pub most: f64,
}

/// f in a quarter. Made and used in one place, a cell at a time: a box would cost more than the room.
#[allow(clippy::large_enum_variant)]
pub(super) enum Pieces {
    One(Piece),
    Four([Piece; 4]),
}

impl Pieces {
    pub fn get(&self, square: usize) -> &Piece {
        match self {
            Self::One(piece) => piece,
            Self::Four(pieces) => &pieces[square],
        }
    }
}

/// A quarter turned to s, t > 0.
pub(super) struct Turned<'a> {
    u: &'a Displacement<'a>,
    sign: [f64; 2],
    /// r = sum of these c_k P_k - sum of jumps L_j, f that of the first sub-square: row b, column a.
    polynomial: [[f64; 5]; 5],
    pub jumps: [f64; 8],
    /// f of the first sub-square.
    first: Option<[f64; 10]>,
}

impl<'a> Turned<'a> {
    pub fn new(u: &'a Displacement<'a>, quarter: usize, piece: &Piece) -> Self {
        let mut turned = Self { first: Some(piece.taylor.terms), ..Self::without_overlap(u, quarter) };
        for (k, f) in of_taylor(&piece.taylor.terms, u.field.tables.h) {
            let [a, b] = DEGREES[k];
            turned.polynomial[b][a] += if turned.odd(a, b) { -f } else { f };
        }
        turned
    }

    /// With f = 0.
    pub fn without_overlap(u: &'a Displacement<'a>, quarter: usize) -> Self {
        let sign = signs(quarter);
        // (x, y) in the order of the cells that touch: -1, 0, 1 along x fastest, the middle left out.
        let place = |x: usize, y: usize| {
            let n = 3 * y + x;
            if n > 4 { n - 1 } else { n }
        };
        let flip = |n: usize, sign: f64| if sign < 0.0 { 2 - n } else { n };
        let jumps = std::array::from_fn(|j| {
            let n = if j > 3 { j + 1 } else { j };
            u.expansion.jumps[place(flip(n % 3, sign[0]), flip(n / 3, sign[1]))]
        });
        let mut turned = Self { u, sign, polynomial: u.polynomial, jumps, first: None };
        for b in 0..5 {
            for a in 0..5 {
                if !turned.odd(a, b) {
                    turned.polynomial[b][a] *= -1.0;
                }
            }
        }
        turned
    }

    /// Whether P_a P_b changes its sign in the quarter.
    fn odd(&self, a: usize, b: usize) -> bool {
        (a % 2 == 1 && self.sign[0] < 0.0) != (b % 2 == 1 && self.sign[1] < 0.0)
    }

    #[inline(always)]
    fn rule(&self) -> &'a Rule {
        &self.u.field.tables.rule
    }

    #[inline(always)]
    fn loaded(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.jumps.iter().copied().enumerate().filter(|(_, v)| *v != 0.0)
    }

    /// r on the lattice of corners, as if f were that of the first sub-square everywhere.
    pub fn corners(&self) -> [Lane; CORNERS] {
        Arch::new().dispatch(AtCorners(self))
    }

    pub fn sign(&self, square: usize, piece: &Piece, corners: &[Lane; CORNERS]) -> Sign {
        let [low, high] = self.range(square, piece, corners);
        if high <= 0.0 {
            Sign::Negative
        } else if low >= 0.0 {
            Sign::Positive
        } else {
            Sign::Mixed
        }
    }

    /// Bounds of r in a sub-square: from its values on the lattice, and how far it may be from bilinear functions through them.
    pub fn range(&self, square: usize, piece: &Piece, corners: &[Lane; CORNERS]) -> [f64; 2] {
        let (rule, u, h) = (self.rule(), self.u, self.rule().h);
        let mut range = NOTHING;
        let more = self.beyond_first(piece);
        for y in 2 * (square / 2)..2 * (square / 2) + 3 {
            for x in 2 * (square % 2)..2 * (square % 2) + 3 {
                let mut r = corners[y][x];
                if let Some(more) = &more {
                    r += more.at([LATTICE[x] * h[0], LATTICE[y] * h[1]])[0];
                }
                if r.is_nan() {
                    return ANYTHING;
                }
                range = [range[0].min(r), range[1].max(r)];
            }
        }
        let q2 = 1.0 / 64.0;
        let bend = piece.taylor.bend;
        let singular: f64 = self.jumps.iter().zip(&rule.bends[square]).map(|(v, bend)| v.abs() * bend).sum();
        let off = (u.bend[0] + u.bend[1]) * q2
            + 0.125 * q2 * (bend[0] * h[0] * h[0] + bend[1] * h[1] * h[1])
            + singular
            + piece.taylor.most[0]
            + u.most;
        if off.is_nan() { ANYTHING } else { [range[0] - off, range[1] + off] }
    }

    /// f of a sub-square less that of the first, turned; `None` where they are the same.
    #[inline(always)]
    fn beyond_first(&self, piece: &Piece) -> Option<Taylor> {
        let first = self.first?;
        let mut terms = piece.taylor.terms;
        terms.iter_mut().zip(first).for_each(|(t, f)| *t -= f);
        if terms == [0.0; 10] {
            return None;
        }
        let [x, y] = self.sign;
        let by = [1.0, x, y, 1.0, x * y, 1.0, x, y, x, y];
        Some(Taylor { terms: std::array::from_fn(|k| terms[k] * by[k]), ..piece.taylor })
    }

    /// Integrals over the four sub-squares.
    pub fn sums(&self, pieces: &Pieces, fade: [f64; 4]) -> [Sums; 4] {
        Arch::new().dispatch(OverQuarter { turned: self, pieces, fade })
    }
}

/// What is integrated over a quarter.
struct OverQuarter<'a> {
    turned: &'a Turned<'a>,
    pieces: &'a Pieces,
    fade: [f64; 4],
}

impl WithSimd for OverQuarter<'_> {
    type Output = [Sums; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Sums; 4] {
        let Self { turned, pieces, fade } = self;
        let rule = turned.rule();
        let [hx, hy] = rule.h;
        let [values, slopes] = &rule.along;
        let mut lanes = [[[0.0; LANES]; 5]; 2];
        let along = turned.polynomial.map(|c| combination(simd, &c, values));
        let steep = turned.polynomial.map(|c| combination(simd, &c, slopes).map(|s| s / hx));
        let across = along.map(|row| row.map(|v| v / hy));
        let s: Lane = std::array::from_fn(|k| 2.0 * rule.places.get(k).copied().unwrap_or(0.0));
        let more: [Option<Taylor>; 4] = match pieces {
            Pieces::One(_) => [None; 4],
            Pieces::Four(pieces) => [0, 1, 2, 3].map(|k| turned.beyond_first(&pieces[k])),
        };
        for y in 0..POINTS {
            let mut r = combination(simd, &rule.across[0][y], &along);
            let mut rx = combination(simd, &rule.across[0][y], &steep);
            let mut ry = combination(simd, &rule.across[1][y], &across);
            for (j, v) in turned.loaded() {
                let [l, lx, ly] = &rule.singular[j][y];
                add(simd, &mut r, -v, l);
                add(simd, &mut rx, -v, lx);
                add(simd, &mut ry, -v, ly);
            }
            let outer = usize::from(y >= INNER);
            for (side, more) in more[2 * outer..2 * outer + 2].iter().enumerate() {
                let Some(more) = more else { continue };
                for x in if side == 0 { 0..INNER } else { INNER..POINTS } {
                    let e = more.at([rule.places[x] * hx, rule.places[y] * hy]);
                    (r[x], rx[x], ry[x]) = (r[x] + e[0], rx[x] + e[1], ry[x] + e[2]);
                }
            }
            let t = 2.0 * rule.places[y];
            let (near, far) = ((1.0 - t) * fade[0] + t * fade[2], (1.0 - t) * fade[1] + t * fade[3]);
            let chi_x = 2.0 / hx * (far - near);
            let (low, high) = (2.0 / hy * (fade[2] - fade[0]), 2.0 / hy * (fade[3] - fade[1]));
            let weight = rule.weights[y] * hx * hy;
            let (mut chi, mut chi_y) = ([near; LANES], [low; LANES]);
            add(simd, &mut chi, far - near, &s);
            add(simd, &mut chi_y, high - low, &s);
            let (mut wx, mut wy, mut w) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            add_product(simd, &mut w, &chi, &r);
            add(simd, &mut wx, chi_x, &r);
            add_product(simd, &mut wx, &chi, &rx);
            add_product(simd, &mut wy, &chi_y, &r);
            add_product(simd, &mut wy, &chi, &ry);
            let [rr, ww, rw, v, vw] = &mut lanes[outer];
            add_square(simd, rr, weight, &rx);
            add_square(simd, rr, weight, &ry);
            add_square(simd, ww, weight, &wx);
            add_square(simd, ww, weight, &wy);
            add_square(simd, v, weight, &r);
            add_square(simd, vw, weight, &w);
            let mut product = [0.0; LANES];
            add_product(simd, &mut product, &rx, &wx);
            add_product(simd, &mut product, &ry, &wy);
            add(simd, rw, weight, &product);
        }
        std::array::from_fn(|square| {
            let along = if square % 2 == 0 { 0..INNER } else { INNER..POINTS };
            let sum = |n: usize| along.clone().map(|x| rule.weights[x] * lanes[square / 2][n][x]).sum::<f64>();
            Sums { slopes: [sum(0), sum(1), sum(2)], values: [sum(3), sum(4)] }
        })
    }
}

/// r on the lattice of corners.
struct AtCorners<'a>(&'a Turned<'a>);

impl WithSimd for AtCorners<'_> {
    type Output = [Lane; CORNERS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Lane; CORNERS] {
        let Self(turned) = self;
        let (along, across) = &turned.rule().corners;
        let rows = turned.polynomial.map(|c| combination(simd, &c, along));
        let mut r = across.map(|p| combination(simd, &p, &rows));
        for (j, v) in turned.loaded() {
            r.iter_mut().zip(&turned.rule().at_corners[j]).for_each(|(r, l)| add(simd, r, -v, l));
        }
        r
    }
}

/// Of r in a sub-square; zero counts as either.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Sign {
    Negative,
    Positive,
    Mixed,
}

/// Integrals over a sub-square.
#[derive(Clone, Copy)]
pub(super) struct Sums {
    /// |grad r|^2, |grad(chi r)|^2, and their product grad r . grad(chi r).
    pub slopes: [f64; 3],
    /// r^2, (chi r)^2.
    pub values: [f64; 2],
}

impl Sums {
    /// Of |grad w|^2 and w^2. Where r may have either sign, |grad w| is one of a = |grad r|, b = |grad(chi r)|, and
    /// max(a^2, b^2) = (a^2 + b^2 + |a^2 - b^2|)/2 with the integral of |a^2 - b^2| <= |grad r - grad chi r| |grad r + grad chi r|.
    pub fn bound(&self, sign: Sign, taylor: &Taylor, area: f64, steepest: f64, missed: [f64; 2]) -> Integrals {
        let [r, w, x] = self.slopes;
        let (slopes, values) = match sign {
            Sign::Positive => (r + missed[0], self.values[0]),
            Sign::Negative => (w + missed[0], self.values[1]),
            Sign::Mixed => {
                let [minus, plus] = [-2.0, 2.0].map(|k| (r + w + k * x).max(0.0) + missed[0]);
                (0.5 * (r + w + (minus * plus).sqrt()) + missed[0], self.values[0])
            }
        };
        // f may be another function: by rest[0] in value and rest[1] in gradient.
        let [value, gradient] = taylor.rest;
        let more = gradient + if sign == Sign::Positive { 0.0 } else { steepest * value };
        let side = area.sqrt();
        let square = |x: f64| x * x;
        [square(slopes.sqrt() + side * more), square((values + missed[1]).sqrt() + side * value)]
    }
}
