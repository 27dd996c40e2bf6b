//! From cells to a patch: the boundary between cells, its area, centroid and regions.

pub(crate) mod peak;
mod pieces;

use crate::discrete::{Discrete, DiscreteSolution};
use crate::grid::{Grid, Kernel};
use crate::matrix_free;
use crate::numeric::geometry::{area, centroid, farthest};
use crate::numeric::scalar::root;
use crate::solution::Patch;

/// The patch of a solved problem, with boundaries placed between cell centres.
///
/// Near the edge of a smooth contact p = k sqrt(s) inside and gap = 4 k s^(3/2)/3 outside (E* = 1, s the distance to the
/// edge), so p^2 and gap^(2/3) are linear in s: the pair of cells on either side places the edge between them, by the
/// distance of their centres in the direction in which p^2 falls.
/// At a sharp edge (no material beyond) the edge is the border of the cell.
///
/// ```
/// use contact_patch::{Discrete, Grid, Kernel, gap::Paraboloid, geometry::Rect, matrix_free, patch};
/// let grid = Grid::over(&Rect::around([0.0; 2], [1.1; 2]), [64, 64]);
/// let problem = Discrete::sample(&Paraboloid::new([1.0, 1.0])?, 1.0, grid, Kernel::Galerkin);
/// let solution = matrix_free::solve_nested(&problem, &matrix_free::Settings::default())?;
/// let patch = patch::of(&problem, &solution, [0.0; 2]);
/// assert!((patch.area / std::f64::consts::PI - 1.0).abs() < 0.01 && patch.regions == 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn of(problem: &Discrete, solution: &DiscreteSolution, reference: [f64; 2]) -> Patch {
    with_peaks(problem, solution, reference).0
}

/// The patch, and the cell of the largest pressure of each of its pieces.
pub(crate) fn with_peaks(problem: &Discrete, solution: &DiscreteSolution, reference: [f64; 2]) -> (Patch, Vec<usize>) {
    let (starts, loops): (Vec<usize>, Vec<Vec<[f64; 2]>>) = boundary(problem, solution).into_iter().unzip();
    let areas: Vec<f64> = loops.iter().map(|l| area(l)).collect();
    let total: f64 = areas.iter().sum();
    let mut moment = [0.0; 2];
    for (polygon, share) in loops.iter().zip(&areas) {
        let c = centroid(polygon);
        moment[0] += share * c[0];
        moment[1] += share * c[1];
    }
    let (pieces, peaks) = pieces::of(&problem.grid, &solution.pressure, &starts, &loops).into_iter().unzip();
    let patch = Patch {
        area: total,
        centroid: (total > 0.0).then(|| moment.map(|m| m / total)),
        regions: areas.iter().filter(|&&a| a > 0.0).count(),
        max_radius: farthest(loops.iter().flatten(), reference),
        pieces,
        boundary: Some(loops),
        semi_axes: None,
        angle: None,
    };
    (patch, peaks)
}

/// Closed polylines around the cells under pressure, contact on the left, each with a cell that it goes around.
fn boundary(problem: &Discrete, solution: &DiscreteSolution) -> Vec<(usize, Vec<[f64; 2]>)> {
    let grid = &problem.grid;
    let whole = displacement_around(problem, solution);
    let displacement = whole.as_deref().unwrap_or(&solution.displacement);
    // Share of the way from the centre of the loaded cell to that of its free neighbour.
    let share = |inside: usize, outside: Option<usize>| {
        let Some(outside) = outside else { return 0.5 };
        let f = problem.overlap[outside];
        if f == f64::NEG_INFINITY {
            return 0.5;
        }
        let along = usize::from(inside.abs_diff(outside) != 1);
        let across_edge = outward(grid, &solution.pressure, inside).map_or(1.0, |normal| normal[along].abs());
        edge_between(
            solution.pressure[inside],
            displacement[outside] - f,
            grid.spacing[along] * across_edge,
            problem.kernel,
        )
    };
    march(grid, &solution.pressure.iter().map(|&p| p > 0.0).collect::<Vec<_>>(), share)
}

