//! The overlap of a gap on the cells of one grid: each is looked at once, whatever is asked of it.

use std::cell::RefCell;

use super::field::RING;
use super::of_gap::GapOverlap;
use super::overlap::{Interval, Jet, OverlapBounds};
use crate::gap::{AnyGap, Cubic, Gap, Taylor};
use crate::grid::Grid;
use crate::numeric;
use crate::numeric::geometry::Rect;

/// Side of the blocks of cells in which a gap of planes or a quadratic one is looked at together, and in which those parts of a composed
/// one are told that matter there.
const BLOCK: usize = 4;

/// A smooth gap over a rectangle, as closely as it is known.
#[derive(Debug, Clone, Copy)]
enum Smooth {
    Second(Taylor),
    Third(Cubic),
}

impl Smooth {
    fn of(gap: &AnyGap, rect: &Rect) -> Option<Self> {
        gap.cubic(rect).map(Self::Third).or_else(|| gap.taylor(rect).map(Self::Second))
    }

    /// About the middle of a part of the rectangle, at (x, y) from its own.
    fn moved(&self, by: [f64; 2]) -> Self {
        match self {
            Self::Second(taylor) => Self::Second(taylor.moved(by)),
            Self::Third(cubic) => Self::Third(cubic.moved(by)),
        }
    }

    fn taylor(&self, size: [f64; 2]) -> Taylor {
        match self {
            Self::Second(taylor) => *taylor,
            Self::Third(cubic) => cubic.taylor(size),
        }
    }

    fn mean(&self, size: [f64; 2]) -> numeric::Interval {
        match self {
            Self::Second(taylor) => taylor.mean(size),
            Self::Third(cubic) => cubic.mean(size),
        }
    }
}

/// What is known of rectangles of a lattice: each by its number among those that were looked at.
#[derive(Debug, Default)]
struct Looked {
    /// 0: not yet; 1: not smooth; else the place in the list, less 2.
    places: Vec<u32>,
    list: Vec<Smooth>,
}

impl Looked {
    fn at(&mut self, k: usize, look: impl FnOnce() -> Option<Smooth>) -> Option<Smooth> {
        if self.places[k] == 0 {
            self.places[k] = match look() {
                None => 1,
                Some(smooth) => {
                    self.list.push(smooth);
                    self.list.len() as u32 + 1
                }
            };
        }
        (self.places[k] > 1).then(|| self.list[self.places[k] as usize - 2])
    }
}

/// f on the cells of a grid and around it.
#[derive(Debug)]
pub(super) struct OnCells<'a> {
    overlap: &'a GapOverlap<'a>,
    grid: Grid,
    /// Cells along each axis, those around included.
    wide: [usize; 2],
    cells: RefCell<Looked>,
    /// Blocks of cells, where second derivatives are constants.
    blocks: Option<RefCell<Looked>>,
    /// What a composed gap is in each block of cells that was looked at: the gap itself, where it is no simpler there.
    simpler: Option<RefCell<Vec<Option<AnyGap>>>>,
}

impl<'a> OnCells<'a> {
    pub fn new(overlap: &'a GapOverlap<'a>, grid: &Grid) -> Self {
        let wide = grid.shape.map(|n| n + 2 * RING);
        let looked = |count: usize| RefCell::new(Looked { places: vec![0; count], list: Vec::new() });
        let gap = overlap.gap();
        let constant = gap.planes().is_some() || gap.known().quadratic.is_some();
        let count = wide[0].div_ceil(BLOCK) * wide[1].div_ceil(BLOCK);
        let blocks = constant.then(|| looked(count));
        let simpler = gap.is_composed().then(|| RefCell::new(vec![None; count]));
        Self { overlap, grid: *grid, wide, cells: looked(wide[0] * wide[1]), blocks, simpler }
    }

