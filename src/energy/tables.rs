//! What the cells around one do to the displacement in it, for cells of one aspect ratio.
//!
//! With L_j the displacement by unit pressure on the cell at offset j, I g the polynomial that the means of g over 7 x 7 cells
//! determine ([`super::basis`]), and p_j the pressures around a cell under pressure p_0,
//!
//!   u = I u + sum over j of (p_j - p_0) (L_j - I L_j).
//!
//! (The terms with p_0 add up to nothing: pressure p_0 everywhere moves the surface as one.) L_j - I L_j falls like |j|^-8. Of the
//! eight cells that touch the middle one it is kept as it is, logarithms at the sides included: as the projection of L_j on the
//! polynomials, and Z_j, orthogonal to all of them. Of the cells of a near block it is a polynomial. What that leaves out, and the
//! cells beyond, count by their norms.

use std::sync::{Arc, Mutex, PoisonError};

use super::basis::{CLASSES, DEGREES, NODES, legendre, slopes, through};
use super::potential::Corners;
use super::quarter::Rule;
use super::rest::{beyond, norms, supremum};
use super::square_cells::NUMBERS;
use super::touching::{FIRSTS, SINGULAR, Touching};
use crate::grid::Kernel;
use crate::influence::InfluenceTable;
use crate::numeric::quadrature::GaussLegendre;

/// Half side of the near block, in longer sides of a cell, less half a cell.
const NEAR: f64 = 4.0;

/// The same for the cells whose norms are added one by one.
const FAR: f64 = 20.0;

/// Points along half a side for the integrals of Z_j: in the inner half of it, and in the outer half.
const FINE: [usize; 2] = [6, 10];

/// The outer half is put at the cube of the nodes from the side, where the slopes have a logarithm.
const GRADING: i32 = 3;

/// Aspect ratio up to which tables are made: of more slender cells those next but one along the short side are too close for
/// polynomials of degree 4.
pub(super) const MOST_SLENDER: f64 = 2.0;

/// Largest half side of a near block: that of the most slender cells.
pub(super) const WIDEST: usize = 8;

/// Weights of each class for square cells.
const SQUARE_WEIGHTS: [usize; 4] = [225, 120, 120, 64];

/// Tables that are kept.
const MOST_KEPT: usize = 8;

/// What is left out, per unit of the root of the sum of squares of the differences of the pressure along x and along y.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rest {
    /// Of the gradient.
    pub gradient: [f64; 2],
    /// Of the value.
    pub value: [f64; 2],
}

/// Tables for cells of sides `h`, the longer one 1.
#[derive(Debug)]
pub(super) struct Tables {
    pub h: [f64; 2],
    /// Half sides of the near block, in cells.
    pub near: [usize; 2],
    /// For each class, coefficient by coefficient: the weights of the sums of the images, with the signs of the class, of the cells of the
    /// near block at (a, b) >= 0 (a fastest; those that touch and those that the class does not have left out), of the singular
    /// functions, and in the first class of the pressure itself.
    pub weights: [Vec<f64>; 4],
    /// Integrals of products of singular functions, and of their gradients, of one class.
    pub values: [[f64; 3]; 8],
    pub gradients: [[f64; 3]; 8],
    /// Integrals of grad Z . grad P, P in the order of the class.
    pub mixed: [[f64; 9]; 8],
    pub rest: Rest,
    /// Supremum of what is left out by unit pressure on all cells around: within the near block, and beyond.
    pub most: [f64; 2],
    /// For cells that are integrated quarter by quarter.
    pub rule: Rule,
}

impl Tables {
    /// For cells of these sides; `None` for slender ones. The last few are kept.
    pub fn of(spacing: [f64; 2]) -> Option<Arc<Self>> {
        static KEPT: Mutex<Vec<Arc<Tables>>> = Mutex::new(Vec::new());
        let longer = spacing[0].max(spacing[1]);
        // Grids over a rectangle have sides that differ by rounding: the tables then do by as much.
        let h = spacing.map(|s| if s > longer * (1.0 - 1e-13) { 1.0 } else { s / longer });
        if !(h[0].min(h[1]) * MOST_SLENDER >= 1.0) {
            return None;
        }
        let kept = || KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept().iter().find(|t| t.h == h) {
            return Some(known.clone());
        }
        let tables = Arc::new(Self::new(h));
        let mut kept = kept();
        if kept.len() >= MOST_KEPT {
            kept.remove(0);
        }
        kept.push(tables.clone());
        Some(tables)
    }

    fn new(h: [f64; 2]) -> Self {
        if h == [1.0; 2] {
            return Self::square();
        }
        let (mut tables, projections) = Self::computed(h);
        tables.rule = Rule::new(h, &projections);
        tables
    }

