//! Whether the exact pressure is infinite, and where: what is known of the gap, in the cells that are pressed.
//!
//! | gap | pressure |
//! |---|---|
//! | homogeneous of degree k <= 1 about its centre | infinite there: p is the integral over the depth of the pressures of flat punches, of the order 1/size, and the size of the contact grows as d^(1/k) |
//! | ends (no material) where the contact reaches | infinite at the end, as under the edge of a flat punch |
//! | bends upwards at a kink under pressure | infinite there, as ln(1/distance) |
//!
//! Kinks are looked for where the pressure is largest: parts of a cell in which the gap proves itself smooth ([`Gap::taylor`]) are put
//! aside until what is left is small, and there the slopes on both sides decide. Where nothing is found nothing is claimed.

use crate::discrete::Discrete;
use crate::gap::{AnyGap, DataEdge, Degree, Gap};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;
use crate::solution::Singular;

/// Cells under pressure beside an end of the material.
pub(crate) struct Ends {
    /// Those towards whose end the pressure rises: it is infinite there.
    pub rising: Vec<usize>,
    /// The edge of data at the strongest of them that lie beside one, and the share of the force on all such cells.
    pub data: Option<(DataEdge, f64)>,
}

impl Ends {
    /// `gap` in the units of the problem.
    pub fn of(gap: &AnyGap, problem: &Discrete, pressure: &[f64]) -> Self {
        let grid = &problem.grid;
        let [nx, ny] = grid.shape.map(|n| n as i64);
        let index = |i: i64, j: i64| ((0..nx).contains(&i) && (0..ny).contains(&j)).then(|| (j * nx + i) as usize);
        let centre = |i: i64, j: i64| {
            [grid.origin[0] + (i as f64 + 0.5) * grid.spacing[0], grid.origin[1] + (j as f64 + 0.5) * grid.spacing[1]]
        };
        let void = |i: i64, j: i64| match index(i, j) {
            Some(k) => problem.overlap[k] == f64::NEG_INFINITY,
            None => gap.gap(centre(i, j)[0], centre(i, j)[1]) == f64::INFINITY,
        };
        let (mut rising, mut beside, mut strongest) = (Vec::new(), 0.0, (0.0, None));
        let step = STEP * problem.deepest();
        for k in (0..pressure.len()).filter(|&k| pressure[k] > 0.0) {
            let (i, j) = (k as i64 % nx, k as i64 / nx);
            let mut edge = None;
            let rises_from =
                |di: i64, dj: i64| index(i - di, j - dj).is_some_and(|behind| pressure[k] > pressure[behind]);
            for (di, dj) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let ends = void(i + di, j + dj);
                let jumps = || {
                    let far = JUMP * grid.spacing[usize::from(di == 0)];
                    steepest_beside(gap, problem, pressure, k, [di, dj], step).is_some_and(|slope| slope * far > step)
                };
                if rising.last() != Some(&k) && rises_from(di, dj) && (ends || jumps()) {
                    rising.push(k);
                }
                if !ends {
                    continue;
                }
                // Its middle, or the part of it that has no material.
                let mut looks =
                    [0.0, -0.49, 0.49].map(|s| centre(i + di, j + dj).map(|c| c + s * grid.spacing[0])).to_vec();
                looks.push([0, 1].map(|m| centre(i, j)[m] + 1.49 * [di, dj][m] as f64 * grid.spacing[m]));
                edge = edge.or_else(|| looks.iter().find_map(|p| gap.end_of_data(p[0], p[1])));
            }
            if edge.is_some() {
                beside += pressure[k];
                if pressure[k] > strongest.0 {
                    strongest = (pressure[k], edge);
                }
            }
        }
        let share = beside / pressure.iter().sum::<f64>();
        Self { rising, data: strongest.1.map(|edge| (edge, share)) }
    }
}

/// Share of the deepest overlap by which the gap grows over two cells where it counts as a step.
pub(crate) const STEP: f64 = 0.25;

/// Width, in cells, over which it grows by as much there at a jump: no flank is as steep.
const JUMP: f64 = 1e-6;

