//! `lattice-brep schema`: prints the JSON Schema of the lattice form.

use super::output;
use lattice_brep::error::Error;
use lattice_brep::graph::json;
use std::path::PathBuf;

/// Print the JSON Schema of the lattice graphs that `export` reads
#[derive(Debug, clap::Args)]
pub struct SchemaArgs {
    /// File to write; standard output if absent
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(args: &SchemaArgs) -> Result<(), Error> {
    output::write(args.output.as_deref(), |out| out.write_all(json::schema().as_bytes()))
}
