//! Measured surfaces: gaps given by heights on a regular grid.

mod heights;
mod nodes;
mod npy;
mod sdf;
mod text;
#[cfg(feature = "scene")]
mod x3p;

pub use heights::{Heights, MapFormat};
pub(super) use nodes::{Nodes, ROUNDING};
pub(super) use text::decoded;

use super::extremes::Extremes;
use super::{DataEdge, Gap, Growth, Known, Material, Reach, Taylor};
use crate::error::InputError;
use crate::grid::Grid;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Heights by rows with their number and steps along x and y, from a file that carries its unit.
#[derive(Debug)]
struct Read {
    values: Vec<f64>,
    shape: [usize; 2],
    spacing: [f64; 2],
}

/// With more cells than this the extremes of blocks stand for them.
const MANY: usize = 64;

/// Which surface was measured. Heights count upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surface {
    /// The underside of the upper body, seen in the same frame: where it is high the gap is wide.
    Upper,
    /// The top of the lower body: its peaks touch first.
    Lower,
}

/// What depth zero means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Zero {
    /// The bodies just touch: the least gap is zero.
    #[default]
    FirstTouch,
    /// Heights are gaps as they stand.
    AsIs,
}

/// A gap given at the nodes of a regular grid, bilinear in between: continuous, with kinks at the lines of the grid.
///
/// A hole (a node without a value) leaves the up to four cells around it without material; there is none outside the
/// map either. Means over rectangles are exact for the interpolated surface. A smooth surface is met to second order in
/// the spacing.
///
/// ```
/// use contact_patch::gap::{Gap, HeightMap, Heights, Surface, Zero};
/// // One asperity on the lower body, 1e-6 apart.
/// let heights = Heights::from_text("0 0 0\n0 2e-9 0\n0 0 0\n", [1e-6, 1e-6])?;
/// let gap = HeightMap::new(&heights, Surface::Lower, Zero::FirstTouch)?;
/// assert_eq!(gap.gap(0.0, 0.0), 0.0);
/// assert_eq!(gap.gap(0.5e-6, 0.0), 1e-9);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    nodes: Nodes,
    /// Gap at the nodes, x fastest; infinite in holes.
    gaps: Vec<f64>,
    centre: [f64; 2],
    /// The least gap of all cells with material.
    floor: f64,
    /// Least and greatest gap of blocks of cells.
    extremes: Extremes,
    /// How far each gap may be from the true one, where noise was taken out.
    uncertainty: Option<Vec<f64>>,
}

impl HeightMap {
    /// One measured surface against a plane.
    ///
    /// # Errors
    /// When no cell of the map has heights at all four corners.
    pub fn new(heights: &Heights, surface: Surface, zero: Zero) -> Result<Self, InputError> {
        let sign = match surface {
            Surface::Upper => 1.0,
            Surface::Lower => -1.0,
        };
        Self::build(
            heights,
            heights.values().iter().map(|z| sign * z).collect(),
            heights.uncertainty().map(<[f64]>::to_vec),
            zero,
        )
    }

    /// Two measured surfaces against each other: gap = upper - lower. Both maps have the same nodes.
    ///
    /// # Errors
    /// Names `lower` when its shape, spacing or origin differs from the upper one's; otherwise as [`HeightMap::new`].
    pub fn pair(upper: &Heights, lower: &Heights, zero: Zero) -> Result<Self, InputError> {
        let allowed = |what: &str, of: String| format!("the {what} of the upper map, {of}");
        if lower.shape() != upper.shape() {
            let given = format!("a map of {} x {} nodes", lower.shape()[0], lower.shape()[1]);
            let of = format!("{} x {} nodes", upper.shape()[0], upper.shape()[1]);
            return Err(InputError::new("lower", given, allowed("shape", of)));
        }
        for m in 0..2 {
            let step = upper.spacing()[m];
            if (lower.spacing()[m] - step).abs() > 1e-6 * step {
                let given = format!("a spacing of {}", lower.spacing()[m]);
                return Err(InputError::new("lower", given, allowed("spacing", step.to_string())));
            }
            if (lower.origin()[m] - upper.origin()[m]).abs() > 1e-3 * step {
                let given = format!("a first node at {:?}", lower.origin());
                return Err(InputError::new("lower", given, allowed("first node", format!("{:?}", upper.origin()))));
            }
        }
        let both = |one: Option<&[f64]>, other: Option<&[f64]>| match (one, other) {
            (Some(a), Some(b)) => Some(a.iter().zip(b).map(|(a, b)| a + b).collect()),
            (one, other) => one.or(other).map(<[f64]>::to_vec),
        };
        let uncertainty = both(upper.uncertainty(), lower.uncertainty());
        Self::build(upper, upper.values().iter().zip(lower.values()).map(|(u, l)| u - l).collect(), uncertainty, zero)
    }

