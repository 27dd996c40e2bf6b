//! The separate regions of a patch, with what each of them carries.

use crate::grid::Grid;
use crate::numeric::geometry::{Rect, area, centroid};
use crate::solution::Piece;

/// A cell that is in no region.
const FREE: u32 = u32::MAX;

/// The regions of cells under pressure with the cell of the largest pressure of each, largest force first; cells that meet at a corner belong together, as along the boundary.
/// `loops` are the closed lines of the boundary, `starts` a cell that each goes around.
pub(super) fn of(grid: &Grid, pressure: &[f64], starts: &[usize], loops: &[Vec<[f64; 2]>]) -> Vec<(Piece, usize)> {
    let labels = labelled(grid, pressure);
    let count = labels.iter().filter(|&&label| label != FREE).max().map_or(0, |&label| label as usize + 1);
    let none = Sums { area: 0.0, moment: [0.0; 2], force: 0.0, highest: 0.0, peak: 0, rect: None };
    let mut sums = vec![none; count];
    for (&start, polygon) in starts.iter().zip(loops) {
        // Holes turn the other way and count as less.
        let (own, at, rect) = (area(polygon), centroid(polygon), Rect::holding(polygon.iter().copied()));
        if let Some(sum) = sums.get_mut(labels[start] as usize) {
            sum.area += own;
            sum.moment = [0, 1].map(|m| sum.moment[m] + own * at[m]);
            sum.rect = sum.rect.map_or(rect, |held| rect.map(|rect| held.union(&rect)));
        }
    }
    for (k, (label, &p)) in labels.iter().zip(pressure).enumerate() {
        if let Some(sum) = sums.get_mut(*label as usize) {
            sum.force += p * grid.cell_area();
            if p > sum.highest {
                (sum.highest, sum.peak) = (p, k);
            }
        }
    }
    let mut pieces: Vec<(Piece, usize)> = sums.iter().filter_map(|sum| sum.piece().map(|p| (p, sum.peak))).collect();
    pieces.sort_by(|a, b| b.0.force.total_cmp(&a.0.force));
    pieces
}

/// What adds up to a piece.
#[derive(Clone)]
struct Sums {
    area: f64,
    moment: [f64; 2],
    force: f64,
    highest: f64,
    /// The cell of that.
    peak: usize,
    rect: Option<Rect>,
}

impl Sums {
    fn piece(&self) -> Option<Piece> {
        let rect = self.rect.filter(|_| self.area > 0.0)?;
        Some(Piece {
            area: self.area,
            force: self.force,
            centroid: self.moment.map(|m| m / self.area),
            extent: [rect.min, rect.max],
            max_pressure: Some(self.highest),
        })
    }
}

/// The number of its region for every cell under pressure.
fn labelled(grid: &Grid, pressure: &[f64]) -> Vec<u32> {
    let [nx, ny] = grid.shape;
    let mut labels = vec![FREE; pressure.len()];
    let (mut next, mut stack) = (0, Vec::new());
    for start in 0..pressure.len() {
        if !(pressure[start] > 0.0) || labels[start] != FREE {
            continue;
        }
        labels[start] = next;
        stack.push(start);
        while let Some(k) = stack.pop() {
            let around = |n: usize, end: usize| n.saturating_sub(1)..(n + 2).min(end);
            for j in around(k / nx, ny) {
                for i in around(k % nx, nx) {
                    let beside = j * nx + i;
                    if pressure[beside] > 0.0 && labels[beside] == FREE {
                        labels[beside] = next;
                        stack.push(beside);
                    }
                }
            }
        }
        next += 1;
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_add_up_and_the_strongest_is_first() {
        let rows = ["##....", "##.###", "...#.#", "#..###"];
        let pressure: Vec<f64> = rows.concat().chars().map(|c| if c == '#' { 1.0 } else { 0.0 }).collect();
        let grid = Grid { origin: [0.0; 2], spacing: [2.0, 1.0], shape: [6, 4] };
        let inside: Vec<bool> = pressure.iter().map(|&p| p > 0.0).collect();
        let (starts, loops): (Vec<_>, Vec<_>) = super::super::march(&grid, &inside, |_, _| 0.5).into_iter().unzip();
        let pieces: Vec<Piece> = of(&grid, &pressure, &starts, &loops).into_iter().map(|(piece, _)| piece).collect();
        assert_eq!(pieces.iter().map(|p| p.force).collect::<Vec<_>>(), [16.0, 8.0, 2.0]);
        let all: f64 = loops.iter().map(|l| area(l)).sum();
        assert!((pieces.iter().map(|p| p.area).sum::<f64>() - all).abs() < 1e-12);
        // The ring around a hole, and its box.
        assert_eq!(pieces[0].extent, [[6.0, 1.0], [12.0, 4.0]]);
        assert!((pieces[0].centroid[0] - 9.0).abs() < 1e-12 && (pieces[0].centroid[1] - 2.5).abs() < 1e-12);
        // Nine cells less four corners cut by an eighth, less half a cell for the hole; a diamond.
        assert!((pieces[0].area - 16.0).abs() < 1e-12 && (pieces[2].area - 1.0).abs() < 1e-12);
    }
}
