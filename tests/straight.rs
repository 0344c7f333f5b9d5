//! Nodes whose two struts are one cylinder or cone need no skin: export makes them one strut, and nothing else one.

use glam::{DVec3, dvec3};
use lattice_brep::brep::Caps;
use lattice_brep::graph::check::{Overlaps, admit};
use lattice_brep::graph::{Input, Strut};
use lattice_brep::ids::{NodeId, StrutId};
use lattice_brep::inspect::{Inspection, inspect};
use lattice_brep::options::{Divide, Options};
use lattice_brep::pipeline::{self, Silent};
use lattice_brep::report::{Counts, Report};
use std::f64::consts::PI;
use std::process::{Command, Output};

const START: DVec3 = dvec3(5.0, -3.0, 1.0);
const ALONG: DVec3 = dvec3(0.36, 0.48, 0.8);

/// Struts of this length (mm) in a straight line; strut k has these radii (mm).
fn row(count: u32, length: f64, radii: impl Fn(u32) -> [f64; 2]) -> Input {
    let nodes = (0..=count).map(|k| START + f64::from(k) * length * ALONG).collect();
    let struts = (0..count).map(|k| Strut { a: NodeId(k), b: NodeId(k + 1), ra: radii(k)[0], rb: radii(k)[1] }).collect();
    Input { name: None, nodes, struts }
}

/// Half a millimetre thick.
fn even(_: u32) -> [f64; 2] {
    [0.5; 2]
}

/// As `export` does, without the text.
fn exported(input: &Input, options: &Options) -> Report {
    let lattice = admit(input.clone(), vec![], Overlaps::Refuse).unwrap();
    let (lattice, repair) = pipeline::straighten(lattice);
    let mut report = pipeline::solve(&lattice, options, &Silent).unwrap().report;
    report.repairs.extend(repair);
    report
}

fn look(input: &Input) -> Inspection {
    inspect(input, "JSON", vec![], &Options::default())
}

/// Struts, nodes, cylinders, cones, patches, caps.
fn count(c: &Counts) -> [usize; 6] {
    [c.struts, c.nodes, c.cylinders, c.cones, c.patches, c.caps]
}

#[test]
fn a_row_is_one_cylinder() {
    let input = row(6, 4.0, even);
    let report = exported(&input, &Options::default());
    assert_eq!(count(&report.counts), [1, 2, 1, 0, 0, 2]);
    assert_eq!((report.counts.faces, report.counts.circles, report.counts.edges), (3, 2, 3));
    assert!((report.volume_mm3 / (PI * 0.25 * 24.0) - 1.0).abs() < 1e-12, "{}", report.volume_mm3);
    // which struts became one
    let [repair] = &report.repairs[..] else { panic!("{:?}", report.repairs) };
    assert_eq!(repair.struts.iter().map(|s| (s.strut.0, s.into)).collect::<Vec<_>>(), (0..6).map(|k| (k, Some(StrutId(0)))).collect::<Vec<_>>());
    assert_eq!(report.changes.len(), 1);
    let ball = exported(&input, &Options { caps: Caps::Sphere, ..Options::default() });
    assert!((ball.volume_mm3 / (PI * 0.25 * 24.0 + PI / 6.0) - 1.0).abs() < 1e-12, "{}", ball.volume_mm3);
    let parts = exported(&input, &Options { divide: Divide::Nodes, ..Options::default() });
    assert_eq!((parts.instances, count(&parts.counts)), (2, [2, 2, 2, 0, 0, 4]));
    assert_eq!((look(&input).repairs.straight_nodes, look(&input).estimate.faces), (5, 3));
}

#[test]
fn a_row_with_a_linear_taper_is_one_cone() {
    let report = exported(&row(6, 4.0, |k| [0, 1].map(|end| 0.5 + 0.05 * f64::from(k + end))), &Options::default());
    assert_eq!(count(&report.counts), [1, 2, 0, 1, 0, 2]);
    let volume = PI / 3.0 * 24.0 * (0.25 + 0.5 * 0.8 + 0.64);
    assert!((report.volume_mm3 / volume - 1.0).abs() < 1e-12, "{} against {volume}", report.volume_mm3);
}

