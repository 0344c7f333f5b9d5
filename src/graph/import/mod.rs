//! Readers of the formats that lattices come in: `bytes ▶ Input`, faults and notes.
//!
//! In: a `Source` (bytes, and a way to ask for files beside it) and `ImportOptions`. The format is found by content; the suffix
//! decides only where the content does not say. Out: an `Input` in mm, not yet checked by `graph::check`; all faults of form,
//! each with its place in the source; notes of everything that was left out, joined or taken from an option.
//! Nothing here opens a file, and no reader sets memory aside by a number that the file claims: see `limits`.

mod csv;
mod draft;
mod join;
mod limits;
mod obj;
mod text;

pub use limits::FILE_BYTES;

use super::check::{self, Overlaps};
use super::json;
use super::{Input, Lattice};
use crate::error::{Error, Fault, Note};
use draft::{Draft, Places};
use std::path::Path;
use std::str::FromStr;

pub use super::json::Units;

/// What is read: a file's name (only its suffix is looked at), its bytes, and the files beside it.
pub struct Source<'a> {
    pub name: &'a str,
    pub bytes: &'a [u8],
    /// The bytes of the file that differs from this one by its extension alone (`node`, `edge`, `ele`), if there is one.
    pub sibling: &'a dyn Fn(&str) -> Option<Vec<u8>>,
}

/// What a person says where the file does not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// The radius of struts to which the file gives none.
    pub radius_rule: Option<RadiusRule>,
    /// The unit of formats that state none; mm unless given.
    pub unit: Option<Units>,
}

/// How struts without a radius get one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RadiusRule {
    /// The length of the shortest strut of the file, divided by this.
    Shortest(f64),
    /// This radius (mm).
    Length(f64),
}

impl FromStr for RadiusRule {
    type Err = String;

    fn from_str(rule: &str) -> Result<Self, String> {
        let positive = |number: &str| number.trim().parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
        let read = match rule.strip_prefix("shortest/") {
            Some(parts) => positive(parts).map(RadiusRule::Shortest),
            None => positive(rule).map(RadiusRule::Length),
        };
        read.ok_or_else(|| format!("found `{}`, wanted `shortest/N` or a radius in mm, such as shortest/8 or 0.5", text::shown(rule)))
    }
}

/// The formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Json,
    Csv,
    Obj,
}

impl Format {
    /// As shown to a person.
    pub fn name(self) -> &'static str {
        match self {
            Format::Json => "JSON",
            Format::Csv => "CSV",
            Format::Obj => "OBJ",
        }
    }

    /// The format says in which unit its lengths are.
    fn states_unit(self) -> bool {
        matches!(self, Format::Json)
    }
}

/// What was found in a source.
#[derive(Clone, Debug, Default)]
pub struct Imported {
    /// `None` where no reader knows the content: then there is a fault too.
    pub format: Option<Format>,
    pub input: Input,
    pub faults: Vec<Fault>,
    pub notes: Vec<Note>,
    places: Places,
}

impl Imported {
    /// The checked lattice, or all faults: those of form and those of content, each with its place in the source.
    pub fn admit(self, overlaps: Overlaps) -> Result<Lattice, Error> {
        let Imported { input, faults, mut notes, places, .. } = self;
        let mut lattice = check::admit(input, faults, overlaps).map_err(|error| match error {
            Error::BadInput(faults) => Error::BadInput(faults.into_iter().map(|f| places.named(f)).collect()),
            other => other,
        })?;
        notes.append(&mut lattice.notes);
        Ok(Lattice { notes, ..lattice })
    }
}

/// Find the format and read.
pub fn read(source: &Source, options: &ImportOptions) -> Imported {
    let Some(format) = sniff(source.bytes, Path::new(source.name)) else {
        let wanted = "a lattice in one of the formats of docs/formats.md (JSON, 3MF, TetGen, Gmsh, VTK, LTCX, CSV, OBJ, Abaqus)";
        let faults = vec![Fault::new("document", text::looks_like(source.bytes), wanted)];
        return Imported { faults, ..Imported::default() };
    };
    let mut faults = Vec::new();
    if let (true, Some(_)) = (format.states_unit(), options.unit) {
        faults.push(Fault::new("--units", "a unit", format!("none: a {} file states its own", format.name())));
    }
    let mut imported = match format {
        Format::Json => {
            let (input, faults) = json::read(source.bytes);
            Imported { format: Some(format), input, faults, ..Imported::default() }
        }
        _ => {
            let mut draft = Draft::new(options.unit.unwrap_or_default());
            match format {
                Format::Json => unreachable!("read above"),
                Format::Csv => csv::read(source.bytes, &mut draft),
                Format::Obj => obj::read(source.bytes, &mut draft),
            }
            draft.finish(format, options.radius_rule)
        }
    };
    imported.faults.splice(0..0, faults);
    imported
}

/// The format, by content; where that does not say, by the suffix of the path.
pub fn sniff(bytes: &[u8], path: &Path) -> Option<Format> {
    by_content(bytes).or_else(|| by_suffix(path))
}

fn by_suffix(path: &Path) -> Option<Format> {
    Some(match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "json" => Format::Json,
        "csv" | "txt" => Format::Csv,
        "obj" => Format::Obj,
        _ => return None,
    })
}

fn by_content(bytes: &[u8]) -> Option<Format> {
    let head = text::head(bytes);
    let start = head.trim_start();
    if start.starts_with('{') {
        return Some(Format::Json);
    }
    if obj::is_like(&head) {
        return Some(Format::Obj);
    }
    csv::is_like(&head).then_some(Format::Csv)
}
