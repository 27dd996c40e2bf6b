//! Measured surfaces as smooth ones: cubic splines through heights on a regular grid.

mod surface;

use super::extremes::Extremes;
use super::height_map::{HeightMap, Heights, Nodes, ROUNDING, Surface, Zero, mean_over};
use super::left_open::{BESIDE, COARSER, FURTHER, MARGIN, Rising, tip};
use super::spline::{Ends, bernstein};
use super::{DataEdge, Gap, Growth, Known, LeftOpen, Material, Reach, Taylor};
use crate::error::InputError;
use crate::grid::Grid;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;
use surface::Splines;

/// With more cells than this the extremes of blocks stand for them.
const MANY: usize = 64;

/// A gap given at the nodes of a regular grid, bicubic in between: the tensor product of cubic splines along rows and columns.
///
/// Slopes are continuous everywhere, curvatures where there are no holes. A smooth surface is met to fourth order in the spacing. Holes and
/// the border are those of [`HeightMap`]: no material in a cell that lacks a corner. Bounds follow from the Bernstein coefficients
/// of each cell; what the samples cannot show is estimated by [`Gap::sampling_error`].
///
/// ```
/// use contact_patch::gap::{Gap, Heights, SplineMap, Surface, Zero};
/// // A ball of radius 1e-3, sampled every 20 um: met to parts in a million of its height.
/// let z = |k: usize| [k % 21, k / 21].map(|i| 2e-5 * (i as f64 - 10.0)).iter().map(|x| x * x).sum::<f64>() / 2e-3;
/// let heights = Heights::new((0..21 * 21).map(z).collect(), [21, 21], [2e-5; 2])?;
/// let map = SplineMap::new(&heights, Surface::Upper, Zero::FirstTouch)?;
/// assert!((map.gap(1.3e-5, -0.7e-5) - (1.69e-10 + 0.49e-10) / 2e-3).abs() < 1e-15);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SplineMap {
    splines: Splines,
    centre: [f64; 2],
    floor: f64,
    extremes: Extremes,
    uncertainty: Option<Vec<f64>>,
    /// Where depths are counted from.
    zero: Zero,
}

impl SplineMap {
    /// One measured surface against a plane.
    ///
    /// # Errors
    /// When no cell of the map has heights at all four corners.
    pub fn new(heights: &Heights, surface: Surface, zero: Zero) -> Result<Self, InputError> {
        HeightMap::new(heights, surface, Zero::AsIs).map(|map| Self::through(&map, zero))
    }

    /// Two measured surfaces against each other: gap = upper - lower. Both maps have the same nodes.
    ///
    /// # Errors
    /// As [`HeightMap::pair`].
    pub fn pair(upper: &Heights, lower: &Heights, zero: Zero) -> Result<Self, InputError> {
        HeightMap::pair(upper, lower, Zero::AsIs).map(|map| Self::through(&map, zero))
    }

    fn through(map: &HeightMap, zero: Zero) -> Self {
        let (nodes, gaps, uncertainty) = map.samples();
        let ends = if uncertainty.is_some() { Ends::Natural } else { Ends::NotAKnot };
        let mut splines = Splines::through(nodes, gaps, ends);
        let (centre, least, bound) = splines.least();
        let floor = match zero {
            Zero::FirstTouch => {
                splines.raise(-least);
                (bound - least) - bernstein::ROUNDING * least.abs()
            }
            Zero::AsIs => bound,
        };
        let cells = splines.nodes.shape.map(|n| n - 1);
        let extremes = Extremes::new(cells, |i, j| splines.net(i, j).map(|net| bernstein::range(net.as_flattened())));
        Self { splines, centre, floor, extremes, uncertainty: uncertainty.map(<[f64]>::to_vec), zero }
    }

    /// Number of nodes along x and y.
    #[must_use]
    pub fn shape(&self) -> [usize; 2] {
        self.splines.nodes.shape
    }

    /// Steps between nodes along x and y.
    #[must_use]
    pub fn spacing(&self) -> [f64; 2] {
        self.splines.nodes.spacing
    }

    /// The rectangle from the first node to the last.
    #[must_use]
    pub fn extent(&self) -> Rect {
        self.splines.nodes.extent()
    }

