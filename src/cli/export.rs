//! `lattice-brep export`: arguments ▶ options ▶ pipeline ▶ file.

use crate::cli::input::ImportFlags;
use crate::cli::output;
use crate::cli::repair::{self, RepairFlags};
use clap::{Args, ValueEnum};
use glam::DVec3;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lattice_brep::brep::Caps;
use lattice_brep::error::{Error, Fault, Note};
use lattice_brep::graph::Lattice;
use lattice_brep::graph::check::{self, Overlaps};
use lattice_brep::graph::import::Imported;
use lattice_brep::graph::repair::merge::MERGE_ANGLE;
use lattice_brep::graph::repair::{Repair, Repaired};
use lattice_brep::inspect;
use lattice_brep::node::Fairing;
use lattice_brep::options::{Divide, OnConflict, Options};
use lattice_brep::pipeline::{self, Progress, Solved};
use lattice_brep::report::Report;
use lattice_brep::step::{Digits, Schema, StepOptions, TimeStamp, compressed};
use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Build the solid of a lattice graph and write it as STEP
#[derive(Args)]
#[command(after_help = "Examples:
  lattice-brep cell bcc --size 10 --repeat 2x2x2 --radius 0.5 -o bcc.json
  lattice-brep export bcc.json                       writes bcc.step
  lattice-brep export part.json -o part.step --report part.report.json
  lattice-brep export printed.3mf --crop 0,0,0:30,30,30
  lattice-brep export mesh.ele --radius-rule shortest/8 --units in
  lattice-brep export lines.csv --radius-rule 0.5
  lattice-brep export part.json --crop 0,0,0:20,20,20 -o block.step
  lattice-brep export part.json --blend 0.2 --report part.report.json
  lattice-brep export large.json --max-memory 500
  lattice-brep export mesh.json --weld 0.001 --collapse-chains --report mesh.report.json

