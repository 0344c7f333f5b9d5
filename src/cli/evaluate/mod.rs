//! `lattice-brep evaluate`: the paper's own evaluation, Case study 1, beside its figures.

mod sets;

use super::output;
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lattice_brep::error::Error;
use lattice_brep::evaluate::{Deviation, Evaluation, FAIRINGS, Measured, Patches, Reading};
use rayon::prelude::*;
use serde::Serialize;
use sets::{Kind, SETS, Set};
use std::path::PathBuf;

/// Measure nodes as the paper does, and print its figures beside ours
#[derive(Args)]
pub struct EvaluateArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Nodes(NodesArgs),
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
    /// Also measure films by other readings of the paper's fairing
    #[arg(long)]
    readings: bool,
    /// Write the figures of every node as JSON, lengths in mm
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
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
    let What::Nodes(args) = &args.what;
    args.run()
}

/// All nodes of a set.
#[derive(Serialize)]
struct Figures {
    set: &'static str,
    /// Max, Avg and Std of Table 1, mm.
    paper: [f64; 3],
    /// Degrees; none for regular nodes.
    least_angle: Option<f64>,
    /// Names of each node's `films`.
    readings: Vec<&'static str>,
    nodes: Vec<Measured>,
}

impl NodesArgs {
    fn run(&self) -> Result<(), Error> {
        let readings: Vec<Reading> = Reading::USUAL.into_iter().chain(Reading::OTHERS.into_iter().filter(|_| self.readings)).collect();
        let chosen: Vec<&Set> = SETS.iter().filter(|set| self.sets.is_empty() || self.sets.iter().any(|name| name == set.name)).collect();
        let evaluation = Evaluation::new(self.samples);
        let threads = self.threads.unwrap_or(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| Error::Internal(e.to_string()))?;
        let figures = chosen.iter().map(|set| pool.install(|| self.measure(set, &readings, &evaluation))).collect::<Result<Vec<_>, _>>()?;
        output::write(None, |out| write!(out, "{}\n{}\n{}", deviations(&figures), factors(&figures), fairness(&figures)))?;
        match &self.json {
            None => Ok(()),
            Some(path) => output::write(Some(path), |out| {
                serde_json::to_writer_pretty(&mut *out, &figures)?;
                writeln!(out)
            }),
        }
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
        Ok(Figures { set: set.name, paper: set.paper, least_angle, readings: readings.iter().map(|r| r.name).collect(), nodes })
    }
}

impl Figures {
    /// Each kind of surface with the deviations of all nodes that have it.
    fn surfaces(&self) -> Vec<(&'static str, Vec<Deviation>)> {
        let films = (0..self.readings.len()).map(|k| (self.readings[k], self.nodes.iter().filter_map(|n| n.films[k]).collect()));
        let patches = |n: &Measured, k: usize| n.patches[k].as_ref().map(|p| p.deviation);
        let patches = FAIRINGS.iter().enumerate().map(|(k, (name, _))| (*name, self.nodes.iter().filter_map(|n| patches(n, k)).collect()));
        films.chain(patches).collect()
    }
}

/// Max, Avg and Std.
fn three(list: &[Deviation]) -> [Spread; 3] {
    let of = |figure: fn(&Deviation) -> f64| Spread::new(list.iter().map(figure));
    [of(|d| d.max), of(|d| d.avg), of(|d| d.std)]
}

/// How far Max, Avg and Std are from the paper's: the mean of |ln(ours / paper's)|.
fn off(list: &[Deviation], paper: &[f64; 3]) -> f64 {
    three(list).iter().zip(paper).map(|(ours, paper)| (ours.median / paper).ln().abs()).sum::<f64>() / 3.0
}

/// The table of deviations, after Table 1.
fn deviations(figures: &[Figures]) -> String {
    let mut out =
        String::from("| set | surface | nodes | Max mm | Avg mm | Std mm | most outside | most inside | factor |\n|---|---|---|---|---|---|---|---|---|\n");
    for set in figures {
        let [max, avg, std] = set.paper.map(|x| format!("{x:.4}"));
        out += &format!("| {} | Table 1 | 1 | {max} | {avg} | {std} | | | |\n", set.set);
        for (surface, list) in set.surfaces() {
            let sides: [fn(&Deviation) -> f64; 2] = [|d| d.max_outside, |d| d.max_inside];
            let sides = sides.map(|figure| Spread::new(list.iter().map(figure)));
            let columns = three(&list).iter().chain(&sides).map(|s| s.text(4)).collect::<Vec<_>>().join(" | ");
            out += &format!("| {} | {surface} | {} | {columns} | {:.2} |\n", set.set, list.len(), off(&list, &set.paper).exp());
        }
    }
    out + "\nFactor: exp of the mean |ln(ours / paper's)| of Max, Avg and Std: 1 where they agree. Of several nodes: median (least to largest).\n"
}

