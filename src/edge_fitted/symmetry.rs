//! Cells that the symmetries of mesh and overlap map to each other carry the same pressure.

use super::mesh::{Bilinear, Mesh, Point, minus, norm};

/// x -> centre + matrix (x - centre), the matrix orthogonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Isometry {
    /// The fixed point.
    pub centre: Point,
    /// Rows of the orthogonal matrix.
    pub matrix: [Point; 2],
}

impl Isometry {
    /// The image of a point.
    #[must_use]
    pub fn apply(&self, p: Point) -> Point {
        let v = minus(p, self.centre);
        [0, 1].map(|k| self.centre[k] + self.matrix[k][0] * v[0] + self.matrix[k][1] * v[1])
    }
}

/// The group of mirrors in the lines x = c (the first) and y = c.
#[must_use]
pub(crate) fn mirrors(centre: Point, in_lines: [bool; 2]) -> Vec<Isometry> {
    let senses = |m: usize| if in_lines[m] { &[1.0, -1.0][..] } else { &[1.0][..] };
    let all = senses(1).iter().flat_map(|&b| senses(0).iter().map(move |&a| [[a, 0.0], [0.0, b]]));
    all.map(|matrix| Isometry { centre, matrix }).collect()
}

/// Orbits of the cells under a group.
#[derive(Debug, Clone)]
pub(crate) struct Orbits {
    /// Of each group element: the image of every cell, strip included.
    pub images: Vec<Vec<usize>>,
    /// One cell of each orbit, in order; orbits of loaded cells first.
    pub representatives: Vec<usize>,
    /// The orbit of each cell.
    pub orbit: Vec<usize>,
    /// Cells in each orbit.
    pub size: Vec<usize>,
    /// Orbits of loaded cells.
    pub loaded: usize,
}

impl Orbits {
    /// The orbits under those of `group` that map the mesh to itself; `group` is closed, so they are a group too.
    pub fn new(mesh: &Mesh, group: &[Isometry]) -> Self {
        let cells = mesh.cells.len();
        let finder = Finder::new(mesh);
        let mut images: Vec<Vec<usize>> = vec![(0..cells).collect()];
        // Matrices, about one centre, with the place of their image.
        let mut known: Vec<([Point; 2], usize)> = vec![([[1.0, 0.0], [0.0, 1.0]], 0)];
        for g in group {
            // After one another two that are known, or searched for.
            let composed = || {
                let mut pairs = known.iter().flat_map(|a| known.iter().map(move |b| (a, b)));
                let (a, b) = pairs.find(|(a, b)| close(&product(&a.0, &b.0), &g.matrix))?;
                Some(images[b.1].iter().map(|&i| images[a.1][i]).collect())
            };
            let Some(image) = composed().or_else(|| finder.image(mesh, g)) else { continue };
            let place = images.iter().position(|other| *other == image).unwrap_or_else(|| {
                images.push(image);
                images.len() - 1
            });
            known.push((g.matrix, place));
        }
        let mut orbit = vec![usize::MAX; cells];
        let (mut representatives, mut size, mut loaded) = (Vec::new(), Vec::new(), 0);
        for i in 0..cells {
            if orbit[i] == usize::MAX {
                let mut count = 0;
                for image in &images {
                    if orbit[image[i]] == usize::MAX {
                        orbit[image[i]] = representatives.len();
                        count += 1;
                    }
                }
                representatives.push(i);
                size.push(count);
                loaded += usize::from(i < mesh.loaded);
            }
        }
        Self { images, representatives, orbit, size, loaded }
    }

    /// For each loaded cell j: a group element that takes its representative to it.
    pub fn carriers(&self) -> Vec<usize> {
        let mut carrier = vec![0; self.orbit.len()];
        for &r in &self.representatives {
            for (g, image) in self.images.iter().enumerate().rev() {
                carrier[image[r]] = g;
            }
        }
        carrier
    }

    /// Values of the loaded orbits on all loaded cells.
    pub fn expand(&self, values: &[f64], loaded: usize) -> Vec<f64> {
        (0..loaded).map(|i| values[self.orbit[i]]).collect()
    }
}

fn product(a: &[Point; 2], b: &[Point; 2]) -> [Point; 2] {
    a.map(|[x, y]| [x * b[0][0] + y * b[1][0], x * b[0][1] + y * b[1][1]])
}

/// Whether two matrices of a finite group are the same.
fn close(a: &[Point; 2], b: &[Point; 2]) -> bool {
    a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-9)
}

/// Finds cells by their centres.
struct Finder {
    /// Centre and cell, by rising x.
    centres: Vec<(Point, usize)>,
    tolerance: f64,
}

impl Finder {
    fn new(mesh: &Mesh) -> Self {
        let mut centres: Vec<(Point, usize)> =
            (0..mesh.cells.len()).map(|i| (Bilinear::new(mesh.corners(i)).centre, i)).collect();
        centres.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        Self { centres, tolerance: 1e-12 * mesh.extent() }
    }

    fn find(&self, p: Point) -> Option<usize> {
        let first = self.centres.partition_point(|c| c.0[0] < p[0] - self.tolerance);
        self.centres[first..]
            .iter()
            .take_while(|c| c.0[0] <= p[0] + self.tolerance)
            .find(|c| norm(minus(c.0, p)) <= self.tolerance)
            .map(|c| c.1)
    }

    /// The permutation of the cells, if every cell has its corners taken to those of another one.
    fn image(&self, mesh: &Mesh, g: &Isometry) -> Option<Vec<usize>> {
        (0..mesh.cells.len())
            .map(|i| {
                let corners = mesh.corners(i);
                let target = self.find(g.apply(Bilinear::new(corners).centre))?;
                let others = mesh.corners(target);
                let close = |p: Point| others.iter().any(|q| norm(minus(*q, p)) <= self.tolerance);
                let same_kind = (i < mesh.loaded) == (target < mesh.loaded);
                (same_kind && corners.iter().all(|&c| close(g.apply(c)))).then_some(target)
            })
            .collect()
    }
}