/// The displacement of every cell, where a solver has left it out (as zero) beside a cell under pressure: it stops at the box of the
/// cells that overlap.
fn displacement_around(problem: &Discrete, solution: &DiscreteSolution) -> Option<Vec<f64>> {
    let [nx, ny] = problem.grid.shape;
    let left_out = |k: usize| solution.displacement[k] == 0.0 && problem.overlap[k] > f64::NEG_INFINITY;
    let beside = |k: usize| {
        let (i, j) = (k % nx, k / nx);
        let neighbours = [
            (i > 0).then(|| k - 1),
            (i + 1 < nx).then(|| k + 1),
            (j > 0).then(|| k - nx),
            (j + 1 < ny).then(|| k + nx),
        ];
        neighbours.into_iter().flatten().any(left_out)
    };
    let pressed = (0..problem.grid.len()).filter(|&k| solution.pressure[k] > 0.0);
    pressed.into_iter().any(beside).then(|| matrix_free::displacement(problem, &solution.pressure))
}

/// The direction in which p^2 falls at a loaded cell, by differences over three cells each way (Sobel).
fn outward(grid: &Grid, pressure: &[f64], k: usize) -> Option<[f64; 2]> {
    let [nx, ny] = grid.shape.map(|n| n as i64);
    let [i, j] = [k as i64 % nx, k as i64 / nx];
    let squared = |[a, b]: [i64; 2]| {
        let on_grid = (0..nx).contains(&(i + a)) && (0..ny).contains(&(j + b));
        if on_grid { pressure[((j + b) * nx + i + a) as usize].powi(2) } else { 0.0 }
    };
    let fall = [0, 1].map(|m| {
        let pair = |across: i64| {
            let [ahead, behind] = [1, -1].map(|along| squared(if m == 0 { [along, across] } else { [across, along] }));
            behind - ahead
        };
        (pair(-1) + 2.0 * pair(0) + pair(1)) / grid.spacing[m]
    });
    let size = fall[0].hypot(fall[1]);
    (size > 0.0).then(|| fall.map(|c| c / size))
}

/// (3 gap/(4 p d))^2 of p = k s^(1/2) and its gap at the centres over that of two cells: the least squares of 5900 pairs of them beside the
/// edges of ellipses of 1 to 300, which they place to 0.02 and 0.04 of a cell.
fn of_cells(kernel: Kernel) -> f64 {
    match kernel {
        Kernel::Galerkin => 0.47,
        Kernel::Collocation => 0.85,
    }
}

/// t = s/d with p^2 = k^2 s and (3 gap/4)^(2/3) = k^(2/3) (d - s), d the distance of the centres across the edge: k eliminated,
/// (1 - t)^3 = c t.
fn edge_between(p: f64, gap: f64, d: f64, kernel: Kernel) -> f64 {
    if gap <= 0.0 {
        return 0.5;
    }
    let c = of_cells(kernel) * (0.75 * gap / (p * d)).powi(2);
    // The unknown k comes from a cell mean next to a square root: keep the edge between the two centres.
    let [nearest, farthest] = [0.05, 0.95];
    let excess = |t: f64| (1.0 - t).powi(3) - c * t;
    let beyond = if excess(nearest) > 0.0 { farthest } else { nearest };
    root(excess, nearest, farthest).map_or(beyond, |found| found.at)
}

