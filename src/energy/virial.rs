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

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};

use super::overlap::{self, Interval, Jet, OverlapBounds};
use super::parts::{Law, Parts};
use super::pressed::Pressed;
use super::residual::Quarter;
use crate::gap::{Taylor, half_sides};
use crate::numeric;
use crate::numeric::geometry::Rect;

/// Cells that tell what makes T small.
const SAMPLES: usize = 384;

/// Of a mean pressure, what is added to that of a cell before its weight is the inverse of it.
const AT_END: f64 = 0.3;

/// Cells along the sides of the blocks that are looked at together.
const BLOCK: isize = 8;

/// Singular values that are left out, over the largest.
const DEPENDENT: f64 = 1e-7;

/// T of the size of this share of eta is worth no more than none.
const SMALL: f64 = 0.7;

/// Share of a cell by which it is widened to see across its sides.
const ACROSS: f64 = 1e-6;

/// What a few hundred products and sums may change a bound by, relative to the size of what is added.
const ROUNDING: f64 = 1e-12;

/// eta = eta_0 + eta_1 x + eta_2 y, mu and W, x and y from `centre`.
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

/// Whether a jet knows third derivatives, and not that there are none.
fn has_third(jet: &Jet) -> bool {
    jet.third != [[0.0; 2]; 4]
}

/// Whether what has no law is smooth on the contact, which ends before the material does: not so close to a tip that its slopes in a cell
/// are less certain than those of the contact are steep. Block by block, and cell by cell where that does not tell.
fn may_move(pressed: &Pressed, parts: &Parts, touch: &[Quarter]) -> bool {
    let steep = |&(i, j, _): &(isize, isize, f64)| {
        parts.smooth.nearly(&pressed.rect(i, j)).map_or(0.0, |(_, gradient)| gradient.map(f64::abs).into_iter().sum())
    };
    let steepest = pressed.cells.iter().map(steep).fold(0.0, f64::max);
    let smooth = |rect: &Rect| {
        let close = |jet: Jet| overlap::Taylor::of(&jet, rect.size().map(|side| 0.5 * side)).rest[1] <= steepest;
        parts.smooth.jet(rect).is_some_and(close)
    };
    let around = if parts.ends() { 1 } else { 0 };
    let ring =
        |i: isize, j: isize| (-around..=around).flat_map(move |b| (-around..=around).map(move |a| (i + a, j + b)));
    // Where one of several tips ends the gap jumps to the next, perhaps between two cells.
    let joined =
        |i: isize, j: isize| around == 0 || parts.smooth.jet(&pressed.rect(i, j).scaled(1.0 + ACROSS)).is_some();
    let cell_by_cell = |i: isize, j: isize| joined(i, j) && ring(i, j).all(|(i, j)| smooth(&pressed.rect(i, j)));
    let mut blocks = HashMap::new();
    let mut in_block = |i: isize, j: isize| {
        let block = [i, j].map(|n| n.div_euclid(BLOCK));
        *blocks.entry(block).or_insert_with(|| {
            let [first, last] = [0, BLOCK - 1].map(|n| block.map(|k| k * BLOCK + n));
            let corners =
                [pressed.rect(first[0] - around, first[1] - around), pressed.rect(last[0] + around, last[1] + around)];
            smooth(&corners[0].union(&corners[1]))
        })
    };
    let has_material = |i: isize, j: isize| {
        ring(i, j).all(|(i, j)| parts.laws.iter().all(|law| law.overlap.material(&pressed.rect(i, j))))
    };
    pressed.with(touch).all(|(i, j, _)| (in_block(i, j) || cell_by_cell(i, j)) && has_material(i, j))
}