Exit codes: 0 written, 1 our own failure, 2 bad input, 3 cannot be built.")]
pub struct ExportArgs {
    /// Lattice: JSON (see `lattice-brep schema`), 3MF, TetGen, Gmsh, VTK, VTU, LTCX, CSV pairs, OBJ lines or Abaqus beams, found by content
    input: PathBuf,
    /// STEP file to write, compressed if its name ends with .stpZ [default: the input's name with .step]
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Write a report (JSON): counts, volume, continuity, how each node was built, times
    #[arg(long)]
    report: Option<PathBuf>,
    /// How far cuts reach beyond the least cut, as a part of it: between 0 and 0.5 [default: 0.3, or more if --blend needs it]
    #[arg(long)]
    lambda: Option<f64>,
    /// Refinement levels of each node's film: 0 to 5
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=5))]
    levels: u32,
    /// Distance wanted between patches and film, in strut radii; nodes that miss it get more control points
    #[arg(long, default_value_t = 0.05)]
    tolerance: f64,
    /// How films are faired: `ray` fills valleys by a small ball and keeps vertices on their rays; `paper` is the paper's own, which folds more often
    #[arg(long, value_enum, default_value_t = FairingArg::Ray)]
    fairing: FairingArg,
    /// Radius of the ball that rolls along the valleys between struts and fills them, in strut radii: 0 to 0.36. 0 stays as near to the struts'
    /// union as the mesh allows, more is rounder. Takes the place of --fairing; the report then lists the tightest valley of each node
    #[arg(long, value_name = "RADII", conflicts_with = "fairing")]
    blend: Option<f64>,
    /// How struts end at nodes of degree 1: a disc, or half a ball (which meets a tapered strut in an edge)
    #[arg(long, value_enum, default_value_t = CapsArg::Flat)]
    caps: CapsArg,
    /// Write an assembly: each different node with its half struts once, placed wherever it stands. A small file of many solids that
    /// touch in the middle of the struts, not one solid
    #[arg(long)]
    assembly: bool,
    /// Write so many blocks of neighbouring nodes as files of their own (out.block-1.step, ...), each strut between two of them halved by a disc; FILE
    /// becomes an assembly that refers to them, and out.blocks.json lists them with their SHA-256
    #[arg(long, value_name = "N", conflicts_with = "assembly")]
    blocks: Option<usize>,
    /// STEP schema
    #[arg(long, value_enum, default_value_t = SchemaArg::Ap242)]
    schema: SchemaArg,
    /// Decimals (of a mm) of points, 6 to 15, and as fine ones of weights; `auto`: a ten-billionth of the thinnest radius, which keeps gaps and angles
    /// far below what the file states
    #[arg(long, value_name = "auto|N", default_value = "auto")]
    digits: Digits,
    /// Build just the part inside a box (mm): xmin,ymin,zmin:xmax,ymax,zmax. Struts cut by it become free ends
    #[arg(long, value_parser = parse_box, allow_hyphen_values = true)]
    crop: Option<[DVec3; 2]>,
    /// Struts that share no node and are nearer than their radii, and nodes whose skin meets a strut or skin of others: refuse
    /// them, or keep them (the solid then crosses itself there, and the report says where)
    #[arg(long, value_enum, default_value_t = OverlapsArg::Refuse)]
    overlaps: OverlapsArg,
    /// Struts too short for their cuts, after all that smaller and unequal cuts can do: refuse them with the numbers, shrink
    /// radii near the conflict until cuts fit, merge nodes and struts that are too near, or merge first and shrink what that
    /// leaves, as foams with very short struts need (the report says which)
    #[arg(long, value_enum, default_value_t = OnConflictArg::Refuse)]
    pub on_conflict: OnConflictArg,
    /// Angle for --on-conflict merge, degrees: 0 to below 60
    #[arg(long, value_name = "DEGREES", default_value_t = MERGE_ANGLE, value_parser = repair::angle)]
    merge_angle: f64,
    #[command(flatten)]
    import: ImportFlags,
    /// Time stamp in the file's header, YYYY-MM-DDThh:mm:ss [default: a fixed one, so that files compare equal]
    #[arg(long)]
    time_stamp: Option<TimeStamp>,
    /// Build nodes of equal stars each for itself: the same file, later. To measure what building them once gains
    #[arg(long, conflicts_with = "assembly")]
    no_cache: bool,
    /// Memory that the run should keep to, MB: what is built waits in a temporary file beside the output as far as it does not fit. The least that
    /// is needed grows with the lattice; where it is more than this, a note says so [default: 256 MB of what is built stay in memory]
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u32).range(1..))]
    max_memory: Option<u32>,
    /// Threads [default: all cores]; the file does not depend on it
    #[arg(long)]
    threads: Option<usize>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    repair: RepairFlags,
}

/// With this ball lambda is 0.48: cuts of 1.5 times the least would meet in the middle of the shortest struts that the paper allows.
const MOST_BLEND: f64 = 0.36;

#[derive(Clone, Copy, ValueEnum)]
enum CapsArg {
    Flat,
    Sphere,
}

#[derive(Clone, Copy, ValueEnum)]
enum FairingArg {
    Ray,
    Paper,
}

#[derive(Clone, Copy, ValueEnum)]
enum SchemaArg {
    Ap242,
    Ap214,
    Ap203,
}

#[derive(Clone, Copy, ValueEnum)]
enum OverlapsArg {
    Refuse,
    Keep,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum OnConflictArg {
    Refuse,
    Shrink,
    Merge,
    #[value(name = "merge,shrink")]
    MergeShrink,
}

impl OnConflictArg {
    fn merges(self) -> bool {
        matches!(self, OnConflictArg::Merge | OnConflictArg::MergeShrink)
    }

    fn shrinks(self) -> bool {
        matches!(self, OnConflictArg::Shrink | OnConflictArg::MergeShrink)
    }

