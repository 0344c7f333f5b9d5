//! The one file that knows the order: graph ▶ films ▶ skins ▶ solids ▶ checks ▶ STEP text and report.

use crate::brep::{self, AssembleOptions, BrepError, Crossing, Instance, Model, Other, QualityLimits};
use crate::cuts::{Cuts, Means, Shrunk};
use crate::error::{Error, Fault, Note};
use crate::graph::check::{self, Overlaps};
use crate::graph::proximity::{self, NearMiss};
use crate::graph::repair::{Repair, chains};
use crate::graph::{self, Graph, Input, Lattice};
use crate::ids::{NodeId, StrutId};
use crate::ladder::Rung;
use crate::options::{Divide, Options};
use crate::patch::Shelved;
use crate::patch::figures::Figures;
use crate::report::{self, BlockFile, ChangedCuts, Counts, Hashed, Lowered, Manifest, Quality, Report, Rungs, ShrunkStrut, Solid, StageTime, Valley, Worst};
use crate::settle::{Kept, Settled, Settling};
use crate::step;
use glam::DVec3;
use sha2::{Digest, Sha256};
use std::io::Write;
use std::ops::Range;
use std::time::Instant;

/// Samples along each patch side in the checks before writing.
const CHECK_SAMPLES: usize = 5;

/// Largest jumps of the normal that may be written, degrees: rims, inside nodes.
const MOST_RIM_JUMP: f64 = 0.05;
const MOST_INNER_JUMP: f64 = 0.1;

/// Largest gap that may be written, in strut radii. The construction leaves round-off.
const MOST_GAP: f64 = 1e-9;
/// Gap that may be written besides, in steps of the doubles at the largest coordinate. Measured: below one step 1e6 mm from the origin.
const GAP_STEPS: f64 = 4.0;

/// Told about progress, from any thread.
pub trait Progress: Sync {
    /// A stage begins; `total` steps of `unit`, 0 where the number is not known.
    fn stage(&self, name: &str, total: u64, unit: &str);
    fn advance(&self, steps: u64);
}

/// No progress shown.
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str, _: u64, _: &str) {}
    fn advance(&self, _: u64) {}
}

/// A solid that passed every check, ready to be written, and its report (without the writing).
pub struct Solved {
    pub model: Model,
    /// Where the model's solids stand, if they are the units of an assembly.
    pub instances: Vec<Instance>,
    /// Which of the model's solids each block has, if it is divided into blocks, and what they hold together.
    pub blocks: Vec<(Range<usize>, brep::Measure)>,
    facts: step::Facts,
    pub report: Report,
}

/// The part of a lattice inside a box (mm): cut struts become free ends. Overlaps are judged in the part alone.
pub fn crop(lattice: &Lattice, [min, max]: [DVec3; 2], overlaps: Overlaps) -> Result<Lattice, Error> {
    let part = graph::crop::crop(&lattice.graph, min, max).graph;
    if part.struts().is_empty() {
        return Err(Error::BadInput(vec![Fault::new(
            "--crop",
            "a box in which no strut is left",
            "a box around at least one node and more than a radius of its struts",
        )]));
    }
    let (kept, all) = (part.struts().len(), lattice.graph.struts().len());
    let mut notes = vec![Note::new("document", format!("cropped: {kept} of {all} struts kept"))];
    let misses = proximity::among(&check::bodies(&input(&part), |n| n.0));
    match overlaps {
        Overlaps::Refuse => Error::unless_empty(misses.iter().map(NearMiss::fault).collect())?,
        Overlaps::Keep => notes.extend(misses.iter().map(NearMiss::note)),
        Overlaps::Leave => {}
    }
    Ok(Lattice { name: lattice.name.clone(), graph: part, notes })
}

/// The lattice without the nodes that need no skin: where two struts are one cylinder or cone, they become one strut. The record of what changed, which is
/// among the notes as well; none where there is no such node.
pub fn straighten(lattice: Lattice) -> (Lattice, Option<Repair>) {
    let Some((whole, repair)) = chains::straight(&input(&lattice.graph)) else { return (lattice, None) };
    let Lattice { name, mut notes, .. } = lattice;
    notes.push(repair.note());
    (Lattice { name, graph: Graph::new(whole.nodes, whole.struts), notes }, Some(repair))
}

fn input(graph: &Graph) -> Input {
    Input { name: None, nodes: graph.nodes().to_vec(), struts: graph.struts().to_vec() }
}