    pub fn gap(&self) -> &'a AnyGap {
        self.overlap.gap()
    }

    /// From one line of cells to another, counted from the first around the grid.
    fn between(&self, from: [usize; 2], to: [usize; 2]) -> Rect {
        let at = |n: usize, m: usize| self.grid.origin[m] + (n as f64 - RING as f64) * self.grid.spacing[m];
        Rect { min: [at(from[0], 0), at(from[1], 1)], max: [at(to[0], 0), at(to[1], 1)] }
    }

    /// The cell that a rectangle lies in, if it lies in one.
    fn around(&self, rect: &Rect) -> Option<([usize; 2], Rect)> {
        let c = rect.centre();
        let place = [0, 1].map(|m| (c[m] - self.grid.origin[m]) / self.grid.spacing[m] + RING as f64);
        if !(0..2).all(|m| place[m] >= 0.0 && place[m] < self.wide[m] as f64) {
            return None;
        }
        let at = place.map(|p| p as usize);
        let cell = self.between(at, at.map(|n| n + 1));
        (0..2).all(|m| cell.min[m] <= rect.min[m] && rect.max[m] <= cell.max[m]).then_some((at, cell))
    }

    /// The number of the block that a cell lies in, and its rectangle.
    fn block(&self, at: [usize; 2]) -> (usize, Rect) {
        let of = at.map(|n| n / BLOCK);
        let end = [0, 1].map(|m| ((of[m] + 1) * BLOCK).min(self.wide[m]));
        (of[1] * self.wide[0].div_ceil(BLOCK) + of[0], self.between(of.map(|n| n * BLOCK), end))
    }

    /// The gap in a cell; `None` where it is not smooth.
    fn gap_in(&self, at: [usize; 2], cell: &Rect) -> Option<Smooth> {
        let place = at[1] * self.wide[0] + at[0];
        let from_block = || {
            let blocks = self.blocks.as_ref()?;
            let (place, rect) = self.block(at);
            let taylor = blocks.borrow_mut().at(place, || self.overlap.gap().taylor(&rect).map(Smooth::Second))?;
            let (c, at) = (rect.centre(), cell.centre());
            Some(taylor.moved([0, 1].map(|m| at[m] - c[m])))
        };
        let look = || from_block().or_else(|| self.of_parts_within(at, |overlap| Smooth::of(overlap.gap(), cell)));
        self.cells.borrow_mut().at(place, look)
    }

    /// What `look` tells of the overlap by the parts of the gap that matter around a cell.
    fn of_parts_within<T>(&self, at: [usize; 2], look: impl FnOnce(&GapOverlap) -> T) -> T {
        let Some(simpler) = &self.simpler else { return look(self.overlap) };
        let (place, rect) = self.block(at);
        let mut simpler = simpler.borrow_mut();
        let gap = simpler[place].get_or_insert_with(|| {
            let gap = self.overlap.gap();
            gap.restricted(&rect).unwrap_or_else(|| gap.clone())
        });
        look(&self.overlap.of_part(gap))
    }

    /// The same around the cell that a rectangle lies in.
    fn of_parts<T>(&self, rect: &Rect, look: impl FnOnce(&GapOverlap) -> T) -> T {
        match self.simpler.as_ref().and_then(|_| self.around(rect)) {
            Some((at, _)) => self.of_parts_within(at, look),
            None => look(self.overlap),
        }
    }

    /// The gap about the middle of a part of a cell.
    fn gap_about(&self, rect: &Rect) -> Option<Smooth> {
        let (at, cell) = self.around(rect)?;
        let smooth = self.gap_in(at, &cell)?;
        if *rect == cell {
            return Some(smooth);
        }
        let (c, at) = (cell.centre(), rect.centre());
        Some(smooth.moved([0, 1].map(|m| at[m] - c[m])))
    }

    fn jet_of(&self, smooth: &Smooth) -> Jet {
        match smooth {
            Smooth::Second(taylor) => self.overlap.jet_of(taylor),
            Smooth::Third(cubic) => self.overlap.jet_of_cubic(cubic),
        }
    }
}

