//! The cells that touch the one at hand, and what they displace in a quarter of it.

use super::potential::Corners;

/// The cells that touch, in the order of their weights.
pub(super) const TOUCHING: [[i32; 2]; 8] = [[-1, -1], [0, -1], [1, -1], [-1, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];

/// Singular functions of each class of parity: those of the cells (1, 0), (0, 1), (1, 1), as far as they have a part in it.
pub(super) const SINGULAR: [&[usize]; 4] = [&[0, 1, 2], &[0, 2], &[1, 2], &[2]];

/// First singular function of each class, and the end.
pub(super) const FIRSTS: [usize; 5] = [0, 3, 5, 7, 8];

/// The nine cells of the middle block as they act in the quarter s, t > 0 of the middle one.
pub(super) struct Touching(Corners);

impl Touching {
    /// At the points of a tensor lattice, in sides of the cell from its centre.
    pub fn new(h: [f64; 2], along: &[f64], across: &[f64]) -> Self {
        let shifted = |points: &[f64], side: f64| -> Vec<f64> {
            points.iter().flat_map(|s| (0..4).map(move |n| (s + 1.5 - f64::from(n)) * side)).collect()
        };
        Self(Corners::new(&shifted(along, h[0]), &shifted(across, h[1])))
    }

    /// Displacement and slopes at the point (x, y) of the lattice by the cell at an offset of -1, 0 or 1.
    pub fn at(&self, x: usize, y: usize, offset: [i32; 2]) -> [f64; 3] {
        let [a, b] = offset.map(|o| (o + 1) as usize);
        self.0.cell([4 * x + a + 1, 4 * x + a], [4 * y + b + 1, 4 * y + b])
    }

    /// The part of one class that the cell (1, 0), (0, 1) or (1, 1) and its images have, for the sum of their jumps with the signs of
    /// the class.
    pub fn of_class(&self, [i, j]: [usize; 2], cell: usize, class: usize) -> [f64; 3] {
        let [a, b] = [[1, 0], [0, 1], [1, 1]][cell];
        let odd = [class & 1, class >> 1];
        let mut sum = [0.0; 3];
        let mut images = 0.0;
        for x in if a == 1 { &[1, -1][..] } else { &[0] } {
            for y in if b == 1 { &[1, -1][..] } else { &[0] } {
                let negative = (odd[0] == 1 && *x < 0) != (odd[1] == 1 && *y < 0);
                let value = self.at(i, j, [*x, *y]);
                (0..3).for_each(|m| sum[m] += if negative { -value[m] } else { value[m] });
                images += 1.0;
            }
        }
        sum.map(|s| s / images)
    }
}