    /// Which other policy may serve where this one was refused so.
    pub fn advice(self, error: &Error) -> Option<&'static str> {
        const MERGE_SHRINK: &str = "`--on-conflict merge,shrink` joins nodes that are too near before it makes radii smaller";
        const SHRINK: &str = "`--on-conflict shrink` makes radii smaller where nothing fits; `merge,shrink` joins nodes that are too near first";
        let of_policy = match error {
            Error::CannotBuild { .. } => true,
            Error::BadInput(faults) => faults.iter().all(|fault| fault.is_overlap),
            Error::Io { .. } | Error::Internal(_) => false,
        };
        match self {
            _ if !of_policy => None,
            OnConflictArg::Refuse => Some(SHRINK),
            OnConflictArg::Shrink | OnConflictArg::Merge => Some(MERGE_SHRINK),
            OnConflictArg::MergeShrink => Some("`--on-conflict shrink` alone keeps all nodes where they are: merging can bring struts nearer to others"),
        }
    }
}

fn parse_box(text: &str) -> Result<[DVec3; 2], String> {
    let wanted = || format!("found `{text}`, wanted xmin,ymin,zmin:xmax,ymax,zmax in mm, each min below its max");
    let point = |part: &str| -> Option<DVec3> {
        let numbers: Vec<f64> = part.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect::<Option<_>>()?;
        <[f64; 3]>::try_from(numbers).ok().map(DVec3::from)
    };
    let (min, max) = text.split_once(':').ok_or_else(wanted)?;
    match (point(min), point(max)) {
        (Some(min), Some(max)) if min.cmplt(max).all() => Ok([min, max]),
        _ => Err(wanted()),
    }
}

pub fn run(args: &ExportArgs) -> Result<(), Error> {
    let mut options = options(args)?;
    if let Some(threads) = args.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|e| Error::Internal(e.to_string()))?;
    }
    let output = args.output.clone().unwrap_or_else(|| args.input.with_extension("step"));
    let overlaps = match args.overlaps {
        OverlapsArg::Refuse if args.on_conflict.shrinks() => Overlaps::Leave,
        OverlapsArg::Refuse => Overlaps::Refuse,
        OverlapsArg::Keep => Overlaps::Keep,
    };
    let imported = args.import.read(&args.input)?;
    // overlaps outside the box do not matter: they are judged after the crop
    let in_file = if args.crop.is_some() { Overlaps::Leave } else { overlaps };
    let (mut lattice, mut repairs) = admit(args, imported, &options, in_file)?;
    if let Some(bounds) = args.crop {
        lattice = pipeline::crop(&lattice, bounds, overlaps)?;
    }
    let (mut lattice, straight) = pipeline::straighten(lattice);
    if !args.quiet {
        repair::print_repairs(straight.as_slice());
    }
    repairs.extend(straight);
    let is_shown = |c: char| !c.is_control() && !c.is_whitespace();
    if let Some(name) = lattice.name.as_ref().filter(|name| name.chars().any(is_shown)) {
        options.step.product = name.clone();
    }
    if let Some(mb) = args.max_memory {
        options.skins_in_memory = inspect::room_for_skins(&lattice.graph, f64::from(mb) * 1e6).unwrap_or_else(|least| {
            lattice.notes.push(Note::new("--max-memory", format!("{mb} MB: this lattice may take {:.0} MB, with all that is built in a file", least / 1e6)));
            0
        });
    }
    let progress = Bar::new(args.quiet);
    options.scratch = Some(output::folder(&output));
    let told_once = |_: &Error| {
        if args.quiet {
            repair::print_numbering(&repairs)
        }
    };
    let mut solved = pipeline::solve(&lattice, &options, &progress).inspect_err(told_once)?;
    solved.report.repairs = repairs;
    let mut manifest = None;
    if args.blocks.is_some() {
        manifest = Some(write_blocks(&mut solved, &output, &options, &progress)?);
    } else {
        let mut write = |out: &mut (dyn Write + Send)| pipeline::write(&mut solved, &options, out, &progress);
        output::write(Some(&output), |out| if compressed::is_named(&output) { compressed::pack(&options.step.file_name, out, write) } else { write(out) })?;
    }
    progress.finish();
    if let Some(path) = &args.report {
        output::write(Some(path), |out| {
            serde_json::to_writer_pretty(&mut *out, &solved.report)?;
            writeln!(out)
        })?;
    }
    if !args.quiet {
        eprint!("{}", summary(&solved.report, &output));
        if let Some(path) = manifest {
            eprintln!("{} blocks, each a file of its own: listed in {}", solved.blocks.len(), path.display());
        }
    }
    Ok(())
}