    /// What the samples leave open of the heights.
    fn open_between(&self, places: &[Rect]) -> Vec<LeftOpen> {
        let frame = self.frame();
        let nowhere = || vec![LeftOpen::default(); places.len()];
        let Some(all) = places.iter().copied().reduce(|a, b| a.union(&b)) else { return nowhere() };
        let (Some(around), Some(inner)) = (frame.around(&all, MARGIN), frame.around(&all, 0)) else {
            return nowhere();
        };
        let [second, fourth] = COARSER.map(|every| self.missed(around, inner, every));
        let everywhere = [0, 1].map(|m| [0, frame.shape[m] - 1]);
        let one = |place: &Rect| {
            let Some(at) = frame.around(place, 0) else { return LeftOpen::default() };
            let noise = self.uncertainty.as_deref().map_or(0.0, |noise| mean_over(noise, everywhere, at));
            let [second, fourth] = [&second, &fourth].map(|off| off.as_ref().map(|off| mean_over(off, inner, at)));
            LeftOpen::of(noise, second, fourth, || self.variation(place))
        };
        places.iter().map(one).collect()
    }

    /// What they leave open of where the bodies first touch, where depths are counted from there.
    fn open_at_zero(&self) -> LeftOpen {
        if self.zero == Zero::AsIs {
            return LeftOpen::default();
        }
        let open = self.open_between(&[Rect { min: self.centre, max: self.centre }])[0];
        let [nx, ny] = self.shape();
        open.of_least((0..nx * ny).map(|k| self.splines.value(k)), self.tip())
    }

    /// How much lower than the spline a tip may be between the samples around the lowest place.
    fn tip(&self) -> f64 {
        let smoothed = self.uncertainty.is_some();
        let frame = self.frame();
        let at = Rect { min: self.centre, max: self.centre };
        let (Some(own), Some([columns, rows])) = (frame.around(&at, 0), frame.around(&at, FURTHER)) else { return 0.0 };
        let value = |[i, j]: [usize; 2]| self.splines.value(j * frame.shape[0] + i);
        let rising = |[i, j]: [usize; 2]| {
            let [a, b, c, d] = [[i, j], [i + 1, j], [i, j + 1], [i + 1, j + 1]].map(value);
            let slope = [(b - a + d - c) / (2.0 * frame.spacing[0]), (c - a + d - b) / (2.0 * frame.spacing[1])];
            let from = Rect { min: frame.node(i, j), max: frame.node(i + 1, j + 1) }.centre();
            let v = [0, 1].map(|m| from[m] - self.centre[m]);
            Rising { slope: slope[0].hypot(slope[1]), away: (slope[0] * v[0] + slope[1] * v[1]) / v[0].hypot(v[1]) }
        };
        // Cells from the one, or the few, that the lowest place is in.
        let away = |cell: [usize; 2]| {
            (0..2)
                .map(|m| own[m][0].saturating_sub(cell[m]).max((cell[m] + 1).saturating_sub(own[m][1])))
                .fold(0, usize::max)
        };
        let cells = (rows[0]..rows[1]).flat_map(|j| (columns[0]..columns[1]).map(move |i| [i, j]));
        let (beside, further): (Vec<_>, Vec<_>) =
            cells.filter(|cell| away(*cell) > 0).partition(|cell| away(*cell) <= BESIDE);
        let [beside, further] = [beside, further].map(|cells| cells.into_iter().map(rising).collect::<Vec<Rising>>());
        let near = [0, 1].map(|m| own[m][0].saturating_sub(1)..=(own[m][1] + 1).min(frame.shape[m] - 1));
        let nodes = near[1].clone().flat_map(|j| near[0].clone().map(move |i| [i, j]));
        let points: Vec<_> = nodes.map(|[i, j]| (frame.node(i, j), value([i, j]))).collect();
        tip(&Rect::around(self.centre, frame.spacing), &points, &beside, &further, smoothed)
    }

    fn frame(&self) -> &Nodes {
        &self.splines.nodes
    }

    fn on_map(&self, rect: &Rect) -> bool {
        let whole = self.extent();
        (0..2).all(|m| whole.min[m] <= rect.min[m] && rect.max[m] <= whole.max[m])
    }

