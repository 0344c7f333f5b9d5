//! `inspect`: figures of known cells, faulty lattices, the command, and that scale and place change nothing.

use glam::{DVec3, dvec3};
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::{Input, Strut};
use lattice_brep::ids::{NodeId, StrutId};
use lattice_brep::inspect::{Class, DegreeCount, Inspection, inspect, schema};
use lattice_brep::options::Options;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn cell(cell: Cell, size: f64, radius: f64) -> Input {
    let graph = generate(cell, size, [2; 3], radius).unwrap();
    Input { name: Some("cell".into()), nodes: graph.nodes().to_vec(), struts: graph.struts().to_vec() }
}

fn look(input: &Input) -> Inspection {
    inspect(input, "test", vec![], &Options::default())
}

fn strut(a: u32, b: u32, r: f64) -> Strut {
    Strut { a: NodeId(a), b: NodeId(b), ra: r, rb: r }
}

#[test]
fn figures_of_a_block_of_bcc() {
    let i = look(&cell(Cell::Bcc, 10.0, 0.5));
    assert_eq!((i.nodes, i.struts, i.bare_nodes, i.unsound_struts), (35, 64, 0, 0));
    assert_eq!(i.bounds, Some([[0.0; 3], [20.0; 3]]));
    let degrees: Vec<_> = i.degrees.iter().map(|d| (d.degree, d.nodes)).collect();
    assert_eq!(degrees, [(1, 8), (2, 12), (4, 6), (8, 9)]);
    let length = 75f64.sqrt();
    let lengths = i.lengths.unwrap();
    assert!((lengths.least - length).abs() < 1e-12 && (lengths.most - length).abs() < 1e-12);
    assert!((i.slenderness.unwrap().median - 2.0 * length).abs() < 1e-12);
    // cos = 1/3 between neighbouring diagonals of a cube, at all nodes but the 8 of degree 1
    let angles = i.angles.unwrap();
    assert!((angles.least - (1.0f64 / 3.0).acos().to_degrees()).abs() < 1e-9 && (angles.most - angles.least).abs() < 1e-9);
    assert_eq!(i.angle_classes.iter().map(|c| c.count).sum::<usize>(), 27);
    assert_eq!(i.angle_classes[7], Class { below: Some(90.0), count: 27 });
    assert_eq!((i.radii.different, i.radii.tapered, i.radii.unequal_nodes), (1, 0, 0));
    assert_eq!((i.components.len(), i.components[0].loops), (1, 64 + 1 - 35));
    assert!(i.faults.is_empty() && i.cut_conflicts.is_empty() && i.overlaps.is_empty() && i.near_misses.is_empty());
    assert!(i.export.accepted && i.export.exit_code == 0);
    assert_eq!(i.estimate.faces, 744, "as exported: 64 cylinders, 672 patches, 8 caps");
}

#[test]
fn conflicts_are_those_that_export_refuses() {
    let i = look(&cell(Cell::Octet, 10.0, 2.0));
    assert_eq!(i.cut_conflicts.len(), 240);
    let c = &i.cut_conflicts[0];
    // the least cut: caps that almost touch, half the angle of 60° each
    let least = 2.0 / 30f64.to_radians().tan();
    assert!(c.cuts[0] > least && c.cuts[0] < 1.1 * least && (c.length - 50f64.sqrt()).abs() < 1e-12, "{c:?}");
    assert_eq!((i.export.accepted, i.export.exit_code), (false, 3));
    assert_eq!(i.export.reasons, ["240 struts are too short for any cuts (see --on-conflict)"]);
}

#[test]
fn overlaps_and_near_misses_are_told_apart_with_distance_and_place() {
    let pair = |height: f64| {
        let nodes = vec![dvec3(-5.0, 0.0, 0.0), dvec3(5.0, 0.0, 0.0), dvec3(0.0, -5.0, height), dvec3(0.0, 5.0, height)];
        look(&Input { name: None, nodes, struts: vec![strut(0, 1, 0.5), strut(2, 3, 0.5)] })
    };
    let i = pair(0.8);
    assert_eq!((i.overlaps.len(), i.near_misses.len(), i.components.len()), (1, 0, 2));
    let p = &i.overlaps[0];
    assert_eq!((p.a, p.b, p.distance, p.allowed, p.at), (StrutId(0), StrutId(1), 0.8, 1.0, [0.0, 0.0, 0.4]));
    let i = pair(1.2);
    assert_eq!((i.overlaps.len(), i.near_misses.len()), (0, 1));
    assert!(i.export.accepted && i.export.reasons == ["2 solids"]);
    assert_eq!(pair(1.3).near_misses.len(), 0);
}

