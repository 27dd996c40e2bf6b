//! The force of a smooth gap by moving the contact: dilated, the way back to a law where there is nearly one.
//!
//! Of all pressures the exact one gives <f, p> - <p, S p>/2 its largest value U, also of those that are moved along the surface or
//! dilated. Moved by a constant b, S does the same: <b . grad f, p> = 0. Dilated by 1 + e, <p, S p> grows by (1 + e)^3:
//! <x . grad f, p> = -U. (Curves on which f has kinks carry no load: they have no capacity.) With <f, p> = 2 U,
//!
//!   <psi, p> = (2 + alpha) U,   psi = f + V . grad f,   V = b - alpha x,                                                 (6)
//!
//! for any alpha and b. A gap that is homogeneous of degree k about a point has psi = d - g0 for alpha = 1/k and b = x0/k. Else, with any
//! kappa, phi = psi - kappa,
//!
//!   kappa P = (2 + alpha) U - <phi, p>,   |<phi, p> - <phi, p_h>| <= sqrt(2 gamma a_phi),                                (7)
//!
//! a_phi a bound of a(w, w) with w = phi on all that is under p or p_h. alpha, b and kappa are those that make phi small on the contact.
//! Of a ball or a paraboloid that is not quite one what is left is far less than what (4) and (5) leave.

use nalgebra::{DMatrix, DVector};

use super::field::Field;
use super::overlap::{Interval, Jet, OverlapBounds};
use super::residual::{Quarter, Residual};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;

/// Cells that tell what makes phi small.
const SAMPLES: usize = 256;

/// Rectangles a side of what w differs from 0 in.
const LATTICE: usize = 24;

/// How far w goes on beyond the contact, in its half axes: the best of these counts.
const BEYOND: [f64; 3] = [0.25, 0.08, 0.025];

/// What a few hundred products and sums may change a bound by, relative to the size of what is added.
const ROUNDING: f64 = 1e-12;

/// Bounds of the force from those of the energy, `lower` and `lower + gamma`; `None` where f is not known to be smooth. `touch`:
/// what may be under the exact pressure besides the cells under that of the residual.
pub(super) fn bounds(residual: &Residual, touch: &[Quarter], lower: f64, gamma: f64) -> Option<[f64; 2]> {
    let moved = Moved::fitted(residual)?;
    let [low, high] = moved.work(residual)?;
    let open = (2.0 * gamma * moved.energy(residual.overlap, &Ellipse::around(residual, touch))?).sqrt();
    let upper = (lower + gamma) * (1.0 + ROUNDING);
    let ends = [(2.0 + moved.alpha) * lower - high - open, (2.0 + moved.alpha) * upper - low + open];
    let size = (2.0 + moved.alpha) * upper + high.abs() + low.abs() + open;
    let force = [ends[0] - ROUNDING * size, ends[1] + ROUNDING * size].map(|end| end / moved.kappa);
    (force[0] > 0.0 && force[1].is_finite()).then_some(force)
}

/// An ellipse with its axes along x and y.
struct Ellipse {
    centre: [f64; 2],
    half: [f64; 2],
}

impl Ellipse {
    /// Around all cells that are or may be under pressure.
    fn around(residual: &Residual, touch: &[Quarter]) -> Self {
        let cells = || loaded(residual).map(|(i, j, _)| (i, j)).chain(touch.iter().map(|(i, j, _)| (*i, *j)));
        let rects = || cells().map(|(i, j)| residual.rect(i, j));
        let mut all = rects().reduce(|a, b| a.union(&b)).unwrap_or_else(|| residual.field.grid.extent());
        let middle = residual.field.grid.extent().centre();
        for m in (0..2).filter(|m| residual.halves[*m]) {
            let half = (all.max[m] - middle[m]).max(middle[m] - all.min[m]);
            (all.min[m], all.max[m]) = (middle[m] - half, middle[m] + half);
        }
        let whole = Self { centre: all.centre(), half: all.size().map(|side| 0.5 * side) };
        // Images lie as far away.
        let scale = rects().map(|rect| whole.distances(&rect)[1]).fold(1.0, f64::max) * (1.0 + 1e-9);
        Self { half: whole.half.map(|a| a * scale), ..whole }
    }

    /// Least and greatest distance of a rectangle from the centre, in half axes.
    fn distances(&self, rect: &Rect) -> [f64; 2] {
        let near = |m: usize| (rect.min[m] - self.centre[m]).max(self.centre[m] - rect.max[m]).max(0.0) / self.half[m];
        let far = |m: usize| (rect.max[m] - self.centre[m]).max(self.centre[m] - rect.min[m]) / self.half[m];
        [near(0).hypot(near(1)), far(0).hypot(far(1))]
    }
}