    /// The heights against splines through every n-th of them, laid on the nodes `around` from their first on and from those `later`: the
    /// greatest differences at the nodes `inner`, row by row. A sharp tip is seen by those that have no node on it.
    fn missed(&self, around: [[usize; 2]; 2], inner: [[usize; 2]; 2], [every, later]: [usize; 2]) -> Option<Vec<f64>> {
        let shifted = |[i, j]: [usize; 2]| {
            let [columns, rows] = around;
            [[columns[0] + i, columns[1]], [rows[0] + j, rows[1]]]
        };
        let all = [[0, 0], [later, 0], [0, later], [later, later]].map(shifted);
        let larger = |mut most: Vec<f64>, other: Vec<f64>| {
            most.iter_mut().zip(other).for_each(|(most, off)| *most = most.max(off));
            most
        };
        all.into_iter().filter_map(|around| self.missed_on(around, inner, every)).reduce(larger)
    }

    fn missed_on(&self, [columns, rows]: [[usize; 2]; 2], inner: [[usize; 2]; 2], every: usize) -> Option<Vec<f64>> {
        if columns[0] >= columns[1] || rows[0] >= rows[1] {
            return None;
        }
        let nodes = self.frame();
        let [nx, ny] = [columns, rows].map(|[first, last]| (last - first) / every + 1);
        if nx < 4 || ny < 4 {
            return None;
        }
        let place = |k: usize| (rows[0] + every * (k / nx)) * nodes.shape[0] + columns[0] + every * (k % nx);
        let gaps: Vec<f64> = (0..nx * ny).map(|k| self.splines.value(place(k))).collect();
        let spacing = nodes.spacing.map(|h| h * every as f64);
        let coarse = Nodes { shape: [nx, ny], spacing, origin: nodes.node(columns[0], rows[0]) };
        let coarse = Splines::through(coarse, &gaps, Ends::NotAKnot);
        // Cell and place in it; at the end of a cell without material the next one may have some.
        let place = |k: usize, first: usize, n: usize| {
            let steps = k.checked_sub(first)?;
            let cell = (steps / every).min(n - 2);
            let at = (steps - cell * every) as f64 / every as f64;
            (at <= 1.0).then_some((cell, at))
        };
        let off = |[i, j]: [usize; 2]| {
            let Some(((column, s), (row, t))) = place(i, columns[0], nx).zip(place(j, rows[0], ny)) else {
                return 0.0;
            };
            let value = coarse.inside(column, row, [s, t]).unwrap_or_else(|| coarse.at(nodes.node(i, j)));
            let off = (value - self.splines.value(j * nodes.shape[0] + i)).abs();
            if off.is_finite() { off } else { 0.0 }
        };
        let [width, height] = inner.map(|[first, last]| last - first + 1);
        let node = |k: usize| [inner[0][0] + k % width, inner[1][0] + k / width];
        Some((0..width * height).map(node).map(off).collect())
    }

    /// By how much the heights vary around a rectangle.
    fn variation(&self, rect: &Rect) -> f64 {
        let [low, high] = self.frame().blocks(rect).map_or([0.0; 2], |blocks| self.extremes.over(blocks));
        if high.is_finite() { high - low } else { 0.0 }
    }
}

