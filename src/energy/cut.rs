//! The residual f - u in one cell, quarter by quarter: where the overlap has a kink or an end, and where the extension fades.

use super::basis::{BENDS, DEGREES, of_taylor};
use super::expansion::Expansion;
use super::field::Field;
use super::lane::{LANES, Lane, add};
use super::overlap::{OverlapBounds, Taylor};
use super::quarter::{CORNERS, INNER, LATTICE, MISSED, POINTS, Rule, WEIGHTS};
use crate::numeric::geometry::Rect;

/// f over a sub-square: a polynomial about the centre of the cell, and how far f may be from it.
#[derive(Clone, Copy)]
struct Piece {
    taylor: Taylor,
    /// Whether w >= f - u has to hold: there may be material.
    bound: bool,
}

/// The displacement in a cell, ready to be compared with the overlap.
pub(super) struct Cell<'a> {
    field: &'a Field,
    overlap: &'a dyn OverlapBounds,
    rect: Rect,
    expansion: Expansion,
    /// u = sum of these c_k P_k + sum of jumps L_j: row b, column a.
    polynomial: [[f64; 5]; 5],
    /// Largest |u_ss| and |u_tt| of the polynomial part, times 1/8.
    bend: [f64; 2],
    /// What the expansion leaves out of a displacement.
    most: f64,
    /// Largest jump.
    largest: f64,
    whole: Option<Piece>,
}

/// Bounds of a value of which nothing is known, and those of no value.
const ANYTHING: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Integrals of |grad w|^2 and w^2 over a quarter or more.
pub(super) type Integrals = [f64; 2];

/// Sign of each coordinate in a quarter; bit 0: s > 0, bit 1: t > 0.
fn signs(quarter: usize) -> [f64; 2] {
    [0, 1].map(|m| if quarter >> m & 1 == 1 { 1.0 } else { -1.0 })
}

/// A Taylor polynomial in longer sides of a cell.
pub(super) fn scaled(taylor: &Taylor, scale: f64) -> Taylor {
    let (two, three) = (scale, scale * scale);
    let by = [1.0 / scale, 1.0, 1.0, two, two, two, three, three, three, three];
    Taylor {
        terms: std::array::from_fn(|k| taylor.terms[k] * by[k]),
        rest: [taylor.rest[0] / scale, taylor.rest[1]],
        most: [taylor.most[0] / scale, taylor.most[1]],
        bend: taylor.bend.map(|b| b * scale),
    }
}

/// Largest displacement within a cell by cell means of size 1 around it: the square of 1.676.
const NODAL: f64 = 3.0;

/// Bound of what the expansion of a displacement leaves out.
pub(super) fn left_out(field: &Field) -> f64 {
    field.strongest * (field.tables.most[0] + field.tables.most[1]) + NODAL * field.rounding
}

/// Share of the largest jump of the pressure that the gradient of f may be in doubt by before f is looked at more closely.
const CLOSE: f64 = 0.02;

/// The same of the largest pressure, however small the jumps.
const NEGLIGIBLE: f64 = 1e-4;

impl<'a> Cell<'a> {
    pub fn new(field: &'a Field, overlap: &'a dyn OverlapBounds, rect: Rect, expansion: Expansion) -> Self {
        let rule = &field.tables.rule;
        let mut flat = expansion.polynomial;
        let mut largest = 0.0_f64;
        for (jump, projection) in expansion.jumps.iter().zip(&rule.projections).filter(|(v, _)| **v != 0.0) {
            flat.iter_mut().zip(projection).for_each(|(c, p)| *c -= jump * p);
            largest = largest.max(jump.abs());
        }
        let mut polynomial = [[0.0; 5]; 5];
        let mut bend = [0.0; 2];
        for (c, [a, b]) in flat.into_iter().zip(DEGREES) {
            polynomial[b][a] = c;
            bend[0] += 0.125 * c.abs() * BENDS[a];
            bend[1] += 0.125 * c.abs() * BENDS[b];
        }
        let most = left_out(field);
        Self { field, overlap, rect, expansion, polynomial, bend, most, largest, whole: None }
    }

    /// Looks for one polynomial that is close to f in the whole cell.
    pub fn with_overlap(mut self) -> Self {
        self.whole = self.smooth(&self.rect).filter(|piece| self.close(piece));
        self
    }

    fn close(&self, piece: &Piece) -> bool {
        piece.taylor.rest[1] <= (CLOSE * self.largest).max(NEGLIGIBLE * self.field.strongest)
    }

