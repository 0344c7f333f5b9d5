//! What is in a lattice, what is wrong with it, and what `export` would do: from the graph and its cuts alone, no solid is built.
//!
//! In: an unchecked `Input` and the faults of its form. All figures are of its sound struts: ends in range and apart, places and radii
//! finite. So a faulty lattice is described as far as it can be, and its faults are listed beside.

use crate::cuts;
use crate::error::Fault;
use crate::graph::components::{ComponentId, ComponentSize, components};
use crate::graph::proximity::{self, NearMiss, TOUCHING};
use crate::graph::repair::merge::Fit;
use crate::graph::repair::{self, chains, loose};
use crate::graph::{Graph, Input, Strut, check};
use crate::ids::{NodeId, StrutId};
use crate::options::{Options, SKINS_IN_MEMORY};
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;

/// Struts without a common node are a near miss below this clearance, as a share of the sum of their radii. Guessed.
const NEAR: f64 = 0.25;
/// Patches per strut end, and per end of a node of degree 2. Measured: tetrahedra 5.6, diamond and bcc 6, octet and cubic, with
/// four-fold corners of cells, 4 to 5; degree 2 has 8 in all.
const PATCHES_PER_END: usize = 6;
const PATCHES_PER_END_OF_TWO: usize = 4;
/// Bytes of STEP text per face. Measured: 5,800 (cells of 10 mm) to 7,800 (12,550 struts of a tetrahedral mesh).
const BYTES_PER_FACE: f64 = 7_000.0;
/// Memory at the peak, bytes, of two threads: the program itself; per face what is under way (up to `MOST_UNDER_WAY`), tables, and skins up to a limit where nodes
/// differ. A byte of skins takes `PER_BYTE_OF_SKINS`. Measured: 635 MB for the 153,708 faces of the same mesh, 266 to 306 MB with all its skins in a file; 65 MB for
/// 744 faces and 490 MB for 2,806,568 faces of BCC, whose nodes are equal, so that these figures are too high.
const PROGRAM: f64 = 80e6;
const UNDER_WAY_PER_FACE: f64 = 5_000.0;
const MOST_UNDER_WAY: f64 = 170e6;
const TABLES_PER_FACE: f64 = 350.0;
const SKINS_PER_FACE: f64 = 3_000.0;
const PER_BYTE_OF_SKINS: f64 = 1.4;
/// CPU time per patch, seconds. Measured: 0.0007 (kelvin) to 0.0011 (the same mesh) on a core of a 2020s server.
const SECONDS_PER_PATCH: f64 = 0.001;

/// Bounds of the classes of smallest angles (degrees), and of length over radius.
const ANGLE_CLASSES: [f64; 8] = [2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0];
const SLENDERNESS_CLASSES: [f64; 7] = [2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0];

/// All that can be said of a lattice without building it. Lengths in mm, angles in degrees.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Inspection {
    /// The form of the file.
    pub format: String,
    pub name: Option<String>,
    pub nodes: usize,
    pub struts: usize,
    /// Nodes without a sound strut.
    pub bare_nodes: usize,
    /// Struts with a fault of their own: all else is said of the others.
    pub unsound_struts: usize,
    /// Lowest and highest corner of the nodes that have struts.
    pub bounds: Option<[[f64; 3]; 2]>,
    pub radii: Radii,
    pub lengths: Option<Spread>,
    /// Length over the larger radius.
    pub slenderness: Option<Spread>,
    pub slenderness_classes: Vec<Class>,
    pub degrees: Vec<DegreeCount>,
    /// The smallest angle between two struts, over the nodes of degree 2 and more.
    pub angles: Option<Spread>,
    pub angle_classes: Vec<Class>,
    /// Connected parts, largest first: one solid each.
    pub components: Vec<Component>,
    pub faults: Vec<Fault>,
    /// Struts whose least cuts do not fit on their length.
    pub cut_conflicts: Vec<CutConflict>,
    /// Struts without a common node whose bodies touch or cross.
    pub overlaps: Vec<Pair>,
    /// Such struts that stay apart, by less than a quarter of the sum of their radii.
    pub near_misses: Vec<Pair>,
    pub repairs: Repairs,
    pub export: Verdict,
    /// What the solid would cost, as if every conflict were resolved.
    pub estimate: Estimate,
}

/// A range of figures, and the place of the least.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    pub least: f64,
    pub median: f64,
    pub most: f64,
    /// Where the least is, such as `struts[17]`.
    pub least_at: String,
}

