//! A field as a NumPy .npy file, version 1.0: `numpy.load(file)[j, i]` is cell (i, j).

use std::io::{self, Write};

/// Writes `values`, x fastest, as an array of shape (ny, nx).
pub(crate) fn write(to: &mut dyn Write, [nx, ny]: [usize; 2], values: &[f64]) -> io::Result<()> {
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({ny}, {nx}), }}");
    // Magic, version and length take 10 bytes; the data starts at a multiple of 64, after a line feed.
    while !(10 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    to.write_all(b"\x93NUMPY\x01\x00")?;
    to.write_all(&(header.len() as u16).to_le_bytes())?;
    to.write_all(header.as_bytes())?;
    values.iter().try_for_each(|value| to.write_all(&value.to_le_bytes()))
}
