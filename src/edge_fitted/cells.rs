//! Pressure in cells, resampled onto a uniform grid by exact means.

use super::mesh::{Point, norm};
use crate::grid::{Grid, Pressure};
use crate::numeric::geometry::{area, clip, disc_in_polygon};

/// The means over the cells of a grid of a pressure that is constant in convex cells.
#[must_use]
pub(crate) fn resample(cells: &[([Point; 4], f64)], grid: Grid) -> Pressure {
    let Grid { origin, spacing, shape } = grid;
    let mut values = vec![0.0; grid.len()];
    for (corners, p) in cells {
        let range = |k: usize| {
            let low = corners.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min);
            let high = corners.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
            let index = |x: f64| ((x - origin[k]) / spacing[k]).floor().clamp(0.0, shape[k] as f64) as usize;
            index(low)..(index(high) + 1).min(shape[k])
        };
        let columns = range(0);
        for j in range(1) {
            for i in columns.clone() {
                let low = [origin[0] + i as f64 * spacing[0], origin[1] + j as f64 * spacing[1]];
                let share = shared_area(corners, low, [low[0] + spacing[0], low[1] + spacing[1]]);
                values[j * shape[0] + i] += p * share / grid.cell_area();
            }
        }
    }
    Pressure { grid, values }
}

/// The means over the cells of a grid of a pressure that is constant in concentric rings: radii and pressure of each.
#[must_use]
pub(crate) fn resample_rings(rings: &[([f64; 2], f64)], centre: Point, grid: Grid) -> Pressure {
    let mean = |k: usize| {
        let [i, j] = [k % grid.shape[0], k / grid.shape[0]];
        let corners = grid.cell(i, j).corners().map(|c| [c[0] - centre[0], c[1] - centre[1]]);
        // Distances of the cell from the centre, at least and at most.
        let far = corners.iter().map(|c| norm(*c)).fold(0.0, f64::max);
        let near = far - norm(grid.spacing);
        let inside = |r: f64| disc_in_polygon(&corners, r);
        let meets = |ring: &&([f64; 2], f64)| ring.0[1] > near && ring.0[0] < far;
        // What a ring shares with the cell is no less than nothing, but for rounding.
        let shared = |[a, b]: [f64; 2]| (inside(b) - inside(a)).max(0.0);
        rings.iter().filter(meets).map(|(radii, p)| p * shared(*radii)).sum::<f64>() / grid.cell_area()
    };
    Pressure { grid, values: (0..grid.len()).map(mean).collect() }
}

/// The area that a convex polygon shares with a rectangle.
fn shared_area(corners: &[Point], low: Point, high: Point) -> f64 {
    let sides = [[-1.0, 0.0, low[0]], [1.0, 0.0, -high[0]], [0.0, -1.0, low[1]], [0.0, 1.0, -high[1]]];
    area(&sides.iter().fold(corners.to_vec(), |left, [a, b, c]| clip(&left, *a, *b, *c))).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_integral_is_kept() {
        let cells = [
            ([[0.1, 0.2], [1.3, 0.4], [1.1, 1.6], [0.0, 1.0]], 2.0),
            ([[1.3, 0.4], [2.0, 0.3], [1.9, 1.7], [1.1, 1.6]], 3.0),
        ];
        let grid = Grid { origin: [-0.5, -0.5], spacing: [0.13, 0.17], shape: [30, 20] };
        let values = resample(&cells, grid).values;
        let sum: f64 = values.iter().sum::<f64>() * 0.13 * 0.17;
        let exact: f64 = cells.iter().map(|(c, p)| p * area(c)).sum();
        assert!((sum - exact).abs() < 1e-13);
        // A grid cell well inside carries the pressure itself.
        assert!((values[8 * 30 + 8] - 2.0).abs() < 1e-13, "{}", values[8 * 30 + 8]);
    }

    #[test]
    fn rings_keep_their_force() {
        let rings = [([0.0, 0.3], 2.0), ([0.3, 0.7], 3.0), ([0.9, 1.0], 1.5)];
        let grid = Grid { origin: [-1.1, -0.9], spacing: [0.07, 0.05], shape: [34, 44] };
        let values = resample_rings(&rings, [0.1, 0.2], grid).values;
        let sum: f64 = values.iter().sum::<f64>() * grid.cell_area();
        let exact: f64 = rings.iter().map(|([a, b], p)| p * std::f64::consts::PI * (b * b - a * a)).sum();
        assert!((sum / exact - 1.0).abs() < 1e-12, "{sum} {exact}");
        let row = ((0.2 - grid.origin[1]) / 0.05) as usize;
        let column = |r: f64| ((0.1 + r - grid.origin[0]) / 0.07) as usize;
        assert!((values[row * 34 + column(0.5)] - 3.0).abs() < 1e-12 && values[row * 34 + column(0.8)] == 0.0);
    }
}
