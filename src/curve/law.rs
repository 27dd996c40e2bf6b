//! ln P over ln s through solved states: the form in which a few states say most.
//!
//! P(s) runs from one power of the overlap s to another, so ln P is nearly straight in ln s: cubic Hermite pieces with
//! the exact slopes m = s P'/P are exact for powers and of fourth order in the ratio of neighbouring overlaps between
//! them. States are added where the law misses a new one.
//!
//! A grid knows the force to second order in its cells and the slope, which jumps whenever a row of cells comes into contact, to
//! first: the slopes are taken, within their doubt, where they bend the law least. The values then tell them to one another.

use super::Sample;
use crate::numeric::cubic::Cubic;
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

/// Slope of what is left in the middle of an interval of width h, over that and h: 3.1 for t^2 (1 - t)^2, which is what a smooth law
/// leaves, and more where its second derivative jumps.
const SLOPE_OF_REST: f64 = 5.0;

/// Slope that errors of the values make, over the sum of two neighbouring ones and their distance, where slopes bend the law least:
/// 1.5 for errors that alternate, about 2.2 for the worst there are.
const SLOPE_OF_NOISE: f64 = 2.5;

/// The states by overlap, and how well they determine what lies between.
pub(super) struct Law {
    /// s, P, m = d ln P/d ln s.
    knots: Vec<[f64; 3]>,
    /// Relative doubt of each slope.
    doubts: Vec<f64>,
    /// Whether a slope is at an end, or where its doubt ends: the values alone do not tell it.
    held: Vec<bool>,
    /// Relative errors of the values that differ from one state to the next.
    noise: Vec<f64>,
    /// Estimates of the largest relative errors of force and slope in each interval between two states, those of the states included.
    pub errors: Vec<[f64; 2]>,
}

impl Law {
    /// States from `from` to `to` until what lies between them is known to `accuracy`, or `most` of them are solved; `doubt` is the
    /// part of a state's error that differs from one to the next. `solve` is asked for all overlaps of a round at once; `told` is
    /// given the states so far and what the widest interval leaves open.
    pub fn solved(
        [from, to]: [f64; 2],
        accuracy: f64,
        most: usize,
        first_touch: f64,
        doubt: impl Fn(&Sample) -> f64,
        mut solve: impl FnMut(&[f64]) -> Result<Vec<Sample>, Unsolved>,
        told: &mut dyn FnMut(usize, Option<f64>),
    ) -> Result<(Self, Vec<Sample>), Unsolved> {
        told(0, None);
        // Deepest first: it may serve all.
        let deepest = solve(&[to])?;
        told(1, None);
        let shallower: Vec<f64> = (0..FIRST).map(|k| from * (to / from).powf(k as f64 / FIRST as f64)).collect();
        let mut states = solve(&shallower)?;
        states.extend(deepest);
        // One an interval: how far the law missed the state in its middle when it was halved last, relative.
        let mut found = vec![0.0; states.len() - 1];
        loop {
            let law = Self::through(&states, first_touch, &doubt);
            let noise = |k: usize| law.noise[k].max(law.noise[k + 1]);
            let open = |k: usize| {
                let narrow = law.knots[k + 1][0] < (1.0 + 1e-6) * law.knots[k][0];
                let open = law.left_in(k, found[k]);
                // More states do not know more than each of them.
                if narrow || open <= noise(k) { 0.0 } else { open }
            };
            let open: Vec<f64> = (0..found.len()).map(open).collect();
            told(states.len(), open.iter().copied().reduce(f64::max));
            let mut wide: Vec<usize> = (0..open.len()).filter(|&k| open[k] > accuracy).collect();
            // The widest first, where there is no room for all.
            wide.sort_by(|&a, &b| open[b].total_cmp(&open[a]).then(a.cmp(&b)));
            wide.truncate(most.saturating_sub(states.len()));
            wide.sort_unstable();
            if wide.is_empty() {
                let own: Vec<[f64; 2]> = (0..found.len()).map(|k| law.errors_in(k, &states, found[k])).collect();
                // Of the force no part of the curve is taken to be better known than the rest; a slope is as near as the slopes beside it.
                let forces = own.iter().map(|e| e[0]).fold(0.0, f64::max)
                    + (0..found.len()).map(|k| law.left_in(k, found[k])).fold(0.0, f64::max);
                let beside = |k: usize| &own[k.saturating_sub(1)..(k + 2).min(own.len())];
                let slopes = |k: usize| beside(k).iter().map(|e| e[1]).fold(0.0, f64::max);
                let errors = (0..own.len()).map(|k| [forces, forces + slopes(k)]).collect();
                return Ok((Self { errors, ..law }, states));
            }
            let middles: Vec<f64> = wide.iter().map(|&k| (law.knots[k][0] * law.knots[k + 1][0]).sqrt()).collect();
            let solved = solve(&middles)?;
            // From the end, so that the places of the others stay.
            for ((&k, &s), state) in wide.iter().zip(&middles).zip(solved).rev() {
                let missed = (law.at(s)[0] / state.force).ln().abs();
                states.insert(k + 1, state);
                found[k] = missed;
                found.insert(k, missed);
            }
        }
    }