/// From a checked lattice to checked solids.
pub fn solve(lattice: &Lattice, options: &Options, progress: &dyn Progress) -> Result<Solved, Error> {
    let nodes = lattice.graph.used_nodes().count();
    if let Divide::Blocks(count) = options.divide
        && !(1..=nodes).contains(&count)
    {
        return Err(Error::BadInput(vec![Fault::new("--blocks", format!("{count} for {nodes} nodes"), "at least 1, and at most the number of nodes")]));
    }
    let mut clock = Clock::default();
    let begin = |nodes: u64| progress.stage("nodes", nodes, "nodes");
    let mut settling = clock.time("nodes", || Settling::new(&lattice.graph, options))?;
    let (Settled { graph, cuts, shrunk, built }, (model, instances, blocks), crossings) = loop {
        let settled = clock.time("nodes", || settling.settle(&begin, &|| progress.advance(1)))?;
        progress.stage("solids", 0, "");
        let skins: Vec<Option<Shelved>> = settled.built.iter().map(|b| b.as_ref().map(|b| b.skin.clone())).collect();
        let assemble = AssembleOptions { caps: options.caps };
        let put_together = || match options.divide {
            Divide::Not => brep::assemble(&settled.graph, &skins, &assemble).map(|model| (model, vec![], vec![])),
            Divide::Nodes => brep::units(&settled.graph, &skins, &assemble).map(|(model, instances)| (model, instances, vec![])),
            Divide::Blocks(count) => brep::blocks(&settled.graph, &skins, &assemble, count).map(|(model, blocks)| (model, vec![], blocks)),
        };
        let made = clock.time("assembly", put_together).map_err(internal)?;
        let crossings = clock.time("checks", || match options.divide {
            Divide::Nodes => brep::unit_crossings(&settled.graph, &made.0, &made.1),
            Divide::Not | Divide::Blocks(_) => brep::crossings(&made.0),
        });
        if !settling.part(&meetings(&crossings)) {
            break (settled, made, crossings);
        }
    };
    let graph = &graph;
    let facts_of_nodes: Vec<Option<NodeFacts>> = built.iter().map(|b| b.as_deref().map(NodeFacts::of)).collect();
    drop((settling, built));

    progress.stage("checks", 0, "");
    let rungs = rungs(graph, &facts_of_nodes);
    let sharp: Vec<NodeId> = rungs.sharp.iter().map(|l| l.node).collect();
    let radius = graph.struts().iter().map(|s| s.ra.max(s.rb)).fold(0.0, f64::max);
    let reach = graph.nodes().iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let most_gap = MOST_GAP * radius + GAP_STEPS * f64::EPSILON * reach;
    let (quality, kept) = clock.time("checks", || {
        brep::check_topology(&model).map_err(internal)?;
        let quality = brep::quality(&model, CHECK_SAMPLES, &sharp);
        let limits = QualityLimits { rim_jump_deg: MOST_RIM_JUMP, inner_jump_deg: MOST_INNER_JUMP, gap_mm: most_gap, facing: 0.0 };
        quality.check(&limits).map_err(internal)?;
        Ok((quality, clearance(&crossings, options.overlaps)?))
    })?;
    let measures = clock.time("measures", || model.solids.iter().map(brep::measure).collect::<Result<Vec<_>, _>>().map_err(|e| internal(vec![e])))?;
    let solids = model.solids.iter().zip(&measures).map(|(solid, m)| solid_facts(solid, m)).collect();
    let at_place = |instance: &Instance| {
        let unit = measures[instance.unit as usize];
        brep::Measure { centroid: unit.centroid + instance.at, ..unit }
    };
    let blocks = blocks.into_iter().map(|solids| (solids.clone(), brep::measure_total(measures[solids].iter().copied()))).collect();
    let measure = match options.divide {
        Divide::Nodes => brep::measure_total(instances.iter().map(at_place)),
        Divide::Not | Divide::Blocks(_) => brep::measure_total(measures.iter().copied()),
    };
    let worst = |w: &brep::Worst| Worst { value: w.value, place: w.to_string() };
    let shape = shape_facts(graph, &facts_of_nodes);
    let fit = fit_facts(graph, &facts_of_nodes, options.tolerance);
    let report = Report {
        program: concat!("lattice-brep ", env!("CARGO_PKG_VERSION")).into(),
        counts: counts(&model),
        instances: instances.len(),
        solids,
        volume_mm3: measure.volume,
        area_mm2: measure.area,
        centroid_mm: measure.centroid.to_array(),
        added_mm3: shape.added,
        removed_mm3: shape.removed,
        concave_radius_mm: shape.valley,
        valleys: if options.blend().is_some() { shape.valleys } else { vec![] },
        quality: Quality {
            inner_jump_deg: worst(&quality.inner_jump_deg),
            rim_jump_deg: worst(&quality.rim_jump_deg),
            gap_mm: worst(&quality.gap_mm),
            facing: worst(&quality.facing),
            deviation_radii: fit.farthest,
            mean_deviation_radii: fit.mean,
            isoline_deg: fit.isoline,
            curvature_jump: fit.jump,
            over_tolerance: fit.over,
        },
        rungs,
        cuts: cuts_report(&cuts, &shrunk),
        changes: lattice.notes.iter().cloned().chain(kept).collect(),
        repairs: Vec::new(), // made before: for the caller to add
        bytes: 0,
        stages: clock.stages,
    };
    let facts = step::Facts { measure, gap_mm: quality.gap_mm.value };
    Ok(Solved { model, instances, blocks, facts, report })
}

