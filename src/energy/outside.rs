//! Beyond the contact f <= u has to be shown, not measured: most of it from the load alone.
//!
//! A load P at distances up to R moves the surface by P/(pi R) at least. Where the overlap is below what all loads do in this way there
//! is nothing more to look at.

use super::field::{Field, RING};
use super::overlap::OverlapBounds;
use crate::grid::Grid;
use crate::numeric::geometry::Rect;

/// Blocks of cells along each side of the loaded box.
const BLOCKS: usize = 8;

/// Side of the tiles, in cells, that are shown as a whole to lie beyond the contact, or whose cells are looked at one by one.
const TILE: usize = 4;

/// Halvings of the rectangles beyond the grid.
const HALVINGS: u32 = 14;

/// Loads put together in blocks.
pub(super) struct Loads {
    blocks: Vec<(Rect, f64)>,
    /// What the loads of the blocks may be less than that: their rounding.
    less: f64,
}

impl Loads {
    /// Of a pressure p >= 0 on the cells of a grid, row by row.
    pub fn new<'a>(grid: &Grid, row: impl Fn(usize) -> &'a [f64]) -> Self {
        let [nx, ny] = grid.shape;
        let loaded = |p: &f64| *p > 0.0;
        let rows: Vec<usize> = (0..ny).filter(|j| row(*j).iter().any(loaded)).collect();
        let (Some(low), Some(high)) = (rows.first(), rows.last()) else {
            return Self { blocks: Vec::new(), less: 1.0 };
        };
        let columns = rows.iter().map(|j| {
            let row = row(*j);
            [row.iter().position(loaded).unwrap_or(nx), row.iter().rposition(loaded).unwrap_or(0)]
        });
        let [left, right] = columns.fold([nx, 0], |[a, b], [c, d]| [a.min(c), b.max(d)]);
        let size = [(right - left) / BLOCKS + 1, (high - low) / BLOCKS + 1];
        let mut loads = [0.0; BLOCKS * BLOCKS];
        for j in rows.iter().copied() {
            for (i, p) in row(j).iter().enumerate().filter(|(_, p)| **p > 0.0) {
                loads[(j - low) / size[1] * BLOCKS + (i - left) / size[0]] += p;
            }
        }
        let rect = |k: usize| {
            let from = [left + k % BLOCKS * size[0], low + k / BLOCKS * size[1]];
            let to = [(from[0] + size[0]).min(right + 1), (from[1] + size[1]).min(high + 1)];
            let at = |n: [usize; 2]| [0, 1].map(|m| grid.origin[m] + n[m] as f64 * grid.spacing[m]);
            Rect { min: at(from), max: at(to) }
        };
        let blocks = loads.iter().enumerate().filter(|(_, p)| **p > 0.0);
        let blocks = blocks.map(|(k, p)| (rect(k), p * grid.cell_area() * std::f64::consts::FRAC_1_PI)).collect();
        Self { blocks, less: 1.0 - 1e-12 }
    }

    /// Bound from below of u all over a rectangle.
    pub fn displacement(&self, rect: &Rect) -> f64 {
        let far = |block: &Rect| {
            let [x, y] = [0, 1].map(|m| (rect.max[m] - block.min[m]).max(block.max[m] - rect.min[m]));
            x.hypot(y)
        };
        self.less * self.blocks.iter().map(|(block, load)| load / far(block)).sum::<f64>()
    }

    /// Whether f <= u, or there is no material, all over a rectangle, by this alone.
    pub fn clears(&self, overlap: &dyn OverlapBounds, rect: &Rect) -> bool {
        let [_, high] = overlap.bounds(rect, [0.0; 2]);
        high <= 0.0 || high <= self.displacement(rect) || !overlap.material(rect)
    }
}

/// The rectangle of the cells that are looked at.
fn looked_at(grid: &Grid) -> Rect {
    let extent = grid.extent();
    let more = [0, 1].map(|m| RING as f64 * grid.spacing[m]);
    Rect {
        min: [extent.min[0] - more[0], extent.min[1] - more[1]],
        max: [extent.max[0] + more[0], extent.max[1] + more[1]],
    }
}

/// Whether f <= u everywhere beyond the cells that are looked at.
pub(super) fn clear_beyond(grid: &Grid, overlap: &dyn OverlapBounds, loads: &Loads) -> bool {
    let Some(reach) = overlap.reach() else { return false };
    let inner = looked_at(grid);
    if (0..2).all(|m| inner.min[m] <= reach.min[m] && reach.max[m] <= inner.max[m]) {
        return true;
    }
    if !(0..2).all(|m| reach.min[m].is_finite() && reach.max[m].is_finite()) {
        return false;
    }
    let sides = [
        Rect { min: reach.min, max: [reach.max[0], inner.min[1]] },
        Rect { min: [reach.min[0], inner.max[1]], max: reach.max },
        Rect { min: reach.min, max: [inner.min[0], reach.max[1]] },
        Rect { min: [inner.max[0], reach.min[1]], max: reach.max },
    ];
    let real = |r: &Rect| (0..2).all(|m| r.min[m] < r.max[m]);
    sides.iter().filter(|r| real(r)).all(|side| clear(overlap, loads, side, HALVINGS))
}

fn clear(overlap: &dyn OverlapBounds, loads: &Loads, rect: &Rect, deeper: u32) -> bool {
    if loads.clears(overlap, rect) {
        return true;
    }
    if deeper == 0 {
        return false;
    }
    let ([w, h], c) = (rect.size(), rect.centre());
    let cut = usize::from(h > w);
    let (mut low, mut high) = (*rect, *rect);
    (low.max[cut], high.min[cut]) = (c[cut], c[cut]);
    clear(overlap, loads, &low, deeper - 1) && clear(overlap, loads, &high, deeper - 1)
}

/// Of the cells that are looked at, from `first` on along either axis and not `loaded`: those for which f <= u is not shown by the
/// loads. Calls `near` for runs of them: from i, how many, row j.
pub(super) fn near(
    field: &Field,
    overlap: &dyn OverlapBounds,
    loads: &Loads,
    first: [isize; 2],
    loaded: impl Fn(isize, isize) -> bool,
    mut near: impl FnMut(isize, usize, isize),
) {
    let end = field.grid.shape.map(|n| (n + RING) as isize);
    let grid = &field.grid;
    let at = |i: isize, m: usize| grid.origin[m] + i as f64 * grid.spacing[m];
    let tile = TILE as isize;
    let mut j = first[1];
    while j < end[1] {
        let to = (j + tile).min(end[1]);
        let mut i = first[0];
        // Tiles of a strip that are not clear, side by side.
        let mut open: Option<isize> = None;
        loop {
            let next = (i + tile).min(end[0]);
            let inside = i < end[0];
            let full = inside && (j..to).all(|j| (i..next).all(|i| loaded(i, j)));
            let any = full || inside && (j..to).any(|j| (i..next).any(|i| loaded(i, j)));
            let rect = Rect { min: [at(i, 0), at(j, 1)], max: [at(next, 0), at(to, 1)] };
            let keep = inside && !full && (any || !loads.clears(overlap, &rect));
            match (open, keep) {
                (None, true) => open = Some(i),
                (Some(from), false) => {
                    (j..to).for_each(|j| near(from, (i - from) as usize, j));
                    open = None;
                }
                _ => {}
            }
            if !inside {
                break;
            }
            i = next;
        }
        j = to;
    }
}
