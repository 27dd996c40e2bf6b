//! Where the material ends, and the meshes that fit it.

use nalgebra::Matrix3;

use super::Limits;
use super::ellipse;
use super::kites;
use super::mesh::{Mesh, Point, cross, dot, minus, norm};
use super::polygon::{STRAIGHT, cleaned, convex_cuts, rectilinear_frame, symmetries};
use super::rectilinear::{Grading, count_along, graded_both, split, tensor};
use super::regular::regular;
use super::symmetry::{Isometry, Orbits};
use crate::numeric::geometry::{area, clip};

/// Near a sharp edge p ~ s^(-1/2) and the energy of cells of size h(s) errs by the integral of h^3 s^(-3): n^-3 for nodes (i/n)^beta with
/// beta > 3. A proved width of a level flat takes 5 to 20 % less time with 3.5 than with 4, which leaves thinner cells to sum over; 3.25 and
/// 3.75 are within 3 % of it.
const GRADING: Grading = Grading { beta: 3.5, count: count_along };

/// As many cells wherever the edge is. Tilted flats, most of which lift off, take 8 % more time with 3.5.
const ALIKE: Grading = Grading { beta: 4.0, count: |n, _| n };

/// The cells per half side of the first mesh.
pub(crate) const COARSEST: usize = 4;

/// Constant pressures on cells of size h leave of a pressure that varies by the share v of itself over a length l an energy of the order
/// of v^2 (h/l)^3: cells are at most this times l v^(-2/3)/n, which leaves as much as the edges do.
pub(super) const FINE: f64 = 0.9;

/// A simple polygon where the material ends, or an ellipse.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outline {
    /// Of an ellipse, those of a polygon that stands for it.
    corners: Vec<Point>,
    /// Of an ellipse about the origin.
    semi_axes: Option<Point>,
    /// The half-plane in which cells are wanted: plane . (1, x, y) > 0.
    reach: Option<[f64; 3]>,
    /// The direction of its sides, where all lie along two perpendicular lines.
    frame: Option<Point>,
    pieces: Vec<Vec<Point>>,
    /// By how much more or less a punch displaces whose edge lies elsewhere by the rounding of the meshes, relative.
    displaced: f64,
}

/// Distance from an edge, in units of the outline, of what lies on it.
const ON_EDGE: f64 = 1e-9;

/// Corners of the polygon that stands for an ellipse.
const CHORDS: usize = 96;

/// A mesh in the frame of its outline.
#[derive(Debug, Clone)]
pub(crate) struct Fitted {
    /// The cells.
    pub(crate) mesh: Mesh,
    /// Cosine and sine of the angle from the outline's axes to the mesh's.
    pub(crate) frame: Point,
    /// The mesh's zero, from the outline's origin, in the mesh's axes.
    pub(crate) origin: Point,
    /// Symmetries of the outline, in the mesh's axes.
    pub(crate) group: Vec<Isometry>,
}

impl Fitted {
    /// A point of the mesh in the outline's axes.
    pub(crate) fn to_outline(&self, q: Point) -> Point {
        let [c, s] = self.frame;
        let [x, y] = [q[0] + self.origin[0], q[1] + self.origin[1]];
        [c * x - s * y, s * x + c * y]
    }

    /// Whether so many times its cells and unknowns are within the limits.
    pub(crate) fn is_within(&self, limits: &Limits, times: usize) -> bool {
        let Self { mesh, group, .. } = self;
        times * mesh.loaded <= limits.cells && times * Orbits::new(mesh, group).loaded <= limits.unknowns
    }

    /// (1, x, y) of the outline's axes as combinations of those of the mesh's.
    pub(crate) fn basis(&self) -> Matrix3<f64> {
        let ([c, s], [x, y]) = (self.frame, self.to_outline([0.0; 2]));
        Matrix3::new(1.0, 0.0, 0.0, x, c, -s, y, s, c)
    }
}

impl Outline {
    /// The polygon with these corners, in either order. None where it has no area, crosses itself, or cannot be cut into
    /// convex pieces.
    #[must_use]
    pub fn polygon(corners: &[Point]) -> Option<Self> {
        if corners.len() < 3 || corners.iter().flatten().any(|c| !c.is_finite()) {
            return None;
        }
        Self::of_cleaned(cleaned(corners), 0.0)
    }

