//! Which part of the plane a picture shows.

use super::axes::power_of_ten;
use super::frame::Frame;
use crate::numeric::geometry::Rect;

/// A window onto the plane with equal scales along x and y.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// What is seen, in units of 10^power.
    pub extent: Rect,
    /// The power of ten taken out of both coordinates.
    pub power: i32,
    /// Points of the plotting area.
    pub pixels: [u32; 2],
}

impl Window {
    /// `seen` with a margin of 6 %, the longer side `longest` points long; lengths are labelled in `unit`.
    pub fn onto(seen: &Rect, longest: u32, unit: &str) -> Self {
        let longest_side = f64::from(longest);
        let seen = seen.scaled(1.12);
        let largest = seen.corners().into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
        let power = power_of_ten(largest, unit);
        let unit = 10f64.powi(power);
        let [w, h] = seen.size();
        let longest = w.max(h);
        // A very slender patch keeps an area on which it can be seen; its short side then has room to spare.
        let side = |length: f64| (longest_side * (length / longest).max(0.4)).round();
        let pixels = [side(w), side(h)];
        let half = pixels.map(|p| 0.5 * p / longest_side * longest / unit);
        let extent = Rect::around(seen.centre().map(|c| c / unit), half);
        Self { extent, power, pixels: pixels.map(|p| p as u32) }
    }

    /// Size of the picture around it; `beside` points more on the right, `below` more at the bottom.
    pub fn size(&self, frame: &Frame, beside: u32, below: u32) -> (u32, u32) {
        (
            self.pixels[0] + frame.edge + frame.left + frame.right + beside,
            self.pixels[1] + frame.top + frame.bottom + below,
        )
    }

    /// A point in the units of the axes.
    pub fn place(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let unit = 10f64.powi(self.power);
        (x / unit, y / unit)
    }

    /// Where a picture has a point, points from its upper left corner.
    pub fn pixel(&self, frame: &Frame, point: [f64; 2]) -> [f64; 2] {
        let (x, y) = self.place(point);
        let [w, h] = self.extent.size();
        let [px, py] = self.pixels.map(f64::from);
        [
            f64::from(frame.edge + frame.left) + (x - self.extent.min[0]) / w * px,
            f64::from(frame.top) + (self.extent.max[1] - y) / h * py,
        ]
    }
}