#[test]
fn faulty_lattices_are_described_as_far_as_they_can_be() {
    let mut input = cell(Cell::Bcc, 10.0, 0.5);
    input.nodes[0].x = f64::NAN;
    input.struts[20].b = NodeId(999);
    input.struts[21].ra = -1.0;
    input.struts[22].rb = 0.7;
    let i = look(&input);
    let paths: Vec<&str> = i.faults.iter().map(|f| f.path.as_str()).collect();
    for path in ["nodes[0][0]", "struts[20].b", "struts[21].ra"] {
        assert!(paths.contains(&path), "{path} in {paths:?}");
    }
    assert_eq!((i.unsound_struts, i.bare_nodes), (3, 1), "the strut at node 0, 20 and 21");
    assert_eq!((i.radii.tapered, i.radii.different), (1, 2));
    assert_eq!(i.lengths.as_ref().map(|l| l.least), look(&cell(Cell::Bcc, 10.0, 0.5)).lengths.map(|l| l.least));
    assert!(!i.export.accepted);
    let empty = look(&Input::default());
    assert_eq!((empty.faults.len(), empty.lengths, empty.estimate.faces), (2, None, 0));
}

#[test]
fn ids_are_those_of_the_input_also_behind_unsound_struts() {
    let mut input = cell(Cell::Octet, 10.0, 2.0);
    input.struts.insert(0, strut(0, 999, 2.0));
    assert_eq!(look(&input).cut_conflicts.last().unwrap().strut, StrutId(240));
}

#[test]
fn hints_say_what_the_repairs_would_remove() {
    let nodes = (0..5).map(|k| DVec3::X * 10.0 * f64::from(k)).chain([dvec3(0.0, 50.0, 0.0), dvec3(0.1, 50.0, 0.0), DVec3::Y * 70.0]).collect();
    let i = look(&Input { name: None, nodes, struts: vec![strut(0, 1, 0.5), strut(1, 2, 0.5), strut(2, 3, 0.5), strut(3, 4, 0.5), strut(5, 6, 0.5)] });
    assert_eq!((i.repairs.chain_nodes, i.repairs.loose_struts, i.repairs.loose_nodes), (3, 1, 3));
}

/// What must not change with scale and place: all counts, and the figures that have no unit.
fn counts(i: &Inspection) -> impl PartialEq + std::fmt::Debug {
    let sizes = (i.nodes, i.struts, i.bare_nodes, i.unsound_struts, i.components.clone());
    let classes = (i.degrees.iter().map(|d| (d.degree, d.nodes)).collect::<Vec<_>>(), i.angle_classes.clone(), i.slenderness_classes.clone());
    let ids = |pairs: &[lattice_brep::inspect::Pair]| pairs.iter().map(|p| (p.a, p.b)).collect::<Vec<_>>();
    let conflicts = i.cut_conflicts.iter().map(|c| c.strut).collect::<Vec<_>>();
    (sizes, classes, conflicts, ids(&i.overlaps), ids(&i.near_misses), i.faults.iter().map(|f| f.path.clone()).collect::<Vec<_>>(), i.export.clone())
}

/// An irregular lattice with a cut that does not fit, a near miss, and two parts.
fn mixed() -> Input {
    let mut input = cell(Cell::Octet, 10.0, 0.5);
    for (k, p) in input.nodes.iter_mut().enumerate() {
        let t = k as f64;
        *p += 0.7 * dvec3((3.1 * t).sin(), (5.7 * t).sin(), (7.3 * t).cos());
    }
    let n = input.nodes.len() as u32;
    input.nodes.extend([dvec3(40.0, 0.0, 0.0), dvec3(40.3, 0.0, 0.0), dvec3(40.0, 0.3, 0.0), dvec3(50.0, 0.0, 1.1), dvec3(30.0, 0.5, 1.1)]);
    input.struts.extend([strut(n, n + 1, 0.5), strut(n, n + 2, 0.5), strut(n + 3, n + 4, 0.5)]);
    input
}

