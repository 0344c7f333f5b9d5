//! Unit cells against closed formulas: counts, degrees, lengths; and no node or crossing that should not be.

use lattice_brep::error::Error;
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::check::check;
use lattice_brep::graph::components::components;
use lattice_brep::graph::proximity::near_misses;
use lattice_brep::graph::{Graph, Input};
use std::collections::BTreeMap;

const REPEATS: [[u32; 3]; 5] = [[1, 1, 1], [2, 2, 2], [3, 3, 3], [1, 2, 3], [4, 1, 1]];

fn block(cell: Cell, repeat: [u32; 3]) -> Graph {
    generate(cell, 10.0, repeat, 0.25).unwrap()
}

/// Number of nodes and struts in a block, from counting its cubes, square faces, edges and corners.
fn counts(cell: Cell, [x, y, z]: [u32; 3]) -> (u32, u32) {
    let cubes = x * y * z;
    let corners = (x + 1) * (y + 1) * (z + 1);
    let edges = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
    let faces = (x + 1) * y * z + x * (y + 1) * z + x * y * (z + 1);
    match cell {
        Cell::Cubic => (corners, edges),
        Cell::Bcc => (corners + cubes, 8 * cubes),
        Cell::BccEdges => (corners + cubes, 8 * cubes + edges),
        Cell::Fcc => (corners + faces, 4 * faces),
        Cell::Octet => (corners + faces, 4 * faces + 12 * cubes),
        // Four of the block's own eight corners have no bond.
        Cell::Diamond => (corners - 4 + faces + 4 * cubes, 16 * cubes),
        Cell::Kelvin => (4 * faces, 4 * faces + 12 * cubes),
    }
}

/// Strut length in one cell of 10 mm; two where cubic edges and diagonals mix.
fn lengths(cell: Cell) -> Vec<f64> {
    let half_space_diagonal = 5.0 * 3f64.sqrt();
    match cell {
        Cell::Cubic => vec![10.0],
        Cell::Bcc => vec![half_space_diagonal],
        Cell::BccEdges => vec![half_space_diagonal, 10.0],
        Cell::Fcc | Cell::Octet => vec![5.0 * 2f64.sqrt()],
        Cell::Diamond => vec![half_space_diagonal / 2.0],
        Cell::Kelvin => vec![2.5 * 2f64.sqrt()],
    }
}

/// How many nodes have each degree.
fn degrees(graph: &Graph) -> BTreeMap<usize, usize> {
    let mut count = BTreeMap::new();
    graph.node_ids().for_each(|n| *count.entry(graph.degree(n)).or_default() += 1);
    count
}

#[test]
fn counts_follow_the_closed_formulas() {
    for (cell, repeat) in Cell::ALL.into_iter().flat_map(|cell| REPEATS.map(|repeat| (cell, repeat))) {
        let graph = block(cell, repeat);
        let found = (graph.nodes().len() as u32, graph.struts().len() as u32);
        assert_eq!(found, counts(cell, repeat), "{} {repeat:?}", cell.name());
    }
}

#[test]
fn blocks_pass_every_check_and_are_one_part_with_no_node_to_spare() {
    for (cell, repeat) in Cell::ALL.into_iter().flat_map(|cell| REPEATS.map(|repeat| (cell, repeat))) {
        let graph = block(cell, repeat);
        let input = Input { name: None, nodes: graph.nodes().to_vec(), struts: graph.struts().to_vec() };
        assert_eq!(check(&input), vec![], "{} {repeat:?}", cell.name());
        assert_eq!(components(&graph).count(), 1, "{} {repeat:?}", cell.name());
        assert_eq!(graph.used_nodes().count(), graph.nodes().len(), "{} {repeat:?}", cell.name());
    }
}

#[test]
fn thick_struts_meet_only_at_nodes() {
    // No two struts without a common node come closer than 40 % of the shortest strut's length.
    for cell in Cell::ALL {
        let shortest = lengths(cell).into_iter().fold(f64::INFINITY, f64::min);
        let graph = generate(cell, 10.0, [2, 2, 2], 0.2 * shortest).unwrap();
        assert_eq!(near_misses(&graph), vec![], "{}", cell.name());
    }
}

