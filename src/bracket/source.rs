//! The displacement by one loaded rectangle, the polynomial through it, and bounds of their difference e over squares.

use super::kernel;
use super::polynomial::{NODES, Polynomial};

/// One source: its K and the polynomial through it.
pub(super) struct Source {
    /// Sides of the loaded rectangle, and its centre in the problem of the middle cell.
    pub sides: [f64; 2],
    pub centre: [f64; 2],
    /// Sides of a cell.
    pub h: [f64; 2],
    pub polynomial: Polynomial,
}

impl Source {
    pub fn new(h: [f64; 2], sides: [f64; 2], offset: [i64; 2]) -> Self {
        let centre = [0, 1].map(|m| offset[m] as f64 * h[m]);
        let node = |i: usize, m: usize| (i as f64 - NODES as f64) * h[m] - centre[m];
        let polynomial = Polynomial::through(|i, j| kernel::displacement(sides, node(i, 0), node(j, 1))[0]);
        Self { sides, centre, h, polynomial }
    }

    /// K and its slopes per side, at (s, t) sides from the centre of the middle cell.
    pub fn displacement(&self, [s, t]: [f64; 2]) -> [f64; 3] {
        let [u, x, y] =
            kernel::displacement(self.sides, s * self.h[0] - self.centre[0], t * self.h[1] - self.centre[1]);
        [u, x * self.h[0], y * self.h[1]]
    }

    /// e and its slopes.
    pub fn error(&self, at: [f64; 2]) -> [f64; 3] {
        let (k, p) = (self.displacement(at), self.polynomial.at(at));
        [k[0] - p[0], k[1] - p[1], k[2] - p[2]]
    }

    /// K at the furthest and the nearest point of a square: it lies between them.
    pub fn within(&self, at: [f64; 2], half: f64) -> [f64; 2] {
        let span = [0, 1].map(|m| {
            let from = (at[m] - half) * self.h[m] - self.centre[m];
            let to = (at[m] + half) * self.h[m] - self.centre[m];
            let least = if from < 0.0 && to > 0.0 { 0.0 } else { from.abs().min(to.abs()) };
            [from.abs().max(to.abs()), least]
        });
        [0, 1].map(|end| kernel::displacement(self.sides, span[0][end], span[1][end])[0])
    }

    /// Supremum over a square of |e - plane|, where second derivatives of K are at most `curvature` (along, mixed, across,
    /// per side squared).
    pub fn smooth(&self, middle: [f64; 2], half: f64, tiles: usize, curvature: [f64; 3], plane: [f64; 3]) -> f64 {
        let tile = half / tiles as f64;
        let [a, b, c] = curvature;
        let bend = 0.5 * (a + 2.0 * b + c) * tile * tile + self.polynomial.bend(tile);
        over_tiles(middle, half, tiles, |at| {
            let [e, s, t] = self.error(at);
            let [v, along, across] = plane;
            let flat = v + along * (at[0] - middle[0]) + across * (at[1] - middle[1]);
            (e - flat).abs() + ((s - along).abs() + (t - across).abs()) * tile
        }) + bend
    }

    /// The same without second derivatives: over each tile K lies between its values at the furthest and the nearest point.
    pub fn rough(&self, middle: [f64; 2], half: f64, tiles: usize, plane: [f64; 3]) -> f64 {
        let tile = half / tiles as f64;
        let bend = self.polynomial.bend(tile);
        over_tiles(middle, half, tiles, |at| {
            let [low, high] = self.within(at, tile);
            let [p, s, t] = self.polynomial.at(at);
            let [v, along, across] = plane;
            let flat = p + v + along * (at[0] - middle[0]) + across * (at[1] - middle[1]);
            (0.5 * (high + low) - flat).abs() + 0.5 * (high - low) + ((s + along).abs() + (t + across).abs()) * tile
        }) + bend
    }
}

/// The largest of `value` at the middles of the tiles of a square.
fn over_tiles(middle: [f64; 2], half: f64, tiles: usize, value: impl Fn([f64; 2]) -> f64) -> f64 {
    let place = |k: usize| half * ((2 * k + 1) as f64 / tiles as f64 - 1.0);
    (0..tiles * tiles).map(|k| value([middle[0] + place(k % tiles), middle[1] + place(k / tiles)])).fold(0.0, f64::max)
}
