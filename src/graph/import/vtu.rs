//! VTK's XML files: unstructured grids (`.vtu`) and polydata (`.vtp`), with arrays as text, in base64, or appended, also raw; packed
//! by zlib or not.
//!
//! A raw appendix is not XML: the text is cut before it. Arrays grow with the bytes that are there, whatever their headers say.

use super::draft::Draft;
use super::grid::{Grid, is_radius};
use super::mesh::Edges;
use super::xml::{Piece, Tag, Xml, decode};
use super::{limits, text};
use crate::error::Fault;
use flate2::read::ZlibDecoder;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;

/// How the file writes binary arrays.
#[derive(Clone, Copy, Default)]
struct Form {
    big_endian: bool,
    /// Counts in array headers have 8 bytes.
    long_counts: bool,
    zlib: bool,
}

/// Bytes after the `_` of the appendix.
#[derive(Clone, Copy)]
enum Appendix<'a> {
    None,
    Base64(&'a [u8]),
    Raw(&'a [u8]),
}

pub fn read(bytes: &[u8], draft: &mut Draft) {
    if let Err(fault) = document(bytes, draft) {
        draft.fault_at(fault.path, fault.found, fault.wanted);
    }
}

/// The text without the appendix, and the appendix.
fn split(bytes: &[u8]) -> (Cow<'_, [u8]>, Appendix<'_>) {
    let find = |from: usize, what: &[u8]| bytes[from..].windows(what.len()).position(|w| w == what).map(|k| from + k);
    let start = find(0, b"<AppendedData");
    let parts = start.and_then(|start| {
        let tag = find(start, b">")?;
        let data = find(tag, b"_")? + 1;
        Some((start, &bytes[start..tag], &bytes[data..]))
    });
    match parts {
        None => (Cow::Borrowed(bytes), Appendix::None),
        Some((start, tag, data)) => {
            let is_raw = tag.windows(3).any(|w| w == b"raw");
            let head = [&bytes[..start], b"</VTKFile>"].concat();
            (Cow::Owned(head), if is_raw { Appendix::Raw(data) } else { Appendix::Base64(data) })
        }
    }
}

fn document(bytes: &[u8], draft: &mut Draft) -> Result<(), Fault> {
    let (head, appendix) = split(bytes);
    let mut left = limits::unpacked(bytes.len());
    let mut xml = Xml::new(decode(&head, "")?, &[], String::new());
    let mut form = Form::default();
    let mut edges = Edges::default();
    let mut pieces = 0;
    let mut section = String::new();
    // all arrays of a piece, by section and name
    let mut arrays: BTreeMap<(String, String), Vec<f64>> = BTreeMap::new();
    let mut array: Option<Array> = None;
    // open elements inside the array: what they say of it is not its content
    let mut inner = 0;
    while let Some(piece) = xml.next()? {
        match piece {
            Piece::Open(_) if array.is_some() => inner += 1,
            Piece::Close(_) if inner > 0 => inner -= 1,
            Piece::Open(tag) => match tag.name() {
                "VTKFile" => form = self::form(&tag)?,
                "Piece" => arrays.clear(),
                "Points" | "Cells" | "Verts" | "Lines" | "Strips" | "Polys" | "PointData" | "CellData" => section = tag.name().to_owned(),
                "DataArray" => array = Some(Array::open(&tag, &section, pieces)),
                _ => {}
            },
            Piece::Text(t) => {
                if let Some(array) = array.as_mut().filter(|_| inner == 0) {
                    array.text.push_str(&t);
                }
            }
            Piece::Close(name) => match name.as_ref() {
                "DataArray" => {
                    if let Some(array) = array.take().filter(Array::is_wanted) {
                        let values = array.values(form, appendix, &mut left)?;
                        arrays.insert((array.section, array.key), values);
                    }
                }
                "Points" | "Cells" | "Verts" | "Lines" | "Strips" | "Polys" | "PointData" | "CellData" => section.clear(),
                "Piece" => {
                    let before = format!("Piece[{pieces}].");
                    grid(&mut arrays).pour(&before, &mut edges, draft);
                    pieces += 1;
                }
                _ => {}
            },
        }
        if draft.is_full() {
            return Ok(());
        }
    }
    edges.note(draft);
    Ok(())
}

fn form(tag: &Tag) -> Result<Form, Fault> {
    let kind = tag.get("type").unwrap_or_default();
    if kind != "UnstructuredGrid" && kind != "PolyData" {
        return Err(Fault::new("VTKFile.type", text::quoted(Some(&kind)).to_string(), "UnstructuredGrid or PolyData"));
    }
    let compressor = tag.get("compressor").unwrap_or_default();
    if !compressor.is_empty() && compressor != "vtkZLibDataCompressor" {
        return Err(Fault::new("VTKFile.compressor", text::quoted(Some(&compressor)).to_string(), "vtkZLibDataCompressor or none"));
    }
    let big_endian = tag.get("byte_order").is_some_and(|o| o == "BigEndian");
    let long_counts = tag.get("header_type").is_some_and(|t| t == "UInt64");
    Ok(Form { big_endian, long_counts, zlib: !compressor.is_empty() })
}

/// The cells of a piece: those of an unstructured grid, or lines and the like one after the other.
fn grid(arrays: &mut BTreeMap<(String, String), Vec<f64>>) -> Grid {
    let mut take = |section: &str, name: &str| arrays.remove(&(section.to_owned(), name.to_owned()));
    let mut grid = Grid {
        points: take("Points", "").unwrap_or_default(),
        connectivity: take("Cells", "connectivity").unwrap_or_default(),
        ends: take("Cells", "offsets").unwrap_or_default(),
        types: take("Cells", "types").unwrap_or_default(),
        point_radius: take("PointData", "radius"),
        cell_radius: take("CellData", "radius"),
    };
    for (section, kind) in [("Verts", 2.0), ("Lines", 4.0), ("Strips", 6.0), ("Polys", 7.0)] {
        let base = grid.connectivity.len() as f64;
        grid.connectivity.extend(take(section, "connectivity").unwrap_or_default());
        grid.ends.extend(take(section, "offsets").unwrap_or_default().iter().map(|end| base + end));
        if section != "Verts" || !grid.ends.is_empty() {
            grid.types.resize(grid.ends.len().max(grid.types.len()), kind);
        }
    }
    grid
}

/// An array while its text is read.
struct Array {
    section: String,
    /// Its name; `radius` for all names of radii, nothing for points.
    key: String,
    place: String,
    kind: String,
    format: String,
    offset: Option<usize>,
    components: String,
    text: String,
}

impl Array {
    fn open(tag: &Tag, section: &str, piece: usize) -> Array {
        let get = |name| tag.get(name).unwrap_or_default().into_owned();
        let name = get("Name");
        let key = match section {
            "Points" => String::new(),
            _ if is_radius(&name) => "radius".to_owned(),
            _ => name.clone(),
        };
        let place = format!("Piece[{piece}].{section}.{}", text::shown(&name));
        let (kind, format, components) = (get("type"), get("format"), get("NumberOfComponents"));
        Array { section: section.to_owned(), key, place, kind, format, offset: get("offset").parse().ok(), components, text: String::new() }
    }

    fn is_wanted(&self) -> bool {
        match self.section.as_str() {
            "" => false,
            "PointData" | "CellData" => self.key == "radius" && ["", "1"].contains(&self.components.as_str()),
            "Points" => true,
            _ => ["connectivity", "offsets", "types"].contains(&self.key.as_str()),
        }
    }

    fn fault(&self, found: impl Into<String>, wanted: &str) -> Fault {
        Fault::new(self.place.clone(), found, wanted)
    }

    fn values(&self, form: Form, appendix: Appendix, left: &mut u64) -> Result<Vec<f64>, Fault> {
        match (self.format.as_str(), appendix) {
            ("ascii" | "", _) => {
                let read = |word: &str| word.parse().map_err(|_| self.fault(text::quoted(Some(word)).to_string(), "a number"));
                self.text.split_whitespace().map(read).collect()
            }
            ("binary", _) => self.decoded(Bytes::Base64(Base64::new(self.text.as_bytes())), form, left),
            ("appended", Appendix::None) => Err(self.fault("no AppendedData", "the appendix that the array is in")),
            ("appended", Appendix::Base64(data) | Appendix::Raw(data)) => {
                let data = self.offset.and_then(|o| data.get(o..)).ok_or_else(|| self.fault("no offset within the appendix", "an offset"))?;
                let is_raw = matches!(appendix, Appendix::Raw(_));
                self.decoded(if is_raw { Bytes::Raw(data) } else { Bytes::Base64(Base64::new(data)) }, form, left)
            }
            (other, _) => Err(self.fault(format!("format {}", text::quoted(Some(other))), "ascii, binary or appended")),
        }
    }

    fn decoded(&self, mut bytes: Bytes, form: Form, left: &mut u64) -> Result<Vec<f64>, Fault> {
        let short = || self.fault("fewer bytes than its header says", "as many as the header says");
        let header = |bytes: &mut Bytes| -> Result<u64, Fault> {
            let count = bytes.take(if form.long_counts { 8 } else { 4 }).ok_or_else(short)?;
            Ok(unsigned(&count, form.big_endian))
        };
        let length = |count: u64| usize::try_from(count).map_err(|_| short());
        if !form.zlib {
            let count = header(&mut bytes)?;
            return self.numbers(&bytes.take(length(count)?).ok_or_else(short)?, form.big_endian);
        }
        let blocks = header(&mut bytes)?;
        header(&mut bytes)?;
        header(&mut bytes)?;
        let mut packed = Vec::new();
        for _ in 0..blocks {
            packed.push(header(&mut bytes)?);
        }
        let mut unpacked = Vec::new();
        for count in packed {
            let block = bytes.take(length(count)?).ok_or_else(short)?;
            let before = unpacked.len() as u64;
            let read = ZlibDecoder::new(&block[..]).take(*left + 1).read_to_end(&mut unpacked);
            read.map_err(|e| self.fault(text::shown(&e.to_string()), "data packed by zlib"))?;
            let grown = unpacked.len() as u64 - before;
            *left = left.checked_sub(grown).ok_or_else(|| self.fault("more data than a file of this size may unpack", "a file that is not a zip bomb"))?;
        }
        self.numbers(&unpacked, form.big_endian)
    }

    fn numbers(&self, bytes: &[u8], big_endian: bool) -> Result<Vec<f64>, Fault> {
        let size = match self.kind.as_str() {
            "Int8" | "UInt8" => 1,
            "Int16" | "UInt16" => 2,
            "Int32" | "UInt32" | "Float32" => 4,
            "Int64" | "UInt64" | "Float64" => 8,
            other => return Err(self.fault(format!("type {}", text::quoted(Some(other))), "Int8 to UInt64, Float32 or Float64")),
        };
        let number = |b: &[u8]| {
            let bits = unsigned(b, big_endian);
            match self.kind.as_bytes()[0] {
                b'F' if size == 4 => f64::from(f32::from_bits(bits as u32)),
                b'F' => f64::from_bits(bits),
                b'I' => ((bits << (64 - 8 * size)) as i64 >> (64 - 8 * size)) as f64,
                _ => bits as f64,
            }
        };
        Ok(bytes.chunks_exact(size).map(number).collect())
    }
}

fn unsigned(bytes: &[u8], big_endian: bool) -> u64 {
    let add = |sum: u64, b: &u8| sum << 8 | u64::from(*b);
    if big_endian { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) }
}

