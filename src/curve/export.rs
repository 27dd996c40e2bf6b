//! The curve as files: spreadsheet, JSON, spline tables for multibody codes, a C header.

use std::fmt::Write;

use super::{Curve, Sample};
use crate::units::UnitLabels;

impl Curve {
    /// Depth and force at `steps` equal steps from first touch to the largest depth, both ends included.
    #[must_use]
    pub fn table(&self, steps: usize) -> Vec<[f64; 2]> {
        let depth = |k: usize| {
            let share = k as f64 / steps as f64;
            if k == steps { self.deepest() } else { self.first_touch + share * (self.deepest() - self.first_touch) }
        };
        (0..=steps).filter_map(|k| self.force(depth(k)).map(|p| [depth(k), p])).collect()
    }

    /// Comma-separated values: a header, then `steps` equal steps of depth, first touch left out. Force and stiffness are the
    /// interpolant's; area, largest pressure and centre are interpolated between solved states (powers and lines), and empty below
    /// the first of them and where the method does not give them.
    #[must_use]
    pub fn csv(&self, steps: usize) -> String {
        self.csv_in(None, steps)
    }

    /// As [`Curve::csv`], with units in the heads of the columns: `depth [mm]`.
    #[must_use]
    pub fn csv_in(&self, units: Option<&UnitLabels>, steps: usize) -> String {
        let mut text = match units {
            None => "depth,force,stiffness,area,pressure_max,centre_x,centre_y\n".to_owned(),
            Some(u) => {
                let (l, f, s, a, p) = (u.length(), u.force(), u.stiffness(), u.area(), u.pressure());
                format!(
                    "depth [{l}],force [{f}],stiffness [{s}],area [{a}],pressure_max [{p}],centre_x [{l}],centre_y [{l}]\n"
                )
            }
        };
        let number = |x: Option<f64>| x.filter(|x| x.is_finite()).map_or(String::new(), |x| format!("{x:e}"));
        for [depth, force] in self.table(steps).into_iter().skip(1) {
            let between = |of: &dyn Fn(&Sample) -> Option<f64>, power: bool| self.between(depth, of, power);
            let line = [
                number(Some(depth)),
                number(Some(force)),
                number(self.stiffness(depth)),
                number(between(&|s| Some(s.area), true)),
                number(between(&|s| s.max_pressure, true)),
                number(between(&|s| s.centre.map(|c| c[0]), false)),
                number(between(&|s| s.centre.map(|c| c[1]), false)),
            ];
            // Writing to a string does not fail.
            let _ = writeln!(text, "{}", line.join(","));
        }
        text
    }

    /// A quantity between the solved states beside a depth.
    fn between(&self, depth: f64, of: &dyn Fn(&Sample) -> Option<f64>, power: bool) -> Option<f64> {
        let k = self.samples.partition_point(|s| s.depth < depth).min(self.samples.len() - 1);
        let b = &self.samples[k];
        if b.depth == depth {
            return of(b);
        }
        let a = &self.samples[k.checked_sub(1)?];
        let (va, vb) = (of(a)?, of(b)?);
        let overlap = |d: f64| d - self.first_touch;
        if power && va > 0.0 && vb > 0.0 {
            let t = (overlap(depth) / overlap(a.depth)).ln() / (overlap(b.depth) / overlap(a.depth)).ln();
            return Some(va * (vb / va).powf(t));
        }
        Some(va + (vb - va) * (depth - a.depth) / (b.depth - a.depth))
    }

    /// JSON: the knots of the interpolant, the solved states, the fitted power law, the estimate of the error.
    #[must_use]
    pub fn json(&self) -> String {
        let number = |x: f64| if x.is_finite() { format!("{x:e}") } else { "null".to_owned() };
        let maybe = |x: Option<f64>| x.map_or("null".to_owned(), number);
        let law = self.power_law();
        let states: Vec<String> = self
            .samples
            .iter()
            .map(|s| {
                let singular = s.singular.map_or("null".to_owned(), |s| format!("\"{}\"", s.word()));
                let centre = s.centre.map_or("null".to_owned(), |[x, y]| format!("[{}, {}]", number(x), number(y)));
                format!(
                    "{{\"depth\": {}, \"force\": {}, \"force_error\": {}, \"stiffness\": {}, \"area\": {}, \"pressure_max\": {}, \"centre\": {centre}, \
                     \"energy\": {}, \"pressure_singular\": {singular}, \"pressure_max_error\": {}, \"stiffness_error\": {}, \
                     \"area_error\": {}, \"energy_error\": {}}}",
                    number(s.depth),
                    number(s.force),
                    maybe(s.force_error),
                    number(s.stiffness),
                    number(s.area),
                    maybe(s.max_pressure),
                    maybe(s.energy),
                    maybe(s.max_pressure_error),
                    maybe(s.stiffness_error),
                    maybe(s.area_error),
                    maybe(s.energy_error)
                )
            })
            .collect();
        let knots: Vec<String> = self
            .knots()
            .iter()
            .map(|k| [k.overlap, k.force, k.stiffness, k.shape].map(number).join(", "))
            .map(|k| format!("[{k}]"))
            .collect();
        format!(
            "{{\"first_touch\": {}, \"interpolation_error\": {}, \"solves\": {}, \"power_law\": {{\"coefficient\": {}, \
             \"exponent\": {}, \"error\": {}}}, \"knots\": [{}], \"states\": [{}]}}\n",
            number(self.first_touch),
            number(self.interpolation_error),
            self.solves,
            number(law.coefficient),
            number(law.exponent),
            number(law.error),
            knots.join(", "),
            states.join(", ")
        )
    }