/// The name of a file of blocks, beside the master's: `out.block-1.step`, `out.blocks.json`.
fn beside_master(master: &Path, middle: &str, ending: Option<&OsStr>) -> PathBuf {
    let mut name = master.file_stem().unwrap_or_default().to_owned();
    name.push(middle);
    if let Some(ending) = ending {
        name.push(".");
        name.push(ending);
    }
    master.with_file_name(name)
}

fn manifest_path(master: &Path) -> PathBuf {
    beside_master(master, ".blocks", Some("json".as_ref()))
}

/// All blocks, the master and the manifest, or none of them. The manifest's path.
fn write_blocks(solved: &mut Solved, output: &Path, options: &Options, progress: &Bar) -> Result<PathBuf, Error> {
    let mut files = output::Together::default();
    let count = solved.blocks.len();
    progress.stage("writing", count as u64, "blocks");
    let list = manifest_path(output);
    let paths: Vec<PathBuf> = (1..=count).map(|k| beside_master(output, &format!(".block-{k}"), output.extension())).collect();
    paths.iter().chain([&list]).map(PathBuf::as_path).chain([output]).try_for_each(output::must_be_file)?;
    let mut blocks = vec![];
    for (k, path) in paths.iter().enumerate() {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        blocks.push(files.write(path, |out| pipeline::write_block(solved, k, &name, options, out))?);
        progress.advance(1);
    }
    let mut last = output::Together::default();
    let manifest = last.write(output, |out| pipeline::write_master(solved, blocks, options, out))?;
    files.write(&list, |out| {
        serde_json::to_writer_pretty(&mut *out, &manifest)?;
        writeln!(out)
    })?;
    files.and(last).finish()?;
    Ok(list)
}

/// The repairs that are asked for, then the checks. Faults are told in the file's own places unless a repair has renumbered them.
fn admit(args: &ExportArgs, mut imported: Imported, options: &Options, overlaps: Overlaps) -> Result<(Lattice, Vec<Repair>), Error> {
    let input = std::mem::take(&mut imported.input);
    let mut repaired = args.repair.apply(input, &imported.faults, args.quiet);
    if args.on_conflict.merges() && imported.faults.is_empty() {
        repair::merged(&mut repaired, args.merge_angle, options.lambda, args.on_conflict.shrinks(), args.quiet)?;
    }
    let Repaired { input, repairs } = repaired;
    if repairs.is_empty() {
        imported.input = input;
        return Ok((imported.admit(overlaps)?, repairs));
    }
    let mut lattice = check::admit(input, imported.faults, overlaps)?;
    lattice.notes.splice(0..0, imported.notes.into_iter().chain(repairs.iter().map(Repair::note)));
    Ok((lattice, repairs))
}

