//! A lattice while it is read: nodes, struts, and where in the source each of them stands.

use super::{Format, Imported, RadiusRule, Units, limits};
use crate::error::{Fault, Note};
use crate::graph::{Input, Strut};
use crate::ids::NodeId;
use glam::DVec3;
use std::collections::HashSet;

/// A place in the source: a kind (an index into `Places::kinds`) and a number, such as a line's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    pub kind: u32,
    pub at: u32,
}

/// The places of all nodes and struts. Empty where the source has the form of the `Input` (JSON).
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// Text before and after the number: `("line ", "")`, `("object[3].beams[", "]")`.
    kinds: Vec<(String, &'static str)>,
    nodes: Vec<Place>,
    struts: Vec<Place>,
}

impl Places {
    pub fn name(&self, place: Place) -> String {
        let (before, after) = &self.kinds[place.kind as usize];
        format!("{before}{}{after}", place.at)
    }

    /// The fault, with the place in the source added to a path that names a node or a strut.
    pub fn named(&self, mut fault: Fault) -> Fault {
        let place = |list: &str, places: &[Place]| {
            let index = fault.path.strip_prefix(list)?.split(']').next()?;
            places.get(index.parse::<usize>().ok()?).copied()
        };
        if let Some(place) = place("nodes[", &self.nodes).or_else(|| place("struts[", &self.struts)) {
            fault.path += &format!(" ({})", self.name(place));
        }
        fault
    }
}

struct Piece {
    ends: [u32; 2],
    /// Radii at both ends (mm); `None` where the source gives none.
    radii: Option<[f64; 2]>,
}

/// What a reader has found so far. Lengths given to it are in the unit of the source.
pub struct Draft {
    pub name: Option<String>,
    pub units: Units,
    nodes: Vec<DVec3>,
    struts: Vec<Piece>,
    places: Places,
    faults: Vec<Fault>,
    faults_not_listed: usize,
    notes: Vec<Note>,
    /// No further piece is taken: a limit was met, and the fault told.
    full: bool,
}

impl Draft {
    pub fn new(units: Units) -> Self {
        let places = Places { kinds: vec![("line ".into(), "")], ..Places::default() };
        let (nodes, struts, faults, notes) = Default::default();
        Draft { name: None, units, nodes, struts, places, faults, faults_not_listed: 0, notes, full: false }
    }

    /// A line of the file.
    pub fn line(at: u32) -> Place {
        Place { kind: 0, at }
    }

    /// A new kind of place: text before and after the number.
    pub fn kind(&mut self, before: String, after: &'static str) -> u32 {
        self.places.kinds.push((before, after));
        self.places.kinds.len() as u32 - 1
    }

    pub fn fault(&mut self, place: Place, found: impl ToString, wanted: impl Into<String>) {
        let path = self.places.name(place);
        self.fault_at(path, found, wanted);
    }

    /// A fault at a place that has a name of its own.
    pub fn fault_at(&mut self, path: impl Into<String>, found: impl ToString, wanted: impl Into<String>) {
        if self.faults.len() < limits::LISTED {
            self.faults.push(Fault::new(path, found.to_string(), wanted));
        } else {
            self.faults_not_listed += 1;
        }
    }

    pub fn note(&mut self, path: impl Into<String>, what: impl Into<String>) {
        if self.notes.len() < limits::LISTED {
            self.notes.push(Note::new(path, what));
        }
    }

    /// Faults were found.
    pub fn has_faults(&self) -> bool {
        !self.faults.is_empty()
    }

    /// No further piece is taken: a reader may stop.
    pub fn is_full(&self) -> bool {
        self.full
    }

    /// Nodes so far.
    pub fn node_count(&self) -> u32 {
        self.nodes.len() as u32
    }

    /// Add a node; `None` where the position could not be read (a fault that the reader has told). Returns its index.
    pub fn node(&mut self, place: Place, position: Option<[f64; 3]>) -> u32 {
        if self.has_room(self.nodes.len(), "nodes") {
            let mm = |p: [f64; 3]| DVec3::from_array(p.map(|x| self.units.mm(x)));
            self.nodes.push(position.map_or(DVec3::NAN, mm));
            self.places.nodes.push(place);
        }
        self.nodes.len() as u32 - 1
    }

    /// Add a strut between two nodes of this draft, with radii at both ends if the source gives them.
    pub fn strut(&mut self, place: Place, ends: [u32; 2], radii: Option<[f64; 2]>) {
        if self.has_room(self.struts.len(), "struts") {
            let radii = radii.map(|r| r.map(|r| self.units.mm(r)));
            self.struts.push(Piece { ends, radii });
            self.places.struts.push(place);
        }
    }

    fn has_room(&mut self, count: usize, what: &str) -> bool {
        if !self.full && count >= limits::PIECES {
            self.full = true;
            self.fault_at("document", format!("more than {} {what}", limits::PIECES), format!("at most {}", limits::PIECES));
        }
        !self.full
    }

    /// Positions of all nodes (mm), for readers that join them.
    pub fn positions(&self) -> &[DVec3] {
        &self.nodes
    }

    /// Let every strut end at the node that this list gives for its node; nodes that go elsewhere are left out.
    pub fn join(&mut self, to: &[u32]) {
        self.redirect(to);
        self.retain_nodes(|n| to[n] == n as u32);
    }

    fn redirect(&mut self, to: &[u32]) {
        for piece in &mut self.struts {
            piece.ends = piece.ends.map(|n| to[n as usize]);
        }
    }

