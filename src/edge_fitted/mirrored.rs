//! Planes on a mesh with mirrors: along and across their lines they are even or odd, which are problems of their own.
//!
//! With a mirror R the cells come in orbits {i, R i}. Pressures with p(R i) = chi p(i), chi = 1 or -1, displace to f with
//! f(R i) = chi f(i), so that S falls into a block for each sign, of the representatives alone:
//!
//! ```text
//! sum over orbits b of A_ab p_b = f_a,      A_ab = sum over j = g b of chi(g) S_aj.
//! ```
//!
//! Parts of different signs are orthogonal in S, and their residuals in a(., .): a(w, w) is the sum of those of its parts. Two perpendicular
//! mirrors leave 1 and both coordinates to three different blocks.

use nalgebra::{Matrix3, Vector3};

use super::Means;
use super::active_set::Planes;
use super::cholesky::Cholesky;
use super::compliance::Compliance;
use super::line_potential::Lines;
use super::mesh::{Bilinear, Mesh, Point, dot};
use super::residual_form::ResidualForm;
use super::residual_norm::{Overlap, Target, decay_lengths, norms_of_pairs};
use super::symmetry::{Isometry, Orbits};

/// One mirror of a mesh, or two that are perpendicular, or none.
pub(super) struct Mirrored {
    /// Of the cells under the mirrors.
    pub orbits: Orbits,
    /// (1, u, v) = basis (1, x, y): u along the line of the first mirror and v across it, from its fixed point.
    basis: Matrix3<f64>,
    /// Mirrors: none, one, two.
    count: usize,
}

impl Mirrored {
    /// By those in `group` that map the mesh to itself.
    pub fn new(mesh: &Mesh, group: &[Isometry]) -> Self {
        let mut mirrors: Vec<Isometry> = Vec::new();
        for g in group.iter().filter(|g| is_mirror(g)) {
            // Mirrors that commute.
            let fits = match mirrors[..] {
                [] => true,
                [first] => dot(axis(&first), axis(g)).abs() < 1e-9,
                _ => false,
            };
            if fits && Orbits::new(mesh, &[*g]).images.len() == 2 {
                mirrors.push(*g);
            }
        }
        let Some(first) = mirrors.first().copied() else {
            return Self { orbits: Orbits::new(mesh, &[]), basis: Matrix3::identity(), count: 0 };
        };
        let count = mirrors.len();
        if count == 2 {
            // Both together are half a turn.
            mirrors.push(Isometry { centre: first.centre, matrix: [[-1.0, 0.0], [0.0, -1.0]] });
        }
        let ([x, y], [a, b]) = (first.centre, axis(&first));
        let basis = Matrix3::new(1.0, 0.0, 0.0, -(a * x + b * y), a, b, b * x - a * y, -b, a);
        Self { orbits: Orbits::new(mesh, &mirrors), basis, count }
    }

