//! Displacement by one loaded cell: at a point, and as mean over another cell.
//!
//! Near the cell a polygon integrated edge by edge (Wilton et al., IEEE Trans. Antennas Propag. 32 (1984) 276), further out Gauss.

use std::f64::consts::FRAC_1_PI;

/// Abscissae and weights of Gauss on [-1/2, 1/2].
const THREE: [(f64, f64); 3] =
    [(-0.387_298_334_620_741_7, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.387_298_334_620_741_7, 5.0 / 18.0)];
const FOUR: [(f64, f64); 4] = [
    (-0.430_568_155_797_026_3, 0.173_927_422_568_726_93),
    (-0.169_990_521_792_428_13, 0.326_072_577_431_273_07),
    (0.169_990_521_792_428_13, 0.326_072_577_431_273_07),
    (0.430_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Displacement at the offset from the middle of a cell of sides `h` under unit pressure.
pub(super) fn of_cell([a, b]: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    if x * x + y * y > 36.0 * (a * a + b * b) {
        let mut sum = 0.0;
        for (s, v) in THREE {
            for (t, w) in THREE {
                sum += v * w / (x - s * a).hypot(y - t * b);
            }
        }
        return FRAC_1_PI * a * b * sum;
    }
    // The integral of 1/r over a polygon: for each edge, distance times the difference of ln(R + l).
    let corners = [
        [-0.5 * a - x, -0.5 * b - y],
        [0.5 * a - x, -0.5 * b - y],
        [0.5 * a - x, 0.5 * b - y],
        [-0.5 * a - x, 0.5 * b - y],
    ];
    let mut sum = 0.0;
    for k in 0..4 {
        let (p, q) = (corners[k], corners[(k + 1) % 4]);
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        let along = [(q[0] - p[0]) / length, (q[1] - p[1]) / length];
        let distance = p[0] * along[1] - p[1] * along[0];
        let (l1, l2) = (p[0] * along[0] + p[1] * along[1], q[0] * along[0] + q[1] * along[1]);
        let (r1, r2) = (p[0].hypot(p[1]), q[0].hypot(q[1]));
        if distance != 0.0 {
            sum += distance * if l1 + l2 >= 0.0 { ((r2 + l2) / (r1 + l1)).ln() } else { ((r1 - l1) / (r2 - l2)).ln() };
        }
    }
    FRAC_1_PI * sum
}

/// Mean over the cell at this offset: Gauss on parts that are small against their distance from the loaded cell. Where the
/// two touch, the points crowd towards the borders, across which the slope of the displacement is infinite.
pub(super) fn mean_over_cell(h: [f64; 2], offset: [f64; 2]) -> f64 {
    let apart = [0, 1].map(|m| (offset[m].abs() - h[m]).max(0.0));
    let distance = apart[0].hypot(apart[1]);
    let touching = distance <= 1e-9 * h[0].min(h[1]);
    let nodes = |m: usize| -> Vec<(f64, f64)> {
        let parts = if touching { 16 } else { ((1.5 * h[m] / distance).ceil() as usize).clamp(1, 16) };
        let share = |k: usize, (s, w): (f64, f64)| ((k as f64 + 0.5 + s) / parts as f64, w / parts as f64);
        let even = (0..parts).flat_map(|k| FOUR.into_iter().map(move |node| (k, node))).map(|(k, node)| share(k, node));
        let crowded =
            |(t, w): (f64, f64)| if touching { (t * t * (3.0 - 2.0 * t), w * 6.0 * t * (1.0 - t)) } else { (t, w) };
        even.map(crowded).map(|(t, w)| (offset[m] + h[m] * (t - 0.5), w)).collect()
    };
    let (xs, ys) = (nodes(0), nodes(1));
    xs.iter().map(|(x, v)| ys.iter().map(|(y, w)| v * w * of_cell(h, [*x, *y])).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacement_of_a_cell_by_two_routes() {
        // Love, in the middle of a unit square: 4 asinh(1)/pi.
        let middle = of_cell([1.0, 1.0], [0.0, 0.0]);
        assert!((middle - 4.0 * FRAC_1_PI * 1f64.asinh()).abs() < 1e-14);
        for h in [[1.0, 0.7], [1.0, 0.1]] {
            for at in [[0.3, 0.1], [0.9, -0.6], [2.0, 1.0], [3.5, 0.4], [-8.0, 3.0], [20.0, 1.0]] {
                let other = crate::bracket::kernel::displacement(h, at[0], at[1])[0];
                assert!((of_cell(h, at) / other - 1.0).abs() < 1e-8, "{h:?} {at:?}");
            }
        }
    }

    #[test]
    fn means_over_cells_are_those_of_the_grid_solvers() {
        let h = [0.3, 0.2];
        let table = crate::InfluenceTable::new(crate::Kernel::Galerkin, h, [6, 6]);
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1), (3, 2), (5, 5)] {
            let other = table.get(i, j);
            let own = mean_over_cell(h, [i as f64 * h[0], j as f64 * h[1]]);
            assert!((own / other - 1.0).abs() < 1e-7, "{i} {j}: {own} {other}");
        }
    }
}