/// Write the solids as STEP, all in one file; adds size and time to the report.
pub fn write(solved: &mut Solved, options: &Options, out: &mut (dyn Write + Send), progress: &dyn Progress) -> std::io::Result<()> {
    progress.stage("writing", 0, "");
    let start = Instant::now();
    let mut out = Counting { inner: out, bytes: 0 };
    let Solved { model, instances, facts, .. } = &*solved;
    let written = match options.divide {
        Divide::Nodes => step::write_assembly(model, instances, facts, &options.step, &mut out),
        Divide::Not | Divide::Blocks(_) => step::write(model, facts, &options.step, &mut out),
    };
    written.map_err(std::io::Error::other)?;
    let bytes = out.bytes;
    tell_written(&mut solved.report, bytes, start);
    Ok(())
}

/// The product in the file of a block.
fn block_product(options: &Options, block: usize) -> String {
    format!("{}_block_{}", options.step.product, block + 1)
}

/// Write one of the blocks as a STEP file of this name; adds size and time to the report.
pub fn write_block(solved: &mut Solved, block: usize, file: &str, options: &Options, out: &mut (dyn Write + Send)) -> std::io::Result<BlockFile> {
    let start = Instant::now();
    let mut out = Hashing::new(out);
    let (solids, measure) = &solved.blocks[block];
    let (range, solids) = (solids.clone(), &solved.model.solids[solids.clone()]);
    let step = step::StepOptions { file_name: file.into(), product: block_product(options, block), ..options.step.clone() };
    let facts = step::Facts { measure: *measure, ..solved.facts };
    step::write_some(&solved.model, range, &facts, &step, &mut out).map_err(std::io::Error::other)?;
    let half_struts = solids.iter().map(brep::Solid::halved).sum();
    let written = BlockFile {
        file: out.told(file),
        solids: solids.len(),
        nodes: solids.iter().map(|s| s.own).sum(),
        struts: solids.iter().map(|s| s.struts.len()).sum::<usize>() - half_struts,
        half_struts,
        volume_mm3: measure.volume,
        area_mm2: measure.area,
    };
    tell_written(&mut solved.report, written.file.bytes, start);
    Ok(written)
}

/// Write the assembly that refers to the blocks' files; adds size and time to the report. What is in all files together.
pub fn write_master(solved: &mut Solved, blocks: Vec<BlockFile>, options: &Options, out: &mut (dyn Write + Send)) -> std::io::Result<Manifest> {
    let start = Instant::now();
    let mut out = Hashing::new(out);
    let external = |(k, block): (usize, &BlockFile)| step::External { file: block.file.file.clone(), product: block_product(options, k) };
    let files: Vec<step::External> = blocks.iter().enumerate().map(external).collect();
    step::write_master(&files, &solved.facts, &options.step, &mut out).map_err(std::io::Error::other)?;
    let master = out.told(&options.step.file_name);
    tell_written(&mut solved.report, master.bytes, start);
    let sum = |of: fn(&BlockFile) -> usize| blocks.iter().map(of).sum::<usize>();
    let Report { program, volume_mm3, area_mm2, .. } = &solved.report;
    let (solids, nodes) = (sum(|b| b.solids), sum(|b| b.nodes));
    let struts = sum(|b| b.struts) + sum(|b| b.half_struts) / 2;
    Ok(Manifest { program: program.clone(), master, solids, nodes, struts, volume_mm3: *volume_mm3, area_mm2: *area_mm2, blocks })
}

