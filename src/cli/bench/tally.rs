//! What became of many lattices: counts by outcome, reason, degree and smallest angle.

use lattice_brep::error::Error;
use lattice_brep::graph::Graph;
use lattice_brep::node::Star;
use lattice_brep::node::star::angle;
use lattice_brep::report::Report;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// Upper bounds of the classes: number of struts at the node, smallest angle (degrees), number of struts of a graph.
const DEGREES: &[f64] = &[1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 30.0, f64::INFINITY];
const ANGLES: &[f64] = &[5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 90.0, 180.0, f64::INFINITY];
const STRUTS: &[f64] = &[50.0, 100.0, 150.0, f64::INFINITY];
/// Seeds listed for each reason.
const SEEDS: usize = 8;
/// Characters of a reason that tell its kind.
const KIND: usize = 160;

pub enum Outcome {
    Accepted(Box<Report>),
    Refused(Error),
    /// A panic, or a check of our own work that did not pass.
    Failed(String),
}

impl Outcome {
    pub fn name(&self) -> &'static str {
        match self {
            Outcome::Accepted(_) => "accepted",
            Outcome::Refused(_) => "refused",
            Outcome::Failed(_) => "failed",
        }
    }

    /// The column it counts in, and kinds of reasons: why it was not accepted, or not on the first rung.
    fn column(&self) -> (&'static str, Vec<String>) {
        match self {
            Outcome::Accepted(report) => {
                let r = &report.rungs;
                let lowered = [(&r.sharp, "sharp"), (&r.more_control, "more control"), (&r.level_set, "level set")];
                let kinds = lowered.iter().flat_map(|(list, rung)| list.iter().map(move |l| format!("{rung}: {}", kind(&l.reasons[0]))));
                let column = lowered
                    .iter()
                    .find(|(list, _)| !list.is_empty())
                    .map_or(if r.soap_film > 0 || !r.no_ball.is_empty() { "first rung" } else { "ends" }, |l| l.1);
                (column, kinds.collect())
            }
            Outcome::Refused(Error::BadInput(faults)) => ("bad input", faults.iter().take(1).map(|f| kind(&f.to_string())).collect()),
            Outcome::Refused(Error::CannotBuild { reasons }) if reasons.iter().all(|r| r.starts_with("struts[")) => ("no cuts", Vec::new()),
            Outcome::Refused(Error::CannotBuild { reasons }) => ("no skin", reasons.iter().map(|r| kind(r.split_once("): ").map_or(r, |r| r.1))).collect()),
            Outcome::Refused(other) => ("failed", vec![kind(&other.to_string())]),
            Outcome::Failed(why) => ("failed", vec![kind(why)]),
        }
    }
}

/// Columns of the tables, from the best outcome down.
const COLUMNS: [&str; 9] = ["ends", "first rung", "level set", "more control", "sharp", "no cuts", "bad input", "no skin", "failed"];

/// A reason without its numbers.
fn kind(reason: &str) -> String {
    let mut out = String::new();
    for c in reason.chars() {
        let c = if c.is_ascii_digit() { '#' } else { c };
        if !(c == '#' && out.ends_with(['#', '.', 'e', '-']) && out.contains('#')) {
            out.push(c);
        }
    }
    let out = out.replace("#.#", "#").replace("#.", "#").replace("#e-", "#").replace("-#", "#");
    out.chars().take(KIND).collect()
}

/// One lattice and what became of it.
pub struct Case {
    seed: u64,
    pub outcome: Outcome,
    /// Of the node with most struts.
    degree: usize,
    struts: usize,
    /// Smallest angle between two struts of a node, degrees; infinite where no node has two.
    angle: f64,
    seconds: f64,
}

impl Case {
    pub fn new(seed: u64, graph: &Graph, outcome: Outcome, seconds: f64) -> Case {
        let least = |node| {
            let axes = Star::directions(graph, node);
            let pairs = (0..axes.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
            pairs.map(|(i, j)| angle(axes[i], axes[j]).to_degrees()).fold(f64::INFINITY, f64::min)
        };
        Case {
            seed,
            seconds,
            outcome,
            degree: graph.used_nodes().map(|n| graph.degree(n)).max().unwrap_or(0),
            struts: graph.struts().len(),
            angle: graph.used_nodes().map(least).fold(f64::INFINITY, f64::min),
        }
    }
}

/// One kind of reason.
#[derive(Serialize)]
struct Kind {
    column: &'static str,
    reason: String,
    count: usize,
    /// The first lattices of this kind.
    seeds: Vec<u64>,
}

/// Counts over many lattices.
#[derive(Serialize)]
pub struct Tally {
    #[serde(skip)]
    tables: Vec<(&'static str, fn(&Case) -> f64, &'static [f64])>,
    lattices: usize,
    outcomes: BTreeMap<&'static str, usize>,
    /// By table, class (its upper bound) and column.
    classes: BTreeMap<&'static str, BTreeMap<usize, BTreeMap<&'static str, usize>>>,
    kinds: Vec<Kind>,
    worst: Worst,
    /// The lattice that took longest: its seed, and its time in seconds.
    slowest: (u64, f64),
}

/// The worst figures over all accepted lattices.
#[derive(Default, Serialize)]
struct Worst {
    inner_jump_deg: f64,
    rim_jump_deg: f64,
    gap_mm: f64,
    /// Least over all.
    facing: f64,
    over_tolerance: usize,
}

impl Tally {
    pub fn of_nodes() -> Tally {
        Tally::new(vec![("struts", |c| c.degree as f64, DEGREES), ("smallest angle", |c| c.angle, ANGLES)])
    }