    /// f where it is smooth.
    fn smooth(&self, rect: &Rect) -> Option<Piece> {
        let jet = self.overlap.jet(rect)?;
        let [w, h] = rect.size();
        // Where f is smooth there is material.
        Some(self.piece(rect, Taylor::of(&jet, [0.5 * w, 0.5 * h]), true))
    }

    fn piece(&self, rect: &Rect, taylor: Taylor, material: bool) -> Piece {
        let (c, at) = (self.rect.centre(), rect.centre());
        let back = [0, 1].map(|m| (c[m] - at[m]) / self.field.scale);
        Piece { taylor: scaled(&taylor, self.field.scale).moved(back), bound: material && self.overlap.binds() }
    }

    /// f anywhere: the middle of its bounds.
    fn rough(&self, rect: &Rect) -> Piece {
        let slopes = self.overlap.slopes(rect);
        let slope = slopes.map(|[low, high]| 0.5 * (low + high));
        let [low, high] = self.overlap.bounds(rect, slope);
        let open = slopes.map(|[low, high]| 0.5 * (high - low));
        let rest = [0.5 * (high - low), open[0].hypot(open[1])];
        let mut terms = [0.0; 10];
        (terms[0], terms[1], terms[2]) = (0.5 * (low + high), slope[0], slope[1]);
        let taylor = Taylor { terms, rest, most: rest, bend: [0.0; 2] };
        self.piece(rect, taylor, self.overlap.material(rect))
    }

    /// The part of the cell from `low` to `high` of half a side in the quarter.
    fn part(&self, quarter: usize, low: [f64; 2], high: [f64; 2]) -> Rect {
        let (c, size, sign) = (self.rect.centre(), self.rect.size(), signs(quarter));
        let ends = [0, 1].map(|m| [low[m], high[m]].map(|s| c[m] + sign[m] * s * size[m]));
        Rect { min: ends.map(|[a, b]| a.min(b)), max: ends.map(|[a, b]| a.max(b)) }
    }

    /// f over a quarter, or over its four sub-squares.
    fn pieces(&self, quarter: usize) -> Pieces {
        if let Some(piece) = self.whole {
            return Pieces::One(piece);
        }
        if let Some(piece) = self.smooth(&self.part(quarter, [0.0; 2], [0.5; 2])).filter(|piece| self.close(piece)) {
            return Pieces::One(piece);
        }
        Pieces::Four(std::array::from_fn(|k| {
            let place = [k % 2, k / 2];
            let rect = self.part(quarter, place.map(|n| LATTICE[2 * n]), place.map(|n| LATTICE[2 * n + 2]));
            let smooth = self.smooth(&rect);
            if let Some(close) = smooth.filter(|piece| self.close(piece)) {
                return close;
            }
            // Close to a tip second derivatives have no bound, and slopes have.
            let rough = self.rough(&rect);
            smooth.filter(|piece| !(piece.taylor.rest[1] > rough.taylor.rest[1])).unwrap_or(rough)
        }))
    }

    /// Integrals over a quarter of w = max(r, chi r), r = f - u; chi is bilinear with the values `fade` at the centre of the cell, the
    /// middle of the side along x, that along y, and the corner.
    pub fn integrals(&self, quarter: usize, fade: [f64; 4]) -> Integrals {
        let pieces = self.pieces(quarter);
        let turned = Turned::new(self, quarter, pieces.get(0));
        let full = fade == [1.0; 4];
        let mut kinds = [if full { Sign::Positive } else { Sign::Negative }; 4];
        if !full {
            let corners = turned.corners();
            for (square, kind) in kinds.iter_mut().enumerate().filter(|(square, _)| pieces.get(*square).bound) {
                *kind = turned.sign(square, pieces.get(square), &corners);
            }
            if fade == [0.0; 4] && kinds == [Sign::Negative; 4] {
                return [0.0; 2];
            }
        }
        let sums = turned.sums(&pieces, fade);
        let [hx, hy] = self.field.tables.h;
        let (area, shortest) = (hx * hy / 16.0, hx.min(hy));
        let steepest = if full { 0.0 } else { 2.0 * (1.0 / (hx * hx) + 1.0 / (hy * hy)).sqrt() };
        let mut total = [0.0; 2];
        let mut missed = 0.0;
        for square in 0..4 {
            let piece = pieces.get(square);
            if square == 0 || matches!(pieces, Pieces::Four(_)) {
                missed = self.missed(piece);
            }
            if kinds[square] == Sign::Negative && fade == [0.0; 4] {
                continue;
            }
            let more = [MISSED[square][0] / shortest * missed, MISSED[square][1] * shortest * missed];
            let part = sums[square].bound(kinds[square], &piece.taylor, area, steepest, more);
            (0..2).for_each(|m| total[m] += part[m]);
        }
        total
    }

