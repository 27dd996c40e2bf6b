//! Largest differences within a block around every cell: maxima and minima of sliding windows, in a few passes.

/// For each cell of a grid the largest difference between its value and any in the block of half sides `half` around it;
/// `padded` holds the grid with a problem as wide as that.
pub(super) fn spread(padded: &[f64], shape: [usize; 2], half: [usize; 2]) -> Vec<f64> {
    let high = slide(padded, shape, half, |a, b| if a > b { a } else { b });
    let low = slide(padded, shape, half, |a, b| if a < b { a } else { b });
    let width = shape[0] + 2 * half[0];
    let rows = padded.chunks_exact(width).skip(half[1]).flat_map(|row| &row[half[0]..half[0] + shape[0]]);
    rows.zip(high.iter().zip(&low)).map(|(q, (high, low))| (high - q).max(q - low)).collect()
}

/// `pick` of all values in the block around every cell. Windows of twice the length from two of half of it.
fn slide(padded: &[f64], [nx, ny]: [usize; 2], half: [usize; 2], pick: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let (width, span) = (nx + 2 * half[0], half.map(|n| 2 * n + 1));
    let mut rows = Vec::with_capacity(nx * (ny + 2 * half[1]));
    let mut row = vec![0.0; width];
    for from in padded.chunks_exact(width) {
        row.copy_from_slice(from);
        let mut reach = 1;
        while 2 * reach <= span[0] {
            for k in 0..width - reach {
                row[k] = pick(row[k], row[k + reach]);
            }
            reach *= 2;
        }
        let shift = span[0] - reach;
        rows.extend((0..nx).map(|k| pick(row[k], row[k + shift])));
    }
    let mut reach = 1;
    while 2 * reach <= span[1] {
        let end = rows.len() - nx * reach;
        for k in 0..end {
            rows[k] = pick(rows[k], rows[k + nx * reach]);
        }
        reach *= 2;
    }
    let shift = (span[1] - reach) * nx;
    (0..nx * ny).map(|k| pick(rows[k], rows[k + shift])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_differences_are_those_of_every_pair() {
        let (shape, half) = ([7, 6], [3, 2]);
        let width = shape[0] + 2 * half[0];
        let padded: Vec<f64> = (0..width * (shape[1] + 2 * half[1])).map(|k| (k * 29 % 31) as f64).collect();
        for (k, found) in spread(&padded, shape, half).into_iter().enumerate() {
            let (i, j) = (k % shape[0], k / shape[0]);
            let at = |a: usize, b: usize| padded[(j + b) * width + i + a];
            let block = (0..=2 * half[1]).flat_map(|b| (0..=2 * half[0]).map(move |a| (a, b)));
            let largest = block.map(|(a, b)| (at(a, b) - at(half[0], half[1])).abs()).fold(0.0, f64::max);
            assert_eq!(found, largest);
        }
    }
}
