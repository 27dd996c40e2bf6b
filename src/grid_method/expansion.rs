//! Whether a box holds the whole contact.

use crate::gap::lattice;
use crate::grid::Grid;
use crate::numeric::geometry::Rect;
use crate::overlap::Scaled;

/// A larger box, when contact touches a border with overlap beyond it, or a point outside penetrates.
pub(crate) fn expanded(scaled: &Scaled, window: &Rect, grid: &Grid, pressure: &[f64]) -> Option<Rect> {
    let mut wanted = beyond_border(scaled, window, grid, pressure)?;
    for point in penetrating_outside(scaled, window, grid, pressure) {
        wanted = wanted.union(&Rect::around(point, [2.0 * grid.spacing[0], 2.0 * grid.spacing[1]]));
    }
    if wanted == *window {
        return None;
    }
    // No further than there is overlap; a box may be wider than that from the start.
    let wanted = wanted.intersection(&scaled.reach.union(window)).unwrap_or(wanted);
    (wanted != *window).then_some(wanted)
}

/// Whether the contact touches a border of the grid with overlap beyond it.
pub(crate) fn touches_border(scaled: &Scaled, grid: &Grid, pressure: &[f64]) -> bool {
    let window = grid.extent();
    beyond_border(scaled, &window, grid, pressure).is_some_and(|wanted| wanted != window)
}

/// The box, larger where contact touches a border with overlap beyond it; `None` without contact.
fn beyond_border(scaled: &Scaled, window: &Rect, grid: &Grid, pressure: &[f64]) -> Option<Rect> {
    let loaded = Rect::holding(grid.loaded(pressure).map(|(at, _)| at))?;
    let mut wanted = *window;
    for axis in 0..2 {
        // On a coarse grid the outermost cells may well be under pressure.
        let h = grid.spacing[axis].min(window.size()[axis] / NEAR);
        let grow = 0.2 * window.size()[axis];
        if loaded.min[axis] < window.min[axis] + h && window.min[axis] > scaled.reach.min[axis] {
            wanted.min[axis] -= grow;
        }
        if loaded.max[axis] > window.max[axis] - h && window.max[axis] < scaled.reach.max[axis] {
            wanted.max[axis] += grow;
        }
    }
    Some(wanted)
}

/// Contact that comes closer to the border than this part of the box may go on beyond it.
const NEAR: f64 = 64.0;

/// Lattice points between the box and the limit of {f > 0} where the loaded surfaces would overlap.
fn penetrating_outside(scaled: &Scaled, window: &Rect, grid: &Grid, pressure: &[f64]) -> Vec<[f64; 2]> {
    let [w, h] = scaled.reach.size();
    let count = |size: f64, spacing: f64| ((size / spacing).ceil() as usize).clamp(1, OUTSIDE);
    let points = Grid::over(&scaled.reach, [count(w, grid.spacing[0]), count(h, grid.spacing[1])]);
    let area = grid.cell_area();
    let loaded: Vec<([f64; 2], f64)> = grid.loaded(pressure).map(|(at, p)| (at, p * area)).collect();
    let gathered = std::cell::LazyCell::new(|| gathered(&loaded, window));
    let under = |loads: &[([f64; 2], f64)], [x, y]: [f64; 2]| {
        loads.iter().map(|([a, b], q)| q / (x - a).hypot(y - b)).sum::<f64>() / std::f64::consts::PI
    };
    // What a load leaves at a point, at the least: as if it all lay in the corner that is farthest.
    let blocks = in_boxes(&loaded, window);
    let least = |boxes: &[(Rect, f64)], [x, y]: [f64; 2]| {
        let farthest = |r: &Rect| {
            let far = |m: usize, p: f64| (p - r.min[m]).abs().max((r.max[m] - p).abs());
            (far(0, x).powi(2) + far(1, y).powi(2)).sqrt()
        };
        boxes.iter().map(|(r, q)| q / farthest(r)).sum::<f64>() / std::f64::consts::PI
    };
    let whole = blocks.iter().copied().reduce(|(a, p), (b, q)| (a.union(&b), p + q));
    let gaps = lattice::values(&scaled.gap, &points);
    points
        .centres()
        .zip(gaps)
        .filter(|(p, _)| !window.contains(*p))
        .filter(|&([x, y], g)| {
            let f = scaled.depth - g;
            if f <= 0.0 || f <= least(whole.as_slice(), [x, y]) || f <= least(&blocks, [x, y]) {
                return false;
            }
            // Then block by block; every cell for itself only where that leaves it open.
            let u = under(&gathered, [x, y]);
            if f > 0.9 * u && f < 1.1 * u { f > under(&loaded, [x, y]) + 1e-9 } else { f > u + 1e-9 }
        })
        .map(|(p, _)| p)
        .collect()
}

/// The loads in a few parts of the box: the cells they act on, and their sum.
fn in_boxes(loaded: &[([f64; 2], f64)], window: &Rect) -> Vec<(Rect, f64)> {
    let mut parts: [Option<(Rect, f64)>; PARTS * PARTS] = [None; PARTS * PARTS];
    for &(at, q) in loaded {
        let here = Rect { min: at, max: at };
        let part = &mut parts[part_of(at, window, PARTS)];
        *part = Some(part.map_or((here, q), |(r, sum)| (r.union(&here), sum + q)));
    }
    parts.into_iter().flatten().collect()
}

/// In which of so many parts a side of the box a point lies.
fn part_of(at: [f64; 2], window: &Rect, parts: usize) -> usize {
    let (size, last) = (window.size(), parts as f64 - 1.0);
    let [i, j] = [0, 1].map(|m| ((at[m] - window.min[m]) / size[m] * parts as f64).clamp(0.0, last) as usize);
    i * parts + j
}

/// Parts of the box along a side.
const PARTS: usize = 4;

/// The loads of a block of the box at their common centre: a sixteenth of the box a side, so that a point a block away
/// feels them to a few per cent.
fn gathered(loaded: &[([f64; 2], f64)], window: &Rect) -> Vec<([f64; 2], f64)> {
    let mut blocks = vec![Vec::new(); BLOCKS * BLOCKS];
    for &(at, q) in loaded {
        blocks[part_of(at, window, BLOCKS)].push((at, q));
    }
    let total = |block: &Vec<([f64; 2], f64)>| (centre_of_load(block), block.iter().map(|l| l.1).sum());
    blocks.iter().filter(|block| !block.is_empty()).map(total).collect()
}

fn centre_of_load(loads: &[([f64; 2], f64)]) -> [f64; 2] {
    let force: f64 = loads.iter().map(|l| l.1).sum();
    loads.iter().fold([0.0; 2], |m, (c, q)| [m[0] + c[0] * q / force, m[1] + c[1] * q / force])
}

/// Blocks of the box along a side.
const BLOCKS: usize = 16;

/// Most lattice points along a side outside the box.
const OUTSIDE: usize = 256;