    /// Without functions.
    fn empty(h: [f64; 2]) -> Self {
        Self {
            h,
            near: h.map(|side| (NEAR / side).ceil() as usize),
            weights: Default::default(),
            values: [[0.0; 3]; 8],
            gradients: [[0.0; 3]; 8],
            mixed: [[0.0; 9]; 8],
            rest: Rest::default(),
            most: [0.0; 2],
            rule: Rule::empty(h),
        }
    }

    /// All but the rule, and the projections of the cells (1, 0), (0, 1), (1, 1) that it takes.
    fn computed(h: [f64; 2]) -> (Self, [[[f64; 5]; 5]; 3]) {
        let far = h.map(|side| (FAR / side).ceil() as usize);
        let means = Means::new(h, far);
        let mut tables = Self::empty(h);
        let near = tables.near;
        let mut block = vec![[[0.0; 5]; 5]; (near[0] + 1) * (near[1] + 1)];
        tables.smooth::<8>(&means, near, [1; 2], &mut block);
        tables.smooth::<6>(&means, far, near, &mut block);
        let [gradient, value] = beyond(FAR, h);
        for m in 0..2 {
            tables.rest.gradient[m] += gradient;
            tables.rest.value[m] += value;
        }
        tables.most[1] += value;
        let (touching, projections) = tables.singular(&means);
        tables.collect(&block, &touching);
        (tables, projections)
    }

    /// For square cells: the numbers of [`super::square_cells`] in place of their computation.
    fn square() -> Self {
        let mut tables = Self::empty([1.0; 2]);
        for (class, weights) in tables.weights.iter_mut().enumerate() {
            weights.resize(SQUARE_WEIGHTS[class], 0.0);
        }
        let mut projections = [[[0.0; 5]; 5]; 3];
        tables.numbers(&mut projections).zip(NUMBERS).for_each(|(to, number)| *to = number);
        tables.rule = Rule::new(tables.h, &projections);
        tables
    }

    /// All that is computed, in the order of [`super::square_cells`].
    fn numbers<'a>(&'a mut self, projections: &'a mut [[[f64; 5]; 5]; 3]) -> impl Iterator<Item = &'a mut f64> {
        let forms = self.values.iter_mut().flatten().chain(self.gradients.iter_mut().flatten());
        let mixed = self.mixed.iter_mut().flatten();
        let rest = self.rest.gradient.iter_mut().chain(&mut self.rest.value).chain(&mut self.most);
        let projections = projections.iter_mut().flatten().flatten();
        self.weights.iter_mut().flatten().chain(forms).chain(mixed).chain(rest).chain(projections)
    }

    /// Puts the weights of each class together.
    fn collect(&mut self, block: &[[[f64; 5]; 5]], touching: &[[f64; 9]; 8]) {
        let [nx, ny] = self.near;
        for class in 0..4 {
            let odd = [class & 1, class >> 1];
            for (k, [m, n]) in DEGREES[CLASSES[class]..CLASSES[class + 1]].iter().enumerate() {
                let mut uniform = 0.0;
                for b in 0..=ny {
                    for a in (0..=nx).filter(|a| *a > 1 || b > 1) {
                        // The sums of images count those of offset 0 twice.
                        let images = if a == 0 || b == 0 { 2.0 } else { 4.0 };
                        let c = block[b * (nx + 1) + a][*n][*m];
                        uniform += images * c;
                        if a >= odd[0] && b >= odd[1] {
                            self.weights[class].push(0.25 * images * c);
                        }
                    }
                }
                self.weights[class].extend((FIRSTS[class]..FIRSTS[class + 1]).map(|f| touching[f][k]));
                if class == 0 {
                    self.weights[class].push(-uniform);
                }
            }
        }
    }

