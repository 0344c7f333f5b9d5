//! `lattice-brep inspect FILE`: what is in a lattice and what export would do, for people or for programs.

use super::input::ImportFlags;
use super::output;
use super::repair::RepairFlags;
use lattice_brep::error::Error;
use lattice_brep::graph::import::{Format, Imported};
use lattice_brep::inspect::{Class, Inspection, Spread, inspect};
use lattice_brep::options::Options;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

/// Most lines shown of each list; `--json` has them all.
const MOST_SHOWN: usize = 8;

/// Print what is in a lattice graph: counts, angles, radii, faults, conflicts, what export would do, and a rough cost
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lattice-brep inspect part.json
  lattice-brep inspect part.json --collapse-chains     as it would be after this repair
  lattice-brep inspect part.json --json | jq '.cut_conflicts | length'

No solid is built. Faulty lattices are described as far as they can be. Exit code 0 unless the file cannot be read.")]
pub struct InspectArgs {
    /// Lattice: JSON (see `lattice-brep schema`), 3MF, TetGen, Gmsh, VTK, LTCX, CSV, OBJ or Abaqus
    input: PathBuf,
    /// Print JSON, with whole lists, instead of text (see `lattice-brep schema --inspect`)
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    import: ImportFlags,
    #[command(flatten)]
    repair: RepairFlags,
}

pub fn run(args: &InspectArgs) -> Result<(), Error> {
    let Imported { format, input, faults, .. } = args.import.read(&args.input)?;
    let repaired = args.repair.apply(input, &faults, args.json);
    let found = inspect(&repaired.input, format.map_or("of no known format", Format::name), faults, &Options::default());
    output::write(None, |out| {
        if args.json {
            serde_json::to_writer_pretty(&mut *out, &found)?;
            writeln!(out)
        } else {
            write!(out, "{}", Page(&found))
        }
    })
}

/// An inspection as text.
struct Page<'a>(&'a Inspection);

impl Display for Page<'_> {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let i = self.0;
        line(f, "lattice", &format!("{}{}", i.format, i.name.as_ref().map_or(String::new(), |n| format!(", \"{}\"", n.escape_debug()))))?;
        let extra = |count: usize, what: &str| if count > 0 { format!(" ({count} {what})") } else { String::new() };
        line(f, "nodes", &format!("{}{}", i.nodes, extra(i.bare_nodes, "without a sound strut")))?;
        line(f, "struts", &format!("{}{}", i.struts, extra(i.unsound_struts, "unsound, left out below")))?;
        if let Some([low, high]) = i.bounds {
            let size = [0, 1, 2].map(|k| number(high[k] - low[k])).join(" x ");
            line(f, "size", &format!("{size} mm, from [{}] to [{}]", low.map(number).join(", "), high.map(number).join(", ")))?;
        }
        let r = &i.radii;
        let others = format!("; {} different, {} tapered struts, {} nodes of unequal radii", r.different, r.tapered, r.unequal_nodes);
        line(f, "radii", &format!("{}{others}", range(&r.spread, " mm")))?;
        line(f, "lengths", &range(&i.lengths, " mm"))?;
        line(f, "length / r", &format!("{}{}", range(&i.slenderness, ""), histogram(&i.slenderness_classes, "")))?;
        line(f, "degrees", &i.degrees.iter().map(|d| format!("{}: {}", d.degree, d.nodes)).collect::<Vec<_>>().join("  "))?;
        line(f, "angles", &format!("{}; of each node the smallest{}", range(&i.angles, "°"), histogram(&i.angle_classes, "°")))?;
        let parts = i.components.iter().map(|c| format!("{} struts, {} nodes, {} loops, from nodes[{}]", c.struts, c.nodes, c.loops, c.first_node.0));
        list(f, "parts", parts)?;
        let most = i.faults.iter().fold(BTreeMap::<&str, usize>::new(), |mut counts, fault| {
            *counts.entry(&fault.wanted).or_default() += 1;
            counts
        });
        list(f, "faults", i.faults.iter().map(ToString::to_string))?;
        if let Some((wanted, count)) = most.iter().max_by_key(|x| *x.1).filter(|_| i.faults.len() > MOST_SHOWN) {
            line(f, "", &format!("{count} of them: wanted {wanted}"))?;
        }
        let cuts = i.cut_conflicts.iter().map(|c| {
            let [a, b] = c.cuts.map(number);
            format!("struts[{}]: {a} mm at nodes[{}] and {b} mm at nodes[{}], on a length of {} mm", c.strut.0, c.a.0, c.b.0, number(c.length))
        });
        list(f, "cuts too long", cuts)?;
        for (title, pairs) in [("overlaps", &i.overlaps), ("near misses", &i.near_misses)] {
            let text = pairs.iter().map(|p| {
                let at = p.at.map(number).join(", ");
                format!("struts[{}] and struts[{}]: axes {} mm apart, more than {} wanted, at [{at}]", p.a.0, p.b.0, number(p.distance), number(p.allowed))
            });
            list(f, title, text)?;
        }
        let r = &i.repairs;
        let chains = format!("--collapse-chains removes {} nodes", r.chain_nodes);
        line(f, "repairs", &format!("{chains}; --drop-loose {} struts and {} nodes", r.loose_struts, r.loose_nodes))?;
        if r.straight_nodes > 0 {
            line(f, "", &format!("export itself removes {} nodes whose two struts are one cylinder or cone", r.straight_nodes))?;
        }
        let verdict = if i.export.accepted { "would build" } else { "would refuse:" };
        line(f, "export", &format!("{verdict} {}", i.export.reasons.join("; ")))?;
        let e = &i.estimate;
        let (mb, memory) = (e.bytes / 1e6, e.memory_bytes / 1e6);
        line(f, "estimate", &format!("about {} faces, {mb:.1} MB of STEP, {memory:.0} MB of memory, {:.1} s of CPU time", e.faces, e.cpu_seconds))
    }
}

fn line(f: &mut Formatter, title: &str, text: &str) -> fmt::Result {
    writeln!(f, "{title:13} {text}")
}

/// The count, then one item a line.
fn list(f: &mut Formatter, title: &str, items: impl ExactSizeIterator<Item = String>) -> fmt::Result {
    let count = items.len();
    line(f, title, &count.to_string())?;
    for item in items.take(MOST_SHOWN) {
        line(f, "", &item)?;
    }
    if count > MOST_SHOWN { line(f, "", &format!("... and {} more", count - MOST_SHOWN)) } else { Ok(()) }
}

fn range(spread: &Option<Spread>, unit: &str) -> String {
    match spread {
        None => "none".into(),
        Some(s) if s.least == s.most => format!("{}{unit}", number(s.least)),
        Some(s) => format!("{} to {}{unit}, median {}, least at {}", number(s.least), number(s.most), number(s.median), s.least_at),
    }
}

/// `; below 2: 3, below 5: 40, more: 100`, empty classes left out.
fn histogram(classes: &[Class], unit: &str) -> String {
    let name = |c: &Class| c.below.map_or("more".into(), |x| format!("below {x}{unit}"));
    let filled: Vec<String> = classes.iter().filter(|c| c.count > 0).map(|c| format!("{}: {}", name(c), c.count)).collect();
    if filled.is_empty() { String::new() } else { format!("\n{:14}{}", "", filled.join(", ")) }
}

/// Five significant digits, no zeros at the end.
fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let size = x.abs().log10().floor() as i32;
    if !(-4..9).contains(&size) {
        return format!("{x:.4e}");
    }
    let text = format!("{x:.*}", (4 - size).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}