    /// chi of 1, u or v for every element of the group: u is odd under the second mirror, v under the first.
    fn signs(&self, function: usize) -> &'static [f64] {
        match (self.count, function) {
            (0, _) => &[1.0],
            (1, 0 | 1) => &[1.0, 1.0],
            (1, _) => &[1.0, -1.0],
            (_, 0) => &[1.0, 1.0, 1.0, 1.0],
            (_, 1) => &[1.0, 1.0, -1.0, -1.0],
            _ => &[1.0, -1.0, 1.0, -1.0],
        }
    }

    /// The pressures of 1, x and y on all cells; `None` where the matrix has no factor.
    pub fn planes(&self, s: &Compliance, weights: &[Vec<f64>; 3]) -> Option<Planes> {
        if self.count == 0 {
            return Planes::on(s, weights, &vec![true; s.n]);
        }
        let mut own: [Vec<f64>; 3] = Default::default();
        let mut last: Option<Block> = None;
        for (k, own) in own.iter_mut().enumerate() {
            let signs = self.signs(k);
            let block = match last.take().filter(|block| block.signs == signs) {
                Some(block) => block,
                None => Block::new(s, &self.orbits, signs)?,
            };
            let integral = |i: usize| (0..3).map(|j| self.basis[(k, j)] * weights[j][i]).sum::<f64>();
            *own = block.solve(&self.orbits, integral);
            last = Some(block);
        }
        let back = self.basis.try_inverse()?;
        let combined = |k: usize| (0..s.n).map(|i| (0..3).map(|j| back[(k, j)] * own[j][i]).sum()).collect();
        Some(Planes([0, 1, 2].map(combined)))
    }

    /// Bounds of a(w, w) for the residuals of planes in contact on all cells; `most`: those that have to be known best, where no mirror tells
    /// which are apart.
    pub fn residuals(
        &self,
        mesh: &Mesh,
        lines: &Lines,
        planes: &Planes,
        most: &[Vector3<f64>],
        means: Means,
    ) -> Option<ResidualForm> {
        let decay = decay_lengths(mesh);
        // (1, u, v).
        let own = |k: usize| self.basis.row(k).transpose();
        let (asked, pairs, parts): (_, &[[usize; 2]], &'static [&'static [usize]]) = match self.count {
            0 => (spread(mesh, most), &[[0, 1], [0, 2], [1, 2]], &[&[0, 1, 2]]),
            1 => ([own(0), own(1), own(2)], &[[0, 1]], &[&[0, 1], &[2]]),
            _ => ([own(0), own(1), own(2)], &[], &[&[0], &[1], &[2]]),
        };
        let pressures = asked.map(|g| planes.combined(&g));
        let targets: [Target; 3] =
            std::array::from_fn(|k| Target { pressure: &pressures[k], overlap: Overlap::Plane(asked[k].into()) });
        let (sums, joint) = norms_of_pairs(mesh, lines, &self.orbits, &decay, targets, pairs, means)?;
        ResidualForm::new(asked, parts, &sums, pairs, &joint)
    }
}

/// Three planes that are not alike on a mesh: 1, and those that are given as far as they are not.
fn spread(mesh: &Mesh, most: &[Vector3<f64>]) -> [Vector3<f64>; 3] {
    let middles = || (0..mesh.loaded).map(|cell| Bilinear::new(mesh.corners(cell)).centre);
    let [x, y] = [0, 1].map(|m| middles().map(|c| c[m]).sum::<f64>() / mesh.loaded as f64);
    let size = middles().map(|c| (c[0] - x).hypot(c[1] - y)).fold(0.0, f64::max);
    // Values in the middle, and what they change by over that size.
    let about = |g: &Vector3<f64>| Vector3::new(g[0] + g[1] * x + g[2] * y, size * g[1], size * g[2]);
    let back = |v: Vector3<f64>| Vector3::new(v[0] - (v[1] * x + v[2] * y) / size, v[1] / size, v[2] / size);
    let one = Vector3::x();
    let given = || most.iter().map(|g| about(g).normalize());
    let other = given().find(|g| one.cross(g).norm() > ALIKE).unwrap_or(Vector3::y());
    let across = one.cross(&other).normalize();
    let third = given().find(|g| across.dot(g).abs() > ALIKE).unwrap_or(across);
    [one, back(other), back(third)]
}

/// The sine of the angle between planes that are alike.
const ALIKE: f64 = 0.1;

/// S of the pressures with one set of signs.
struct Block {
    signs: &'static [f64],
    factor: Cholesky,
    /// The orbits that may carry such a pressure.
    own: Vec<usize>,
    /// chi of every cell, from its representative.
    of_cell: Vec<f64>,
}

impl Block {
    fn new(s: &Compliance, orbits: &Orbits, signs: &'static [f64]) -> Option<Self> {
        // A cell that a mirror with the sign -1 maps to itself carries none.
        let carries = |a: &usize| {
            let cell = orbits.representatives[*a];
            orbits.images.iter().zip(signs).all(|(image, sign)| image[cell] != cell || *sign > 0.0)
        };
        let own: Vec<usize> = (0..orbits.loaded).filter(carries).collect();
        let mut place = vec![None; orbits.loaded];
        own.iter().enumerate().for_each(|(k, &a)| place[a] = Some(k));
        let carriers = orbits.carriers();
        let of_cell: Vec<f64> = carriers[..s.n].iter().map(|&g| signs[g]).collect();
        let n = own.len();
        let mut matrix = vec![0.0; n * n];
        for (&a, line) in own.iter().zip(matrix.chunks_exact_mut(n)) {
            let size = orbits.size[a] as f64;
            let row = &s.matrix[orbits.representatives[a] * s.n..][..s.n];
            for (j, v) in row.iter().enumerate() {
                if let Some(k) = place[orbits.orbit[j]] {
                    line[k] += size * of_cell[j] * v;
                }
            }
        }
        Some(Self { signs, factor: Cholesky::new(matrix, n, s.threads)?, own, of_cell })
    }

