//! The axes along which a contact is solved: those that its gap was drawn along, however it was turned afterwards.
//!
//! Cells that lie along straight edges and slender contacts are few; the same ones turned by 37 degrees take a staircase. Nothing in the
//! mechanics knows the axes, so the problem is turned back, solved, and its answer turned outward again. What the axes are follows from
//! the way in which the gap is written ([`crate::gap::Known::drawn_along`]); a wrong guess costs time, never truth.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::edge_fitted::resample;
use crate::gap::AnyGap;
use crate::grid::{Grid, Pressure, shape};
use crate::numeric::geometry::Rect;
use crate::problem::{Contact, Load, Loading, Method, Outputs, Settings};
use crate::solution::{Origin, Patch, Solution, Unsolved};

/// Axes turned from the user's by an angle, about the user's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axes {
    /// Radians counter-clockwise, in (-pi/4, pi/4].
    angle: f64,
    sin: f64,
    cos: f64,
}

/// Angles that only rounding sets apart from the user's axes.
const NONE: f64 = 1e-9;

impl Axes {
    /// The axes of a contact; `None` where the user's serve as well, and where these are wanted: a prescribed grid is the user's, and so
    /// are the fields that a gap or a bracket is shown by.
    pub fn of(contact: &Contact, settings: &Settings) -> Option<Self> {
        let Outputs { gap, bracket, .. } = settings.outputs;
        let by_cells = matches!(settings.method, Method::Auto | Method::EdgeFitted | Method::Fft | Method::Qp);
        if !by_cells || settings.cells.is_some() || gap || bracket {
            return None;
        }
        let known = contact.gap().known();
        // Closed forms and cells fitted to a face have axes of their own.
        if known.axis.is_some() || known.face.is_some() || known.quadratic.is_some() {
            return None;
        }
        Self::along(contact.gap())
    }

    /// Those that a gap was drawn along; `None` where these are the user's.
    pub fn along(gap: &AnyGap) -> Option<Self> {
        let drawn_along = gap.known().drawn_along;
        let quarters = (drawn_along / FRAC_PI_2).round();
        let angle = drawn_along - quarters * FRAC_PI_2;
        (angle.abs() > NONE).then(|| Self { angle, sin: angle.sin(), cos: angle.cos() })
    }

    /// A gap in these axes.
    pub fn gap_inward(&self, gap: &AnyGap) -> AnyGap {
        gap.turned(-self.angle)
    }

    /// In words.
    pub fn found(&self) -> String {
        format!("solved along axes turned by {:.3} degrees, along which the gap was drawn", self.angle.to_degrees())
    }

    /// A load of the user's axes in these.
    pub fn load_inward(&self, load: Load) -> Load {
        match load {
            Load::Tilted { depth, tilt } => Load::Tilted { depth, tilt: self.vector_inward(tilt) },
            Load::ForceMoment { force, moment } => Load::ForceMoment { force, moment: self.vector_inward(moment) },
            other => other,
        }
    }

    /// The contact in these axes.
    pub fn inward(&self, contact: &Contact) -> Contact {
        let loading = match contact.loading() {
            Loading::Single(single) => Loading::Single(self.load_inward(*single)),
            Loading::Steps(steps) => Loading::Steps(steps.iter().map(|load| self.load_inward(*load)).collect()),
        };
        contact.of_gap(self.gap_inward(contact.gap()), loading)
    }

    /// What to ask for in these axes: boxes of the user's axes around the pieces take their boundaries.
    pub fn settings_inward(settings: &Settings) -> Settings {
        Settings { outputs: Outputs { patch: true, ..settings.outputs }, ..*settings }
    }