    /// The same, [`displaced`] by `eps` besides.
    fn of_cleaned(corners: Vec<Point>, eps: f64) -> Option<Self> {
        let frame = rectilinear_frame(&corners);
        let mut cuts = convex_cuts(&corners).into_iter().map(|cut| cut.iter().map(|p| cleaned(p)).collect()).peekable();
        // The first that cells fit, or the last.
        let has_mesh = |pieces: &Vec<Vec<Point>>| {
            frame.is_some() || kites::mesh(&corners, pieces, COARSEST, f64::INFINITY, GRADING).is_some()
        };
        let pieces = loop {
            let pieces: Vec<Vec<Point>> = cuts.next()?;
            if cuts.peek().is_none() || has_mesh(&pieces) {
                break pieces;
            }
        };
        let displaced = displaced(&corners, &pieces, eps)?;
        let outline = Self { corners, semi_axes: None, reach: None, frame, pieces, displaced };
        (area(&outline.corners) > 0.0 && displaced < 1e-3).then_some(outline)
    }

    /// The polygon that this one is but for the rounding of its coordinates: with symmetries or a frame that it has not, and [`displaced`]
    /// by no more than so much. `None` where it is what it is.
    pub fn regular(&self, most: f64) -> Option<Self> {
        if self.semi_axes.is_some() || self.reach.is_some() {
            return None;
        }
        // From the least radius of its pieces.
        let radius =
            self.pieces.iter().filter_map(|piece| Some(kites::inner_circle(piece)?.1)).fold(f64::INFINITY, f64::min);
        let corners = regular(&self.corners, most * radius);
        let moved = self.corners.iter().zip(&corners).map(|(a, b)| norm(minus(*a, *b))).fold(0.0, f64::max);
        let framed = self.frame.is_none() && rectilinear_frame(&corners).is_some();
        if moved == 0.0 || !(framed || symmetries(&corners).len() > symmetries(&self.corners).len()) {
            return None;
        }
        // Either lies in the other one grown by that.
        let found = Self::of_cleaned(cleaned(&corners), moved)?;
        let displaced = found.displaced.max(displaced(&self.corners, &self.pieces, moved)?);
        (displaced <= most).then_some(Self { displaced, ..found })
    }

    /// The ellipse with these semi-axes along x and y. Cells fit it but for chords: nothing is proved on them.
    #[must_use]
    pub fn ellipse(semi_axes: Point) -> Self {
        let corners = ellipse::chords(semi_axes, CHORDS);
        Self { corners, semi_axes: Some(semi_axes), reach: None, frame: None, pieces: Vec::new(), displaced: 0.0 }
    }

    /// Whether an ellipse under a force through this point is known to touch everywhere: its pressure there is
    /// (1 + 3 x x_0/a^2 + 3 y y_0/b^2)/sqrt(1 - x^2/a^2 - y^2/b^2) but for a factor (Green & Sneddon 1950), positive for x_0 within a third
    /// of the ellipse.
    pub(crate) fn touches_everywhere(&self, through: Point) -> bool {
        self.semi_axes.is_some_and(|[a, b]| 3.0 * (through[0] / a).hypot(through[1] / b) <= 1.0)
    }

    /// Whether it is an ellipse.
    pub(crate) fn is_curved(&self) -> bool {
        self.semi_axes.is_some()
    }

    /// Whether cells of it are left out.
    pub(crate) fn is_limited(&self) -> bool {
        self.reach.is_some()
    }

    /// Whether cells cover it, no more and no less: only then they prove anything.
    pub(crate) fn is_covered(&self) -> bool {
        self.semi_axes.is_none() && self.reach.is_none()
    }

    /// Whether the coarsest mesh leaves room for a finer one.
    #[must_use]
    pub fn fits(&self, limits: &Limits) -> bool {
        self.mesh(COARSEST).is_some_and(|fitted| fitted.is_within(limits, 2))
    }

    /// Its corners, counter-clockwise.
    pub(crate) fn corners(&self) -> &[Point] {
        &self.corners
    }

    /// Whether the side of a cell between two points lies on it: on an edge of a polygon, beside an ellipse on a chord of it.
    pub(crate) fn is_along_edge(&self, p: Point, q: Point) -> bool {
        if let Some([a, b]) = self.semi_axes {
            return [p, q].iter().all(|[x, y]| (x / a).hypot(y / b) >= 1.0 - ON_EDGE);
        }
        let on = |p: Point, a: Point, b: Point| {
            let (along, from) = (minus(b, a), minus(p, a));
            let share = dot(along, from) / dot(along, along);
            cross(along, from).abs() <= ON_EDGE * norm(along) && (-ON_EDGE..=1.0 + ON_EDGE).contains(&share)
        };
        let corners = &self.corners;
        (0..corners.len())
            .map(|k| (corners[k], corners[(k + 1) % corners.len()]))
            .any(|(a, b)| on(p, a, b) && on(q, a, b))
    }

