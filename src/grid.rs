//! The grid of equal rectangular cells, each under uniform pressure, and fields on it.

use crate::numeric::geometry::Rect;

/// Equal rectangular cells over a rectangle. Cell (i, j) has index `j * shape[0] + i`: x runs fastest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Lower left corner of cell (0, 0).
    pub origin: [f64; 2],
    /// Sides of a cell.
    pub spacing: [f64; 2],
    /// Number of cells along x and y.
    pub shape: [usize; 2],
}

impl Grid {
    /// `shape` cells over `extent`.
    #[must_use]
    pub fn over(extent: &Rect, shape: [usize; 2]) -> Self {
        let [w, h] = extent.size();
        Self { origin: extent.min, spacing: [w / shape[0] as f64, h / shape[1] as f64], shape }
    }

    /// Whether its middle along an axis is at `place`, but for rounding.
    pub(crate) fn is_centred_on(&self, axis: usize, place: f64) -> bool {
        (place - self.extent().centre()[axis]).abs() <= ASIDE * self.spacing[axis]
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.shape[0] * self.shape[1]
    }

    /// Whether there is no cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Area of a cell.
    #[must_use]
    pub fn cell_area(&self) -> f64 {
        self.spacing[0] * self.spacing[1]
    }

    /// Centre of cell (i, j).
    #[must_use]
    pub fn centre(&self, i: usize, j: usize) -> [f64; 2] {
        [self.origin[0] + (i as f64 + 0.5) * self.spacing[0], self.origin[1] + (j as f64 + 0.5) * self.spacing[1]]
    }

    /// Centre of the cell with this index.
    #[must_use]
    pub fn centre_of(&self, index: usize) -> [f64; 2] {
        self.centre(index % self.shape[0], index / self.shape[0])
    }

    /// Centres of all cells, x fastest.
    pub fn centres(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let grid = *self;
        (0..grid.shape[1]).flat_map(move |j| (0..grid.shape[0]).map(move |i| grid.centre(i, j)))
    }

    /// All cells, row by row.
    pub fn cells(&self) -> impl Iterator<Item = Rect> + use<> {
        let grid = *self;
        (0..grid.shape[1]).flat_map(move |j| (0..grid.shape[0]).map(move |i| grid.cell(i, j)))
    }

    /// Centres of the cells under pressure, and their pressures.
    pub fn loaded<'a>(&self, pressure: &'a [f64]) -> impl Iterator<Item = ([f64; 2], f64)> + use<'a> {
        self.centres().zip(pressure.iter().copied()).filter(|(_, p)| *p > 0.0)
    }

    /// Cell (i, j) as a rectangle.
    #[must_use]
    pub fn cell(&self, i: usize, j: usize) -> Rect {
        Rect::around(self.centre(i, j), [0.5 * self.spacing[0], 0.5 * self.spacing[1]])
    }

    /// The rectangle that the cells cover.
    #[must_use]
    pub fn extent(&self) -> Rect {
        Rect {
            min: self.origin,
            max: [
                self.origin[0] + self.shape[0] as f64 * self.spacing[0],
                self.origin[1] + self.shape[1] as f64 * self.spacing[1],
            ],
        }
    }
}

/// Share of a cell that is rounding of its place: less than what every bound allows for.
const ASIDE: f64 = 1e-12;

/// Cells along both sides of a box: `longest` along the longer one, at least half as many along the other.
pub(crate) fn shape(window: &Rect, longest: usize) -> [usize; 2] {
    let [w, h] = window.size();
    let other = |ratio: f64| ((longest as f64 * ratio - 1e-9).ceil() as usize).clamp(longest.div_ceil(2), longest);
    if w >= h { [longest, other(h / w)] } else { [other(w / h), longest] }
}

/// How displacement is compared with the gap in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Kernel {
    /// Mean over the cell, of the displacement and of the gap: the energy is a bound, the force converges smoothly.
    #[default]
    Galerkin,
    /// At the cell's centre (Hartnett 1980, Kalker 1972).
    Collocation,
}

impl Kernel {
    /// The one that this is not: what both find differs by the error of either.
    pub(crate) fn other(self) -> Self {
        match self {
            Self::Galerkin => Self::Collocation,
            Self::Collocation => Self::Galerkin,
        }
    }
}

/// Pressure in each cell of a grid, and how it was reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Pressure {
    /// The cells.
    pub grid: Grid,
    /// Pressure in each cell, x fastest.
    pub values: Vec<f64>,
}

impl Pressure {
    /// Integral of the pressure: the force.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.values.iter().sum::<f64>() * self.grid.cell_area()
    }
}