    /// Cells that do not touch: with polynomials up to degree N - 1, those within `within` and not within `without`.
    fn smooth<const N: usize>(
        &mut self,
        means: &Means,
        within: [usize; 2],
        without: [usize; 2],
        block: &mut [[[f64; 5]; 5]],
    ) {
        let h = self.h;
        let square = h[0] == h[1];
        let rule = GaussLegendre::new(N);
        let along = |m: usize| -> Vec<f64> {
            let shifted = |x: f64| (0..within[m] + 2).map(move |n| (0.5 * x - (n as f64 - 0.5)) * h[m]);
            rule.nodes().iter().flat_map(|(x, _)| shifted(*x)).collect()
        };
        let corners = Corners::new(&along(0), &along(1));
        let projection = Projection::<N>::new(&rule);
        for b in 0..=within[1] {
            for a in 0..=within[0] {
                // Of square cells what lies at (a, b) is the transpose of what lies at (b, a).
                if a <= without[0] && b <= without[1] || square && b > a {
                    continue;
                }
                let at = |k: usize, l: usize| {
                    let (x, y) = (k * (within[0] + 2) + a, l * (within[1] + 2) + b);
                    corners.cell([x + 1, x], [y + 1, y])[0]
                };
                let mut c = projection.of(at);
                let nodal = means.polynomial([a, b]);
                for (row, nodal) in c.iter_mut().zip(nodal) {
                    row.iter_mut().zip(nodal).for_each(|(c, n)| *c -= n);
                }
                let mut images = if a == 0 || b == 0 { 2.0 } else { 4.0 };
                let near = a <= self.near[0] && b <= self.near[1];
                if near {
                    let own: [[f64; 5]; 5] = std::array::from_fn(|n| std::array::from_fn(|m| c[n][m]));
                    block[b * (self.near[0] + 1) + a] = own;
                    if square {
                        block[a * (self.near[0] + 1) + b] = std::array::from_fn(|n| own.map(|row| row[n]));
                    }
                    c.iter_mut().take(5).for_each(|row| row[..5].fill(0.0));
                }
                let mut steps = [a as f64, b as f64];
                if square && a != b {
                    images *= 2.0;
                    steps = [0.5 * (steps[0] + steps[1]); 2];
                }
                self.most[usize::from(!near)] += images * supremum(&c);
                let [gradient, value] = norms(&c, h);
                for (m, steps) in steps.into_iter().enumerate() {
                    self.rest.gradient[m] += images * steps * gradient;
                    self.rest.value[m] += images * steps * value;
                }
            }
        }
    }

    /// Cells that touch: the polynomials that go with the singular functions, and the projections of the three cells.
    fn singular(&mut self, means: &Means) -> ([[f64; 9]; 8], [[[f64; 5]; 5]; 3]) {
        let h = self.h;
        let fine = graded(FINE);
        let places: Vec<f64> = fine.iter().map(|(s, _)| *s).collect();
        let touching = Touching::new(h, &places, &places);
        // By class: values and gradients at the points, with the weights of the cell.
        let n = fine.len() * fine.len();
        let weight = |k: usize| 4.0 * fine[k % fine.len()].1 * fine[k / fine.len()].1;
        let area = h[0] * h[1];
        let polynomials: Vec<[[f64; 5]; 2]> = fine.iter().map(|(s, _)| [legendre(*s), slopes(*s)]).collect();
        let at = |k: usize, [a, b]: [usize; 2]| {
            let (x, y) = (&polynomials[k % fine.len()], &polynomials[k / fine.len()]);
            [x[0][a] * y[0][b], x[1][a] * y[0][b] / h[0], x[0][a] * y[1][b] / h[1]]
        };
        let mut projections = [[[0.0; 5]; 5]; 3];
        for class in 0..4 {
            let degrees = &DEGREES[CLASSES[class]..CLASSES[class + 1]];
            let mut functions: Vec<Vec<[f64; 3]>> = Vec::new();
            for &cell in SINGULAR[class] {
                let mut z: Vec<[f64; 3]> =
                    (0..n).map(|k| touching.of_class([k % fine.len(), k / fine.len()], cell, class)).collect();
                for &[a, b] in degrees {
                    let size = ((2 * a + 1) * (2 * b + 1)) as f64;
                    let c = size * (0..n).map(|k| weight(k) * z[k][0] * at(k, [a, b])[0]).sum::<f64>();
                    projections[cell][b][a] = c;
                    for (k, z) in z.iter_mut().enumerate() {
                        let p = at(k, [a, b]);
                        (0..3).for_each(|m| z[m] -= c * p[m]);
                    }
                }
                functions.push(z);
            }
            for (f, zf) in functions.iter().enumerate() {
                let row = FIRSTS[class] + f;
                for (g, zg) in functions.iter().enumerate() {
                    for (k, (p, q)) in zf.iter().zip(zg).enumerate() {
                        self.values[row][g] += area * weight(k) * p[0] * q[0];
                        self.gradients[row][g] += area * weight(k) * (p[1] * q[1] + p[2] * q[2]);
                    }
                }
                for (g, &degree) in degrees.iter().enumerate() {
                    let sum = |k: usize, z: &[f64; 3]| {
                        let p = at(k, degree);
                        area * weight(k) * (z[1] * p[1] + z[2] * p[2])
                    };
                    self.mixed[row][g] = zf.iter().enumerate().map(|(k, z)| sum(k, z)).sum();
                }
            }
        }
        let mut touching_polynomials = [[0.0; 9]; 8];
        for (cell, offset) in [[1, 0], [0, 1], [1, 1]].into_iter().enumerate() {
            let nodal = means.polynomial(offset);
            for class in 0..4 {
                let Some(place) = SINGULAR[class].iter().position(|c| *c == cell) else { continue };
                for (k, [a, b]) in DEGREES[CLASSES[class]..CLASSES[class + 1]].iter().enumerate() {
                    touching_polynomials[FIRSTS[class] + place][k] = projections[cell][*b][*a] - nodal[*b][*a];
                }
            }
        }
        (touching_polynomials, projections)
    }
}

