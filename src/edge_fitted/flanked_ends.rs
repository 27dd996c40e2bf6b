//! Where the contact ends on the flanks of a flat.

use super::flanked::Flat;
use super::flanked_mesh::Flanked;
use super::rows::further;

/// Heights on every flank over shares of its side, from its first corner (0) to its last one (1).
#[derive(Debug, Clone)]
pub(super) struct Ends {
    flanks: Vec<Vec<[f64; 2]>>,
    /// Of each flank: the share within which the end does not feel the distance from the corner.
    least: Vec<f64>,
}

/// Beside an edge with the pressure k s^(-1/2) of the flat punch the contact passes the edge by the order of (k/slope)^2; towards a corner of
/// 90 degrees k grows with this power of the distance from it. Where the contact is as wide as that distance, it feels the corner.
const OF_CORNER: f64 = -0.41;

/// The height over the growth, at a distance of 1 from the corners.
const HEIGHT: f64 = 0.6;

/// Heights at most: the bodies overlap below 1.
const HIGHEST: f64 = 0.9;

/// Moves at once.
const MOVES: [f64; 2] = [0.5, 2.0];

/// Shares at which a guess is made.
const PLACES: i32 = 30;

impl Ends {
    /// A first guess.
    pub fn guess(flat: &Flat) -> Self {
        let count = flat.corners.len();
        let mut ends = Self { flanks: Vec::new(), least: Vec::new() };
        for k in 0..count {
            let (a, b) = (flat.corners[k], flat.corners[(k + 1) % count]);
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            let [p, q, _] = flat.sides[k];
            let growth = 1.0 / p.hypot(q);
            // Of s = growth^2 s^(2 OF_CORNER): a distance s from the corner.
            let least = growth.powf(1.0 / (1.0 + OF_CORNER)).min(1.0);
            let place = |i: i32| {
                let t = f64::from(i) / f64::from(PLACES);
                let share = 0.5 + 0.5 * t.signum() * (1.0 - (1.0 - t.abs()).powi(4));
                let x = length * share.min(1.0 - share) + least;
                [share, (HEIGHT * growth * x.powf(OF_CORNER)).min(HIGHEST)]
            };
            ends.flanks.push((-PLACES..=PLACES).map(place).collect());
            ends.least.push(least / length);
        }
        ends.close();
        ends
    }

    /// The height at a share of side k: logarithms are interpolated over that of the distance from the nearer corner.
    pub fn at(&self, k: usize, share: f64) -> f64 {
        let (ends, place) = (&self.flanks[k], |share: f64| place(share, self.least[k]));
        let i = ends.partition_point(|e| e[0] < share).clamp(1, ends.len() - 1);
        let ([a, p], [b, q]) = (ends[i - 1], ends[i]);
        let t = ((place(share) - place(a)) / (place(b) - place(a))).clamp(0.0, 1.0);
        let (p, q) = (p.ln(), q.ln());
        // From the nearer end: mirrored.
        (if t <= 0.5 { p + t * (q - p) } else { q + (1.0 - t) * (p - q) }).exp()
    }

    pub fn highest(&self) -> f64 {
        self.flanks.iter().flatten().map(|e| e[1]).fold(0.0, f64::max)
    }

    pub fn lowest(&self) -> f64 {
        self.flanks.iter().flatten().map(|e| e[1]).fold(f64::INFINITY, f64::min)
    }

    /// No nearer to the sides than this.
    pub fn no_nearer(mut self, flat: &Flat, distance: f64) -> Self {
        for (ends, [a, b, _]) in self.flanks.iter_mut().zip(flat.sides) {
            let least = distance * a.hypot(*b);
            ends.iter_mut().for_each(|e| e[1] = e[1].max(least).min(HIGHEST));
        }
        self.close();
        self
    }

    /// The least distance from a side.
    pub fn nearest(&self, flat: &Flat) -> f64 {
        let least = |ends: &Vec<[f64; 2]>| ends.iter().map(|e| e[1]).fold(f64::INFINITY, f64::min);
        let flanks = self.flanks.iter().zip(flat.sides);
        flanks.map(|(ends, [a, b, _])| least(ends) / a.hypot(*b)).fold(f64::INFINITY, f64::min)
    }

    /// All of them farther from the sides.
    pub fn reaching(&self, factor: f64) -> Self {
        let mut all = self.clone();
        all.flanks.iter_mut().flatten().for_each(|e| e[1] = (factor * e[1]).min(HIGHEST));
        all
    }

    /// Moved by what the pressure of the cells says beside them, contact being everywhere up to them (`oval`).
    pub fn moved(&self, flanked: &Flanked, pressure: &dyn Fn(usize) -> f64) -> Self {
        let mut all = self.clone();
        for (k, flank) in flanked.flanks.iter().enumerate() {
            let rows = flank.cells.len();
            let at = |line: usize, j: usize| {
                0.5 * (flanked.heights[flank.lines[line][j]] + flanked.heights[flank.lines[line][j + 1]])
            };
            let columns = 0..flank.shares.len() - 1;
            let moved = columns.map(|j| {
                let end = at(rows, j);
                let thickness = [end - at(rows - 1, j), end - at(rows - 2, j)];
                let share =
                    further(thickness, [pressure(flank.cells[rows - 1][j]), pressure(flank.cells[rows - 2][j])]);
                let factor = (1.0 + share / end).clamp(MOVES[0], MOVES[1]);
                [0.5 * (flank.shares[j] + flank.shares[j + 1]), (factor * end).min(HIGHEST)]
            });
            all.flanks[k] = moved.collect();
            // To the corners as between the two columns beside them.
            let to = |corner: f64, [a, p]: [f64; 2], [b, q]: [f64; 2]| {
                let [o, x, y] = [corner, a, b].map(|share| place(share, self.least[k]));
                [corner, p * (p / q).powf((x - o) / (y - x)).clamp(MOVES[0], MOVES[1])]
            };
            let own = &all.flanks[k];
            let last = own.len() - 1;
            let (first, end) = (to(0.0, own[0], own[1]), to(1.0, own[last], own[last - 1]));
            all.flanks[k].insert(0, first);
            all.flanks[k].push(end);
        }
        all.close();
        all
    }

    /// Makes both flanks of a corner end at one height.
    fn close(&mut self) {
        let count = self.flanks.len();
        for k in 0..count {
            let before = (k + count - 1) % count;
            let last = self.flanks[before].len() - 1;
            let mean = (0.5 * (self.flanks[k][0][1] + self.flanks[before][last][1])).min(HIGHEST);
            self.flanks[k][0][1] = mean;
            self.flanks[before][last][1] = mean;
        }
    }
}

/// Rises with the share; by its logarithm near both corners.
fn place(share: f64, least: f64) -> f64 {
    let from = |x: f64| (x / least).ln_1p();
    if share <= 0.5 { from(share) - from(0.5) } else { from(0.5) - from(1.0 - share) }
}
