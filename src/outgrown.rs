//! Whether a box holds the whole contact.

use crate::domain::Door;
use crate::gap::Gap;
use crate::geometry::Rect;
use crate::grid::Grid;

/// A larger box, when contact touches a border with overlap beyond it, or a point outside penetrates.
pub(crate) fn outgrown(door: &Door, window: &Rect, grid: &Grid, pressure: &[f64]) -> Option<Rect> {
    let loaded = Rect::holding((0..grid.len()).filter(|&k| pressure[k] > 0.0).map(|k| grid.centre_of(k)))?;
    let mut wanted = *window;
    for axis in 0..2 {
        let h = grid.spacing[axis];
        let grow = 0.2 * window.size()[axis];
        // A whole number of cells: the new grid is then no other sample of the gap than it has to be.
        if loaded.min[axis] < window.min[axis] + h && window.min[axis] > door.reach.min[axis] {
            wanted.min[axis] -= grow;
        }
        if loaded.max[axis] > window.max[axis] - h && window.max[axis] < door.reach.max[axis] {
            wanted.max[axis] += grow;
        }
    }
    for point in penetrating_outside(door, window, grid, pressure) {
        wanted = wanted.union(&Rect::around(point, [2.0 * grid.spacing[0], 2.0 * grid.spacing[1]]));
    }
    let wanted = wanted.intersection(&door.reach).unwrap_or(wanted);
    (wanted != *window).then_some(wanted)
}

/// Lattice points between the box and the limit of {f > 0} where the loaded surfaces would overlap.
fn penetrating_outside(door: &Door, window: &Rect, grid: &Grid, pressure: &[f64]) -> Vec<[f64; 2]> {
    let [w, h] = door.reach.size();
    let count = |size: f64, spacing: f64| ((size / spacing).ceil() as usize).clamp(1, OUTSIDE);
    let lattice = Grid::over(&door.reach, [count(w, grid.spacing[0]), count(h, grid.spacing[1])]);
    let area = grid.cell_area();
    let loaded: Vec<([f64; 2], f64)> =
        (0..grid.len()).filter(|&k| pressure[k] > 0.0).map(|k| (grid.centre_of(k), pressure[k] * area)).collect();
    let gathered = gathered(&loaded, window);
    let under = |loads: &[([f64; 2], f64)], [x, y]: [f64; 2]| {
        loads.iter().map(|([a, b], q)| q / (x - a).hypot(y - b)).sum::<f64>() / std::f64::consts::PI
    };
    let force: f64 = loaded.iter().map(|l| l.1).sum();
    let [px, py] = centre_of_load(&loaded);
    (0..lattice.len())
        .map(|k| lattice.centre_of(k))
        .filter(|p| !window.contains(*p))
        .filter(|&[x, y]| {
            let f = door.depth - door.gap.gap(x, y);
            // The whole load at its centre, at the farthest it can be: cheap, and enough nearly everywhere.
            let farthest = (x - px).hypot(y - py) + window.size()[0].hypot(window.size()[1]);
            if f <= force / (std::f64::consts::PI * farthest) {
                return false;
            }
            // Then block by block; every cell for itself only where that leaves it open.
            let u = under(&gathered, [x, y]);
            if f > 0.9 * u && f < 1.1 * u { f > under(&loaded, [x, y]) + 1e-9 } else { f > u + 1e-9 }
        })
        .collect()
}

/// The loads of a block of the box at their common centre: a sixteenth of the box a side, so that a point a block away
/// feels them to a few per cent.
fn gathered(loaded: &[([f64; 2], f64)], window: &Rect) -> Vec<([f64; 2], f64)> {
    let mut blocks = vec![Vec::new(); BLOCKS * BLOCKS];
    let size = window.size();
    for &(at, q) in loaded {
        let [i, j] =
            [0, 1].map(|m| ((at[m] - window.min[m]) / size[m] * BLOCKS as f64).clamp(0.0, BLOCKS as f64 - 1.0));
        blocks[i as usize * BLOCKS + j as usize].push((at, q));
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
