//! The faces of a regular pyramid, pointed or blunt: which of many planes matter where.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::Reach;
use super::ridges::unit;
use crate::numeric::geometry::Rect;

/// Faces of one slope around the origin, the first of which looks along +x, cut off by a level flat at height 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fan {
    pub faces: usize,
    pub slope: f64,
    /// Inradius of the flat; 0: pointed.
    pub flat: f64,
}

impl Fan {
    /// The planes of its faces, in order.
    pub fn planes(&self) -> Vec<[f64; 3]> {
        let plane = |k: usize| {
            let (sin, cos) = unit(k, self.faces);
            [self.slope * cos, self.slope * sin, if self.flat > 0.0 { -self.slope * self.flat } else { 0.0 }]
        };
        (0..self.faces).map(plane).collect()
    }

    /// Least slope along any ray.
    pub fn rise(&self) -> f64 {
        self.slope * self.half_angle().cos()
    }

    /// Holds every corner with room to spare.
    pub fn window(&self) -> Rect {
        let room = if self.flat > 0.0 { 4.0 * self.flat / self.half_angle().cos() } else { 4.0 };
        Rect::around([0.0; 2], [room; 2])
    }

    fn half_angle(&self) -> f64 {
        0.5 * TAU / self.faces as f64
    }

    pub fn reach(&self, depth: f64) -> Reach {
        if depth <= 0.0 {
            return Reach::Nowhere;
        }
        if self.faces == 2 {
            return Reach::Unbounded { from: [0.0; 2], along: FRAC_PI_2 };
        }
        let ridge = (depth / self.slope + self.flat) / self.half_angle().cos();
        if self.flat > 0.0 {
            let corner = |k: usize| {
                let (sin, cos) = unit(2 * k + 1, 2 * self.faces);
                [ridge * cos, ridge * sin]
            };
            return Rect::holding((0..self.faces).map(corner))
                .map_or(Reach::Nowhere, |rect| Reach::Within(rect.scaled(1.0 + 1e-12)));
        }
        Reach::Within(Rect::around([0.0; 2], [ridge * (1.0 + 1e-12); 2]))
    }

    /// Indices of the faces around the sector that holds a point, which rounding may take for one another; its own first.
    pub fn at(&self, [x, y]: [f64; 2]) -> [usize; 3] {
        let k = (y.atan2(x) / TAU * self.faces as f64).round() as i64;
        [k, k - 1, k + 1].map(|k| k.rem_euclid(self.faces as i64) as usize)
    }

    /// Indices of the faces that can be the highest over a rectangle; `None`: all.
    pub fn over(&self, rect: &Rect) -> Option<impl Iterator<Item = usize> + use<>> {
        if rect.contains([0.0; 2]) {
            return None;
        }
        // The sector in which the rectangle is seen from the apex.
        let [x, y] = rect.centre();
        let middle = y.atan2(x);
        let aside = |c: [f64; 2]| {
            let off = c[1].atan2(c[0]) - middle;
            (off + TAU + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU
        };
        let spread = rect.corners().into_iter().map(|c| aside(c).abs()).fold(0.0, f64::max);
        let (faces, step) = (self.faces as i64, TAU / self.faces as f64);
        let (first, last) =
            (((middle - spread) / step).floor() as i64 - 1, ((middle + spread) / step).ceil() as i64 + 1);
        (last - first < faces).then(|| (first..=last).map(move |k| k.rem_euclid(faces) as usize))
    }
}