/// Halvings of a rise that find its steepest part.
const HALVINGS: usize = 40;

/// Share of a rise that one half of its length has where it is steeper than the other.
const STEEPER: f64 = 0.6;

/// The slope of the gap where it is steepest between a pressed cell and the second one beside it, as far as halves of the way tell, where that
/// one is free and the gap there higher by `step`: infinite or nearly so at a jump.
pub(crate) fn steepest_beside(
    gap: &AnyGap,
    problem: &Discrete,
    pressure: &[f64],
    k: usize,
    [di, dj]: [i64; 2],
    step: f64,
) -> Option<f64> {
    let grid = &problem.grid;
    let [nx, ny] = grid.shape.map(|n| n as i64);
    let (i, j) = (k as i64 % nx + 2 * di, k as i64 / nx + 2 * dj);
    if (0..nx).contains(&i) && (0..ny).contains(&j) && pressure[(j * nx + i) as usize] > 0.0 {
        return None;
    }
    let ([x, y], [hx, hy]) = (grid.centre_of(k), grid.spacing);
    // Of the way in cells.
    let at = |t: f64| gap.gap(x + t * di as f64 * hx, y + t * dj as f64 * hy);
    let (mut from, mut to) = (0.0, 2.0);
    let (mut low, mut high) = (at(from), at(to));
    if !(high - low > step) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        let value = at(middle);
        let most = STEEPER * (high - low);
        // Halves of an infinite rise have all of it.
        if value - low >= most {
            (to, high) = (middle, value);
        } else if high - value >= most {
            (from, low) = (middle, value);
        } else {
            break;
        }
    }
    Some((high - low) / ((to - from) * if di == 0 { hy } else { hx }))
}

/// Why the pressure is infinite at the strongest cell of a piece, for another reason than an end of the material, as far as that
/// is known. `gap` in the units of the problem, lengths and heights near 1.
pub(crate) fn singular(gap: &AnyGap, problem: &Discrete, strongest: usize) -> Option<Singular> {
    match gap.known().law.map(|law| law.degree) {
        Some(Degree::Flat) => return Some(Singular::Edge),
        Some(Degree::Power(k)) if k <= 1.0 => return Some(Singular::Tip),
        _ => {}
    }
    // Creases of a map between its nodes are those of the interpolation.
    if gap.nodes().is_some() {
        return None;
    }
    let nx = problem.grid.shape[0];
    // An edge of the cells themselves may be that of the gap.
    kink_in(gap, &problem.grid.cell(strongest % nx, strongest / nx).scaled(WIDER))
}

/// Sides of the rectangle that is looked at over those of the cell: a tip may lie in the next one.
const WIDER: f64 = 2.0;

/// Rectangles that are looked at for one kink.
const LOOKS: usize = 600;

/// Side of what is left of a cell when the slopes beside it are compared, over that of the cell.
const SMALLEST: f64 = 1e-6;

/// Tiles a side of a cell in which a gap may tell that it is smooth.
const TILES: usize = 5;

/// Places that are compared.
const PLACES: usize = 8;

/// A kink of the gap in a rectangle at which it bends upwards: a tip where it does so in every direction, else a ridge.
fn kink_in(gap: &AnyGap, cell: &Rect) -> Option<Singular> {
    let side = cell.size()[0].min(cell.size()[1]);
    let (mut stack, mut places, mut smooth) = (vec![*cell], Vec::new(), 0);
    for _ in 0..LOOKS {
        let Some(rect) = stack.pop() else { break };
        if gap.taylor(&rect).is_some() {
            smooth += 1;
            continue;
        }
        let size = rect.size();
        if size[0].max(size[1]) <= SMALLEST * side {
            places.push(rect.centre());
            if places.len() == PLACES {
                break;
            }
            continue;
        }
        let [cx, cy] = rect.centre();
        let half = size.map(|s| 0.25 * s);
        let part = |[sx, sy]: [f64; 2]| Rect::around([cx + sx * half[0], cy + sy * half[1]], half);
        let mut parts = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(part);
        // The lowest is looked at first: tips are low, and beside them a kink is not seen from both distances.
        let low = |rect: &Rect| {
            gap.bounds(rect, [0.0; 2]).map_or_else(|| gap.gap(rect.centre()[0], rect.centre()[1]), |[low, _]| low)
        };
        parts.sort_by(|a, b| low(b).total_cmp(&low(a)));
        stack.extend(parts);
    }
    // A gap that nowhere tells that it is smooth tells nothing of kinks either. (Places may all have been found before anything else was
    // looked at.)
    let tiles = Grid::over(cell, [TILES; 2]);
    let tile = |k: usize| tiles.cell(k % TILES, k / TILES).scaled(0.9);
    let tells = smooth > 0 || (0..TILES * TILES).any(|k| gap.taylor(&tile(k)).is_some());
    places.into_iter().filter(|_| tells).find_map(|place| bend_at(gap, place, side))
}

