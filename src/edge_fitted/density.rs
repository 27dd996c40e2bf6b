//! Where lines between cells lie by the pressure that a coarser mesh found: their density 1/h is a power of G, the integral of (dp/dx)^2 over
//! the other direction ([`super::equidistributed`], (1)).

/// The least density of lines, over their mean.
const LEAST: f64 = 0.25;

/// Cells beside the contact that was found, to either side: fewer and wider ones may touch further out.
const BESIDE: usize = 2;

/// Parts of the cells beside a sharp edge by which the density there is told.
const PARTS: usize = 16;

/// Pressures between lines in two directions.
pub(super) struct OnLines {
    /// Of x and of y.
    pub lines: [Vec<f64>; 2],
    /// Between them, row by row.
    pub pressure: Vec<f64>,
}

impl OnLines {
    pub fn cells(&self) -> [usize; 2] {
        [0, 1].map(|m| self.lines[m].len() - 1)
    }

    /// The pressure between two lines of x and two of y.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.pressure[j * self.cells()[0] + i]
    }

    /// The pressure of the k-th cell of the l-th line of cells along m.
    pub fn along(&self, m: usize, k: usize, l: usize) -> f64 {
        if m == 0 { self.at(k, l) } else { self.at(l, k) }
    }

    /// Whether there is contact in a cell between these lines or in one beside it.
    pub fn is_near(&self, x: [f64; 2], y: [f64; 2]) -> bool {
        let range = |m: usize, [a, b]: [f64; 2]| {
            let lines = &self.lines[m];
            let from = lines.partition_point(|l| *l <= a).saturating_sub(2);
            let to = (lines.partition_point(|l| *l < b) + 1).min(lines.len() - 1);
            from..to
        };
        let columns = range(0, x);
        range(1, y).any(|j| columns.clone().any(|i| self.at(i, j) > 0.0))
    }
}

/// How many lines there are up to a point.
pub(super) struct Density {
    at: Vec<f64>,
    up_to: Vec<f64>,
}

impl Density {
    /// 1/h ~ G^power along m, with the grading of a sharp edge at these sides.
    pub fn of(found: &OnLines, m: usize, edges: [bool; 2], power: f64) -> Self {
        let (n, others) = (found.cells()[m], found.cells()[1 - m]);
        let (lines, across) = (&found.lines[m], &found.lines[1 - m]);
        let touches = |k: usize| (0..others).any(|l| found.along(m, k, l) > 0.0);
        let first = (0..n).find(|k| touches(*k)).unwrap_or(0);
        let last = (0..n).rev().find(|k| touches(*k)).unwrap_or(n - 1);
        // With cells beside the contact, where there are some.
        let (from, to) = (first.saturating_sub(BESIDE), (last + 1 + BESIDE).min(n));
        let middle = |k: usize| 0.5 * (lines[k] + lines[k + 1]);
        let weight = |l: usize| across[l + 1] - across[l];
        // 1/h at the line between two cells.
        let rho = |k: usize| {
            let step = middle(k) - middle(k - 1);
            let g = |l: usize| weight(l) * ((found.along(m, k, l) - found.along(m, k - 1, l)) / step).powi(2);
            (0..others).map(g).sum::<f64>().powf(power)
        };
        let mut pieces: Vec<(f64, f64, f64)> = Vec::new();
        let sharp = [edges[0] && from == 0, edges[1] && to == n];
        let inner = |k: usize| (middle(k - 1), middle(k), rho(k));
        let (low, high) = (from + 1 + usize::from(sharp[0]), to - usize::from(sharp[1]));
        // 1/h = c s^(-3/4) with the same number of lines between the first two cells.
        let graded = |edge: f64, [near, far]: [f64; 2], rho: f64| {
            let root = |x: f64| (x - edge).abs().powf(0.25);
            let all = rho * (far - near).abs() * root(far) / (root(far) - root(near));
            (0..PARTS).map(move |k| {
                let at = |k: usize| edge + (far - edge) * (k as f64 / PARTS as f64).powi(4);
                (at(k), at(k + 1), all / PARTS as f64 / (at(k + 1) - at(k)).abs())
            })
        };
        if sharp[0] {
            pieces.extend(graded(lines[0], [middle(0), middle(1)], rho(1)));
        } else {
            pieces.push((lines[from], middle(from), rho(from + 1)));
        }
        pieces.extend((low..high).map(inner));
        if sharp[1] {
            let mut last: Vec<_> =
                graded(lines[n], [middle(n - 1), middle(n - 2)], rho(n - 1)).map(|(a, b, r)| (b, a, r)).collect();
            last.reverse();
            pieces.extend(last);
        } else {
            pieces.push((middle(to - 1), lines[to], rho(to - 1)));
        }
        let all: f64 = pieces.iter().map(|(a, b, rho)| rho * (b - a)).sum();
        let least = if all > 0.0 { LEAST * all / (lines[to] - lines[from]) } else { 1.0 };
        let mut density = Self { at: vec![lines[from]], up_to: vec![0.0] };
        let mut sum = 0.0;
        for (_, b, rho) in pieces {
            let a = *density.at.last().unwrap_or(&b);
            sum += rho.max(least) * (b - a);
            density.at.push(b);
            density.up_to.push(sum);
        }
        density
    }

