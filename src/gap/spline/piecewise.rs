//! A function of one variable: cubic between knots, known by its Bernstein coefficients.

use std::ops::RangeInclusive;

use super::bernstein::{self, ROUNDING};
use super::{Ends, slopes};
use crate::gap::extremes::Extremes;
use crate::numeric::Interval;

/// With more pieces than this the extremes of blocks stand for them.
const MANY: usize = 64;

/// Rounding that does not take a point off the line, in steps.
const AT_END: f64 = 1e-9;

/// Halvings of a piece that looks for where it leaves a depth.
const HALVINGS: usize = 30;

/// Cubic between knots, continuous; no value outside.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::gap) struct PiecewiseCubic {
    knots: Vec<f64>,
    /// Bernstein coefficients of each piece.
    pieces: Vec<[f64; 4]>,
    /// Whether slopes are continuous.
    smooth: bool,
    extremes: Extremes,
}

impl PiecewiseCubic {
    /// The cubic spline through these values at rising knots, at least two.
    pub fn spline(knots: Vec<f64>, values: &[f64], ends: Ends) -> Self {
        let slopes = slopes(&knots, values, ends);
        let piece = |k: usize| {
            let h = knots[k + 1] - knots[k];
            bernstein::cubic([values[k], values[k + 1]], [slopes[k] * h, slopes[k + 1] * h])
        };
        let pieces = (0..knots.len() - 1).map(piece).collect();
        Self::of(knots, pieces, true)
    }

    /// Straight lines between these values.
    pub fn straight(knots: Vec<f64>, values: &[f64]) -> Self {
        let piece = |w: &[f64]| bernstein::cubic([w[0], w[1]], [w[1] - w[0]; 2]);
        let pieces = values.windows(2).map(piece).collect();
        Self::of(knots, pieces, false)
    }

    fn of(knots: Vec<f64>, pieces: Vec<[f64; 4]>, smooth: bool) -> Self {
        let extremes = Extremes::new([pieces.len(), 1], |k, _| Some(bernstein::range(&pieces[k])));
        Self { knots, pieces, smooth, extremes }
    }

    /// With this number added everywhere.
    pub fn raised(mut self, by: f64) -> Self {
        self.pieces.iter_mut().flatten().for_each(|b| *b += by);
        Self::of(self.knots, self.pieces, self.smooth)
    }

    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    pub fn is_smooth(&self) -> bool {
        self.smooth
    }

    /// First and last knot.
    pub fn ends(&self) -> [f64; 2] {
        [self.knots[0], self.knots[self.knots.len() - 1]]
    }

    fn step(&self, k: usize) -> f64 {
        self.knots[k + 1] - self.knots[k]
    }

    /// What counts as on the line beyond its ends.
    fn slack(&self) -> [f64; 2] {
        [AT_END * self.step(0), AT_END * self.step(self.pieces.len() - 1)]
    }

    /// The piece that holds a point, and the place in it.
    fn locate(&self, q: f64) -> Option<(usize, f64)> {
        let ([first, last], [before, after]) = (self.ends(), self.slack());
        if !(q >= first - before && q <= last + after) {
            return None;
        }
        let k = self.knots.partition_point(|&knot| knot <= q).clamp(1, self.pieces.len()) - 1;
        Some((k, ((q - self.knots[k]) / self.step(k)).clamp(0.0, 1.0)))
    }

    /// The value; infinite off the line.
    pub fn value(&self, q: f64) -> f64 {
        self.locate(q).map_or(f64::INFINITY, |(k, t)| bernstein::value(&self.pieces[k], t))
    }

    /// The slope, at a kink that of the piece after it; `None` off the line.
    pub fn slope(&self, q: f64) -> Option<f64> {
        self.locate(q).map(|(k, t)| bernstein::value(&bernstein::slope(&self.pieces[k]), t) / self.step(k))
    }

    /// Pieces that an interval touches; `None` off the line.
    fn touched(&self, [a, b]: [f64; 2]) -> Option<RangeInclusive<usize>> {
        let ([first, last], [before, after]) = (self.ends(), self.slack());
        if b < first - before || a > last + after {
            return None;
        }
        let of = |q: f64| self.knots.partition_point(|&knot| knot <= q).clamp(1, self.pieces.len()) - 1;
        // A point that rounding may move over a knot touches both sides.
        let near = 4.0 * f64::EPSILON * (a.abs() + b.abs());
        Some(of(a - near)..=of(b + near))
    }