    /// What the states leave open in the middle of an interval.
    fn left_in(&self, k: usize, missed: f64) -> f64 {
        (LEFT * missed).max(self.unseen(k)).max(self.unsure(k))
    }

    /// Estimates of the relative errors between the states k and k + 1: of the force, by those of the states; of the slope, by what lies
    /// between them.
    fn errors_in(&self, k: usize, states: &[Sample], missed: f64) -> [f64; 2] {
        let own = [k, k + 1].iter().filter_map(|&k| states[k].force_error).fold(0.0, f64::max);
        let left = self.left_in(k, missed);
        let ([_, _, m], [_, _, n], h) = (self.knots[k], self.knots[k + 1], self.width(k));
        let by_values = SLOPE_OF_NOISE * (self.noise[k] + self.noise[k + 1]) / h;
        // A slope is never farther from the one of its state than that is doubted; at the ends it is that one.
        let doubted = [m * self.doubts[k], n * self.doubts[k + 1]];
        let ends = [k == 0, k + 2 == self.knots.len()];
        let of = |end: usize| if ends[end] { doubted[end] } else { by_values.min(2.0 * doubted[end]) };
        let of_slopes = of(0).max(of(1));
        let slope = (SLOPE_OF_REST * left / h + of_slopes) / m.min(n);
        [own, slope]
    }

    /// Estimate of the error in the middle of an interval: (h/2)^4 q, h its width.
    fn unseen(&self, k: usize) -> f64 {
        HIGHER * (0.5 * self.width(k)).powi(4) * self.fourth_degree(k)
    }

    /// h, in ln s.
    fn width(&self, k: usize) -> f64 {
        (self.knots[k + 1][0] / self.knots[k][0]).ln()
    }

    /// The factor q of the fourth degree in an interval, from its neighbours: with h its width and c a state beside it,
    /// the one that y(c) or y'(c) asks for on top of the cubic piece y3,
    /// q = (y - y3)/[(c - a)^2 (c - b)^2] = (y' - y3')/[2 (c - a)(c - b)(2 c - a - b)].
    fn fourth_degree(&self, k: usize) -> f64 {
        let ([a, b], pa) = ([self.knots[k][0], self.knots[k + 1][0]], self.knots[k][1]);
        let beside = [k.checked_sub(1), Some(k + 2)];
        let terms = beside.into_iter().flatten().filter_map(|n| self.knots.get(n)).map(|&[c, p, m]| {
            let [rise, slope] = self.piece(k, c);
            let (u, v) = ((c / a).ln(), (c / b).ln());
            let by_value = ((p / pa).ln() - rise).abs() / (u * v).powi(2);
            let by_slope = (m - slope).abs() / (2.0 * u * v * (u + v)).abs();
            by_value.max(by_slope)
        });
        terms.fold(0.0, f64::max)
    }

    /// What the slopes leave open in the middle of an interval, h/8 of the difference of their errors.
    fn unsure(&self, k: usize) -> f64 {
        self.width(k) * self.doubt_of_slope(k).max(self.doubt_of_slope(k + 1)) / 8.0
    }

    /// What a slope may be off by: the doubt of that of its state, or what errors of the values and the term of fourth degree make of the
    /// one that bends the law least.
    fn doubt_of_slope(&self, k: usize) -> f64 {
        let of_state = self.knots[k][2] * self.doubts[k];
        if self.held[k] {
            return of_state;
        }
        let by_values = |i: usize| {
            let h = self.width(i);
            SLOPE_OF_NOISE * (self.noise[i] + self.noise[i + 1]) / h + h.powi(3) * self.fourth_degree(i)
        };
        of_state.min(by_values(k - 1).max(by_values(k)))
    }

    fn through(states: &[Sample], first_touch: f64, noise: impl Fn(&Sample) -> f64) -> Self {
        let given: Vec<[f64; 3]> = states
            .iter()
            .map(|state| {
                let s = state.depth - first_touch;
                // Convex from zero: P' is at least P/s.
                [s, state.force, (state.stiffness * s / state.force).max(1.0)]
            })
            .collect();
        let doubt = |state: &Sample| {
            let own = state.force_error.unwrap_or(0.0);
            let of_grids = DOUBT_OF_SLOPES * own.sqrt();
            state.stiffness_error.map_or(of_grids, |stated| of_grids.min(stated + own))
        };
        let doubts: Vec<f64> = states.iter().map(doubt).collect();
        let mut law = Self {
            knots: given.clone(),
            held: vec![true; given.len()],
            noise: states.iter().map(noise).collect(),
            doubts: doubts.clone(),
            errors: Vec::new(),
        };
        for _ in 0..SWEEPS {
            for k in 1..given.len() - 1 {
                let (m, smooth) = (given[k][2], law.smooth(k));
                let taken = smooth.max(m * (1.0 - doubts[k])).min(m * (1.0 + doubts[k])).max(1.0);
                (law.knots[k][2], law.held[k]) = (taken, taken != smooth);
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
        let place = Cubic { t: (s / sa).ln() / h, h };
        [0, 1].map(|n| place.value(n, [0.0, ma], [rise, mb]))
    }

    /// Overlaps of the states.
    pub fn overlaps(&self) -> impl Iterator<Item = f64> + '_ {
        self.knots.iter().map(|knot| knot[0])
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
