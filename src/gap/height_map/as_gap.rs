//! What measured heights are as a gap: bilinear between their nodes.

use super::{HeightMap, MANY, ROUNDING, Zero, bilinear, mean_over};
use crate::gap::{DataEdge, Gap, Growth, Known, LeftOpen, Material, Reach, Taylor};
use crate::grid::Grid;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

impl HeightMap {
    /// What the samples leave open of the heights: their noise.
    fn open_between(&self, place: &Rect) -> LeftOpen {
        let everywhere = [0, 1].map(|m| [0, self.nodes.shape[m] - 1]);
        let noise = || Some(mean_over(self.uncertainty.as_deref()?, everywhere, self.nodes.around(place, 0)?));
        LeftOpen { noise: noise().unwrap_or(0.0), ..LeftOpen::default() }
    }

    /// What they leave open of where the bodies first touch, where depths are counted from there.
    fn open_at_zero(&self) -> LeftOpen {
        if self.zero == Zero::AsIs || self.uncertainty.is_none() {
            return LeftOpen::default();
        }
        let open = self.open_between(&Rect { min: self.centre, max: self.centre });
        open.of_least(self.gaps.iter().copied(), 0.0)
    }
}

impl Gap for HeightMap {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.locate(x, y).map_or(f64::INFINITY, |(corners, at)| bilinear(corners, at))
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let ([a, b, c, d], [s, t]) = self.locate(x, y)?;
        let along_x = ((b - a) * (1.0 - t) + (d - c) * t) / self.nodes.spacing[0];
        Some([along_x, ((c - a) * (1.0 - s) + (d - b) * s) / self.nodes.spacing[1]])
    }

    fn describe(&self) -> Known {
        Known { centre: self.centre, floor: self.floor, material: Material::Within(self.extent()), ..Known::nothing() }
    }

    fn components(&self, depth: f64) -> Option<Vec<Rect>> {
        let below = |i: usize, j: usize| self.corners(i, j).is_some_and(|c| c.iter().any(|&g| g < depth));
        Some(self.nodes.groups(below))
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let [c, r] = [0, 1].map(|m| self.nodes.parts(m, rect));
        let ([(i, _)], [(j, _)]) = (c.as_slice(), r.as_slice()) else { return None };
        let whole = self.extent();
        let on_map = (0..2).all(|m| whole.min[m] <= rect.min[m] && rect.max[m] <= whole.max[m]);
        let [a, b, c, d] = self.corners(*i, *j).filter(|_| on_map)?.map(Interval::point);
        let [x0, y0] = self.nodes.node(*i, *j);
        let [x, y] = rect.centre();
        let place = |v: f64, v0: f64, m: usize| {
            (Interval::point(v) - Interval::point(v0)) / Interval::point(self.nodes.spacing[m])
        };
        let (s, t) = (place(x, x0, 0), place(y, y0, 1));
        let one = Interval::point(1.0);
        let [dx, dy] = self.nodes.spacing.map(Interval::point);
        let (low, high) = (a * (one - s) + b * s, c * (one - s) + d * s);
        let (left, right) = (a * (one - t) + c * t, b * (one - t) + d * t);
        Taylor {
            value: (one - t) * low + t * high,
            gradient: [(right - left) / dx, (high - low) / dy],
            hessian: [Interval::ZERO, (a - b - c + d) / (dx * dy), Interval::ZERO],
        }
        .finite()
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        let whole = self.extent();
        if !(0..2).all(|m| whole.min[m] <= rect.min[m] && rect.max[m] <= whole.max[m]) {
            return None;
        }
        let [columns, rows] = [0, 1].map(|m| self.nodes.parts(m, rect));
        let [dx, dy] = self.nodes.spacing.map(Interval::point);
        let mut all: Option<[Interval; 2]> = None;
        for (j, _) in &rows {
            for (i, _) in &columns {
                // A hole is an end of the map.
                let [a, b, c, d] = self.corners(*i, *j)?.map(Interval::point);
                let along = ((b - a) / dx).union((d - c) / dx);
                let across = ((c - a) / dy).union((d - b) / dy);
                all = Some(all.map_or([along, across], |s| [s[0].union(along), s[1].union(across)]));
            }
        }
        all
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        let mean = self.mean(rect);
        if !mean.is_finite() {
            return Some([self.bounds(rect, [0.0; 2])?[0], f64::INFINITY]);
        }
        // A sum of products of the heights, and where its pieces lie to rounding.
        let [low, high] = self.extremes.over(self.nodes.blocks(rect)?);
        let steps =
            self.nodes.spacing.map(|step| rect.max.iter().chain(&rect.min).fold(0.0_f64, |m, v| m.max(v.abs())) / step);
        let rounding =
            f64::EPSILON * (16.0 * low.abs().max(high.abs()) + 4.0 * (high - low) * (steps[0] + steps[1] + 4.0));
        Some([mean - rounding, mean + rounding])
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Growth::ended(&self.extent(), from)
    }

    fn reach(&self, depth: f64) -> Reach {
        // In a cell a level line runs from edge to edge and is monotone: the edges alone bound what it encloses.
        let mut held: Option<Rect> = None;
        for j in 0..self.nodes.shape[1] - 1 {
            for i in 0..self.nodes.shape[0] - 1 {
                let Some([a, b, c, d]) = self.corners(i, j) else { continue };
                if a.min(b).min(c).min(d) >= depth {
                    continue;
                }
                for (low, high, p, q) in [
                    (a, b, [0.0, 0.0], [1.0, 0.0]),
                    (c, d, [0.0, 1.0], [1.0, 1.0]),
                    (a, c, [0.0, 0.0], [0.0, 1.0]),
                    (b, d, [1.0, 0.0], [1.0, 1.0]),
                ] {
                    let cross = (depth - low) / (high - low);
                    let span = match (low < depth, high < depth) {
                        (true, true) => [0.0, 1.0],
                        (true, false) => [0.0, cross],
                        (false, true) => [cross, 1.0],
                        (false, false) => continue,
                    };
                    let ends = span.map(|t| [0, 1].map(|m| p[m] + t * (q[m] - p[m])));
                    let ends = ends.map(|[s, t]| {
                        let [x, y] = self.nodes.node(i, j);
                        [x + s * self.nodes.spacing[0], y + t * self.nodes.spacing[1]]
                    });
                    let edge = Rect { min: ends[0], max: ends[1] };
                    held = Some(held.map_or(edge, |held| held.union(&edge)));
                }
            }
        }
        held.map_or(Reach::Nowhere, |rect| {
            let [w, h] = self.nodes.spacing.map(|step| ROUNDING * step);
            let wider = Rect { min: [rect.min[0] - w, rect.min[1] - h], max: [rect.max[0] + w, rect.max[1] + h] };
            Reach::Within(wider.intersection(&self.extent()).unwrap_or(wider))
        })
    }

    fn mean(&self, cell: &Rect) -> f64 {
        let (Some(columns), Some(rows)) =
            (self.nodes.pieces(0, cell.min[0], cell.max[0]), self.nodes.pieces(1, cell.min[1], cell.max[1]))
        else {
            return f64::INFINITY;
        };
        let (mut volume, mut area) = (0.0, 0.0);
        for &(j, t0, t1) in &rows {
            for &(i, s0, s1) in &columns {
                let Some(corners) = self.corners(i, j) else { return f64::INFINITY };
                // The mean of a bilinear function over a rectangle is its value in the middle.
                let part = (s1 - s0) * (t1 - t0);
                volume += part * bilinear(corners, [0.5 * (s0 + s1), 0.5 * (t0 + t1)]);
                area += part;
            }
        }
        if area > 0.0 {
            return volume / area;
        }
        let [x, y] = cell.centre();
        self.gap(x, y)
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        // A bilinear function less a plane is least and greatest at corners of a rectangle.
        let centre = rect.centre();
        let whole = self.extent();
        let all_on_map = (0..2).all(|m| whole.min[m] <= rect.min[m] && rect.max[m] <= whole.max[m]);
        let [mut low, mut high] = [f64::INFINITY, if all_on_map { f64::NEG_INFINITY } else { f64::INFINITY }];
        let (columns, rows) = (self.nodes.parts(0, rect), self.nodes.parts(1, rect));
        if columns.len() * rows.len() > MANY {
            // Blocks of cells: their extremes, and the variation of the plane.
            let [a, b] = self.extremes.over(self.nodes.blocks(rect)?);
            let [w, h] = rect.size();
            let half = 0.5 * (slope[0].abs() * w + slope[1].abs() * h);
            return Some([a - half, if all_on_map { b + half } else { f64::INFINITY }]);
        }
        for &(j, t) in &rows {
            for &(i, s) in &columns {
                let Some(corners) = self.corners(i, j) else {
                    // A rectangle that ends on the border of a hole does not lie in it.
                    let inside = |[a, b]: [f64; 2], all: usize| b - a > ROUNDING || all == 1;
                    if inside(s, columns.len()) && inside(t, rows.len()) {
                        high = f64::INFINITY;
                    }
                    continue;
                };
                let [x, y] = self.nodes.node(i, j);
                for at in [[s[0], t[0]], [s[1], t[0]], [s[0], t[1]], [s[1], t[1]]] {
                    let rise = slope[0] * (x + at[0] * self.nodes.spacing[0] - centre[0])
                        + slope[1] * (y + at[1] * self.nodes.spacing[1] - centre[1]);
                    let value = bilinear(corners, at) - rise;
                    (low, high) = (low.min(value), high.max(value));
                }
            }
        }
        // Rounding: of heights, and of where in a cell a corner lies.
        let size = [low, high].iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
        let steep = slope.iter().zip(rect.size()).map(|(s, w)| (s * w).abs()).sum::<f64>();
        let rounding = 1e-13 * (size + steep);
        Some([low - rounding, high.max(low) + rounding])
    }

    fn end_of_data(&self, x: f64, y: f64) -> Option<DataEdge> {
        self.nodes.end_of_data([x, y], self.gap(x, y))
    }

    fn nodes(&self) -> Option<Grid> {
        Some(self.nodes.cells())
    }

    fn is_measured(&self) -> bool {
        self.uncertainty.is_some()
    }

    fn sampling_error(&self, rect: &Rect) -> f64 {
        self.nodes.largest(self.uncertainty.as_deref(), rect) + self.open_at_zero().size()
    }

    fn left_open(&self, places: &[Rect]) -> Vec<LeftOpen> {
        let of_zero = self.open_at_zero();
        places.iter().map(|place| self.open_between(place) + of_zero).collect()
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        for m in 0..2 {
            if direction[m] != 0.0 {
                let line =
                    |k: usize| (self.nodes.origin[m] + k as f64 * self.nodes.spacing[m] - from[m]) / direction[m];
                kinks.extend((0..self.nodes.shape[m]).map(line).filter(|r| *r > 0.0 && r.is_finite()));
            }
        }
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        // On a line of the grid: along it. Nodes further out are too many to name.
        let on_line = |m: usize| {
            let u = (from[m] - self.nodes.origin[m]) / self.nodes.spacing[m];
            (u - u.round()).abs() < ROUNDING
        };
        let (quarter, half) = (std::f64::consts::FRAC_PI_2, std::f64::consts::PI);
        if on_line(1) {
            angles.extend([0.0, half]);
        }
        if on_line(0) {
            angles.extend([quarter, -quarter]);
        }
    }
}
