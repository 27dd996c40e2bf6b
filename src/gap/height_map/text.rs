//! Heights written as text: rows of numbers, or lines of x, y, z.

use crate::error::InputError;

fn refuse(given: impl std::fmt::Display, allowed: impl Into<String>) -> InputError {
    InputError::new("file", given, allowed)
}

/// UTF-8 without its byte order mark.
pub(in crate::gap) fn decoded(bytes: &[u8]) -> Result<&str, InputError> {
    let line = |at: usize| bytes[..at].iter().filter(|&&b| b == b'\n').count() + 1;
    if let Some(at) = bytes.iter().position(|&b| b == 0) {
        return Err(refuse(format!("binary data in line {}", line(at)), "text, or the format said by `format`"));
    }
    let text = std::str::from_utf8(bytes)
        .map_err(|e| refuse(format!("line {}, which is not UTF-8", line(e.valid_up_to())), "text in UTF-8 or ASCII"))?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// Lines that hold something, with their number from 1, split into fields.
fn lines(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    text.lines().enumerate().filter_map(|(k, line)| {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            return None;
        }
        let separator = [';', ','].into_iter().find(|&s| line.contains(s));
        let fields = match separator {
            Some(s) => line.split(s).map(str::trim).collect(),
            None => line.split_whitespace().collect(),
        };
        Some((k + 1, fields))
    })
}

/// A height; NaN for a hole.
fn height(field: &str, line: usize) -> Result<f64, InputError> {
    if field.is_empty() || ["nan", "na", "n/a", "-", "--"].iter().any(|hole| field.eq_ignore_ascii_case(hole)) {
        return Ok(f64::NAN);
    }
    number(field, line, "a finite number, or nan for a hole")
}

fn number(field: &str, line: usize, allowed: &str) -> Result<f64, InputError> {
    match field.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => {
            // What stands there is not repeated: the file may be one that was not meant.
            Err(refuse(format!("something else in line {line}"), allowed))
        }
    }
}

/// Rows of equal length: values and shape.
pub(super) fn rows(text: &str) -> Result<(Vec<f64>, [usize; 2]), InputError> {
    let (mut values, mut columns, mut count) = (Vec::new(), None, 0);
    for (line, fields) in lines(text) {
        let &mut (first, width) = columns.get_or_insert((line, fields.len()));
        if fields.len() != width {
            let given = format!("{} values in line {line}", fields.len());
            return Err(refuse(given, format!("rows of equal length; line {first} has {width} values")));
        }
        for field in fields {
            values.push(height(field, line)?);
        }
        count += 1;
    }
    let width = columns.map_or(0, |c| c.1);
    if width < 2 || count < 2 {
        let given = if count == 0 { "no values".to_owned() } else { format!("{count} rows of {width} values") };
        return Err(refuse(given, "at least two rows of at least two heights"));
    }
    Ok((values, [width, count]))
}

/// What lines of x, y, z amount to.
pub(super) struct Scattered {
    pub values: Vec<f64>,
    pub shape: [usize; 2],
    pub spacing: [f64; 2],
    pub origin: [f64; 2],
}

/// Lines of x, y, z on a regular grid, in any order.
pub(super) fn scattered(text: &str) -> Result<Scattered, InputError> {
    let mut points = Vec::new();
    for (line, fields) in lines(text) {
        let &[x, y, z] = fields.as_slice() else {
            return Err(refuse(format!("{} values in line {line}", fields.len()), "three values x, y, z in each line"));
        };
        let place = |field| number(field, line, "a finite coordinate");
        points.push((line, [place(x)?, place(y)?], height(z, line)?));
    }
    let axis = |m: usize| {
        let name = ["x", "y"][m];
        let mut places: Vec<f64> = points.iter().map(|p| p.1[m]).collect();
        places.sort_by(f64::total_cmp);
        let (Some(&first), Some(&last)) = (places.first(), places.last()) else {
            return Err(refuse("no points", "lines of x, y, z on a regular grid"));
        };
        let range = last - first;
        // Places that only rounding tells apart count once.
        places.dedup_by(|b, a| *b - *a <= 1e-6 * range);
        let steps = places.len() - 1;
        if steps == 0 || !range.is_finite() {
            return Err(refuse(format!("one value of {name}"), format!("at least two different values of {name}")));
        }
        Ok((first, range / steps as f64, steps + 1))
    };
    let ((x, dx, nx), (y, dy, ny)) = (axis(0)?, axis(1)?);
    let irregular = || {
        let given = format!("{} points with {nx} different x and {ny} different y", points.len());
        refuse(given, "points of a regular grid, of which at most nine in ten are left out")
    };
    if nx.checked_mul(ny).is_none_or(|nodes| nodes / 10 > points.len()) {
        return Err(irregular());
    }
    let (mut values, mut seen) = (vec![f64::NAN; nx * ny], vec![0_usize; nx * ny]);
    for &(line, place, z) in &points {
        let at = [(place[0] - x) / dx, (place[1] - y) / dy];
        let on_grid = |m: usize| (at[m] - at[m].round()).abs() <= 0.01;
        if let Some(m) = (0..2).find(|&m| !on_grid(m)) {
            let given = format!("a value of {} in line {line} that is off the grid", ["x", "y"][m]);
            return Err(refuse(given, "coordinates on a regular grid, to one hundredth of a step"));
        }
        let k = at[1].round() as usize * nx + at[0].round() as usize;
        if seen[k] > 0 {
            return Err(refuse(
                format!("a second height in line {line}"),
                format!("one; line {} has the first", seen[k]),
            ));
        }
        (values[k], seen[k]) = (z, line);
    }
    Ok(Scattered { values, shape: [nx, ny], spacing: [dx, dy], origin: [x, y] })
}