#[test]
fn scale_and_place_change_no_count() {
    let plain = mixed();
    let expected = look(&plain);
    assert!(!expected.cut_conflicts.is_empty() && expected.overlaps.len() + expected.near_misses.len() > 0 && expected.components.len() == 3);
    assert!(expected.faults.is_empty(), "{:?}", expected.faults);
    for scale in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let mut other = plain.clone();
        other.nodes.iter_mut().for_each(|p| *p *= scale);
        other.struts.iter_mut().for_each(|s| (s.ra, s.rb) = (s.ra * scale, s.rb * scale));
        assert_eq!(counts(&look(&other)), counts(&expected), "scaled by {scale}");
    }
    // A step of doubles is 1e-10 mm there: a strut of 0.5 mm keeps nine digits and more.
    for far in [dvec3(1e6, 0.0, 0.0), dvec3(-1e6, 1e6, 1e6)] {
        for scale in [1.0, 1e3] {
            let mut other = plain.clone();
            other.nodes.iter_mut().for_each(|p| *p = *p * scale + far);
            other.struts.iter_mut().for_each(|s| (s.ra, s.rb) = (s.ra * scale, s.rb * scale));
            assert_eq!(counts(&look(&other)), counts(&expected), "scaled by {scale}, moved by {far}");
        }
    }
}

