//! Gmsh `.msh`, ASCII, versions 2 and 4.1: line elements and edges of tetrahedra become struts. No radii.
//!
//! Of curved elements (3-node lines, 10-node tetrahedra) only the ends and corners count. Other elements are left out.

use super::draft::{Draft, Place};
use super::mesh::{Edges, Numbers};
use super::text;
use std::borrow::Cow;

pub fn is_like(start: &str) -> bool {
    start.starts_with("$MeshFormat") || (start.starts_with("$Comments") && start.contains("$MeshFormat"))
}

#[derive(Clone, Copy, PartialEq)]
enum Version {
    Two,
    Four,
}

struct Reader<'a, 'd, I> {
    lines: I,
    draft: &'d mut Draft,
    numbers: Numbers,
    edges: Edges,
    /// A line that ends a section before its time.
    pending: Option<(u32, Cow<'a, str>)>,
    /// A count did not hold: what follows cannot be told apart.
    is_lost: bool,
}

pub fn read(bytes: &[u8], draft: &mut Draft) {
    let lines = text::lines(bytes).filter(|(_, l)| !l.trim().is_empty());
    Reader { lines, draft, numbers: Numbers::default(), edges: Edges::default(), pending: None, is_lost: false }.file();
}

impl<'a, I: Iterator<Item = (u32, Cow<'a, str>)>> Reader<'a, '_, I> {
    fn file(mut self) {
        let mut version = None;
        while let Some((at, line)) = self.pending.take().or_else(|| self.lines.next()) {
            match line.trim() {
                "$MeshFormat" => match self.format() {
                    Some(known) => version = Some(known),
                    None => return,
                },
                "$Nodes" | "$Elements" if version.is_none() => {
                    self.draft.fault(Draft::line(at), "no $MeshFormat before it", "the version first");
                    return;
                }
                "$Nodes" => match version {
                    Some(Version::Two) => self.nodes_2(at),
                    _ => self.nodes_4(at),
                },
                "$Elements" => match version {
                    Some(Version::Two) => self.elements_2(at),
                    _ => self.elements_4(at),
                },
                _ => {}
            }
            if self.draft.is_full() || self.is_lost {
                return;
            }
        }
        self.edges.note(self.draft);
    }

    /// The next line of a section; `None` at its end.
    fn row(&mut self) -> Option<(u32, Cow<'a, str>)> {
        let (at, line) = self.lines.next()?;
        if line.trim_start().starts_with('$') {
            self.pending = Some((at, line));
            return None;
        }
        Some((at, line))
    }

    fn format(&mut self) -> Option<Version> {
        let (at, line) = self.row()?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let version = match words.first() {
            Some(v) if v.starts_with("2") => Some(Version::Two),
            Some(&"4.1") => Some(Version::Four),
            _ => None,
        };
        let place = Draft::line(at);
        if version.is_none() {
            self.draft.fault(place, format_args!("version {}", text::quoted(words.first().copied())), "version 2 or 4.1");
        } else if words.get(1) != Some(&"0") {
            self.draft.fault(place, "a binary file", "ASCII: save with Mesh.Binary = 0");
        }
        version.filter(|_| words.get(1) == Some(&"0"))
    }

    /// Counts at the start of a section or block.
    fn counts<const N: usize>(&mut self, section: u32, what: &str) -> Option<(u32, [u64; N])> {
        let row = self.row();
        let at = row.as_ref().map_or(section, |r| r.0);
        let mut words = row.as_ref().map(|r| r.1.split_whitespace()).into_iter().flatten();
        let read = [(); N].map(|_| words.next().and_then(|w| w.parse().ok()));
        if !read.iter().all(Option::is_some) {
            self.draft.fault(Draft::line(at), "no counts", what);
            self.is_lost = true;
            return None;
        }
        Some((at, read.map(|n| n.expect("all are there"))))
    }

    fn short(&mut self, at: u32, claimed: u64, found: u64, what: &str) {
        self.draft.fault(Draft::line(at), format_args!("a count of {claimed} {what}, then {found}"), "as many as the count says");
        self.is_lost = true;
    }

