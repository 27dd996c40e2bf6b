//! A flat polygon with flanks: a worn indenter, a truncated pyramid. The contact passes the edges of the flat by a strip, on which it ends
//! where the pressure vanishes.
//!
//! Cells follow the polygon: inside by its own shape from the centre outwards, on the flanks by their level lines; both are graded to the
//! edge, where the slope of the gap jumps and the pressure is infinite like a logarithm, and along it to the corners. The strip is wider
//! than the contact; the active set finds its end. On any set of cells the force of S p = f is stationary where the set is the contact
//! (Barber 1974), so that the end, known to a cell, enters squared. What cells across and along the edges leave is told by fewer of them.

use super::Limits;
use super::estimated::{Estimated, Rest, Solved, Touching};
use super::mesh::{Mesh, Point};
use super::polygon::symmetries;
use super::rectilinear::{graded, graded_both};
use super::symmetry::Isometry;

/// A flat that is pressed in by 1, about its centroid.
pub(crate) struct Flat<'a> {
    /// Corners of a convex polygon, counter-clockwise.
    pub corners: &'a [Point],
    /// What each corner moves by where the gap rises by 1.
    pub drift: &'a [Point],
    /// The plane of the gap, a x + b y + c, that begins at each side, from corner to next corner.
    pub sides: &'a [[f64; 3]],
    /// All planes of the gap but the level one.
    pub planes: &'a [[f64; 3]],
    /// What rounding may change the planes by.
    pub rounding: f64,
    /// The largest share of its size that the polygon grows by for that.
    pub growth: f64,
    /// Whether the gap has the symmetries of the polygon.
    pub symmetric: bool,
    /// The overlap.
    pub overlap: &'a dyn Fn(Point) -> f64,
}

/// Cells: from the centre to the edge before it is graded further, half along an edge, across the strip.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Counts {
    inside: usize,
    along: usize,
    strip: usize,
}

/// The first mesh at a tolerance that it is mostly enough for.
const FIRST: Counts = Counts { inside: 7, along: 6, strip: 6 };
const AT_FIRST: f64 = 4e-4;

/// Of its cells, in one direction after the other, those of the meshes that tell its error.
const FEWER: f64 = 2.0 / 3.0;

/// Orders that the next round relies on, and what it has more of in each direction: chance is in the last.
const ORDERS: [f64; 3] = [2.8, 2.8, 2.0];
const MARGIN: f64 = 1.1;

/// Cells of one of them, which make too many of them together.
const MOST: usize = 10_000;

/// Rounds of more cells.
const ROUNDS: usize = 4;

/// Rows of the strip are no thinner than this, over the size of the flat, where there are several: with t for that rounding is 1e-16/t^2 of
/// a pair integral, and the matrix of many of them is not positive beyond it.
const THINNEST: f64 = 2e-6;

/// Grading to the edge from inside, along it to its ends, and to it from the strip.
const EXPONENTS: [f64; 3] = [4.0, 3.0, 1.5];

/// What the innermost cells at the edge shrink by from one to the next.
const RATIO: f64 = 4.0;

/// Width of the strip, as a height of the flank over g ln(1/g), g the growth: a little more than the contact takes at the corners of 3 to 6
/// sides at growths of 1e-4 to 0.3. Beside a straight edge it is (8/pi^2) 2 g ln(1/g) less terms of the order of g.
const ROOM: f64 = 2.2;

/// Times that the strip is doubled.
const MOST_DOUBLINGS: usize = 6;

/// What is left of a force over what it changes by with fewer cells across the strip: 0.6 to 0.9 measured on 3 to 12 sides, growths of
/// 1e-3 to 0.3.
const SCATTER: f64 = 1.3;

/// What the end of the contact leaves of the force, over the square of what it may be off by.
const OF_END: f64 = 0.5;

/// Where a smaller tolerance asks for more cells than that one: errors fall with this power of their number.
const ORDER: f64 = 2.5;

/// A solved mesh.
struct State {
    solved: Solved,
    layout: Layout,
}

/// Lines of a mesh.
struct Layout {
    /// Shares of the way from the centre to the edge.
    inside: Vec<f64>,
    /// Heights of the level lines on the flanks, without the edge.
    heights: Vec<f64>,
    /// Shares along each edge.
    along: Vec<f64>,
}