impl Virial {
    /// T = eta = c_0 + c_1 x + c_2 y, x and y from the origin, without what is odd about a mirror.
    pub fn plain(pressed: &Pressed, c: [f64; 3]) -> Self {
        let centre = pressed.grid.extent().centre();
        let [x, y] = [0, 1].map(|m| if pressed.halves[m] { 0.0 } else { c[1 + m] });
        let eta = [c[0] + c[1] * centre[0] + c[2] * centre[1], x, y];
        Self { eta, centre, mu: 0.0, b: [0.0; 2], beta: 0.0, omega: 0.0, left: 1.0 }
    }

    /// The same eta from another centre.
    fn about(mut self, centre: [f64; 2]) -> Self {
        self.eta[0] += (0..2).map(|m| self.eta[1 + m] * (centre[m] - self.centre[m])).sum::<f64>();
        Self { centre, ..self }
    }

    pub fn is_plain(&self) -> bool {
        self.mu == 0.0 && self.beta == 0.0 && self.omega == 0.0 && self.b == [0.0; 2]
    }

    /// Factor of U in (6).
    pub fn per_energy(&self) -> f64 {
        2.0 * self.mu - self.beta
    }

    /// Factor of P in its derivative by the depth ([`super::stiffness`]).
    pub fn per_depth(&self) -> f64 {
        self.mu - self.beta
    }

    /// By least squares over the cells under pressure, or plain where what has no law is not smooth on all that is or may be under pressure
    /// (`touch`). Where f is its own image so is what is moved.
    pub fn fitted(pressed: &Pressed, parts: &Parts, c: [f64; 3], touch: &[Quarter]) -> Self {
        let plain = Self::plain(pressed, c);
        let about = plain.about(parts.centre.unwrap_or(plain.centre));
        let off_centre = (0..2).any(|m| pressed.halves[m] && !pressed.grid.is_centred_on(m, about.centre[m]));
        if off_centre || !may_move(pressed, parts, touch) {
            return plain;
        }
        about.least_squares(pressed, parts, touch).filter(|found| found.left < SMALL).unwrap_or(plain)
    }

