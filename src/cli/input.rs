//! Opens lattice files: the bytes of a file, and of those that differ from it by their extension alone.

use clap::ValueEnum;
use lattice_brep::error::{Error, Fault};
use lattice_brep::graph::import::{self, FILE_BYTES, ImportOptions, Imported, RadiusRule, Source, Units};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// What a file does not say of itself.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "What the file does not say")]
pub struct ImportFlags {
    /// Unit of the file's lengths, for formats that state none [default: mm]
    #[arg(long, value_enum)]
    units: Option<UnitsArg>,
    /// Radius of struts to which the file gives none: `shortest/N`, the shortest strut's length divided by N, or a radius in mm
    #[arg(long, value_name = "RULE")]
    radius_rule: Option<RadiusRule>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum UnitsArg {
    Um,
    Mm,
    Cm,
    M,
    In,
    Ft,
}

impl ImportFlags {
    /// Read a lattice file.
    pub fn read(&self, path: &Path) -> Result<Imported, Error> {
        let unit = self.units.map(|unit| match unit {
            UnitsArg::Um => Units::Um,
            UnitsArg::Mm => Units::Mm,
            UnitsArg::Cm => Units::Cm,
            UnitsArg::M => Units::M,
            UnitsArg::In => Units::In,
            UnitsArg::Ft => Units::Ft,
        });
        read(path, &ImportOptions { radius_rule: self.radius_rule, unit })
    }
}

/// Read a lattice in any format that `graph::import` knows.
fn read(path: &Path, options: &ImportOptions) -> Result<Imported, Error> {
    let too_large = || Error::BadInput(vec![Fault::new("document", format!("more than {FILE_BYTES} bytes"), "a smaller file")]);
    let bytes = bytes(path).map_err(Error::io(path))?.ok_or_else(too_large)?;
    let sibling = |extension: &str| bytes_beside(path, extension);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(import::read(&Source { name: &name, bytes: &bytes, sibling: &sibling }, options))
}

fn bytes_beside(path: &Path, extension: &str) -> Option<Vec<u8>> {
    bytes(&path.with_extension(extension)).ok().flatten()
}

/// The whole file; `None` if it is larger than any reader takes.
fn bytes(path: &Path) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(FILE_BYTES + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= FILE_BYTES).then_some(bytes))
}
