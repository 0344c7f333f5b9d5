//! Readers of the formats that lattices come in: `bytes ▶ Input`, faults and notes.
//!
//! In: a `Source` (bytes, and a way to ask for files beside it) and `ImportOptions`. The format is found by content; the suffix
//! decides only where the content does not say. Out: an `Input` in mm, not yet checked by `graph::check`; all faults of form,
//! each with its place in the source; notes of everything that was left out, joined or taken from an option.
//! Nothing here opens a file, and no reader sets memory aside by a number that the file claims: see `limits`.

mod abaqus;
mod csv;
mod draft;
mod gmsh;
mod grid;
mod join;
mod limits;
mod ltcx;
mod mesh;
mod obj;
mod tetgen;
mod text;
mod threemf;
mod vtk;
mod vtu;
mod xml;

pub use limits::{FILE_BYTES, LISTED};

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
    ThreeMf,
    TetGen,
    Gmsh,
    /// Legacy VTK.
    Vtk,
    /// VTK's XML files, also polydata.
    Vtu,
    Ltcx,
    Csv,
    Obj,
    Abaqus,
}

impl Format {
    /// As shown to a person.
    pub fn name(self) -> &'static str {
        match self {
            Format::Json => "JSON",
            Format::ThreeMf => "3MF",
            Format::TetGen => "TetGen",
            Format::Gmsh => "Gmsh",
            Format::Vtk => "VTK",
            Format::Vtu => "VTU",
            Format::Ltcx => "LTCX",
            Format::Csv => "CSV",
            Format::Obj => "OBJ",
            Format::Abaqus => "Abaqus",
        }
    }

    /// The format says in which unit its lengths are.
    fn states_unit(self) -> bool {
        matches!(self, Format::Json | Format::ThreeMf | Format::Ltcx)
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
                Format::ThreeMf => threemf::read(source.bytes, &mut draft),
                Format::TetGen => tetgen::read(source, &mut draft),
                Format::Gmsh => gmsh::read(source.bytes, &mut draft),
                Format::Vtk => vtk::read(source.bytes, &mut draft),
                Format::Vtu => vtu::read(source.bytes, &mut draft),
                Format::Ltcx => ltcx::read(source.bytes, &mut draft),
                Format::Csv => csv::read(source.bytes, &mut draft),
                Format::Obj => obj::read(source.bytes, &mut draft),
                Format::Abaqus => abaqus::read(source.bytes, &mut draft),
            }
            draft.finish(format, options.radius_rule)
        }
    };
    imported.faults.splice(0..0, faults);
    imported
}

/// The format, by content; where that does not say, by the suffix of the path. TetGen's tables of numbers are known by suffix.
pub fn sniff(bytes: &[u8], path: &Path) -> Option<Format> {
    let suffix = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let head = text::head(bytes);
    let start = head.trim_start();
    let by_content = [
        (Format::ThreeMf, bytes.starts_with(b"PK\x03\x04")),
        (Format::Json, start.starts_with('{')),
        (Format::Gmsh, gmsh::is_like(start)),
        (Format::Vtk, start.starts_with(vtk::START)),
        (Format::Vtu, start.starts_with('<') && xml::root(start).is_some_and(|root| root == "VTKFile")),
        (Format::Ltcx, start.starts_with('<') && xml::root(start).is_some_and(|root| ltcx::ROOTS.contains(&root.as_str()))),
        (Format::Abaqus, abaqus::is_like(start)),
        (Format::Obj, obj::is_like(start)),
        (Format::TetGen, tetgen::SUFFIXES.contains(&suffix.as_str())),
        (Format::Csv, csv::is_like(start)),
    ];
    let by_suffix = || {
        Some(match suffix.as_str() {
            "json" => Format::Json,
            "3mf" => Format::ThreeMf,
            "msh" => Format::Gmsh,
            "vtk" => Format::Vtk,
            "vtu" | "vtp" => Format::Vtu,
            "ltcx" => Format::Ltcx,
            "csv" => Format::Csv,
            "obj" => Format::Obj,
            "inp" => Format::Abaqus,
            _ => return None,
        })
    };
    by_content.into_iter().find(|(_, is_it)| *is_it).map(|(format, _)| format).or_else(by_suffix)
}
