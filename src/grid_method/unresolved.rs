//! What the cells of one grid leave open, whatever other grids say: one step from grid to grid may be small by luck.
//!
//! Measured on 70 paraboloids of aspects to 7 and powers of exponents 1.3 to 6.3, at any turn and place, on 40 to 90 cells, both
//! kernels: area and stiffness of the true contact lie within 0.27 and 0.25 of rho^1.5.

use crate::grid::Grid;

/// Share of rho^1.5.
const OF_RIM: f64 = 0.4;

/// Relative error of a number that rests on where the boundary lies between cells: rho is the share of the pressed cells that have
/// a free neighbour.
pub(crate) fn boundary(grid: &Grid, pressure: &[f64]) -> f64 {
    let [nx, ny] = grid.shape;
    let pressed = |k: usize| pressure[k] > 0.0;
    let on_rim = |k: &usize| {
        let (i, j) = (k % nx, k / nx);
        let inner = i > 0 && i + 1 < nx && j > 0 && j + 1 < ny;
        !(inner && pressed(k - 1) && pressed(k + 1) && pressed(k - nx) && pressed(k + nx))
    };
    let all = (0..pressure.len()).filter(|&k| pressed(k));
    let (count, rim) = all.fold((0_usize, 0_usize), |(n, r), k| (n + 1, r + usize::from(on_rim(&k))));
    if count == 0 { 1.0 } else { OF_RIM * (rim as f64 / count as f64).powf(1.5) }
}

/// Growth of the drop from one cell to two where the pressure is smooth about its peak: 3 or 4 for a paraboloid of pressure, 2.4 to
/// 2.8 where it falls as r^1.5.
const SMOOTH: f64 = 2.9;

/// Error of a peak over the drop to the cells beside it: smooth, and not.
const OF_DROP: [f64; 2] = [0.5, 2.5];

/// Relative error of the largest pressure of a grid, from how much the pressure varies from cell to cell about it.
pub(crate) fn peak(grid: &Grid, pressure: &[f64], strongest: usize) -> f64 {
    let [nx, ny] = grid.shape.map(|n| n as i64);
    let (i, j) = (strongest as i64 % nx, strongest as i64 / nx);
    let highest = pressure[strongest];
    let drop = |far: i64| {
        let at = |(di, dj): (i64, i64)| {
            let (i, j) = (i + far * di, j + far * dj);
            let inside = (0..nx).contains(&i) && (0..ny).contains(&j);
            if inside { highest - pressure[(j * nx + i) as usize] } else { highest }
        };
        [(1, 0), (-1, 0), (0, 1), (0, -1)].map(at).into_iter().fold(0.0, f64::max) / highest
    };
    let [near, far] = [drop(1), drop(2)];
    OF_DROP[usize::from(!(far > SMOOTH * near))] * near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finer_cells_leave_less_open() {
        let left = |n: usize, power: f64| {
            let grid = Grid { origin: [-1.0; 2], spacing: [2.0 / n as f64; 2], shape: [n, n] };
            let p: Vec<f64> = grid.centres().map(|[x, y]| (1.0 - x.hypot(y).powf(power)).max(0.0)).collect();
            let strongest = (0..p.len()).max_by(|&a, &b| p[a].total_cmp(&p[b])).unwrap();
            // A peak of 1 at the middle, met by a cell or by a corner of four.
            (boundary(&grid, &p), peak(&grid, &p, strongest), (1.0 / p[strongest] - 1.0).abs())
        };
        for power in [0.5, 1.0, 2.0] {
            for n in [20, 21, 40, 41, 80] {
                let (rim, drop, off) = left(n, power);
                assert!(off <= drop, "{n} cells, r^{power}: {off} {drop}");
                // A cell stays in the middle, or a corner.
                let (finer, lower, _) = left(2 * n + n % 2, power);
                assert!(finer < 0.5 * rim && lower < drop);
            }
        }
    }
}
