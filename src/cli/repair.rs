//! The repair flags, for every command that reads a lattice; `lattice-brep repair`: a lattice in, the repaired lattice out.

use super::input::ImportFlags;
use super::output;
use lattice_brep::error::{Error, Fault};
use lattice_brep::graph::import::Imported;
use lattice_brep::graph::repair::{self, Merged, Repair, Repaired, Wanted, chains, loose::LOOSE, merge};
use lattice_brep::graph::{Input, json};
use lattice_brep::inspect;
use lattice_brep::options::Options;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Repairs of the input that are made when asked for.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Repairs, made before the checks and listed in the report")]
pub struct RepairFlags {
    /// Nodes at most this far apart (mm) become one; struts that become loops or twins of others are dropped
    #[arg(long, value_name = "MM", value_parser = above_zero)]
    weld: Option<f64>,
    /// Connected parts of less volume than this share of the largest part's are dropped, and nodes without struts
    /// [0.01 if no share is given; 1 keeps just the largest]
    #[arg(long, value_name = "SHARE", num_args = 0..=1, require_equals = true, default_missing_value = text(LOOSE), value_parser = share)]
    drop_loose: Option<f64>,
    /// Straight chains of struts through nodes of degree 2 become one strut where that moves nothing by more than this, in strut
    /// radii [0.01 if none is given]
    #[arg(long, value_name = "RADII", num_args = 0..=1, require_equals = true, default_missing_value = text(chains::STRAIGHT), value_parser = above_zero)]
    collapse_chains: Option<f64>,
}

impl RepairFlags {
    /// Make the repairs; with faults of form none of them, so that paths mean what they say in the file.
    pub fn apply(&self, input: Input, faults: &[Fault], quiet: bool) -> Repaired {
        if !faults.is_empty() {
            return Repaired { input, repairs: Vec::new() };
        }
        let wanted = Wanted { weld: self.weld, drop_loose: self.drop_loose, collapse_chains: self.collapse_chains };
        let repaired = repair::repair(input, &wanted);
        if !quiet {
            print_repairs(&repaired.repairs);
        }
        repaired
    }
}

/// Merge what cuts do not fit (degrees, λ of the cuts). Where that would join nodes too far apart it is refused, or left to be shrunk.
/// First chains that export makes one strut become so: pieces of them that are too short are no reason to merge.
pub fn merged(repaired: &mut Repaired, angle: f64, lambda: f64, leave: bool, quiet: bool) -> Result<(), Error> {
    let before = repaired.repairs.len();
    if let Some(straight) = chains::straight(&repaired.input) {
        repaired.then(|_| straight);
    }
    let Merged { input, repair, stuck } = repair::merge(&repaired.input, angle, &inspect::fit(lambda));
    if !(stuck.is_empty() || leave) {
        return Err(Error::CannotBuild { reasons: stuck.iter().map(|s| s.fault().to_string()).collect() });
    }
    repaired.then(|_| (input, repair));
    if !quiet {
        print_repairs(&repaired.repairs[before..]);
    }
    Ok(())
}

pub fn print_repairs(repairs: &[Repair]) {
    for repair in repairs {
        eprintln!("repaired: {}", repair.note().what);
    }
    print_numbering(repairs);
}

/// Which lattice's numbers errors and notes have.
pub fn print_numbering(repairs: &[Repair]) {
    if repairs.iter().any(|r| r.before != r.after) {
        let asked = if repairs.iter().any(|r| r.limit == chains::EXACT) { " --collapse-chains=1e-9" } else { "" };
        eprintln!("node and strut numbers from here on are those of the repaired lattice (`lattice-brep repair{asked}` writes it)");
    }
}

/// Write a lattice graph with repairs made to it, or take repairs back
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lattice-brep repair part.json --weld 0.001 --collapse-chains -o fixed.json --report fixed.report.json
  lattice-brep repair part.json --merge -o fixed.json
  lattice-brep repair fixed.json --undo fixed.report.json -o part.json    the old lattice, bit for bit

The lattice may be of any format that export reads. Order: weld, drop-loose, collapse-chains, merge. The graph is not checked: see `lattice-brep inspect`.")]
pub struct RepairArgs {
    /// Lattice: JSON (see `lattice-brep schema`), 3MF, TetGen, Gmsh, VTK, LTCX, CSV, OBJ or Abaqus
    input: PathBuf,
    /// File to write (JSON, lengths in mm); standard output if absent
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the record of the repairs (JSON): what went into what, with old numbers, places and radii
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Take back the repairs in this record, of `repair --report` or `export --report`
    #[arg(long, value_name = "REPORT", conflicts_with_all = ["weld", "drop_loose", "collapse_chains", "merge"])]
    undo: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    import: ImportFlags,
    #[command(flatten)]
    repair: RepairFlags,
    /// Nodes whose cuts do not fit on the strut between them become one, as do struts at a node closer than --merge-angle;
    /// refused where that would join nodes further apart than their cuts reach
    #[arg(long)]
    merge: bool,
    /// Angle for --merge, degrees: 0 to below 60
    #[arg(long, value_name = "DEGREES", default_value_t = merge::MERGE_ANGLE, requires = "merge", value_parser = angle)]
    merge_angle: f64,
}

/// The part of a report that `--undo` reads.
#[derive(Serialize, Deserialize)]
struct Record {
    repairs: Vec<Repair>,
}

pub fn run(args: &RepairArgs) -> Result<(), Error> {
    let Imported { input, faults, .. } = args.import.read(&args.input)?;
    let mut repaired = args.repair.apply(input, &faults, args.quiet);
    Error::unless_empty(faults)?;
    if args.merge {
        merged(&mut repaired, args.merge_angle, Options::default().lambda, false, args.quiet)?;
    }
    if let Some(path) = &args.undo {
        repaired.input = undone(&repaired.input, path)?;
    }
    output::write(args.output.as_deref(), |out| json::write_input(&repaired.input, out))?;
    let Some(path) = &args.report else { return Ok(()) };
    output::write(Some(path), |out| {
        serde_json::to_writer_pretty(&mut *out, &Record { repairs: repaired.repairs })?;
        writeln!(out)
    })
}

fn undone(input: &Input, path: &Path) -> Result<Input, Error> {
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    let fault = |found: String, wanted: &str| Error::BadInput(vec![Fault::new(path.display().to_string(), found, wanted)]);
    let record: Record = serde_json::from_slice(&bytes).map_err(|e| fault(e.to_string(), "a report with the repairs that were made"))?;
    let Some(last) = record.repairs.last() else { return Ok(input.clone()) };
    let (nodes, struts) = (input.nodes.len(), input.struts.len());
    if (nodes, struts) != (last.after.nodes, last.after.struts) {
        let found = format!("a record that ends with {} nodes and {} struts", last.after.nodes, last.after.struts);
        return Err(fault(found, &format!("the record of this lattice, which has {nodes} nodes and {struts} struts")));
    }
    repair::undo(input, &record.repairs).map_err(|e| fault(e, "the record as it was written"))
}

/// A default for clap, from the one place where it is said.
fn text(x: f64) -> &'static str {
    Box::leak(x.to_string().into_boxed_str())
}

fn above_zero(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "a number above 0")
}

fn share(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x <= 1.0, "a number above 0 and at most 1")
}

pub fn angle(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..merge::LARGEST_ANGLE).contains(&x), "a number from 0 to below 60, in degrees")
}

fn number(text: &str, holds: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    text.parse().ok().filter(|&x: &f64| x.is_finite() && holds(x)).ok_or_else(|| format!("found `{text}`, wanted {wanted}"))
}
