//! Starting pressures from coarser grids.

use super::face::Face;
use super::{Settings, solve};
use crate::discrete::Discrete;
use crate::error::Unsolved;
use crate::grid::Grid;

/// Cells along the longer side below which a solve starts from nothing.
const SMALLEST: usize = 12;

/// Residual on the coarse grids: their discretisation error is larger.
const COARSE: f64 = 1e-3;

/// Gives `face` a start from a solve on cells twice as large.
pub(super) fn start(problem: &Discrete, face: &mut Face, settings: &Settings) -> Result<(), Unsolved> {
    if problem.grid.shape.iter().any(|&n| n < SMALLEST) {
        face.start_from_overlap();
        return Ok(());
    }
    let coarse = halved(problem);
    let loose = Settings { residual: settings.residual.max(COARSE), ..*settings };
    let solved = solve(&coarse, None, &loose)?;
    if solved.pressure.iter().all(|&p| p == 0.0) {
        face.start_from_overlap();
    } else {
        face.start_from(&prolonged(&solved.pressure, &coarse.grid, &problem.grid));
    }
    face.products += 0;
    Ok(())
}

/// The same problem on blocks of 2 x 2 cells: the mean overlap of those with material.
fn halved(problem: &Discrete) -> Discrete {
    let fine = &problem.grid;
    let shape = fine.shape.map(|n| n.div_ceil(2));
    let grid = Grid { origin: fine.origin, spacing: fine.spacing.map(|h| 2.0 * h), shape };
    let overlap = (0..grid.len())
        .map(|k| {
            let (i, j) = (2 * (k % shape[0]), 2 * (k / shape[0]));
            let (mut sum, mut count) = (0.0, 0);
            for (a, b) in [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)] {
                if a < fine.shape[0] && b < fine.shape[1] {
                    let f = problem.overlap[b * fine.shape[0] + a];
                    if f.is_finite() {
                        sum += f;
                        count += 1;
                    }
                }
            }
            if count >= 2 { sum / f64::from(count) } else { f64::NEG_INFINITY }
        })
        .collect();
    Discrete { grid, kernel: problem.kernel, overlap }
}

/// Bilinear from cell centre to cell centre.
fn prolonged(pressure: &[f64], coarse: &Grid, fine: &Grid) -> Vec<f64> {
    let at = |i: i64, j: i64| {
        let (i, j) = (i.clamp(0, coarse.shape[0] as i64 - 1), j.clamp(0, coarse.shape[1] as i64 - 1));
        pressure[j as usize * coarse.shape[0] + i as usize]
    };
    (0..fine.len())
        .map(|k| {
            let (i, j) = ((k % fine.shape[0]) as i64, (k / fine.shape[0]) as i64);
            let (a, b) = (i / 2, j / 2);
            let (da, db) = (if i % 2 == 0 { -1 } else { 1 }, if j % 2 == 0 { -1 } else { 1 });
            0.5625 * at(a, b) + 0.1875 * (at(a + da, b) + at(a, b + db)) + 0.0625 * at(a + da, b + db)
        })
        .collect()
}