    /// Whether an interval lies on the line, but for rounding.
    fn holds(&self, [a, b]: [f64; 2]) -> bool {
        let ([first, last], [before, after]) = (self.ends(), self.slack());
        a >= first - before && b <= last + after
    }

    /// The part of piece k that an interval covers, and what rounding of places may do to values in it.
    fn part(&self, k: usize, [a, b]: [f64; 2]) -> ([f64; 2], f64) {
        let (from, step) = (self.knots[k], self.step(k));
        let place = [a, b].map(|q| ((q - from) / step).clamp(0.0, 1.0));
        let moved = 4.0 * f64::EPSILON * (a.abs().max(b.abs()) + from.abs()) / step;
        (place, moved.min(1.0) * bernstein::largest(&bernstein::slope(&self.pieces[k])))
    }

    /// Bounds of the function less slope (q - middle) over an interval: infinite above where a part of it is off the line.
    pub fn bounds(&self, interval: [f64; 2], slope: f64) -> [f64; 2] {
        let [a, b] = interval;
        let Some(touched) = self.touched(interval) else { return [f64::INFINITY; 2] };
        let (middle, width) = (0.5 * (a + b), b - a);
        let mut bounds = if touched.end() - touched.start() >= MANY {
            let [low, high] = self.extremes.over([[*touched.start(), *touched.end()], [0, 0]]);
            let half = 0.5 * slope.abs() * width;
            let room = ROUNDING * (low.abs().max(high.abs()) + half);
            [low - half - room, high + half + room]
        } else {
            let mut all = [f64::INFINITY, f64::NEG_INFINITY];
            for k in touched {
                let ([u, v], moved) = self.part(k, interval);
                let mut b = bernstein::part(&self.pieces[k], [u, v]);
                let size = bernstein::largest(&self.pieces[k]) + slope.abs() * width;
                let at = |t: f64| self.knots[k] + self.step(k) * t - middle;
                let ends = [at(u), at(v)];
                for (n, b) in b.iter_mut().enumerate() {
                    let t = n as f64 / 3.0;
                    *b -= slope * (ends[0] * (1.0 - t) + ends[1] * t);
                }
                let places = 4.0 * f64::EPSILON * (self.knots[k].abs() + middle.abs()) * slope.abs();
                let room = ROUNDING * size + moved + places;
                let [low, high] = bernstein::range(&b);
                all = [all[0].min(low - room), all[1].max(high + room)];
            }
            all
        };
        if !self.holds(interval) {
            bounds[1] = f64::INFINITY;
        }
        bounds
    }

    /// Bounds of the slope wherever in an interval it exists; `None` where a part of it is off the line.
    pub fn slopes(&self, interval: [f64; 2]) -> Option<Interval> {
        self.derivative(interval, |piece, part| {
            let slope = bernstein::slope(piece);
            (bernstein::range(&bernstein::part(&slope, part)), bernstein::largest(&slope), 1)
        })
    }

    /// Bounds of the second derivative; `None` where slopes may jump, or where a part of the interval is off the line.
    pub fn curvatures(&self, interval: [f64; 2]) -> Option<Interval> {
        let one = self.touched(interval)?.count() == 1;
        (self.smooth || one).then_some(())?;
        self.derivative(interval, |piece, part| {
            let bend = bernstein::curvature(piece);
            // The coefficients of a cubic may cancel.
            (bernstein::range(&bernstein::part(&bend, part)), bernstein::largest(&bend) + bernstein::largest(piece), 2)
        })
    }

    fn derivative(
        &self,
        interval: [f64; 2],
        of: impl Fn(&[f64; 4], [f64; 2]) -> ([f64; 2], f64, i32),
    ) -> Option<Interval> {
        let [first, last] = self.ends();
        let touched = self.touched(interval)?;
        if interval[0] < first || interval[1] > last || touched.end() - touched.start() >= MANY {
            return None;
        }
        touched
            .map(|k| {
                let (part, _) = self.part(k, interval);
                let wide = 4.0 * f64::EPSILON * (interval[0].abs().max(interval[1].abs()) + self.knots[k].abs());
                let wide = wide / self.step(k);
                let part = [(part[0] - wide).max(0.0), (part[1] + wide).min(1.0)];
                let ([low, high], size, order) = of(&self.pieces[k], part);
                let room = ROUNDING * (size + bernstein::largest(&self.pieces[k]));
                let unit = Interval::point(self.step(k)).powi(order);
                Interval::new(low - room, high + room) / unit
            })
            .reduce(Interval::union)
    }