/// V and kappa.
struct Moved {
    alpha: f64,
    b: [f64; 2],
    kappa: f64,
}

fn middle([low, high]: Interval) -> f64 {
    0.5 * (low + high)
}

/// Half of an interval, and a little more for its rounding.
fn half([low, high]: Interval) -> f64 {
    0.5 * (high - low) + f64::EPSILON * (low.abs() + high.abs())
}

fn most([low, high]: Interval) -> f64 {
    low.abs().max(high.abs())
}

/// Cells under pressure that are worked out, with their images.
fn loaded<'a>(residual: &'a Residual) -> impl Iterator<Item = (isize, isize, f64)> + 'a {
    let field: &Field = residual.field;
    let [nx, ny] = field.grid.shape.map(|n| n as isize);
    let first = [0, 1].map(|m| if residual.halves[m] { field.grid.shape[m] as isize / 2 } else { 0 });
    (first[1]..ny)
        .flat_map(move |j| (first[0]..nx).map(move |i| (i, j, field.pressure(i, j))))
        .filter(|(_, _, p)| *p > 0.0)
}

impl Moved {
    /// By least squares over the cells under pressure. Where f is its own image so is what is moved.
    fn fitted(residual: &Residual) -> Option<Self> {
        let all = loaded(residual).count();
        let centre = residual.field.grid.extent().centre();
        let free: Vec<usize> = (0..2).filter(|m| !residual.halves[*m]).collect();
        let mut rows = Vec::new();
        let mut right = Vec::new();
        for (i, j, _) in loaded(residual).step_by(all.div_ceil(SAMPLES).max(1)) {
            let rect = residual.rect(i, j);
            let jet = residual.overlap.jet(&rect)?;
            let (at, slope) = (rect.centre(), jet.gradient.map(middle));
            let along = slope[0] * (at[0] - centre[0]) + slope[1] * (at[1] - centre[1]);
            rows.extend([1.0, along].into_iter().chain(free.iter().map(|m| -slope[*m])));
            right.push(middle(jet.value));
        }
        let columns = 2 + free.len();
        if right.len() < columns {
            return None;
        }
        let a = DMatrix::from_row_slice(right.len(), columns, &rows);
        let found = a.svd(true, true).solve(&DVector::from_vec(right), 1e-10).ok()?;
        let (kappa, alpha) = (found[0], found[1]);
        let mut b = centre.map(|c| alpha * c);
        free.iter().enumerate().for_each(|(n, m)| b[*m] += found[2 + n]);
        let usable = kappa > 0.0 && alpha > -1.0 && [kappa, alpha, b[0], b[1]].iter().all(|v| v.is_finite());
        usable.then_some(Self { alpha, b, kappa })
    }

    /// V in the middle of a rectangle.
    fn at(&self, rect: &Rect) -> [f64; 2] {
        let c = rect.centre();
        [0, 1].map(|m| self.b[m] - self.alpha * c[m])
    }

    /// <phi, p_h>, from below and from above.
    fn work(&self, residual: &Residual) -> Option<[f64; 2]> {
        let field = residual.field;
        let [a, b] = field.grid.spacing.map(|h| 0.5 * h);
        let (mut sum, mut open, mut size, mut count) = (0.0, 0.0, 0.0, 0);
        for (i, j, p) in loaded(residual) {
            let rect = residual.rect(i, j);
            let Jet { value, gradient, hessian, third } = residual.overlap.jet(&rect)?;
            if third != [[0.0; 2]; 4] {
                return None;
            }
            let v = self.at(&rect);
            let p = p * residual.images(i, j);
            // Over the cell x and y have the mean 0 and mean sizes a/2, b/2, their squares a^2/3, b^2/3, and |xy| has a b/4.
            let bend = (middle(hessian[0]) * a * a + middle(hessian[2]) * b * b) / 3.0;
            let terms =
                [middle(value), v[0] * middle(gradient[0]), v[1] * middle(gradient[1]), (0.5 - self.alpha) * bend];
            let in_doubt = hessian.map(half);
            let quadratic = (in_doubt[0] * a * a + in_doubt[2] * b * b) / 3.0 + 0.5 * a * b * in_doubt[1];
            let odd = 0.5 * a * (v[0].abs() * in_doubt[0] + v[1].abs() * in_doubt[1])
                + 0.5 * b * (v[0].abs() * in_doubt[1] + v[1].abs() * in_doubt[2]);
            let ends = half(value) + v[0].abs() * half(gradient[0]) + v[1].abs() * half(gradient[1]);
            sum += p * (terms.iter().sum::<f64>() - self.kappa);
            open += p * (ends + odd + (0.5 + self.alpha.abs()) * quadratic);
            size += p * (terms.iter().map(|t| t.abs()).sum::<f64>() + self.kappa);
            count += 1;
        }
        let open = open * (1.0 + ROUNDING) + size * f64::EPSILON * f64::from(count + 64);
        let area = field.grid.cell_area();
        let [low, high] = [area * (sum - open), area * (sum + open)];
        (low.is_finite() && high.is_finite()).then(|| [low - ROUNDING * low.abs(), high + ROUNDING * high.abs()])
    }