/// The contact of a flat with flanks. `None` where it cannot be solved on as many cells, and once the time is used up.
pub(crate) fn flanked(flat: &Flat, limits: &Limits) -> Option<Estimated> {
    let mut counts = first(limits);
    let mut width = flat.strip();
    let mut best: Option<Estimated> = None;
    for _ in 0..ROUNDS {
        let Some(fine) = wide_enough(flat, counts, &mut width, limits) else { return best };
        // Of the rows that it has.
        let strip = fine.layout.heights.len();
        let fewer = Counts { strip: (FEWER * strip as f64) as usize, ..scaled(counts, [FEWER; 3]) };
        // One after the other: what they change the force by may cancel.
        let others = [
            Counts { inside: fewer.inside, ..counts },
            Counts { along: fewer.along, ..counts },
            Counts { strip: fewer.strip, ..counts },
        ];
        let others: Option<Vec<State>> = others.into_iter().map(|counts| solved(flat, counts, width, limits)).collect();
        let (Some(others), State { solved: own, .. }) = (others, &fine) else { return best };
        let changes = others.iter().map(|other| (other.solved.area / own.area - 1.0).abs());
        // The cells of the flat and those along its edges fall short as they are graded; of the strip it is chance where the contact ends
        // in a cell.
        let ratios = [counts.inside as f64 / fewer.inside as f64, counts.along as f64 / fewer.along as f64];
        let rest = |of: fn(&Solved) -> f64| [0, 1].map(|m| Rest::new(of(own), of(&others[m].solved), ratios[m]));
        let (force, energy, stiffness) = (rest(|s| s.force), rest(|s| s.energy), rest(|s| s.stiffness));
        let corrected = |rest: [Rest; 2]| 1.0 + rest[0].correction + rest[1].correction;
        // The end of the contact is known to half a cell of the strip.
        let cell = 0.5 * flat.growth * fine.thickness_at_end();
        let of_rows = |of: fn(&Solved) -> f64| {
            if strip > 1 { SCATTER * (of(&others[2].solved) / of(own) - 1.0).abs() } else { width * flat.growth }
        };
        let of_strip = of_rows(|s| s.force) + OF_END * cell * cell;
        let left = [force[0].error.max(energy[0].error), force[1].error.max(energy[1].error), of_strip];
        let found = Estimated {
            force: own.force * corrected(force),
            error: left.iter().sum(),
            energy: own.energy * corrected(energy),
            stiffness: own.stiffness * corrected(stiffness),
            stiffness_error: stiffness[0].error + stiffness[1].error + of_rows(|s| s.stiffness) + cell,
            stiffness_matrix: None,
            area: own.area,
            area_error: changes.sum::<f64>() + 2.0 * cell,
            max_error: None,
            ends: vec![fine.end()],
            cells: own.cells_times(corrected(force), Touching::Some),
            unknowns: own.unknowns,
        };
        let missed = found.error / limits.tolerance;
        if best.as_ref().is_none_or(|best| found.error < best.error) {
            best = Some(found);
        }
        if missed <= 1.0 {
            break;
        }
        // Larger parts of the error may stay larger: what they take goes into as many cells as all of them.
        let roots: f64 = left.iter().map(|left| left.sqrt()).sum();
        let more = [0, 1, 2].map(|m| MARGIN * (left[m].sqrt() * roots / limits.tolerance).powf(1.0 / ORDERS[m]));
        counts = scaled(counts, more.map(|more| more.clamp(1.0, 2.0)));
    }
    best
}

fn scaled(c: Counts, by: [f64; 3]) -> Counts {
    let times = |n: usize, by: f64| ((n as f64 * by).ceil() as usize).clamp(3, MOST);
    Counts { inside: times(c.inside, by[0]), along: times(c.along, by[1]), strip: times(c.strip, by[2]) }
}

/// The cells to begin with.
fn first(limits: &Limits) -> Counts {
    scaled(FIRST, [(AT_FIRST / limits.tolerance).powf(1.0 / ORDER).max(0.7); 3])
}

