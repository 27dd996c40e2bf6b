//! Influence coefficients: the displacement in one cell by unit pressure on another (E* = 1).
//!
//! For a rectangle of sides h_x, h_y and an offset of (i, j) cells, with r the distance:
//!
//! | kernel | coefficient |
//! |---|---|
//! | [`Kernel::Collocation`] | 1/pi times the integral of 1/r over the loaded cell, r from the centre of the other (Love 1929) |
//! | [`Kernel::Galerkin`] | the mean of that over the other cell |
//!
//! Differences of the closed form lose every digit with distance, so they are taken in double-double arithmetic, and only
//! near the cell. Further out a Gauss rule takes over direction by direction: a slender cell is near along its long side
//! and far along the short one. Beyond 12 longest sides the series of 1/r holds. Relative error below 1e-12 everywhere.

mod double_double;
mod far;
mod love;
mod table;

use std::f64::consts::FRAC_1_PI;

use crate::grid::Kernel;
use far::Series;
use love::Corners;

pub use table::InfluenceTable;

/// Displacement in a cell by unit pressure on the cell `offset` away, E* = 1; a length, in the unit of `spacing`.
///
/// `spacing`: the sides of a cell, positive. Symmetric in the sign of the offset. Relative error below 1e-12 for
/// offsets up to 4096 cells and more, and for aspect ratios up to 1e4.
///
/// ```
/// use contact_patch::{Kernel, influence};
///
/// // Far away a cell is a point force: area/(pi r).
/// let far = influence::coefficient(Kernel::Galerkin, [2.0, 1.0], [0, 1000]);
/// assert!((far * std::f64::consts::PI * 1000.0 / 2.0 - 1.0).abs() < 1e-6);
/// ```
#[must_use]
pub fn coefficient(kernel: Kernel, spacing: [f64; 2], offset: [i64; 2]) -> f64 {
    let (h, scale) = scaled(spacing);
    scale * coefficient_by(&Series::new(kernel, h), kernel, h, offset, &mut Corners::default())
}

/// Sides in units of the longer one, and the longer one.
fn scaled(spacing: [f64; 2]) -> ([f64; 2], f64) {
    let longer = spacing[0].max(spacing[1]);
    ([spacing[0] / longer, spacing[1] / longer], longer)
}

