//! Nodes of one star are built once, and are what they would be if built alone.

use lattice_brep::graph::Lattice;
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::options::Options;
use lattice_brep::pipeline::{Silent, solve, write};
use lattice_brep::settle::Settling;
use std::cell::Cell as Counter;
use std::sync::Arc;

#[test]
fn equal_stars_share_one_skin_and_it_is_the_same_to_the_bit() {
    let graph = generate(Cell::Bcc, 8.0, [3, 3, 3], 0.5).unwrap();
    let built = Counter::new(0);
    let all = Settling::new(&graph, &Options::default()).unwrap().settle(&|count| built.set(built.get() + count), &|| ()).unwrap();
    // the corners of the lattice, its edges and faces, and one star for all inside: the 8 corners there see what the 27 centres see
    assert_eq!(built.get(), 8 + 12 + 6 + 1);
    let full: Vec<_> = graph.node_ids().filter(|&n| graph.degree(n) == 8).map(|n| all.built[n.index()].as_ref().unwrap()).collect();
    assert!(full.len() == 35 && full.iter().all(|b| Arc::ptr_eq(b, full[0])));

    let cell = generate(Cell::Bcc, 8.0, [1, 1, 1], 0.5).unwrap();
    let alone = Settling::new(&cell, &Options::default()).unwrap().settle(&|_| (), &|| ()).unwrap();
    let centre = cell.node_ids().find(|&n| cell.degree(n) == 8).unwrap();
    assert_eq!(format!("{:?}", full[0].skin.skin()), format!("{:?}", alone.built[centre.index()].as_ref().unwrap().skin.skin()));
}

/// What `--no-cache` asks for.
#[test]
fn each_built_for_itself_gives_the_same_bytes() {
    let lattice = Lattice { name: None, graph: generate(Cell::Bcc, 8.0, [2, 2, 2], 0.5).unwrap(), notes: vec![] };
    let export = |cache: bool| {
        let options = Options { cache, ..Options::default() };
        let built = Counter::new(0);
        let all = Settling::new(&lattice.graph, &options).unwrap().settle(&|count| built.set(built.get() + count), &|| ()).unwrap();
        assert!(all.built.iter().all(Option::is_some));
        let mut text = vec![];
        write(&mut solve(&lattice, &options, &Silent).unwrap(), &options, &mut text, &Silent).unwrap();
        (built.get(), text)
    };
    let ((once, shared), (each, apart)) = (export(true), export(false));
    assert_eq!((once, each), (8 + 12 + 6 + 1, 35));
    assert!(shared == apart);
}