    pub fn of_graphs() -> Tally {
        Tally::new(vec![("struts", |c| c.struts as f64, STRUTS), ("smallest angle", |c| c.angle, ANGLES)])
    }

    fn new(tables: Vec<(&'static str, fn(&Case) -> f64, &'static [f64])>) -> Tally {
        let worst = Worst { facing: 1.0, ..Worst::default() };
        Tally { tables, lattices: 0, outcomes: BTreeMap::new(), classes: BTreeMap::new(), kinds: Vec::new(), worst, slowest: (0, 0.0) }
    }

    pub fn add(&mut self, case: Case) {
        let (column, kinds) = case.outcome.column();
        self.lattices += 1;
        *self.outcomes.entry(case.outcome.name()).or_default() += 1;
        for (name, figure, bounds) in &self.tables {
            let class = bounds.iter().position(|&most| figure(&case) <= most).expect("the last bound is infinite");
            *self.classes.entry(name).or_default().entry(class).or_default().entry(column).or_default() += 1;
        }
        for text in kinds {
            let known = self.kinds.iter().position(|k| k.column == column && k.reason == text);
            let at = known.unwrap_or_else(|| {
                self.kinds.push(Kind { column, reason: text, count: 0, seeds: Vec::new() });
                self.kinds.len() - 1
            });
            let kind = &mut self.kinds[at];
            kind.count += 1;
            if kind.seeds.len() < SEEDS && kind.seeds.last() != Some(&case.seed) {
                kind.seeds.push(case.seed);
            }
        }
        if case.seconds > self.slowest.1 {
            self.slowest = (case.seed, case.seconds);
        }
        if let Outcome::Failed(why) = &case.outcome {
            eprintln!("failed: seed {}: {why}", case.seed);
        }
        if let Outcome::Accepted(report) = &case.outcome {
            let (q, w) = (&report.quality, &mut self.worst);
            w.inner_jump_deg = w.inner_jump_deg.max(q.inner_jump_deg.value);
            w.rim_jump_deg = w.rim_jump_deg.max(q.rim_jump_deg.value);
            w.gap_mm = w.gap_mm.max(q.gap_mm.value);
            w.facing = w.facing.min(q.facing.value);
            w.over_tolerance += q.over_tolerance;
        }
    }

    pub fn failed(&self) -> usize {
        self.outcomes.get("failed").copied().unwrap_or(0)
    }
}

impl Display for Tally {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let outcomes: Vec<String> = ["accepted", "refused", "failed"].map(|o| format!("{} {o}", self.outcomes.get(o).copied().unwrap_or(0))).into();
        writeln!(f, "{} lattices: {}", self.lattices, outcomes.join(", "))?;
        for (name, _, bounds) in &self.tables {
            writeln!(f, "\n| {name} | {} | all |\n|---|{}---|", COLUMNS.join(" | "), "---|".repeat(COLUMNS.len()))?;
            for (class, columns) in self.classes.get(name).into_iter().flatten() {
                let counts = COLUMNS.map(|c| columns.get(c).copied().unwrap_or(0));
                let bound = match (bounds[*class], *class) {
                    (most, _) if most.is_finite() => format!("up to {most}"),
                    (_, 0) => "any".to_owned(),
                    (_, class) => format!("above {}", bounds[class - 1]),
                };
                writeln!(f, "| {bound} | {} | {} |", counts.map(|n| n.to_string()).join(" | "), counts.iter().sum::<usize>())?;
            }
        }
        let w = &self.worst;
        writeln!(
            f,
            "\naccepted, at worst: normal jump {:.1e}° inside nodes, {:.1e}° at rims, gap {:.1e} mm, facing {:.1e}; {} nodes over the tolerance",
            w.inner_jump_deg, w.rim_jump_deg, w.gap_mm, w.facing, w.over_tolerance
        )?;
        writeln!(f, "slowest: seed {}, {:.1} s", self.slowest.0, self.slowest.1)?;
        let mut kinds: Vec<_> = self.kinds.iter().collect();
        kinds.sort_by_key(|k| (COLUMNS.iter().position(|c| *c == k.column), usize::MAX - k.count));
        for Kind { column, reason, count, seeds } in kinds {
            writeln!(f, "{count:6} {column}: {reason} (seeds {seeds:?})")?;
        }
        Ok(())
    }
}