impl Flat<'_> {
    /// Whether the cells that the tolerance asks for are not too many.
    pub fn fits(&self, limits: &Limits) -> bool {
        let layout = Layout::new(first(limits), self.strip(), self.growth);
        self.holds(&layout, &self.group(), limits)
    }

    /// The width of the strip to begin with, as a height of the flanks.
    fn strip(&self) -> f64 {
        (ROOM * self.growth * (1.0 / self.growth).ln().max(1.5)).min(1.0)
    }

    pub(super) fn group(&self) -> Vec<Isometry> {
        if self.symmetric { symmetries(self.corners) } else { Vec::new() }
    }

    fn holds(&self, layout: &Layout, group: &[Isometry], limits: &Limits) -> bool {
        let cells = self.corners.len() * (layout.along.len() - 1) * layout.rows();
        cells <= limits.cells && cells / group.len().max(1) <= limits.unknowns
    }
}

/// The mesh with a strip wider than the contact.
fn wide_enough(flat: &Flat, counts: Counts, width: &mut f64, limits: &Limits) -> Option<State> {
    for _ in 0..MOST_DOUBLINGS {
        let state = solved(flat, counts, *width, limits)?;
        if *width == 1.0 || !state.reaches_its_border() {
            return Some(state);
        }
        *width = (2.0 * *width).min(1.0);
    }
    None
}

fn solved(flat: &Flat, counts: Counts, width: f64, limits: &Limits) -> Option<State> {
    let layout = Layout::new(counts, width, flat.growth);
    let group = flat.group();
    if !flat.holds(&layout, &group, limits) {
        return None;
    }
    let solved = Solved::new(layout.mesh(flat), &group, flat.overlap, Touching::Some, limits)?;
    (solved.force > 0.0 && solved.stiffness > 0.0).then_some(State { solved, layout })
}

impl Layout {
    fn new(counts: Counts, width: f64, growth: f64) -> Self {
        let rows = (width * growth / THINNEST).powf(1.0 / EXPONENTS[2]);
        let mut heights = graded(width, 0.0, counts.strip.min(rows as usize).max(1), EXPONENTS[2]);
        heights.reverse();
        heights.remove(0);
        // At the edge cells are as thin on both of its sides.
        let mut inside = graded(0.0, 1.0, counts.inside, EXPONENTS[0]);
        let thinnest = heights[0] * growth;
        let mut last = 1.0 - inside[counts.inside - 1];
        while last > RATIO * thinnest {
            last /= RATIO;
            inside.insert(inside.len() - 1, 1.0 - last);
        }
        Self { inside, heights, along: graded_both(0.0, 1.0, counts.along, EXPONENTS[1]) }
    }

    /// Cells from the centre to the end of the strip.
    fn rows(&self) -> usize {
        self.inside.len() - 1 + self.heights.len()
    }

    /// Lines around the centre, which is no line itself: the corners of each.
    fn rings<'a>(&'a self, flat: &'a Flat) -> impl Iterator<Item = Vec<Point>> + 'a {
        let inside = self.inside[1..].iter().map(|share| flat.corners.iter().map(|c| c.map(|x| share * x)).collect());
        let outside = self.heights.iter().map(|height| {
            flat.corners.iter().zip(flat.drift).map(|(c, v)| [0, 1].map(|m| c[m] + height * v[m])).collect()
        });
        inside.chain(outside)
    }

    /// Cells by sectors, in each from the centre outwards.
    fn mesh(&self, flat: &Flat) -> Mesh {
        let (corners, along) = (flat.corners.len(), self.along.len() - 1);
        let around = corners * along;
        let mut nodes = vec![[0.0; 2]];
        for ring in self.rings(flat) {
            for k in 0..corners {
                let (a, b) = (ring[k], ring[(k + 1) % corners]);
                // From the nearer end: mirrored edges have mirrored nodes.
                nodes.extend(self.along[..along].iter().map(|&t| {
                    [0, 1].map(|m| if t <= 0.5 { a[m] + t * (b[m] - a[m]) } else { b[m] + (1.0 - t) * (a[m] - b[m]) })
                }));
            }
        }
        let id = |row: usize, j: usize| if row == 0 { 0 } else { 1 + (row - 1) * around + j % around };
        let cells = (0..around)
            .flat_map(|j| {
                (0..self.rows()).map(move |row| [id(row, j), id(row + 1, j), id(row + 1, j + 1), id(row, j + 1)])
            })
            .collect();
        Mesh::new(nodes, cells, Vec::new())
    }
}

