//! How the trial displacement goes on beyond the contact.
//!
//! w = r = f - u on a set of cells. Around them chi is 1 at the corners and in the middles of the sides that they have, 0 at all other
//! corners of quarters of cells, and bilinear in each quarter: it fades over half a cell. There w = chi r; where w >= r has to hold,
//! w = max(r, chi r), also where chi = 0 as far as r <= 0 was not shown.

use super::field::RING;

/// The cells and quarters of cells in which w differs from zero.
#[derive(Debug, Clone)]
pub(super) struct Extension {
    shape: [usize; 2],
    /// Of each cell, those around the grid included: bits 0 to 3 the quarters in which r may be positive though chi = 0 (that of
    /// s, t < 0, then s > 0, t > 0, both); bit 4 the cell itself.
    cells: Vec<u8>,
    /// chi at the corners of quarters.
    lit: Vec<bool>,
}

/// Bit of a cell of the set.
const WHOLE: u8 = 16;

impl Extension {
    /// Of some of the cells of a grid.
    pub fn of_cells(shape: [usize; 2], within: impl Fn(usize, usize) -> bool) -> Self {
        let wide = shape.map(|n| n + 2 * RING);
        let width = 2 * wide[0] + 1;
        let mut set = Self { shape, cells: vec![0; wide[0] * wide[1]], lit: vec![false; width * (2 * wide[1] + 1)] };
        for j in 0..shape[1] {
            for i in 0..shape[0] {
                if within(i, j) {
                    let place = set.place(i as isize, j as isize);
                    set.cells[place] = WHOLE;
                    let first = set.first(i as isize, j as isize);
                    (0..3).for_each(|b| set.lit[first + b * width..first + b * width + 3].fill(true));
                }
            }
        }
        set
    }

    fn place(&self, i: isize, j: isize) -> usize {
        let ring = RING as isize;
        (j + ring) as usize * (self.shape[0] + 2 * RING) + (i + ring) as usize
    }

    /// Place of the lower left corner of a cell among the corners of quarters.
    fn first(&self, i: isize, j: isize) -> usize {
        let ring = RING as isize;
        2 * (j + ring) as usize * self.width() + 2 * (i + ring) as usize
    }

    fn width(&self) -> usize {
        2 * (self.shape[0] + 2 * RING) + 1
    }

    /// Adds a quarter in which r may be positive.
    pub fn open(&mut self, i: isize, j: isize, quarter: usize) {
        let place = self.place(i, j);
        self.cells[place] |= 1 << quarter;
    }

    /// Whether chi is 1 somewhere on the border of what is looked at: then it fades beyond.
    pub fn reaches_border(&self) -> bool {
        let width = self.width();
        let (first, last) = (&self.lit[..width], &self.lit[self.lit.len() - width..]);
        let sides = self.lit.chunks_exact(width).any(|row| row[0] || row[width - 1]);
        sides || first.iter().chain(last).any(|lit| *lit)
    }

    /// Whether the cell belongs to the set.
    pub fn whole(&self, i: isize, j: isize) -> bool {
        self.cells[self.place(i, j)] & WHOLE != 0
    }

    /// Values of chi at the corners of a quarter: centre of the cell, middle of the side along x, along y, corner of the cell.
    pub fn fade(&self, i: isize, j: isize, quarter: usize) -> [f64; 4] {
        let centre = (self.first(i, j) + self.width() + 1) as isize;
        let along = if quarter & 1 == 1 { 1 } else { -1 };
        let across = self.width() as isize * if quarter & 2 == 2 { 1 } else { -1 };
        [0, along, across, along + across].map(|offset| f64::from(u8::from(self.lit[(centre + offset) as usize])))
    }

    /// Whether w may differ from zero in a quarter.
    pub fn holds(&self, i: isize, j: isize, quarter: usize) -> bool {
        self.cells[self.place(i, j)] >> quarter & 1 == 1 || self.fade(i, j, quarter) != [0.0; 4]
    }

    /// Whether w may differ from zero in a cell.
    pub fn touches(&self, i: isize, j: isize) -> bool {
        let (first, width) = (self.first(i, j), self.width());
        self.cells[self.place(i, j)] != 0
            || (0..3).any(|b| self.lit[first + b * width..first + b * width + 3].iter().any(|l| *l))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chi_is_one_on_the_cells_and_fades_over_half_a_cell() {
        let set = Extension::of_cells([3, 3], |i, j| (i, j) == (1, 1) || (i, j) == (2, 0));
        assert_eq!(set.fade(1, 1, 3), [1.0; 4]);
        // Left of the cell: its quarters at s > 0.
        assert_eq!(set.fade(0, 1, 3), [0.0, 1.0, 0.0, 1.0]);
        assert!(!set.holds(0, 1, 2) && set.holds(0, 1, 1));
        // Between the two: beside one, above the other.
        assert_eq!(set.fade(2, 1, 0), [0.0, 1.0, 1.0, 1.0]);
        // Beyond a corner.
        assert_eq!(set.fade(0, 0, 3), [0.0, 0.0, 0.0, 1.0]);
        assert!(!set.reaches_border());
        // Outside the grid.
        assert_eq!(set.fade(3, 0, 2), [0.0, 1.0, 0.0, 1.0]);
        assert!(set.touches(3, -1) && !set.touches(-1, 3));
    }
}