    /// Give radii where the source has none, leave out what is there twice or not used, and hand over.
    pub fn finish(mut self, format: Format, rule: Option<RadiusRule>) -> Imported {
        self.give_radii(format, rule);
        self.drop_repeated();
        if self.has_faults() {
            self.drop_broken();
        }
        self.drop_unused();
        if self.faults_not_listed > 0 {
            self.faults.push(Fault::new("document", format!("{} more faults", self.faults_not_listed), "none"));
        }
        let strut = |p: &Piece| {
            let [ra, rb] = p.radii.unwrap_or([f64::NAN; 2]);
            Strut { a: NodeId(p.ends[0]), b: NodeId(p.ends[1]), ra, rb }
        };
        let input = Input { name: self.name, nodes: self.nodes, struts: self.struts.iter().map(strut).collect() };
        Imported { format: Some(format), input, faults: self.faults, notes: self.notes, places: self.places }
    }

    fn give_radii(&mut self, format: Format, rule: Option<RadiusRule>) {
        let bare = self.struts.iter().filter(|s| s.radii.is_none()).count();
        if bare == 0 {
            if rule.is_some() && !self.struts.is_empty() {
                self.note("--radius-rule", "not used: the file gives every radius");
            }
            return;
        }
        let Some(rule) = rule else {
            let first = self.struts.iter().position(|s| s.radii.is_none()).expect("counted above");
            let which = if bare == self.struts.len() { format!("any of the {bare} struts") } else { format!("{bare} of {} struts", self.struts.len()) };
            let place = self.places.name(self.places.struts[first]);
            let wanted = "`--radius-rule shortest/8` (an eighth of the shortest strut) or a radius in mm, such as `--radius-rule 0.5`";
            self.fault_at(place, format!("no radius for {which} of this {} file", format.name()), wanted);
            return;
        };
        let radius = match rule {
            RadiusRule::Length(radius) => {
                self.note("document", format!("no radius for {bare} of {} struts: {radius} mm by --radius-rule", self.struts.len()));
                radius
            }
            RadiusRule::Shortest(parts) => {
                let length = |p: &Piece| self.nodes[p.ends[0] as usize].distance(self.nodes[p.ends[1] as usize]);
                let lengths = self.struts.iter().map(length).zip(&self.places.struts).filter(|(l, _)| *l > 0.0);
                let Some((shortest, &place)) = lengths.min_by(|x, y| x.0.total_cmp(&y.0)) else { return };
                let (radius, place) = (shortest / parts, self.places.name(place));
                let what = format!(
                    "no radius for {bare} of {} struts: {radius} mm by --radius-rule, the shortest strut's {shortest} mm ({place}) / {parts}",
                    self.struts.len()
                );
                self.note("document", what);
                radius
            }
        };
        self.struts.iter_mut().for_each(|s| _ = s.radii.get_or_insert([radius; 2]));
    }

    /// Of struts between the same nodes with the same radii, the first stays. Others are for `graph::check` to judge.
    fn drop_repeated(&mut self) {
        let mut seen: HashSet<[(u32, u64); 2]> = HashSet::with_capacity(self.struts.len());
        let mut keep = vec![true; self.struts.len()];
        for (k, s) in self.struts.iter().enumerate() {
            let mut sides = [0, 1].map(|end| (s.ends[end], s.radii.map_or(0, |r| r[end].to_bits())));
            sides.sort_unstable();
            keep[k] = seen.insert(sides);
        }
        if let Some(k) = keep.iter().position(|k| !k) {
            let (place, count) = (self.places.name(self.places.struts[k]), keep.iter().filter(|k| !**k).count());
            self.retain_struts(&keep);
            self.note("document", format!("struts given more than once with the same radii: {count} left out (first at {place})"));
        }
    }

    /// Leave out what carries a fault that is told already, so that it is not told twice.
    fn drop_broken(&mut self) {
        let sound = |s: &Piece| s.radii.is_some() && s.ends.iter().all(|&n| !self.nodes[n as usize].is_nan());
        let keep: Vec<bool> = self.struts.iter().map(sound).collect();
        self.retain_struts(&keep);
    }

    fn retain_struts(&mut self, keep: &[bool]) {
        let (mut k, mut l) = (keep.iter(), keep.iter());
        self.struts.retain(|_| *k.next().expect("one each"));
        self.places.struts.retain(|_| *l.next().expect("one each"));
    }

    /// Nodes without struts are left out; the others keep their order.
    fn drop_unused(&mut self) {
        let mut used = vec![false; self.nodes.len()];
        self.struts.iter().flat_map(|s| s.ends).for_each(|n| used[n as usize] = true);
        let Some(first) = used.iter().position(|u| !u) else { return };
        if !self.has_faults() {
            let (place, count) = (self.places.name(self.places.nodes[first]), used.iter().filter(|u| !**u).count());
            self.note("document", format!("nodes without a strut: {count} left out (first at {place})"));
        }
        self.retain_nodes(|n| used[n]);
    }

    /// Leave out nodes at which no strut ends.
    fn retain_nodes(&mut self, keep: impl Fn(usize) -> bool) {
        let mut next = 0;
        let mut number = vec![u32::MAX; self.nodes.len()];
        for n in (0..self.nodes.len()).filter(|&n| keep(n)) {
            number[n] = next as u32;
            self.nodes[next] = self.nodes[n];
            self.places.nodes[next] = self.places.nodes[n];
            next += 1;
        }
        self.nodes.truncate(next);
        self.places.nodes.truncate(next);
        self.redirect(&number);
    }
}
