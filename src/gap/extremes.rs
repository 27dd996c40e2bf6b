//! Least and greatest value of rectangular blocks of cells, from a pyramid of blocks that double.

/// Blocks of 1, 2, 4, ... cells a side, each with its least and greatest value.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Extremes {
    levels: Vec<Level>,
}

#[derive(Debug, Clone, PartialEq)]
struct Level {
    shape: [usize; 2],
    /// Least value of the cells with one, greatest of all: infinite with a cell that has none.
    values: Vec<[f64; 2]>,
}

/// A cell without a value.
const HOLE: [f64; 2] = [f64::INFINITY; 2];

fn together(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

impl Extremes {
    /// From the least and greatest value of each cell; `None` where there is a hole.
    pub fn new(shape: [usize; 2], cell: impl Fn(usize, usize) -> Option<[f64; 2]>) -> Self {
        let cells = (0..shape[1]).flat_map(|j| (0..shape[0]).map(move |i| (i, j)));
        let mut levels = vec![Level { shape, values: cells.map(|(i, j)| cell(i, j).unwrap_or(HOLE)).collect() }];
        while let Some(fine) = levels.last().filter(|level| level.values.len() > 1) {
            let [nx, ny] = fine.shape;
            let shape = [nx.div_ceil(2), ny.div_ceil(2)];
            let block = |i: usize, j: usize| {
                let inner =
                    (2 * j..(2 * j + 2).min(ny)).flat_map(|m| (2 * i..(2 * i + 2).min(nx)).map(move |n| (n, m)));
                inner.map(|(n, m)| fine.values[m * nx + n]).fold([f64::INFINITY, f64::NEG_INFINITY], together)
            };
            let values =
                (0..shape[1]).flat_map(|j| (0..shape[0]).map(move |i| (i, j))).map(|(i, j)| block(i, j)).collect();
            levels.push(Level { shape, values });
        }
        Self { levels }
    }

    /// Bounds over the cells from the first to the last along x and y: those of the blocks that cover them, of a size of which a
    /// few are enough.
    pub fn over(&self, [columns, rows]: [[usize; 2]; 2]) -> [f64; 2] {
        let longest = (columns[1] - columns[0]).max(rows[1] - rows[0]) + 1;
        let level = (longest / ACROSS).checked_ilog2().map_or(0, |k| k as usize + 1).min(self.levels.len() - 1);
        let Level { shape, values } = &self.levels[level];
        let mut found = [f64::INFINITY, f64::NEG_INFINITY];
        for j in rows[0] >> level..=rows[1] >> level {
            for i in columns[0] >> level..=columns[1] >> level {
                found = together(found, values[j * shape[0] + i]);
            }
        }
        found
    }
}

/// Blocks along the longer side that bounds are put together from, at least half as many.
const ACROSS: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_their_cells() {
        let value = |i: usize, j: usize| ((3 * i + 7 * j) as f64).sin();
        let shape = [131, 57];
        let extremes = Extremes::new(shape, |i, j| (i != 40 || j != 20).then(|| [value(i, j); 2]));
        for k in 0..300 {
            let of = |n: usize, m: usize| {
                let (a, b) = ((n * 37) % m, (n * 91 + 5) % m);
                [a.min(b), a.max(b)]
            };
            let (columns, rows) = (of(k, shape[0]), of(k + 11, shape[1]));
            let [low, high] = extremes.over([columns, rows]);
            for j in rows[0]..=rows[1] {
                for i in columns[0]..=columns[1] {
                    assert!(low <= value(i, j) && value(i, j) <= high);
                }
            }
        }
        let one = extremes.over([[3, 3], [4, 4]]);
        assert_eq!(one, [value(3, 4); 2]);
    }
}