    fn least_squares(self, pressed: &Pressed, parts: &Parts, touch: &[Quarter]) -> Option<Self> {
        let mean = pressed.cells.iter().map(|(_, _, p)| p).sum::<f64>() / pressed.cells.len() as f64;
        // A law is one about its centre alone.
        let free: Vec<usize> = (0..2).filter(|m| !pressed.halves[*m] && parts.laws.is_empty()).collect();
        let turns = free.len() == 2;
        let columns = 2 + free.len() + usize::from(turns);
        let (mut rows, mut right, mut size, mut samples) = (Vec::new(), Vec::new(), 0.0, 0);
        let all = pressed.with(touch).count();
        for (i, j, p) in pressed.with(touch).step_by(all.div_ceil(SAMPLES).max(1)) {
            let rect = pressed.rect(i, j);
            let (mut f, [fx, fy]) = parts.smooth.nearly(&rect)?;
            let [x, y] = self.off_centre(&rect);
            let mut dilated = x * fx + y * fy;
            for law in &parts.laws {
                let own = law.nearly(&rect);
                f += own - law.depth;
                dilated -= law.degree * (law.above - own);
            }
            let weight = (1.0 / (p / mean + AT_END)).sqrt();
            let own = weight * (self.eta[0] + self.eta[1] * x + self.eta[2] * y);
            rows.extend([f, dilated].map(|v| weight * v));
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

    fn mean_of_law(&self, law: &Law, rect: &Rect) -> numeric::Interval {
        let [constant, per] = self.of_law(law);
        constant - per * set(law.overlap.mean(rect))
    }

    fn off_centre(&self, rect: &Rect) -> [f64; 2] {
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
    /// W = W(0) + L x, L = beta + omega J. Where third derivatives are known H is that of the middle, and those of T over the rectangle
    /// - mu H - L' H - H L - W . grad H.
    fn target(&self, rect: &Rect, f: &Jet) -> Taylor {
        let at = self.place(rect);
        let [wx, wy] = self.motion(at);
        let ([gx, gy], [xx, xy, yy]) = (f.gradient.map(set), f.hessian.map(set));
        let (mu, beta, omega) = (point(self.mu), point(self.beta), point(self.omega));
        // L' E + E L = 2 beta E + omega (E J - J E).
        let more = mu + point(2.0) * beta;
        let bent = |[xx, xy, yy]: [numeric::Interval; 3]| {
            let (turned, two) = (omega * (yy - xx), point(2.0) * omega * xy);
            [-(more * xx + two), -(more * xy + turned), -(more * yy - two)]
        };
        let hessian = if has_third(f) {
            let (sides, t) = (half_sides(rect.size()), f.third.map(set));
            let over = [0, 1, 2].map(|n| [xx, xy, yy][n] + t[n] * sides[0] + t[n + 1] * sides[1]);
            let [wx, wy] = self.motion([0, 1].map(|m| at[m] + sides[m]));
            let own = bent(over);
            [0, 1, 2].map(|n| own[n] - (wx * t[n] + wy * t[n + 1]))
        } else {
            bent([xx, xy, yy])
        };
        Taylor {
            value: self.eta_at(at) - mu * set(f.value) - (wx * gx + wy * gy),
            gradient: [
                point(self.eta[1]) - (mu + beta) * gx - omega * gy - (xx * wx + xy * wy),
                point(self.eta[2]) - (mu + beta) * gy + omega * gx - (xy * wx + yy * wy),
            ],
            hessian,
        }
    }

    /// T in the middle of a rectangle, nearly.
    pub fn nearly(&self, rect: &Rect, parts: &Parts) -> f64 {
        let [x, y] = self.off_centre(rect);
        let eta = self.eta[0] + self.eta[1] * x + self.eta[2] * y;
        if self.is_plain() {
            return eta;
        }
        let Some((f, [fx, fy])) = parts.smooth.nearly(rect) else { return eta };
        let [wx, wy] = [self.b[0] + self.beta * x - self.omega * y, self.b[1] + self.beta * y + self.omega * x];
        let of_law =
            |law: &Law| self.mu * law.depth + self.beta * law.degree * law.above - self.per_law(law) * law.nearly(rect);
        eta - self.mu * f - wx * fx - wy * fy + parts.laws.iter().map(of_law).sum::<f64>()
    }

    /// mu + beta k, the factor of a part of the gap that follows a law of degree k, in T.
    fn per_law(&self, law: &Law) -> f64 {
        self.mu + self.beta * law.degree
    }

    /// T = what the smooth part leaves + sum of mu (d - f_j) + beta k_j (d - g0_j - f_j) over parts f_j = d - g_j with laws: what does not
    /// depend on the place, and the factor of -f_j.
    fn of_law(&self, law: &Law) -> [numeric::Interval; 2] {
        let (mu, steep) = (point(self.mu), point(self.beta) * point(law.degree));
        [mu * point(law.depth) + steep * set(law.above_ends()), mu + steep]
    }

    /// <T, p_h>, from below and from above.
    pub fn work(&self, pressed: &Pressed, parts: &Parts) -> Option<[f64; 2]> {
        let grid = &pressed.grid;
        let [a, b] = grid.spacing.map(|h| point(0.5 * h));
        let third = numeric::Interval::new((1.0f64 / 3.0).next_down(), (1.0f64 / 3.0).next_up());
        let (x2, y2) = (third * a * a, third * b * b);
        // Of a function between -1 and 1 times x, y and x y.
        let unit = numeric::Interval::new(-1.0, 1.0);
        let (x, y, twist) = (unit * point(0.5) * a, unit * point(0.5) * b, unit * point(0.25) * a * b);
        let (mut sum, mut size, mut count) = ([0.0; 2], 0.0, 0);
        for &(i, j, p) in &pressed.cells {
            let rect = pressed.rect(i, j);
            let at = self.place(&rect);
            let mean = if self.is_plain() {
                self.eta_at(at)
            } else {
                let f = parts.smooth.jet(&rect)?;
                let smooth = if has_third(&f) {
                    self.target(&rect, &f).mean(rect.size())
                } else {
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
                parts.laws.iter().fold(smooth, |sum, law| sum + self.mean_of_law(law, &rect))
            };
            let p = p * pressed.images(i, j);
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
    pub parts: &'a Parts<'a>,
}

impl Target<'_> {
    /// What the smooth part leaves.
    fn of_smooth(&self, rect: &Rect) -> Option<Taylor> {
        let f = if self.virial.is_plain() { Jet::default() } else { self.parts.smooth.jet(rect)? };
        self.virial.target(rect, &f).finite()
    }

    fn laws(&self) -> &[Law<'_>] {
        if self.virial.is_plain() { &[] } else { &self.parts.laws }
    }

    /// Where laws are smooth, too.
    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let mut taylor = self.of_smooth(rect)?;
        for law in self.laws() {
            let (own, [constant, per]) = (law.overlap.jet(rect)?, self.virial.of_law(law));
            taylor.value = taylor.value + constant - per * set(own.value);
            (0..2).for_each(|m| taylor.gradient[m] = taylor.gradient[m] - per * set(own.gradient[m]));
            (0..3).for_each(|n| taylor.hessian[n] = taylor.hessian[n] - per * set(own.hessian[n]));
        }
        taylor.finite()
    }
}

fn ends(interval: numeric::Interval) -> Interval {
    [interval.lo, interval.hi]
}

/// What no bound is known of.
const UNKNOWN: Interval = [f64::NEG_INFINITY, f64::INFINITY];

impl OverlapBounds for Target<'_> {
    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Interval {
        if let Some(taylor) = self.taylor(rect) {
            return taylor.bounds(rect.size(), slope);
        }
        let Some(smooth) = self.of_smooth(rect) else { return UNKNOWN };
        // Every law is compared with its own mean slope.
        let (mut left, mut sum) = (slope, numeric::Interval::ZERO);
        for law in self.laws() {
            let [constant, per] = self.virial.of_law(law);
            let own = law.overlap.slopes(rect).map(middle);
            if !own.iter().all(|s| s.is_finite()) {
                return UNKNOWN;
            }
            sum = sum + constant - per * set(law.overlap.bounds(rect, own));
            // What the middle of a factor leaves open is rounding, and counts over the rectangle.
            let [w, h] = rect.size();
            let rounding = per.width() * (own[0].abs() * w + own[1].abs() * h);
            sum = sum + numeric::Interval::new(-rounding, rounding);
            (0..2).for_each(|m| left[m] += per.middle() * own[m]);
        }
        ends(set(smooth.bounds(rect.size(), left)) + sum)
    }

    fn slopes(&self, rect: &Rect) -> [Interval; 2] {
        let Some(smooth) = self.of_smooth(rect) else { return [UNKNOWN; 2] };
        let mut slopes = smooth.slopes(rect.size());
        for law in self.laws() {
            let ([_, per], own) = (self.virial.of_law(law), law.overlap.slopes(rect));
            (0..2).for_each(|m| slopes[m] = slopes[m] - per * set(own[m]));
        }
        slopes.map(ends)
    }

    fn jet(&self, rect: &Rect) -> Option<Jet> {
        let Taylor { value, gradient, hessian } = self.taylor(rect)?;
        Some(Jet { value: ends(value), gradient: gradient.map(ends), hessian: hessian.map(ends), third: [[0.0; 2]; 4] })
    }

    fn mean(&self, rect: &Rect) -> Interval {
        let Some(smooth) = self.of_smooth(rect) else { return UNKNOWN };
        ends(self.laws().iter().fold(smooth.mean(rect.size()), |sum, law| sum + self.virial.mean_of_law(law, rect)))
    }

    fn ends(&self) -> bool {
        self.parts.ends()
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
        self.parts.smooth.has_time()
    }
}