impl State {
    fn reaches_its_border(&self) -> bool {
        let rows = self.layout.rows();
        self.solved.pressure.chunks(rows).any(|column| column[rows - 1] > 0.0)
    }

    /// The largest thickness of a last cell in contact of all sectors, as a height of the flank; of the next one where contact ends on the
    /// flat.
    fn thickness_at_end(&self) -> f64 {
        let (rows, inside) = (self.layout.rows(), self.layout.inside.len() - 1);
        let heights = &self.layout.heights;
        let thickness = |column: &[f64]| {
            let last = column.iter().rposition(|p| *p > 0.0).map_or(0, |row| (row + 1).saturating_sub(inside));
            let next = last.min(heights.len() - 1);
            heights[next] - next.checked_sub(1).map_or(0.0, |before| heights[before])
        };
        self.solved.pressure.chunks(rows).map(thickness).fold(0.0, f64::max)
    }

    /// The middle of the outer side of the last cell in contact, of every sector.
    fn end(&self) -> Vec<Point> {
        let rows = self.layout.rows();
        let columns = self.solved.pressure.chunks(rows).enumerate();
        columns
            .filter_map(|(j, column)| {
                let last = column.iter().rposition(|p| *p > 0.0)?;
                let c = self.solved.mesh.corners(j * rows + last);
                Some([0, 1].map(|m| 0.5 * (c[1][m] + c[2][m])))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pyramid of n faces, inradius 1, at a depth of `growth` times the height of its missing tip.
    fn pyramid(n: usize, growth: f64, tolerance: f64) -> Estimated {
        let half = std::f64::consts::PI / n as f64;
        let corner = |k: usize| {
            let (sin, cos) = (half * (2 * k + 1) as f64).sin_cos();
            [cos / half.cos(), sin / half.cos()]
        };
        let corners: Vec<Point> = (0..n).map(corner).collect();
        let drift: Vec<Point> = corners.iter().map(|c| c.map(|x| growth * x)).collect();
        let overlap = |p: Point| {
            let along = |k: usize| {
                let (sin, cos) = (2.0 * half * k as f64).sin_cos();
                p[0] * cos + p[1] * sin
            };
            let farthest = (0..n).map(along).fold(f64::MIN, f64::max);
            1.0 - ((farthest - 1.0) / growth).max(0.0)
        };
        let flat = Flat {
            corners: &corners,
            drift: &drift,
            sides: &[],
            planes: &[],
            rounding: 0.0,
            growth,
            symmetric: true,
            overlap: &overlap,
        };
        flanked(&flat, &Limits { tolerance, ..Limits::default() }).unwrap()
    }

    /// Of very many faces: the truncated cone in closed form.
    #[test]
    fn many_faces_are_a_truncated_cone() {
        use crate::closed_form::FlatEndedCone;
        use crate::problem::EffectiveModulus;
        let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
        for growth in [1e-3, 1e-2, 0.1] {
            let found = pyramid(48, growth, 1e-3);
            // The circle of the same area.
            let radius = (48.0 * (std::f64::consts::PI / 48.0).tan() / std::f64::consts::PI).sqrt();
            let cone = FlatEndedCone::new(modulus, radius, 1.0 / growth).unwrap().at_depth(1.0).unwrap();
            assert!(found.error <= 1e-3, "{growth}: {}", found.error);
            let off = found.force / cone.force - 1.0;
            assert!(off.abs() < found.error + 3e-4, "{growth}: off {off:e}, stated {:e}", found.error);
        }
    }

    /// P between the flat's and that of the flat enlarged; dP/dd the stiffness; finer cells within the stated errors.
    #[test]
    fn forces_of_truncated_pyramids() {
        for n in [3, 4] {
            for growth in [3e-3, 0.03, 0.3] {
                let (rough, fine) = (pyramid(n, growth, 1e-3), pyramid(n, growth, 2e-4));
                assert!(rough.error <= 1e-3 && fine.error <= 3e-4, "{n} {growth}: {} {}", rough.error, fine.error);
                let off = (rough.force / fine.force - 1.0).abs();
                assert!(off <= rough.error + fine.error, "{n} {growth}: {off:e} {} {}", rough.error, fine.error);
            }
        }
    }
}
