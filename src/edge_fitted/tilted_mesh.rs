//! One mesh of a tilted punch, and its pressure (`tilted` has the formulas).

use nalgebra::Vector3;

use super::Means;
use super::active_set::{Planes, balance, solve, solve_from};
use super::compliance::Compliance;
use super::line_potential::Lines;
use super::mesh::{Mesh, Point};
use super::mirrored::Mirrored;
use super::outline::{Fitted, Outline};

/// The n that no mesh goes beyond.
pub(super) const FINEST: usize = 64;

/// Pressure of a cell at an edge over that of the level punch, over the same of a neighbour, below which it may be negative in a part of the
/// cell: towards a corner that goes as A + B s^e, 0 < e < 1, and cells are graded, so that A may be negative.
const FALLING: f64 = 2.0 / 3.0;

/// What is given of a tilting punch, in the outline's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Given {
    /// f = g . (1, x, y).
    Plane([f64; 3]),
    /// The integrals of p, p x and p y.
    Load([f64; 3]),
}

/// The axes, in the outline's, in which moments or a depth and tilts are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub origin: Point,
    /// Unit vectors along x and y.
    pub along: [Point; 2],
}

impl Frame {
    /// The outline's own.
    #[cfg(test)]
    pub const OWN: Self = Self { origin: [0.0; 2], along: [[1.0, 0.0], [0.0, 1.0]] };

    /// x or y as a plane.
    pub(super) fn coordinate(&self, m: usize) -> Vector3<f64> {
        let ([x, y], [a, b]) = (self.origin, self.along[m]);
        Vector3::new(-(a * x + b * y), a, b)
    }

    /// The loads that a plane works on by its value at the origin, and its slopes.
    pub(super) fn loads(&self) -> [Vector3<f64>; 3] {
        let [x, y] = self.origin;
        let [u, v] = self.along.map(|[a, b]| Vector3::new(0.0, a, b));
        [Vector3::new(1.0, x, y), u, v]
    }
}

/// Cells in a row across which that is looked for: two parts of a polygon meet in thin cells on both sides.
const ENCLOSED_BY: usize = 3;

/// The pressure on a mesh.
pub(super) struct Pressed {
    pub(super) pressure: Vec<f64>,
    /// What of it is not that of Galerkin's method on all cells: that of enclosed ones, where there are any.
    pub(super) added: Option<Vec<f64>>,
    /// Of the cells in contact.
    pub(super) planes: Planes,
    /// f = plane . (1, x, y) in the mesh's axes.
    pub(super) plane: Vector3<f64>,
    pub(super) contact: Vec<bool>,
    /// Share of the largest f that f varies by.
    pub varies: f64,
    /// Half the extent of the contact, longer where f varies less.
    size: f64,
    /// Area over the square of the extent, where it lifts off.
    compact: f64,
}

impl Pressed {
    pub fn lifts(&self) -> bool {
        self.contact.iter().any(|c| !c)
    }

    /// The length that cells are small against. Of arms about as wide as w the compliance goes with w, and so does what cells leave of it: of
    /// the order of (h/l)^3 l/w. A proof tells by itself what they leave, and so do cells along a curve, which are finer on finer meshes:
    /// those along the chords of a polygon need not be.
    pub fn size(&self, outline: &Outline) -> f64 {
        if outline.is_curved() { self.size } else { self.size * self.compact.cbrt() }
    }
}

/// A mesh with its compliance, every cell an unknown.
pub(super) struct Punch {
    pub(super) fitted: Fitted,
    pub(super) mirrored: Mirrored,
    pub(super) lines: Lines,
    pub(super) compliance: Compliance,
    /// Integrals of 1, x and y over the cells, in the mesh's axes.
    pub(super) weights: [Vec<f64>; 3],
    pub(super) means: Means,
}

impl Punch {
    /// `None` once the time is used up.
    pub fn new(fitted: Fitted, means: Means) -> Option<Self> {
        let mesh = &fitted.mesh;
        let lines = Lines::new(mesh);
        let mirrored = Mirrored::new(mesh, &fitted.group);
        let compliance = Compliance::of_cells(mesh, &lines, &mirrored.orbits, means)?;
        let weights = mesh.weights();
        Some(Self { fitted, mirrored, lines, compliance, weights, means })
    }

    pub(super) fn mesh(&self) -> &Mesh {
        &self.fitted.mesh
    }

    /// The integral of g . (1, x, y) over every cell.
    pub(super) fn integrals(&self, g: &Vector3<f64>) -> Vec<f64> {
        let [one, x, y] = &self.weights;
        (0..one.len()).map(|i| g[0] * one[i] + g[1] * x[i] + g[2] * y[i]).collect()
    }

