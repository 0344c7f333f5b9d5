//! `--blocks`: solids of neighbouring nodes that are the lattice together, each block a file, and a master that refers to them.

use glam::DVec3;
use lattice_brep::brep::{Circle, Solid, crossings};
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::check::Overlaps;
use lattice_brep::graph::{Graph, Lattice, Strut, json};
use lattice_brep::ids::{NodeId, StrutId};
use lattice_brep::options::{Divide, Options};
use lattice_brep::pipeline::{Silent, Solved, solve};
use lattice_brep::step::read_back;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::PI;
use std::path::Path;
use std::process::{Command, Output};

fn solved(graph: &Graph, divide: Divide) -> Solved {
    let lattice = Lattice { name: None, graph: graph.clone(), notes: vec![] };
    let options = Options { divide, overlaps: Overlaps::Keep, ..Options::default() };
    solve(&lattice, &options, &Silent).unwrap_or_else(|e| panic!("{e}"))
}

fn example(text: &str) -> Graph {
    let (input, faults) = json::read(text.as_bytes());
    assert_eq!(faults, []);
    Graph::new(input.nodes, input.struts)
}

/// BCC cells whose struts have radii of their own and taper.
fn tapered() -> Graph {
    let graph = generate(Cell::Bcc, 10.0, [2, 2, 1], 0.5).unwrap();
    let radius = |k: usize| 0.3 + 0.05 * (k % 5) as f64;
    let struts = graph.struts().iter().enumerate().map(|(k, s)| Strut { ra: radius(k), rb: radius(7 * k + 2), ..*s }).collect();
    Graph::new(graph.nodes().to_vec(), struts)
}

fn lattices() -> Vec<Graph> {
    vec![example(include_str!("examples/irregular.json")), generate(Cell::Octet, 10.0, [2, 1, 1], 0.5).unwrap(), tapered()]
}

/// The disc that ends the k-th strut of a solid, and where its seam ends.
fn disc(solid: &Solid, k: usize) -> Option<(Circle, DVec3)> {
    let end = (0..2).find(|&e| solid.ends[k][e] as usize >= solid.own)?;
    Some((*solid.rim(k, end), solid.seam_ends(k)[end]))
}

#[test]
fn blocks_together_are_the_lattice() {
    for graph in lattices() {
        let one = solved(&graph, Divide::Not);
        for count in [1, 2, 3, 5] {
            let Solved { model, blocks, report, .. } = solved(&graph, Divide::Blocks(count));
            assert_eq!(blocks.len(), count);
            assert_eq!(blocks.iter().flat_map(|b| b.0.clone()).collect::<Vec<_>>(), (0..model.solids.len()).collect::<Vec<_>>());
            let own = |s: &Solid| s.nodes[..s.own].to_vec();
            let mut nodes: Vec<NodeId> = model.solids.iter().flat_map(own).collect();
            nodes.sort_unstable();
            assert_eq!(nodes, graph.used_nodes().collect::<Vec<_>>());
            let sizes: Vec<usize> = blocks.iter().map(|b| model.solids[b.0.clone()].iter().map(|s| s.own).sum()).collect();
            assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1, "{sizes:?}");

            let volume: f64 = blocks.iter().map(|b| b.1.volume).sum();
            assert!((volume / one.report.volume_mm3 - 1.0).abs() < 1e-12 && (report.volume_mm3 / volume - 1.0).abs() < 1e-14);
            assert!(DVec3::from(report.centroid_mm).distance(one.report.centroid_mm.into()) < 1e-10);
            let discs = model.solids.iter().flat_map(|s| (0..s.struts.len()).filter_map(|k| disc(s, k)));
            let discs: f64 = discs.map(|(circle, _)| PI * circle.radius * circle.radius).sum();
            assert!((report.area_mm2 / (one.report.area_mm2 + discs) - 1.0).abs() < 1e-12);
            assert_eq!(discs == 0.0, count == 1);
        }
    }
}

