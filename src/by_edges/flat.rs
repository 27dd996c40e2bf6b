//! A level face in a polygon with no material outside: P = E* K d.

use super::{Found, field_grid};
use crate::edge_fitted::{FlatStiffness, Limits, Outline, Region, estimated_stiffness, flat_stiffness, resample};
use crate::gap::Face;
use crate::numeric::geometry::{Rect, area, centroid, farthest};
use crate::problem::{Contact, Settings};
use crate::solution::{Patch, Piece};

/// A polygon, and the outline that the cells are fitted to: in units of half its longer side, about the middle of its box.
pub(crate) struct Flat {
    pub(super) outline: Outline,
    pub(super) corners: Vec<[f64; 2]>,
    /// From the outline's axes to the user's: its origin, the cosine and sine of its turn, its unit of length.
    pub(super) origin: [f64; 2],
    pub(super) turn: [f64; 2],
    pub(super) length: f64,
    /// The gap on it.
    pub value: f64,
}

/// An outline of more corners is left to the grid: cells at each of them would be too many, and to find them takes the cube.
pub(super) const MOST_CORNERS: usize = 256;

/// Relative rounding of the area of a polygon.
pub(super) const ROUNDING: f64 = 1e-12;

/// K in the user's units and what comes with it.
#[derive(Clone)]
pub(super) struct Punch {
    /// Bounds of K, a length.
    pub stiffness: [f64; 2],
    /// Corners in the user's frame, and pressure over E* d, of the cells.
    pub cells: Vec<([[f64; 2]; 4], f64)>,
    pub unknowns: usize,
}

impl Flat {
    /// `None` where the face is not level or no polygon, or the cells cannot be fitted to it.
    pub fn of(face: &Face) -> Option<Self> {
        if face.slope != [0.0; 2] {
            return None;
        }
        Self::outlined(face)
    }

    /// The same whatever its slope.
    pub(super) fn outlined(face: &Face) -> Option<Self> {
        let (sin, cos) = face.turn.sin_cos();
        Self::polygon(face.outline.corners(), face.at, [cos, sin], face.value)
    }

    /// A face in an ellipse, whatever its slope: for tilts past lift-off, which no formula reaches.
    pub(super) fn ellipse(face: &Face) -> Option<Self> {
        let (sin, cos) = face.turn.sin_cos();
        Some(Self::round(face.outline.semi_axes()?, face.at, [cos, sin], face.value))
    }

    /// The ellipse with these semi-axes, turned by the angle with this cosine and sine.
    pub(super) fn round(semi_axes: [f64; 2], at: [f64; 2], turn: [f64; 2], value: f64) -> Self {
        let length = semi_axes[0].max(semi_axes[1]);
        let outline = Outline::ellipse(semi_axes.map(|a| a / length));
        let mut flat = Self { outline, corners: Vec::new(), origin: at, turn, length, value };
        flat.corners = flat.outline.corners().iter().map(|p| flat.outward(*p)).collect();
        flat
    }

    /// The polygon with these corners in axes about `at`, turned by the angle with this cosine and sine.
    pub fn polygon(corners: &[[f64; 2]], at: [f64; 2], turn: [f64; 2], value: f64) -> Option<Self> {
        if corners.len() > MOST_CORNERS {
            return None;
        }
        let rect = Rect::holding(corners.iter().copied())?;
        let (middle, [w, h]) = (rect.centre(), rect.size());
        let length = 0.5 * w.max(h);
        let inward = |p: &[f64; 2]| [0, 1].map(|m| (p[m] - middle[m]) / length);
        let outline = Outline::polygon(&corners.iter().map(inward).collect::<Vec<_>>())?;
        let moved = turned(turn, middle);
        if !outline.fits(&Limits::default()) {
            return None;
        }
        let origin = [at[0] + moved[0], at[1] + moved[1]];
        let mut flat = Self { outline, corners: Vec::new(), origin, turn, length, value };
        flat.corners = corners.iter().map(|p| flat.outward(inward(p))).collect();
        Some(flat)
    }

    pub(super) fn outward(&self, p: [f64; 2]) -> [f64; 2] {
        let [x, y] = turned(self.turn, p);
        [self.origin[0] + self.length * x, self.origin[1] + self.length * y]
    }

    /// A point of the user's frame in the outline's axes.
    pub(super) fn inward(&self, p: [f64; 2]) -> [f64; 2] {
        let ([x, y], [cos, sin]) = ([p[0] - self.origin[0], p[1] - self.origin[1]], self.turn);
        [(cos * x + sin * y) / self.length, (cos * y - sin * x) / self.length]
    }

    pub fn found(&self) -> String {
        format!("a level polygon of {} corners with sharp edges", self.corners.len())
    }

    /// Bounds of K to a tolerance.
    pub(super) fn punch(&self, limits: &Limits) -> Option<Punch> {
        flat_stiffness(&self.outline, limits).map(|found| self.placed(found))
    }

