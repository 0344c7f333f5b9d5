//! `lattice-brep bench`: seeded random lattices through the whole pipeline, counted as accepted, refused or failed; times of nodes.

pub mod random;
mod table;
mod tally;

use super::output;
use clap::{Args, Subcommand};
use lattice_brep::error::Error;
use lattice_brep::graph::check::{self, Overlaps};
use lattice_brep::graph::{Graph, Input, json};
use lattice_brep::options::{OnConflict, Options};
use lattice_brep::pipeline::{self, Silent};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use table::TableArgs;
use tally::{Case, Outcome, Tally};

/// Most struts at a random node. Reason: the largest degree of the tetrahedral lattices known to us is 41.
const MOST_DEGREE: usize = 45;
/// Stack of a working thread, bytes: that of a main thread.
const STACK: usize = 8 << 20;

/// Build seeded random lattices and count what becomes of them; time the nodes of lattices
#[derive(Args)]
pub struct BenchArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Single nodes with free ends, of degree 1 to 45, radii up to ten to one, angles down to 3°
    Nodes {
        #[command(flatten)]
        run: Run,
        /// Least number of struts
        #[arg(long, value_name = "DEGREE", default_value_t = 1)]
        from: usize,
        /// Largest number of struts; fewer where so many do not fit
        #[arg(long, value_name = "DEGREE", default_value_t = MOST_DEGREE)]
        to: usize,
    },
    /// Connected graphs of 20 to 200 struts with mixed radii; every other one with --on-conflict shrink
    Graphs {
        #[command(flatten)]
        run: Run,
    },
    Table(TableArgs),
}

#[derive(Args)]
struct Run {
    /// Number of lattices
    #[arg(long, value_name = "N", default_value_t = 1000)]
    count: u64,
    /// Seed of the first lattice; each next has the next number
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Begin no lattice after so many minutes
    #[arg(long, value_name = "M")]
    minutes: Option<f64>,
    /// Write all counts as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write lattices into this folder, as SEED.OUTCOME.json: those that failed
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    /// With --keep: write all lattices, not only those that failed
    #[arg(long, requires = "keep")]
    all: bool,
    /// Threads [default: all cores]
    #[arg(long)]
    threads: Option<usize>,
}

pub fn run(args: &BenchArgs) -> Result<(), Error> {
    match &args.what {
        What::Nodes { run, from, to } => {
            let degrees = [(*from).max(1), (*to).clamp((*from).max(1), MOST_DEGREE.max(*from))];
            run.go(|seed| (random::node(seed, degrees), Options::default()), Tally::of_nodes())
        }
        What::Graphs { run } => run.go(
            |seed| {
                let on_conflict = if seed % 2 == 0 { OnConflict::Shrink { part: true } } else { OnConflict::Refuse };
                (random::graph(seed), Options { on_conflict, ..Options::default() })
            },
            Tally::of_graphs(),
        ),
        What::Table(table) => table.run(),
    }
}

impl Run {
    fn go(&self, lattice: impl Fn(u64) -> (Graph, Options) + Sync, tally: Tally) -> Result<(), Error> {
        if let Some(folder) = &self.keep {
            std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
        }
        let threads = self.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into)).max(1);
        let next = AtomicU64::new(0);
        let start = Instant::now();
        let is_over = || self.minutes.is_some_and(|m| start.elapsed().as_secs_f64() > 60.0 * m);
        let tally = Mutex::new(tally);
        let work = || -> Result<(), Error> {
            // one lattice a thread, from begin to end: a panic then ends that lattice alone
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).stack_size(STACK).build().map_err(|e| Error::Internal(e.to_string()))?;
            loop {
                let at = next.fetch_add(1, Ordering::Relaxed);
                if at >= self.count || is_over() {
                    return Ok(());
                }
                let seed = self.seed + at;
                let (graph, options) = lattice(seed);
                let begin = Instant::now();
                let outcome = pool.install(|| outcome(&graph, &options));
                let case = Case::new(seed, &graph, outcome, begin.elapsed().as_secs_f64());
                if let Some(folder) = self.keep.as_ref().filter(|_| self.all || matches!(case.outcome, Outcome::Failed(_))) {
                    let path = folder.join(format!("{seed}.{}.json", case.outcome.name()));
                    output::write(Some(&path), |out| json::write(&graph, None, out))?;
                }
                tally.lock().expect("no thread panics with the tally").add(case);
            }
        };
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            threads.into_iter().try_for_each(|t| t.join().expect("lattices are built behind catch_unwind"))
        })?;
        let tally = tally.into_inner().expect("no thread panics with the tally");
        output::write(None, |out| write!(out, "{tally}"))?;
        if let Some(path) = &self.json {
            output::write(Some(path), |out| {
                serde_json::to_writer_pretty(&mut *out, &tally)?;
                writeln!(out)
            })?;
        }
        match tally.failed() {
            0 => Ok(()),
            n => Err(Error::Internal(format!("{n} lattices failed"))),
        }
    }
}

/// Check and build one lattice as `export` does, without the text.
fn outcome(graph: &Graph, options: &Options) -> Outcome {
    let input = Input { name: None, nodes: graph.nodes().to_vec(), struts: graph.struts().to_vec() };
    let built = catch_unwind(AssertUnwindSafe(|| {
        let lattice = check::admit(input, Vec::new(), Overlaps::Refuse)?;
        pipeline::solve(&lattice, options, &Silent).map(|solved| solved.report)
    }));
    match built {
        Ok(Ok(report)) => Outcome::Accepted(Box::new(report)),
        Ok(Err(error @ (Error::BadInput(_) | Error::CannotBuild { .. }))) => Outcome::Refused(error),
        Ok(Err(error)) => Outcome::Failed(error.to_string()),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned().or_else(|| panic.downcast_ref::<&str>().map(|s| s.to_string()));
            Outcome::Failed(format!("panic: {}", text.unwrap_or_default()))
        }
    }
}