    fn build(
        frame: &Heights,
        mut gaps: Vec<f64>,
        uncertainty: Option<Vec<f64>>,
        zero: Zero,
    ) -> Result<Self, InputError> {
        for gap in &mut gaps {
            if !gap.is_finite() {
                *gap = f64::INFINITY;
            }
        }
        let shape = frame.shape();
        let nodes = Nodes { shape, spacing: frame.spacing(), origin: frame.origin() };
        let mut map = Self { nodes, gaps, centre: [0.0; 2], floor: 0.0, extremes: Extremes::default(), uncertainty };
        let least = (0..shape[1] - 1)
            .flat_map(|j| (0..shape[0] - 1).map(move |i| [i, j]))
            .filter_map(|[i, j]| map.corners(i, j))
            .flatten()
            .fold(f64::INFINITY, f64::min);
        if least == f64::INFINITY {
            return Err(InputError::new(
                "file",
                "a map of holes",
                "at least one cell with heights at its four corners",
            ));
        }
        if zero == Zero::FirstTouch {
            map.gaps.iter_mut().for_each(|gap| *gap -= least);
        }
        map.floor = if zero == Zero::FirstTouch { 0.0 } else { least };
        let cell = |i, j| map.corners(i, j).map(|c| c.iter().fold([c[0]; 2], |[a, b], &g| [a.min(g), b.max(g)]));
        map.extremes = Extremes::new([shape[0] - 1, shape[1] - 1], cell);
        map.centre = map.lowest_node();
        Ok(map)
    }

    /// Number of nodes along x and y.
    #[must_use]
    pub fn shape(&self) -> [usize; 2] {
        self.nodes.shape
    }

    /// Steps between nodes along x and y.
    #[must_use]
    pub fn spacing(&self) -> [f64; 2] {
        self.nodes.spacing
    }

    /// The rectangle from the first node to the last.
    #[must_use]
    pub fn extent(&self) -> Rect {
        self.nodes.extent()
    }

    /// The nodes, the gaps there (infinite in holes), and how far each may be from the true one.
    pub(super) fn samples(&self) -> (Nodes, &[f64], Option<&[f64]>) {
        (self.nodes, &self.gaps, self.uncertainty.as_deref())
    }

    /// Gaps at the corners of cell (i, j): lower left, lower right, upper left, upper right. `None` with a hole.
    fn corners(&self, i: usize, j: usize) -> Option<[f64; 4]> {
        let k = j * self.nodes.shape[0] + i;
        let corners = [k, k + 1, k + self.nodes.shape[0], k + self.nodes.shape[0] + 1].map(|k| self.gaps[k]);
        corners.iter().all(|g| g.is_finite()).then_some(corners)
    }

    /// The lowest node; the middle of several next to each other.
    fn lowest_node(&self) -> [f64; 2] {
        let [nx, ny] = self.nodes.shape;
        let touches = |i: usize, j: usize| {
            let (left, below) = (i.saturating_sub(1), j.saturating_sub(1));
            (below..=j.min(ny - 2)).any(|j| (left..=i.min(nx - 2)).any(|i| self.corners(i, j).is_some()))
        };
        let mut least: Option<(f64, [usize; 2])> = None;
        for (k, &gap) in self.gaps.iter().enumerate() {
            let (i, j) = (k % nx, k / nx);
            if least.is_none_or(|l| gap < l.0) && touches(i, j) {
                least = Some((gap, [i, j]));
            }
        }
        let Some((gap, [i, j])) = least else { return self.extent().centre() };
        let east = i + 1 < nx && self.gaps[j * nx + i + 1] == gap;
        let north = j + 1 < ny && self.gaps[(j + 1) * nx + i] == gap;
        let both = east && north && self.corners(i, j).is_some_and(|c| c.iter().all(|&g| g == gap));
        let [x, y] = self.nodes.node(i, j);
        let half = [0.5 * self.nodes.spacing[0], 0.5 * self.nodes.spacing[1]];
        match (both, east, north) {
            (true, ..) => [x + half[0], y + half[1]],
            (_, true, _) => [x + half[0], y],
            (_, _, true) => [x, y + half[1]],
            _ => [x, y],
        }
    }

    /// The cell with material that holds a point, and the place in it.
    fn locate(&self, x: f64, y: f64) -> Option<([f64; 4], [f64; 2])> {
        self.nodes.holding(1, y).find_map(|(j, t)| {
            self.nodes.holding(0, x).find_map(|(i, s)| self.corners(i, j).map(|corners| (corners, [s, t])))
        })
    }
}

fn bilinear([a, b, c, d]: [f64; 4], [s, t]: [f64; 2]) -> f64 {
    (1.0 - t) * (a * (1.0 - s) + b * s) + t * (c * (1.0 - s) + d * s)
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
        self.nodes.largest(self.uncertainty.as_deref(), rect)
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
