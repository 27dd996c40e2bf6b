//! Fields for ParaView: VTK's XML image data, values of cells.
//!
//! Format: VTK file formats, "XML file formats", serial `ImageData` with appended raw data: each array is its length in bytes (8 bytes)
//! and its numbers (8 bytes each), little-endian, x fastest, as in [`crate::Pressure`].

use std::io::{self, Write};

use crate::grid::Grid;
use crate::solution::Solution;

/// Writes fields on one grid, each with its name, as one layer of cells at z = 0; infinite values (no material) become NaN.
///
/// # Errors
/// When the writer fails, or a field has another number of values than the grid has cells.
///
/// ```
/// use contact_patch::{Grid, report};
/// let grid = Grid { origin: [0.0, 0.0], spacing: [0.5, 0.5], shape: [2, 1] };
/// let mut file = Vec::new();
/// report::vti(&mut file, &grid, &[("pressure", &[1.0, 2.0])])?;
/// assert!(file.starts_with(b"<?xml") && file.ends_with(b"</VTKFile>\n"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn vti(to: &mut dyn Write, grid: &Grid, fields: &[(&str, &[f64])]) -> io::Result<()> {
    let Grid { origin: [x, y], spacing: [dx, dy], shape: [nx, ny] } = *grid;
    if let Some((name, values)) = fields.iter().find(|(_, values)| values.len() != grid.len()) {
        let told = format!("{} values of {name} for {nx} x {ny} cells", values.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, told));
    }
    let extent = format!("0 {nx} 0 {ny} 0 0");
    writeln!(to, "<?xml version=\"1.0\"?>")?;
    writeln!(to, "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">")?;
    // A layer has no height; its step along z only has to be greater than zero.
    writeln!(
        to,
        "<ImageData WholeExtent=\"{extent}\" Origin=\"{x:e} {y:e} 0\" Spacing=\"{dx:e} {dy:e} {:e}\">",
        dx.min(dy)
    )?;
    let first = fields.first().map_or(String::new(), |(name, _)| format!(" Scalars=\"{}\"", escaped(name)));
    writeln!(to, "<Piece Extent=\"{extent}\">\n<CellData{first}>")?;
    for (k, (name, _)) in fields.iter().enumerate() {
        let offset = k * (8 + 8 * grid.len());
        writeln!(
            to,
            "<DataArray type=\"Float64\" Name=\"{}\" format=\"appended\" offset=\"{offset}\"/>",
            escaped(name)
        )?;
    }
    write!(to, "</CellData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_")?;
    for (_, values) in fields {
        to.write_all(&(8 * values.len() as u64).to_le_bytes())?;
        for value in *values {
            to.write_all(&(if value.is_infinite() { f64::NAN } else { *value }).to_le_bytes())?;
        }
    }
    write!(to, "\n</AppendedData>\n</VTKFile>\n")
}

/// Writes the pressure of a state and, where it has one on the same cells, the gap that is left after loading. Says whether there was a
/// field; without one nothing is written.
///
/// # Errors
/// When the writer fails.
pub fn vti_of(to: &mut dyn Write, solution: &Solution) -> io::Result<bool> {
    let pressure = solution.pressure.field.as_ref().map(|field| (field.grid, "pressure", field.values.as_slice()));
    let gap = solution.pressure.gap.as_ref().map(|(grid, values)| (*grid, "gap", values.as_slice()));
    let Some((grid, ..)) = pressure.or(gap) else { return Ok(false) };
    let fields: Vec<_> =
        pressure.into_iter().chain(gap).filter(|f| f.0 == grid).map(|(_, name, values)| (name, values)).collect();
    vti(to, &grid, &fields)?;
    Ok(true)
}

/// A name as the value of an attribute.
fn escaped(name: &str) -> String {
    let plain = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    plain.chars().filter(|c| !c.is_control()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { origin: [-1e-6, 2.0], spacing: [0.1, 0.25], shape: [2, 3] };

    #[test]
    fn numbers_stand_where_the_offsets_say() {
        let (p, g) = ([1.0, 0.1, 1e300, 0.0, -0.0, 5e-324], [f64::INFINITY, 1.0, 2.0, 3.0, 4.0, 0.3]);
        let mut file = Vec::new();
        vti(&mut file, &GRID, &[("pressure", &p), ("gap", &g)]).unwrap();
        let start = file.windows(2).position(|w| w == b"\n_").unwrap() + 2;
        let number = |at: usize| f64::from_le_bytes(file[at..at + 8].try_into().unwrap());
        assert_eq!(u64::from_le_bytes(file[start..start + 8].try_into().unwrap()), 48);
        assert!((0..6).all(|k| number(start + 8 + 8 * k).to_bits() == p[k].to_bits()));
        assert!(number(start + 56 + 8).is_nan());
        assert!((1..6).all(|k| number(start + 56 + 8 + 8 * k) == g[k]));
        let head = String::from_utf8_lossy(&file[..start]);
        assert!(head.contains("offset=\"56\"") && head.contains("Origin=\"-1e-6 2e0 0\""), "{head}");
    }

    #[test]
    fn a_field_of_another_size_is_refused() {
        let refused = vti(&mut Vec::new(), &GRID, &[("p", &[1.0])]).unwrap_err();
        assert!(refused.to_string().contains("1 values of p for 2 x 3 cells"));
    }

    #[test]
    fn names_stay_inside_their_attribute() {
        let mut file = Vec::new();
        vti(&mut file, &Grid { shape: [1, 1], ..GRID }, &[("a\"<b&\n", &[1.0])]).unwrap();
        assert!(String::from_utf8_lossy(&file).contains("Name=\"a&quot;&lt;b&amp;\""));
    }
}