    fn placed(&self, FlatStiffness { stiffness, cells, unknowns }: FlatStiffness) -> Punch {
        let cells = cells.into_iter().map(|(c, p)| (c.map(|q| self.outward(q)), p / self.length)).collect();
        Punch { stiffness: stiffness.map(|k| k * self.length), cells, unknowns }
    }

    pub(super) fn solve(&self, contact: &Contact, depth: f64, settings: &Settings, limits: &Limits) -> Option<Found> {
        let told = if limits.proof { None } else { estimated_stiffness(&self.outline, limits) };
        // Where meshes do not tell enough a proof may.
        let (found, proved) = match told {
            Some(told) if told.width() <= limits.tolerance => (told, false),
            told => {
                let shown = flat_stiffness(&self.outline, limits).map(|shown| (shown, true));
                shown.or(told.map(|told| (told, false)))?
            }
        };
        let punch = self.placed(found);
        let how = format!("the gap is {}: force ~ depth", self.found());
        Some(Found { proved, ..self.state(contact, depth - self.value, settings, punch, how) })
    }

    /// The state of the punch alone, pressed in by `depth`.
    pub(super) fn state(&self, contact: &Contact, depth: f64, settings: &Settings, punch: Punch, how: String) -> Found {
        let e_star = contact.modulus().e_star();
        let force = punch.stiffness.map(|k| e_star * k * depth);
        let mut cells = punch.cells;
        cells.iter_mut().for_each(|(_, p)| *p *= e_star * depth);
        let strongest = cells.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(self.origin, |(c, _)| middle(c));
        let rect = Rect::holding(self.corners.iter().copied()).unwrap_or(Rect::around(self.origin, [self.length; 2]));
        let reference = contact.gap().known().reference;
        Found {
            force,
            energy: force.map(|p| 0.5 * p * depth),
            stiffness: 0.5 * e_star * (punch.stiffness[0] + punch.stiffness[1]),
            stiffness_error: Some(
                (punch.stiffness[1] - punch.stiffness[0]) / (punch.stiffness[1] + punch.stiffness[0]),
            ),
            // The corners are given.
            area_error: Some(ROUNDING),
            patch: Patch {
                area: area(&self.corners),
                centroid: Some(centroid(&self.corners)),
                regions: 1,
                max_radius: farthest(&self.corners, reference),
                boundary: Some(vec![self.corners.clone()]),
                ..Patch::default()
            },
            centre: self.centre_of(&cells),
            max: None,
            max_error: None,
            at: strongest,
            field: settings.outputs.pressure.then(|| resample(&cells, field_grid(&rect))),
            unknowns: punch.unknowns,
            how,
            left_out: "the surface grid: cells follow the edges of the material",
            proved: true,
            tilting: None,
        }
    }

    /// The regions of contact in the user's frame.
    pub(super) fn patch(&self, regions: &[Region], of_force: f64, reference: [f64; 2]) -> Patch {
        let outward = |line: &Vec<[f64; 2]>| line.iter().map(|p| self.outward(*p)).collect::<Vec<_>>();
        let pieces = regions.iter().map(|region| {
            let boundary = region.boundary.iter().flat_map(outward);
            let extent = Rect::holding(boundary).unwrap_or(Rect::around(self.origin, [0.0; 2]));
            Piece {
                area: region.area * self.length * self.length,
                force: region.force * of_force,
                centroid: self.outward(region.centroid),
                extent: [extent.min, extent.max],
                max_pressure: None,
            }
        });
        let pieces: Vec<Piece> = pieces.collect();
        let area: f64 = pieces.iter().map(|piece| piece.area).sum();
        let boundary: Vec<Vec<[f64; 2]>> = regions.iter().flat_map(|region| &region.boundary).map(outward).collect();
        Patch {
            area,
            centroid: Some([0, 1].map(|m| pieces.iter().map(|p| p.area * p.centroid[m]).sum::<f64>() / area)),
            regions: pieces.len(),
            max_radius: farthest(boundary.iter().flatten(), reference),
            boundary: Some(boundary),
            pieces,
            semi_axes: None,
            angle: None,
        }
    }

    /// The centre of the pressure in cells, from the middle of the outline: nothing cancels far from the user's origin.
    pub(super) fn centre_of(&self, cells: &[([[f64; 2]; 4], f64)]) -> [f64; 2] {
        let (mut total, mut sum) = (0.0, [0.0; 2]);
        for (corners, p) in cells {
            let own = corners.map(|c| [c[0] - self.origin[0], c[1] - self.origin[1]]);
            let (force, at) = (p * area(&own), centroid(&own));
            total += force;
            sum = [sum[0] + force * at[0], sum[1] + force * at[1]];
        }
        [0, 1].map(|m| self.origin[m] + sum[m] / total)
    }
}

fn turned([cos, sin]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [cos * x - sin * y, sin * x + cos * y]
}

pub(super) fn middle(corners: &[[f64; 2]; 4]) -> [f64; 2] {
    [0, 1].map(|m| 0.25 * corners.iter().map(|c| c[m]).sum::<f64>())
}