    /// The pressure on all cells that displaces them by f, given its integrals.
    fn solve(&self, orbits: &Orbits, integral: impl Fn(usize) -> f64) -> Vec<f64> {
        let of_orbit = |a: &usize| orbits.size[*a] as f64 * integral(orbits.representatives[*a]);
        let mut x: Vec<f64> = self.own.iter().map(of_orbit).collect();
        self.factor.solve(&mut x);
        let mut values = vec![0.0; orbits.loaded];
        self.own.iter().zip(x).for_each(|(&a, p)| values[a] = p);
        self.of_cell.iter().zip(&orbits.orbit).map(|(sign, &a)| sign * values[a]).collect()
    }
}

fn is_mirror(g: &Isometry) -> bool {
    let [[a, b], [c, d]] = g.matrix;
    a * d - b * c < 0.0
}

/// The direction of the line that a mirror keeps: its matrix is [[c, s], [s, -c]], the angle half of that of (c, s).
fn axis(mirror: &Isometry) -> Point {
    let [[c, s], _] = mirror.matrix;
    let (sin, cos) = (0.5 * s.atan2(c)).sin_cos();
    [cos, sin]
}

#[cfg(test)]
mod tests {
    use super::super::outline::Outline;
    use super::*;

    /// With and without mirrors: one pressure, and bounds of one size.
    #[test]
    fn parts_make_the_whole() {
        let ell = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.2], [0.2, 0.2], [0.2, 1.0], [-1.0, 1.0]];
        let tee =
            [[0.5, 2.0], [-0.5, 2.0], [-0.5, 0.0], [-1.5, 0.0], [-1.5, -0.8], [1.5, -0.8], [1.5, 0.0], [0.5, 0.0]];
        let rectangle = [[0.0, 0.0], [2.0, 1.0], [1.0, 3.0], [-1.0, 2.0]];
        let kite = [[0.0, -1.0], [0.7, 0.3], [0.0, 0.8], [-0.7, 0.3]];
        let cases: [(&[Point], usize); 4] = [(&ell, 1), (&tee, 1), (&rectangle, 2), (&kite, 1)];
        for (corners, count) in cases {
            let fitted = Outline::polygon(corners).unwrap().mesh(4).unwrap();
            let mesh = &fitted.mesh;
            let lines = Lines::new(mesh);
            let mirrored = Mirrored::new(mesh, &fitted.group);
            let plain = Mirrored::new(mesh, &[]);
            assert_eq!((mirrored.count, plain.count), (count, 0), "{corners:?}");
            let weights = mesh.weights();
            let asked = [Vector3::x(), Vector3::new(1.0, 0.2, -0.3), Vector3::new(-0.4, 0.1, 1.0)];
            let [own, other] = [&mirrored, &plain].map(|some| {
                let s = Compliance::of_cells(mesh, &lines, &some.orbits, Means::PLAIN).unwrap();
                let planes = some.planes(&s, &weights).unwrap();
                let form = some.residuals(mesh, &lines, &planes, &asked[1..], Means::PLAIN).unwrap();
                (planes, asked.map(|plane| form.of(&plane)))
            });
            for (p, q) in own.0.0.iter().zip(&other.0.0) {
                let size = q.iter().fold(0.0, |m: f64, q| m.max(q.abs()));
                assert!(p.iter().zip(q).all(|(p, q)| (p - q).abs() < 1e-6 * size));
            }
            for (a, b) in own.1.iter().zip(other.1) {
                assert!(*a > 0.0 && (a / b - 1.0).abs() < 0.1, "{a} {b}");
            }
        }
    }
}