    /// Bounds of r all over a quarter, in longer sides.
    pub fn range(&self, quarter: usize) -> [f64; 2] {
        let pieces = self.pieces(quarter);
        let turned = Turned::new(self, quarter, pieces.get(0));
        let corners = turned.corners();
        let ranges = [0, 1, 2, 3].map(|square| turned.range(square, pieces.get(square), &corners));
        ranges.into_iter().fold(NOTHING, |[low, high], [a, b]| [low.min(a), high.max(b)])
    }

    /// What the rule may miss of the integrals over a sub-square ([`MISSED`]).
    fn missed(&self, piece: &Piece) -> f64 {
        let mut c = self.expansion.polynomial;
        for (k, f) in of_taylor(&piece.taylor.terms, self.field.tables.h) {
            c[k] -= f;
        }
        let mut sum = self.expansion.jumps.iter().map(|v| v * v).sum::<f64>();
        for (c, [a, b]) in c.iter().zip(DEGREES) {
            sum += WEIGHTS[a.max(b)] * c * c;
        }
        sum
    }

    /// Whether r <= 0 all over a quarter, by its corners alone.
    pub fn clear_quarter(&self, quarter: usize) -> bool {
        let turned = Turned::without_overlap(self, quarter);
        let corners = turned.corners();
        let last = CORNERS - 1;
        // -u at the corners: bilinear through them, a mean, slopes and a twist.
        let [a, b, c, d] = [corners[0][0], corners[0][last], corners[last][0], corners[last][last]].map(|r| -r);
        let (sign, h) = (signs(quarter), self.field.tables.h);
        let slope = [sign[0] * (b - a + d - c) / h[0], sign[1] * (c - a + d - b) / h[1]];
        let lowest = 0.25 * (a + b + c + d) - 0.25 * (a - b - c + d).abs();
        let bends = &self.field.tables.rule.bends[4];
        let singular: f64 = turned.jumps.iter().zip(bends).map(|(v, bend)| v.abs() * bend).sum();
        let rect = self.part(quarter, [0.0; 2], [0.5; 2]);
        let [_, high] = self.overlap.bounds(&rect, slope);
        high / self.field.scale <= lowest - 0.25 * (self.bend[0] + self.bend[1]) - singular - self.most
    }
}

/// f in a quarter. Made and used in one place, a cell at a time: a box would cost more than the room.
#[allow(clippy::large_enum_variant)]
enum Pieces {
    One(Piece),
    Four([Piece; 4]),
}

impl Pieces {
    fn get(&self, square: usize) -> &Piece {
        match self {
            Self::One(piece) => piece,
            Self::Four(pieces) => &pieces[square],
        }
    }
}

/// A quarter turned to s, t > 0.
struct Turned<'a> {
    cell: &'a Cell<'a>,
    sign: [f64; 2],
    /// r = sum of these c_k P_k - sum of jumps L_j, f that of the first sub-square: row b, column a.
    polynomial: [[f64; 5]; 5],
    jumps: [f64; 8],
    /// f of the first sub-square.
    first: Option<[f64; 10]>,
}

impl<'a> Turned<'a> {
    fn new(cell: &'a Cell<'a>, quarter: usize, piece: &Piece) -> Self {
        let mut turned = Self { first: Some(piece.taylor.terms), ..Self::without_overlap(cell, quarter) };
        for (k, f) in of_taylor(&piece.taylor.terms, cell.field.tables.h) {
            let [a, b] = DEGREES[k];
            turned.polynomial[b][a] += if turned.odd(a, b) { -f } else { f };
        }
        turned
    }

    /// With f = 0.
    fn without_overlap(cell: &'a Cell<'a>, quarter: usize) -> Self {
        let sign = signs(quarter);
        // (x, y) in the order of the cells that touch: -1, 0, 1 along x fastest, the middle left out.
        let place = |x: usize, y: usize| {
            let n = 3 * y + x;
            if n > 4 { n - 1 } else { n }
        };
        let flip = |n: usize, sign: f64| if sign < 0.0 { 2 - n } else { n };
        let jumps = std::array::from_fn(|j| {
            let n = if j > 3 { j + 1 } else { j };
            cell.expansion.jumps[place(flip(n % 3, sign[0]), flip(n / 3, sign[1]))]
        });
        let mut turned = Self { cell, sign, polynomial: cell.polynomial, jumps, first: None };
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

    fn rule(&self) -> &'a Rule {
        &self.cell.field.tables.rule
    }

