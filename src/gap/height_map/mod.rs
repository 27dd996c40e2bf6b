//! Measured surfaces: gaps given by heights on a regular grid.

mod as_gap;
mod heights;
mod nodes;
mod npy;
mod sdf;
mod text;
#[cfg(feature = "scene")]
mod x3p;

pub use heights::{Heights, MapFormat};
pub(super) use nodes::{Nodes, ROUNDING, mean_over};
pub(super) use text::decoded;

use super::extremes::Extremes;
use crate::error::InputError;
use crate::numeric::geometry::Rect;

/// Heights by rows with their number and steps along x and y, from a file that carries its unit.
#[derive(Debug)]
struct Read {
    values: Vec<f64>,
    shape: [usize; 2],
    spacing: [f64; 2],
}

/// With more cells than this the extremes of blocks stand for them.
const MANY: usize = 64;

/// Which surface was measured. Heights count upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surface {
    /// The underside of the upper body, seen in the same frame: where it is high the gap is wide.
    Upper,
    /// The top of the lower body: its peaks touch first.
    Lower,
}

/// What depth zero means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Zero {
    /// The bodies just touch: the least gap is zero.
    #[default]
    FirstTouch,
    /// Heights are gaps as they stand.
    AsIs,
}

/// A gap given at the nodes of a regular grid, bilinear in between: continuous, with kinks at the lines of the grid.
///
/// A hole (a node without a value) leaves the up to four cells around it without material; there is none outside the
/// map either. Means over rectangles are exact for the interpolated surface. A smooth surface is met to second order in
/// the spacing.
///
/// ```
/// use contact_patch::gap::{Gap, HeightMap, Heights, Surface, Zero};
/// // One asperity on the lower body, 1e-6 apart.
/// let heights = Heights::from_text("0 0 0\n0 2e-9 0\n0 0 0\n", [1e-6, 1e-6])?;
/// let gap = HeightMap::new(&heights, Surface::Lower, Zero::FirstTouch)?;
/// assert_eq!(gap.gap(0.0, 0.0), 0.0);
/// assert_eq!(gap.gap(0.5e-6, 0.0), 1e-9);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    nodes: Nodes,
    /// Gap at the nodes, x fastest; infinite in holes.
    gaps: Vec<f64>,
    centre: [f64; 2],
    /// The least gap of all cells with material.
    floor: f64,
    /// Least and greatest gap of blocks of cells.
    extremes: Extremes,
    /// How far each gap may be from the true one, where noise was taken out.
    uncertainty: Option<Vec<f64>>,
    /// Where depths are counted from.
    zero: Zero,
}

impl HeightMap {
    /// One measured surface against a plane.
    ///
    /// # Errors
    /// When no cell of the map has heights at all four corners.
    pub fn new(heights: &Heights, surface: Surface, zero: Zero) -> Result<Self, InputError> {
        let sign = match surface {
            Surface::Upper => 1.0,
            Surface::Lower => -1.0,
        };
        Self::build(
            heights,
            heights.values().iter().map(|z| sign * z).collect(),
            heights.uncertainty().map(<[f64]>::to_vec),
            zero,
        )
    }

    /// Two measured surfaces against each other: gap = upper - lower. Both maps have the same nodes.
    ///
    /// # Errors
    /// Names `lower` when its shape, spacing or origin differs from the upper one's; otherwise as [`HeightMap::new`].
    pub fn pair(upper: &Heights, lower: &Heights, zero: Zero) -> Result<Self, InputError> {
        let allowed = |what: &str, of: String| format!("the {what} of the upper map, {of}");
        if lower.shape() != upper.shape() {
            let given = format!("a map of {} x {} nodes", lower.shape()[0], lower.shape()[1]);
            let of = format!("{} x {} nodes", upper.shape()[0], upper.shape()[1]);
            return Err(InputError::new("lower", given, allowed("shape", of)));
        }
        for m in 0..2 {
            let step = upper.spacing()[m];
            if (lower.spacing()[m] - step).abs() > 1e-6 * step {
                let given = format!("a spacing of {}", lower.spacing()[m]);
                return Err(InputError::new("lower", given, allowed("spacing", step.to_string())));
            }
            if (lower.origin()[m] - upper.origin()[m]).abs() > 1e-3 * step {
                let given = format!("a first node at {:?}", lower.origin());
                return Err(InputError::new("lower", given, allowed("first node", format!("{:?}", upper.origin()))));
            }
        }
        let both = |one: Option<&[f64]>, other: Option<&[f64]>| match (one, other) {
            (Some(a), Some(b)) => Some(a.iter().zip(b).map(|(a, b)| a + b).collect()),
            (one, other) => one.or(other).map(<[f64]>::to_vec),
        };
        let uncertainty = both(upper.uncertainty(), lower.uncertainty());
        Self::build(upper, upper.values().iter().zip(lower.values()).map(|(u, l)| u - l).collect(), uncertainty, zero)
    }

