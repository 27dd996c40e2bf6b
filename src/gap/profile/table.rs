//! Lines written as text: two columns, or the files of a MiniProf.

use std::path::Path;

use crate::error::InputError;

/// Kinds of files that hold a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineFormat {
    /// Two columns y, z.
    Columns,
    /// A header of lines `Key=value`, an empty line, columns y, z, ...
    Miniprof,
}

impl LineFormat {
    /// By the file's extension: `.ban` and `.whl` are a MiniProf's.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("ban" | "whl") => Self::Miniprof,
            _ => Self::Columns,
        }
    }
}

/// Points from lines of y, z and more columns that are not needed; `first` is the number of the first line.
pub(super) fn columns(text: &str, first: usize) -> Result<Vec<[f64; 2]>, InputError> {
    let mut points = Vec::new();
    for (k, line) in text.lines().enumerate() {
        let end = ["#", "%", "!", "//"].iter().filter_map(|mark| line.find(mark)).min().unwrap_or(line.len());
        let line = line[..end].trim();
        if line.is_empty() {
            continue;
        }
        let at = k + first;
        let between = |c: char| c == ',' || c == ';' || c.is_whitespace();
        let mut fields = line.split(between).filter(|field| !field.is_empty());
        let mut number = |what: &str| {
            // What stands there is not repeated: the file may be one that was not meant.
            let wrong = |given: String| InputError::new("file", given, "two finite numbers y, z in each line");
            let field = fields.next().ok_or_else(|| wrong(format!("no {what} in line {at}")))?;
            let value = field.parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| wrong(format!("something else than a number as {what} in line {at}")))
        };
        points.push([number("y")?, number("z")?]);
    }
    Ok(points)
}

/// Points of a MiniProf's file: what follows the first line without a key.
pub(super) fn miniprof(text: &str) -> Result<Vec<[f64; 2]>, InputError> {
    let mut rest = text;
    let mut line = 1;
    loop {
        let (head, tail) = rest.split_once('\n').unwrap_or((rest, ""));
        // A header ends with an empty line; some files have none and begin with numbers.
        let is_header = head.contains('=') || head.trim_start().starts_with('#');
        if !is_header
            && (head.trim().is_empty() && line > 1
                || head.trim_start().starts_with(|c: char| c == '-' || c.is_ascii_digit()))
        {
            break;
        }
        if tail.is_empty() {
            return Err(InputError::new(
                "file",
                "a header without points",
                "lines Key=value, an empty line, then y and z",
            ));
        }
        (rest, line) = (tail, line + 1);
    }
    columns(rest, line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_separator_and_comments() {
        for text in ["1 2\n3 4", "1,2\n3,4\n", "# y z\n1;2\r\n\n3;4 % last", "1\t2\t0.5\n\n3, 4, 9 // more"] {
            assert_eq!(columns(text, 1).unwrap(), [[1.0, 2.0], [3.0, 4.0]], "{text}");
        }
        assert_eq!(columns("1 2\n3", 1).unwrap_err().given, "no z in line 2");
        assert_eq!(columns("1 2\n\nsecret 5", 1).unwrap_err().given, "something else than a number as y in line 3");
    }

    #[test]
    fn headers_of_a_miniprof() {
        let text = "Date=01-09-2005\r\nUnits=mm\r\nColumnDef=X,Y,A,C,N\r\n\r\n-30.5 1.25 0.1 0.0 1\r\n-30.0\t1.5\r\n";
        assert_eq!(miniprof(text).unwrap(), [[-30.5, 1.25], [-30.0, 1.5]]);
        assert_eq!(miniprof("1.0 2.0\n3 4").unwrap(), [[1.0, 2.0], [3.0, 4.0]]);
        assert_eq!(miniprof("a=1\nb=2\n").unwrap_err().given, "a header without points");
        assert_eq!(miniprof("a=1\n\n1 x\n").unwrap_err().given, "something else than a number as z in line 3");
    }
}