    /// Value and slope at a point, with what rounding may have done to them; `None` off the line.
    pub fn enclosed(&self, q: f64) -> Option<[Interval; 2]> {
        let [first, last] = self.ends();
        if !(q >= first && q <= last) {
            return None;
        }
        let near = 4.0 * f64::EPSILON * q.abs();
        let around = [(q - near).max(first), (q + near).min(last)];
        let [low, high] = self.bounds(around, 0.0);
        Some([Interval::new(low, high), self.slopes(around)?])
    }

    /// The mean over an interval, and what rounding may have done to it; infinite where a part of it is off the line.
    pub fn mean(&self, interval: [f64; 2]) -> [f64; 2] {
        let Some(touched) = self.touched(interval).filter(|_| self.holds(interval)) else {
            return [f64::INFINITY, 0.0];
        };
        let (mut sum, mut width, mut room) = (0.0, 0.0, 0.0);
        let mut size = 0.0_f64;
        for k in touched {
            let ([u, v], moved) = self.part(k, interval);
            let part = (v - u) * self.step(k);
            sum += part * 0.25 * bernstein::part(&self.pieces[k], [u, v]).iter().sum::<f64>();
            width += part;
            size = size.max(bernstein::largest(&self.pieces[k]));
            room += moved;
        }
        if width > 0.0 {
            return [sum / width, 2.0 * ROUNDING * size + 4.0 * room];
        }
        [self.value(0.5 * (interval[0] + interval[1])), 2.0 * ROUNDING * size + 4.0 * room]
    }

    /// A place where the function is least, the value there, and a number that it is nowhere less than.
    pub fn least(&self) -> (f64, f64, f64) {
        let mut best = (self.knots[0], self.pieces[0][0]);
        for (k, piece) in self.pieces.iter().enumerate() {
            for (t, value) in [(0.0, piece[0]), (1.0, piece[3])] {
                if value < best.1 {
                    best = (self.knots[k] + t * self.step(k), value);
                }
            }
        }
        // Level by level: what cannot be less than the best is dropped, the rest is halved.
        let mut bound = f64::INFINITY;
        let mut open: Vec<(usize, [f64; 2])> = (0..self.pieces.len()).map(|k| (k, [0.0, 1.0])).collect();
        while !open.is_empty() {
            for &(k, [u, v]) in &open {
                let middle = 0.5 * (u + v);
                let value = bernstein::value(&self.pieces[k], middle);
                if value < best.1 {
                    best = (self.knots[k] + middle * self.step(k), value);
                }
            }
            let mut halves = Vec::new();
            for (k, [u, v]) in open {
                let piece = &self.pieces[k];
                let [low, _] = bernstein::range(&bernstein::part(piece, [u, v]));
                let close = ROUNDING * bernstein::largest(piece);
                // NaN: beyond the range of numbers.
                if !(low < best.1 - close) || v - u < 1e-12 {
                    bound = bound.min(low - close);
                } else {
                    let middle = 0.5 * (u + v);
                    halves.extend([(k, [u, middle]), (k, [middle, v])]);
                }
            }
            open = halves;
        }
        (best.0, best.1, bound.min(best.1))
    }

    /// Groups of pieces next to each other that dip below a depth, each as an interval that holds all of its points below.
    pub fn below(&self, depth: f64) -> Vec<[f64; 2]> {
        let size = |piece: &[f64; 4]| ROUNDING * bernstein::largest(piece);
        let dips =
            |piece: &[f64; 4], part: [f64; 2]| bernstein::range(&bernstein::part(piece, part))[0] - size(piece) < depth;
        // The part of a piece from one side on that is certainly not below.
        let clear = |piece: &[f64; 4], from_left: bool| {
            let mut clear = 0.0;
            let mut rest = 1.0;
            for _ in 0..HALVINGS {
                rest *= 0.5;
                let part = if from_left { [clear, clear + rest] } else { [1.0 - clear - rest, 1.0 - clear] };
                if !dips(piece, part) {
                    clear += rest;
                }
            }
            clear
        };
        let mut found: Vec<[f64; 2]> = Vec::new();
        let mut open = false;
        for (k, piece) in self.pieces.iter().enumerate() {
            let dipped = dips(piece, [0.0, 1.0]);
            if dipped {
                let (from, step) = (self.knots[k], self.step(k));
                let near = AT_END * step;
                let start = from + step * clear(piece, true) - near;
                let end = from + step * (1.0 - clear(piece, false)) + near;
                match found.last_mut().filter(|_| open) {
                    Some(last) => last[1] = end,
                    None => found.push([start, end]),
                }
            }
            open = dipped;
        }
        found
    }
}
