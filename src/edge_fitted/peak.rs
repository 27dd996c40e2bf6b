//! What the largest pressure of cells in rows leaves open: it is that of a cell, and the peak lies between two of them.

/// What the pressure is less by beside the largest one, over that: along a row and across, on the side where it is less so; rows of
/// pressures.
pub(super) fn drop(rows: &[&[f64]]) -> f64 {
    let cells = rows.iter().enumerate().flat_map(|(k, row)| row.iter().enumerate().map(move |(j, p)| (k, j, *p)));
    let Some((k, j, most)) = cells.max_by(|a, b| a.2.total_cmp(&b.2)).filter(|largest| largest.2 > 0.0) else {
        return 0.0;
    };
    let at = |k: Option<usize>, j: Option<usize>| rows.get(k?)?.get(j?).map(|p| 1.0 - p / most);
    let less = |sides: [Option<f64>; 2]| sides.into_iter().flatten().fold(1.0, f64::min);
    let along = [at(k.checked_sub(1), Some(j)), at(Some(k + 1), Some(j))];
    let across = [at(Some(k), j.checked_sub(1)), at(Some(k), Some(j + 1))];
    less(along) + less(across)
}

/// What the largest pressure grows by in the next row towards the nearer end of the strip, or up to its own outer line where that row is
/// free, if it goes on as the power of the distance from that end by which it grows from the row further in: beside a steep end of the
/// contact p ~ s^-a up to a peak that one row or two hold. Without it a peak in two nearly equal rows was off by four times what was said.
/// `largest`: by row.
pub(super) fn growth(largest: &[f64], lines: &[f64]) -> f64 {
    let Some(peak) = (0..largest.len()).max_by(|&a, &b| largest[a].total_cmp(&largest[b])) else { return 0.0 };
    let last = largest.len() - 1;
    // Rows and lines counted from the nearer end.
    let first = 2 * peak <= last;
    let line = |k: usize| if first { lines[k] - lines[0] } else { lines[last + 1] - lines[last + 1 - k] };
    let of = |k: usize| largest[if first { k } else { last - k }];
    let k = if first { peak } else { last - peak };
    let middle = |k: usize| 0.5 * (line(k) + line(k + 1));
    let outer = if k > 0 && of(k - 1) > 0.0 { middle(k - 1) } else { line(k) };
    if k == last || !(of(k + 1) > 0.0) {
        return 0.0;
    }
    let power = (of(k) / of(k + 1)).ln() / (middle(k + 1) / middle(k)).ln();
    (middle(k) / outer).powf(power) - 1.0
}