    /// The integrals of p, p x and p y.
    pub(super) fn load(&self, p: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|k, _| p.iter().zip(&self.weights[k]).map(|(p, w)| p * w).sum())
    }

    /// The pressure that is >= 0 and its plane.
    pub fn pressed(&self, given: Given) -> Option<Pressed> {
        let map = self.fitted.basis();
        let everywhere = || self.mirrored.planes(&self.compliance, &self.weights);
        let positive = |p: &[f64]| p.iter().all(|p| *p > 0.0);
        let mut added = None;
        let (pressure, plane, whole) = match given {
            Given::Plane(plane) => {
                let g = map.transpose() * Vector3::from(plane);
                let integrals = self.integrals(&g);
                // S p is positive: where f is not, it does not touch.
                if positive(&integrals) {
                    let whole = everywhere()?;
                    let mut p = whole.combined(&g);
                    if !positive(&p) {
                        let own = self.raised(&p).unwrap_or_else(|| solve_from(&self.compliance, &integrals, &p));
                        let own = self.raised(&own).unwrap_or(own);
                        added = positive(&own).then(|| difference(&own, &p));
                        p = own;
                    }
                    (p, g, Some(whole))
                } else {
                    (solve(&self.compliance, &integrals), g, None)
                }
            }
            Given::Load(load) => {
                let wanted = map.try_inverse()? * Vector3::from(load);
                let whole = everywhere()?;
                let g = whole.stiffness(&self.weights).try_inverse()? * wanted;
                let p = whole.combined(&g);
                // Enclosed cells are left free: a pressure as of their neighbours would bound the depth by ten times what an estimate leaves.
                let (p, g) = if positive(&p) {
                    (p, g)
                } else {
                    balance(&self.compliance, &self.weights, wanted, &p, self.means.deadline)?
                };
                (p, g, Some(whole))
            }
        };
        let contact: Vec<bool> = pressure.iter().map(|p| *p > 0.0).collect();
        let planes = match whole.filter(|_| positive(&pressure)) {
            Some(whole) => whole,
            None => Planes::on(&self.compliance, &self.weights, &contact)?,
        };
        let corners = || (0..contact.len()).filter(|&i| contact[i]).flat_map(|i| self.mesh().corners(i));
        let extent = |k: usize| {
            let (low, high) =
                corners().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p[k]), b.max(p[k])));
            high - low
        };
        let (low, high) = corners()
            .map(|[x, y]| plane[0] + plane[1] * x + plane[2] * y)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), f| (a.min(f), b.max(f)));
        let varies = ((high - low) / high).clamp(1e-3, 1.0);
        let longer = extent(0).max(extent(1));
        let area: f64 = (0..contact.len()).filter(|&i| contact[i]).map(|i| self.weights[0][i]).sum();
        let compact = if contact.iter().all(|c| *c) { 1.0 } else { (area / (longer * longer)).min(1.0) };
        let size = 0.5 * longer * varies.powf(-2.0 / 3.0);
        (high > 0.0 && size > 0.0).then_some(Pressed { pressure, added, planes, plane, contact, varies, size, compact })
    }

    /// The least of the pressures that enclose a cell on two opposite sides, there being cells beyond all four: it lifts off for no reason
    /// but that it is thin, and takes up what its neighbours leave.
    pub(super) fn enclosing(&self, cell: usize, p: &[f64]) -> Option<f64> {
        let beyond = |side: usize| self.beyond(cell, side, p, ENCLOSED_BY);
        let [a, b, c, d] = [beyond(0)?, beyond(1)?, beyond(2)?, beyond(3)?];
        Some(a.min(c).max(b.min(d))).filter(|least| *least > 0.0)
    }

    /// The first positive pressure of so many cells in a row beyond a side, else that of the last; `None` where the material ends before.
    fn beyond(&self, cell: usize, side: usize, p: &[f64], cells: usize) -> Option<f64> {
        let mesh = self.mesh();
        let (edge, _) = mesh.cell_edges[cell][side]?;
        let other = mesh.edges[edge].sides.into_iter().flatten().find(|c| *c != cell)?;
        if p[other] > 0.0 || cells == 1 {
            return Some(p[other]);
        }
        let entered = mesh.cell_edges[other].iter().position(|own| own.is_some_and(|(own, _)| own == edge))?;
        self.beyond(other, (entered + 2) % 4, p, cells - 1)
    }

    /// With a pressure as of their neighbours on enclosed cells where no others lack any; `None` too where none does.
    fn raised(&self, p: &[f64]) -> Option<Vec<f64>> {
        let own = |cell: usize| if p[cell] > 0.0 { Some(p[cell]) } else { self.enclosing(cell, p) };
        if p.iter().all(|p| *p > 0.0) { None } else { (0..p.len()).map(own).collect() }
    }

    /// The plane in the outline's axes.
    pub fn outer_plane(&self, pressed: &Pressed) -> Option<[f64; 3]> {
        Some((self.fitted.basis().transpose().try_inverse()? * pressed.plane).into())
    }

    /// Whether a cell at an edge of the material, of pressure p and m on the whole contact, may lift off in part.
    pub(super) fn may_lift(&self, cell: usize, p: &[f64], m: &[f64]) -> bool {
        let sides = || self.mesh().cell_edges[cell].iter().flatten().map(|(edge, _)| self.mesh().edges[*edge].sides);
        let ratio = |c: usize| p[c] / m[c];
        let falls = |c: usize| p[c] > 0.0 && ratio(cell) < FALLING * ratio(c);
        sides().any(|sides| sides.contains(&None)) && sides().flatten().flatten().any(falls)
    }
}

fn difference(p: &[f64], q: &[f64]) -> Vec<f64> {
    p.iter().zip(q).map(|(p, q)| p - q).collect()
}
