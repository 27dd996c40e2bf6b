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

/// Points from lines of numbers; `first` is the number of the first line, `at` tells which columns are y and z. One line of words may
/// stand above.
pub(super) fn columns(text: &str, first: usize, at: [usize; 2]) -> Result<Vec<[f64; 2]>, InputError> {
    let mut points = Vec::new();
    let mut heading = true;
    for (k, line) in text.lines().enumerate() {
        let end = ["#", "%", "!", "//"].iter().filter_map(|mark| line.find(mark)).min().unwrap_or(line.len());
        let line = line[..end].trim();
        if line.is_empty() {
            continue;
        }
        let number = k + first;
        // What stands there is not repeated: the file may be one that was not meant.
        let wrong = |given: String| InputError::new("file", given, "two finite numbers y, z in each line");
        let fields = fields(line)
            .ok_or_else(|| wrong(format!("commas of which it is not clear what they part in line {number}")))?;
        if std::mem::take(&mut heading) && fields.iter().all(|field| is_word(field)) {
            continue;
        }
        let value = |column: usize, what: &str| {
            let field = fields.get(column).ok_or_else(|| wrong(format!("no {what} in line {number}")))?;
            let value = field.parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| wrong(format!("something else than a number as {what} in line {number}")))
        };
        points.push([value(at[0], "y")?, value(at[1], "z")?]);
    }
    Ok(points)
}

/// The fields of a line: parted by semicolons or tabs, where a comma within a number is that of its decimals, else by commas and blanks.
/// `None` where blanks part numbers that hold commas.
fn fields(line: &str) -> Option<Vec<String>> {
    if line.contains([';', '\t']) {
        let parts = line.split(|c: char| c == ';' || c.is_whitespace()).map(|field| field.trim_end_matches(','));
        return Some(parts.filter(|field| !field.is_empty()).map(|field| field.replacen(',', ".", 1)).collect());
    }
    let within = |field: &str| field.trim_end_matches(',').contains(',');
    let blanks: Vec<&str> = line.split_whitespace().collect();
    if blanks.len() > 1 && blanks.iter().any(|field| within(field)) {
        return None;
    }
    let parts = line.split(|c: char| c == ',' || c.is_whitespace());
    Some(parts.filter(|field| !field.is_empty()).map(str::to_owned).collect())
}

/// Whether a field is one of a heading.
fn is_word(field: &str) -> bool {
    let field = field.trim_matches(['"', '\'', '[', '(']);
    field.starts_with(|c: char| c.is_ascii_alphabetic()) && field.parse::<f64>().is_err()
}

/// What the header of a MiniProf says of its columns.
struct Header {
    /// Which are y and z.
    at: [usize; 2],
    /// Their unit in millimetres.
    unit: f64,
}

impl Header {
    /// Takes a line `Key=value`; other keys are passed over.
    fn read(&mut self, line: &str) -> Result<(), InputError> {
        let Some((key, value)) = line.split_once('=') else { return Ok(()) };
        let (key, value) = (key.trim().to_ascii_lowercase(), value.trim().to_ascii_lowercase());
        match key.as_str() {
            "units" => {
                let known = [("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("um", 1e-3), ("inch", 25.4), ("in", 25.4)];
                let unit = known.iter().find(|(name, _)| *name == value).map(|(_, unit)| *unit);
                let allowed = "Units=mm, cm, m, um or inch";
                self.unit = unit.ok_or_else(|| InputError::new("file", "another unit in its header", allowed))?;
            }
            "columndef" => {
                let place = |name: &str| value.split(',').position(|column| column.trim() == name);
                let (Some(y), Some(z)) = (place("x"), place("y")) else {
                    return Err(InputError::new("file", "columns without X and Y in its header", "ColumnDef=X,Y,..."));
                };
                self.at = [y, z];
            }
            _ => {}
        }
        Ok(())
    }
}

/// Points of a MiniProf's file in millimetres: what follows the first line without a key.
pub(super) fn miniprof(text: &str) -> Result<Vec<[f64; 2]>, InputError> {
    let mut header = Header { at: [0, 1], unit: 1.0 };
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
        header.read(head)?;
        (rest, line) = (tail, line + 1);
    }
    let points = columns(rest, line, header.at)?;
    Ok(points.into_iter().map(|p| p.map(|v| v * header.unit)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_separator_and_comments() {
        for text in ["1 2\n3 4", "1,2\n3,4\n", "# y z\n1;2\r\n\n3;4 % last", "1\t2\t0.5\n\n3, 4, 9 // more"] {
            assert_eq!(columns(text, 1, [0, 1]).unwrap(), [[1.0, 2.0], [3.0, 4.0]], "{text}");
        }
        assert_eq!(columns("1 2\n3", 1, [0, 1]).unwrap_err().given, "no z in line 2");
        assert_eq!(
            columns("1 2\n\nsecret 5", 1, [0, 1]).unwrap_err().given,
            "something else than a number as y in line 3"
        );
    }

    #[test]
    fn commas_of_decimals_and_headings() {
        for text in
            ["-8,5;1,6\n2,25; 3", "-8,5\t1,6\n2.25\t3", "y;z\n-8,5;1,6\n2,25;3", "y [mm], z [mm]\n-8.5,1.6\n2.25, 3"]
        {
            assert_eq!(columns(text, 1, [0, 1]).unwrap(), [[-8.5, 1.6], [2.25, 3.0]], "{text}");
        }
        let given = columns("1 2\n-8,5 1,6", 1, [0, 1]).unwrap_err().given;
        assert_eq!(given, "commas of which it is not clear what they part in line 2");
        assert!(columns("y z\ny z\n1 2", 1, [0, 1]).is_err() && columns("nan 2", 1, [0, 1]).is_err());
    }

    #[test]
    fn headers_of_a_miniprof() {
        let text = "Date=01-09-2005\r\nUnits=mm\r\nColumnDef=X,Y,A,C,N\r\n\r\n-30.5 1.25 0.1 0.0 1\r\n-30.0\t1.5\r\n";
        assert_eq!(miniprof(text).unwrap(), [[-30.5, 1.25], [-30.0, 1.5]]);
        assert_eq!(miniprof("1.0 2.0\n3 4").unwrap(), [[1.0, 2.0], [3.0, 4.0]]);
        let text = "Units=inch\nColumnDef=N,Y,X\n\n7 2 -1\n8 4 0\n";
        assert_eq!(miniprof(text).unwrap(), [[-25.4, 50.8], [0.0, 101.6]]);
        assert_eq!(miniprof("Units=furlong\n\n1 2\n3 4").unwrap_err().given, "another unit in its header");
        assert_eq!(miniprof("ColumnDef=A,B\n\n1 2\n").unwrap_err().given, "columns without X and Y in its header");
        assert_eq!(miniprof("a=1\nb=2\n").unwrap_err().given, "a header without points");
        assert_eq!(miniprof("a=1\n\n1 x\n").unwrap_err().given, "something else than a number as z in line 3");
    }
}
