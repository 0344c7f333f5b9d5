//! `--assembly`: units placed at the nodes are the lattice again.

use glam::DVec3;
use lattice_brep::brep::{Instance, crossings, unit_crossings};
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::check::Overlaps;
use lattice_brep::graph::{Graph, Lattice, json};
use lattice_brep::options::{Divide, Options};
use lattice_brep::pipeline::{Silent, Solved, solve, write};
use lattice_brep::step::read_back;
use std::collections::HashMap;

fn solved(graph: &Graph, assembly: bool) -> Solved {
    let lattice = Lattice { name: None, graph: graph.clone(), notes: vec![] };
    let divide = if assembly { Divide::Nodes } else { Divide::Not };
    let options = Options { divide, overlaps: Overlaps::Keep, ..Options::default() };
    solve(&lattice, &options, &Silent).unwrap_or_else(|e| panic!("{e}"))
}

fn irregular() -> Graph {
    let (input, _) = json::read(include_bytes!("examples/irregular.json"));
    Graph::new(input.nodes, input.struts)
}

#[test]
fn every_node_is_placed_once_and_equal_nodes_share_a_unit() {
    let graph = generate(Cell::Bcc, 8.0, [3, 3, 3], 0.5).unwrap();
    let Solved { model, instances, report, .. } = solved(&graph, true);
    assert_eq!(instances.iter().map(|i| i.node).collect::<Vec<_>>(), graph.used_nodes().collect::<Vec<_>>());
    assert!(instances.iter().all(|i| i.at == graph.nodes()[i.node.index()]));
    // 8 ends, nodes on 12 edges and 6 faces, 8 centres whose strut to an end is cut elsewhere, and one for all others inside
    assert_eq!((model.solids.len(), report.instances), (8 + 12 + 6 + 8 + 1, 91));
    let inside: Vec<&Instance> = instances.iter().filter(|i| model.solids[i.unit as usize].struts.len() == 8).collect();
    assert_eq!(inside.len(), 27 + 8);
}

#[test]
fn parts_have_the_volume_of_the_solid_and_touch_in_discs() {
    for graph in [irregular(), generate(Cell::Octet, 10.0, [2, 1, 1], 0.5).unwrap()] {
        let (parts, one) = (solved(&graph, true), solved(&graph, false));
        assert!((parts.report.volume_mm3 / one.report.volume_mm3 - 1.0).abs() < 1e-9);
        let centroids = [&parts, &one].map(|s| DVec3::from(s.report.centroid_mm));
        assert!(centroids[0].distance(centroids[1]) < 1e-9);
        // a disc on both sides in every strut
        let discs: f64 = graph.struts().iter().map(|s| 2.0 * std::f64::consts::PI * s.ra * s.rb).sum();
        assert!((parts.report.area_mm2 / (one.report.area_mm2 + discs) - 1.0).abs() < 1e-9);
    }
}

/// A thin strut through the fillet of a node, and a lattice that is clear.
#[test]
fn crossings_are_those_of_the_solid() {
    let crotch = br#"{"nodes": [[0,0,0],[8.7,5,0],[8.7,-5,0],[2.07,0,-5],[2.07,0,5]],
        "struts": [{"a":0,"b":1,"ra":1,"rb":1},{"a":0,"b":2,"ra":1,"rb":1},{"a":3,"b":4,"ra":0.02,"rb":0.02}]}"#;
    let (input, faults) = json::read(crotch);
    assert_eq!(faults, []);
    let pierced = Graph::new(input.nodes, input.struts);
    let (parts, one) = (solved(&pierced, true), solved(&pierced, false));
    let (found, wanted) = (unit_crossings(&pierced, &parts.model, &parts.instances), crossings(&one.model));
    assert_eq!((found.len(), wanted.len()), (1, 1));
    assert_eq!((found[0].node, found[0].other), (wanted[0].node, wanted[0].other));
    assert!((found[0].clearance - wanted[0].clearance).abs() < 1e-9);
    let clear = generate(Cell::Kelvin, 10.0, [2, 2, 2], 0.5).unwrap();
    let Solved { model, instances, .. } = solved(&clear, true);
    assert_eq!(unit_crossings(&clear, &model, &instances), []);
}