impl Gap for SplineMap {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.splines.at([x, y])
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.splines.gradient([x, y])
    }

    fn end_of_data(&self, x: f64, y: f64) -> Option<DataEdge> {
        self.splines.nodes.end_of_data([x, y], self.gap(x, y))
    }

    fn nodes(&self) -> Option<Grid> {
        Some(self.splines.nodes.cells())
    }

    fn describe(&self) -> Known {
        Known { centre: self.centre, floor: self.floor, material: Material::Within(self.extent()), ..Known::nothing() }
    }

    fn reach(&self, depth: f64) -> Reach {
        let [nx, ny] = self.shape().map(|n| n - 1);
        let mut held: Option<[[usize; 2]; 2]> = None;
        for j in 0..ny {
            let dips = |i: &usize| self.splines.dips(*i, j, depth);
            let Some(first) = (0..nx).find(dips) else { continue };
            let last = (first..nx).rfind(dips).unwrap_or(first);
            let [c, r] = held.unwrap_or([[first, last], [j, j]]);
            held = Some([[c[0].min(first), c[1].max(last)], [r[0], j]]);
        }
        match held {
            None => Reach::Nowhere,
            Some(_) if depth <= self.floor => Reach::Nowhere,
            Some([c, r]) => {
                let nodes = self.frame();
                Reach::Within(Rect { min: nodes.node(c[0], r[0]), max: nodes.node(c[1] + 1, r[1] + 1) })
            }
        }
    }

    fn components(&self, depth: f64) -> Option<Vec<Rect>> {
        Some(self.frame().groups(|i, j| self.splines.dips(i, j, depth)))
    }

    fn mean(&self, cell: &Rect) -> f64 {
        self.splines.mean(cell)
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let nodes = self.frame();
        let (columns, rows) = (nodes.parts(0, rect), nodes.parts(1, rect));
        let open = |high: f64| if self.on_map(rect) { high } else { f64::INFINITY };
        if columns.len() * rows.len() > MANY {
            // Blocks of cells: their extremes, and the variation of the plane.
            let [a, b] = self.extremes.over(nodes.blocks(rect)?);
            let [w, h] = rect.size();
            let half = 0.5 * (slope[0].abs() * w + slope[1].abs() * h);
            let finite = |v: f64| if v.is_finite() { v.abs() } else { 0.0 };
            let room = bernstein::ROUNDING * (finite(a) + finite(b) + half);
            return Some([a - half - room, open(b + half + room)]);
        }
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        for &(j, t) in &rows {
            for &(i, s) in &columns {
                match self.splines.over(i, j, [s, t], slope, rect) {
                    Some([a, b]) => (low, high) = (low.min(a), high.max(b)),
                    None => {
                        // A rectangle that ends on the border of a hole does not lie in it.
                        let inside = |[a, b]: [f64; 2], all: usize| b - a > ROUNDING || all == 1;
                        if inside(s, columns.len()) && inside(t, rows.len()) {
                            high = f64::INFINITY;
                        }
                    }
                }
            }
        }
        Some([low, open(high.max(low))])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let nodes = self.frame();
        let (columns, rows) = (nodes.parts(0, rect), nodes.parts(1, rect));
        if !self.on_map(rect) || columns.len() * rows.len() > MANY {
            return None;
        }
        let mut hessian: Option<[Interval; 3]> = None;
        for &(j, t) in &rows {
            for &(i, s) in &columns {
                // Slopes are continuous: a bound of the curvatures on either side serves for both.
                let own = self.splines.curvatures(i, j, [s, t])?;
                hessian = Some(hessian.map_or(own, |all| [0, 1, 2].map(|n| all[n].union(own[n]))));
            }
        }
        let [value, gx, gy] = self.splines.enclosed(rect.centre())?;
        Taylor { value, gradient: [gx, gy], hessian: hessian? }.finite()
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        let mean = self.mean(rect);
        if !mean.is_finite() {
            return Some([self.bounds(rect, [0.0; 2])?[0], f64::INFINITY]);
        }
        // A sum of products of coefficients, and where its pieces lie to rounding.
        let [low, high] = self.extremes.over(self.frame().blocks(rect)?);
        let far = |m: usize| rect.max[m].abs().max(rect.min[m].abs()) / self.spacing()[m];
        let size = low.abs().max(high.abs());
        let rounding = bernstein::ROUNDING * size + 16.0 * f64::EPSILON * (high - low) * (far(0) + far(1) + 4.0);
        Some([mean - rounding, mean + rounding])
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Growth::ended(&self.extent(), from)
    }

    fn is_measured(&self) -> bool {
        true
    }

    fn sampling_error(&self, rect: &Rect) -> f64 {
        let of_zero = self.open_at_zero().size();
        let noise = self.frame().largest(self.uncertainty.as_deref(), rect);
        let (Some(around), Some(inner)) = (self.frame().around(rect, MARGIN), self.frame().around(rect, 0)) else {
            return noise + of_zero;
        };
        let most = |every| self.missed(around, inner, every).map(|off| off.into_iter().fold(0.0, f64::max));
        let [second, fourth] = COARSER.map(most);
        LeftOpen::of(noise, second, fourth, || self.variation(rect)).size() + of_zero
    }

    fn left_open(&self, places: &[Rect]) -> Vec<LeftOpen> {
        let of_zero = self.open_at_zero();
        self.open_between(places).into_iter().map(|open| open + of_zero).collect()
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        let whole = self.extent();
        for m in (0..2).filter(|&m| direction[m] != 0.0) {
            let sides = [whole.min[m], whole.max[m]].map(|side| (side - from[m]) / direction[m]);
            kinks.extend(sides.into_iter().filter(|r| *r > 0.0 && r.is_finite()));
        }
    }
}
