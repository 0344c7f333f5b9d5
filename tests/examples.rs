//! The shipped examples are sound, and those of unit cells are what `lattice-brep cell` writes.

use lattice_brep::graph::{self, catalogue, json};
use std::fs;
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/examples")
}

#[test]
fn every_example_is_read_without_a_fault_or_a_note() {
    let mut count = 0;
    for entry in fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            continue; // files for the tests of readers
        }
        let lattice = graph::read(&fs::read(&path).unwrap()).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(lattice.notes.is_empty(), "{}: {:?}", path.display(), lattice.notes);
        count += 1;
    }
    assert_eq!(count, 3);
}

#[test]
fn cells_are_what_the_command_writes() {
    for name in ["bcc", "octet"] {
        let graph = catalogue::generate(name.parse().unwrap(), 10.0, [2, 2, 2], 0.5).unwrap();
        let mut text = Vec::new();
        json::write(&graph, Some(name), &mut text).unwrap();
        assert_eq!(text, fs::read(folder().join(format!("{name}.json"))).unwrap(), "{name}");
    }
}
