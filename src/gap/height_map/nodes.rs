//! The nodes of a regular grid: which cells a point, an interval or a rectangle meets.

use crate::gap::DataEdge;
use crate::grid::Grid;
use crate::numeric::geometry::Rect;

/// Rounding that does not take a point off the map, in steps of the map.
pub(in crate::gap) const ROUNDING: f64 = 1e-9;

/// Nodes at equal steps along x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::gap) struct Nodes {
    /// Number along x and y.
    pub shape: [usize; 2],
    pub spacing: [f64; 2],
    /// Where the first one lies.
    pub origin: [f64; 2],
}

impl Nodes {
    pub fn node(&self, i: usize, j: usize) -> [f64; 2] {
        [self.origin[0] + i as f64 * self.spacing[0], self.origin[1] + j as f64 * self.spacing[1]]
    }

    /// Cells whose centres the nodes are.
    pub fn cells(&self) -> Grid {
        let origin = [0, 1].map(|m| self.origin[m] - 0.5 * self.spacing[m]);
        Grid { origin, spacing: self.spacing, shape: self.shape }
    }

    /// Which edge of the data lies at a point where the gap is this, if any.
    pub fn end_of_data(&self, at: [f64; 2], gap: f64) -> Option<DataEdge> {
        if !self.extent().contains(at) {
            return Some(DataEdge::Map);
        }
        (gap == f64::INFINITY).then_some(DataEdge::Hole)
    }

    /// The rectangle from the first node to the last.
    pub fn extent(&self) -> Rect {
        Rect { min: self.origin, max: self.node(self.shape[0] - 1, self.shape[1] - 1) }
    }

    /// The cells that hold a coordinate, with its place in them in [0, 1]; two on a line of the grid.
    pub fn holding(&self, m: usize, v: f64) -> impl Iterator<Item = (usize, f64)> + use<> {
        let last = self.shape[m] - 2;
        let u = (v - self.origin[m]) / self.spacing[m];
        let on_map = u >= -ROUNDING && u <= (last + 1) as f64 + ROUNDING;
        let u = u.clamp(0.0, (last + 1) as f64);
        let cell = (u.floor() as usize).min(last);
        let t = u - cell as f64;
        let before = (t == 0.0 && cell > 0).then(|| (cell - 1, 1.0));
        on_map.then_some((cell, t)).into_iter().chain(before.filter(|_| on_map))
    }

    /// Cells over which an interval extends, with the interval's part in each; `None` if it leaves the map.
    pub fn pieces(&self, m: usize, from: f64, to: f64) -> Option<Vec<(usize, f64, f64)>> {
        let (a, b) = ((from - self.origin[m]) / self.spacing[m], (to - self.origin[m]) / self.spacing[m]);
        let last = (self.shape[m] - 1) as f64;
        let slack = ROUNDING * (1.0 + (b - a));
        if !(a >= -slack && b <= last + slack) {
            return None;
        }
        let (a, b) = (a.clamp(0.0, last), b.clamp(0.0, last));
        let (first, end) = ((a + ROUNDING).floor() as usize, (b - ROUNDING).ceil() as usize);
        let piece = |k: usize| (k, a.max(k as f64) - k as f64, b.min((k + 1) as f64) - k as f64);
        Some((first..end).map(piece).collect())
    }

    /// The cells from one to another along both sides that a rectangle touches; `None` off the map.
    pub fn blocks(&self, rect: &Rect) -> Option<[[usize; 2]; 2]> {
        let ([i, k], [j, l]) = (self.touched(0, rect)?.0, self.touched(1, rect)?.0);
        Some([[i, k], [j, l]])
    }

    /// Every cell that a side of a rectangle touches, with the part of it in [0, 1]; none off the map.
    pub fn parts(&self, m: usize, rect: &Rect) -> Vec<(usize, [f64; 2])> {
        let Some(([first, end], side)) = self.touched(m, rect) else { return Vec::new() };
        (first..=end).map(|k| (k, side.map(|u| (u - k as f64).clamp(0.0, 1.0)))).collect()
    }

