//! Distances to the load, in cells.

/// How many cells each cell is away from the nearest loaded one, along the longer of the two ways; a large number without load.
pub(super) fn away(q: &[f64], [nx, ny]: [usize; 2]) -> Vec<u32> {
    let mut away: Vec<u32> = q.iter().map(|&q| if q > 0.0 { 0 } else { u32::from(u16::MAX) }).collect();
    // Two passes over the neighbours that come before in their order: steps along both axes count as one.
    let mut pass = |order: &mut dyn Iterator<Item = usize>, sense: isize| {
        for k in order {
            let (i, j) = (k % nx, k / nx);
            for [di, dj] in [[-1, 0], [-1, -1], [0, -1], [1, -1]] {
                let (Some(i), Some(j)) = (i.checked_add_signed(sense * di), j.checked_add_signed(sense * dj)) else {
                    continue;
                };
                if i < nx && j < ny {
                    away[k] = away[k].min(away[j * nx + i] + 1);
                }
            }
        }
    };
    pass(&mut (0..nx * ny), 1);
    pass(&mut (0..nx * ny).rev(), -1);
    away
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_away_from_the_load_along_the_longer_way() {
        let shape = [9, 7];
        let mut q = vec![0.0; 63];
        for loaded in [[2_usize, 1_usize], [8, 6], [0, 5]] {
            q[loaded[1] * 9 + loaded[0]] = 1.0;
        }
        for (k, found) in away(&q, shape).into_iter().enumerate() {
            let (i, j) = (k % 9, k / 9);
            let to = |a: usize, b: usize| i.abs_diff(a).max(j.abs_diff(b)) as u32;
            assert_eq!(found, to(2, 1).min(to(8, 6)).min(to(0, 5)), "{i} {j}");
        }
    }
}
