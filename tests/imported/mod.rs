//! Reads a text or bytes as a file of a given name, and shows what came of it.
#![allow(dead_code)] // each test file uses its own part

use lattice_brep::graph::import::{self, ImportOptions, Imported, Source};

pub fn read(name: &str, bytes: impl AsRef<[u8]>) -> Imported {
    read_with(name, bytes, &ImportOptions::default())
}

pub fn read_with(name: &str, bytes: impl AsRef<[u8]>, options: &ImportOptions) -> Imported {
    import::read(&Source { name, bytes: bytes.as_ref(), sibling: &|_| None }, options)
}

/// As `read_with`, with files beside this one: extension and text.
pub fn read_beside(name: &str, text: &str, beside: &[(&str, &str)], options: &ImportOptions) -> Imported {
    let sibling = |extension: &str| beside.iter().find(|(e, _)| *e == extension).map(|(_, text)| text.as_bytes().to_vec());
    import::read(&Source { name, bytes: text.as_bytes(), sibling: &sibling }, options)
}

/// Nodes and struts.
pub fn count(imported: &Imported) -> (usize, usize) {
    (imported.input.nodes.len(), imported.input.struts.len())
}

/// A strut's ends and radii (mm).
pub fn strut(imported: &Imported, k: usize) -> ([f64; 3], [f64; 3], [f64; 2]) {
    let s = imported.input.struts[k];
    let at = |n: lattice_brep::ids::NodeId| imported.input.nodes[n.index()].to_array();
    (at(s.a), at(s.b), [s.ra, s.rb])
}

/// Lengths of all struts (mm).
pub fn lengths(imported: &Imported) -> Vec<f64> {
    let at = |n: lattice_brep::ids::NodeId| imported.input.nodes[n.index()];
    imported.input.struts.iter().map(|s| at(s.a).distance(at(s.b))).collect()
}

pub fn faults(imported: &Imported) -> Vec<String> {
    imported.faults.iter().map(ToString::to_string).collect()
}

pub fn notes(imported: &Imported) -> Vec<String> {
    imported.notes.iter().map(ToString::to_string).collect()
}
