//! Mirrors of a pressure in the middle of its grid: cells that they map to each other displace alike and are worked out once.
//! Of the gap nothing is presumed: it is looked at in every cell, unless it is known to have the same mirror.

use super::problem::BracketProblem;

/// Pressures that differ by less than this share of the largest are evened out.
const SAME: f64 = 1e-6;

/// Along which axes the pressure is its own image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mirrors {
    shape: [usize; 2],
    on: [bool; 2],
    /// Whether the gap is its own image, too.
    gap: [bool; 2],
}

/// A cell, and the axes along which it is turned round against the one that was worked out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Image {
    pub cell: usize,
    turned: [bool; 2],
}

impl Mirrors {
    /// Evens out a pressure that is nearly symmetric.
    pub fn found(q: &mut [f64], problem: &BracketProblem) -> Self {
        let (grid, gap, at) = (&problem.grid, problem.gap.known().mirrors, problem.gap.known().centre);
        let gap = [0, 1].map(|m| gap[m] && grid.is_centred_on(m, at[m]));
        Self::of(q, grid.shape, gap)
    }

    fn of(q: &mut [f64], shape: [usize; 2], gap: [bool; 2]) -> Self {
        let largest = q.iter().copied().fold(0.0, f64::max);
        let mut mirrors = Self { shape, on: [false; 2], gap };
        for axis in 0..2 {
            let alike = |k: usize| (q[k] - q[mirrors.image(k, axis)]).abs() <= SAME * largest;
            mirrors.on[axis] = (0..q.len()).all(alike);
            mirrors.gap[axis] &= mirrors.on[axis];
        }
        mirrors.even_out(q);
        mirrors
    }

    /// Makes a pressure symmetric that should be.
    pub fn even_out(&self, q: &mut [f64]) {
        for axis in (0..2).filter(|&axis| self.on[axis]) {
            for k in 0..q.len() {
                let image = self.image(k, axis);
                if image > k {
                    let mean = 0.5 * (q[k] + q[image]);
                    (q[k], q[image]) = (mean, mean);
                }
            }
        }
    }

    fn image(&self, cell: usize, axis: usize) -> usize {
        let [nx, ny] = self.shape;
        let (i, j) = (cell % nx, cell / nx);
        if axis == 0 { j * nx + nx - 1 - i } else { (ny - 1 - j) * nx + i }
    }

    /// One cell of each set of images, the one that lies furthest up.
    pub fn firsts(self) -> impl Iterator<Item = usize> {
        let [nx, ny] = self.shape;
        let from = |axis: usize| if self.on[axis] { self.shape[axis] / 2 } else { 0 };
        let (left, low) = (from(0), from(1));
        (low..ny).flat_map(move |j| (left..nx).map(move |i| j * nx + i))
    }

    /// A cell and its images, without those in mirrors that the gap has.
    pub fn images(self, cell: usize) -> impl Iterator<Item = Image> {
        let turns = [[false, false], [true, false], [false, true], [true, true]];
        turns.into_iter().filter_map(move |turned| {
            let mut place = cell;
            for axis in (0..2).filter(|&axis| turned[axis]) {
                let image = self.image(place, axis);
                if !self.on[axis] || self.gap[axis] || image == place {
                    return None;
                }
                place = image;
            }
            Some(Image { cell: place, turned })
        })
    }

    /// How many cells each that is looked at stands for.
    pub fn fold(&self) -> usize {
        self.gap.iter().map(|&on| if on { 2 } else { 1 }).product()
    }

    /// Copies what holds of the cells that were looked at to their images in the mirrors that the gap has.
    pub fn unfold(&self, field: &mut [f64]) {
        let [nx, ny] = self.shape;
        if self.gap[0] {
            for row in field.chunks_exact_mut(nx) {
                let (low, high) = row.split_at_mut(nx / 2);
                low.iter_mut().zip(high.iter().rev()).for_each(|(low, high)| *low = *high);
            }
        }
        if self.gap[1] {
            for j in 0..ny / 2 {
                field.copy_within((ny - 1 - j) * nx..(ny - j) * nx, j * nx);
            }
        }
    }
}

impl Image {
    /// Where a point of the cell that was worked out lies in this one, sides from the centre; slopes alike.
    pub fn turn(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|m| if self.turned[m] { -at[m] } else { at[m] })
    }

    /// The same for quarters in the order of [`super::polynomial::QUARTERS`].
    pub fn quarter(&self, k: usize) -> usize {
        k ^ (usize::from(self.turned[0]) + 2 * usize::from(self.turned[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_make_up_the_grid_and_carry_the_same_pressure() {
        for shape in [[6, 5], [5, 4], [7, 7], [4, 6]] {
            let at = |k: usize, axis: usize| [k % shape[0], k / shape[0]][axis] as f64 - 0.5 * (shape[axis] - 1) as f64;
            for on in [[true, true], [true, false], [false, true], [false, false]] {
                let odd = |axis: usize, k: usize| if on[axis] { at(k, axis).abs() } else { at(k, axis) + 0.3 };
                let cells = shape[0] * shape[1];
                let mut q: Vec<f64> = (0..cells).map(|k| 9.0 + odd(0, k) + 1.7 * odd(1, k)).collect();
                let mirrors = Mirrors::of(&mut q, shape, [false; 2]);
                assert_eq!(mirrors.on, on);
                let mut seen = vec![0; cells];
                for cell in mirrors.firsts() {
                    for image in mirrors.images(cell) {
                        seen[image.cell] += 1;
                        assert_eq!(q[image.cell], q[cell]);
                        let turned = image.turn([at(cell, 0), at(cell, 1)]);
                        assert_eq!(turned, [at(image.cell, 0), at(image.cell, 1)]);
                    }
                }
                assert!(seen.iter().all(|&n| n == 1), "{shape:?} {on:?}");
                for gap in [[true, true], [false, true], [true, false]] {
                    let mirrors = Mirrors::of(&mut q, shape, gap);
                    let mut copied = vec![f64::NAN; cells];
                    let all: Vec<Image> = mirrors.firsts().flat_map(|first| mirrors.images(first)).collect();
                    all.iter().for_each(|image| copied[image.cell] = q[image.cell]);
                    mirrors.unfold(&mut copied);
                    assert_eq!(copied, q, "{shape:?} {on:?} {gap:?}");
                    assert!(all.len() >= cells / mirrors.fold());
                }
            }
        }
    }
}
