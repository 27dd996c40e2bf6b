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
        return Err(refuse(format!("{} as number {k}", numbers[k]), "finite heights, or NaN for holes"));
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
    /// Reads `{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }`.
    fn of(text: &str) -> Result<Self, InputError> {
        let shown: String = text.trim().chars().take(100).collect();
        let entry = |key: &str| {
            let quoted = text.find(&format!("'{key}'")).or_else(|| text.find(&format!("\"{key}\"")));
            let found = quoted.and_then(|at| text[at + key.len() + 2..].trim_start().strip_prefix(':'));
            found.map(str::trim_start).ok_or_else(|| refuse(format!("the header {shown}"), format!("an entry {key}")))
        };
        let descr = entry("descr")?;
        let name = match descr.chars().next() {
            Some(quote @ ('\'' | '"')) => descr[1..].split(quote).next().unwrap_or_default(),
            _ => "",
        };
        let kind = Kind::of(name).ok_or_else(|| {
            let given =
                if name.is_empty() { "a structured array".to_owned() } else { format!("numbers of type {name}") };
            refuse(given, "floats of 4 or 8 bytes or integers, such as '<f8'")
        })?;
        let order = entry("fortran_order")?;
        let fortran = order.starts_with("True");
        if !fortran && !order.starts_with("False") {
            return Err(refuse(format!("the header {shown}"), "True or False as fortran_order"));
        }
        let shape = entry("shape")?.strip_prefix('(').and_then(|s| s.split_once(')')).map(|s| s.0);
        let sides: Option<Vec<usize>> = shape.and_then(|shape| {
            let sides = shape.split(',').map(str::trim).filter(|s| !s.is_empty());
            sides.map(|s| s.parse().ok()).collect()
        });
        match sides.as_deref() {
            Some(&[rows, columns]) => Ok(Self { kind, fortran, rows, columns }),
            _ => Err(refuse(format!("the header {shown}"), "a shape of two numbers, (rows, columns)")),
        }
    }
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
