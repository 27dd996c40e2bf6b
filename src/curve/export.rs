//! The curve as files: spreadsheet, JSON, spline tables for multibody codes.

use std::fmt::Write;

use super::{Curve, Sample};
use crate::units::UnitLabels;

/// Where a curve comes from: what an export says beside the numbers.
#[derive(Debug, Clone, Copy, Default)]
pub struct About<'a> {
    /// Name of the scene.
    pub scene: Option<&'a str>,
    /// Labels of the units.
    pub units: Option<&'a UnitLabels>,
}

/// epsilon of Oliver & Pharr (1992): what the surface sinks in outside of the contact, over P/S; of a paraboloid.
const SINK_IN: f64 = 0.75;

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
    /// the first of them and where the method does not give them. The relative errors of force and stiffness are those of
    /// [`Curve::errors_at`]. For indentation: the depth of contact, s - 0.75 P/S with s the depth below first touch (Oliver & Pharr 1992; exact
    /// for paraboloids), the mean pressure (hardness), beta = S sqrt(pi/A)/(2 E*) (1 for bodies of revolution), and the semi-axes of
    /// elliptical patches.
    #[must_use]
    pub fn csv(&self, steps: usize) -> String {
        self.csv_in(None, steps)
    }

    /// As [`Curve::csv`], with units in the heads of the columns: `depth [mm]`.
    #[must_use]
    pub fn csv_in(&self, units: Option<&UnitLabels>, steps: usize) -> String {
        let unit = |of: fn(&UnitLabels) -> String| units.map_or(String::new(), |u| format!(" [{}]", of(u)));
        let (length, pressure, none) = (unit(|u| u.length().to_owned()), unit(UnitLabels::pressure), String::new());
        let head = [
            ("depth", &length),
            ("force", &unit(|u| u.force().to_owned())),
            ("stiffness", &unit(UnitLabels::stiffness)),
            ("area", &unit(UnitLabels::area)),
            ("pressure_max", &pressure),
            ("centre_x", &length),
            ("centre_y", &length),
            ("force_error", &none),
            ("stiffness_error", &none),
            ("contact_depth", &length),
            ("pressure_mean", &pressure),
            ("beta", &none),
            ("semi_axis_major", &length),
            ("semi_axis_minor", &length),
        ];
        let mut text = head.map(|(name, unit)| format!("{name}{unit}")).join(",") + "\n";
        let number = |x: Option<f64>| x.filter(|x| x.is_finite()).map_or(String::new(), |x| format!("{x:e}"));
        for [depth, force] in self.table(steps).into_iter().skip(1) {
            let between = |of: &dyn Fn(&Sample) -> Option<f64>, power: bool| self.between(depth, of, power);
            let (stiffness, area) = (self.stiffness(depth), between(&|s| Some(s.area), true));
            let contact_depth = stiffness.map(|s| depth - self.first_touch - SINK_IN * force / s);
            let beta = stiffness.zip(area).map(|(s, a)| s * (std::f64::consts::PI / a).sqrt() / (2.0 * self.e_star));
            let line = [
                number(Some(depth)),
                number(Some(force)),
                number(stiffness),
                number(area),
                number(between(&|s| s.max_pressure, true)),
                number(between(&|s| s.centre.map(|c| c[0]), false)),
                number(between(&|s| s.centre.map(|c| c[1]), false)),
                number(self.errors_at(depth).map(|e| e[0])),
                number(self.errors_at(depth).map(|e| e[1])),
                number(contact_depth),
                number(area.map(|a| force / a)),
                number(beta),
                number(between(&|s| s.semi_axes.map(|axes| axes[0]), true)),
                number(between(&|s| s.semi_axes.map(|axes| axes[1]), true)),
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

    /// JSON: the knots of the interpolant, the solved states, the fitted power law, the estimates of the errors.
    #[must_use]
    pub fn json(&self) -> String {
        self.json_about(About::default())
    }

    /// As [`Curve::json`], with the name of the scene and the labels of its units.
    #[must_use]
    pub fn json_about(&self, about: About) -> String {
        let number = |x: f64| if x.is_finite() { format!("{x:e}") } else { "null".to_owned() };
        let maybe = |x: Option<f64>| x.map_or("null".to_owned(), number);
        let law = self.power_law();
        let states: Vec<String> = self
            .samples
            .iter()
            .map(|s| {
                let singular = s.singular.map_or("null".to_owned(), |s| format!("\"{}\"", s.word()));
                let pair = |of: Option<[f64; 2]>| {
                    of.map_or("null".to_owned(), |[x, y]| format!("[{}, {}]", number(x), number(y)))
                };
                let (centre, axes) = (pair(s.centre), pair(s.semi_axes));
                format!(
                    "{{\"depth\": {}, \"force\": {}, \"force_error\": {}, \"stiffness\": {}, \"area\": {}, \"pressure_max\": {}, \"centre\": {centre}, \"semi_axes\": {axes}, \
                     \"energy\": {}, \"pressure_singular\": {singular}, \"pressure_max_error\": {}, \"stiffness_error\": {}, \
                     \"area_error\": {}, \"energy_error\": {}, \"map_error\": {}}}",
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
                    maybe(s.energy_error),
                    maybe(s.map_error)
                )
            })
            .collect();
        let knots: Vec<String> = self
            .knots()
            .iter()
            .map(|k| [k.overlap, k.force, k.stiffness, k.shape].map(number).join(", "))
            .map(|k| format!("[{k}]"))
            .collect();
        let quoted = |text: Option<&str>| text.map_or("null".to_owned(), string);
        let units = about.units.map_or("null".to_owned(), |u| {
            format!("{{\"length\": {}, \"force\": {}}}", string(u.length()), string(u.force()))
        });
        let errors: Vec<String> =
            self.errors.iter().map(|[p, k]| format!("[{}, {}]", number(*p), number(*k))).collect();
        format!(
            "{{\"scene\": {}, \"units\": {units}, \"version\": \"{}\", \"effective_modulus\": {}, \"beyond\": \"{}\", \
             \"first_touch\": {}, \"interpolation_error\": {}, \"stiffness_error\": {}, \"map_error\": {}, \
             \"errors_between_states\": [{}], \"solves\": {}, \"power_law\": {{\"coefficient\": {}, \
             \"exponent\": {}, \"error\": {}}}, \"knots\": [{}], \"states\": [{}]}}\n",
            quoted(about.scene),
            env!("CARGO_PKG_VERSION"),
            number(self.e_star),
            self.beyond.word(),
            number(self.first_touch),
            number(self.interpolation_error()),
            number(self.stiffness_error()),
            maybe(self.map_error()),
            errors.join(", "),
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
        let mut text = format!(
            "! force{} over depth{}, to {:.1e} (force), {:.1e} (slope)\nSPLINE/{id}\n",
            of_force(units),
            of_length(units),
            self.interpolation_error(),
            self.stiffness_error()
        );
        for (m, name) in ["X", "Y"].into_iter().enumerate() {
            for (k, four) in table.chunks(3).enumerate() {
                let values: Vec<String> = four.iter().map(|row| format!("{:.15e}", row[m])).collect();
                let head = if k == 0 { format!(", {name} = ") } else { ", ".to_owned() };
                let _ = writeln!(text, "{head}{}", values.join(", "));
            }
        }
        text
    }
}

/// A string of JSON.
fn string(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

fn of_force(units: Option<&UnitLabels>) -> String {
    units.map_or(String::new(), |u| format!(" ({})", u.force()))
}

fn of_length(units: Option<&UnitLabels>) -> String {
    units.map_or(String::new(), |u| format!(" ({})", u.length()))
}
