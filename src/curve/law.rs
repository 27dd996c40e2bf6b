//! ln P over ln s through solved states: the form in which a few states say most.
//!
//! P(s) runs from one power of the overlap s to another, so ln P is nearly straight in ln s: cubic Hermite pieces with
//! the exact slopes m = s P'/P are exact for powers and of fourth order in the ratio of neighbouring overlaps between
//! them. States are added where the law misses a new one.
//!
//! A grid knows the force to second order in its cells and the slope, which jumps whenever a row of cells comes into contact, to
//! first: the slopes are taken, within their doubt, where they bend the law least. The values then tell them to one another.

use super::Sample;
use crate::solution::Unsolved;

/// Share of a miss in the middle of an interval that is left in its halves: 1/16 where the law is smooth.
const LEFT: f64 = 0.2;

/// What terms beyond the fourth degree are allowed to add to it.
const HIGHER: f64 = 1.5;

/// Equal ratios that the range is divided into before any interval is judged.
const FIRST: usize = 4;

/// Relative doubt of a slope from a grid whose force is in error by e: this times e^(1/2). Measured on pyramids, cones, two tips
/// and a rounded cone at e from 1e-6 to 1e-4, the true share is below 0.17.
const DOUBT_OF_SLOPES: f64 = 0.2;

/// Sweeps over the slopes: each leaves less than a quarter of the error before it.
const SWEEPS: usize = 24;

/// The states by overlap, and how well they determine what lies between.
pub(super) struct Law {
    /// s, P, m = d ln P/d ln s.
    knots: Vec<[f64; 3]>,
    /// Relative doubt of each slope.
    doubts: Vec<f64>,
    /// Estimate of the largest relative error between the states, theirs included.
    pub error: f64,
}

/// What a bisection found: relative miss of the state in the middle, and how much of it their own errors can explain.
#[derive(Clone, Copy)]
struct Miss {
    missed: f64,
    doubt: f64,
}

impl Law {
    /// States from `from` to `to` until what lies between them is known to `accuracy`, or `most` of them are solved; `doubt` is the
    /// part of a state's error that differs from one to the next.
    pub fn solved(
        [from, to]: [f64; 2],
        accuracy: f64,
        most: usize,
        first_touch: f64,
        doubt: impl Fn(&Sample) -> f64,
        mut solve: impl FnMut(f64) -> Result<Sample, Unsolved>,
    ) -> Result<(Self, Vec<Sample>), Unsolved> {
        // Deepest first: it may serve all.
        let deepest = solve(to)?;
        let mut states = Vec::with_capacity(2 * FIRST);
        for k in 0..FIRST {
            states.push(solve(from * (to / from).powf(k as f64 / FIRST as f64))?);
        }
        states.push(deepest);
        // One an interval: what was found when it was halved last.
        let mut found = vec![Miss { missed: 0.0, doubt: 0.0 }; FIRST];
        loop {
            let law = Self::through(&states, first_touch);
            let noise = |k: usize| doubt(&states[k]).max(doubt(&states[k + 1]));
            let open = |k: usize| {
                let by_halving = LEFT * (found[k].missed - found[k].doubt);
                // A state's error takes part in a neighbour's extrapolation with a share below this.
                let narrow = law.knots[k + 1][0] < (1.0 + 1e-6) * law.knots[k][0];
                let open = by_halving.max(law.unseen(k) - noise(k)).max(law.unsure(k));
                // More states do not know more than each of them.
                if narrow || open <= noise(k) { 0.0 } else { open }
            };
            let widest = (0..found.len()).max_by(|&a, &b| open(a).total_cmp(&open(b))).unwrap_or(0);
            if open(widest) <= accuracy || states.len() >= most {
                let own = states.iter().filter_map(|s| s.force_error).fold(0.0, f64::max);
                let left = |k: usize| (LEFT * found[k].missed).max(law.unseen(k)).max(law.unsure(k));
                let between = (0..found.len()).map(left).fold(0.0, f64::max);
                return Ok((Self { error: own + between, ..law }, states));
            }
            let s = (law.knots[widest][0] * law.knots[widest + 1][0]).sqrt();
            let state = solve(s)?;
            let miss = Miss { missed: (law.at(s)[0] / state.force).ln().abs(), doubt: doubt(&state) + noise(widest) };
            states.insert(widest + 1, state);
            found[widest] = miss;
            found.insert(widest, miss);
        }
    }

