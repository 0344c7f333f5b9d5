//! Abaqus input files: B31, B32, T3D2 and their variants, with circular sections by element set.
//!
//! `*BEAM SECTION, SECTION=CIRC` and `*BEAM GENERAL SECTION, SECTION=CIRC` give the radius; `*SOLID SECTION` of a truss gives the area of
//! a circle. Of B32 the middle node counts only if it is off the line between the ends. A part and its one instance are read as they
//! stand; what moves or makes nodes (`*SYSTEM`, `*NGEN`, an instance with a transform, a second instance) is refused.

use super::draft::{Draft, Place};
use super::mesh::Numbers;
use super::{limits, text};
use std::collections::{BTreeMap, HashMap, HashSet};

/// A middle node this near to the line between its ends (as a fraction of the length) does not bend the strut.
const STRAIGHT: f64 = 1e-6;

/// The first line that is no comment is a keyword.
pub fn is_like(head: &str) -> bool {
    const FIRST: [&str; 8] = ["*heading", "*node", "*part", "*element", "*include", "*parameter", "*preprint", "*assembly"];
    let first = head.lines().map(str::trim).find(|l| !l.is_empty() && !l.starts_with("**")).unwrap_or_default().to_ascii_lowercase();
    FIRST.iter().any(|k| first.strip_prefix(k).is_some_and(|rest| rest.is_empty() || rest.starts_with([',', ' '])))
}

struct Element {
    place: Place,
    number: u64,
    nodes: Vec<u32>,
}

/// What the data lines after a keyword are.
enum Block {
    Skip,
    Node,
    Element { ends: usize, set: Option<String> },
    Set { name: String, generate: bool },
    Section { set: String, is_area: bool },
    Instance,
}

#[derive(Default)]
struct File {
    numbers: Numbers,
    elements: Vec<Element>,
    /// Numbers of the elements of each set; sets named within a set are resolved when they are read.
    sets: HashMap<String, HashSet<u64>>,
    /// Members of all sets together.
    members: usize,
    /// Radius by set name, in the order of the file.
    sections: BTreeMap<usize, (String, f64)>,
    left_out: BTreeMap<String, usize>,
    instances: usize,
}

pub fn read(bytes: &[u8], draft: &mut Draft) {
    let mut file = File::default();
    let mut block = Block::Skip;
    let mut rows = text::lines(bytes).filter(|(_, l)| !l.trim().is_empty() && !l.starts_with("**"));
    while let Some((at, line)) = rows.next() {
        let place = Draft::line(at);
        let mut line = line.trim().to_owned();
        if line.starts_with('*') {
            block = file.keyword(draft, place, &line);
            continue;
        }
        // a line of an element that ends with a comma goes on in the next
        while matches!(block, Block::Element { .. }) && line.ends_with(',') && line.len() < 4096 {
            match rows.next() {
                Some((_, more)) => line += more.trim(),
                None => break,
            }
        }
        block = file.data(draft, place, block, &line);
        if draft.is_full() {
            return;
        }
    }
    file.pour(draft);
}

