//! `lattice-brep schema`: prints the JSON Schema of the lattice form, of the report, or of an inspection.

use super::output;
use lattice_brep::error::Error;
use lattice_brep::graph::json;
use lattice_brep::inspect;
use lattice_brep::report;
use std::path::PathBuf;

/// Print the JSON Schema of the lattice graphs that `export` reads, of the report that it writes, or of `inspect --json`
#[derive(Debug, clap::Args)]
pub struct SchemaArgs {
    /// The schema of `export --report` in place of the lattice's
    #[arg(long)]
    report: bool,

    /// The schema of `inspect --json` in place of the lattice's
    #[arg(long, conflicts_with = "report")]
    inspect: bool,

    /// File to write; standard output if absent
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(args: &SchemaArgs) -> Result<(), Error> {
    let schema = match (args.report, args.inspect) {
        (true, _) => report::schema(),
        (_, true) => inspect::schema(),
        _ => json::schema(),
    };
    output::write(args.output.as_deref(), |out| out.write_all(schema.as_bytes()))
}
