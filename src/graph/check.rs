//! Checks of a graph's content. Each checker looks at one invariant and lists all its faults.
//! A later checker passes over what an earlier one has refused, so that one fault is not told twice.

use super::proximity::{self, Body, NearMiss};
use super::repair::chains;
use super::{Graph, Input, Lattice, Strut};
use crate::error::{Error, Fault, Note};
use crate::ids::{NodeId, StrutId};
use glam::DVec3;
use std::collections::{BTreeMap, HashSet};

/// Largest coordinate (mm): a thousand kilometres. Reason: beyond 1e150 squares overflow; no part is near either. Guessed.
const LARGEST_COORDINATE: f64 = 1e12;
/// Smallest radius (mm): a picometre. Reason: below 1e-150 squares vanish; no part is near either. Guessed.
const SMALLEST_RADIUS: f64 = 1e-9;
/// Nodes closer than this are in one place (as a fraction of the bounding box's diagonal). Reason: above the round-off of
/// coordinates printed with ten digits, far below any strut. Guessed.
const ONE_PLACE: f64 = 1e-9;
/// And closer than this in any case (mm). Reason: below it squares of lengths vanish in doubles.
const LEAST_PLACE: f64 = 1e-150;
/// Radii that differ by less are taken as equal (relative). Reason: round-off of unit conversion is 2e-16. Guessed.
const EQUAL_RADII: f64 = 1e-12;
/// Coarsest step of a coordinate (as a fraction of the smallest radius). Reason: a lattice so far from the origin
/// that its doubles are coarser cannot have rims in the right place; STEP files are written to about 1e-7. Guessed.
const COARSEST_STEP: f64 = 1e-6;

/// What to do with struts that come closer than their radii without sharing a node, and with skins that meet what is not theirs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlaps {
    /// Each is a fault.
    #[default]
    Refuse,
    /// Each is a note: the solid crosses itself there.
    Keep,
    /// Nothing is said of them: they are settled later, with the cuts.
    Leave,
}

/// The checked lattice, or all faults: those of form (found by the reader) and those of content.
pub fn admit(input: Input, faults: Vec<Fault>, overlaps: Overlaps) -> Result<Lattice, Error> {
    let mut notes = Vec::new();
    let (mut faults, misses) = survey(&input, faults);
    match overlaps {
        Overlaps::Refuse => faults.extend(misses.iter().map(NearMiss::fault)),
        Overlaps::Keep => notes.extend(misses.iter().map(NearMiss::note)),
        Overlaps::Leave => {}
    }
    Error::unless_empty(faults)?;
    let Input { name, nodes, mut struts } = input;
    notes.extend(level_radii(&mut struts));
    let graph = Graph::new(nodes, struts);
    let bare = graph.node_ids().filter(|&n| graph.degree(n) == 0);
    notes.extend(bare.map(|n| Note::new(format!("nodes[{}]", n.0), "has no strut: left out")));
    Ok(Lattice { name, graph, notes })
}

/// The faults of form and all those of content, and apart from them the struts that come too close.
pub fn survey(input: &Input, mut faults: Vec<Fault>) -> (Vec<Fault>, Vec<NearMiss>) {
    if !faults.is_empty() && input.nodes.is_empty() {
        return (faults, Vec::new());
    }
    let told: HashSet<String> = faults.iter().map(|f| f.path.clone()).collect();
    let (content, misses) = inspect(input);
    faults.extend(content.into_iter().filter(|f| !within(&f.path, &told)));
    (faults, misses)
}

/// All faults of the content.
pub fn check(input: &Input) -> Vec<Fault> {
    let (mut faults, misses) = inspect(input);
    faults.extend(misses.iter().map(NearMiss::fault));
    faults
}

/// All faults of the content, but for the struts that come too close: those apart.
fn inspect(input: &Input) -> (Vec<Fault>, Vec<NearMiss>) {
    let mut faults = Vec::new();
    empty(input, &mut faults);
    coordinates(&input.nodes, &mut faults);
    let apart = (ONE_PLACE * size(&input.nodes)).max(LEAST_PLACE);
    let place = places(&input.nodes, apart, &mut faults);
    ends(input, apart, &place, &mut faults);
    radii(&input.struts, &mut faults);
    resolution(input, &mut faults);
    let misses = proximity::among(&bodies(input, |n| place[n.index()]));
    (faults, misses)
}

/// The path, or a path that contains it, has been told already.
fn within(path: &str, told: &HashSet<String>) -> bool {
    told.contains(path) || path.match_indices(['.', '[']).any(|(end, _)| told.contains(&path[..end]))
}

