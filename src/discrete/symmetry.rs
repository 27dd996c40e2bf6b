//! Symmetries shared by the gap and the grid: cells that they map to each other carry the same pressure.

use crate::discrete::Discrete;

/// Two overlaps that differ by less than this share of the largest are taken as equal.
const SAME: f64 = 1e-11;

/// One of the eight ways to lay a rectangle of cells on itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Image {
    transpose: bool,
    flip_x: bool,
    flip_y: bool,
}

impl Image {
    /// All but the identity.
    const ALL: [Self; 7] = [
        Self { transpose: false, flip_x: true, flip_y: false },
        Self { transpose: false, flip_x: false, flip_y: true },
        Self { transpose: false, flip_x: true, flip_y: true },
        Self { transpose: true, flip_x: false, flip_y: false },
        Self { transpose: true, flip_x: true, flip_y: true },
        Self { transpose: true, flip_x: true, flip_y: false },
        Self { transpose: true, flip_x: false, flip_y: true },
    ];

    fn of(self, index: usize, [nx, ny]: [usize; 2]) -> usize {
        let (mut i, mut j) = (index % nx, index / nx);
        if self.transpose {
            (i, j) = (j, i);
        }
        if self.flip_x {
            i = nx - 1 - i;
        }
        if self.flip_y {
            j = ny - 1 - j;
        }
        j * nx + i
    }

    fn words(self) -> &'static str {
        match (self.transpose, self.flip_x, self.flip_y) {
            (false, true, false) => "mirror x -> -x",
            (false, false, true) => "mirror y -> -y",
            (false, _, _) => "half turn",
            (true, false, false) => "mirror x <-> y",
            (true, true, true) => "mirror x <-> -y",
            (true, _, _) => "quarter turn",
        }
    }
}

/// The symmetries of a discrete problem, found on its own numbers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Symmetry {
    images: Vec<Image>,
}

impl Symmetry {
    /// Those of the eight symmetries of the grid that leave the overlap of every cell as it is.
    ///
    /// ```
    /// use contact_patch::{Discrete, Grid, Kernel, gap::Polyhedron, geometry::Rect, symmetry::Symmetry};
    /// let grid = Grid::over(&Rect::around([0.0; 2], [2.0; 2]), [20, 20]);
    /// let order = |faces| {
    ///     let punch = Polyhedron::pyramid(faces, 0.7)?;
    ///     Ok::<_, contact_patch::InputError>(Symmetry::of(&Discrete::sample(&punch, 1.0, grid, Kernel::Galerkin)).order())
    /// };
    /// assert_eq!((order(3)?, order(4)?), (2, 8));
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    #[must_use]
    pub fn of(problem: &Discrete) -> Self {
        let grid = &problem.grid;
        let square =
            grid.shape[0] == grid.shape[1] && (grid.spacing[0] - grid.spacing[1]).abs() <= SAME * grid.spacing[0];
        let tolerance = SAME * problem.deepest().abs();
        let same = |a: f64, b: f64| a == b || (a - b).abs() <= tolerance || (a <= 0.0 && b <= 0.0);
        let holds =
            |image: &Image| (0..grid.len()).all(|k| same(problem.overlap[k], problem.overlap[image.of(k, grid.shape)]));
        let images = Image::ALL.into_iter().filter(|i| (square || !i.transpose) && holds(i)).collect();
        Self { images }
    }

    /// Whether the mirror x -> -x about the middle of the grid is one of them.
    #[must_use]
    pub fn mirrors_x(&self) -> bool {
        self.images.contains(&Image::ALL[0])
    }

    /// Whether the mirror y -> -y about the middle of the grid is one of them.
    #[must_use]
    pub fn mirrors_y(&self) -> bool {
        self.images.contains(&Image::ALL[1])
    }

    /// Whether x and y may be exchanged.
    #[must_use]
    pub fn exchanges(&self) -> bool {
        self.images.iter().any(|i| i.transpose)
    }

    /// How many cells share one unknown, away from the axes.
    #[must_use]
    pub fn order(&self) -> usize {
        self.images.len() + 1
    }

    /// In words: "mirror x -> -x, half turn".
    #[must_use]
    pub fn words(&self) -> String {
        let mut words: Vec<&str> = Vec::new();
        for image in &self.images {
            // A turn to the left and one to the right have one name.
            if !words.contains(&image.words()) {
                words.push(image.words());
            }
        }
        words.join(", ")
    }

    /// Groups the cells marked in `wanted`; each group shares one unknown.
    #[must_use]
    pub fn orbits(&self, wanted: &[bool], shape: [usize; 2]) -> Orbits {
        let mut orbit_of = vec![usize::MAX; wanted.len()];
        let mut members = Vec::new();
        for cell in 0..wanted.len() {
            if orbit_of[cell] != usize::MAX {
                continue;
            }
            let mut orbit: Vec<usize> =
                std::iter::once(cell).chain(self.images.iter().map(|i| i.of(cell, shape))).collect();
            orbit.sort_unstable();
            orbit.dedup();
            if orbit.iter().any(|&c| wanted[c]) {
                for &c in &orbit {
                    orbit_of[c] = members.len();
                }
                members.push(orbit);
            }
        }
        Orbits { members }
    }
}

/// Groups of cells that carry the same pressure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Orbits {
    /// The cells of each group, ascending.
    pub members: Vec<Vec<usize>>,
}