/// Bytes taken one after the other.
enum Bytes<'a> {
    Raw(&'a [u8]),
    Base64(Base64<'a>),
}

impl Bytes<'_> {
    /// So many bytes, or none if there are fewer.
    fn take(&mut self, count: usize) -> Option<Vec<u8>> {
        match self {
            Bytes::Raw(data) => {
                let (taken, rest) = data.split_at_checked(count)?;
                *data = rest;
                Some(taken.to_vec())
            }
            Bytes::Base64(base64) => {
                let mut out = Vec::new();
                while out.len() < count {
                    out.push(base64.next()?);
                }
                Some(out)
            }
        }
    }
}

/// Base64, also of several texts one after the other, each padded: a header, then its data.
struct Base64<'a> {
    text: &'a [u8],
    group: [u8; 3],
    left: usize,
}

impl<'a> Base64<'a> {
    fn new(text: &'a [u8]) -> Self {
        Base64 { text, group: [0; 3], left: 0 }
    }

    fn next(&mut self) -> Option<u8> {
        if self.left == 0 {
            let (mut bits, mut letters, mut digits) = (0u32, 0, 0);
            while letters < 4 {
                let (&c, rest) = self.text.split_first()?;
                self.text = rest;
                let value = match c {
                    b'A'..=b'Z' => c - b'A',
                    b'a'..=b'z' => c - b'a' + 26,
                    b'0'..=b'9' => c - b'0' + 52,
                    b'+' => 62,
                    b'/' => 63,
                    b'=' => 0,
                    c if c.is_ascii_whitespace() => continue,
                    _ => return None,
                };
                digits += usize::from(c != b'=');
                bits = bits << 6 | u32::from(value);
                letters += 1;
            }
            let [_, a, b, c] = bits.to_be_bytes();
            // the last is taken first
            self.group = [c, b, a];
            self.left = 3;
            if digits < 4 {
                let bytes = digits.checked_sub(1).filter(|n| *n > 0)?;
                self.group.rotate_left(3 - bytes);
                self.left = bytes;
            }
        }
        self.left -= 1;
        Some(self.group[self.left])
    }
}