/// Directions in which a bend is looked for.
const DIRECTIONS: u32 = 16;

/// How the gap bends at a point, within the small distance by which that may be off.
fn bend_at(gap: &AnyGap, [x, y]: [f64; 2], side: f64) -> Option<Singular> {
    let here = gap.gap(x, y);
    // What the slope changes by across the point, seen from two distances.
    let bend = |angle: f64, far: f64| {
        let (step, (sin, cos)) = (far * side, angle.sin_cos());
        let at = |sign: f64| gap.gap(x + sign * step * cos, y + sign * step * sin);
        (at(1.0) + at(-1.0) - 2.0 * here) / step
    };
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for k in 0..DIRECTIONS {
        let angle = std::f64::consts::PI * (f64::from(k) + 0.31) / f64::from(DIRECTIONS);
        let [near, far] = [NEAR, 10.0 * NEAR].map(|distance| bend(angle, distance));
        // A smooth gap bends ten times as much over ten times the distance, a kink as much.
        let kink = near.is_finite() && near > LEAST_BEND && far < STRAIGHT * near;
        least = least.min(if kink { near } else { 0.0 });
        most = most.max(if kink { near } else { 0.0 });
    }
    // Along a ridge, within half a step of the directions, nothing bends.
    let tip = least > ALONG * most;
    (most > 0.0).then_some(if tip { Singular::Tip } else { Singular::Edge })
}

/// Distance from which slopes are compared, over the side of the cell: far from what rounding and the search leave open.
const NEAR: f64 = 1e-3;

/// Least change of a slope that counts, where depth and size of the contact are near 1.
const LEAST_BEND: f64 = 1e-4;

/// By how much a kink may seem to grow with the distance: what curves beside it.
const STRAIGHT: f64 = 1.1;

/// Least bend of a tip in any direction over the largest: sin(11 degrees) is as much as a ridge has in some direction.
const ALONG: f64 = 0.2;

#[cfg(test)]
#[cfg(feature = "formula")]
mod tests {
    use super::*;
    use crate::gap::Formula;

    #[test]
    fn a_tip_where_five_ridges_meet_is_found_beside_them() {
        let faces = [[-0.3254, 0.163], [-0.2556, -0.2591], [0.1674, -0.3231], [0.3591, 0.05938], [0.05448, 0.3598]];
        let at = [0.034981, 0.060677];
        let terms = faces.map(|[a, b]| format!("{a}*(x-{})+({b})*(y-{})", at[0], at[1]));
        let gap: AnyGap = (&Formula::new(&format!("max({})", terms.join(", "))).unwrap()).into();
        let side = 0.003;
        for [s, t] in [[0.05, -0.19], [0.4, 0.4], [-0.3, 0.1], [0.0, 0.0]] {
            let cell = Rect::around([at[0] + s * side, at[1] + t * side], [0.5 * side; 2]);
            assert_eq!(kink_in(&gap, &cell.scaled(WIDER)), Some(Singular::Tip), "{s} {t}");
        }
        // On one of the ridges, far from it.
        let beside = Rect::around([at[0] + 20.0 * side, at[1] + 20.3 * side], [2.0 * side; 2]);
        assert_eq!(kink_in(&gap, &beside), Some(Singular::Edge));
    }
}
