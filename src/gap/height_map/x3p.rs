//! X3P files: ISO 25178-72:2017 (formerly ISO 5436-2), a zip archive of `main.xml` and the heights. All lengths are in metres.

use std::io::{Cursor, Read as _};

use super::Read;
use crate::error::InputError;

/// Longest description that is read, in bytes, and most elements in it.
const LONGEST: u64 = 1 << 24;
const MOST_ELEMENTS: u32 = 1 << 20;

/// Most nodes of a map.
const MOST_NODES: usize = 1 << 27;

fn refuse(given: impl std::fmt::Display, allowed: impl Into<String>) -> InputError {
    InputError::new("file", given, allowed)
}

type Archive<'a> = zip::ZipArchive<Cursor<&'a [u8]>>;
type Element<'a> = roxmltree::Node<'a, 'a>;

/// At most `longest` bytes of a member of the archive, whatever the archive says of its length.
fn member(archive: &mut Archive, name: &str, longest: u64) -> Result<Vec<u8>, InputError> {
    let name = name.trim_start_matches(['/', '.']);
    let absent =
        |what: &str| refuse(format!("an archive {what}"), "a zip archive with main.xml and the heights it names");
    let file = archive.by_name(name).map_err(|_| absent("without a part that it needs"))?;
    let mut bytes = Vec::new();
    file.take(longest + 1).read_to_end(&mut bytes).map_err(|_| absent("with a part that cannot be unpacked"))?;
    if bytes.len() as u64 > longest {
        return Err(refuse(format!("a part of more than {longest} bytes"), format!("at most {longest} bytes")));
    }
    Ok(bytes)
}

/// The first element with this name below another, whatever its name space.
fn below<'a>(element: Element<'a>, name: &str) -> Option<Element<'a>> {
    element.descendants().find(|e| e.is_element() && e.tag_name().name() == name)
}

fn text<'a>(element: Element<'a>, name: &str) -> Option<&'a str> {
    below(element, name).and_then(|e| e.text()).map(str::trim).filter(|text| !text.is_empty())
}