/// Diagonal of the bounding box of all usable nodes (mm).
fn size(nodes: &[DVec3]) -> f64 {
    let usable = || nodes.iter().copied().filter(|p| is_usable(*p));
    let (low, high) = (usable().reduce(DVec3::min), usable().reduce(DVec3::max));
    low.zip(high).map_or(0.0, |(low, high)| low.distance(high))
}

pub(super) fn is_usable(p: DVec3) -> bool {
    p.is_finite() && p.abs().max_element() <= LARGEST_COORDINATE
}

/// Invariant: there is a node and a strut.
fn empty(input: &Input, faults: &mut Vec<Fault>) {
    if input.nodes.is_empty() {
        faults.push(Fault::new("nodes", "no node", "at least two"));
    }
    if input.struts.is_empty() {
        faults.push(Fault::new("struts", "no strut", "at least one"));
    }
}

/// Invariant: coordinates are finite, and not so large that their squares overflow.
fn coordinates(nodes: &[DVec3], faults: &mut Vec<Fault>) {
    for (k, p) in nodes.iter().enumerate().filter(|(_, p)| !is_usable(**p)) {
        for (axis, x) in p.to_array().into_iter().enumerate() {
            let path = || format!("nodes[{k}][{axis}]");
            if !x.is_finite() {
                faults.push(Fault::new(path(), x.to_string(), "a finite number"));
            } else if x.abs() > LARGEST_COORDINATE {
                faults.push(Fault::new(path(), format!("{x:e} mm"), format!("at most {LARGEST_COORDINATE:e} mm")));
            }
        }
    }
}

/// Invariant: no two nodes are in one place. Returns the place of each node: the first node that is there.
///
/// Nodes are sorted along x and parted at every gap wider than `apart` (mm), each part again along y, then z, until no axis
/// parts it. So a chain of nodes, each in the place of the next, is one place.
fn places(nodes: &[DVec3], apart: f64, faults: &mut Vec<Fault>) -> Vec<u32> {
    let mut place: Vec<u32> = (0..nodes.len() as u32).collect();
    let usable: Vec<u32> = place.iter().copied().filter(|&n| is_usable(nodes[n as usize])).collect();
    let mut todo = vec![(usable, 0, 0)];
    while let Some((mut group, axis, unparted)) = todo.pop() {
        if group.len() < 2 {
            continue;
        }
        if unparted == 3 {
            let first = *group.iter().min().expect("a group of two or more");
            group.iter().for_each(|&n| place[n as usize] = first);
            continue;
        }
        let x = |n: u32| nodes[n as usize][axis];
        group.sort_unstable_by(|&m, &n| x(m).total_cmp(&x(n)).then(m.cmp(&n)));
        let parts: Vec<&[u32]> = group.chunk_by(|&m, &n| x(n) - x(m) <= apart).collect();
        let unparted = if parts.len() == 1 { unparted + 1 } else { 1 };
        todo.extend(parts.iter().map(|part| (part.to_vec(), (axis + 1) % 3, unparted)));
    }
    for (n, &first) in place.iter().enumerate().filter(|&(n, &first)| n as u32 != first) {
        let distance = nodes[n].distance(nodes[first as usize]);
        let found = format!("the place of nodes[{first}] ({distance:e} mm apart)");
        faults.push(Fault::new(format!("nodes[{n}]"), found, format!("each node in a place of its own (more than {apart:e} mm apart)")));
    }
    place
}

/// Invariants: both ends are nodes; they differ; the strut has a length; no other strut joins the same nodes.
fn ends(input: &Input, apart: f64, place: &[u32], faults: &mut Vec<Fault>) {
    let count = input.nodes.len();
    let mut first_between: BTreeMap<(NodeId, NodeId), usize> = BTreeMap::new();
    for (k, s) in input.struts.iter().enumerate() {
        let mut in_range = true;
        for (end, node) in [("a", s.a), ("b", s.b)] {
            if node.index() >= count {
                in_range = false;
                faults.push(Fault::new(format!("struts[{k}].{end}"), node.0.to_string(), format!("a node index below {count}")));
            }
        }
        if !in_range {
            continue;
        }
        let (a, b) = (s.a.min(s.b), s.a.max(s.b));
        if a == b {
            faults.push(Fault::new(format!("struts[{k}]"), format!("both ends at nodes[{}]", a.0), "two different nodes"));
            continue;
        }
        if place[a.index()] == place[b.index()] {
            let length = input.nodes[a.index()].distance(input.nodes[b.index()]);
            let found = format!("length {length:e} mm between nodes[{}] and nodes[{}]", s.a.0, s.b.0);
            faults.push(Fault::new(format!("struts[{k}]"), found, format!("a length above {apart:e} mm")));
        }
        let first = *first_between.entry((a, b)).or_insert(k);
        if first != k {
            let found = format!("the same nodes {} and {} as struts[{first}]", a.0, b.0);
            faults.push(Fault::new(format!("struts[{k}]"), found, "at most one strut between two nodes"));
        }
    }
}