    fn add_node(&mut self, place: Place, number: &str, line: &str, skip: usize) {
        let mut words = line.split_whitespace().skip(skip);
        let position = text::point(self.draft, place, [words.next(), words.next(), words.next()]);
        let node = self.draft.node(place, position);
        self.numbers.add(self.draft, place, number, node);
    }

    fn nodes_2(&mut self, section: u32) {
        let Some((header, [count])) = self.counts(section, "the number of nodes") else { return };
        for k in 0..count {
            let Some((at, line)) = self.row() else { return self.short(header, count, k, "nodes") };
            self.add_node(Draft::line(at), line.split_whitespace().next().unwrap_or_default(), &line, 1);
        }
    }

    fn nodes_4(&mut self, section: u32) {
        let Some((header, [blocks, total])) = self.counts(section, "the numbers of blocks and of nodes") else { return };
        for k in 0..blocks {
            let Some((block, [_, _, _, count])) = self.counts(header, "a block of nodes: dimension, tag, parametric, count") else {
                return self.short(header, blocks, k, "blocks");
            };
            let mut tags = Vec::new();
            for k in 0..count {
                let Some((at, tag)) = self.row() else { return self.short(block, count, k, "nodes") };
                tags.push((at, tag));
                if tags.len() > super::limits::PIECES {
                    return self.draft.fault(Draft::line(block), format_args!("{count} nodes"), format!("at most {}", super::limits::PIECES));
                }
            }
            for (k, (_, tag)) in tags.iter().enumerate() {
                let Some((at, line)) = self.row() else { return self.short(block, count, k as u64, "positions") };
                self.add_node(Draft::line(at), tag, &line, 0);
            }
        }
        if u64::from(self.draft.node_count()) != total {
            self.short(header, total, u64::from(self.draft.node_count()), "nodes");
        }
    }

    fn elements_2(&mut self, section: u32) {
        let Some((header, [count])) = self.counts(section, "the number of elements") else { return };
        for k in 0..count {
            let Some((at, line)) = self.row() else { return self.short(header, count, k, "elements") };
            let mut words = line.split_whitespace().skip(1);
            let kind = words.next();
            // so many tags follow, then the nodes
            match words.next().and_then(|t| t.parse::<usize>().ok()) {
                Some(tags) => self.element(Draft::line(at), kind, words.skip(tags)),
                None => self.draft.fault(Draft::line(at), "no number of tags", "an element: number, type, number of tags, tags, nodes"),
            }
        }
    }

    fn elements_4(&mut self, section: u32) {
        let Some((header, [blocks, total])) = self.counts(section, "the numbers of blocks and of elements") else { return };
        let mut seen = 0;
        for k in 0..blocks {
            let Some((block, [_, _, kind, count])) = self.counts(header, "a block of elements: dimension, tag, type, count") else {
                return self.short(header, blocks, k, "blocks");
            };
            let kind = kind.to_string();
            for k in 0..count {
                let Some((at, line)) = self.row() else { return self.short(block, count, k, "elements") };
                self.element(Draft::line(at), Some(&kind), line.split_whitespace().skip(1));
                seen += 1;
            }
        }
        if seen != total {
            self.short(header, total, seen, "elements");
        }
    }

    fn element<'t>(&mut self, place: Place, kind: Option<&str>, nodes: impl Iterator<Item = &'t str>) {
        match kind.unwrap_or_default() {
            "1" | "8" => match self.numbers.find_all::<2>(self.draft, place, nodes) {
                Some(ends) => self.edges.line(self.draft, place, ends, None),
                None => self.edges.broken(),
            },
            "4" | "11" => match self.numbers.find_all::<4>(self.draft, place, nodes) {
                Some(corners) => self.edges.tet(self.draft, place, corners, |_| None),
                None => self.edges.broken(),
            },
            "2" | "9" => self.edges.other("triangles"),
            "3" | "10" | "16" => self.edges.other("quadrangles"),
            "5" | "12" | "17" => self.edges.other("hexahedra"),
            "6" | "13" | "18" => self.edges.other("prisms"),
            "7" | "14" | "19" => self.edges.other("pyramids"),
            "15" => self.edges.other("points"),
            other if other.parse::<u32>().is_ok() => self.edges.other("elements of other types"),
            other => {
                self.draft.fault(place, text::quoted(Some(other)), "the type of an element");
                self.edges.broken();
            }
        }
    }
}