/// The table of mean factors over all regular and over all irregular sets.
fn factors(figures: &[Figures]) -> String {
    let mut out = String::from("| surface | factor, regular sets | factor, irregular sets |\n|---|---|---|\n");
    let names: Vec<&str> = figures.first().map(|set| set.surfaces().iter().map(|s| s.0).collect()).unwrap_or_default();
    for (k, name) in names.into_iter().enumerate() {
        let mean = |regular: bool| {
            let sets = figures.iter().filter(|set| set.least_angle.is_none() == regular);
            let offs: Vec<f64> = sets.map(|set| off(&set.surfaces()[k].1, &set.paper)).collect();
            if offs.is_empty() { String::new() } else { format!("{:.2}", (offs.iter().sum::<f64>() / offs.len() as f64).exp()) }
        };
        out += &format!("| {name} | {} | {} |\n", mean(true), mean(false));
    }
    out
}

/// The table of curvatures of the patches.
fn fairness(figures: &[Figures]) -> String {
    let mut out = String::from(
        "| set | surface | refused | not on the first rung | largest \\|H\\| r | 99 % of \\|H\\| r | thin plate | by area, r² | variation, r² | largest jump, r |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for Figures { set, nodes, .. } in figures {
        for (k, (surface, _)) in FAIRINGS.iter().enumerate() {
            let built: Vec<&Patches> = nodes.iter().filter_map(|n| n.patches[k].as_ref()).collect();
            let lower = built.iter().filter(|p| !p.first_rung).count();
            let of = |figure: fn(&Patches) -> f64, digits| Spread::new(built.iter().map(|p| figure(p))).text(digits);
            let columns = [
                of(|p| p.max_mean_curvature, 2),
                of(|p| p.usual_mean_curvature, 2),
                of(|p| p.thin_plate, 1),
                of(|p| p.thin_plate / p.area, 2),
                of(|p| p.variation, 0),
                of(|p| p.max_edge_jump, 2),
            ];
            out += &format!("| {set} | {surface} | {} | {lower} | {} |\n", nodes.len() - built.len(), columns.join(" | "));
        }
    }
    out
}

/// Median, least and largest of some figures.
struct Spread {
    median: f64,
    least: f64,
    largest: f64,
}

impl Spread {
    /// NaN where there are none.
    fn new(figures: impl Iterator<Item = f64>) -> Spread {
        let mut sorted: Vec<f64> = figures.collect();
        sorted.sort_by(f64::total_cmp);
        let at = |k: usize| sorted.get(k).copied().unwrap_or(f64::NAN);
        let (n, last) = (sorted.len(), sorted.len().saturating_sub(1));
        Spread { median: 0.5 * (at(last / 2) + at(n / 2)), least: at(0), largest: at(last) }
    }

    fn text(&self, digits: usize) -> String {
        let Spread { median, least, largest } = self;
        if least == largest { format!("{median:.digits$}") } else { format!("{median:.digits$} ({least:.digits$} to {largest:.digits$})") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_or_between_the_two() {
        let spread = |list: &[f64]| Spread::new(list.iter().copied());
        assert_eq!(spread(&[3.0, 1.0, 2.0]).text(1), "2.0 (1.0 to 3.0)");
        assert_eq!(spread(&[4.0, 1.0, 2.0, 3.0]).median, 2.5);
        assert_eq!(spread(&[0.25]).text(2), "0.25");
        assert!(spread(&[]).median.is_nan());
    }

    /// Half of the paper's figures everywhere: a factor of two.
    #[test]
    fn the_factor_is_that_of_the_figures() {
        let half = Deviation { max: 0.5, avg: 0.1, std: 0.2, ..Deviation::default() };
        assert!((off(&[half; 3], &[1.0, 0.2, 0.4]).exp() - 2.0).abs() < 1e-12);
        // one figure twice, one half: they do not cancel
        let mixed = Deviation { max: 2.0, avg: 0.1, std: 0.4, ..Deviation::default() };
        assert!((off(&[mixed], &[1.0, 0.2, 0.4]) - 4f64.ln() / 3.0).abs() < 1e-12);
    }
}