#[test]
fn what_is_no_single_cylinder_or_cone_keeps_its_node() {
    let mut kinked = row(6, 4.0, even);
    let aside = ALONG.any_orthonormal_vector();
    (4..7).for_each(|k| kinked.nodes[k] += 4.0 * (k as f64 - 3.0) * 1e-6 * aside);
    assert_eq!(count(&exported(&kinked, &Options::default()).counts), [2, 3, 2, 0, 8, 2]);
    // a step of the radius, and a slope that ends
    let step = exported(&row(6, 4.0, |k| if k < 3 { [0.5; 2] } else { [0.5 + 1e-6; 2] }), &Options::default());
    assert_eq!(count(&step.counts)[..4], [2, 3, 2, 0]);
    let slope = exported(&row(2, 4.0, |k| [0.5, 0.5 + 0.1 * f64::from(k)]), &Options::default());
    assert_eq!(count(&slope.counts)[..4], [2, 3, 1, 1]);
    // a row that begins at the middle of another strut's length is joined to a node of degree 3: it stays
    let mut tee = row(2, 4.0, even);
    tee.nodes.push(tee.nodes[1] + 4.0 * aside);
    tee.struts.push(Strut { a: NodeId(1), b: NodeId(3), ra: 0.5, rb: 0.5 });
    let report = exported(&tee, &Options::default());
    assert_eq!((report.counts.struts, report.repairs.len(), report.changes.len()), (3, 0, 0));
}

/// The middle side of half the ring lies along the chord: all its nodes are equally far from it, but for round-off.
#[test]
fn the_corners_of_a_ring_stay_alone() {
    let (u, v) = (ALONG.any_orthonormal_vector(), ALONG.cross(ALONG.any_orthonormal_vector()));
    for (start, pieces) in (0..8).flat_map(|start| [2u32, 3, 5].map(|pieces| (start, pieces))) {
        let corner = |k: u32| (f64::from(k) * PI / 3.0 + 0.1).sin_cos();
        let place = |k: u32| {
            let [(s, c), (t, d)] = [corner(k / pieces), corner(k / pieces + 1)];
            let part = f64::from(k % pieces) / f64::from(pieces);
            START + 10.0 * ((c + part * (d - c)) * u + (s + part * (t - s)) * v)
        };
        let count = 6 * pieces;
        let struts = (0..count).map(|k| Strut { a: NodeId(k), b: NodeId((k + 1) % count), ra: 0.5, rb: 0.5 }).collect();
        let input = Input { name: None, nodes: (0..count).map(|k| place(k + start)).collect(), struts };
        assert_eq!(look(&input).repairs.straight_nodes, (count - 6) as usize, "{pieces} pieces from {start}");
    }
}

/// Pieces shorter than thick would overlap those after the next, and have no room for the cuts of the node they begin at.
#[test]
fn pieces_of_any_length_are_no_conflict() {
    let short = row(60, 0.4, even);
    assert_eq!(count(&exported(&short, &Options::default()).counts), [1, 2, 1, 0, 0, 2]);
    let arms = [dvec3(1.0, 0.0, 0.0), dvec3(-0.5, 0.8, 0.0), dvec3(-0.5, -0.5, 0.7), dvec3(0.0, 0.2, 1.0)];
    let (mut star, mut whole) = (Input::default(), Input::default());
    (star.nodes.push(START), whole.nodes.push(START));
    let strut = |a: usize, b: usize| Strut { a: NodeId(a as u32), b: NodeId(b as u32), ra: 0.5, rb: 0.5 };
    for along in arms.map(|arm| arm.normalize()) {
        for k in 1..=20 {
            star.nodes.push(START + 0.5 * f64::from(k) * along);
            let last = star.nodes.len() - 1;
            star.struts.push(strut(if k == 1 { 0 } else { last - 1 }, last));
        }
        whole.nodes.push(START + 10.0 * along);
        whole.struts.push(strut(0, whole.nodes.len() - 1));
    }
    let (found, wanted) = (exported(&star, &Options::default()), exported(&whole, &Options::default()));
    assert_eq!(found.counts, wanted.counts);
    assert!((found.volume_mm3 / wanted.volume_mm3 - 1.0).abs() < 1e-12);
    let i = look(&star);
    assert_eq!((i.repairs.straight_nodes, i.overlaps.len(), i.near_misses.len(), i.cut_conflicts.len()), (76, 0, 0, 0));
    assert_eq!((i.struts, i.estimate, i.export), (80, look(&whole).estimate, look(&whole).export));
    // what does overlap is named by the struts of the file
    let mut crossed = star.clone();
    let aside = arms[0].any_orthonormal_vector();
    crossed.nodes.extend([-1.0, 1.0].map(|side| START + 6.0 * arms[0] + (2.0 * side) * aside));
    crossed.struts.push(strut(81, 82));
    let Err(error) = admit(crossed.clone(), vec![], Overlaps::Refuse) else { panic!("refused") };
    assert!(error.to_string().contains("struts[80]: found its axis 0.000000 mm from that of struts[0]"), "{error}");
    assert_eq!(look(&crossed).overlaps.iter().map(|p| (p.a.0, p.b.0)).collect::<Vec<_>>(), [(0, 80)]);
}

