//! How far two patches, and two pressures, are apart.

use crate::grid::Pressure;
use crate::numeric::geometry::Rect;

/// Lines across both patches, on which lengths are exact: the area between two boundaries is good to about 1e-3 of it.
const SCAN_LINES: usize = 1000;

/// Area inside one set of closed polylines but not the other, over the area inside the second (even-odd rule).
pub(super) fn between_patches(a: &[Vec<[f64; 2]>], b: &[Vec<[f64; 2]>]) -> Option<f64> {
    let points = a.iter().chain(b).flatten().copied();
    let extent = Rect::holding(points)?;
    let height = extent.size()[1] / SCAN_LINES as f64;
    let (mut between, mut within) = (0.0, 0.0);
    for k in 0..SCAN_LINES {
        let y = extent.min[1] + (k as f64 + 0.5) * height;
        let (own, other) = (crossings(a, y), crossings(b, y));
        within += other.chunks_exact(2).map(|pair| pair[1] - pair[0]).sum::<f64>();
        // A point is in exactly one of the two where it has passed an odd number of crossings of both together.
        let mut all = [own, other].concat();
        all.sort_by(f64::total_cmp);
        between += all.chunks_exact(2).map(|pair| pair[1] - pair[0]).sum::<f64>();
    }
    (within > 0.0).then(|| between / within)
}

/// Where the line at this height crosses closed polylines, ascending.
fn crossings(loops: &[Vec<[f64; 2]>], y: f64) -> Vec<f64> {
    let mut at = Vec::new();
    for points in loops {
        for (p, q) in points.iter().zip(points.iter().cycle().skip(1)) {
            if (p[1] > y) != (q[1] > y) {
                at.push(p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]));
            }
        }
    }
    at.sort_by(f64::total_cmp);
    at
}

/// Integral of |p - q| over that of q, cell by cell of the coarser grid: what two uniform pressures within a cell cannot
/// show is not counted. `None` when q carries nothing.
pub(super) fn between_pressures(p: &Pressure, q: &Pressure) -> Option<f64> {
    let total = q.force();
    let (coarse, fine) = if p.grid.cell_area() >= q.grid.cell_area() { (p, q) } else { (q, p) };
    let shares = [0, 1].map(|m| shares(coarse, fine, m));
    let [nx, _] = coarse.grid.shape;
    let mut forces: Vec<f64> = coarse.values.iter().map(|p| p * coarse.grid.cell_area()).collect();
    // What is taken from cells of the coarse grid, and what lies beyond them.
    let mut beyond = 0.0;
    for (k, pressure) in fine.values.iter().enumerate().filter(|(_, p)| **p != 0.0) {
        let [i, j] = [k % fine.grid.shape[0], k / fine.grid.shape[0]];
        let mut inside = 0.0;
        for &(row, height) in &shares[1][j] {
            for &(column, width) in &shares[0][i] {
                forces[row * nx + column] -= pressure * width * height;
                inside += width * height;
            }
        }
        beyond += pressure * (fine.grid.cell_area() - inside).max(0.0);
    }
    (total > 0.0).then(|| (forces.iter().map(|f| f.abs()).sum::<f64>() + beyond) / total)
}

/// For each cell of the fine grid along one axis: the coarse cells it lies in, and the lengths in them.
fn shares(coarse: &Pressure, fine: &Pressure, axis: usize) -> Vec<Vec<(usize, f64)>> {
    let (c, f) = (&coarse.grid, &fine.grid);
    let place = |k: usize| (f.origin[axis] - c.origin[axis] + k as f64 * f.spacing[axis]) / c.spacing[axis];
    let last = c.shape[axis] as f64;
    (0..f.shape[axis])
        .map(|k| {
            let [from, to] = [place(k), place(k + 1)].map(|x| x.clamp(0.0, last));
            let cells = from.floor() as usize..to.ceil() as usize;
            cells.map(|n| (n, (to.min(n as f64 + 1.0) - from.max(n as f64)).max(0.0) * c.spacing[axis])).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;

    fn square(x: f64, side: f64) -> Vec<Vec<[f64; 2]>> {
        vec![vec![[x, 0.0], [x + side, 0.0], [x + side, side], [x, side]]]
    }

    #[test]
    fn area_between_two_boundaries() {
        // Shifted by a quarter: two strips of a quarter each.
        assert!((between_patches(&square(0.25, 1.0), &square(0.0, 1.0)).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(between_patches(&square(0.0, 1.0), &square(0.0, 1.0)), Some(0.0));
        // Half the side inside: three quarters missing; the scan lines are 1/1000 apart.
        assert!((between_patches(&square(0.0, 0.5), &square(0.0, 1.0)).unwrap() - 0.75).abs() < 1e-3);
    }

    fn uniform(x: f64, side: f64, cells: usize, pressure: f64) -> Pressure {
        let grid = Grid::over(&Rect { min: [x, 0.0], max: [x + side, side] }, [cells; 2]);
        Pressure { grid, values: vec![pressure; cells * cells] }
    }

    #[test]
    fn force_between_two_pressures() {
        // The same on other cells, twice as strong, shifted by a quarter, beside each other; both ways round.
        let unit = uniform(0.0, 1.0, 7, 1.0);
        for (other, wanted) in [
            (uniform(0.0, 1.0, 3, 1.0), 0.0),
            (uniform(0.0, 1.0, 20, 2.0), 1.0),
            (uniform(0.0, 1.0, 4, 2.0), 1.0),
            (uniform(3.0, 1.0, 4, 1.0), 2.0),
            (uniform(3.0, 1.0, 9, 1.0), 2.0),
        ] {
            let found = between_pressures(&other, &unit).unwrap();
            assert!((found - wanted).abs() < 1e-12, "{found} is not {wanted}");
        }
        let shifted = uniform(0.25, 1.0, 8, 1.0);
        let found = between_pressures(&shifted, &uniform(0.0, 1.0, 4, 1.0)).unwrap();
        assert!((found - 0.5).abs() < 1e-12, "{found}");
        assert_eq!(between_pressures(&unit, &uniform(0.0, 1.0, 2, 0.0)), None);
    }
}
