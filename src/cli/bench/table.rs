//! `lattice-brep bench table`: Table 2 of Luo & Zou 2025 for any lattices, and the time of a node by its degree.

use crate::cli::input::ImportFlags;
use crate::cli::output;
use clap::Args;
use lattice_brep::error::Error;
use lattice_brep::graph::Graph;
use lattice_brep::graph::check::Overlaps;
use lattice_brep::options::Options;
use lattice_brep::pipeline;
use lattice_brep::timing::{self, NodeTime};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

/// Edges, nodes, largest degree and times of each node of some lattices, beside the paper's Table 2
#[derive(Args)]
#[command(after_help = "Example:
  lattice-brep bench table lever.json housing.json --runs 3")]
pub struct TableArgs {
    /// Lattices, in any format that `export` reads
    #[arg(required = true)]
    lattices: Vec<PathBuf>,
    /// Runs of each node, of which the fastest counts
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    #[command(flatten)]
    import: ImportFlags,
}

/// Least, largest and mean, ms.
type Three = [f64; 3];

/// A row: model, edges, nodes, largest degree, smoothing, construction.
type Row<'a> = (&'a str, usize, usize, usize, Three, Three);

/// Table 2.
const PAPER: [Row; 9] = [
    ("Heat Exchanger", 6125, 4908, 39, [5.0, 94.0, 29.5], [40.0, 649.0, 216.8]),
    ("Lever Arm", 12960, 2665, 38, [6.0, 99.0, 28.6], [48.0, 677.0, 205.6]),
    ("Mounting Bracket", 24685, 4873, 38, [6.0, 108.0, 31.7], [50.0, 761.0, 230.3]),
    ("Surfacing Mold", 26813, 5306, 33, [7.0, 90.0, 31.7], [53.0, 633.0, 229.3]),
    ("Engine Bracket", 33005, 6517, 35, [6.0, 94.0, 30.4], [48.0, 652.0, 218.6]),
    ("Bevel Gear", 38325, 7602, 40, [6.0, 105.0, 31.1], [49.0, 727.0, 227.6]),
    ("Pipe Holder", 46331, 9134, 41, [8.0, 105.0, 31.3], [60.0, 732.0, 230.7]),
    ("Impeller", 47377, 9283, 38, [6.0, 107.0, 32.7], [50.0, 734.0, 236.6]),
    ("Gear Box", 79200, 15571, 38, [5.0, 105.0, 32.5], [39.0, 707.0, 227.8]),
];

impl TableArgs {
    pub fn run(&self) -> Result<(), Error> {
        let three = |name: &str| format!("{name} min, ms | max | avg");
        let mut text = format!("| model | edges | nodes | max degree | {} | {} |\n|---|{}\n", three("smoothing"), three("construction"), "---|".repeat(9));
        for row in PAPER {
            push(&mut text, "paper: ", row, 1);
        }
        let mut all = vec![];
        for path in &self.lattices {
            let (lattice, _) = pipeline::straighten(self.import.read(path)?.admit(Overlaps::Keep)?);
            let times = timing::nodes(&lattice.graph, &Options::default(), self.runs)?;
            push(&mut text, "", row(&path.file_stem().unwrap_or_default().to_string_lossy(), &lattice.graph, &times), 2);
            all.extend(times);
        }
        text += &format!("\n| degree | nodes | {} | {} |\n|---|{}\n", three("smoothing"), three("construction"), "---|".repeat(7));
        let mut degrees: BTreeMap<usize, Vec<NodeTime>> = BTreeMap::new();
        for time in all {
            degrees.entry(time.degree).or_default().push(time);
        }
        for (degree, times) in degrees {
            let cells = [smoothing(&times), construction(&times)].concat();
            writeln!(text, "| {degree} | {} | {} |", times.len(), numbers(&cells, 2)).expect("a string takes all");
        }
        output::write(None, |out| out.write_all(text.as_bytes()))
    }
}

fn row<'a>(model: &'a str, graph: &Graph, times: &[NodeTime]) -> Row<'a> {
    let most = graph.used_nodes().map(|n| graph.degree(n)).max().unwrap_or(0);
    (model, graph.struts().len(), graph.used_nodes().count(), most, smoothing(times), construction(times))
}

fn push(text: &mut String, who: &str, (model, edges, nodes, degree, smoothing, construction): Row, decimals: usize) {
    let cells = [smoothing, construction].concat();
    writeln!(text, "| {who}{model} | {edges} | {nodes} | {degree} | {} |", numbers(&cells, decimals)).expect("a string takes all");
}

fn numbers(cells: &[f64], decimals: usize) -> String {
    cells.iter().map(|x| format!("{x:.decimals$}")).collect::<Vec<_>>().join(" | ")
}

fn smoothing(times: &[NodeTime]) -> Three {
    spread(times.iter().filter_map(|t| t.smoothing))
}

fn construction(times: &[NodeTime]) -> Three {
    spread(times.iter().map(|t| t.construction))
}

/// Of no times: not numbers.
fn spread(times: impl Iterator<Item = f64> + Clone) -> Three {
    let count = times.clone().count() as f64;
    [times.clone().fold(f64::NAN, f64::min), times.clone().fold(f64::NAN, f64::max), times.sum::<f64>() / count]
}