#[test]
fn a_micrometre_lattice_a_kilometre_away_is_refused_and_told_why() {
    let mut far = mixed();
    far.nodes.iter_mut().for_each(|p| *p = *p * 1e-3 + DVec3::X * 1e6);
    far.struts.iter_mut().for_each(|s| (s.ra, s.rb) = (s.ra * 1e-3, s.rb * 1e-3));
    // a step of 2.2e-10 mm is below a millionth of the 0.5 µm radius
    assert!(look(&far).faults.is_empty());
    far.struts.iter_mut().for_each(|s| (s.ra, s.rb) = (s.ra * 1e-1, s.rb * 1e-1));
    far.nodes.iter_mut().for_each(|p| p.x += 1e6);
    let faults = look(&far).faults;
    assert!(faults.iter().any(|f| f.path == "nodes" && f.wanted.contains("near the origin")), "{faults:?}");
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn stdout(out: &Output) -> String {
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8(out.stdout.clone()).unwrap()
}

#[test]
fn the_command_prints_a_page_and_json_that_fits_its_schema() {
    let page = stdout(&run(&["inspect", "tests/examples/bcc.json"]));
    for wanted in [
        "nodes         35",
        "struts        64",
        "degrees       1: 8  2: 12  4: 6  8: 9",
        "would build 1 solid",
        "angles        70.529°; of each node the smallest",
        "744 faces",
    ] {
        assert!(page.contains(wanted), "{wanted} in\n{page}");
    }
    assert!(page.lines().all(|l| l.trim_end() == l), "no blanks at the end of a line");
    let json: serde_json::Value = serde_json::from_str(&stdout(&run(&["inspect", "tests/examples/bcc.json", "--json"]))).unwrap();
    assert_eq!((json["estimate"]["faces"].as_u64(), json["degrees"][3]["degree"].as_u64()), (Some(744), Some(8)));
    let schema: serde_json::Value = serde_json::from_str(&schema()).unwrap();
    assert_eq!(stdout(&run(&["schema", "--inspect"])), lattice_brep::inspect::schema());
    let declared = |v: &serde_json::Value| v.as_object().unwrap().keys().cloned().collect::<std::collections::BTreeSet<_>>();
    assert_eq!(declared(&json), declared(&schema["properties"]));
}

#[test]
fn the_command_describes_a_faulty_file_and_refuses_what_is_no_file() {
    let folder = Folder::new();
    let bad = folder.write("bad.json", r#"{"nodes":[[0,0,0],[9,0,0],[0,9]],"struts":[{"a":0,"b":1,"ra":1,"rb":1},{"a":0,"b":7,"ra":1,"rb":"x"}]}"#);
    let page = stdout(&run(&["inspect", text(&bad), "--weld", "0.1"]));
    for wanted in ["faults        3", "nodes[2]: found 2 values", "struts[1].b: found 7", "would refuse: 3 faults", "struts        2 (1 unsound"] {
        assert!(page.contains(wanted), "{wanted} in\n{page}");
    }
    assert_eq!(run(&["inspect", text(&folder.0.path().join("none.json"))]).status.code(), Some(1));
}

#[test]
fn the_commands_repair_and_take_back() {
    let folder = Folder::new();
    let chain = r#"{"nodes":[[0,0,0],[10,0,0],[20,0,0],[20,10,0],[20,20,0],[90,0,0],[91,0,0]],
        "struts":[{"a":0,"b":1,"ra":1,"rb":1},{"a":1,"b":2,"ra":1,"rb":1},{"a":2,"b":3,"ra":1,"rb":1},{"a":3,"b":4,"ra":1,"rb":1},{"a":5,"b":6,"ra":0.1,"rb":0.1}]}"#;
    let part = folder.write("part.json", chain);
    let (fixed, report, back, step) =
        (folder.0.path().join("fixed.json"), folder.0.path().join("r.json"), folder.0.path().join("back.json"), folder.0.path().join("part.step"));
    let flags = ["--drop-loose", "--collapse-chains"];
    let out = run(&[&["repair", text(&part), "-o", text(&fixed), "--report", text(&report)], &flags[..]].concat());
    stdout(&out);
    let said = String::from_utf8(out.stderr).unwrap();
    assert!(said.contains("drop-loose") && said.contains("numbers from here on"), "{said}");
    let read = |path: &Path| lattice_brep::graph::json::read(&std::fs::read(path).unwrap()).0;
    assert_eq!((read(&fixed).nodes.len(), read(&fixed).struts.len()), (3, 2));
    stdout(&run(&["repair", text(&fixed), "--undo", text(&report), "-o", text(&back)]));
    assert_eq!(read(&back), read(&part));
    // export makes the same repairs, and its report holds the same record
    let export_report = folder.0.path().join("e.json");
    let out = run(&[&["export", text(&part), "-o", text(&step), "--report", text(&export_report), "-q"], &flags[..]].concat());
    stdout(&out);
    let json = |path: &Path| serde_json::from_slice::<serde_json::Value>(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(json(&export_report)["repairs"], json(&report)["repairs"]);
    assert_eq!(json(&export_report)["counts"]["struts"], 2);
    assert_eq!(json(&export_report)["changes"].as_array().unwrap().len(), 2);
    stdout(&run(&["repair", text(&fixed), "--undo", text(&export_report), "-o", text(&back)]));
    assert_eq!(read(&back), read(&part));
    // a record of another lattice
    assert_eq!(run(&["repair", text(&part), "--undo", text(&report)]).status.code(), Some(2));
    for wrong in [["--weld", "0"], ["--weld", "nan"], ["--drop-loose=2", "-q"], ["--merge", "--merge-angle=60"]] {
        assert_eq!(run(&[&["repair", text(&part)], &wrong[..]].concat()).status.code(), Some(2), "{wrong:?}");
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_is_written_to_and_not_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = Folder::new();
    let pipe = folder.0.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read(pipe).unwrap()
    });
    stdout(&run(&["schema", "-o", text(&pipe)]));
    assert!(reader.join().unwrap().starts_with(b"{"));
    assert!(pipe.symlink_metadata().unwrap().file_type().is_fifo());
}

#[test]
fn degree_counts_are_listed_once_each() {
    let nodes = (0..4).map(|k| DVec3::X * f64::from(k) * 10.0).collect();
    let i = look(&Input { name: None, nodes, struts: vec![strut(0, 1, 1.0), strut(1, 2, 1.0)] });
    assert_eq!(i.degrees, [DegreeCount { degree: 1, nodes: 2 }, DegreeCount { degree: 2, nodes: 1 }]);
    assert_eq!(i.bare_nodes, 1);
}