fn options(args: &ExportArgs) -> Result<Options, Error> {
    let mut faults = Vec::new();
    // fillings end before three quarters of the room that lambda leaves (`rolling::most`)
    let for_blend = args.blend.unwrap_or(0.0) / 0.75;
    let lambda = args.lambda.unwrap_or(f64::max(Options::default().lambda, for_blend));
    if args.blend.is_some_and(|b| !(0.0..=MOST_BLEND).contains(&b)) {
        faults.push(Fault::new("--blend", args.blend.unwrap_or_default().to_string(), format!("a number from 0 to {MOST_BLEND}, in strut radii")));
    } else if !(lambda > 0.0 && lambda < 0.5) {
        faults.push(Fault::new("--lambda", lambda.to_string(), "a number between 0 and 0.5, both excluded"));
    } else if lambda < for_blend {
        faults.push(Fault::new("--lambda", lambda.to_string(), format!("at least {for_blend:.4}, the room that --blend needs")));
    }
    if !(args.tolerance > 0.0) {
        faults.push(Fault::new("--tolerance", args.tolerance.to_string(), "a number above 0, in strut radii"));
    }
    if args.assembly && matches!(args.schema, SchemaArg::Ap203) {
        faults.push(Fault::new("--assembly", "--schema ap203", "ap242 or ap214: in ap203 each part would need its own approvals"));
    }
    if args.blocks == Some(0) {
        faults.push(Fault::new("--blocks", "0", "at least 1"));
    }
    if args.blocks.is_some() {
        if matches!(args.schema, SchemaArg::Ap203) {
            faults.push(Fault::new("--blocks", "--schema ap203", "ap242 or ap214: in ap203 each part would need its own approvals"));
        }
        if args.output.as_ref().is_some_and(|p| compressed::is_named(p)) {
            faults.push(Fault::new("--blocks", "-o with .stpZ", "a name with another ending: readers do not look into archives for what a file refers to"));
        }
        let output = args.output.clone().unwrap_or_else(|| args.input.with_extension("step"));
        if args.report.as_ref().is_some_and(|report| *report == manifest_path(&output)) {
            faults.push(Fault::new("--report", "the name of the list of blocks", "another name"));
        }
    }
    if args.threads == Some(0) {
        faults.push(Fault::new("--threads", "0", "at least 1"));
    }
    Error::unless_empty(faults)?;
    let name = args.input.file_stem().map_or("lattice".into(), |s| s.to_string_lossy().into_owned());
    // in an archive: the file that is in it
    let file = args.output.as_ref().map(|p| if compressed::is_named(p) { p.with_extension("stp") } else { p.clone() });
    let file = file.as_ref().and_then(|p| p.file_name()).map_or(format!("{name}.step"), |s| s.to_string_lossy().into_owned());
    Ok(Options {
        lambda,
        on_conflict: match args.on_conflict {
            policy if policy.shrinks() => OnConflict::Shrink { part: matches!(args.overlaps, OverlapsArg::Refuse) },
            _ => OnConflict::Refuse, // after `merge` what it leaves
        },
        overlaps: match args.overlaps {
            OverlapsArg::Refuse => Overlaps::Refuse,
            OverlapsArg::Keep => Overlaps::Keep,
        },
        levels: args.levels,
        fairing: match (args.blend, args.fairing) {
            (Some(ball), _) => Fairing::Ball(ball),
            (None, FairingArg::Ray) => Fairing::Filled,
            (None, FairingArg::Paper) => Fairing::Paper,
        },
        tolerance: args.tolerance,
        caps: match args.caps {
            CapsArg::Flat => Caps::Flat,
            CapsArg::Sphere => Caps::Sphere,
        },
        step: StepOptions {
            schema: match args.schema {
                SchemaArg::Ap242 => Schema::Ap242,
                SchemaArg::Ap214 => Schema::Ap214,
                SchemaArg::Ap203 => Schema::Ap203,
            },
            time_stamp: args.time_stamp.unwrap_or_default(),
            product: if name.is_empty() { "lattice".into() } else { name },
            file_name: file,
            digits: args.digits,
            ..StepOptions::default()
        },
        divide: match args.blocks {
            Some(count) => Divide::Blocks(count),
            None if args.assembly => Divide::Nodes,
            None => Divide::Not,
        },
        cache: !args.no_cache,
        ..Options::default()
    })
}