    /// The first and the last cell that a side of a rectangle touches, and where it begins and ends in steps of the map; `None` off the map.
    fn touched(&self, m: usize, rect: &Rect) -> Option<([usize; 2], [f64; 2])> {
        let side = [rect.min[m], rect.max[m]].map(|v| (v - self.origin[m]) / self.spacing[m]);
        let last = self.shape[m] - 2;
        // Points within rounding of the border count as on the map, as they do for the gap itself.
        if side[1] < -ROUNDING || side[0] > (last + 1) as f64 + ROUNDING {
            return None;
        }
        let side = side.map(|u| u.clamp(0.0, (last + 1) as f64));
        Some((side.map(|u| (u.floor() as usize).min(last)), side))
    }

    /// Rectangles around connected groups of cells of which something holds, corners counted.
    pub fn groups(&self, holds: impl Fn(usize, usize) -> bool) -> Vec<Rect> {
        let [nx, ny] = self.shape.map(|n| n - 1);
        let mut seen = vec![false; nx * ny];
        let mut found = Vec::new();
        let mut stack = Vec::new();
        for start in 0..nx * ny {
            if seen[start] || !holds(start % nx, start / nx) {
                continue;
            }
            seen[start] = true;
            stack.push(start);
            let [mut low, mut high] = [[usize::MAX; 2], [0; 2]];
            while let Some(k) = stack.pop() {
                let at = [k % nx, k / nx];
                low = [low[0].min(at[0]), low[1].min(at[1])];
                high = [high[0].max(at[0] + 1), high[1].max(at[1] + 1)];
                for j in at[1].saturating_sub(1)..(at[1] + 2).min(ny) {
                    for i in at[0].saturating_sub(1)..(at[0] + 2).min(nx) {
                        if !seen[j * nx + i] && holds(i, j) {
                            seen[j * nx + i] = true;
                            stack.push(j * nx + i);
                        }
                    }
                }
            }
            found.push(Rect { min: self.node(low[0], low[1]), max: self.node(high[0], high[1]) });
        }
        found
    }

    /// The nodes from one to another along both sides that hold a rectangle, with `margin` more on each side; `None` off the map.
    pub fn around(&self, rect: &Rect, margin: usize) -> Option<[[usize; 2]; 2]> {
        let blocks = self.blocks(rect)?;
        Some([0, 1].map(|m| {
            let [first, last] = blocks[m];
            [first.saturating_sub(margin), (last + 1 + margin).min(self.shape[m] - 1)]
        }))
    }

    /// The largest of the values at the nodes around a rectangle; 0 without values.
    pub fn largest(&self, values: Option<&[f64]>, rect: &Rect) -> f64 {
        let (Some(values), Some([columns, rows])) = (values, self.around(rect, 0)) else { return 0.0 };
        let inside = (rows[0]..=rows[1]).flat_map(|j| (columns[0]..=columns[1]).map(move |i| j * self.shape[0] + i));
        inside.map(|k| values[k]).filter(|v| v.is_finite()).fold(0.0, f64::max)
    }
}

/// The mean over the nodes `at` of what is known at those `over`, row by row, from one to another along both sides; what is no number counts
/// as 0.
pub(in crate::gap) fn mean_over(values: &[f64], over: [[usize; 2]; 2], at: [[usize; 2]; 2]) -> f64 {
    let width = over[0][1] - over[0][0] + 1;
    let [columns, rows] = at;
    let inside = (rows[0]..=rows[1]).flat_map(|j| (columns[0]..=columns[1]).map(move |i| (i, j)));
    let known = inside.map(|(i, j)| values[(j - over[1][0]) * width + i - over[0][0]]);
    let (sum, count) = known.fold((0.0, 0.0), |(sum, n), v| (if v.is_finite() { sum + v } else { sum }, n + 1.0));
    sum / count
}
