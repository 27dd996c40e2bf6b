//! The contact patch and its pieces.

use crate::gap::DataEdge;
use crate::numeric::geometry::Rect;

/// Where the bodies touch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Patch {
    /// Area.
    pub area: f64,
    /// Centroid of the area; `None` without contact.
    pub centroid: Option<[f64; 2]>,
    /// Number of separate regions.
    pub regions: usize,
    /// Largest distance of a point of the patch from the reference point of the gap.
    pub max_radius: f64,
    /// Closed polylines, the first point not repeated, when asked for: outer boundaries counter-clockwise, holes clockwise.
    pub boundary: Option<Vec<Vec<[f64; 2]>>>,
    /// The separate regions, largest force first; together they carry the force and have the area.
    pub pieces: Vec<Piece>,
    /// Semi-axes a >= b of a patch that is an ellipse by a closed form, or of the best one.
    pub semi_axes: Option<[f64; 2]>,
    /// Angle from x to the longer axis of such an ellipse, radians counter-clockwise, in (-pi/2, pi/2]; 0 for a disc.
    pub angle: Option<f64>,
}

/// One of the separate regions of a patch.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Area.
    pub area: f64,
    /// The part of the force that it carries.
    pub force: f64,
    /// Centroid of its area.
    pub centroid: [f64; 2],
    /// Lower left and upper right corner of the rectangle around it.
    pub extent: [[f64; 2]; 2],
    /// Largest pressure in it; `None` where the exact one is infinite or the method gives none.
    pub max_pressure: Option<f64>,
}

impl Patch {
    /// Lower left and upper right corner of the rectangle around all pieces; `None` without contact.
    ///
    /// ```
    /// use contact_patch::{Patch, Piece};
    /// let piece = |x: f64| Piece {
    ///     area: 1.0, force: 1.0, centroid: [x, 0.0], extent: [[x - 0.5, -0.5], [x + 0.5, 0.5]], max_pressure: None,
    /// };
    /// let patch = Patch { pieces: vec![piece(0.0), piece(3.0)], ..Patch::default() };
    /// assert_eq!(patch.extent(), Some([[-0.5, -0.5], [3.5, 0.5]]));
    /// ```
    #[must_use]
    pub fn extent(&self) -> Option<[[f64; 2]; 2]> {
        let corners = self.pieces.iter().flat_map(|piece| piece.extent);
        Rect::holding(corners).map(|rect| [rect.min, rect.max])
    }
}

/// The edge of measured or declared data that a patch meets: beyond it there may be a body that nobody told of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchesEdge {
    /// Which.
    pub edge: DataEdge,
    /// Share of the force on the cells beside it, from 0 to 1; `None` for methods without cells.
    pub share: Option<f64>,
}