impl OverlapBounds for OnCells<'_> {
    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Interval {
        let from_cell = self.gap_about(rect).and_then(|smooth| {
            let taylor = smooth.taylor(rect.size());
            let [low, high] = taylor.bounds(rect.size(), slope.map(|s| -s));
            // Close to a tip second derivatives have no bound, and values have.
            let [gx, gy] = taylor.gradient.map(numeric::Interval::magnitude);
            let [w, h] = rect.size();
            (high - low <= gx * w + gy * h).then_some([low, high])
        });
        from_cell.map_or_else(
            || self.of_parts(rect, |overlap| overlap.bounds(rect, slope)),
            |bounds| self.overlap.below_depth(bounds),
        )
    }

    fn slopes(&self, rect: &Rect) -> [Interval; 2] {
        self.of_parts(rect, |overlap| overlap.slopes(rect))
    }

    /// That of a whole cell is kept; one of a part of it is closer than what the cell tells to second order.
    fn jet(&self, rect: &Rect) -> Option<Jet> {
        if let Some((at, cell)) = self.around(rect) {
            let whole = self.gap_in(at, &cell);
            if *rect == cell {
                return whole.map(|smooth| self.jet_of(&smooth));
            }
            if whole.is_some_and(|smooth| self.blocks.is_some() || matches!(smooth, Smooth::Third(_))) {
                return self.gap_about(rect).map(|smooth| self.jet_of(&smooth));
            }
            return self.of_parts_within(at, |overlap| overlap.jet(rect));
        }
        self.overlap.jet(rect)
    }

    /// Of what is kept, or by values where a cell was not looked at.
    fn nearly(&self, rect: &Rect) -> Option<(f64, [f64; 2])> {
        let is_kept = |at: [usize; 2]| self.cells.borrow().places[at[1] * self.wide[0] + at[0]] != 0;
        if self.around(rect).is_some_and(|(at, _)| is_kept(at)) {
            return self.jet(rect).map(|jet| jet.nearly());
        }
        let [x, y] = rect.centre();
        let (gap, gradient) = (self.gap().gap(x, y), self.gap().gradient(x, y)?);
        Some((self.overlap.depth() - gap, gradient.map(|g| -g)))
    }

    fn mean(&self, rect: &Rect) -> Interval {
        let from_cell = self.gap_about(rect).map(|taylor| taylor.mean(rect.size()));
        let close = from_cell.map(|mean| [mean.lo, mean.hi]).filter(|mean| self.overlap.is_close(*mean));
        close.map_or_else(|| self.of_parts(rect, |overlap| overlap.mean(rect)), |mean| self.overlap.below_depth(mean))
    }

    fn ends(&self) -> bool {
        self.overlap.ends()
    }

    fn material(&self, rect: &Rect) -> bool {
        // Where f is smooth there is material.
        self.gap_about(rect).is_some() || self.of_parts(rect, |overlap| overlap.material(rect))
    }

    fn reach(&self) -> Option<Rect> {
        self.overlap.reach()
    }

    fn has_time(&self) -> bool {
        self.overlap.has_time()
    }

    fn mirrors(&self) -> [Option<f64>; 2] {
        self.overlap.mirrors()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Minimum, Paraboloid, Place, Polyhedron, Sum};

    #[test]
    fn cells_of_a_composed_gap_hold_its_overlap() {
        let round =
            |at: [f64; 2], radius: f64| Paraboloid::new([radius, 2.0 * radius]).unwrap().placed(at, 0.3).unwrap();
        let pyramid = Polyhedron::pyramid(4, 0.2).unwrap().placed([0.5, 0.1], 0.1).unwrap();
        let sum = AnyGap::new(Sum::new(vec![round([-0.4, 0.2], 0.8), pyramid]).unwrap());
        let gap = AnyGap::new(Minimum::new(vec![sum, round([0.3, -0.3], 0.5), round([-0.6, -0.5], 1.0)]).unwrap());
        let overlap = GapOverlap::new(&gap, 0.4);
        let grid = Grid::over(&Rect::around([0.0; 2], [1.0, 0.8]), [20, 16]);
        let cells = OnCells::new(&overlap, &grid);
        let (mut smooth, mut kinked) = (0, 0);
        for k in 0..grid.len() {
            let cell = grid.cell(k % 20, k / 20);
            let c = cell.centre();
            for rect in [cell, Rect { min: cell.min, max: c }, Rect { min: c, max: cell.max }] {
                let (middle, [w, h]) = (rect.centre(), rect.size());
                let [low, high] = cells.bounds(&rect, [0.1, -0.2]);
                let (slopes, mean, jet) = (cells.slopes(&rect), cells.mean(&rect), cells.jet(&rect));
                if jet.is_some() {
                    smooth += 1
                } else {
                    kinked += 1
                }
                let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
                for n in 0..49 {
                    let (s, t) = (f64::from(n % 7) / 6.0 - 0.5, f64::from(n / 7) / 6.0 - 0.5);
                    let (x, y) = (middle[0] + s * w, middle[1] + t * h);
                    let f = 0.4 - gap.gap(x, y);
                    (least, most) = (least.min(f), most.max(f));
                    let less = f - 0.1 * s * w + 0.2 * t * h;
                    assert!(low <= less + 1e-14 && less <= high + 1e-14, "{rect:?}: {less} {low} {high}");
                    let Some(own) = gap.gradient(x, y) else { continue };
                    assert!((0..2).all(|m| slopes[m][0] <= 1e-12 - own[m] && -1e-12 - own[m] <= slopes[m][1]));
                    if let Some(jet) = &jet {
                        let of = super::super::overlap::Taylor::of(jet, [0.5 * w, 0.5 * h]);
                        let off = (of.at([s * w, t * h])[0] - f).abs();
                        assert!(off <= of.most[0] + 1e-14, "{rect:?}: {off} {}", of.most[0]);
                    }
                }
                assert!(least <= mean[1] && mean[0] <= most, "{rect:?}: {mean:?} of {least} to {most}");
            }
        }
        assert!(smooth > 5 * kinked && kinked > 20, "{smooth} {kinked}");
    }
}
