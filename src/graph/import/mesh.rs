//! Struts of a mesh: its line elements, and each edge of its tetrahedra once.

use super::draft::{Draft, Place};
use super::text;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};

/// The edges of a tetrahedron, as pairs of its four corners.
pub const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Collects the struts of a mesh, and says in the end what became of its elements.
#[derive(Default)]
pub struct Edges {
    seen: HashSet<[u32; 2]>,
    lines: usize,
    tets: usize,
    /// Elements that are neither, by name.
    left_out: BTreeMap<String, usize>,
    faults: usize,
}

impl Edges {
    pub fn line(&mut self, draft: &mut Draft, place: Place, ends: [u32; 2], radii: Option<[f64; 2]>) {
        self.lines += 1;
        self.edge(draft, place, ends, radii);
    }

    /// `radius` gives the radius at a node, in the unit of the source, if there is one.
    pub fn tet(&mut self, draft: &mut Draft, place: Place, corners: [u32; 4], radius: impl Fn(u32) -> Option<f64>) {
        self.tets += 1;
        for [i, j] in TET_EDGES {
            let ends = [corners[i].min(corners[j]), corners[i].max(corners[j])];
            self.edge(draft, place, ends, radius(ends[0]).zip(radius(ends[1])).map(<[f64; 2]>::from));
        }
    }

    fn edge(&mut self, draft: &mut Draft, place: Place, [a, b]: [u32; 2], radii: Option<[f64; 2]>) {
        if self.seen.insert([a.min(b), a.max(b)]) {
            draft.strut(place, [a, b], radii);
        }
    }

    /// An element of another kind.
    pub fn other(&mut self, name: &str) {
        *self.left_out.entry(name.to_owned()).or_default() += 1;
    }

    /// An element that could not be read: its fault is told.
    pub fn broken(&mut self) {
        self.faults += 1;
    }

    pub fn note(self, draft: &mut Draft) {
        let others: Vec<String> = self.left_out.iter().map(|(name, count)| format!("{count} {name}")).collect();
        let others = if others.is_empty() { "no elements".to_owned() } else { others.join(", ") };
        if self.lines + self.tets + self.faults == 0 {
            draft.fault_at("document", others, "line elements or tetrahedra, whose edges become struts");
            return;
        }
        if !self.left_out.is_empty() {
            draft.note("document", format!("left out: {others}; only lines and the edges of tetrahedra are struts"));
        }
        if self.tets > 0 {
            let what = format!("{} tetrahedra and {} lines: {} struts, each edge once", self.tets, self.lines, self.seen.len());
            draft.note("document", what);
        }
    }
}

/// Nodes by the number that the source gives them.
#[derive(Default)]
pub struct Numbers {
    node: HashMap<u64, u32>,
}

impl Numbers {
    /// Note the number of a node of the draft.
    pub fn add(&mut self, draft: &mut Draft, place: Place, number: &str, node: u32) {
        match number.trim().parse().map(|n| self.node.entry(n)) {
            Err(_) => draft.fault(place, text::quoted(Some(number)), "the number of a node"),
            Ok(Entry::Vacant(entry)) => _ = entry.insert(node),
            Ok(Entry::Occupied(entry)) => {
                let number = *entry.key();
                draft.fault(place, format_args!("a second node {number}"), "each number once");
            }
        }
    }

    /// The node of this number, or a fault.
    pub fn find(&self, draft: &mut Draft, place: Place, number: Option<&str>) -> Option<u32> {
        let node = number.and_then(|n| n.trim().parse().ok()).and_then(|n: u64| self.node.get(&n).copied());
        if node.is_none() {
            draft.fault(place, text::quoted(number), format!("the number of one of the {} nodes", self.node.len()));
        }
        node
    }

    /// The nodes of these numbers; `None` with a fault for each that is not there.
    pub fn find_all<'t, const N: usize>(&self, draft: &mut Draft, place: Place, mut numbers: impl Iterator<Item = &'t str>) -> Option<[u32; N]> {
        let found = [(); N].map(|_| self.find(draft, place, numbers.next()));
        found.iter().all(Option::is_some).then(|| found.map(|n| n.expect("all are there")))
    }
}