pub(super) fn is_radius(r: f64) -> bool {
    r.is_finite() && r >= SMALLEST_RADIUS
}

/// Invariant: radii are finite and positive.
fn radii(struts: &[Strut], faults: &mut Vec<Fault>) {
    for (k, s) in struts.iter().enumerate() {
        for (end, r) in [("ra", s.ra), ("rb", s.rb)] {
            let path = || format!("struts[{k}].{end}");
            if !r.is_finite() || r <= 0.0 {
                faults.push(Fault::new(path(), r.to_string(), "a radius > 0"));
            } else if r < SMALLEST_RADIUS {
                faults.push(Fault::new(path(), format!("{r:e} mm"), format!("a radius of at least {SMALLEST_RADIUS:e} mm")));
            }
        }
    }
}

/// Radii equal but for round-off become equal in all bits: the first one's in the input. Returns what it changed.
fn level_radii(struts: &mut [Strut]) -> Vec<Note> {
    let ends = |struts: &[Strut]| -> Vec<f64> { struts.iter().flat_map(|s| [s.ra, s.rb]).collect() };
    let radii = ends(struts);
    let mut order: Vec<usize> = (0..radii.len()).collect();
    order.sort_by(|&a, &b| radii[a].total_cmp(&radii[b]).then(a.cmp(&b)));
    let mut notes = Vec::new();
    for equal in order.chunk_by(|&a, &b| radii[b] - radii[a] <= EQUAL_RADII * radii[b]) {
        let r = radii[*equal.iter().min().expect("chunks are not empty")];
        for &end in equal.iter().filter(|&&end| radii[end] != r) {
            let s = &mut struts[end / 2];
            let (name, own) = if end % 2 == 0 { ("ra", &mut s.ra) } else { ("rb", &mut s.rb) };
            notes.push((end, Note::new(format!("struts[{}].{name}", end / 2), format!("{own} mm differs by round-off: taken as {r} mm"))));
            *own = r;
        }
    }
    notes.sort_by_key(|n| n.0);
    notes.into_iter().map(|n| n.1).collect()
}

/// Invariant: the step between neighbouring doubles at the largest coordinate is small against the smallest radius.
fn resolution(input: &Input, faults: &mut Vec<Fault>) {
    let reach = input.nodes.iter().filter(|p| is_usable(**p)).map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let radii = input.struts.iter().flat_map(|s| [s.ra, s.rb]).filter(|r| is_radius(*r));
    let smallest = radii.fold(f64::INFINITY, f64::min);
    let step = reach * f64::EPSILON;
    if step > COARSEST_STEP * smallest {
        let found = format!("coordinates up to {reach:e} mm, where doubles are {step:e} mm apart");
        let wanted = format!("at most {:e} mm for a radius of {smallest} mm: move the lattice near the origin", COARSEST_STEP * smallest);
        faults.push(Fault::new("nodes", found, wanted));
    }
}

/// The struts that have two places, a length and radii, with their ids.
pub fn sound_struts(input: &Input) -> impl Iterator<Item = (StrutId, Strut)> {
    let usable = |n: NodeId| input.nodes.get(n.index()).copied().filter(|&p| is_usable(p));
    let sound = move |s: &Strut| is_radius(s.ra) && is_radius(s.rb) && usable(s.a).zip(usable(s.b)).is_some_and(|(p, q)| p != q);
    input.struts.iter().enumerate().filter(move |(_, s)| sound(s)).map(|(k, &s)| (StrutId(k as u32), s))
}

/// The bodies of the sound struts whose ends are in two places, by the place of each node. Struts that export makes one (`chains::straight`) are one body,
/// by the name of the first: they cannot meet each other.
pub fn bodies(input: &Input, place: impl Fn(NodeId) -> u32) -> Vec<Body> {
    let whole = chains::straight(input);
    let (node_before, strut_before) = whole.as_ref().map(|(_, repair)| repair.origins()).unwrap_or_default();
    let input = whole.as_ref().map_or(input, |(whole, _)| whole);
    let body = |(strut, s): (StrutId, Strut)| {
        // where nothing became one, there are no ids before
        let ends = [s.a, s.b].map(|n| place(node_before.get(n.index()).copied().unwrap_or(n)));
        let strut = strut_before.get(strut.index()).copied().unwrap_or(strut);
        (ends[0] != ends[1]).then(|| Body { strut, ends, p: input.nodes[s.a.index()], q: input.nodes[s.b.index()], radii: [s.ra, s.rb] })
    };
    sound_struts(input).filter_map(body).collect()
}