    /// Estimate of the error in the middle of an interval, from its neighbours: with h its width and c a state beside it,
    /// the term of fourth degree, (h/2)^4 q, that y(c) or y'(c) asks for on top of the cubic piece y3,
    /// q = (y - y3)/[(c - a)^2 (c - b)^2] = (y' - y3')/[2 (c - a)(c - b)(2 c - a - b)].
    fn unseen(&self, k: usize) -> f64 {
        let ([a, b], [pa, _]) = ([self.knots[k][0], self.knots[k + 1][0]], [self.knots[k][1], self.knots[k + 1][1]]);
        let h = (b / a).ln();
        let beside = [k.checked_sub(1), Some(k + 2)];
        let terms = beside.into_iter().flatten().filter_map(|n| self.knots.get(n)).map(|&[c, p, m]| {
            let [rise, slope] = self.piece(k, c);
            let (u, v) = ((c / a).ln(), (c / b).ln());
            let by_value = ((p / pa).ln() - rise).abs() / (u * v).powi(2);
            let by_slope = (m - slope).abs() / (2.0 * u * v * (u + v)).abs();
            by_value.max(by_slope)
        });
        HIGHER * (0.5 * h).powi(4) * terms.fold(0.0, f64::max)
    }

    /// What the slopes leave open in the middle of an interval, h/8 of the difference of their errors.
    fn unsure(&self, k: usize) -> f64 {
        let ([a, _, m], [b, _, n]) = (self.knots[k], self.knots[k + 1]);
        (b / a).ln() * (m * self.doubts[k]).max(n * self.doubts[k + 1]) / 8.0
    }

    fn through(states: &[Sample], first_touch: f64) -> Self {
        let given: Vec<[f64; 3]> = states
            .iter()
            .map(|state| {
                let s = state.depth - first_touch;
                // Convex from zero: P' is at least P/s.
                [s, state.force, (state.stiffness * s / state.force).max(1.0)]
            })
            .collect();
        let doubts: Vec<f64> =
            states.iter().map(|state| DOUBT_OF_SLOPES * state.force_error.unwrap_or(0.0).sqrt()).collect();
        let mut law = Self { knots: given.clone(), doubts: doubts.clone(), error: 0.0 };
        for _ in 0..SWEEPS {
            for k in 1..given.len() - 1 {
                let m = given[k][2];
                law.knots[k][2] = law.smooth(k).max(m * (1.0 - doubts[k])).min(m * (1.0 + doubts[k])).max(1.0);
            }
        }
        law
    }

    /// The slope in an inner knot that bends the law least: its second derivative does not jump there.
    fn smooth(&self, k: usize) -> f64 {
        let between = |a: [f64; 3], b: [f64; 3]| ((b[0] / a[0]).ln(), (b[1] / a[1]).ln());
        let [before, here, after] = [self.knots[k - 1], self.knots[k], self.knots[k + 1]];
        let ((h, rise), (i, climb)) = (between(before, here), between(here, after));
        let (left, right) = (3.0 * rise / h - before[2], 3.0 * climb / i - after[2]);
        0.5 * (left * i + right * h) / (h + i)
    }

    /// The cubic piece between states k and k + 1, within or beyond them: ln P less that of state k, and its slope.
    fn piece(&self, k: usize, s: f64) -> [f64; 2] {
        let ([sa, pa, ma], [sb, pb, mb]) = (self.knots[k], self.knots[k + 1]);
        let (h, rise) = ((sb / sa).ln(), (pb / pa).ln());
        let t = (s / sa).ln() / h;
        let u = 1.0 - t;
        let y = u * u * t * h * ma + t * t * ((1.0 + 2.0 * u) * rise - u * h * mb);
        let m = 6.0 * t * u * rise / h + u * (u - 2.0 * t) * ma + t * (t - 2.0 * u) * mb;
        [y, m]
    }

    /// Force and slope at overlap `s` within the range.
    pub fn at(&self, s: f64) -> [f64; 2] {
        let k = self.knots.partition_point(|knot| knot[0] < s).clamp(1, self.knots.len() - 1) - 1;
        let [rise, m] = self.piece(k, s);
        let force = self.knots[k][1] * rise.exp();
        [force, m * force / s]
    }

    /// `pieces` of equal ratio in every interval: overlap, force, slope.
    pub fn sampled(&self, pieces: usize) -> Vec<[f64; 3]> {
        let mut rows = Vec::with_capacity(pieces * self.knots.len());
        for pair in self.knots.windows(2) {
            let ([sa, pa, ma], ratio) = (pair[0], pair[1][0] / pair[0][0]);
            rows.push([sa, pa, ma * pa / sa]);
            for j in 1..pieces {
                let s = sa * ratio.powf(j as f64 / pieces as f64);
                let [force, slope] = self.at(s);
                rows.push([s, force, slope]);
            }
        }
        rows.extend(self.knots.last().map(|&[s, force, m]| [s, force, m * force / s]));
        rows
    }
}
