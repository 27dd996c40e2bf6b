//! The curve as a C header: the same interpolant, in the same steps as in `spline.rs`.

use super::export::About;
use super::{Beyond, Curve, Sample};
use crate::units::UnitLabels;

/// The evaluator, with places for names and numbers.
const TEMPLATE: &str = include_str!("spring.h.in");

/// The function of the centre, where the method gives one.
const CENTRE: &str = "
/* Centre of pressure at a depth. */
@GUARD@_FUNCTION void @NAME@_centre(double depth, double *x, double *y) {
    double s = depth - @GUARD@_FIRST_TOUCH, t;
    const double *a = @NAME@_states[@NAME@_state(s)], *b = a + 4;
    t = (s - a[0]) / (b[0] - a[0]);
    t = t > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0;
    *x = a[2] + t * (b[2] - a[2]);
    *y = a[3] + t * (b[3] - a[3]);
}
";

impl Curve {
    /// A C header with the knots and functions of a depth: `NAME_force`, `NAME_stiffness`, `NAME_area`, `NAME_centre` (where the method gives
    /// the centre of pressure), `NAME_evaluate`, and `NAME_moving_force` with damping. They are those of this curve, continued
    /// beyond the largest depth as [`Curve::beyond`] says (NaN where it refuses). It compiles as C89, C99 and C++; characters of `name` that C
    /// does not allow become underscores.
    #[must_use]
    pub fn c_header(&self, name: &str) -> String {
        self.c_header_about(About::default(), name)
    }

    /// As [`Curve::c_header`], with the units in the comment at its head.
    #[must_use]
    pub fn c_header_in(&self, units: Option<&UnitLabels>, name: &str) -> String {
        self.c_header_about(About { units, ..About::default() }, name)
    }

    /// As [`Curve::c_header`], with the name of the scene and its units in the comment at its head.
    #[must_use]
    pub fn c_header_about(&self, about: About, name: &str) -> String {
        let name = identifier(name);
        let knots = self.knots();
        let rows = knots.iter().map(|k| row(&[k.overlap, k.force, k.stiffness, k.shape]));
        let centred = self.samples.iter().all(|s| s.centre.is_some());
        let state = |s: &Sample| {
            let [x, y] = s.centre.unwrap_or_default();
            let columns = [s.depth - self.first_touch, s.area, x, y];
            row(&columns[..if centred { 4 } else { 2 }])
        };
        let continuation = match self.beyond {
            Beyond::Refuse => {
                "        volatile double zero = 0.0;\n        *force = *stiffness = *slope = zero / zero;"
            }
            Beyond::Power => "        @NAME@_by_power(k[high], s, force, stiffness, slope);",
            Beyond::Tangent => {
                "        *force = k[high][1] + k[high][2] * (s - k[high][0]);\n        *stiffness = k[high][2];\n        *slope = 0.0;"
            }
        };
        let beyond = match self.beyond {
            Beyond::Refuse => "NaN",
            Beyond::Power => "the power law of that knot",
            Beyond::Tangent => "its tangent",
        };
        TEMPLATE
            .replace("@CENTRE@", if centred { CENTRE } else { "" })
            .replace("@CENTRE_COLUMNS@", if centred { ", centre of pressure" } else { "" })
            .replace("@STATE_COLUMNS@", if centred { "4" } else { "2" })
            .replace("@CONTINUATION@", continuation)
            .replace("@BEYOND@", beyond)
            .replace("@PROVENANCE@", &self.provenance(about))
            .replace("@GUARD@", &name.to_uppercase())
            .replace("@COUNT@", &knots.len().to_string())
            .replace("@STATE_COUNT@", &self.samples.len().to_string())
            .replace("@FORCE_ERROR@", &format!("{:.1e}", self.interpolation_error()))
            .replace("@STIFFNESS_ERROR@", &format!("{:.1e}", self.stiffness_error()))
            .replace("@TOUCH@", &negative(self.first_touch))
            .replace("@DEEPEST@", &negative(self.deepest()))
            .replace("@KNOTS@", &rows.collect::<Vec<_>>().join(",\n"))
            .replace("@STATES@", &self.samples.iter().map(state).collect::<Vec<_>>().join(",\n"))
            .replace("@NAME@", &name)
    }

    /// Lines of a comment: what the curve is of, and how good it is.
    pub(super) fn provenance(&self, about: About) -> String {
        let scene = about.scene.map_or("without a name".to_owned(), in_comment);
        let units = about.units.map_or("those of the scene".to_owned(), |u| {
            in_comment(&format!("{} (length), {} (force), {} (stiffness)", u.length(), u.force(), u.stiffness()))
        });
        let law = self.power_law();
        let first = self.samples.first().map_or(self.first_touch, |s| s.depth);
        let mut lines = vec![
            format!("scene             {scene}"),
            format!("units             {units}"),
            format!("E*                {:e}", self.e_star),
            format!("first touch       {:e}", self.first_touch),
            format!("solved depths     {first:e} to {:e}, {} states", self.deepest(), self.samples.len()),
            format!(
                "relative errors   {:.1e} of the force, {:.1e} of the stiffness, at any depth between (estimates)",
                self.interpolation_error(),
                self.stiffness_error()
            ),
            format!(
                "power law         force = {:e} * overlap^{:.6}, to {:.1e}",
                law.coefficient, law.exponent, law.error
            ),
            format!("made by           contact-patch {}", env!("CARGO_PKG_VERSION")),
        ];
        if let Some(open) = self.map_error() {
            let line = format!("measured gap      its samples leave another {open:.1e} of the force open (estimate)");
            lines.insert(6, line);
        }
        lines.iter().map(|line| format!(" * {line}")).collect::<Vec<_>>().join("\n")
    }
}

/// A row of a table; every double survives.
fn row(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|x| format!("{x:e}")).collect();
    format!("    {{{}}}", values.join(", "))
}

/// A number that may stand after a minus sign.
fn negative(x: f64) -> String {
    if x.is_sign_negative() { format!("({x:e})") } else { format!("{x:e}") }
}

/// A name as C allows it.
pub(super) fn identifier(name: &str) -> String {
    let mut allowed: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if allowed.chars().next().is_none_or(|c| c.is_ascii_digit()) {
        allowed.insert(0, '_');
    }
    allowed
}

/// Longest name of a scene in a comment.
const LONGEST: usize = 200;

/// A text that ends no comment and begins none.
fn in_comment(text: &str) -> String {
    let plain = |c: char| match c {
        '*' => 'x',
        '\\' => '/',
        '?' => '.',
        '@' => 'a',
        c if c.is_control() => ' ',
        c => c,
    };
    text.chars().take(LONGEST).map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_end_no_comment_and_names_are_those_of_c() {
        assert_eq!(in_comment("a */ b\n/* ??/ c \\"), "a x/ b /x ../ c /");
        assert_eq!(identifier("2 wheels"), "_2_wheels");
        assert_eq!(identifier(""), "_");
    }
}
