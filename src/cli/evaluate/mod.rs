//! `lattice-brep evaluate`: the paper's own evaluation, Case study 1, beside its figures.

mod levels;
mod ply;
mod sets;
mod tables;

use super::output;
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lattice_brep::error::Error;
use lattice_brep::evaluate::{Evaluation, Measured, Reading};
use levels::LevelsArgs;
use rayon::prelude::*;
use serde::Serialize;
use sets::{Kind, SETS, Set};
use std::path::{Path, PathBuf};

/// Measure nodes as the paper does, and print its figures beside ours
#[derive(Args)]
pub struct EvaluateArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Nodes(NodesArgs),
    Levels(LevelsArgs),
}

/// Case study 1: distance of single nodes from the original shape (Table 1), and their curvature
///
/// Regular nodes of 6, 12 and 20 struts, and seeded random ones of which the median is printed with the least and the largest;
/// radius 1 mm, lambda 0.3. The original shape is the union of the half cylinders and the node sphere. Each surface is sampled
/// evenly, each sample counted by its area.
#[derive(Args)]
#[command(after_help = "Examples:
  lattice-brep evaluate nodes
  lattice-brep evaluate nodes --sets regular-6,regular-20 --readings
  lattice-brep evaluate nodes --samples 20000 --count 10 --json nodes.json
  lattice-brep evaluate nodes --sets regular-6 --surfaces drawn
  lattice-brep evaluate nodes --sets irregular-12 --least-angle 15 --seed 7")]
struct NodesArgs {
    /// Node sets to measure [default: all]
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', value_parser = PossibleValuesParser::new(SETS.map(|set| set.name)))]
    sets: Vec<String>,
    /// Least number of points on each surface
    #[arg(long, value_name = "N", default_value_t = 800_000)]
    samples: usize,
    /// Random nodes in each irregular set
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..))]
    count: u64,
    /// Seed of the first random node; each next has the next number
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Least angle between two struts of a random node, degrees [default: 35, 25 and 20 for 6, 12 and 20 struts]
    #[arg(long, value_name = "DEGREES", value_parser = least_angle)]
    least_angle: Option<f64>,
    /// Also measure other readings of the paper's fairing
    #[arg(long)]
    readings: bool,
    /// Also measure our film held more and less to the original shape: deviation against fairness
    #[arg(long)]
    trade: bool,
    /// Write the figures of every node as JSON, lengths in mm
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the surfaces of each set's first node into this folder as PLY, with distance and mean curvature at every point:
    /// SET-READING-mesh.ply and SET-READING-patches.ply (of Savio's film the mesh alone)
    #[arg(long, value_name = "FOLDER")]
    surfaces: Option<PathBuf>,
    /// Threads [default: all cores]; the figures do not depend on it
    #[arg(long)]
    threads: Option<usize>,
}

/// Twenty directions no nearer than 30° are found by chance; not many more.
fn least_angle(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(angle) if (1.0..=30.0).contains(&angle) => Ok(angle),
        _ => Err("wanted an angle from 1 to 30 degrees".to_owned()),
    }
}

pub fn run(args: &EvaluateArgs) -> Result<(), Error> {
    match &args.what {
        What::Nodes(args) => args.run(),
        What::Levels(args) => args.run(),
    }
}

/// All nodes of a set.
#[derive(Serialize)]
struct Figures {
    set: &'static str,
    /// Max, Avg and Std of Table 1, mm.
    paper: [f64; 3],
    /// The same for Savio's method.
    savio: [f64; 3],
    /// Degrees; none for regular nodes.
    least_angle: Option<f64>,
    /// Names of each node's `films` and `patches`.
    readings: Vec<&'static str>,
    nodes: Vec<Measured>,
}

impl NodesArgs {
    fn run(&self) -> Result<(), Error> {
        let more = Reading::OTHERS.into_iter().filter(|_| self.readings).chain(Reading::TRADE.into_iter().filter(|_| self.trade));
        let readings: Vec<Reading> = Reading::USUAL.into_iter().chain(more).collect();
        let chosen: Vec<&Set> = SETS.iter().filter(|set| self.sets.is_empty() || self.sets.iter().any(|name| name == set.name)).collect();
        let evaluation = Evaluation::new(self.samples);
        let threads = self.threads.unwrap_or(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| Error::Internal(e.to_string()))?;
        let figures = chosen.iter().map(|set| pool.install(|| self.measure(set, &readings, &evaluation))).collect::<Result<Vec<_>, _>>()?;
        output::write(None, |out| out.write_all(tables::all(&figures).as_bytes()))?;
        if let Some(folder) = &self.surfaces {
            std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
            chosen.iter().try_for_each(|set| self.write_surfaces(set, &readings, &evaluation, folder))?;
        }
        match &self.json {
            None => Ok(()),
            Some(path) => output::write(Some(path), |out| {
                serde_json::to_writer_pretty(&mut *out, &figures)?;
                writeln!(out)
            }),
        }
    }

    fn write_surfaces(&self, set: &Set, readings: &[Reading], evaluation: &Evaluation, folder: &Path) -> Result<(), Error> {
        let axes = &set.kind.nodes(1, self.seed, self.least_angle)[0];
        for reading in readings {
            for (kind, fields) in evaluation.surfaces(axes, reading).map_err(Error::Internal)?.into_iter().flatten() {
                let name = format!("{}-{}-{kind}.ply", set.name, reading.name.to_lowercase().replace([' ', ','], "-"));
                output::write(Some(&folder.join(name)), |out| ply::write(axes, &fields, out))?;
            }
        }
        Ok(())
    }

    fn measure(&self, set: &Set, readings: &[Reading], evaluation: &Evaluation) -> Result<Figures, Error> {
        let nodes = set.kind.nodes(self.count, self.seed, self.least_angle);
        let bar = ProgressBar::with_draw_target(Some(nodes.len() as u64), ProgressDrawTarget::stderr());
        bar.set_style(ProgressStyle::with_template("{msg:13} {wide_bar} {pos}/{len} nodes, {eta} left").expect("a fixed template"));
        bar.set_message(set.name);
        let one = |axes: Vec<_>| {
            let measured = evaluation.node(&axes, readings);
            bar.inc(1);
            measured
        };
        let nodes = nodes.into_par_iter().map(one).collect::<Result<Vec<_>, _>>().map_err(Error::Internal)?;
        bar.finish_and_clear();
        let least_angle = match set.kind {
            Kind::Regular(_) => None,
            Kind::Irregular { least_angle, .. } => Some(self.least_angle.unwrap_or(least_angle)),
        };
        let readings = readings.iter().map(|r| r.name).collect();
        Ok(Figures { set: set.name, paper: set.paper, savio: set.savio, least_angle, readings, nodes })
    }
}