impl File {
    fn keyword(&mut self, draft: &mut Draft, place: Place, line: &str) -> Block {
        let lower = line.to_ascii_lowercase();
        let mut parts = lower.split(',').map(str::trim);
        let keyword = parts.next().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
        let options: HashMap<&str, &str> = parts.map(|p| p.split_once('=').map_or((p, ""), |(k, v)| (k.trim(), v.trim().trim_matches('"')))).collect();
        let option = |name: &str| options.get(name).map(|v| (*v).to_owned());
        if options.contains_key("input") || keyword == "*include" {
            draft.fault(place, format_args!("{} in another file", text::shown(&keyword)), "everything in one file");
            return Block::Skip;
        }
        match keyword.as_str() {
            "*node" if options.get("system").is_some_and(|s| *s != "r") => {
                draft.fault(place, "nodes in cylindrical or spherical coordinates", "x, y, z");
                Block::Skip
            }
            "*node" => Block::Node,
            "*element" => {
                let kind = option("type").unwrap_or_default();
                match kind.as_str() {
                    "b31" | "b31h" | "b31os" | "b31osh" | "b33" | "b33h" | "t3d2" | "t3d2h" => Block::Element { ends: 2, set: option("elset") },
                    "b32" | "b32h" | "b32os" | "b32osh" | "t3d3" | "t3d3h" | "b32r" => Block::Element { ends: 3, set: option("elset") },
                    _ => {
                        *self.left_out.entry(text::shown(&kind.to_ascii_uppercase())).or_default() += 1;
                        Block::Skip
                    }
                }
            }
            "*elset" => match option("elset") {
                Some(name) => Block::Set { name, generate: options.contains_key("generate") },
                None => Block::Skip,
            },
            "*beam section" | "*beam general section" | "*solid section" => {
                let is_area = keyword == "*solid section";
                let shape = option("section").unwrap_or_default();
                if !is_area && shape != "circ" {
                    draft.fault(place, format_args!("SECTION={}", text::shown(&shape.to_ascii_uppercase())), "SECTION=CIRC: struts are round and full");
                    return Block::Skip;
                }
                match option("elset") {
                    Some(set) => Block::Section { set, is_area },
                    None => {
                        draft.fault(place, "no ELSET", "the element set that has this section");
                        Block::Skip
                    }
                }
            }
            "*instance" => {
                self.instances += 1;
                if self.instances > 1 {
                    draft.fault(place, "a second instance", "one instance of one part");
                }
                Block::Instance
            }
            "*system" | "*ngen" | "*nfill" | "*ncopy" | "*nmap" | "*elgen" | "*elcopy" | "*transform" => {
                if keyword != "*transform" {
                    draft.fault(place, keyword.to_ascii_uppercase(), "nodes and elements in full, in one system");
                }
                Block::Skip
            }
            _ => Block::Skip,
        }
    }

    fn data(&mut self, draft: &mut Draft, place: Place, block: Block, line: &str) -> Block {
        let mut words = line.split(',').map(str::trim);
        match &block {
            Block::Skip => {}
            Block::Node => {
                let number = words.next().unwrap_or_default();
                // an empty coordinate is zero
                let mut coordinate = || Some(words.next().filter(|w| !w.is_empty()).unwrap_or("0"));
                let position = text::point(draft, place, [coordinate(), coordinate(), coordinate()]);
                let node = draft.node(place, position);
                self.numbers.add(draft, place, number, node);
            }
            Block::Element { ends, set } => {
                let number = words.next().and_then(|w| w.parse().ok());
                let nodes = match ends {
                    2 => self.numbers.find_all::<2>(draft, place, words).map(|n| n.to_vec()),
                    _ => self.numbers.find_all::<3>(draft, place, words).map(|n| n.to_vec()),
                };
                match (number, nodes) {
                    (None, _) => draft.fault(place, text::quoted(line.split(',').next()), "the number of an element"),
                    (Some(number), Some(nodes)) => {
                        self.elements.push(Element { place, number, nodes });
                        if let Some(set) = set {
                            self.add(draft, place, set, [number]);
                        }
                    }
                    _ => {}
                }
            }
            Block::Set { name, generate: false } => {
                for word in words.filter(|w| !w.is_empty()) {
                    let members: Vec<u64> = match word.parse() {
                        Ok(number) => vec![number],
                        Err(_) => self.sets.get(&word.to_ascii_lowercase()).into_iter().flatten().copied().collect(),
                    };
                    self.add(draft, place, name, members);
                }
            }
            Block::Set { name, generate: true } => {
                let [first, last, step] = [(); 3].map(|_| words.next().and_then(|w| w.parse::<u64>().ok()));
                match (first, last, step.unwrap_or(1).max(1)) {
                    (Some(first), Some(last), step) => {
                        // only numbers of elements that are there: a range may claim any length
                        let there = self.elements.iter().map(|e| e.number).filter(|n| (first..=last).contains(n) && (n - first) % step == 0);
                        let there: Vec<u64> = there.collect();
                        self.add(draft, place, name, there);
                    }
                    _ => draft.fault(place, text::quoted(Some(line)), "first, last, step"),
                }
            }
            Block::Section { set, is_area } => {
                let what = if *is_area { "area" } else { "radius" };
                let value = words.next().filter(|w| !w.is_empty());
                match value.and_then(text::number).filter(|x| *x > 0.0) {
                    Some(area) if *is_area => _ = self.sections.insert(self.sections.len(), (set.clone(), (area / std::f64::consts::PI).sqrt())),
                    Some(radius) => _ = self.sections.insert(self.sections.len(), (set.clone(), radius)),
                    // a solid section of other elements has no area
                    None if *is_area && value.is_none() => {}
                    None => draft.fault(place, format_args!("{} as {what}", text::quoted(value)), format!("a {what} > 0")),
                }
                // the lines after the first are directions
                return Block::Skip;
            }
            Block::Instance => draft.fault(place, "an instance that is moved", "a part where it stands"),
        }
        block
    }

