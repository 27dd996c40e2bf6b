//! NumPy's array file, read against its real length before anything is allocated.

use crate::error::InputError;

fn refuse(given: impl std::fmt::Display, allowed: impl Into<String>) -> InputError {
    InputError::new("file", given, allowed)
}

/// Values by rows, and the number along x and y.
///
/// Format: NumPy enhancement proposal 1, versions 1.0 to 3.0.
pub(super) fn read(bytes: &[u8]) -> Result<(Vec<f64>, [usize; 2]), InputError> {
    let short = || refuse(format!("a file of {} bytes", bytes.len()), "a whole .npy file");
    let Some(rest) = bytes.strip_prefix(b"\x93NUMPY") else {
        return Err(refuse(format!("a file of {} bytes without NumPy's mark", bytes.len()), "a .npy file"));
    };
    let (version, rest) = rest.split_at_checked(2).ok_or_else(short)?;
    let (length, rest) = match version[0] {
        1 => rest.split_first_chunk::<2>().map(|(n, rest)| (u64::from(u16::from_le_bytes(*n)), rest)),
        2 | 3 => rest.split_first_chunk::<4>().map(|(n, rest)| (u64::from(u32::from_le_bytes(*n)), rest)),
        v => return Err(refuse(format!("version {v} of the .npy format"), "version 1, 2 or 3")),
    }
    .ok_or_else(short)?;
    let (header, data) = usize::try_from(length).ok().and_then(|n| rest.split_at_checked(n)).ok_or_else(|| {
        refuse(format!("a header of {length} bytes in a file of {}", bytes.len()), "a header that the file holds")
    })?;
    let header = std::str::from_utf8(header).map_err(|_| refuse("a header that is not text", "a .npy file"))?;
    let Header { kind, fortran, rows, columns } = Header::of(header)?;
    let wanted = rows.checked_mul(columns).and_then(|n| n.checked_mul(kind.size()));
    if wanted != Some(data.len()) {
        let given = format!("{} bytes of numbers for a shape of ({rows}, {columns})", data.len());
        let allowed = match wanted {
            Some(wanted) => format!("{wanted} bytes, as the header says"),
            None => "a shape that a file can hold".to_owned(),
        };
        return Err(refuse(given, allowed));
    }
    if rows < 2 || columns < 2 {
        return Err(refuse(format!("a shape of ({rows}, {columns})"), "at least two rows of at least two heights"));
    }
    let numbers: Vec<f64> = data.chunks_exact(kind.size()).map(|chunk| kind.number(chunk)).collect();
    if let Some(k) = numbers.iter().position(|v| v.is_infinite()) {
        return Err(refuse(format!("an infinite number as number {k}"), "finite heights, or NaN for holes"));
    }
    if !fortran {
        return Ok((numbers, [columns, rows]));
    }
    let by_rows = (0..rows * columns).map(|k| numbers[(k % columns) * rows + k / columns]).collect();
    Ok((by_rows, [columns, rows]))
}

struct Header {
    kind: Kind,
    fortran: bool,
    rows: usize,
    columns: usize,
}

impl Header {
    /// Reads `{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }`: each key once, and no other.
    fn of(text: &str) -> Result<Self, InputError> {
        let malformed = || refuse("a header that is not one of NumPy's", "a .npy file");
        let body = text.trim().strip_prefix('{').and_then(|t| t.strip_suffix('}')).ok_or_else(malformed)?;
        let mut entries: [Option<&str>; 3] = [None; 3];
        let mut rest = body.trim_start();
        while !rest.is_empty() {
            let (key, after) = string(rest).ok_or_else(malformed)?;
            let after = after.trim_start().strip_prefix(':').ok_or_else(malformed)?.trim_start();
            let end = value_end(after).ok_or_else(malformed)?;
            let place = KEYS.iter().position(|known| *known == key).ok_or_else(malformed)?;
            if entries[place].is_some() {
                return Err(refuse(format!("a header with {key} twice"), "each key once"));
            }
            entries[place] = Some(after[..end].trim_end());
            rest = after[end..].trim_start();
            if !rest.is_empty() {
                rest = rest.strip_prefix(',').ok_or_else(malformed)?.trim_start();
            }
        }
        let entry = |k: usize| entries[k].ok_or_else(|| refuse("a header without", format!("an entry {}", KEYS[k])));
        let kind = string(entry(0)?).filter(|(_, rest)| rest.is_empty()).and_then(|(name, _)| Kind::of(name));
        let kind = kind.ok_or_else(|| {
            refuse("numbers of another type", "an array of floats of 4 or 8 bytes or of integers, such as '<f8'")
        })?;
        let fortran = match entry(1)? {
            "True" => true,
            "False" => false,
            _ => return Err(refuse("another word", "True or False as fortran_order")),
        };
        let shape = entry(2)?.strip_prefix('(').and_then(|s| s.strip_suffix(')'));
        let sides: Option<Vec<usize>> = shape.and_then(|shape| {
            let sides = shape.split(',').map(str::trim).filter(|s| !s.is_empty());
            sides.map(|s| s.parse().ok()).collect()
        });
        match sides.as_deref() {
            Some(&[rows, columns]) => Ok(Self { kind, fortran, rows, columns }),
            _ => Err(refuse("an array of another shape", "a shape of two numbers, (rows, columns)")),
        }
    }
}

/// The keys of a header.
const KEYS: [&str; 3] = ["descr", "fortran_order", "shape"];

/// A string in quotes at the beginning of the text, and what follows it.
fn string(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

/// Where a value ends: at the next comma that is in no string and in no bracket, or with the text. `None` for brackets and strings
/// without an end.
fn value_end(text: &str) -> Option<usize> {
    let (mut depth, mut quote) = (0_usize, None);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth = depth.checked_sub(1)?,
            (None, ',') if depth == 0 => return Some(at),
            (None, _) => {}
        }
    }
    (depth == 0 && quote.is_none()).then_some(text.len())
}

/// Type of the numbers in the file.
#[derive(Debug, Clone, Copy)]
struct Kind {
    big_endian: bool,
    letter: u8,
    bytes: usize,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        let &[order, letter, bytes] = name.as_bytes() else { return None };
        let big_endian = match order {
            b'<' | b'|' | b'=' => false,
            b'>' => true,
            _ => return None,
        };
        let known = matches!((letter, bytes), (b'f', b'4' | b'8') | (b'i' | b'u', b'1' | b'2' | b'4' | b'8'));
        known.then(|| Self { big_endian, letter, bytes: usize::from(bytes - b'0') })
    }

    fn size(self) -> usize {
        self.bytes
    }

    /// The number in a chunk of [`Kind::size`] bytes.
    fn number(self, chunk: &[u8]) -> f64 {
        // Little-endian, filled up to eight bytes.
        let mut low = [0; 8];
        for (k, byte) in low[..self.bytes].iter_mut().enumerate() {
            *byte = chunk[if self.big_endian { self.bytes - 1 - k } else { k }];
        }
        let whole = u64::from_le_bytes(low);
        let unused = 64 - 8 * self.bytes as u32;
        match (self.letter, self.bytes) {
            (b'f', 8) => f64::from_bits(whole),
            (b'f', _) => f64::from(f32::from_bits(whole as u32)),
            // Shifting up and back carries the sign along.
            (b'i', _) => ((whole << unused) as i64 >> unused) as f64,
            _ => whole as f64,
        }
    }
}