/// Marching squares on the lattice of cell centres, with one ring of free cells around it. Contact cells that meet at a
/// corner belong together: the tip of a patch along a ridge is a diagonal of cells.
fn march(grid: &Grid, inside: &[bool], share: impl Fn(usize, Option<usize>) -> f64) -> Vec<(usize, Vec<[f64; 2]>)> {
    let [nx, ny] = grid.shape.map(|n| n as i64);
    let index = |i: i64, j: i64| ((0..nx).contains(&i) && (0..ny).contains(&j)).then(|| (j * nx + i) as usize);
    let is_inside = |i: i64, j: i64| index(i, j).is_some_and(|k| inside[k]);
    // An edge of the contour is met once from each of the two squares beside it: keyed by its loaded cell and direction.
    type Crossing = (i64, i64, u8);
    const STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let point = |(i, j, direction): Crossing| {
        let (di, dj) = STEPS[direction as usize];
        let t = share(index(i, j).expect("a loaded cell"), index(i + di, j + dj));
        let x = grid.origin[0] + (i as f64 + 0.5 + t * di as f64) * grid.spacing[0];
        let y = grid.origin[1] + (j as f64 + 0.5 + t * dj as f64) * grid.spacing[1];
        [x, y]
    };
    // With contact on the left, the contour goes from the crossing towards `direction` around the loaded cell, counter-
    // clockwise: across to the diagonal cell if that touches, else to the cell beside, else around the same cell.
    let next = |(i, j, direction): Crossing| -> Crossing {
        let (ahead, turn) = (STEPS[direction as usize], ((direction + 1) % 4) as usize);
        let (si, sj) = STEPS[turn];
        let side = (i + si, j + sj);
        let diagonal = (side.0 + ahead.0, side.1 + ahead.1);
        if is_inside(diagonal.0, diagonal.1) {
            (diagonal.0, diagonal.1, (direction + 3) % 4)
        } else if is_inside(side.0, side.1) {
            (side.0, side.1, direction)
        } else {
            (i, j, turn as u8)
        }
    };
    // One bit a direction.
    let mut seen = vec![0_u8; inside.len()];
    let mut first_time = |(i, j, direction): Crossing| {
        let (bits, bit) = (&mut seen[(j * nx + i) as usize], 1 << direction);
        let first = *bits & bit == 0;
        *bits |= bit;
        first
    };
    let mut loops = Vec::new();
    for j in 0..ny {
        for i in 0..nx {
            if !is_inside(i, j) {
                continue;
            }
            for direction in 0..4u8 {
                let (di, dj) = STEPS[direction as usize];
                let start = (i, j, direction);
                if is_inside(i + di, j + dj) {
                    continue;
                }
                let mut polygon = Vec::new();
                let mut at = start;
                while first_time(at) {
                    polygon.push(point(at));
                    at = next(at);
                }
                if let Some(cell) = index(i, j).filter(|_| !polygon.is_empty()) {
                    loops.push((cell, polygon));
                }
            }
        }
    }
    loops
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loops_of(rows: &[&str]) -> Vec<Vec<[f64; 2]>> {
        let shape = [rows[0].len(), rows.len()];
        let inside: Vec<bool> = rows.concat().chars().map(|c| c == '#').collect();
        let grid = Grid { origin: [0.0; 2], spacing: [1.0; 2], shape };
        march(&grid, &inside, |_, _| 0.5).into_iter().map(|(_, polygon)| polygon).collect()
    }

    #[test]
    fn one_cell_is_a_diamond() {
        let loops = loops_of(&["#"]);
        assert_eq!(loops.len(), 1);
        assert!((area(&loops[0]) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn a_ring_has_a_hole_that_turns_the_other_way() {
        let loops = loops_of(&["####", "#..#", "#..#", "####"]);
        let mut areas: Vec<f64> = loops.iter().map(|l| area(l)).collect();
        areas.sort_by(f64::total_cmp);
        assert_eq!(areas.len(), 2);
        // 4 x 4 and 2 x 2, each less its four cut corners.
        assert!((areas[1] - 15.5).abs() < 1e-14 && (areas[0] + 3.5).abs() < 1e-14, "{areas:?}");
    }

    #[test]
    fn cells_that_meet_at_a_corner_are_one_region() {
        assert_eq!(loops_of(&["#.", ".#"]).len(), 1);
        assert_eq!(loops_of(&["#..", "...", "..#"]).len(), 2);
    }

    #[test]
    fn the_edge_of_an_ellipse_lies_between_cells() {
        use crate::closed_form::Hertz;
        use crate::{EffectiveModulus, gap::Paraboloid, geometry::Rect};
        let e_star = EffectiveModulus::from_e_star(1.0).unwrap();
        for (flat, [nx, ny]) in [(1.0, [52, 52]), (30.0, [40, 60]), (1000.0, [36, 90])] {
            let hertz = Hertz::new(e_star, [1.0, flat]).unwrap().at_depth(1.0).unwrap();
            let [long, short] = hertz.patch.semi_axes;
            for kernel in [Kernel::Galerkin, Kernel::Collocation] {
                let grid = Grid::over(&Rect::around([0.0; 2], [1.08 * short, 1.08 * long]), [nx, ny]);
                let gap = Paraboloid::new([1.0, flat]).unwrap();
                let problem = Discrete::sample(&gap, 1.0, grid, kernel);
                let solution = matrix_free::solve_nested(&problem, &matrix_free::Settings::default()).unwrap();
                let found = of(&problem, &solution, [0.0; 2]);
                // How far it lies from where it should, in cells of the axis that has fewer of them.
                let cells = [nx, ny].map(|n| n as f64 / 2.16);
                let off = 0.5 * (found.area / hertz.patch.area() - 1.0) * cells[0].min(cells[1]);
                assert!(off.abs() < 0.02, "{flat} {kernel:?} {off}");
            }
        }
    }
}