/// The number of figures below a bound and not below the one before; the last class has no bound.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Class {
    pub below: Option<f64>,
    pub count: usize,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Radii {
    /// Of strut ends.
    pub spread: Option<Spread>,
    /// How many different radii there are.
    pub different: usize,
    /// Struts with different radii at their ends.
    pub tapered: usize,
    /// Nodes where struts of different radii meet.
    pub unequal_nodes: usize,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DegreeCount {
    pub degree: usize,
    pub nodes: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Component {
    pub nodes: usize,
    pub struts: usize,
    /// Independent loops: the genus of the solid.
    pub loops: usize,
    /// The first of its nodes.
    pub first_node: NodeId,
}

#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CutConflict {
    pub strut: StrutId,
    pub a: NodeId,
    pub b: NodeId,
    pub length: f64,
    /// The least lengths that both ends need.
    pub cuts: [f64; 2],
}

impl CutConflict {
    /// The length wanted over the length there is.
    pub fn excess(&self) -> f64 {
        (self.cuts[0] + self.cuts[1]) / self.length
    }
}

/// Two struts without a common node.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Pair {
    pub a: StrutId,
    pub b: StrutId,
    /// Between the axes.
    pub distance: f64,
    /// What the distance has to exceed.
    pub allowed: f64,
    pub at: [f64; 3],
}

/// What the repairs would take away, each alone, with their usual limits.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Repairs {
    /// Nodes that export removes unasked: their two struts are one cylinder or cone.
    pub straight_nodes: usize,
    /// Nodes that `--collapse-chains` removes.
    pub chain_nodes: usize,
    /// Struts and nodes that `--drop-loose` removes.
    pub loose_struts: usize,
    pub loose_nodes: usize,
}

/// What `export` would do, by all that is known before nodes are built.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Verdict {
    /// Nothing here stands against it. Single nodes can still fail.
    pub accepted: bool,
    /// Its exit code: 0, or 2 for bad input.
    pub exit_code: i32,
    pub reasons: Vec<String>,
}

/// Rough: faces and bytes to within a third, time by the machine.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    pub faces: usize,
    pub bytes: f64,
    pub memory_bytes: f64,
    /// On one core; nodes are built on all there are.
    pub cpu_seconds: f64,
}

/// Look at a lattice. `faults` are those of its form, `format` the form's name.
pub fn inspect(input: &Input, format: &str, faults: Vec<Fault>, options: &Options) -> Inspection {
    let (graph, ids) = sound(input);
    let (faults, overlaps) = check::survey(input, faults);
    let whole = Whole::of(input, &graph, &ids);
    let cut_conflicts: Vec<CutConflict> = cut_conflicts(&whole.graph, options.lambda).into_iter().map(|c| whole.original(c)).collect();
    let near = proximity::within(&check::bodies(input, |n| n.0), NEAR).into_iter().filter(|m| m.distance > m.wanted * (1.0 + TOUCHING));
    let components = listed(&graph);
    let verdict = verdict(&faults, overlaps.len(), cut_conflicts.len(), components.len());
    let slenderness = |(k, s): (usize, &Strut)| (graph.length(StrutId(k as u32)) / s.ra.max(s.rb), ids[k]);
    let at_strut = |k: &StrutId| format!("struts[{}]", k.0);
    let by_strut: Vec<(f64, StrutId)> = graph.struts().iter().enumerate().map(slenderness).collect();
    let lengths = (0..ids.len()).map(|k| (graph.length(StrutId(k as u32)), ids[k])).collect();
    let angles = smallest_angles(&graph);
    let used = || graph.used_nodes().map(|n| graph.nodes()[n.index()]);
    let corners = used().reduce(DVec3::min).zip(used().reduce(DVec3::max));
    Inspection {
        format: format.into(),
        name: input.name.clone(),
        nodes: input.nodes.len(),
        struts: input.struts.len(),
        bare_nodes: input.nodes.len() - graph.used_nodes().count(),
        unsound_struts: input.struts.len() - ids.len(),
        bounds: corners.map(|(low, high)| [low.to_array(), high.to_array()]),
        radii: radii(&graph, &ids),
        lengths: spread(lengths, at_strut),
        slenderness_classes: classes(&SLENDERNESS_CLASSES, by_strut.iter().map(|x| x.0)),
        slenderness: spread(by_strut, at_strut),
        degrees: degrees(&graph),
        angle_classes: classes(&ANGLE_CLASSES, angles.iter().map(|x| x.0)),
        angles: spread(angles, |n| format!("nodes[{}]", n.0)),
        components,
        faults,
        cut_conflicts,
        overlaps: overlaps.into_iter().map(Pair::from).collect(),
        near_misses: near.map(Pair::from).collect(),
        repairs: Repairs { straight_nodes: graph.used_nodes().count() - whole.graph.used_nodes().count(), ..repairs(input) },
        export: verdict,
        estimate: estimate(&whole.graph),
    }
}

