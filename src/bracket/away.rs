//! Distances to the load, in cells.

/// How many cells each cell is away from the nearest loaded one, along the longer of the two ways; a large number without load.
pub(super) fn away(q: &[f64], [nx, ny]: [usize; 2]) -> Vec<u32> {
    let mut away: Vec<u32> = q.iter().map(|&q| if q > 0.0 { 0 } else { u32::from(u16::MAX) }).collect();
    let mut pass = |order: &mut dyn Iterator<Item = usize>, back: bool| {
        for k in order {
            let (i, j) = (k % nx, k / nx);
            let (behind_i, behind_j) = if back { (i + 1 < nx, j + 1 < ny) } else { (i > 0, j > 0) };
            let step = |di: bool, dj: bool, mirrored: bool| {
                let i = match (di, mirrored != back) {
                    (false, _) => i,
                    (true, false) => i.wrapping_sub(1),
                    (true, true) => i + 1,
                };
                let j = if !dj {
                    j
                } else if back {
                    j + 1
                } else {
                    j - 1
                };
                away.get(j * nx + i.min(nx - 1)).map_or(u32::MAX - 1, |a| a + 1)
            };
            let mut least = away[k];
            if behind_i {
                least = least.min(step(true, false, false));
            }
            if behind_j {
                least = least.min(step(false, true, false));
                if behind_i {
                    least = least.min(step(true, true, false));
                }
                if if back { i > 0 } else { i + 1 < nx } {
                    least = least.min(step(true, true, true));
                }
            }
            away[k] = least;
        }
    };
    pass(&mut (0..nx * ny), false);
    pass(&mut (0..nx * ny).rev(), true);
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