/// What a person wants to know at the end.
fn summary(report: &Report, path: &std::path::Path) -> String {
    let (c, q, r) = (&report.counts, &report.quality, &report.rungs);
    let mut text = format!(
        "{}: {} solid{}, {} struts, {} nodes, {} faces ({} cylinders, {}{} patches, {} caps), {:.1} MB\n",
        path.display(),
        c.components,
        if c.components == 1 { "" } else { "s" },
        c.struts,
        c.nodes,
        c.faces,
        c.cylinders,
        if c.cones > 0 { format!("{} cones, ", c.cones) } else { String::new() },
        c.patches,
        c.caps,
        report.bytes as f64 / 1e6
    );
    text += &format!("volume {:.6} mm³, area {:.6} mm²\n", report.volume_mm3, report.area_mm2);
    text += &format!(
        "largest normal jump {:.1e}° inside nodes, {:.1e}° at rims; largest gap {:.1e} mm; patches within {:.3} radii of their films ({})\n",
        q.inner_jump_deg.value, q.rim_jump_deg.value, q.gap_mm.value, q.deviation_radii.value, q.deviation_radii.place
    );
    for (list, what) in [
        (&r.no_ball, "without a ball in the valleys"),
        (&r.level_set, "from the level-set film"),
        (&r.more_control, "from the level-set film with more control points"),
        (&r.sharp, "SHARP inside (tangent to their struts only)"),
    ] {
        if !list.is_empty() {
            let some: Vec<String> = list.iter().take(8).map(|l| l.node.0.to_string()).collect();
            text += &format!("{} nodes built {what}: {}{}\n", list.len(), some.join(", "), if list.len() > 8 { ", ..." } else { "" });
        }
    }
    let cuts = &report.cuts;
    if !cuts.changed.is_empty() {
        text += &format!(
            "{} struts without their preferred cuts: {} with a smaller lambda, {} with unequal cuts, {} with unequally shared length\n",
            cuts.changed.len(),
            cuts.smaller_lambda,
            cuts.unequal_cuts,
            cuts.unequal_sharing
        );
    }
    if !cuts.shrunk.is_empty() {
        let factors = || cuts.shrunk.iter().flat_map(|s| [0, 1].map(|end| s.after_mm[end] / s.before_mm[end])).filter(|&f| f < 1.0);
        text += &format!(
            "{} struts SHRUNK at {} ends, to {:.3} of their radius at the least, by {:.6} mm³ in all (see --report)\n",
            cuts.shrunk.len(),
            factors().count(),
            factors().fold(1.0, f64::min),
            cuts.shrunk_volume_mm3
        );
    }
    for note in report.changes.iter().take(10) {
        text += &format!("note: {note}\n");
    }
    if report.changes.len() > 10 {
        text += &format!("... and {} more notes (see --report)\n", report.changes.len() - 10);
    }
    text
}

/// A progress bar on a terminal, nothing on a pipe.
struct Bar {
    bar: Mutex<ProgressBar>,
    quiet: bool,
}

impl Bar {
    fn new(quiet: bool) -> Self {
        Bar { bar: Mutex::new(ProgressBar::hidden()), quiet }
    }

    fn finish(&self) {
        self.bar.lock().expect("progress bar").finish_and_clear();
    }
}

impl Progress for Bar {
    fn stage(&self, name: &str, total: u64, unit: &str) {
        if self.quiet {
            return;
        }
        let style = match total {
            0 => "{msg:8} {elapsed:>4}".to_string(),
            _ => format!("{{msg:8}} {{wide_bar}} {{pos}}/{{len}} {unit}, {{per_sec}}, {{eta}} left"),
        };
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
        bar.set_style(ProgressStyle::with_template(&style).expect("a fixed template"));
        bar.set_message(name.to_string());
        bar.tick();
        let mut slot = self.bar.lock().expect("progress bar");
        slot.finish_and_clear();
        *slot = bar;
    }

    fn advance(&self, steps: u64) {
        self.bar.lock().expect("progress bar").inc(steps);
    }
}