#[test]
fn both_halves_of_a_strut_end_in_the_same_disc_and_all_else_is_as_in_the_one_solid() {
    for graph in lattices() {
        let one = &solved(&graph, Divide::Not).model.solids[0];
        let Solved { model, .. } = solved(&graph, Divide::Blocks(4));
        let mut discs: BTreeMap<StrutId, Vec<(Circle, DVec3)>> = BTreeMap::new();
        for solid in &model.solids {
            for (k, &strut) in solid.struts.iter().enumerate() {
                assert_eq!((solid.seams[k], solid.slopes[k]), (one.seams[strut.index()], one.slopes[strut.index()]));
                for end in (0..2).filter(|&e| (solid.ends[k][e] as usize) < solid.own) {
                    assert_eq!((solid.rim(k, end), solid.seam_ends(k)[end]), (one.rim(strut.index(), end), one.seam_ends(strut.index())[end]));
                }
                disc(solid, k).into_iter().for_each(|d| discs.entry(strut).or_default().push(d));
            }
        }
        assert!(discs.len() > 3);
        for (strut, halves) in discs {
            let [a, b] = halves[..] else { panic!("{} discs of strut {}", halves.len(), strut.0) };
            assert_eq!(a, b);
            let rims = [0, 1].map(|e| one.rim(strut.index(), e));
            assert!((a.0.center.distance(rims[0].center) - a.0.center.distance(rims[1].center)).abs() < 1e-12);
        }
    }
}

/// A thin strut through the fillet of a node: found across blocks as in the one solid.
#[test]
fn crossings_are_those_of_the_solid() {
    let crotch = r#"{"nodes": [[0,0,0],[8.7,5,0],[8.7,-5,0],[2.07,0,-5],[2.07,0,5]],
        "struts": [{"a":0,"b":1,"ra":1,"rb":1},{"a":0,"b":2,"ra":1,"rb":1},{"a":3,"b":4,"ra":0.02,"rb":0.02}]}"#;
    let graph = example(crotch);
    let wanted = crossings(&solved(&graph, Divide::Not).model);
    assert_eq!(wanted.len(), 1);
    for count in [2, 3, 5] {
        assert_eq!(crossings(&solved(&graph, Divide::Blocks(count)).model), wanted);
    }
    let clear = generate(Cell::Kelvin, 10.0, [2, 1, 1], 0.5).unwrap();
    assert_eq!(crossings(&solved(&clear, Divide::Blocks(3)).model), []);
}

fn export(input: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lattice-brep")).arg("export").arg(input).args(more).output().unwrap()
}

/// The files that a run writes, by name.
fn exported(input: &str, more: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.step");
    let run = export(Path::new(input), &[&["-o", output.to_str().unwrap(), "-q"], more].concat());
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let entries = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap());
    entries.map(|e| (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap())).collect()
}

#[test]
fn the_manifest_says_what_is_in_the_files_and_they_depend_on_nothing_else() {
    let run = |threads| exported("tests/examples/bcc.json", &["--blocks", "3", "--threads", threads]);
    let files = run("1");
    assert_eq!(files.keys().collect::<Vec<_>>(), ["out.block-1.step", "out.block-2.step", "out.block-3.step", "out.blocks.json", "out.step"]);
    assert!(files == run("2"));
    let manifest: serde_json::Value = serde_json::from_slice(&files["out.blocks.json"]).unwrap();
    let blocks = manifest["blocks"].as_array().unwrap();
    assert_eq!(blocks.len(), 3);
    for file in blocks.iter().chain([&manifest["master"]]) {
        let bytes = &files[file["file"].as_str().unwrap()];
        let sha256: String = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
        assert_eq!((file["sha256"].as_str(), file["bytes"].as_u64()), (Some(&sha256[..]), Some(bytes.len() as u64)));
    }
    let sum = |name: &str| blocks.iter().map(|b| b[name].as_u64().unwrap()).sum::<u64>();
    assert_eq!((sum("nodes"), manifest["nodes"].as_u64().unwrap()), (35, 35));
    assert_eq!((sum("struts") + sum("half_struts") / 2, manifest["struts"].as_u64().unwrap()), (64, 64));
    for block in blocks {
        let found = read_back(&files[block["file"].as_str().unwrap()][..]).unwrap();
        assert_eq!((found.faults(), found.dropped), (vec![], 0));
        assert_eq!(found.solids.len() as u64, block["solids"].as_u64().unwrap());
        assert_eq!(found.solids.iter().map(|s| s.cylinders as u64).sum::<u64>(), block["struts"].as_u64().unwrap() + block["half_struts"].as_u64().unwrap());
        assert_eq!((found.validation.volume, found.validation.area), (block["volume_mm3"].as_f64(), block["area_mm2"].as_f64()));
    }
    let master = read_back(&files["out.step"][..]).unwrap();
    assert_eq!((master.products.len(), master.dropped), (4, 0));
    assert_eq!(master.validation.volume, manifest["volume_mm3"].as_f64());
    let text = std::str::from_utf8(&files["out.step"]).unwrap();
    assert_eq!(text.matches("=NEXT_ASSEMBLY_USAGE_OCCURRENCE(").count(), 3);
    assert!(blocks.iter().all(|b| text.contains(&format!("=DOCUMENT_FILE('{}',", b["file"].as_str().unwrap()))));
}