/// The coefficient for a cell whose longer side is 1.
fn coefficient_by(series: &Series, kernel: Kernel, h: [f64; 2], offset: [i64; 2], corners: &mut Corners) -> f64 {
    let [mut i, mut j] = offset.map(i64::abs);
    let mut h = h;
    let r = (i as f64 * h[0]).hypot(j as f64 * h[1]);
    if r >= far::SERIES {
        return FRAC_1_PI * series.value(i as f64 * h[0], j as f64 * h[1]);
    }
    if h[1] > h[0] {
        (h, i, j) = ([h[1], h[0]], j, i);
    }
    if r >= far::GAUSS {
        return FRAC_1_PI * far::both(kernel, h, [i as f64 * h[0], j as f64 * h[1]]);
    }
    // Along the long side the closed form has singular points at the ends of the weight.
    let end = match kernel {
        Kernel::Galerkin => (i as f64 - 1.0).max(0.0),
        Kernel::Collocation => (i as f64 - 0.5).max(0.0),
    };
    let d = (end * h[0]).hypot(j as f64 * h[1]) / h[1];
    FRAC_1_PI
        * if d >= far::GAUSS { far::across(kernel, h, [i, j], d) } else { love::integral(kernel, h, [i, j], corners) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernels() -> [(Kernel, &'static str); 2] {
        [(Kernel::Collocation, "collocation"), (Kernel::Galerkin, "galerkin")]
    }

    #[test]
    fn every_reference_value() {
        let text = include_str!("../../data/reference/influence.json");
        let reference: serde_json::Value = serde_json::from_str(text).expect("reference file");
        let mut worst = 0.0_f64;
        for entry in reference["values"].as_array().expect("values") {
            let h = [0, 1].map(|k| entry["spacing"][k].as_f64().expect("spacing"));
            let offset = [0, 1].map(|k| entry["offset"][k].as_i64().expect("offset"));
            for (kernel, name) in kernels() {
                let exact = entry[name].as_f64().expect("value");
                let error = (coefficient(kernel, h, offset) / exact - 1.0).abs();
                worst = worst.max(error);
                assert!(error < 1e-12, "{name} {h:?} {offset:?}: {error:e}");
            }
        }
        println!("worst relative error {worst:e}");
    }

    #[test]
    fn table_agrees_with_the_coefficient_and_obeys_the_symmetries() {
        for (kernel, _) in kernels() {
            for (h, shape) in
                [([1.0, 1.0], [300, 30]), ([0.3, 0.3], [20, 40]), ([2.0, 0.1], [40, 300]), ([1e-4, 1.0], [50, 20])]
            {
                let table = InfluenceTable::new(kernel, h, shape);
                for j in 0..shape[1] {
                    for i in 0..shape[0] {
                        let c = coefficient(kernel, h, [i as i64, j as i64]);
                        assert!(c > 0.0);
                        assert!((table.get(i, j) / c - 1.0).abs() < 1e-13, "{kernel:?} {h:?} {i} {j}");
                        assert_eq!(c, coefficient(kernel, h, [-(i as i64), j as i64]));
                        let swapped = coefficient(kernel, [h[1], h[0]], [-(j as i64), -(i as i64)]);
                        assert!((swapped / c - 1.0).abs() < 1e-14);
                    }
                }
            }
        }
    }

    #[test]
    fn two_cells_side_by_side_are_one_of_twice_the_side() {
        // The mean over a pair of cells by a load on a pair is the sum over the four pairs, halved: holds across all forms.
        for h in [[1.0, 1.0], [1.0, 1e-3], [7.0, 1.0], [1.0, 300.0]] {
            for (i, j) in
                [(0, 0), (1, 0), (0, 1), (2, 3), (5, 1), (1, 5), (6, 6), (0, 7), (3, 40), (500, 2), (17, 1000)]
            {
                let whole = coefficient(Kernel::Galerkin, [2.0 * h[0], h[1]], [i, j]);
                let half = |k| coefficient(Kernel::Galerkin, h, [2 * i + k, j]);
                let halves = 0.5 * (half(-1) + 2.0 * half(0) + half(1));
                assert!((halves / whole - 1.0).abs() < 1e-12, "{h:?} {i} {j}: {:e}", halves / whole - 1.0);
            }
        }
    }

    #[test]
    fn forms_meet_smoothly_where_they_take_over() {
        // Along a row 1/c is nearly linear in the offset: its second difference over c'' of the law 1/r shows a jump.
        for (kernel, _) in kernels() {
            for h in [[1.0, 1.0], [1.0, 0.01]] {
                let series = Series::new(kernel, h);
                for (i, j) in [(12, 0), (12, 1), (13, 5), (9, 9), (16, 200)] {
                    let at = [i as f64 * h[0], j as f64 * h[1]];
                    let (a, b) = (series.value(at[0], at[1]), far::both(kernel, h, at));
                    assert!((a / b - 1.0).abs() < 3e-13, "series, Gauss {kernel:?} {h:?} {i} {j}: {:e}", a / b - 1.0);
                }
                for (i, j) in [(4, 0), (5, 1), (4, 4), (3, 3)] {
                    let at = [i as f64 * h[0], j as f64 * h[1]];
                    if at[0].hypot(at[1]) >= far::GAUSS {
                        let (a, b) =
                            (love::integral(kernel, h, [i, j], &mut Corners::default()), far::both(kernel, h, at));
                        assert!(
                            (a / b - 1.0).abs() < 1e-13,
                            "Gauss, closed {kernel:?} {h:?} {i} {j}: {:e}",
                            a / b - 1.0
                        );
                    }
                }
            }
            let h = [1.0, 0.01];
            for (i, j, d) in [(0, 4, 4.0), (0, 9, 9.0), (1, 5, 5.0), (2, 0, 100.0), (3, 2, 200.0)] {
                let (a, b) =
                    (love::integral(kernel, h, [i, j], &mut Corners::default()), far::across(kernel, h, [i, j], d));
                assert!((a / b - 1.0).abs() < 1e-12, "across, closed {kernel:?} {i} {j}: {:e}", a / b - 1.0);
            }
        }
    }
}