fn tell_written(report: &mut Report, bytes: u64, start: Instant) {
    report.bytes += bytes;
    let seconds = start.elapsed().as_secs_f64();
    match report.stages.iter_mut().find(|s| s.stage == "writing") {
        Some(before) => before.seconds += seconds,
        None => report.stages.push(StageTime { stage: "writing".into(), seconds }),
    }
}

fn cuts_report(cuts: &Cuts, shrunk: &[Shrunk]) -> report::Cuts {
    let count = |means| cuts.means.iter().filter(|&&m| m == means).count();
    let changed = |k: usize| ChangedCuts { strut: StrutId(k as u32), means: cuts.means[k].name().into(), before_mm: cuts.preferred[k], after_mm: cuts.at[k] };
    report::Cuts {
        preferred: count(Means::Preferred),
        smaller_lambda: count(Means::SmallerLambda),
        unequal_cuts: count(Means::UnequalCuts),
        unequal_sharing: count(Means::UnequalSharing),
        changed: (0..cuts.at.len()).filter(|&k| cuts.means[k] != Means::Preferred).map(changed).collect(),
        shrunk: shrunk.iter().map(|s| ShrunkStrut { strut: s.strut, before_mm: s.before, after_mm: s.after, volume_mm3: s.volume }).collect(),
        shrunk_volume_mm3: shrunk.iter().fold(0.0, |sum, s| sum + s.volume), // an empty `sum` is -0
    }
}

/// The nodes whose skins meet something, and where (mm).
fn meetings(crossings: &[Crossing]) -> Vec<(NodeId, DVec3)> {
    let both = |c: &Crossing| {
        let other = if let Other::Node(other) = c.other { Some((other, c.at)) } else { None };
        std::iter::once((c.node, c.at)).chain(other)
    };
    crossings.iter().flat_map(both).collect()
}

/// Skins that meet what they should not: the reasons why this cannot be built, or notes where overlaps are kept.
fn clearance(crossings: &[Crossing], overlaps: Overlaps) -> Result<Vec<Note>, Error> {
    if overlaps == Overlaps::Refuse && !crossings.is_empty() {
        return Err(Error::CannotBuild { reasons: crossings.iter().map(|&c| BrepError::Crossing(c).to_string()).collect() });
    }
    Ok(crossings.iter().map(|c| Note::new(format!("nodes[{}]", c.node.0), format!("{c}: kept"))).collect())
}

/// What the report keeps of a built node.
struct NodeFacts {
    rung: Rung,
    reasons: Vec<String>,
    deviation: f64,
    mean_deviation: f64,
    /// The patch with the largest distance: its arm, and its number there, from 1.
    farthest: (usize, u32),
    isoline: f64,
    figures: Figures,
}

impl NodeFacts {
    fn of(built: &Kept) -> NodeFacts {
        let Kept { rung, quality: q, figures, reasons, .. } = built;
        NodeFacts {
            rung: *rung,
            reasons: reasons.clone(),
            deviation: q.deviation,
            mean_deviation: q.mean_deviation,
            farthest: q.farthest,
            isoline: q.isoline,
            figures: *figures,
        }
    }
}

fn rungs(graph: &Graph, facts: &[Option<NodeFacts>]) -> Rungs {
    let mut rungs = Rungs::default();
    for (n, fact) in facts.iter().enumerate() {
        let Some(fact) = fact else { continue };
        let node = NodeId(n as u32);
        let lowered = || Lowered { node, degree: graph.degree(node), reasons: fact.reasons.clone() };
        match fact.rung {
            Rung::End => {}
            Rung::SoapFilm => rungs.soap_film += 1,
            Rung::NoBall => rungs.no_ball.push(lowered()),
            Rung::LevelSet => rungs.level_set.push(lowered()),
            Rung::MoreControl => rungs.more_control.push(lowered()),
            Rung::Sharp => rungs.sharp.push(lowered()),
        }
    }
    rungs
}

fn solid_facts(solid: &brep::Solid, measure: &brep::Measure) -> Solid {
    Solid { first_node: solid.nodes[0], nodes: solid.own, struts: solid.struts.len(), genus: solid.genus(), volume_mm3: measure.volume }
}

struct ShapeFacts {
    /// None where nothing is concave.
    valley: Option<Worst>,
    valleys: Vec<Valley>,
    added: f64,
    removed: f64,
}

