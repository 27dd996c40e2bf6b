//! The residual f - u in one cell, quarter by quarter: where the overlap has a kink or an end, and where the extension fades.

use super::basis::{BENDS, DEGREES, of_taylor};
use super::expansion::Expansion;
use super::field::Field;
use super::overlap::{OverlapBounds, Taylor};
use super::quarter::{CORNERS, LATTICE, MISSED, WEIGHTS};
use super::turned::{Displacement, Integrals, NOTHING, Piece, Pieces, Sign, Turned, signs};
use crate::numeric::geometry::Rect;

/// The displacement in a cell, ready to be compared with the overlap.
pub(super) struct Cell<'a> {
    u: Displacement<'a>,
    overlap: &'a dyn OverlapBounds,
    rect: Rect,
    /// Largest jump.
    largest: f64,
    whole: Option<Piece>,
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
const CLOSE: f64 = 0.05;

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
        let u = Displacement { field, expansion, polynomial, bend, most };
        Self { u, overlap, rect, largest, whole: None }
    }

    /// Looks for one polynomial that is close to f in the whole cell.
    pub fn with_overlap(mut self) -> Self {
        self.whole = self.smooth(&self.rect).filter(|piece| self.close(piece));
        self
    }

    fn close(&self, piece: &Piece) -> bool {
        !self.overlap.is_worth_parts()
            || piece.taylor.rest[1] <= (CLOSE * self.largest).max(NEGLIGIBLE * self.u.field.strongest)
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
        let back = [0, 1].map(|m| (c[m] - at[m]) / self.u.field.scale);
        Piece { taylor: scaled(&taylor, self.u.field.scale).moved(back), bound: material && self.overlap.binds() }
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
        let ends = [0, 1].map(|m| {
            [low[m], high[m]].map(|s| (c[m] + sign[m] * s * size[m]).clamp(self.rect.min[m], self.rect.max[m]))
        });
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
        let turned = Turned::new(&self.u, quarter, pieces.get(0));
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
        let [hx, hy] = self.u.field.tables.h;
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
        let turned = Turned::new(&self.u, quarter, pieces.get(0));
        let corners = turned.corners();
        let ranges = [0, 1, 2, 3].map(|square| turned.range(square, pieces.get(square), &corners));
        ranges.into_iter().fold(NOTHING, |[low, high], [a, b]| [low.min(a), high.max(b)])
    }

    /// What the rule may miss of the integrals over a sub-square ([`MISSED`]).
    fn missed(&self, piece: &Piece) -> f64 {
        let mut c = self.u.expansion.polynomial;
        for (k, f) in of_taylor(&piece.taylor.terms, self.u.field.tables.h) {
            c[k] -= f;
        }
        let mut sum = self.u.expansion.jumps.iter().map(|v| v * v).sum::<f64>();
        for (c, [a, b]) in c.iter().zip(DEGREES) {
            sum += WEIGHTS[a.max(b)] * c * c;
        }
        sum
    }

    /// Whether r <= 0 all over a quarter, by its corners alone.
    pub fn clear_quarter(&self, quarter: usize) -> bool {
        let turned = Turned::without_overlap(&self.u, quarter);
        let corners = turned.corners();
        let last = CORNERS - 1;
        // -u at the corners: bilinear through them, a mean, slopes and a twist.
        let [a, b, c, d] = [corners[0][0], corners[0][last], corners[last][0], corners[last][last]].map(|r| -r);
        let (sign, h) = (signs(quarter), self.u.field.tables.h);
        let slope = [sign[0] * (b - a + d - c) / h[0], sign[1] * (c - a + d - b) / h[1]];
        let lowest = 0.25 * (a + b + c + d) - 0.25 * (a - b - c + d).abs();
        let bends = &self.u.field.tables.rule.bends[4];
        let singular: f64 = turned.jumps.iter().zip(bends).map(|(v, bend)| v.abs() * bend).sum();
        let rect = self.part(quarter, [0.0; 2], [0.5; 2]);
        let [_, high] = self.overlap.bounds(&rect, slope);
        high / self.u.field.scale <= lowest - 0.25 * (self.u.bend[0] + self.u.bend[1]) - singular - self.u.most
    }
}

#[cfg(test)]
mod tests {
    use super::super::expansion::{Expansions, Workspace};
    use super::super::overlap::{Interval, Jet};
    use super::super::potential::Corners;
    use super::super::quarter::INNER;
    use super::*;
    use crate::grid::Grid;

    /// The plane c + a x + b y, without end; nothing has to lie above it.
    struct Plane {
        /// c, its value at the origin.
        level: f64,
        /// (a, b).
        slope: [f64; 2],
    }

    impl Plane {
        fn around(&self, [x, y]: [f64; 2]) -> Interval {
            let terms = [self.level, self.slope[0] * x, self.slope[1] * y];
            let (sum, size) = (terms.iter().sum::<f64>(), terms.iter().map(|t| t.abs()).sum::<f64>());
            [sum - 2.0 * f64::EPSILON * size, sum + 2.0 * f64::EPSILON * size]
        }
    }

    impl OverlapBounds for Plane {
        fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Interval {
            let ([low, high], [w, h]) = (self.around(rect.centre()), rect.size());
            let swing = 0.5 * ((self.slope[0] - slope[0]).abs() * w + (self.slope[1] - slope[1]).abs() * h);
            let swing = swing * (1.0 + 8.0 * f64::EPSILON);
            [low - swing, high + swing]
        }

        fn slopes(&self, _rect: &Rect) -> [Interval; 2] {
            self.slope.map(|s| [s; 2])
        }

        fn jet(&self, rect: &Rect) -> Option<Jet> {
            Some(Jet { value: self.around(rect.centre()), gradient: self.slope.map(|s| [s; 2]), ..Jet::default() })
        }

        fn mean(&self, rect: &Rect) -> Interval {
            self.around(rect.centre())
        }

        fn binds(&self) -> bool {
            false
        }

        fn reach(&self) -> Option<Rect> {
            None
        }
    }

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
                    let turned = Turned::new(&cell.u, quarter, cell.pieces(quarter).get(0));
                    for (y, row) in turned.corners().iter().enumerate() {
                        for (x, r) in row.iter().enumerate().take(CORNERS) {
                            let u = at(LATTICE[x], LATTICE[y])[0] / field.scale;
                            assert!((u + r).abs() < cell.u.most, "{i} {j} {quarter} {x} {y}: {u} {r}");
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
