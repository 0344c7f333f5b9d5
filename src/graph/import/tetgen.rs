//! TetGen: `.node` (points), `.edge` (edges), `.ele` (tetrahedra), side by side with one stem. No radii.
//!
//! Struts are the edges of `.edge`, or, if there is no such file, the edges of the tetrahedra of `.ele`. Each file has a first line
//! with counts, then one item a line, numbered from 0 or 1; `#` starts a comment. Of a 10-node tetrahedron only the corners count.

use super::draft::{Draft, Place};
use super::mesh::{Edges, Numbers};
use super::{Source, text};
use std::path::Path;

/// The suffixes of the three files.
pub const SUFFIXES: [&str; 3] = ["node", "edge", "ele"];

/// The items of a file, as the line number and the words of each.
struct Table {
    suffix: &'static str,
    kind: u32,
    header: Vec<u64>,
    rows: Vec<(u32, String)>,
}

impl Table {
    fn load(source: &Source, suffix: &'static str, draft: &mut Draft) -> Option<Table> {
        let is_self = Path::new(source.name).extension().is_some_and(|e| e.eq_ignore_ascii_case(suffix));
        let beside = if is_self { None } else { Some((source.sibling)(suffix)?) };
        let bytes = beside.as_deref().unwrap_or(source.bytes);
        let kind = draft.kind(format!(".{suffix} line "), "");
        let data = |(k, l): (u32, std::borrow::Cow<str>)| Some((k, l.split('#').next()?.trim().to_owned())).filter(|(_, l)| !l.is_empty());
        let mut rows = text::lines(bytes).filter_map(data);
        let first = rows.next();
        let header = first.as_ref().map(|(_, l)| l.split_whitespace().map_while(|w| w.parse().ok()).collect::<Vec<u64>>()).unwrap_or_default();
        let place = Place { kind, at: first.map_or(1, |f| f.0) };
        let Some(&claimed) = header.first() else {
            draft.fault(place, "no count", format!("the first line of a .{suffix} file, with the number of items"));
            return None;
        };
        let rows: Vec<_> = rows.take(super::limits::PIECES + 1).take(usize::try_from(claimed).unwrap_or(usize::MAX)).collect();
        if (rows.len() as u64) < claimed {
            draft.fault(place, format_args!("a count of {claimed}, then {} lines", rows.len()), "as many lines as the count says");
        }
        Some(Table { suffix, kind, header, rows })
    }

    fn rows(&self) -> impl Iterator<Item = (Place, impl Iterator<Item = &str>)> {
        self.rows.iter().map(|(at, line)| (Place { kind: self.kind, at: *at }, line.split_whitespace()))
    }

    /// The number in the first line that says how long an item is.
    fn expect(&self, draft: &mut Draft, allowed: &[u64], what: &str) -> bool {
        let found = self.header.get(1).copied();
        let is_right = found.is_some_and(|n| allowed.contains(&n));
        if !is_right {
            let found = found.map_or("nothing".to_owned(), |n| n.to_string());
            draft.fault_at(format!(".{} line 1", self.suffix), format!("{found} {what}"), format!("{allowed:?} {what}"));
        }
        is_right
    }
}

pub fn read(source: &Source, draft: &mut Draft) {
    let is_there = |suffix| Path::new(source.name).extension().is_some_and(|e| e.eq_ignore_ascii_case(suffix)) || (source.sibling)(suffix).is_some();
    for suffix in [&SUFFIXES[..1], &SUFFIXES[1..]].into_iter().filter(|s| !s.iter().any(|&s| is_there(s))) {
        let names = suffix.iter().map(|s| format!(".{s}")).collect::<Vec<_>>().join(" or ");
        draft.fault_at("document", format!("no {names} file beside it"), "a .node file, and a .edge or .ele file, with the same stem");
    }
    if draft.has_faults() {
        return;
    }
    let Some(nodes) = Table::load(source, "node", draft) else { return };
    if !nodes.expect(draft, &[3], "dimensions") {
        return;
    }
    let mut numbers = Numbers::default();
    for (place, mut words) in nodes.rows() {
        let number = words.next().unwrap_or_default();
        let position = text::point(draft, place, [words.next(), words.next(), words.next()]);
        let node = draft.node(place, position);
        numbers.add(draft, place, number, node);
    }
    let mut edges = Edges::default();
    if is_there("edge") {
        let Some(table) = Table::load(source, "edge", draft) else { return };
        for (place, words) in table.rows() {
            match numbers.find_all::<2>(draft, place, words.skip(1)) {
                Some(ends) => edges.line(draft, place, ends, None),
                None => edges.broken(),
            }
        }
    } else {
        let Some(table) = Table::load(source, "ele", draft) else { return };
        if !table.expect(draft, &[4, 10], "nodes a tetrahedron") {
            return;
        }
        for (place, words) in table.rows() {
            match numbers.find_all::<4>(draft, place, words.skip(1)) {
                Some(corners) => edges.tet(draft, place, corners, |_| None),
                None => edges.broken(),
            }
        }
    }
    edges.note(draft);
}