/// From node units to mm.
fn shape_facts(graph: &Graph, facts: &[Option<NodeFacts>]) -> ShapeFacts {
    let mut out = ShapeFacts { valley: None, valleys: vec![], added: 0.0, removed: 0.0 };
    for (n, fact) in facts.iter().enumerate() {
        let Some(NodeFacts { rung, figures, .. }) = fact else { continue };
        let unit = graph.largest_radius(NodeId(n as u32));
        out.added += figures.added * unit.powi(3);
        out.removed += figures.removed * unit.powi(3);
        if *rung == Rung::Sharp || figures.concave == 0.0 {
            continue;
        }
        let radius = unit / figures.concave;
        out.valleys.push(Valley { node: NodeId(n as u32), radius_mm: radius });
        if radius < out.valley.as_ref().map_or(f64::INFINITY, |w| w.value) {
            out.valley = Some(Worst { value: radius, place: format!("node_{n}") });
        }
    }
    out
}

struct FitFacts {
    farthest: Worst,
    mean: f64,
    over: usize,
    isoline: Worst,
    jump: Worst,
}

fn fit_facts(graph: &Graph, facts: &[Option<NodeFacts>], tolerance: f64) -> FitFacts {
    let nowhere = |value: f64| Worst { value, place: "nowhere".into() };
    let mut out = FitFacts { farthest: nowhere(0.0), mean: 0.0, over: 0, isoline: nowhere(90.0), jump: nowhere(0.0) };
    let mut count = 0.0;
    for (n, fact) in facts.iter().enumerate() {
        let Some(fact) = fact.as_ref().filter(|f| f.rung != Rung::End && f.rung != Rung::Sharp) else { continue };
        let node = NodeId(n as u32);
        let at_node = |value: f64| Worst { value, place: format!("node_{n}") };
        if fact.deviation > out.farthest.value {
            let (arm, number) = fact.farthest;
            let label = brep::Label::Patch { node, strut: graph.arms(node)[arm].strut, number };
            out.farthest = Worst { value: fact.deviation, place: label.to_string() };
        }
        if fact.isoline < out.isoline.value {
            out.isoline = at_node(fact.isoline);
        }
        if fact.figures.jump > out.jump.value {
            out.jump = at_node(fact.figures.jump);
        }
        out.mean += fact.mean_deviation;
        out.over += usize::from(fact.deviation > tolerance);
        count += 1.0;
    }
    out.mean /= f64::max(count, 1.0);
    out
}

fn counts(model: &Model) -> Counts {
    let mut counts = Counts { components: model.solids.len(), ..Counts::default() };
    for solid in &model.solids {
        counts.nodes += solid.own;
        counts.genus += solid.genus();
        counts.struts += solid.struts.len();
        counts.circles += solid.circles.len();
        let c = brep::Counts::of(solid);
        counts.faces += c.faces;
        counts.edges += c.edges;
        counts.vertices += c.vertices;
        let cylinders = solid.slopes.iter().filter(|&&slope| slope == 0.0).count();
        let caps = solid.cap_count();
        counts.cylinders += cylinders;
        counts.cones += solid.struts.len() - cylinders;
        counts.caps += caps;
        counts.patches += c.faces - solid.struts.len() - caps;
    }
    counts
}

/// Our own checks failed on our own work.
fn internal(faults: Vec<BrepError>) -> Error {
    Error::Internal(faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
}

#[derive(Default)]
struct Clock {
    stages: Vec<StageTime>,
}

impl Clock {
    fn time<T>(&mut self, stage: &str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let out = work();
        let seconds = start.elapsed().as_secs_f64();
        match self.stages.iter_mut().find(|s| s.stage == stage) {
            Some(before) => before.seconds += seconds,
            None => self.stages.push(StageTime { stage: stage.into(), seconds }),
        }
        out
    }
}

struct Counting<'a> {
    inner: &'a mut (dyn Write + Send),
    bytes: u64,
}

impl Write for Counting<'_> {
    fn write(&mut self, buf: &[u8]) -> std::io::Result<usize> {
        let n = self.inner.write(buf)?;
        self.bytes += n as u64;
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// Takes the SHA-256 of what it hands on.
struct Hashing<'a> {
    inner: Counting<'a>,
    hash: Sha256,
}

impl<'a> Hashing<'a> {
    fn new(inner: &'a mut (dyn Write + Send)) -> Self {
        Hashing { inner: Counting { inner, bytes: 0 }, hash: Sha256::new() }
    }

    fn told(self, file: &str) -> Hashed {
        let sha256 = self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Hashed { file: file.into(), sha256, bytes: self.inner.bytes }
    }
}

impl Write for Hashing<'_> {
    fn write(&mut self, buf: &[u8]) -> std::io::Result<usize> {
        let n = self.inner.write(buf)?;
        self.hash.update(&buf[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}