/// Two struts 20° apart are too short for any cuts; each comes in two pieces.
#[test]
fn conflicts_are_named_as_in_the_file() {
    let along = |degrees: f64, length: f64| length * DVec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
    let nodes = vec![DVec3::ZERO, along(0.0, 1.0), along(0.0, 2.0), along(20.0, 1.0), along(20.0, 2.0)];
    let strut = |a, b| Strut { a: NodeId(a), b: NodeId(b), ra: 0.5, rb: 0.5 };
    let input = Input { name: None, nodes, struts: vec![strut(2, 1), strut(1, 0), strut(0, 3), strut(4, 3)] };
    let found: Vec<_> = look(&input).cut_conflicts.iter().map(|c| (c.strut.0, c.a.0, c.b.0, (c.length * 1e9).round())).collect();
    assert_eq!(found, [(0, 2, 0, 2e9), (2, 0, 4, 2e9)]);
}

fn run(arguments: &[&str]) -> Output {
    let done = Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(arguments).output().unwrap();
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    done
}

#[test]
fn the_commands_say_so_and_take_it_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let [file, step, report, fixed, back] = ["row.json", "row.step", "r.json", "fixed.json", "back.json"].map(path);
    let input = row(6, 4.0, even);
    lattice_brep::graph::json::write_input(&input, &mut std::fs::File::create(&file).unwrap()).unwrap();
    let said = String::from_utf8(run(&["export", &file, "-o", &step, "--report", &report]).stderr).unwrap();
    assert!(said.contains("5 of 7 nodes and 5 of 6 struts fewer") && said.contains("`lattice-brep repair --collapse-chains=1e-9` writes it"), "{said}");
    let text = std::fs::read_to_string(&step).unwrap();
    assert_eq!(text.matches("=CYLINDRICAL_SURFACE(").count(), 1);
    assert!(text.contains("ADVANCED_FACE('strut_0',") && text.matches("=ADVANCED_FACE(").count() == 3);
    std::fs::create_dir(folder.path().join("again")).unwrap();
    let again = path("again/row.step");
    for threads in ["1", "2", "8"] {
        run(&["export", &file, "-o", &again, "--threads", threads, "-q"]);
        assert_eq!(std::fs::read_to_string(&again).unwrap(), text);
    }
    // the same repair by hand gives what the record was made of
    run(&["repair", &file, "--collapse-chains=1e-9", "-o", &fixed]);
    run(&["repair", &fixed, "--undo", &report, "-o", &back]);
    let read = |path: &str| lattice_brep::graph::json::read(&std::fs::read(path).unwrap()).0;
    assert_eq!((read(&back), read(&fixed).struts.len()), (input, 1));
    // the part of the row in a box
    run(&["export", &file, "-o", &step, "--crop", "6,-1,5:11,6,15", "--report", &report]);
    let cropped: serde_json::Value = serde_json::from_slice(&std::fs::read(&report).unwrap()).unwrap();
    assert_eq!((&cropped["counts"]["cylinders"], &cropped["counts"]["faces"]), (&1.into(), &3.into()));
    // pieces too short for the cuts of their node are no reason to merge nodes
    let bent = r#"{"nodes":[[0,0,0],[0.2,0,0],[20,0,0],[0,20,0],[0,0,20]],"struts":[{"a":0,"b":1,"ra":1,"rb":1},{"a":1,"b":2,"ra":1,"rb":1},{"a":0,"b":3,"ra":1,"rb":1},{"a":0,"b":4,"ra":1,"rb":1}]}"#;
    std::fs::write(&file, bent).unwrap();
    run(&["repair", &file, "--merge", "-o", &fixed]);
    assert_eq!(read(&fixed).nodes, [DVec3::ZERO, 20.0 * DVec3::X, 20.0 * DVec3::Y, 20.0 * DVec3::Z]);
}
