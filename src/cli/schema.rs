//! `lattice-brep schema`: prints the JSON Schema of the lattice form, or of the report.

use super::output;
use lattice_brep::error::Error;
use lattice_brep::graph::json;
use lattice_brep::report;
use std::path::PathBuf;

/// Print the JSON Schema of the lattice graphs that `export` reads, or of the report that it writes
#[derive(Debug, clap::Args)]
pub struct SchemaArgs {
    /// The schema of `export --report` in place of the lattice's
    #[arg(long)]
    report: bool,

    /// File to write; standard output if absent
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(args: &SchemaArgs) -> Result<(), Error> {
    let schema = if args.report { report::schema() } else { json::schema() };
    output::write(args.output.as_deref(), |out| out.write_all(schema.as_bytes()))
}
