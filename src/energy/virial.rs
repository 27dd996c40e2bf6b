//! Linear functionals of the exact pressure from what moves it: translations, a rotation, a dilation.
//!
//! Of all pressures the exact one gives <f, p> - <p, S p>/2 its largest value U, also of those that are moved along the surface or
//! dilated. Moved or turned, S does the same: <W . grad f, p> = 0. Dilated by 1 + e, <p, S p> grows by (1 + e)^3: <x . grad f, p> = -U.
//! (Curves on which f has kinks carry no load: they have no capacity.) With <f, p> = 2 U, for any mu and any W = b + beta x + omega J x, J the
//! quarter turn, and any function eta,
//!
//!   <eta, p> = (2 mu - beta) U + <T, p>,   T = eta - mu f - W . grad f.                                                  (6)
//!
//! A gap that is homogeneous of degree k about a point leaves T = 0 for eta = 1: P (d - g0) = (2 + 1/k) U. Of any other mu and W are
//! those that make T small on the contact, and most where the pressure ends: what is left there widens the bounds of <T, p> most
//! ([`super::functional`]).

use nalgebra::{DMatrix, DVector};

use super::overlap::{Interval, Jet, OverlapBounds};
use super::residual::{Quarter, Residual, loaded};
use crate::gap::Taylor;
use crate::numeric;
use crate::numeric::geometry::Rect;

/// Cells that tell what makes T small.
const SAMPLES: usize = 256;

/// Of a mean pressure, what is added to that of a cell before its weight is the inverse of it.
const AT_END: f64 = 0.05;

/// Singular values that are left out, over the largest.
const DEPENDENT: f64 = 1e-7;

/// T of the size of this share of eta is worth no more than none.
const SMALL: f64 = 0.7;

/// What a few hundred products and sums may change a bound by, relative to the size of what is added.
const ROUNDING: f64 = 1e-12;

/// eta = eta_0 + eta_1 x + eta_2 y, mu and W, x from `centre`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Virial {
    pub eta: [f64; 3],
    centre: [f64; 2],
    mu: f64,
    b: [f64; 2],
    beta: f64,
    omega: f64,
    /// Size of T on the contact over that of eta.
    pub left: f64,
}

fn middle([low, high]: Interval) -> f64 {
    0.5 * (low + high)
}

fn set([low, high]: Interval) -> numeric::Interval {
    numeric::Interval::new(low, high)
}

fn point(value: f64) -> numeric::Interval {
    numeric::Interval::point(value)
}

impl Virial {
    /// T = eta.
    pub fn plain(residual: &Residual, eta: [f64; 3]) -> Self {
        let centre = residual.field.grid.extent().centre();
        Self { eta, centre, mu: 0.0, b: [0.0; 2], beta: 0.0, omega: 0.0, left: 1.0 }
    }

    pub fn is_plain(&self) -> bool {
        self.mu == 0.0 && self.beta == 0.0 && self.omega == 0.0 && self.b == [0.0; 2]
    }

    /// Factor of U in (6).
    pub fn per_energy(&self) -> f64 {
        2.0 * self.mu - self.beta
    }

    /// By least squares over the cells under pressure, or plain where f is not smooth on all that is or may be under pressure (`touch`).
    /// Where f is its own image so is what is moved.
    pub fn fitted(residual: &Residual, eta: [f64; 3], touch: &[Quarter]) -> Self {
        let plain = Self::plain(residual, eta);
        let found = if plain.may_move(residual, touch) { plain.least_squares(residual) } else { None };
        found.filter(|found| found.left < SMALL).unwrap_or(plain)
    }

    /// Whether f is smooth on the contact, which ends before the material does.
    fn may_move(&self, residual: &Residual, touch: &[Quarter]) -> bool {
        let smooth = |i: isize, j: isize| residual.overlap.jet(&residual.rect(i, j)).is_some();
        let around = if residual.overlap.ends() { 1 } else { 0 };
        let all = |i: isize, j: isize| (-around..=around).all(|b| (-around..=around).all(|a| smooth(i + a, j + b)));
        loaded(residual).all(|(i, j, _)| all(i, j)) && touch.iter().all(|(i, j, _)| all(*i, *j))
    }