    /// A vector of the user's axes in these.
    pub fn vector_inward(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x + self.sin * y, self.cos * y - self.sin * x]
    }

    /// A vector of these axes in the user's.
    pub fn vector_outward(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.cos * y + self.sin * x]
    }

    /// An answer in the user's axes, to the load as it was given.
    pub fn outward(
        &self,
        answer: Result<Solution, Unsolved>,
        load: Load,
        settings: &Settings,
    ) -> Result<Solution, Unsolved> {
        match answer {
            Ok(state) => Ok(self.state_outward(state, load, settings)),
            Err(mut unsolved) => {
                unsolved.best = unsolved.best.map(|best| Box::new(self.state_outward(*best, load, settings)));
                Err(unsolved)
            }
        }
    }

    fn state_outward(&self, mut state: Solution, load: Load, settings: &Settings) -> Solution {
        state.tilt = match load {
            Load::Tilted { tilt, .. } => tilt,
            Load::Depth(_) | Load::Force(_) => [0.0; 2],
            Load::ForceMoment { .. } => self.vector_outward(state.tilt),
        };
        state.moment = match load {
            Load::ForceMoment { moment, .. } if state.moment.is_some() && state.force > 0.0 => Some(moment),
            _ => state.moment.map(|moment| self.vector_outward(moment)),
        };
        state.stiffness_matrix = state.stiffness_matrix.map(|matrix| self.matrix_outward(matrix));
        self.patch_outward(&mut state.patch, settings.outputs.patch);
        state.turned = (state.force > 0.0).then_some(self.angle);
        let pressure = &mut state.pressure;
        pressure.at = pressure.at.map(|at| self.vector_outward(at));
        pressure.field = pressure.field.take().map(|field| self.field_outward(&field));
        if let Some(field) = &pressure.field {
            // Fitted cells are drawn on the grid of the field, whichever it is.
            if state.origin == Origin::EdgeFitted {
                state.grid = Some(field.grid);
            }
            state.remarks.push(format!(
                "the pressure field: means over cells of {:e} along x and y, of the cells of a grid turned by {:.3} degrees",
                field.grid.spacing[0],
                self.angle.to_degrees()
            ));
        }
        state.left_out.push(format!(
            "cells along x and y: those of a grid turned by {:.3} degrees are fewer",
            self.angle.to_degrees()
        ));
        state
    }

    /// A stiffness whose rows and columns belong to (d, ax, ay) of these axes, in the user's.
    pub fn matrix_outward(&self, k: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let rows = k.map(|[d, x, y]| {
            let [x, y] = self.vector_outward([x, y]);
            [d, x, y]
        });
        let column = |j: usize| self.vector_outward([rows[1][j], rows[2][j]]);
        let [c0, c1, c2] = [0, 1, 2].map(column);
        [rows[0], [c0[0], c1[0], c2[0]], [c0[1], c1[1], c2[1]]]
    }

    fn patch_outward(&self, patch: &mut Patch, with_boundary: bool) {
        patch.centroid = patch.centroid.map(|c| self.vector_outward(c));
        patch.angle = patch.angle.map(|angle| {
            let turned = angle + self.angle;
            turned - PI * ((turned / PI) - 0.5).ceil()
        });
        let loops = patch.boundary.take().unwrap_or_default();
        for piece in &mut patch.pieces {
            let [min, max] = piece.extent;
            let own = Rect { min, max }.scaled(1.0 + 1e-9);
            piece.centroid = self.vector_outward(piece.centroid);
            let along = loops.iter().filter(|line| line.iter().all(|p| own.contains(*p))).flatten().copied();
            // The rectangle of a piece holds its boundary, or at worst the turned rectangle does.
            let seen = Rect::holding(along.map(|p| self.vector_outward(p)));
            let around = seen.or_else(|| Rect::holding(own.corners().map(|p| self.vector_outward(p))));
            piece.extent = around.map_or(piece.extent, |rect| [rect.min, rect.max]);
        }
        let turned = || loops.iter().map(|line| line.iter().map(|p| self.vector_outward(*p)).collect()).collect();
        patch.boundary = with_boundary.then(turned);
    }

    /// The means of a field over upright cells of about the size of its own.
    fn field_outward(&self, field: &Pressure) -> Pressure {
        let grid = field.grid;
        let cells: Vec<_> = (0..grid.len())
            .filter(|&k| field.values[k] > 0.0)
            .map(|k| {
                let corners = grid.cell(k % grid.shape[0], k / grid.shape[0]).corners();
                (corners.map(|c| self.vector_outward(c)), field.values[k])
            })
            .collect();
        let around = Rect::holding(cells.iter().flat_map(|(corners, _)| *corners)).unwrap_or(grid.extent());
        let finest = around.longer_side() / grid.spacing[0].min(grid.spacing[1]);
        let own = grid.shape[0].max(grid.shape[1]);
        let longest = (finest.ceil() as usize).clamp(own, MOST_CELLS.max(own));
        resample(&cells, Grid::over(&around, shape(&around, longest)))
    }
}

/// Most cells along the longer side of a field that was turned, unless it had more of its own.
const MOST_CELLS: usize = 512;