    /// Two columns, depth and force, from first touch on: what most multibody codes read as a spline table.
    #[must_use]
    pub fn two_columns(&self, steps: usize) -> String {
        let mut text = String::new();
        for [depth, force] in self.table(steps) {
            let _ = writeln!(text, "{depth:.16e} {force:.16e}");
        }
        text
    }

    /// A SPLINE statement in the manner of an Adams data set (.adm), lines of at most 80 characters.
    #[must_use]
    pub fn adams(&self, steps: usize, id: u32) -> String {
        self.adams_in(None, steps, id)
    }

    /// As [`Curve::adams`], with the units in the comment at its head.
    #[must_use]
    pub fn adams_in(&self, units: Option<&UnitLabels>, steps: usize, id: u32) -> String {
        let table = self.table(steps);
        let mut text = format!("! force{} over depth{}\nSPLINE/{id}\n", of_force(units), of_length(units));
        for (m, name) in ["X", "Y"].into_iter().enumerate() {
            for (k, four) in table.chunks(3).enumerate() {
                let values: Vec<String> = four.iter().map(|row| format!("{:.15e}", row[m])).collect();
                let head = if k == 0 { format!(", {name} = ") } else { ", ".to_owned() };
                let _ = writeln!(text, "{head}{}", values.join(", "));
            }
        }
        text
    }

    /// A C header with the knots and `NAME_force`, `NAME_stiffness`, which evaluate the same interpolant: zero before first
    /// touch, NaN beyond the largest depth. Characters of `name` that C does not allow become underscores.
    #[must_use]
    pub fn c_header(&self, name: &str) -> String {
        self.c_header_in(None, name)
    }

    /// As [`Curve::c_header`], with the units in the comment at its head.
    #[must_use]
    pub fn c_header_in(&self, units: Option<&UnitLabels>, name: &str) -> String {
        let mut n: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if n.chars().next().is_none_or(|c| c.is_ascii_digit()) {
            n.insert(0, '_');
        }
        let guard = n.to_uppercase();
        let rows: Vec<String> = self
            .knots()
            .iter()
            .map(|k| format!("    {{{:e}, {:e}, {:e}, {:e}}}", k.overlap, k.force, k.stiffness, k.shape))
            .collect();
        C_HEADER
            .replace("@GUARD@", &guard)
            .replace("@COUNT@", &rows.len().to_string())
            .replace("@KNOTS@", &rows.join(",\n"))
            .replace("@TOUCH@", &format!("{:e}", self.first_touch))
            .replace("@NAME@", &n)
            .replace("@FORCE_UNIT@", &of_force(units))
            .replace("@LENGTH_UNIT@", &of_length(units))
    }
}

fn of_force(units: Option<&UnitLabels>) -> String {
    units.map_or(String::new(), |u| format!(" ({})", u.force()))
}

fn of_length(units: Option<&UnitLabels>) -> String {
    units.map_or(String::new(), |u| format!(" ({})", u.length()))
}

/// The evaluator; the same steps as in `spline.rs`.
const C_HEADER: &str = r"/* Force@FORCE_UNIT@ over depth@LENGTH_UNIT@: rational cubics (Delbourgo & Gregory 1985), increasing and convex. */
#ifndef @GUARD@_SPRING_H
#define @GUARD@_SPRING_H
#include <math.h>

#define @GUARD@_KNOTS @COUNT@

/* Depth of first touch. */
static const double @NAME@_first_touch = @TOUCH@;

/* Overlap, force, stiffness, shape of the interval that begins here. */
static const double @NAME@_knots[@GUARD@_KNOTS][4] = {
@KNOTS@
};

/* Force and stiffness at a depth. */
static void @NAME@_evaluate(double depth, double *force, double *stiffness) {
    const double (*k)[4] = @NAME@_knots;
    double s = depth - @NAME@_first_touch, h, t, u, p, q, above, below, d_above, d_below;
    int low = 0, high = @GUARD@_KNOTS - 1;
    if (!(s <= k[high][0])) { *force = *stiffness = NAN; return; }
    if (s <= 0.0) { *force = *stiffness = 0.0; return; }
    if (s <= k[0][0]) {
        double m = k[0][2] * k[0][0] / k[0][1];
        *force = k[0][1] * pow(s / k[0][0], m);
        *stiffness = m * *force / s;
        return;
    }
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (k[middle][0] < s) low = middle; else high = middle;
    }
    k += low;
    h = k[1][0] - k[0][0];
    t = (s - k[0][0]) / h;
    u = 1.0 - t;
    p = k[0][3] * k[0][1] + h * k[0][2];
    q = k[0][3] * k[1][1] - h * k[1][2];
    above = u * u * u * k[0][1] + t * u * u * p + t * t * u * q + t * t * t * k[1][1];
    below = 1.0 + (k[0][3] - 3.0) * t * u;
    d_above = 3.0 * (t * t * k[1][1] - u * u * k[0][1]) + (u - 2.0 * t) * u * p + (2.0 * u - t) * t * q;
    d_below = (k[0][3] - 3.0) * (u - t);
    *force = above / below;
    *stiffness = (d_above - *force * d_below) / (below * h);
}

static inline double @NAME@_force(double depth) {
    double force, stiffness;
    @NAME@_evaluate(depth, &force, &stiffness);
    return force;
}

static inline double @NAME@_stiffness(double depth) {
    double force, stiffness;
    @NAME@_evaluate(depth, &force, &stiffness);
    return stiffness;
}

#endif
";