    fn least_squares(self, residual: &Residual) -> Option<Self> {
        let count = loaded(residual).count();
        let mean = loaded(residual).map(|(_, _, p)| p).sum::<f64>() / count as f64;
        let free: Vec<usize> = (0..2).filter(|m| !residual.halves[*m]).collect();
        let turns = free.len() == 2;
        let columns = 2 + free.len() + usize::from(turns);
        let (mut rows, mut right, mut size, mut samples) = (Vec::new(), Vec::new(), 0.0, 0);
        for (i, j, p) in loaded(residual).step_by(count.div_ceil(SAMPLES).max(1)) {
            let rect = residual.rect(i, j);
            let jet = residual.overlap.jet(&rect)?;
            let [x, y] = self.from_centre(&rect);
            let [fx, fy] = jet.gradient.map(middle);
            let weight = (1.0 / (p / mean + AT_END)).sqrt();
            let own = weight * (self.eta[0] + self.eta[1] * x + self.eta[2] * y);
            rows.extend([middle(jet.value), x * fx + y * fy].map(|v| weight * v));
            rows.extend(free.iter().map(|m| weight * [fx, fy][*m]));
            if turns {
                rows.push(weight * (x * fy - y * fx));
            }
            right.push(own);
            size += own * own;
            samples += 1;
        }
        if samples < 2 * columns {
            return None;
        }
        let mut a = DMatrix::from_row_slice(samples, columns, &rows);
        let scales: Vec<f64> = a.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
        a.column_iter_mut().zip(&scales).for_each(|(mut c, s)| c /= *s);
        let right = DVector::from_vec(right);
        let found = a.clone().svd(true, true).solve(&right, DEPENDENT).ok()?;
        let left = ((a * &found - right).norm_squared() / size).sqrt();
        let c: Vec<f64> = found.iter().zip(&scales).map(|(c, s)| c / s).collect();
        let mut b = [0.0; 2];
        free.iter().enumerate().for_each(|(n, m)| b[*m] = c[2 + n]);
        let omega = if turns { c[4] } else { 0.0 };
        let all = c.iter().all(|c| c.is_finite()) && left.is_finite();
        all.then_some(Self { mu: c[0], beta: c[1], b, omega, left, ..self })
    }

    fn from_centre(&self, rect: &Rect) -> [f64; 2] {
        let c = rect.centre();
        [0, 1].map(|m| c[m] - self.centre[m])
    }

    /// W in the middle of a rectangle.
    fn motion(&self, [x, y]: [numeric::Interval; 2]) -> [numeric::Interval; 2] {
        let (beta, omega) = (point(self.beta), point(self.omega));
        [point(self.b[0]) + beta * x - omega * y, point(self.b[1]) + beta * y + omega * x]
    }

    fn place(&self, rect: &Rect) -> [numeric::Interval; 2] {
        let c = rect.centre();
        [0, 1].map(|m| point(c[m]) - point(self.centre[m]))
    }

    fn eta_at(&self, [x, y]: [numeric::Interval; 2]) -> numeric::Interval {
        point(self.eta[0]) + point(self.eta[1]) * x + point(self.eta[2]) * y
    }

    /// T over a rectangle from f there: grad T(x) = grad eta - mu grad f - L' grad f - H W with grad f in g + E x, H in E and
    /// W = W(0) + L x, L = beta + omega J.
    fn target(&self, rect: &Rect, f: &Jet) -> Taylor {
        let at = self.place(rect);
        let [wx, wy] = self.motion(at);
        let ([gx, gy], [xx, xy, yy]) = (f.gradient.map(set), f.hessian.map(set));
        let (mu, beta, omega) = (point(self.mu), point(self.beta), point(self.omega));
        // L' E + E L = 2 beta E + omega (E J - J E).
        let more = mu + point(2.0) * beta;
        let turned = omega * (yy - xx);
        let two = point(2.0) * omega * xy;
        Taylor {
            value: self.eta_at(at) - mu * set(f.value) - (wx * gx + wy * gy),
            gradient: [
                point(self.eta[1]) - (mu + beta) * gx - omega * gy - (xx * wx + xy * wy),
                point(self.eta[2]) - (mu + beta) * gy + omega * gx - (xy * wx + yy * wy),
            ],
            hessian: [-(more * xx + two), -(more * xy + turned), -(more * yy - two)],
        }
    }

    /// T in the middle of a rectangle, nearly.
    pub fn nearly(&self, rect: &Rect, overlap: &dyn OverlapBounds) -> f64 {
        let [x, y] = self.from_centre(rect);
        let eta = self.eta[0] + self.eta[1] * x + self.eta[2] * y;
        let moved = |jet: Jet| {
            let [fx, fy] = jet.gradient.map(middle);
            let [wx, wy] = [self.b[0] + self.beta * x - self.omega * y, self.b[1] + self.beta * y + self.omega * x];
            self.mu * middle(jet.value) + wx * fx + wy * fy
        };
        eta - overlap.jet(rect).filter(|_| !self.is_plain()).map_or(0.0, moved)
    }

    /// Root of the mean square of eta over the cells under pressure.
    pub fn eta_on(&self, residual: &Residual) -> f64 {
        if self.eta[1] == 0.0 && self.eta[2] == 0.0 {
            return self.eta[0].abs();
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, j, _) in loaded(residual) {
            let [x, y] = self.from_centre(&residual.rect(i, j));
            sum += (self.eta[0] + self.eta[1] * x + self.eta[2] * y).powi(2);
            count += 1.0;
        }
        (sum / count).sqrt()
    }