#[test]
fn strut_lengths_are_exact() {
    for cell in Cell::ALL {
        let graph = block(cell, [2, 2, 2]);
        let mut used = vec![false; lengths(cell).len()];
        for k in 0..graph.struts().len() as u32 {
            let length = graph.length(lattice_brep::ids::StrutId(k));
            let which = lengths(cell).iter().position(|l| (l - length).abs() < 1e-12);
            used[which.unwrap_or_else(|| panic!("{}: length {length}", cell.name()))] = true;
        }
        assert!(used.iter().all(|&u| u), "{}", cell.name());
    }
}

#[test]
fn inner_nodes_have_the_degree_of_the_crystal() {
    let inner_degrees = |cell: Cell| {
        let graph = block(cell, [3, 3, 3]);
        let inner = |n: &lattice_brep::ids::NodeId| graph.nodes()[n.index()].to_array().iter().all(|x| (0.1..29.9).contains(x));
        let mut found: Vec<usize> = graph.node_ids().filter(inner).map(|n| graph.degree(n)).collect();
        found.sort_unstable();
        found.dedup();
        found
    };
    assert_eq!(inner_degrees(Cell::Cubic), [6]);
    assert_eq!(inner_degrees(Cell::Bcc), [8]);
    assert_eq!(inner_degrees(Cell::BccEdges), [8, 14]);
    assert_eq!(inner_degrees(Cell::Fcc), [4, 12]);
    assert_eq!(inner_degrees(Cell::Octet), [12]);
    assert_eq!(inner_degrees(Cell::Diamond), [4]);
    assert_eq!(inner_degrees(Cell::Kelvin), [4]);
}

#[test]
fn one_cell_has_the_degrees_of_its_polyhedron() {
    assert_eq!(degrees(&block(Cell::Cubic, [1; 3])), BTreeMap::from([(3, 8)]));
    assert_eq!(degrees(&block(Cell::Bcc, [1; 3])), BTreeMap::from([(1, 8), (8, 1)]));
    assert_eq!(degrees(&block(Cell::BccEdges, [1; 3])), BTreeMap::from([(4, 8), (8, 1)]));
    assert_eq!(degrees(&block(Cell::Fcc, [1; 3])), BTreeMap::from([(3, 8), (4, 6)]));
    assert_eq!(degrees(&block(Cell::Octet, [1; 3])), BTreeMap::from([(3, 8), (8, 6)]));
    assert_eq!(degrees(&block(Cell::Diamond, [1; 3])), BTreeMap::from([(1, 4), (2, 6), (4, 4)]));
    assert_eq!(degrees(&block(Cell::Kelvin, [1; 3])), BTreeMap::from([(3, 24)]));
}

#[test]
fn nodes_are_ordered_by_z_y_x_and_struts_by_their_ends() {
    for cell in Cell::ALL {
        let graph = block(cell, [2, 3, 1]);
        assert!(graph.nodes().is_sorted_by(|p, q| [p.z, p.y, p.x] < [q.z, q.y, q.x]), "{}", cell.name());
        assert!(graph.struts().is_sorted_by(|s, t| (s.a, s.b) < (t.a, t.b)), "{}", cell.name());
        assert!(graph.struts().iter().all(|s| s.a < s.b && s.ra == 0.25 && s.rb == 0.25), "{}", cell.name());
    }
}

#[test]
fn names_read_back() {
    for cell in Cell::ALL {
        assert_eq!(cell.name().parse(), Ok(cell));
    }
    assert_eq!("gyroid".parse::<Cell>().unwrap_err().found, "gyroid");
}

#[test]
fn bad_parameters_are_all_refused() {
    let Err(Error::BadInput(faults)) = generate(Cell::Bcc, -1.0, [3, 0, 3], f64::NAN) else { panic!("refused") };
    assert_eq!(faults.iter().map(|f| f.path.as_str()).collect::<Vec<_>>(), ["size", "radius", "repeat"]);
    let Err(Error::BadInput(faults)) = generate(Cell::Bcc, 1.0, [u32::MAX; 3], 0.1) else { panic!("refused") };
    assert_eq!(faults.iter().map(|f| f.path.as_str()).collect::<Vec<_>>(), ["repeat"]);
}