    fn loaded(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.jumps.iter().copied().enumerate().filter(|(_, v)| *v != 0.0)
    }

    /// r on the lattice of corners, as if f were that of the first sub-square everywhere.
    fn corners(&self) -> [Lane; CORNERS] {
        let (along, across) = &self.rule().corners;
        let rows = self.polynomial.map(|c| combination(&c, along));
        let mut r = across.map(|p| combination(&p, &rows));
        for (j, v) in self.loaded() {
            r.iter_mut().zip(&self.rule().at_corners[j]).for_each(|(r, l)| add(r, -v, l));
        }
        r
    }

    fn sign(&self, square: usize, piece: &Piece, corners: &[Lane; CORNERS]) -> Sign {
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
    fn range(&self, square: usize, piece: &Piece, corners: &[Lane; CORNERS]) -> [f64; 2] {
        let (rule, cell, h) = (self.rule(), self.cell, self.rule().h);
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
        let off = (cell.bend[0] + cell.bend[1]) * q2
            + 0.125 * q2 * (bend[0] * h[0] * h[0] + bend[1] * h[1] * h[1])
            + singular
            + piece.taylor.most[0]
            + cell.most;
        if off.is_nan() { ANYTHING } else { [range[0] - off, range[1] + off] }
    }

    /// f of a sub-square less that of the first, turned; `None` where they are the same.
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
    fn sums(&self, pieces: &Pieces, fade: [f64; 4]) -> [Sums; 4] {
        let rule = self.rule();
        let [hx, hy] = rule.h;
        let [values, slopes] = &rule.along;
        let along = self.polynomial.map(|c| combination(&c, values));
        let steep = self.polynomial.map(|c| combination(&c, slopes));
        let mut lanes = [[[0.0; LANES]; 5]; 2];
        let s: Lane = std::array::from_fn(|k| 2.0 * rule.places.get(k).copied().unwrap_or(0.0));
        let more: [Option<Taylor>; 4] = match pieces {
            Pieces::One(_) => [None; 4],
            Pieces::Four(pieces) => pieces.map(|piece| self.beyond_first(&piece)),
        };
        for y in 0..POINTS {
            let mut r = combination(&rule.across[0][y], &along);
            let mut rx = combination(&rule.across[0][y], &steep);
            let mut ry = combination(&rule.across[1][y], &along);
            for k in 0..LANES {
                rx[k] /= hx;
                ry[k] /= hy;
            }
            for (j, v) in self.loaded() {
                let [l, lx, ly] = &rule.singular[j][y];
                add(&mut r, -v, l);
                add(&mut rx, -v, lx);
                add(&mut ry, -v, ly);
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
            let [rr, ww, rw, v, vw] = &mut lanes[outer];
            for k in 0..LANES {
                let chi = near + s[k] * (far - near);
                let chi_y = low + s[k] * (high - low);
                let (wx, wy, w) = (chi * rx[k] + chi_x * r[k], chi * ry[k] + chi_y * r[k], chi * r[k]);
                rr[k] += weight * (rx[k] * rx[k] + ry[k] * ry[k]);
                ww[k] += weight * (wx * wx + wy * wy);
                rw[k] += weight * (rx[k] * wx + ry[k] * wy);
                v[k] += weight * r[k] * r[k];
                vw[k] += weight * w * w;
            }
        }
        std::array::from_fn(|square| {
            let along = if square % 2 == 0 { 0..INNER } else { INNER..POINTS };
            let sum = |n: usize| along.clone().map(|x| rule.weights[x] * lanes[square / 2][n][x]).sum::<f64>();
            Sums { slopes: [sum(0), sum(1), sum(2)], values: [sum(3), sum(4)] }
        })
    }
}

/// Sum of c_a times the a-th row.
#[inline(always)]
fn combination(c: &[f64; 5], rows: &[Lane; 5]) -> Lane {
    std::array::from_fn(|k| {
        (c[0] * rows[0][k] + c[1] * rows[1][k]) + (c[2] * rows[2][k] + c[3] * rows[3][k]) + c[4] * rows[4][k]
    })
}

/// Of r in a sub-square; zero counts as either.
#[derive(Clone, Copy, PartialEq)]
enum Sign {
    Negative,
    Positive,
    Mixed,
}

/// Integrals over a sub-square.
#[derive(Clone, Copy)]
struct Sums {
    /// |grad r|^2, |grad(chi r)|^2, and their product grad r . grad(chi r).
    slopes: [f64; 3],
    /// r^2, (chi r)^2.
    values: [f64; 2],
}

impl Sums {
    /// Of |grad w|^2 and w^2. Where r may have either sign, |grad w| is one of a = |grad r|, b = |grad(chi r)|, and
    /// max(a^2, b^2) = (a^2 + b^2 + |a^2 - b^2|)/2 with the integral of |a^2 - b^2| <= |grad r - grad chi r| |grad r + grad chi r|.
    fn bound(&self, sign: Sign, taylor: &Taylor, area: f64, steepest: f64, missed: [f64; 2]) -> Integrals {
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

#[cfg(test)]
mod tests {
    use super::super::expansion::{Expansions, Workspace};
    use super::super::overlap::Plane;
    use super::super::potential::Corners;
    use super::*;
    use crate::grid::Grid;

    #[test]
    fn displacement_in_every_quarter_is_that_of_sums() {
        for spacing in [[0.1, 0.1], [0.06, 0.08]] {
            let grid = Grid { origin: [0.3, -0.2], spacing, shape: [26, 24] };
            let p: Vec<f64> = (0..grid.len())
                .map(|k| {
                    let (x, y) = ((k % 26) as f64 / 13.0 - 1.0, (k / 26) as f64 / 12.0 - 1.0);
                    (0.8 - x * x - y * y).max(0.0).sqrt()
                })
                .collect();
            let direct = |x: f64, y: f64| {
                let mut u = [0.0; 3];
                for (k, p) in p.iter().enumerate().filter(|(_, p)| **p != 0.0) {
                    let c = grid.centre_of(k);
                    let (dx, dy) = (x - c[0], y - c[1]);
                    let (a, b) = (0.5 * spacing[0], 0.5 * spacing[1]);
                    let one = Corners::new(&[dx - a, dx + a], &[dy - b, dy + b]).cell([0, 1], [0, 1]);
                    (0..3).for_each(|k| u[k] += p * one[k]);
                }
                u
            };
            let field = Field::new(&grid, &p).unwrap();
            // f = 0: integrals of u^2 and its slopes over the quarters, by the points of the rule.
            let plane = Plane { level: 0.0, slope: [0.0; 2] };
            for [i, j] in [[12, 12], [2, 8], [1, 12], [0, 12], [20, 19], [22, 19], [4, 2], [13, 1], [13, 2]] {
                let rect = grid.cell(i, j);
                let c = rect.centre();
                let lanes = Expansions::new(&field, i as isize, j as isize, &mut Workspace::new());
                let expansion = lanes.cell(&field, i as isize, j as isize, 0);
                let cell = Cell::new(&field, &plane, rect, expansion).with_overlap();
                let rule = &field.tables.rule;
                for quarter in 0..4 {
                    let sign = signs(quarter);
                    let at = |s: f64, t: f64| direct(c[0] + sign[0] * s * spacing[0], c[1] + sign[1] * t * spacing[1]);
                    let turned = Turned::new(&cell, quarter, cell.pieces(quarter).get(0));
                    for (y, row) in turned.corners().iter().enumerate() {
                        for (x, r) in row.iter().enumerate().take(CORNERS) {
                            let u = at(LATTICE[x], LATTICE[y])[0] / field.scale;
                            assert!((u + r).abs() < cell.most, "{i} {j} {quarter} {x} {y}: {u} {r}");
                        }
                    }
                    let sums = turned.sums(&cell.pieces(quarter), [1.0; 4]);
                    let (mut slopes, mut values) = ([0.0; 4], [0.0; 4]);
                    for (y, t) in rule.places.iter().enumerate() {
                        for (x, s) in rule.places.iter().enumerate() {
                            let square = usize::from(x >= INNER) + 2 * usize::from(y >= INNER);
                            let weight = rule.weights[x] * rule.weights[y] * rule.h[0] * rule.h[1];
                            let u = at(*s, *t);
                            slopes[square] += weight * (u[1] * u[1] + u[2] * u[2]);
                            values[square] += weight * (u[0] / field.scale).powi(2);
                        }
                    }
                    for square in 0..4 {
                        assert!((sums[square].slopes[0] - slopes[square]).abs() < 2e-3 * slopes[square].sqrt());
                        assert!((sums[square].values[0] - values[square]).abs() < 2e-3 * values[square].sqrt());
                        assert_eq!(sums[square].slopes[0], sums[square].slopes[1]);
                    }
                }
            }
        }
    }
}