    /// <T, p_h>, from below and from above.
    pub fn work(&self, residual: &Residual) -> Option<[f64; 2]> {
        let grid = &residual.field.grid;
        let [a, b] = grid.spacing.map(|h| point(0.5 * h));
        let third = numeric::Interval::new((1.0f64 / 3.0).next_down(), (1.0f64 / 3.0).next_up());
        let (x2, y2) = (third * a * a, third * b * b);
        // Of a function between -1 and 1 times x, y and x y.
        let unit = numeric::Interval::new(-1.0, 1.0);
        let (x, y, twist) = (unit * point(0.5) * a, unit * point(0.5) * b, unit * point(0.25) * a * b);
        let (mut sum, mut size, mut count) = ([0.0; 2], 0.0, 0);
        for (i, j, p) in loaded(residual) {
            let rect = residual.rect(i, j);
            let at = self.place(&rect);
            let mean = if self.is_plain() {
                self.eta_at(at)
            } else {
                let f = residual.overlap.jet(&rect).filter(|jet| jet.third == [[0.0; 2]; 4])?;
                let [wx, wy] = self.motion(at);
                let ([gx, gy], [xx, xy, yy]) = (f.gradient.map(set), f.hessian.map(set));
                let (mu, beta, omega) = (point(self.mu), point(self.beta), point(self.omega));
                let [dxx, dxy, dyy] = [xx, xy, yy].map(|h| point(0.5 * h.width()));
                let quadratic = xx * x2 + yy * y2;
                let of_f = set(f.value) + point(0.5) * quadratic + dxy * twist;
                let odd = (wx * dxx + wy * dxy) * x + (wx * dxy + wy * dyy) * y;
                let dilated = quadratic + point(2.0) * dxy * twist;
                let turned = xy * x2 - xy * y2 + (dxx + dyy) * twist;
                let moved = wx * gx + wy * gy + odd + beta * dilated + omega * turned;
                self.eta_at(at) - mu * of_f - moved
            };
            let p = p * residual.images(i, j);
            (sum[0], sum[1]) = (sum[0] + p * mean.lo, sum[1] + p * mean.hi);
            size += p * mean.magnitude();
            count += 1;
        }
        let rounding = size * f64::EPSILON * f64::from(count + 64);
        let area = grid.cell_area();
        let ends = [area * (sum[0] - rounding), area * (sum[1] + rounding)];
        let ends = [ends[0] - ROUNDING * ends[0].abs(), ends[1] + ROUNDING * ends[1].abs()];
        ends.iter().all(|end| end.is_finite()).then_some(ends)
    }
}

/// T, as a function that a displacement is held against; nothing has to lie above it.
pub(super) struct Target<'a> {
    pub virial: &'a Virial,
    pub overlap: &'a dyn OverlapBounds,
}

impl Target<'_> {
    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let f = if self.virial.is_plain() {
            Jet::default()
        } else {
            self.overlap.jet(rect).filter(|jet| jet.third == [[0.0; 2]; 4])?
        };
        self.virial.target(rect, &f).finite()
    }
}

fn ends(interval: numeric::Interval) -> Interval {
    [interval.lo, interval.hi]
}

/// What no bound is known of.
const UNKNOWN: Interval = [f64::NEG_INFINITY, f64::INFINITY];

impl OverlapBounds for Target<'_> {
    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Interval {
        self.taylor(rect).map_or(UNKNOWN, |taylor| taylor.bounds(rect.size(), slope))
    }

    fn slopes(&self, rect: &Rect) -> [Interval; 2] {
        self.taylor(rect).map_or([UNKNOWN; 2], |taylor| taylor.slopes(rect.size()).map(ends))
    }

    fn jet(&self, rect: &Rect) -> Option<Jet> {
        let Taylor { value, gradient, hessian } = self.taylor(rect)?;
        Some(Jet { value: ends(value), gradient: gradient.map(ends), hessian: hessian.map(ends), third: [[0.0; 2]; 4] })
    }

    fn mean(&self, rect: &Rect) -> Interval {
        self.taylor(rect).map_or(UNKNOWN, |taylor| ends(taylor.mean(rect.size())))
    }

    fn ends(&self) -> bool {
        self.overlap.ends()
    }

    fn binds(&self) -> bool {
        false
    }

    /// What a cell leaves open of T is little beside what T leaves at the end of the pressure.
    fn is_worth_parts(&self) -> bool {
        false
    }

    fn reach(&self) -> Option<Rect> {
        None
    }

    fn has_time(&self) -> bool {
        self.overlap.has_time()
    }
}
