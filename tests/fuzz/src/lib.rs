//! What the fuzz targets do with their bytes: read them as a file of one format, or as a small graph that becomes a solid.
//! A panic, a failure of our own checks, or memory beyond the fuzzer's limit is a find; a refusal is not.

use glam::DVec3;
use lattice_brep::brep::Caps;
use lattice_brep::error::Error;
pub use lattice_brep::graph::import::Format;
use lattice_brep::graph::check::{self, Overlaps};
use lattice_brep::graph::import::{self, ImportOptions, RadiusRule, Source};
use lattice_brep::graph::{Input, Strut};
use lattice_brep::ids::NodeId;
use lattice_brep::options::{OnConflict, Options};
use lattice_brep::pipeline::{self, Silent};
use libfuzzer_sys::Corpus;
use std::io::{Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Graphs with more struts than this are read, not checked for overlaps: that is another target's work.
const MOST_CHECKED: usize = 300;

/// Bytes as a file of this name, if they are taken for this format.
pub fn read(name: &str, format: Format, bytes: &[u8]) -> Corpus {
    read_beside(name, format, bytes, &|_| None)
}

fn read_beside(name: &str, format: Format, bytes: &[u8], sibling: &dyn Fn(&str) -> Option<Vec<u8>>) -> Corpus {
    if import::sniff(bytes, Path::new(name)) != Some(format) {
        return Corpus::Reject;
    }
    let options = ImportOptions { radius_rule: Some(RadiusRule::Shortest(8.0)), unit: None };
    let imported = import::read(&Source { name, bytes, sibling }, &options);
    if imported.input.struts.len() <= MOST_CHECKED {
        let _ = imported.admit(Overlaps::Keep);
    }
    Corpus::Keep
}

/// Up to three files parted by the byte 255: `.ele`, `.node`, `.edge`.
pub fn tetgen(bytes: &[u8]) -> Corpus {
    let parts: Vec<&[u8]> = bytes.splitn(3, |&b| b == 255).collect();
    let part = |k: usize| parts.get(k).filter(|p| !p.is_empty()).map(|p| p.to_vec());
    let sibling = |extension: &str| match extension {
        "ele" => part(0),
        "node" => part(1),
        "edge" => part(2),
        _ => None,
    };
    let Some((extension, k)) = [("ele", 0), ("node", 1), ("edge", 2)].into_iter().find(|&(_, k)| part(k).is_some()) else {
        return Corpus::Reject;
    };
    read_beside(&format!("a.{extension}"), Format::TetGen, parts[k], &sibling)
}

/// A packed file as it is, or the text of its model, to be packed: random bytes seldom have the right check sum.
pub fn threemf(bytes: &[u8]) -> Corpus {
    if bytes.starts_with(b"PK") {
        return read("a.3mf", Format::ThreeMf, bytes);
    }
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let plain = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let files: [(&str, &[u8]); 2] = [("_rels/.rels", RELATIONS), ("3D/3dmodel.model", bytes)];
    for (name, content) in files {
        zip.start_file(name, plain).and_then(|()| zip.write_all(content).map_err(Into::into)).expect("a packed file in memory");
    }
    read("a.3mf", Format::ThreeMf, &zip.finish().expect("a packed file in memory").into_inner())
}

const RELATIONS: &[u8] = br#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

/// A small graph: a byte of options, a byte with the number of nodes, three bytes a node, four a strut.
pub fn solid(bytes: &[u8]) -> Corpus {
    let [flags, count, rest @ ..] = bytes else { return Corpus::Reject };
    let count = 2 + (count % 11) as usize;
    if rest.len() < 3 * count + 4 {
        return Corpus::Reject;
    }
    let (places, struts) = rest.split_at(3 * count);
    // a grid of whole mm, stretched by an odd factor so that not all is exact
    let stretch = if flags & 1 == 0 { 1.0 } else { 0.7310585786300049 };
    let node = |p: &[u8]| stretch * DVec3::new(p[0] as i8 as f64, p[1] as i8 as f64, p[2] as i8 as f64);
    let strut = |s: &[u8]| Strut {
        a: NodeId(s[0] as u32 % count as u32),
        b: NodeId(s[1] as u32 % count as u32),
        ra: 0.05 * (1.0 + s[2] as f64),
        rb: if s[3] == 0 { 0.05 * (1.0 + s[2] as f64) } else { 0.05 * (1.0 + s[3] as f64) },
    };
    let input = Input { name: None, nodes: places.chunks_exact(3).map(node).collect(), struts: struts.chunks_exact(4).take(20).map(strut).collect() };
    let Ok(lattice) = check::admit(input, Vec::new(), Overlaps::Refuse) else { return Corpus::Reject };
    let options = Options {
        on_conflict: if flags & 2 == 0 { OnConflict::Refuse } else { OnConflict::Shrink { part: true } },
        caps: if flags & 4 == 0 { Caps::Flat } else { Caps::Sphere },
        levels: if flags & 8 == 0 { 3 } else { 1 },
        ..Options::default()
    };
    match pipeline::solve(&lattice, &options, &Silent) {
        Ok(mut solved) => pipeline::write(&mut solved, &options, &mut std::io::sink(), &Silent).expect("nothing to fail in a sink"),
        Err(Error::Internal(why)) => panic!("{why}"),
        Err(_) => {}
    }
    Corpus::Keep
}