/// The JSON Schema of an inspection.
pub fn schema() -> String {
    serde_json::to_string_pretty(&schemars::schema_for!(Inspection)).expect("a schema is plain JSON") + "\n"
}

/// The struts for which no cuts fit, in order, after all that `cuts` can negotiate: those that `export` would refuse.
pub fn cut_conflicts(graph: &Graph, lambda: f64) -> Vec<CutConflict> {
    let conflict = |c: cuts::Conflict| {
        let s = &graph.struts()[c.strut.index()];
        CutConflict { strut: c.strut, a: s.a, b: s.b, length: c.length, cuts: c.least }
    };
    cuts::negotiate(graph, lambda).err().unwrap_or_default().into_iter().map(conflict).collect()
}

/// The same as `repair::merge` asks for it.
pub fn fit(lambda: f64) -> impl Fn(&Graph) -> Fit {
    move |graph| Fit { conflicts: cut_conflicts(graph, lambda).iter().map(|c| c.strut).collect(), reach: cuts::reach(graph, lambda) }
}

/// The sound struts with all nodes, and the ids of these struts in the input.
fn sound(input: &Input) -> (Graph, Vec<StrutId>) {
    let (ids, struts) = check::sound_struts(input).unzip();
    // a node of no use is never looked at
    (Graph::new(input.nodes.clone(), struts), ids)
}

/// The graph as export builds it: chains that are one cylinder or cone are one strut.
struct Whole {
    graph: Graph,
    /// Ids in the input.
    nodes: Vec<NodeId>,
    struts: Vec<StrutId>,
}

impl Whole {
    /// Of the sound struts and their ids in the input.
    fn of(input: &Input, graph: &Graph, ids: &[StrutId]) -> Whole {
        match chains::straight(input) {
            None => Whole { graph: graph.clone(), nodes: graph.node_ids().collect(), struts: ids.to_vec() },
            Some((whole, repair)) => {
                let (graph, of_whole) = sound(&whole);
                let (nodes, struts) = repair.origins();
                Whole { graph, nodes, struts: of_whole.iter().map(|k| struts[k.index()]).collect() }
            }
        }
    }

    fn original(&self, c: CutConflict) -> CutConflict {
        CutConflict { strut: self.struts[c.strut.index()], a: self.nodes[c.a.index()], b: self.nodes[c.b.index()], ..c }
    }
}

fn spread<T: Ord + Copy>(mut figures: Vec<(f64, T)>, place: impl Fn(&T) -> String) -> Option<Spread> {
    figures.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let (first, last) = (figures.first()?, figures.last()?);
    Some(Spread { least: first.0, median: figures[figures.len() / 2].0, most: last.0, least_at: place(&first.1) })
}

fn classes(bounds: &[f64], figures: impl Iterator<Item = f64>) -> Vec<Class> {
    let below = bounds.iter().copied().map(Some).chain([None]);
    let mut classes: Vec<Class> = below.map(|below| Class { below, count: 0 }).collect();
    for x in figures {
        classes[bounds.partition_point(|&bound| bound <= x)].count += 1;
    }
    classes
}

fn radii(graph: &Graph, ids: &[StrutId]) -> Radii {
    let ends = graph.struts().iter().zip(ids).flat_map(|(s, &k)| [(s.ra, k), (s.rb, k)]).collect::<Vec<_>>();
    let mut values: Vec<f64> = ends.iter().map(|x| x.0).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let unequal = |&n: &NodeId| graph.arms(n).iter().any(|&arm| graph.radius(arm) != graph.radius(graph.arms(n)[0]));
    Radii {
        different: values.len(),
        tapered: graph.struts().iter().filter(|s| s.ra != s.rb).count(),
        unequal_nodes: graph.used_nodes().filter(unequal).count(),
        spread: spread(ends, |k| format!("struts[{}]", k.0)),
    }
}

fn degrees(graph: &Graph) -> Vec<DegreeCount> {
    let mut of_nodes: Vec<usize> = graph.used_nodes().map(|n| graph.degree(n)).collect();
    of_nodes.sort_unstable();
    of_nodes.chunk_by(|a, b| a == b).map(|same| DegreeCount { degree: same[0], nodes: same.len() }).collect()
}