/// Places in half a cell, from its centre, and weights; the last ones crowd towards the side.
pub(super) fn graded([inner, outer]: [usize; 2]) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> =
        GaussLegendre::new(inner).nodes().iter().map(|(x, w)| (0.125 * (1.0 + x), 0.125 * w)).collect();
    points.extend(GaussLegendre::new(outer).nodes().iter().map(|(x, w)| {
        let t = 0.5 * (1.0 - x);
        (0.5 - 0.25 * t.powi(GRADING), 0.125 * f64::from(GRADING) * t.powi(GRADING - 1) * w)
    }));
    points
}

/// Means of L_j over the cells around.
struct Means(InfluenceTable);

impl Means {
    fn new(h: [f64; 2], far: [usize; 2]) -> Self {
        Self(InfluenceTable::new(Kernel::Galerkin, h, far.map(|n| n + NODES + 1)))
    }

    /// I L_j for the cell at the offset j >= 0.
    fn polynomial(&self, [a, b]: [usize; 2]) -> [[f64; 5]; 5] {
        let mean = |k: usize, l: usize| {
            self.0.get(
                (k as i64 - 3 - a as i64).unsigned_abs() as usize,
                (l as i64 - 3 - b as i64).unsigned_abs() as usize,
            )
        };
        let rows: [[f64; 5]; 7] = std::array::from_fn(|l| through(std::array::from_fn(|k| mean(k, l))));
        let columns: [[f64; 5]; 5] = std::array::from_fn(|m| through(rows.map(|row| row[m])));
        std::array::from_fn(|n| std::array::from_fn(|m| columns[m][n]))
    }
}

/// Coefficients of P_a(2s) P_b(2t), a, b < N, by the Gauss rule of N points.
struct Projection<const N: usize>([[f64; N]; N]);

impl<const N: usize> Projection<N> {
    fn new(rule: &GaussLegendre) -> Self {
        let mut rows = [[0.0; N]; N];
        for (k, (x, w)) in rule.nodes().iter().enumerate() {
            let (mut before, mut p) = (0.0, 1.0);
            for (a, row) in rows.iter_mut().enumerate() {
                row[k] = 0.5 * (2 * a + 1) as f64 * w * p;
                let n = a as f64;
                (before, p) = (p, ((2.0 * n + 1.0) * x * p - n * before) / (n + 1.0));
            }
        }
        Self(rows)
    }

    /// Row b, column a.
    fn of(&self, at: impl Fn(usize, usize) -> f64) -> [[f64; N]; N] {
        let values: [[f64; N]; N] = std::array::from_fn(|l| std::array::from_fn(|k| at(k, l)));
        let dot = |a: &[f64; N], b: &[f64; N]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let along = values.map(|row| self.0.map(|weights| dot(&weights, &row)));
        std::array::from_fn(|b| std::array::from_fn(|a| (0..N).map(|l| self.0[b][l] * along[l][a]).sum::<f64>()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn computed() -> Vec<f64> {
        let (mut tables, mut projections) = Tables::computed([1.0; 2]);
        assert_eq!(tables.weights.each_ref().map(Vec::len), SQUARE_WEIGHTS);
        tables.numbers(&mut projections).map(|number| *number).collect()
    }

    #[test]
    fn numbers_of_square_cells_are_those_that_are_computed() {
        let computed = computed();
        assert_eq!(computed.len(), NUMBERS.len());
        // Sums of terms up to 1, on machines whose logarithms differ in the last digit.
        for (k, (computed, kept)) in computed.into_iter().zip(NUMBERS).enumerate() {
            assert!((computed - kept).abs() < 1e-13, "{k}: {computed:e} {kept:e}");
        }
    }

    #[test]
    #[ignore = "writes the file anew"]
    fn numbers_of_square_cells_are_written() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/energy/square_cells.rs");
        let head = std::fs::read_to_string(path).unwrap();
        let head = head.split("pub(super) const").next().unwrap();
        let numbers = computed();
        let mut text = format!("{head}pub(super) const NUMBERS: [f64; {}] = [\n", numbers.len());
        for line in numbers.chunks(5) {
            let line: Vec<String> = line.iter().map(|number| format!("{number:e},")).collect();
            text += &format!("    {}\n", line.join(" "));
        }
        std::fs::write(path, text + "];\n").unwrap();
    }
}
