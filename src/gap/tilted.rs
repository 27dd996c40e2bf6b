//! A gap under a tilted body: g - ax x - ay y.

use super::{AnyGap, Gap, Reach, Ridges};
use crate::geometry::Rect;

/// The gap under a body tilted by (ax, ay): with depth d the overlap is f = d + ax x + ay y - g.
#[derive(Clone)]
pub struct Tilted {
    gap: AnyGap,
    tilt: [f64; 2],
}

impl Tilted {
    /// `gap` under the tilt (ax, ay), radians, small.
    #[must_use]
    pub fn new(gap: AnyGap, tilt: [f64; 2]) -> Self {
        Self { gap, tilt }
    }

    /// {f > 0} of the tilted gap from that of the level one at a depth.
    fn raised(&self, depth: f64, reach: impl Fn(f64) -> Reach) -> Reach {
        // {g < depth + tilt . x} lies in {g < depth + s} where s is the largest rise over its own box: grow until it does.
        let mut rise = 0.0;
        for _ in 0..60 {
            match reach(depth + rise) {
                Reach::Within(rect) => {
                    let most = rect.corners().map(|[x, y]| self.rise(x, y)).into_iter().fold(0.0, f64::max);
                    if most <= rise {
                        return Reach::Within(rect);
                    }
                    rise = 2.0 * most;
                }
                // Nothing is reached on the way up only if nothing was reached at the bottom.
                Reach::Nowhere if rise == 0.0 => rise = depth.abs().max(f64::MIN_POSITIVE),
                other => return if rise > 0.0 && other == Reach::Nowhere { Reach::Unknown } else { other },
            }
        }
        Reach::Unknown
    }

    fn rise(&self, x: f64, y: f64) -> f64 {
        self.tilt[0] * x + self.tilt[1] * y
    }
}

impl Gap for Tilted {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.gap.gap(x, y) - self.rise(x, y)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.gap.gradient(x, y).map(|[gx, gy]| [gx - self.tilt[0], gy - self.tilt[1]])
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let [x, y] = rect.centre();
        let bounds = self.gap.range(rect, [slope[0] + self.tilt[0], slope[1] + self.tilt[1]])?;
        Some(bounds.map(|b| b - self.rise(x, y)))
    }

    fn mirrors(&self) -> [bool; 2] {
        let own = self.gap.mirrors();
        [0, 1].map(|m| own[m] && self.tilt[m] == 0.0)
    }

    fn reach(&self, depth: f64) -> Reach {
        self.raised(depth, |depth| self.gap.reach(depth))
    }

    fn certain_reach(&self, depth: f64) -> Reach {
        self.raised(depth, |depth| self.gap.certain_reach(depth))
    }

    fn pieces(&self, depth: f64) -> Option<Vec<Rect>> {
        // As for the reach: the pieces at a depth that is larger by the largest rise over them hold those of the tilted gap.
        let Reach::Within(all) = self.reach(depth) else { return None };
        let rise = all.corners().map(|[x, y]| self.rise(x, y)).into_iter().fold(0.0, f64::max);
        self.gap.pieces(depth + rise)
    }

    fn mean(&self, cell: &Rect) -> f64 {
        let [x, y] = cell.centre();
        self.gap.mean(cell) - self.rise(x, y)
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        self.gap.ray_kinks(from, direction, kinks);
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        self.gap.kink_directions(from, angles);
    }

    fn ridges(&self) -> Option<Ridges> {
        // A plane taken off all planes moves no ridge.
        self.gap.ridges()
    }

    fn centre(&self) -> [f64; 2] {
        self.gap.centre()
    }

    fn tips(&self) -> Vec<[f64; 2]> {
        self.gap.tips()
    }

    fn reference(&self) -> [f64; 2] {
        self.gap.reference()
    }
}
