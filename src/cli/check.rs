//! `lattice-brep check FILE.step`: what a STEP file holds, as an independent reader sees it.

use super::output;
use lattice_brep::error::{Error, Fault};
use lattice_brep::step::{ReadBackError, compressed, read_back};
use std::fs::File;
use std::path::PathBuf;

/// Read a STEP file back with an independent reader and print what it holds
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// STEP file to read, compressed (.stpZ) or not
    file: PathBuf,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

/// Prints first, then fails if the file holds no sound solid.
pub fn run(args: &CheckArgs) -> Result<(), Error> {
    let file = File::open(&args.file).map_err(Error::io(&args.file))?;
    let fault = |found: String, wanted: &str| Fault::new(args.file.display().to_string(), found, wanted);
    let found = compressed::unpack(file, |text| read_back(text)).map_err(Error::io(&args.file))?.map_err(|error| match error {
        ReadBackError::Io(source) => Error::io(&args.file)(source),
        other => Error::BadInput(vec![fault(other.to_string(), "a STEP file")]),
    })?;
    output::write(None, |out| {
        if args.json {
            serde_json::to_writer_pretty(&mut *out, &found)?;
            writeln!(out)
        } else {
            writeln!(out, "{found}")
        }
    })?;
    Error::unless_empty(found.faults().into_iter().map(|f| fault(f, "closed solids")).collect())
}