/// Heights and steps in metres.
pub(super) fn read(bytes: &[u8]) -> Result<Read, InputError> {
    let mut archive = Archive::new(Cursor::new(bytes))
        .map_err(|_| refuse("a file that is no zip archive", "an .x3p file of ISO 25178-72"))?;
    let description = member(&mut archive, "main.xml", LONGEST)?;
    let description = std::str::from_utf8(&description).map_err(|_| refuse("a main.xml that is not UTF-8", "UTF-8"))?;
    let options = roxmltree::ParsingOptions { allow_dtd: false, nodes_limit: MOST_ELEMENTS, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(description.trim_start_matches('\u{feff}'), options)
        .map_err(|_| refuse("a main.xml that is not XML, or has a document type", "the XML of ISO 25178-72"))?;
    let root = document.root_element();
    if let Some(sort) = text(root, "FeatureType").filter(|sort| *sort != "SUR") {
        let sort = if sort == "PRF" { "a profile (PRF)" } else { "a feature that is no surface" };
        return Err(refuse(sort, "a surface (FeatureType SUR)"));
    }
    let map = Map::of(root)?;
    let values = match text(root, "PointDataLink") {
        Some(link) => {
            let longest = map.shape[0] * map.shape[1] * map.kind.size();
            let data = member(&mut archive, link, longest as u64)?;
            if data.len() != longest {
                let given = format!("{} bytes of heights for {} x {} nodes", data.len(), map.shape[0], map.shape[1]);
                return Err(refuse(given, format!("{longest} bytes")));
            }
            data.chunks_exact(map.kind.size()).map(|chunk| map.kind.number(chunk)).collect()
        }
        None => listed(root)?,
    };
    let mut values: Vec<f64> = values;
    if values.len() != map.shape[0] * map.shape[1] {
        let given = format!("{} heights for {} x {} nodes", values.len(), map.shape[0], map.shape[1]);
        return Err(refuse(given, "as many heights as nodes"));
    }
    if let Some(link) = text(root, "ValidPointsLink") {
        // One bit a node, the first one lowest.
        let bits = member(&mut archive, link, (values.len() as u64).div_ceil(8) + 8)?;
        for (k, value) in values.iter_mut().enumerate() {
            if bits.get(k / 8).is_some_and(|byte| byte >> (k % 8) & 1 == 0) {
                *value = f64::NAN;
            }
        }
    }
    for value in &mut values {
        *value = *value * map.unit + map.offset;
    }
    if values.iter().any(|v| v.is_infinite()) {
        return Err(refuse("an infinite height", "finite heights, or NaN for holes"));
    }
    Ok(Read { values, shape: map.shape, spacing: map.spacing })
}

/// Heights that stand in the description, `x;y;z` each, or nothing for a hole.
fn listed(root: Element) -> Result<Vec<f64>, InputError> {
    let list = below(root, "DataList").ok_or_else(|| refuse("no heights", "a PointDataLink or a DataList"))?;
    let data = list.children().filter(|e| e.is_element() && e.tag_name().name() == "Datum");
    data.map(|datum| {
        let Some(text) = datum.text().map(str::trim).filter(|text| !text.is_empty()) else { return Ok(f64::NAN) };
        let last = text.rsplit(';').next().unwrap_or_default().trim();
        last.parse::<f64>().map_err(|_| refuse("something else as a Datum", "a height, or x;y;z"))
    })
    .collect()
}

/// What the description says of the heights.
struct Map {
    shape: [usize; 2],
    spacing: [f64; 2],
    kind: Kind,
    unit: f64,
    offset: f64,
}

impl Map {
    fn of(root: Element) -> Result<Self, InputError> {
        let axis =
            |name: &str| below(root, name).ok_or_else(|| refuse(format!("no axis {name}"), "axes CX, CY and CZ"));
        let number = |axis: Element, name: &str, otherwise: f64| match text(axis, name) {
            None => Ok(otherwise),
            Some(value) => {
                let wrong = || refuse(format!("something else as {name}"), "a finite number");
                value.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong)
            }
        };
        let step = |name: &str| {
            let axis = axis(name)?;
            if text(axis, "AxisType") == Some("A") {
                return Err(refuse(format!("absolute places along {name}"), "a regular grid (AxisType I)"));
            }
            let step = number(axis, "Increment", f64::NAN)?;
            Some(step)
                .filter(|s| *s > 0.0)
                .ok_or_else(|| refuse(format!("no step along {name}"), "an Increment greater than 0"))
        };
        let size = |name: &str| {
            let wrong = || refuse(format!("something else as {name}"), "a whole number of at least 2");
            text(root, name).and_then(|n| n.parse::<usize>().ok()).filter(|n| *n >= 2).ok_or_else(wrong)
        };
        let shape = [size("SizeX")?, size("SizeY")?];
        if text(root, "SizeZ").is_some_and(|n| n != "1") {
            return Err(refuse("several layers", "SizeZ 1"));
        }
        if shape[0].checked_mul(shape[1]).is_none_or(|nodes| nodes > MOST_NODES) {
            return Err(refuse(format!("{} x {} nodes", shape[0], shape[1]), format!("at most {MOST_NODES} of them")));
        }
        let heights = axis("CZ")?;
        let kind = match text(heights, "DataType") {
            Some("I") => Kind::Short,
            Some("L") => Kind::Long,
            Some("F") => Kind::Single,
            Some("D") | None => Kind::Double,
            Some(_) => return Err(refuse("heights of another type", "DataType I, L, F or D")),
        };
        let (unit, offset) = (number(heights, "Increment", 1.0)?, number(heights, "Offset", 0.0)?);
        Ok(Self { shape, spacing: [step("CX")?, step("CY")?], kind, unit, offset })
    }
}

/// Type of the numbers, little-endian.
#[derive(Clone, Copy)]
enum Kind {
    Short,
    Long,
    Single,
    Double,
}

impl Kind {
    fn size(self) -> usize {
        match self {
            Self::Short => 2,
            Self::Long | Self::Single => 4,
            Self::Double => 8,
        }
    }