    /// Add elements to a set. Sets of sets multiply: their members have one limit together.
    fn add(&mut self, draft: &mut Draft, place: Place, name: &str, numbers: impl IntoIterator<Item = u64>) {
        if self.members > limits::PIECES {
            return;
        }
        let set = self.sets.entry(name.to_owned()).or_default();
        let before = set.len();
        set.extend(numbers);
        self.members += set.len() - before;
        if self.members > limits::PIECES {
            draft.fault(place, format_args!("more than {} members of element sets", limits::PIECES), format!("at most {}", limits::PIECES));
        }
    }

    fn pour(self, draft: &mut Draft) {
        let mut radius: HashMap<u64, f64> = HashMap::new();
        for (set, r) in self.sections.values() {
            match self.sets.get(set) {
                Some(members) => members.iter().for_each(|n| _ = radius.insert(*n, *r)),
                None => draft.note("document", format!("the section of element set {} has no element: left out", text::shown(set))),
            }
        }
        let mut straight = 0;
        for e in &self.elements {
            let radii = radius.get(&e.number).map(|r| [*r; 2]);
            match e.nodes[..] {
                [a, b] => draft.strut(e.place, [a, b], radii),
                [a, middle, b] => {
                    let [p, m, q] = [a, middle, b].map(|n| draft.positions()[n as usize]);
                    let bend = (m - p).cross(q - p).length() / (q - p).length_squared();
                    if bend <= STRAIGHT && (m - p).dot(q - p) > 0.0 && (m - q).dot(p - q) > 0.0 {
                        straight += 1;
                        draft.strut(e.place, [a, b], radii);
                    } else {
                        draft.strut(e.place, [a, middle], radii);
                        draft.strut(e.place, [middle, b], radii);
                    }
                }
                _ => unreachable!("two or three nodes are read"),
            }
        }
        if straight > 0 {
            draft.note("document", format!("{straight} elements of three nodes are straight: their middle nodes are left out"));
        }
        if self.elements.is_empty() && !draft.has_faults() {
            let kinds: Vec<&str> = self.left_out.keys().map(String::as_str).collect();
            let found = if kinds.is_empty() { "no elements".to_owned() } else { format!("elements of type {}", kinds.join(", ")) };
            draft.fault_at("document", found, "elements of type B31, B32 or T3D2");
        } else if !self.left_out.is_empty() {
            let kinds: Vec<&str> = self.left_out.keys().map(String::as_str).collect();
            draft.note("document", format!("elements of type {} are left out: only beams and trusses are struts", kinds.join(", ")));
        }
    }
}