/// The smallest angle (degrees) at each node of degree 2 and more.
fn smallest_angles(graph: &Graph) -> Vec<(f64, NodeId)> {
    let smallest = |n: NodeId| {
        let along: Vec<DVec3> = graph.arms(n).iter().map(|&arm| (graph.nodes()[graph.far(arm).index()] - graph.nodes()[n.index()]).normalize()).collect();
        let pairs = (0..along.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        let angles = pairs.map(|(i, j)| along[i].cross(along[j]).length().atan2(along[i].dot(along[j])));
        angles.reduce(f64::min).map(|angle| (angle.to_degrees(), n))
    };
    graph.used_nodes().filter_map(smallest).collect()
}

fn listed(graph: &Graph) -> Vec<Component> {
    let parts = components(graph);
    let part = |s: &ComponentSize| Component { nodes: s.nodes, struts: s.struts, loops: s.genus(), first_node: NodeId(u32::MAX) };
    let mut list: Vec<Component> = parts.sizes.iter().map(part).collect();
    for (n, part) in parts.of_node.iter().enumerate() {
        if let Some(ComponentId(part)) = part {
            let first = &mut list[*part as usize].first_node;
            *first = NodeId(n as u32).min(*first);
        }
    }
    list.sort_by_key(|c| (std::cmp::Reverse(c.struts), c.first_node));
    list
}

fn repairs(input: &Input) -> Repairs {
    let gone = |repair: &repair::Repair| (repair.before.nodes - repair.after.nodes, repair.before.struts - repair.after.struts);
    let (chain_nodes, _) = gone(&chains::collapse(input, chains::STRAIGHT).1);
    let (loose_nodes, loose_struts) = gone(&loose::drop_loose(input, loose::LOOSE).1);
    Repairs { chain_nodes, loose_struts, loose_nodes, ..Repairs::default() }
}

fn verdict(faults: &[Fault], overlaps: usize, cuts: usize, solids: usize) -> Verdict {
    let mut reasons = Vec::new();
    let mut stands_against = |count: usize, what: &str| {
        if count > 0 {
            reasons.push(format!("{count} {what}"));
        }
    };
    stands_against(faults.len(), "faults in the input");
    stands_against(overlaps, "pairs of struts overlap (kept with --overlaps keep)");
    stands_against(cuts, "struts are too short for any cuts (see --on-conflict)");
    let accepted = reasons.is_empty();
    if accepted {
        reasons.push(format!("{solids} solid{}", if solids == 1 { "" } else { "s" }));
    }
    let exit_code = if accepted {
        0
    } else if faults.is_empty() && overlaps == 0 {
        3
    } else {
        2
    };
    Verdict { accepted, exit_code, reasons }
}

/// Estimated memory at the peak, bytes, with all skins in a file.
fn without_skins(faces: f64) -> f64 {
    PROGRAM + (faces * UNDER_WAY_PER_FACE).min(MOST_UNDER_WAY) + faces * TABLES_PER_FACE
}

/// How many bytes of skins may stay in memory if the whole run is to take no more than `most` bytes; else how many bytes it will take about without any.
pub fn room_for_skins(graph: &Graph, most: f64) -> Result<usize, f64> {
    let least = without_skins(estimate(graph).faces as f64);
    if least <= most { Ok(((most - least) / PER_BYTE_OF_SKINS) as usize) } else { Err(least) }
}

fn estimate(graph: &Graph) -> Estimate {
    let of_node = |n: NodeId| match graph.degree(n) {
        1 => (0, 1),
        2 => (2 * PATCHES_PER_END_OF_TWO, 0),
        degree => (degree * PATCHES_PER_END, 0),
    };
    let (patches, caps) = graph.used_nodes().map(of_node).fold((0, 0), |sum, x| (sum.0 + x.0, sum.1 + x.1));
    let faces = graph.struts().len() + patches + caps;
    Estimate {
        faces,
        bytes: faces as f64 * BYTES_PER_FACE,
        memory_bytes: without_skins(faces as f64) + PER_BYTE_OF_SKINS * (faces as f64 * SKINS_PER_FACE).min(SKINS_IN_MEMORY as f64),
        cpu_seconds: patches as f64 * SECONDS_PER_PATCH,
    }
}

impl From<NearMiss> for Pair {
    fn from(m: NearMiss) -> Pair {
        Pair { a: m.a, b: m.b, distance: m.distance, allowed: m.wanted, at: m.at.to_array() }
    }
}