    /// The number in a chunk of [`Kind::size`] bytes.
    fn number(self, chunk: &[u8]) -> f64 {
        let mut low = [0; 8];
        low[..chunk.len()].copy_from_slice(chunk);
        let bits = u64::from_le_bytes(low);
        match self {
            Self::Short => f64::from(bits as u16 as i16),
            Self::Long => f64::from(bits as u32 as i32),
            Self::Single => f64::from(f32::from_bits(bits as u32)),
            Self::Double => f64::from_bits(bits),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn description(kind: &str, more: &str) -> String {
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\"><Record1>\
             <Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes><CX><AxisType>I</AxisType><DataType>D</DataType>\
             <Increment>1e-6</Increment><Offset>0</Offset></CX><CY><AxisType>I</AxisType><DataType>D</DataType><Increment>2e-6</Increment>\
             <Offset>0</Offset></CY><CZ><AxisType>A</AxisType><DataType>{kind}</DataType>{more}</CZ></Axes></Record1><Record3>\
             <MatrixDimension><SizeX>3</SizeX><SizeY>2</SizeY><SizeZ>1</SizeZ></MatrixDimension><DataLink><PointDataLink>bindata/data.bin\
             </PointDataLink></DataLink></Record3></p:ISO5436_2>"
        )
    }

    fn packed(parts: &[(&str, &[u8])]) -> Vec<u8> {
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let deflated = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
        for (name, bytes) in parts {
            writer.start_file(*name, deflated).unwrap();
            writer.write_all(bytes).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    #[test]
    fn heights_of_every_type() {
        let z = [1.0, -2.0, 3.0, 4.0, 5.0, -6.0_f64];
        let data: [(&str, Vec<u8>); 4] = [
            ("I", z.iter().flat_map(|z| (*z as i16).to_le_bytes()).collect()),
            ("L", z.iter().flat_map(|z| (*z as i32).to_le_bytes()).collect()),
            ("F", z.iter().flat_map(|z| (*z as f32).to_le_bytes()).collect()),
            ("D", z.iter().flat_map(|z| z.to_le_bytes()).collect()),
        ];
        for (kind, bytes) in data {
            let xml = description(kind, "<Increment>1e-9</Increment><Offset>5e-9</Offset>");
            let file = packed(&[("main.xml", xml.as_bytes()), ("bindata/data.bin", &bytes)]);
            let Read { values, shape, spacing } = read(&file).unwrap();
            assert_eq!((shape, spacing), ([3, 2], [1e-6, 2e-6]));
            assert!(values.iter().zip(z).all(|(v, z)| (v - (1e-9 * z + 5e-9)).abs() < 1e-22), "{kind}: {values:?}");
        }
    }

    #[test]
    fn holes_by_nan_and_by_bits() {
        let z = [1.0, f64::NAN, 3.0, 4.0, 5.0, 6.0];
        let bytes: Vec<u8> = z.iter().flat_map(|z| z.to_le_bytes()).collect();
        let xml = description("D", "")
            .replace("</PointDataLink>", "</PointDataLink><ValidPointsLink>bindata/valid.bin</ValidPointsLink>");
        let file = packed(&[
            ("main.xml", xml.as_bytes()),
            ("bindata/data.bin", &bytes),
            ("bindata/valid.bin", &[0b0001_1111]),
        ]);
        let values = read(&file).unwrap().values;
        assert!(values[1].is_nan() && values[5].is_nan() && values[4] == 5.0);
    }

    #[test]
    fn heights_within_the_description() {
        let list = "<DataList><Datum>1</Datum><Datum/><Datum>0;0;3</Datum><Datum>4</Datum><Datum>5</Datum><Datum>6</Datum></DataList>";
        let xml =
            description("D", "").replace("<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>", list);
        let values = read(&packed(&[("main.xml", xml.as_bytes())])).unwrap().values;
        assert!(values[1].is_nan() && values[2] == 3.0 && values[5] == 6.0);
    }

    #[test]
    fn bombs_and_broken_files_are_refused() {
        let given = |file: &[u8]| read(file).unwrap_err().given;
        assert_eq!(given(b"PK"), "a file that is no zip archive");
        assert_eq!(given(&packed(&[("other", b"")])), "an archive without a part that it needs");
        let xml = description("D", "");
        assert_eq!(given(&packed(&[("main.xml", xml.as_bytes())])), "an archive without a part that it needs");
        // Three megabytes of zeros where 48 bytes belong.
        let bomb = packed(&[("main.xml", xml.as_bytes()), ("bindata/data.bin", &vec![0; 3 << 20])]);
        assert_eq!(given(&bomb), "a part of more than 48 bytes");
        assert_eq!(
            given(&packed(&[("main.xml", xml.as_bytes()), ("bindata/data.bin", &[0; 40])])),
            "40 bytes of heights for 3 x 2 nodes"
        );
        let vast = xml.replace("<SizeX>3<", "<SizeX>4000000000<").replace("<SizeY>2<", "<SizeY>4000000000<");
        assert!(given(&packed(&[("main.xml", vast.as_bytes())])).contains("nodes"));
        let lol = format!("<!DOCTYPE x [<!ENTITY a \"aaaa\">]>{}", xml.split_once("?>").unwrap().1);
        assert_eq!(
            given(&packed(&[("main.xml", lol.as_bytes())])),
            "a main.xml that is not XML, or has a document type"
        );
        let profile = xml.replace(">SUR<", ">PRF<");
        assert_eq!(given(&packed(&[("main.xml", profile.as_bytes())])), "a profile (PRF)");
    }
}
