//! A function of the radius from few of its values: polynomials through Chebyshev points, as many pieces as it takes to the last digits.
//!
//! Past a radius b where the generatrix is not smooth D goes like (s - b)^(1/2): there it is smooth in w, s^2 = b^2 + w^2
//! (b = 0 up to the first of them).

use std::f64::consts::PI;
use std::sync::OnceLock;

/// The function where that many values were enough of it.
#[derive(Debug)]
pub(super) struct Interpolated {
    /// From the axis outwards, with gaps where it is not smooth.
    pieces: Vec<Piece>,
}

#[derive(Debug)]
struct Piece {
    /// Where w counts from.
    from: f64,
    /// w from one end to the other.
    ends: [f64; 2],
    /// Radii from one end to the other.
    radii: [f64; 2],
    /// Chebyshev coefficients.
    coefficients: [f64; POINTS],
}

/// Values of one piece.
const POINTS: usize = 20;

/// Halvings of a stretch; what is not smooth after them is left out.
const HALVINGS: u32 = 8;

/// The share of the rest that a half of a piece may have: more is noise, and no half of it is smooth.
const NOISE: f64 = 0.75;

static POLYNOMIALS: OnceLock<[[f64; POINTS]; POINTS]> = OnceLock::new();

/// What rounding may leave between two pieces, over their radius.
const JOINT: f64 = 1e-12;

/// Pieces that are tried: of noise none is smooth.
const MOST_TRIED: usize = 100;

impl Interpolated {
    /// `f` up to the radius `end` to this share of its value there; `kinks`, increasing: where it is not smooth.
    pub fn new(f: impl Fn(f64) -> f64, kinks: &[f64], end: f64, tolerance: f64) -> Self {
        let off = tolerance * f(end).abs();
        let mut tried = 0;
        // Halves from the left, so that the pieces are in order.
        let mut pieces = Vec::new();
        let inner = kinks.iter().copied().filter(|b| *b < end);
        let radii: Vec<f64> = std::iter::once(0.0).chain(inner).chain([end]).collect();
        for pair in radii.windows(2) {
            let (from, stop) = (pair[0], pair[1]);
            let whole = [0.0, ((stop - from) * (stop + from)).sqrt()];
            let mut left = vec![(whole, f64::INFINITY, HALVINGS)];
            while let Some((ends, before, halvings)) = left.pop().filter(|_| tried < MOST_TRIED) {
                tried += 1;
                let piece = Piece::new(&f, from, ends);
                let rest = piece.rest();
                if rest <= off {
                    pieces.push(piece);
                } else if halvings > 0 && rest <= NOISE * before {
                    let middle = 0.5 * (ends[0] + ends[1]);
                    left.extend([[middle, ends[1]], [ends[0], middle]].map(|half| (half, rest, halvings - 1)));
                }
            }
        }
        Self { pieces }
    }

    /// The derivative over the radius, f'(s)/s, where it is known; `w` tells it from b, which s itself does to fewer digits close to b.
    pub fn slope_over_radius(&self, s: f64, w: impl Fn(f64) -> f64) -> Option<f64> {
        let piece = self.piece(s)?;
        let w = if piece.from > 0.0 { w(piece.from) } else { s };
        // T_k' = k U_(k-1), by Clenshaw's recurrence.
        let x = ((w - piece.ends[0]) - (piece.ends[1] - w)) / (piece.ends[1] - piece.ends[0]);
        let (mut b, mut before) = (0.0, 0.0);
        for (k, c) in piece.coefficients.iter().enumerate().skip(1).rev() {
            (b, before) = (2.0 * x * b - before + k as f64 * c, b);
        }
        // df/ds = df/dw s/w.
        Some(2.0 * b / (piece.ends[1] - piece.ends[0]) / w)
    }

    /// Whether nothing is left out from this radius to the end.
    pub fn covers_from(&self, r: f64, end: f64) -> bool {
        let inner = self.pieces.partition_point(|piece| piece.radii[1] <= r);
        let mut known = r;
        for piece in &self.pieces[inner..] {
            if piece.radii[0] > known * (1.0 + JOINT) {
                return false;
            }
            known = piece.radii[1];
        }
        known * (1.0 + JOINT) >= end
    }

    fn piece(&self, s: f64) -> Option<&Piece> {
        let after = self.pieces.partition_point(|piece| piece.radii[0] <= s);
        let piece = self.pieces.get(after.max(1) - 1)?;
        let slack = JOINT * piece.radii[1];
        (s >= piece.radii[0] - slack && s <= piece.radii[1] + slack).then_some(piece)
    }
}

impl Piece {
    fn new(f: impl Fn(f64) -> f64, from: f64, ends: [f64; 2]) -> Self {
        let (centre, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        // T_j at the points.
        let polynomials = POLYNOMIALS.get_or_init(|| {
            let angle = |k: usize| PI * (k as f64 + 0.5) / POINTS as f64;
            std::array::from_fn(|j| std::array::from_fn(|k| (j as f64 * angle(k)).cos()))
        });
        let values = polynomials[1].map(|x| f(from.hypot(centre + half * x)));
        let coefficients = std::array::from_fn(|j| {
            let sum: f64 = values.iter().zip(&polynomials[j]).map(|(value, t)| value * t).sum();
            sum * if j == 0 { 1.0 } else { 2.0 } / POINTS as f64
        });
        Self { from, ends, radii: ends.map(|w| from.hypot(w)), coefficients }
    }

    /// The largest of the last coefficients: what is left out is no larger where the function is smooth.
    fn rest(&self) -> f64 {
        self.coefficients[POINTS - 3..].iter().fold(0.0, |most, c| c.abs().max(most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_where_it_is_known() {
        // Past 0.3 and 0.7 not smooth; near the axis neither.
        let past = |s: f64, b: f64| if s > b { ((s - b) * (s + b)).sqrt() } else { 0.0 };
        let f = |s: f64| s.powf(1.5) + past(s, 0.3) - 0.4 * past(s, 0.7).powi(3) + (3.0 * s).sin();
        let found = Interpolated::new(f, &[0.3, 0.7], 1.2, 1e-14);
        assert!(found.covers_from(0.1, 1.2) && !found.covers_from(1e-6, 1.2) && !found.covers_from(0.1, 1.3));
        let known = |s: f64| found.slope_over_radius(s, |b| ((s - b) * (s + b)).sqrt()).is_some();
        assert!(known(0.1) && !known(1e-6) && !known(1.3));
        // Noise is not followed.
        let values = std::cell::Cell::new(0);
        let noise = |s: f64| {
            values.set(values.get() + 1);
            (1e9 * s).sin()
        };
        assert!(!Interpolated::new(noise, &[], 1.0, 1e-14).covers_from(0.1, 1.0));
        assert!(values.get() < 20 * POINTS, "{}", values.get());
    }

    #[test]
    fn its_slope_keeps_its_digits() {
        let f = |s: f64| s * s + if s > 0.5 { ((s - 0.5) * (s + 0.5)).sqrt() } else { 0.0 };
        let found = Interpolated::new(f, &[0.5], 2.0, 1e-14);
        for k in 0..=1000 {
            let s = 1e-3 + 1.999 * f64::from(k) / 1000.0;
            let past = if s > 0.5 { 1.0 / ((s - 0.5) * (s + 0.5)).sqrt() } else { 0.0 };
            let slope = found.slope_over_radius(s, |b| ((s - b) * (s + b)).sqrt()).unwrap();
            assert!((slope - 2.0 - past).abs() < 1e-9 * (2.0 + past), "{s}: {slope}");
        }
    }
}