    fn build(
        frame: &Heights,
        mut gaps: Vec<f64>,
        uncertainty: Option<Vec<f64>>,
        zero: Zero,
    ) -> Result<Self, InputError> {
        for gap in &mut gaps {
            if !gap.is_finite() {
                *gap = f64::INFINITY;
            }
        }
        let shape = frame.shape();
        let nodes = Nodes { shape, spacing: frame.spacing(), origin: frame.origin() };
        let mut map =
            Self { nodes, gaps, centre: [0.0; 2], floor: 0.0, extremes: Extremes::default(), uncertainty, zero };
        let least = (0..shape[1] - 1)
            .flat_map(|j| (0..shape[0] - 1).map(move |i| [i, j]))
            .filter_map(|[i, j]| map.corners(i, j))
            .flatten()
            .fold(f64::INFINITY, f64::min);
        if least == f64::INFINITY {
            return Err(InputError::new(
                "file",
                "a map of holes",
                "at least one cell with heights at its four corners",
            ));
        }
        if zero == Zero::FirstTouch {
            map.gaps.iter_mut().for_each(|gap| *gap -= least);
        }
        map.floor = if zero == Zero::FirstTouch { 0.0 } else { least };
        let cell = |i, j| map.corners(i, j).map(|c| c.iter().fold([c[0]; 2], |[a, b], &g| [a.min(g), b.max(g)]));
        map.extremes = Extremes::new([shape[0] - 1, shape[1] - 1], cell);
        map.centre = map.lowest_node();
        Ok(map)
    }

    /// Number of nodes along x and y.
    #[must_use]
    pub fn shape(&self) -> [usize; 2] {
        self.nodes.shape
    }

    /// Steps between nodes along x and y.
    #[must_use]
    pub fn spacing(&self) -> [f64; 2] {
        self.nodes.spacing
    }

    /// The rectangle from the first node to the last.
    #[must_use]
    pub fn extent(&self) -> Rect {
        self.nodes.extent()
    }

    /// The nodes, the gaps there (infinite in holes), and how far each may be from the true one.
    pub(super) fn samples(&self) -> (Nodes, &[f64], Option<&[f64]>) {
        (self.nodes, &self.gaps, self.uncertainty.as_deref())
    }

    /// Gaps at the corners of cell (i, j): lower left, lower right, upper left, upper right. `None` with a hole.
    fn corners(&self, i: usize, j: usize) -> Option<[f64; 4]> {
        let k = j * self.nodes.shape[0] + i;
        let corners = [k, k + 1, k + self.nodes.shape[0], k + self.nodes.shape[0] + 1].map(|k| self.gaps[k]);
        corners.iter().all(|g| g.is_finite()).then_some(corners)
    }

    /// The lowest node; the middle of several next to each other.
    fn lowest_node(&self) -> [f64; 2] {
        let [nx, ny] = self.nodes.shape;
        let touches = |i: usize, j: usize| {
            let (left, below) = (i.saturating_sub(1), j.saturating_sub(1));
            (below..=j.min(ny - 2)).any(|j| (left..=i.min(nx - 2)).any(|i| self.corners(i, j).is_some()))
        };
        let mut least: Option<(f64, [usize; 2])> = None;
        for (k, &gap) in self.gaps.iter().enumerate() {
            let (i, j) = (k % nx, k / nx);
            if least.is_none_or(|l| gap < l.0) && touches(i, j) {
                least = Some((gap, [i, j]));
            }
        }
        let Some((gap, [i, j])) = least else { return self.extent().centre() };
        let east = i + 1 < nx && self.gaps[j * nx + i + 1] == gap;
        let north = j + 1 < ny && self.gaps[(j + 1) * nx + i] == gap;
        let both = east && north && self.corners(i, j).is_some_and(|c| c.iter().all(|&g| g == gap));
        let [x, y] = self.nodes.node(i, j);
        let half = [0.5 * self.nodes.spacing[0], 0.5 * self.nodes.spacing[1]];
        match (both, east, north) {
            (true, ..) => [x + half[0], y + half[1]],
            (_, true, _) => [x + half[0], y],
            (_, _, true) => [x, y + half[1]],
            _ => [x, y],
        }
    }

    /// The cell with material that holds a point, and the place in it.
    fn locate(&self, x: f64, y: f64) -> Option<([f64; 4], [f64; 2])> {
        self.nodes.holding(1, y).find_map(|(j, t)| {
            self.nodes.holding(0, x).find_map(|(i, s)| self.corners(i, j).map(|corners| (corners, [s, t])))
        })
    }
}

fn bilinear([a, b, c, d]: [f64; 4], [s, t]: [f64; 2]) -> f64 {
    (1.0 - t) * (a * (1.0 - s) + b * s) + t * (c * (1.0 - s) + d * s)
}