    /// The longer side of its box.
    pub(crate) fn extent(&self) -> f64 {
        let range = |k: usize| {
            let (low, high) =
                self.corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p[k]), b.max(p[k])));
            high - low
        };
        range(0).max(range(1))
    }

    /// perimeter^2/(4 pi area), 1 for a circle.
    pub(crate) fn slenderness(&self) -> f64 {
        let side = |k: usize| norm(minus(self.corners[(k + 1) % self.corners.len()], self.corners[k]));
        let perimeter: f64 = (0..self.corners.len()).map(side).sum();
        perimeter.powi(2) / (4.0 * std::f64::consts::PI * area(&self.corners))
    }

    /// Whether its sides lie along two perpendicular lines.
    pub(crate) fn is_rectilinear(&self) -> bool {
        self.frame.is_some()
    }

    /// Whether all its sides and corners are alike.
    pub(crate) fn is_regular(&self) -> bool {
        self.is_convex() && symmetries(&self.corners).len() == 2 * self.corners.len()
    }

    /// Whether it is one convex piece.
    pub(crate) fn is_convex(&self) -> bool {
        self.pieces.len() == 1
    }

    /// The part where f = plane . (1, x, y) is positive; `None` where that is all of it, nothing, or in several pieces, and where cells
    /// cannot be fitted to it.
    pub(crate) fn part(&self, plane: [f64; 3]) -> Option<Self> {
        let f: Vec<f64> = self.corners.iter().map(|p| at(&plane, p)).collect();
        let changes = (0..f.len()).filter(|&k| (f[k] > 0.0) != (f[(k + 1) % f.len()] > 0.0)).count();
        if changes != 2 || self.semi_axes.is_some() {
            return None;
        }
        let [c, a, b] = plane;
        Self::polygon(&clip(&self.corners, -a, -b, -c))
    }

    /// The same outline with cells only where f = plane . (1, x, y) may be positive; `None` where that is so in every corner.
    pub(crate) fn within(&self, plane: [f64; 3]) -> Option<Self> {
        let some = self.corners.iter().any(|p| at(&plane, p) <= 0.0);
        some.then(|| Self { reach: Some(plane), ..self.clone() })
    }

    /// Whether f = plane . (1, x, y) is positive somewhere outside of a part, which a line cut off.
    pub(crate) fn beyond(&self, part: &Self, plane: [f64; 3]) -> bool {
        let left = match part.reach {
            Some([c, a, b]) => clip(&self.corners, -a, -b, -c),
            None => part.corners.clone(),
        };
        let outside = |p: &Point| !left.contains(p) && !contains(&left, *p);
        // The corners of the cut are the only ones of the part that are none of the outline.
        let cut = left.iter().filter(|p| !self.corners.contains(p));
        self.corners.iter().filter(|p| outside(p)).chain(cut).any(|p| at(&plane, p) > 0.0)
    }

    /// What the rounding of the mesh's corners does to the stiffness at most, relative.
    pub(crate) fn displaced(&self) -> f64 {
        self.displaced
    }

    /// A mesh with `n` cells between an edge and the middle of the part that it bounds, fewer where that is near.
    #[must_use]
    pub fn mesh(&self, n: usize) -> Option<Fitted> {
        self.fitted(n, f64::INFINITY, GRADING)
    }

    /// Whether every line of these meshes has more cells where n is larger: else only [`Outline::mesh_within`] tells what finer ones leave.
    #[must_use]
    pub fn is_graded_everywhere(&self) -> bool {
        self.semi_axes.is_some() || self.frame.is_some() || self.is_convex()
    }

    /// The same with cells no longer than about `most` and as many wherever the edge is: two of these tell what a finer one leaves.
    #[must_use]
    pub fn mesh_within(&self, n: usize, most: f64) -> Option<Fitted> {
        self.fitted(n, most, ALIKE)
    }

    fn fitted(&self, n: usize, most: f64, grading: Grading) -> Option<Fitted> {
        let mut fitted = match (self.semi_axes, self.frame) {
            (None, Some(frame)) => self.tensor(frame, n, most, grading),
            (None, None) => {
                let mesh = kites::mesh(&self.corners, &self.pieces, n, most, grading)?;
                Fitted { mesh, frame: [1.0, 0.0], origin: [0.0; 2], group: symmetries(&self.corners) }
            }
            (Some(semi_axes), _) => {
                let mesh = ellipse::mesh(semi_axes, n, grading.beta, most);
                Fitted { mesh, frame: [1.0, 0.0], origin: [0.0; 2], group: Vec::new() }
            }
        };
        if let Some(plane) = self.reach {
            let reached = |cell: &[Point; 4]| cell.iter().any(|p| at(&plane, &fitted.to_outline(*p)) > 0.0);
            fitted.mesh = fitted.mesh.with(reached)?;
        }
        Some(fitted)
    }

    /// Lines graded on both sides to every line that holds a side.
    fn tensor(&self, frame: Point, n: usize, most: f64, Grading { beta, count }: Grading) -> Fitted {
        let turned: Vec<Point> =
            self.corners.iter().map(|p| [dot(frame, *p), frame[0] * p[1] - frame[1] * p[0]]).collect();
        let mut lines = [0, 1].map(|k| {
            let mut v: Vec<f64> = turned.iter().map(|p| p[k]).collect();
            v.sort_by(f64::total_cmp);
            let size = v[v.len() - 1] - v[0];
            v.dedup_by(|a, b| (*a - *b).abs() <= STRAIGHT * size);
            v
        });
        // The frame's origin in the middle: mirrored lines are mirrored exactly.
        let middle = [0, 1].map(|k| 0.5 * (lines[k][0] + lines[k][lines[k].len() - 1]));
        for k in 0..2 {
            for v in &mut lines[k] {
                *v -= middle[k];
            }
            let count = lines[k].len();
            for i in 0..count / 2 {
                let (a, b) = (lines[k][i], lines[k][count - 1 - i]);
                if (a + b).abs() <= STRAIGHT * (b - a) {
                    lines[k][i] = -b;
                }
            }
        }
        let snapped: Vec<Point> = turned
            .iter()
            .map(|p| {
                [0, 1].map(|k| {
                    let at = p[k] - middle[k];
                    lines[k].iter().copied().min_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs())).unwrap_or(at)
                })
            })
            .collect();
        let longest = lines.iter().flat_map(|v| v.windows(2)).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        let nodes = |v: &[f64]| -> Vec<f64> {
            let mut all = vec![v[0]];
            for pair in v.windows(2) {
                let n = count(n, (pair[1] - pair[0]) / longest);
                all.extend(graded_both(pair[0], pair[1], n, beta).into_iter().skip(1));
            }
            split(&all, most)
        };
        let (x, y) = (nodes(&lines[0]), nodes(&lines[1]));
        let inside = |i: usize, j: usize| {
            let p = [0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1])];
            contains(&snapped, p)
        };
        let mesh = tensor(&x, &y, &inside);
        Fitted { mesh, frame, origin: middle, group: symmetries(&snapped) }
    }
}

