//! A measured line, and what is done to it before it becomes a gap.

use std::path::Path;

use super::table::{self, LineFormat};
use crate::error::{InputError, finite, positive};
use crate::gap::spline;

/// Longest text that is read, in bytes, and most points.
const LARGEST: u64 = 1 << 24;
const MOST_POINTS: usize = 200_000;

/// Points [y, z] of a measured line, in order along it; heights z count upwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    points: Vec<[f64; 2]>,
    /// How far each height may be from the true one, where noise was taken out.
    uncertainty: Option<Vec<f64>>,
}

impl Line {
    /// A line through these points, at least two, in order along it. Points that follow one another at one place count once.
    ///
    /// # Errors
    /// Names `points` when there are too few or too many, `points[k]` when one is not finite.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, InputError> {
        for (k, p) in points.iter().enumerate() {
            finite(&format!("points[{k}][0]"), p[0])?;
            finite(&format!("points[{k}][1]"), p[1])?;
        }
        let mut points = points;
        points.dedup();
        if points.len() < 2 {
            let given = format!("{} points", points.len());
            return Err(InputError::new("points", given, "at least two different points [y, z]"));
        }
        if points.len() > MOST_POINTS {
            let given = format!("{} points", points.len());
            return Err(InputError::new("points", given, format!("at most {MOST_POINTS} points")));
        }
        Ok(Self { points, uncertainty: None })
    }

    /// Text in two columns y, z, separated by blanks, tabs, commas or semicolons; between semicolons or tabs a comma is that of decimals.
    /// More columns and one line of words above are passed over; `#`, `%`, `!` and `//` start comments.
    ///
    /// # Errors
    /// Names `file` with the line and what is wrong there.
    pub fn from_text(text: &str) -> Result<Self, InputError> {
        table::columns(text, 1, [0, 1]).and_then(Self::of_file)
    }

    /// A MiniProf file (`.ban`, `.whl`): lines `Key=value`, an empty line, then y, z and columns that are not needed; `ColumnDef` tells
    /// their order, `Units` what is made millimetres.
    ///
    /// # Errors
    /// Names `file` with the line and what is wrong there.
    pub fn from_miniprof(text: &str) -> Result<Self, InputError> {
        table::miniprof(text).and_then(Self::of_file)
    }

    fn of_file(points: Vec<[f64; 2]>) -> Result<Self, InputError> {
        Self::new(points).map_err(|e| InputError { path: "file".into(), ..e })
    }

    /// A file; `format` by its ending when not said.
    ///
    /// # Errors
    /// Names `file` when it is not a regular file, cannot be read or is larger than 16 MiB; otherwise as the readers of the formats. No
    /// message repeats what the file holds.
    pub fn read(path: &Path, format: Option<LineFormat>) -> Result<Self, InputError> {
        let name = path.display();
        let bytes = crate::files::read(path, LARGEST)?;
        let line = crate::gap::height_map::decoded(&bytes).and_then(|text| {
            match format.unwrap_or_else(|| LineFormat::of(path)) {
                LineFormat::Columns => Self::from_text(text),
                LineFormat::Miniprof => Self::from_miniprof(text),
            }
        });
        line.map_err(|e| if e.path == "file" { InputError { given: format!("{name}: {}", e.given), ..e } } else { e })
    }

    /// The points.
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Whether noise was taken out.
    #[must_use]
    pub fn is_smoothed(&self) -> bool {
        self.uncertainty.is_some()
    }

    fn moved(
        mut self,
        by: impl Fn([f64; 2]) -> [f64; 2],
        path: &str,
        given: impl std::fmt::Display,
    ) -> Result<Self, InputError> {
        self.points.iter_mut().for_each(|p| *p = by(*p));
        if self.points.iter().flatten().all(|v| v.is_finite()) {
            return Ok(self);
        }
        Err(InputError::new(path, given, "a number that keeps the points finite"))
    }

    /// Both coordinates times `factor`: a file in millimetres is read with 1e-3.
    ///
    /// # Errors
    /// Names `unit` when the factor is not a finite number greater than 0, or a point no longer fits.
    pub fn scaled(self, factor: f64) -> Result<Self, InputError> {
        let factor = positive("unit", factor)?;
        self.moved(|[y, z]| [factor * y, factor * z], "unit", factor)
    }

    /// Its image in the line y = 0, in z = 0, or in both.
    #[must_use]
    pub fn mirrored(mut self, in_y: bool, in_z: bool) -> Self {
        let sign = |mirrored: bool| if mirrored { -1.0 } else { 1.0 };
        self.points.iter_mut().for_each(|p| *p = [sign(in_y) * p[0], sign(in_z) * p[1]]);
        self
    }

    /// Turned in its own plane about the origin, counter-clockwise from y to z, by an angle in radians: the inclination of a rail.
    ///
    /// # Errors
    /// Names `turn` when it is not finite.
    pub fn turned(self, angle: f64) -> Result<Self, InputError> {
        let (sin, cos) = finite("turn", angle)?.sin_cos();
        self.moved(|[y, z]| [cos * y - sin * z, sin * y + cos * z], "turn", angle)
    }

    /// Moved by [dy, dz].
    ///
    /// # Errors
    /// Names `shift` when it is not finite.
    pub fn shifted(self, by: [f64; 2]) -> Result<Self, InputError> {
        finite("shift[0]", by[0])?;
        finite("shift[1]", by[1])?;
        self.moved(|p| [p[0] + by[0], p[1] + by[1]], "shift", format!("{by:?}"))
    }

    /// The points whose y lies between two numbers: what is far from the contact is not needed, and where it is steep or sharp it
    /// leaves less of the noise to be taken out elsewhere.
    ///
    /// # Errors
    /// Names `between` when the first is not less than the second, or fewer than two points are left.
    pub fn between(mut self, [from, to]: [f64; 2]) -> Result<Self, InputError> {
        let given = || format!("[{from}, {to}]");
        if !(from < to) {
            return Err(InputError::new("between", given(), "two numbers, the first less than the second"));
        }
        self.points.retain(|p| (from..=to).contains(&p[0]));
        if self.points.len() < 2 {
            let points = self.points.len();
            return Err(InputError::new(
                "between",
                given(),
                format!("a part of the line with points; there are {points}"),
            ));
        }
        Ok(self)
    }

    /// Without noise of this standard deviation: the smoothing spline of Reinsch whose mean square distance from the heights is
    /// that of the noise. Only the part that can be touched from the side said by `upwards` (from below or from above) is kept.
    ///
    /// # Errors
    /// Names `smooth` when it is not a finite number greater than 0; `points` when fewer than eight are left.
    pub fn smoothed(self, deviation: f64, surface: super::Surface) -> Result<Self, InputError> {
        let deviation = positive("smooth", deviation)?;
        let sign = if surface == super::Surface::Upper { 1.0 } else { -1.0 };
        let points = self.facing(sign)?;
        if points.len() < 8 {
            let given = format!("{} points to take noise out of", points.len());
            return Err(InputError::new("points", given, "at least eight points, or no \"smooth\""));
        }
        let (knots, values): (Vec<f64>, Vec<f64>) = points.iter().map(|p| (p.0[0], p.0[1])).unzip();
        let found = spline::smoothed(&knots, &values, deviation);
        let points = knots.into_iter().zip(found.values).map(|(y, z)| [y, z]).collect();
        Ok(Self { points, uncertainty: Some(found.uncertainty) })
    }

    /// The part that the other body can touch, y rising: where the line turns back (the underside of a rail's head, the back of a
    /// flange), only what lies between the turns next to the point that is nearest to the other body. `sign`: heights times it are gaps.
    pub(super) fn facing(&self, sign: f64) -> Result<Vec<([f64; 2], f64)>, InputError> {
        let points = &self.points;
        let uncertainty = |k: usize| self.uncertainty.as_ref().map_or(0.0, |uncertainty| uncertainty[k]);
        let nearest = (0..points.len()).min_by(|&a, &b| (sign * points[a][1]).total_cmp(&(sign * points[b][1])));
        let nearest = nearest.unwrap_or_default();
        let span = |rising: bool| {
            let goes_on =
                |k: usize| if rising { points[k][0] < points[k + 1][0] } else { points[k][0] > points[k + 1][0] };
            let (mut first, mut last) = (nearest, nearest);
            while first > 0 && goes_on(first - 1) {
                first -= 1;
            }
            while last + 1 < points.len() && goes_on(last) {
                last += 1;
            }
            (first, last)
        };
        let (up, down) = (span(true), span(false));
        let rising = up.1 - up.0 >= down.1 - down.0;
        let (first, last) = if rising { up } else { down };
        let extent = |points: &[[f64; 2]]| {
            points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], p| [a.min(p[0]), b.max(p[0])])
        };
        let (whole, kept) = (extent(points), extent(&points[first..=last]));
        // A line that turns back where it can be touched is out of order, or measured with more noise than step.
        if first == last || kept[1] - kept[0] < 0.5 * (whole[1] - whole[0]) {
            let given = format!("a line whose y turns back next to point {nearest}, its nearest to the other body");
            let allowed = "points in order along the line, y rising or falling over at least half of its width; \
                           \"surface\" says which side is touched";
            return Err(InputError::new("points", given, allowed));
        }
        let mut found: Vec<([f64; 2], f64)> = (first..=last).map(|k| (points[k], uncertainty(k))).collect();
        if !rising {
            found.reverse();
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::Surface;

    #[test]
    fn what_turns_back_is_left_out() {
        // A head with undercut sides: y falls back beyond either side.
        let head = vec![[-0.8, -2.0], [-1.0, -1.0], [-0.9, -0.3], [0.0, 0.0], [0.9, -0.3], [1.0, -1.0], [0.8, -2.0]];
        let kept = Line::new(head.clone()).unwrap().facing(-1.0).unwrap();
        assert_eq!(kept.iter().map(|p| p.0[0]).collect::<Vec<_>>(), [-1.0, -0.9, 0.0, 0.9, 1.0]);
        let reversed = Line::new(head.into_iter().rev().collect()).unwrap().facing(-1.0).unwrap();
        assert_eq!(kept, reversed);
        let zigzag = Line::new(vec![[0.0, 1.0], [1.0, 0.0], [0.5, 0.5], [3.0, 1.0]]).unwrap();
        assert!(zigzag.facing(1.0).unwrap_err().given.contains("turns back"));
    }

    #[test]
    fn moves_are_those_of_the_plane() {
        let line = Line::new(vec![[1.0, 0.0], [2.0, 1.0], [4.0, 0.5]]).unwrap();
        let quarter = line.clone().turned(std::f64::consts::FRAC_PI_2).unwrap();
        assert!(
            quarter
                .points()
                .iter()
                .zip(line.points())
                .all(|(a, b)| (a[0] + b[1]).abs() < 1e-15 && a[1] == b[0] + (a[1] - b[0]))
        );
        let back = line.clone().mirrored(true, false).shifted([1.0, 2.0]).unwrap();
        assert_eq!(back.points()[1], [-1.0, 3.0]);
        assert_eq!(line.clone().scaled(1e-3).unwrap().points()[2], [4e-3, 5e-4]);
        assert_eq!(line.clone().between([1.5, 9.0]).unwrap().points(), [[2.0, 1.0], [4.0, 0.5]]);
        assert_eq!(line.clone().between([3.0, 9.0]).unwrap_err().path, "between");
        assert_eq!(line.clone().scaled(0.0).unwrap_err().path, "unit");
        assert_eq!(line.smoothed(1e-3, Surface::Upper).unwrap_err().path, "points");
        assert_eq!(Line::new(vec![[0.0, 0.0], [0.0, 0.0]]).unwrap_err().path, "points");
    }
}