    fn ends(&self) -> [f64; 2] {
        [self.at[0], self.at[self.at.len() - 1]]
    }

    /// The point up to which there is a share of all lines.
    fn point(&self, share: f64) -> f64 {
        let last = self.at.len() - 1;
        let wanted = share * self.up_to[last];
        let k = self.up_to.partition_point(|up_to| *up_to < wanted).clamp(1, last);
        let part = (wanted - self.up_to[k - 1]) / (self.up_to[k] - self.up_to[k - 1]);
        self.at[k - 1] + part.clamp(0.0, 1.0) * (self.at[k] - self.at[k - 1])
    }

    pub fn lines(&self, cells: usize) -> Vec<f64> {
        let [first, last] = self.ends();
        let inner = (1..cells).map(|k| self.point(k as f64 / cells as f64));
        std::iter::once(first).chain(inner).chain(std::iter::once(last)).collect()
    }

    /// The same, exactly symmetric about c.
    pub fn mirrored_lines(&self, c: f64, cells: usize) -> Vec<f64> {
        let half = cells.div_ceil(2);
        let (last, middle) = (self.at.len() - 1, self.up_to_point(c));
        let share = |k: usize| (middle + (self.up_to[last] - middle) * k as f64 / half as f64) / self.up_to[last];
        let end = self.ends()[1];
        let out: Vec<f64> = (1..=half).map(|k| if k == half { end } else { self.point(share(k)) } - c).collect();
        out.iter().rev().map(|s| c - s).chain(std::iter::once(c)).chain(out.iter().map(|s| c + s)).collect()
    }

    fn up_to_point(&self, x: f64) -> f64 {
        let k = self.at.partition_point(|at| *at < x).clamp(1, self.at.len() - 1);
        let part = (x - self.at[k - 1]) / (self.at[k] - self.at[k - 1]);
        self.up_to[k - 1] + part * (self.up_to[k] - self.up_to[k - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_where_the_density_is() {
        // Four fifths of the lines in the last tenth.
        let density = Density { at: vec![0.0, 0.9, 1.0], up_to: vec![0.0, 1.0, 5.0] };
        let lines = density.lines(10);
        assert!((lines[2] - 0.9).abs() < 1e-12 && lines[0] == 0.0 && lines[10] == 1.0);
        let density = Density { at: vec![-1.0, -0.9, 0.9, 1.0], up_to: vec![0.0, 4.0, 6.0, 10.0] };
        let lines = density.mirrored_lines(0.0, 10);
        assert!(lines.len() == 11 && lines.iter().zip(lines.iter().rev()).all(|(a, b)| *a == -*b), "{lines:?}");
        assert!((lines[4] + 0.9).abs() < 1e-12, "{lines:?}");
    }
}