/// By how much more a punch displaces than one whose edge lies within eps of its own, relative: K of a set A is its capacity,
/// which is strongly subadditive (Choquet 1954), so that for A the union of convex pieces A_i with inscribed circles of radius r_i
///
/// ```text
/// K(A grown by eps) - K(A) <= sum of K((1 + eps/r_i) A_i) - K(A_i) = sum of eps/r_i K(A_i),
/// K(A_i) <= K(A), 2 R_i for A_i in a circle of radius R_i,             K(A) >= 2 sqrt(area/pi) (Polya & Szego 1951).
/// ```
///
/// `eps`: what to add to eps. `None` where a piece has no inside.
fn displaced(corners: &[Point], pieces: &[Vec<Point>], eps: f64) -> Option<f64> {
    let size = corners.iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
    // Lines that are joined, corners that are left out and turned coordinates move the edge by no more.
    let eps = eps + 8.0 * corners.len() as f64 * STRAIGHT * size;
    let least = (area(corners) / std::f64::consts::PI).sqrt();
    let of_piece = |piece: &Vec<Point>| {
        let (centre, r) = kites::inner_circle(piece)?;
        let around = piece.iter().map(|p| norm(minus(*p, centre))).fold(0.0, f64::max);
        Some(eps / r * (around / least).min(1.0))
    };
    pieces.iter().map(of_piece).sum()
}

/// plane . (1, x, y).
fn at([c, a, b]: &[f64; 3], [x, y]: &Point) -> f64 {
    c + a * x + b * y
}

/// Whether a point lies inside a polygon.
fn contains(p: &[Point], at: Point) -> bool {
    let n = p.len();
    (0..n)
        .filter(|&i| {
            let (a, b) = (p[i], p[(i + 1) % n]);
            (a[1] > at[1]) != (b[1] > at[1]) && a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > at[0]
        })
        .count()
        % 2
        == 1
}