    /// Bound of a(w, w) <= |w| |grad w|/2 for w = chi phi, chi = 1 in an ellipse and 0 outside a larger one.
    fn energy(&self, overlap: &dyn OverlapBounds, around: &Ellipse) -> Option<f64> {
        BEYOND.into_iter().filter_map(|beyond| self.energy_within(overlap, around, beyond)).reduce(f64::min)
    }

    fn energy_within(&self, overlap: &dyn OverlapBounds, around: &Ellipse, beyond: f64) -> Option<f64> {
        let Ellipse { centre, half } = *around;
        let lattice = Grid::over(&Rect::around(centre, half.map(|a| a * (1.0 + beyond))), [LATTICE; 2]);
        let steepest = 1.0 / (beyond * half[0].min(half[1]));
        let (mut value, mut slope) = (0.0, 0.0);
        for k in 0..lattice.len() {
            let rect = lattice.cell(k % LATTICE, k / LATTICE).scaled(1.0 + 1e-9);
            let [nearest, furthest] = around.distances(&rect);
            let chi = 1.0 - ((nearest - 1.0) / beyond).max(0.0);
            if chi <= 0.0 {
                continue;
            }
            let [phi, steep] = self.range(overlap, &rect)?;
            let steep = steep * chi + if furthest <= 1.0 { 0.0 } else { phi * steepest };
            value += (phi * chi) * (phi * chi);
            slope += steep * steep;
        }
        let bound = 0.5 * lattice.cell_area() * (value * slope).sqrt() * (1.0 + 1e-8);
        bound.is_finite().then_some(bound)
    }

    /// Bounds of |phi| and |grad phi| over a rectangle: grad phi = (1 - alpha) grad f + H V.
    fn range(&self, overlap: &dyn OverlapBounds, rect: &Rect) -> Option<[f64; 2]> {
        let Jet { value, gradient, hessian, third } = overlap.jet(rect)?;
        if third != [[0.0; 2]; 4] {
            return None;
        }
        let ([w, h], v) = (rect.size(), self.at(rect));
        let (a, b) = (0.5 * w, 0.5 * h);
        let centre = middle(value) + v[0] * middle(gradient[0]) + v[1] * middle(gradient[1]) - self.kappa;
        let rounding =
            ROUNDING * (most(value) + v[0].abs() * most(gradient[0]) + v[1].abs() * most(gradient[1]) + self.kappa);
        let off = half(value) + v[0].abs() * half(gradient[0]) + v[1].abs() * half(gradient[1]) + rounding;
        // The slopes in the middle by sign, and what they may be besides.
        let [xx, xy, yy] = hessian;
        let own = 1.0 - self.alpha;
        let straight = |g: Interval, p: Interval, q: Interval| {
            let at_centre = own * middle(g) + middle(p) * v[0] + middle(q) * v[1];
            let doubt = own.abs() * half(g) + half(p) * v[0].abs() + half(q) * v[1].abs();
            // (1 - alpha) H x - alpha H x, each with an H of its own.
            let turn = |h: Interval| (own - self.alpha).abs() * most(h) + (own.abs() + self.alpha.abs()) * half(h);
            (at_centre.abs(), doubt, turn(p) * a + turn(q) * b)
        };
        let ((sx, dx, ax), (sy, dy, ay)) = (straight(gradient[0], xx, xy), straight(gradient[1], xy, yy));
        let steep = [sx + dx + ax, sy + dy + ay].map(|s| s * (1.0 + ROUNDING));
        let phi = centre.abs() + off + steep[0] * a + steep[1] * b;
        Some([phi, steep[0].hypot(steep[1]) * (1.0 + ROUNDING)])
    }
}
