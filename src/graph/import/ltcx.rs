//! nTop LTCX: XML with `node` (id, x, y, z, rad) and `beam` (n1, n2); the unit stands on an element around them.
//!
//! A beam takes the radii of its two nodes. A node without `id` is numbered by its position, from 0.

use super::draft::{Draft, Place};
use super::mesh::Numbers;
use super::xml::{Piece, Tag, Xml, decode};
use super::{Units, text};
use crate::error::Fault;
use std::collections::HashMap;

/// Names of the outermost element.
pub const ROOTS: [&str; 4] = ["graph", "lattice", "ltcx", "graphs"];

struct Beam {
    place: Place,
    ends: [String; 2],
}

pub fn read(bytes: &[u8], draft: &mut Draft) {
    if let Err(fault) = document(bytes, draft) {
        draft.fault_at(fault.path, fault.found, fault.wanted);
    }
}

fn document(bytes: &[u8], draft: &mut Draft) -> Result<(), Fault> {
    let mut xml = Xml::new(decode(bytes, "")?, &[], String::new());
    let (node_kind, beam_kind) = (draft.kind("node[".into(), "]"), draft.kind("beam[".into(), "]"));
    let mut numbers = Numbers::default();
    let mut radius: HashMap<u32, f64> = HashMap::new();
    let mut beams: Vec<Beam> = Vec::new();
    let mut count = 0;
    while let Some(piece) = xml.next()? {
        let Piece::Open(tag) = piece else { continue };
        unit(&tag, draft);
        match tag.name() {
            "node" => {
                let place = Place { kind: node_kind, at: count };
                let position = text::point(draft, place, [tag.get("x").as_deref(), tag.get("y").as_deref(), tag.get("z").as_deref()]);
                let node = draft.node(place, position);
                numbers.add(draft, place, tag.get("id").as_deref().unwrap_or(&count.to_string()), node);
                let given = ["rad", "radius", "r"].into_iter().find_map(|name| tag.get(name));
                if let Ok(Some([r, _])) = text::radii(draft, place, given.as_deref(), None) {
                    radius.insert(node, r);
                }
                count += 1;
            }
            "beam" => {
                let place = Place { kind: beam_kind, at: beams.len() as u32 };
                beams.push(Beam { place, ends: ["n1", "n2"].map(|n| tag.get(n).unwrap_or_default().into_owned()) });
            }
            _ => {}
        }
        if draft.is_full() {
            return Ok(());
        }
    }
    if beams.is_empty() {
        draft.fault_at("document", "no <beam>", "nodes and beams");
    }
    for beam in &beams {
        if let Some(ends) = numbers.find_all::<2>(draft, beam.place, beam.ends.iter().map(String::as_str)) {
            let [ra, rb] = ends.map(|n| radius.get(&n).copied());
            draft.strut(beam.place, ends, ra.zip(rb).map(<[f64; 2]>::from));
        }
    }
    Ok(())
}

/// The unit, where an element gives one. It stands before the nodes.
fn unit(tag: &Tag, draft: &mut Draft) {
    let Some(unit) = tag.get("units").or_else(|| tag.get("unit")) else { return };
    match named(&unit) {
        Some(unit) if draft.node_count() == 0 || unit == draft.units => draft.units = unit,
        Some(_) => draft.fault_at("units", "another unit after the first nodes", "one unit, before the nodes"),
        None => draft.fault_at("units", text::quoted(Some(&unit)), "one of mm, cm, m, in, ft, um"),
    }
}

/// The unit of this name, long or short.
pub fn named(unit: &str) -> Option<Units> {
    Some(match unit.to_ascii_lowercase().as_str() {
        "um" | "micron" | "micrometer" => Units::Um,
        "mm" | "millimeter" => Units::Mm,
        "cm" | "centimeter" => Units::Cm,
        "m" | "meter" => Units::M,
        "in" | "inch" => Units::In,
        "ft" | "foot" => Units::Ft,
        _ => return None,
    })
}