#[test]
fn an_independent_reader_finds_all_units_sound() {
    let graph = irregular();
    let options = Options { divide: Divide::Nodes, ..Options::default() };
    let mut solved = solved(&graph, true);
    let mut text = vec![];
    write(&mut solved, &options, &mut text, &Silent).unwrap();
    let occurrences = String::from_utf8_lossy(&text).matches("=NEXT_ASSEMBLY_USAGE_OCCURRENCE(").count();
    assert_eq!(occurrences, graph.nodes().len());
    let found = read_back(&text[..]).unwrap();
    assert_eq!((found.faults(), found.dropped), (vec![], 0));
    assert_eq!((found.solids.len(), found.products.len()), (solved.model.solids.len(), solved.model.solids.len() + 1));
    assert!((found.validation.volume.unwrap() / solved.report.volume_mm3 - 1.0).abs() < 1e-15);
}

/// The number after `key` in a line of STEP text.
fn number_after(line: &str, key: &str) -> u64 {
    let rest = line.split_once(key).unwrap_or_else(|| panic!("{key} in {line}")).1;
    rest[..rest.find(|c: char| !c.is_ascii_digit()).unwrap()].parse().unwrap()
}

#[test]
fn many_nodes_stand_in_blocks_each_once_in_its_place() {
    let graph = generate(Cell::Bcc, 7.3, [6, 6, 6], 0.4).unwrap();
    let mut solved = solved(&graph, true);
    let mut text = vec![];
    write(&mut solved, &Options { divide: Divide::Nodes, ..Options::default() }, &mut text, &Silent).unwrap();
    let found = read_back(&text[..]).unwrap();
    assert_eq!((found.faults(), found.dropped, found.solids.len()), (vec![], 0, solved.model.solids.len()));

    let text = String::from_utf8(text).unwrap();
    let lines: HashMap<u64, &str> = text.split(";\n").filter(|l| l.starts_with('#')).map(|l| (number_after(l, "#"), l)).collect();
    // from parent to members: (child, name, place)
    let mut members: HashMap<u64, Vec<(u64, String, DVec3)>> = HashMap::new();
    let mut uses: HashMap<u64, usize> = HashMap::new();
    for (id, line) in lines.iter().filter(|(_, l)| l.contains("=NEXT_ASSEMBLY_USAGE_OCCURRENCE(")) {
        let (parent, child) = (number_after(line, "'',#"), number_after(line.rsplit_once(",#").unwrap().1, ""));
        let name = line.split('\'').nth(3).unwrap().to_owned();
        let point = lines[&(id - 3)].split_once(",(").unwrap().1.trim_end_matches(')');
        let place: Vec<f64> = point.split(',').map(|x| x.parse().unwrap()).collect();
        members.entry(parent).or_default().push((child, name, DVec3::from_slice(&place)));
        *uses.entry(child).or_default() += 1;
    }
    assert!(members.len() > 1 && members.values().all(|m| m.len() <= 256) && uses.values().all(|&n| n <= 256));
    let mut places = vec![None; graph.nodes().len()];
    let mut waiting = vec![(8, DVec3::ZERO)];
    while let Some((product, at)) = waiting.pop() {
        for (child, name, place) in members.get(&product).into_iter().flatten() {
            match name.strip_prefix("node_") {
                Some(node) => assert_eq!(places[node.parse::<usize>().unwrap()].replace(at + *place), None),
                None => waiting.push((*child, at + *place)),
            }
        }
    }
    assert_eq!(places, graph.nodes().iter().map(|&p| Some(p)).collect::<Vec<_>>());
}
