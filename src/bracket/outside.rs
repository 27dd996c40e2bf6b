//! The part of {f > 0} that the grid does not cover: where the bodies could overlap unseen.

use super::Frame;
use crate::geometry::Rect;

/// Blocks a side into which the load is gathered.
const BLOCKS: usize = 16;

/// Rectangles looked at before the rest is taken as it is.
const MOST: usize = 100_000;

/// A rectangle where f may exceed u.
pub(super) struct Spill {
    pub rect: Rect,
    /// Supremum of f less infimum of u.
    pub over: f64,
    /// Supremum of f over infimum of u.
    pub short: f64,
    /// Infimum of u.
    pub least: f64,
}

/// Rectangles outside the grid, as small as a cell, that cover every point with f > u > 0 and f > 0.
pub(super) fn spills(frame: &Frame, q: &[f64]) -> Vec<Spill> {
    let (inner, outer) = (frame.grid.extent(), frame.reach);
    let mut waiting = Vec::new();
    let strips = [
        Rect { min: outer.min, max: [inner.min[0], outer.max[1]] },
        Rect { min: [inner.max[0], outer.min[1]], max: outer.max },
        Rect { min: [inner.min[0], outer.min[1]], max: [inner.max[0], inner.min[1]] },
        Rect { min: [inner.min[0], inner.max[1]], max: [inner.max[0], outer.max[1]] },
    ];
    waiting.extend(strips.into_iter().filter_map(|s| s.intersection(&outer)).filter(|s| s.size().iter().all(|&w| w > 0.0)));
    let loads = gathered(frame, q);
    let smallest = frame.grid.spacing[0].max(frame.grid.spacing[1]);
    let mut spills = Vec::new();
    let mut seen = 0;
    while let Some(rect) = waiting.pop() {
        seen += 1;
        let f = frame.most_overlap(&rect);
        if f <= 0.0 {
            continue;
        }
        let u = loads.iter().map(|(load, block)| load / furthest(&rect, block)).sum::<f64>() * (1.0 - 1e-12)
            / std::f64::consts::PI;
        if f <= u {
            continue;
        }
        let [w, h] = rect.size();
        if w.max(h) <= smallest || seen > MOST {
            let short = if u > 0.0 { f / u } else { f64::INFINITY };
            spills.push(Spill { rect, over: f - u, short, least: u });
            continue;
        }
        let c = rect.centre();
        let (mut low, mut high) = (rect, rect);
        let axis = usize::from(h > w);
        (low.max[axis], high.min[axis]) = (c[axis], c[axis]);
        waiting.extend([low, high]);
    }
    spills
}

/// The load in blocks of cells, each with the rectangle it lies in.
fn gathered(frame: &Frame, q: &[f64]) -> Vec<(f64, Rect)> {
    let (grid, [nx, ny]) = (&frame.grid, frame.grid.shape);
    let [bx, by] = [nx.div_ceil(BLOCKS), ny.div_ceil(BLOCKS)];
    let mut blocks: Vec<(f64, Option<Rect>)> = vec![(0.0, None); nx.div_ceil(bx) * ny.div_ceil(by)];
    for (k, &q) in q.iter().enumerate().filter(|(_, q)| **q > 0.0) {
        let (i, j) = (k % nx, k / nx);
        let block = &mut blocks[(j / by) * nx.div_ceil(bx) + i / bx];
        let cell = grid.cell(i, j);
        block.0 += q * grid.cell_area();
        block.1 = Some(block.1.map_or(cell, |r| r.union(&cell)));
    }
    blocks.into_iter().filter_map(|(load, rect)| Some((load, rect?))).collect()
}

/// Largest distance between points of two rectangles.
fn furthest(a: &Rect, b: &Rect) -> f64 {
    let along = |m: usize| (a.max[m] - b.min[m]).max(b.max[m] - a.min[m]);
    along(0).hypot(along(1))
}
