//! Surface data files in ASCII: ISO 25178-71:2012 (`aISO-1.0`), and EUNA 15178's `aBCR-1.0` before it.
//!
//! A header of `key = value`, a line `*`, heights row by row in units of `Zscale` with `BAD` where nothing was measured, a line `*`, a
//! trailer that is passed over. All scales are in metres.

use super::Read;
use crate::error::InputError;

fn refuse(given: impl std::fmt::Display, allowed: impl Into<String>) -> InputError {
    InputError::new("file", given, allowed)
}

/// Heights and steps in metres.
pub(super) fn read(text: &str) -> Result<Read, InputError> {
    let mut sections = text.split('*');
    let (Some(header), Some(data)) = (sections.next(), sections.next()) else {
        return Err(refuse("no line * after the header", "an ASCII surface data file of ISO 25178-71"));
    };
    let mut lines = header.lines().map(str::trim).filter(|line| !line.is_empty());
    match lines.next() {
        Some("aISO-1.0" | "aBCR-1.0") => {}
        Some(first) if first.starts_with("bISO") || first.starts_with("bBCR") => {
            return Err(refuse("a binary surface data file", "an ASCII one (aISO-1.0)"));
        }
        _ => return Err(refuse("another first line", "aISO-1.0 in the first line")),
    }
    let entries: Vec<(&str, &str)> =
        lines.filter_map(|line| line.split_once('=')).map(|(k, v)| (k.trim(), v.trim())).collect();
    let entry = |key: &str| entries.iter().find(|(k, _)| k.eq_ignore_ascii_case(key)).map(|(_, value)| *value);
    let needed = |key: &str| entry(key).ok_or_else(|| refuse(format!("a header without {key}"), "a header with it"));
    let count = |key: &str| {
        let wrong = || refuse(format!("something else as {key}"), "a whole number of at least 2");
        needed(key)?.parse::<usize>().ok().filter(|n| *n >= 2).ok_or_else(wrong)
    };
    let scale = |key: &str| {
        let wrong = || refuse(format!("something else as {key}"), "a finite number greater than 0, metres");
        needed(key)?.parse::<f64>().ok().filter(|s| s.is_finite() && *s > 0.0).ok_or_else(wrong)
    };
    let shape = [count("NumPoints")?, count("NumProfiles")?];
    let spacing = [scale("Xscale")?, scale("Yscale")?];
    let unit = scale("Zscale")?;
    if entry("Compression").is_some_and(|c| c != "0") {
        return Err(refuse("compressed heights", "Compression = 0"));
    }
    let first = header.lines().count();
    let mut values = Vec::new();
    for (k, line) in data.lines().enumerate() {
        for field in line.split_whitespace() {
            let bad = ["bad", "nan"].iter().any(|hole| field.eq_ignore_ascii_case(hole));
            let height = if bad { Some(f64::NAN) } else { field.parse::<f64>().ok().filter(|z| z.is_finite()) };
            let Some(height) = height else {
                return Err(refuse(format!("something else in line {}", first + k), "a height, or BAD"));
            };
            values.push(height * unit);
        }
    }
    if shape[0].checked_mul(shape[1]) != Some(values.len()) {
        let given = format!("{} heights of {} x {}", values.len(), shape[0], shape[1]);
        return Err(refuse(given, "as many heights as the header says"));
    }
    Ok(Read { values, shape, spacing })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "aISO-1.0\nManufacID   = test\nNumPoints = 3\nNumProfiles = 2\nXscale = 1.0E-06\nYscale = 2e-6\nZscale = 1e-9\nZresolution = -1\nCompression = 0\nDataType = 7\nCheckType = 0\n";

    #[test]
    fn heights_with_their_scales_and_holes() {
        let Read { values, shape, spacing } = read(&format!("{HEAD}*\n 1 2.5 BAD\n-3 4\n5\n*\nanything\n*\n")).unwrap();
        assert_eq!((shape, spacing), ([3, 2], [1e-6, 2e-6]));
        assert_eq!(values[1], 2.5 * 1e-9);
        assert!(values[2].is_nan() && values[5] == 5.0 * 1e-9);
    }

    #[test]
    fn what_is_wrong_is_said_without_repeating_it() {
        let given = |text: &str| read(text).unwrap_err().given;
        assert_eq!(given("x"), "no line * after the header");
        assert_eq!(given("bISO-1.0*"), "a binary surface data file");
        assert_eq!(given("secret*1"), "another first line");
        assert_eq!(given("aISO-1.0\nNumPoints = 3\n*1"), "a header without NumProfiles");
        assert_eq!(given(&format!("{}*1 2 3\n*", HEAD.replace("= 3", "= 1"))), "something else as NumPoints");
        assert_eq!(given(&format!("{HEAD}*1 2 3\n*")), "3 heights of 3 x 2");
        assert_eq!(given(&format!("{HEAD}*\n1 2 3\n4 secret 6\n*")), "something else in line 13");
        assert_eq!(given(&format!("{}*1*", HEAD.replace("Compression = 0", "Compression = 1"))), "compressed heights");
    }
}