/// The text of what an entity consists of, without numbers of entities.
fn expanded(lines: &HashMap<u64, &str>, id: u64, out: &mut Vec<String>) {
    let mut pieces = lines[&id].split('#');
    let mut own = pieces.next().unwrap().to_owned();
    for piece in pieces {
        let digits = piece.find(|c: char| !c.is_ascii_digit()).unwrap();
        own += &piece[digits..];
        expanded(lines, piece[..digits].parse().unwrap(), out);
    }
    out.push(own);
}

/// Of each disc: its circle with centre, axis and radius, and its vertex, as they stand in the file.
fn discs_in(text: &str) -> BTreeMap<String, Vec<String>> {
    let entities = text.split(";\n").filter_map(|l| l.trim_start().strip_prefix('#')?.split_once('='));
    let lines: HashMap<u64, &str> = entities.map(|(id, rest)| (id.parse().unwrap(), rest)).collect();
    let faces = lines.values().filter(|l| l.starts_with("ADVANCED_FACE('strut_") && l.contains("/disc'"));
    let disc = |line: &&str| {
        let bound = line.split_once("(#").unwrap().1;
        let mut out = vec![];
        expanded(&lines, bound[..bound.find(')').unwrap()].parse().unwrap(), &mut out);
        // the sense of the loop is another on the other side
        out.retain(|l| !l.starts_with("ORIENTED_EDGE") && !l.starts_with("FACE") && !l.starts_with("EDGE"));
        (line.split('\'').nth(1).unwrap().to_owned(), out)
    };
    faces.map(disc).collect()
}

#[test]
fn circles_between_two_files_are_the_same_text() {
    let files = exported("tests/examples/irregular.json", &["--blocks", "4"]);
    let mut seen: BTreeMap<String, Vec<Vec<String>>> = BTreeMap::new();
    for (_, bytes) in files.iter().filter(|f| f.0.contains(".block-")) {
        for (name, text) in discs_in(std::str::from_utf8(bytes).unwrap()) {
            seen.entry(name).or_default().push(text);
        }
    }
    assert!(!seen.is_empty());
    for (name, texts) in seen {
        let [a, b] = &texts[..] else { panic!("{name} in {} files", texts.len()) };
        assert_eq!(a, b, "{name}");
        let kinds: BTreeSet<&str> = a.iter().filter_map(|l| l.split('(').next()).collect();
        assert!(kinds.contains("CIRCLE") && kinds.contains("VERTEX_POINT"), "{kinds:?}");
    }
}

#[test]
fn what_cannot_be_divided_so_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.step");
    let packed = folder.path().join("out.stpZ");
    let (output, packed) = (output.to_str().unwrap(), packed.to_str().unwrap());
    for (arguments, words) in [
        (&["--blocks", "0", "-o", output][..], "--blocks: found 0, wanted at least 1"),
        (&["--blocks", "11", "-o", output], "--blocks: found 11 for 10 nodes, wanted at least 1, and at most the number of nodes"),
        (&["--blocks", "2", "--schema", "ap203", "-o", output], "--blocks: found --schema ap203"),
        (&["--blocks", "2", "-o", packed], "readers do not look into archives"),
        (&["--blocks", "2", "--assembly", "-o", output], "cannot be used with"),
    ] {
        let run = export(Path::new("tests/examples/irregular.json"), arguments);
        let told = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(2), "{told}");
        assert!(told.contains(words), "{told}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    assert!(export(Path::new("tests/examples/irregular.json"), &["--blocks", "10", "-q", "-o", output]).status.success());
}

#[test]
fn a_failure_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.step");
    std::fs::create_dir(folder.path().join("out.block-3.step")).unwrap();
    let run = export(Path::new("tests/examples/irregular.json"), &["--blocks", "3", "-o", output.to_str().unwrap()]);
    assert_eq!(run.status.code(), Some(1));
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["out.block-3.step"]);
}
