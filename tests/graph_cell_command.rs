//! `lattice-brep cell` and `schema` from the outside: files, exit codes, nothing left behind.

use lattice_brep::graph::{self, catalogue::Cell};
use std::path::Path;
use std::process::{Command, Output};

fn run(args: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(args).current_dir(folder).output().unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn every_cell_is_written_and_reads_back_without_a_fault() {
    let folder = tempfile::tempdir().unwrap();
    for cell in Cell::ALL {
        let out = run(&["cell", cell.name(), "--size", "8", "--repeat", "2x1x1", "--radius", "0.25", "-o", "g.json"], folder.path());
        assert!(out.status.success() && out.stdout.is_empty(), "{out:?}");
        assert_eq!(names(folder.path()), ["g.json"]);
        let lattice = graph::read(&std::fs::read(folder.path().join("g.json")).unwrap()).unwrap();
        assert_eq!(lattice.name.as_deref(), Some(cell.name()));
        let corner = lattice.graph.nodes().iter().copied().reduce(|p, q| p.max(q)).unwrap();
        assert_eq!(corner.to_array(), [16.0, 8.0, 8.0], "{}", cell.name());
        assert!(lattice.graph.struts().iter().all(|s| s.ra == 0.25));
    }
}

#[test]
fn standard_output_and_file_hold_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let printed = run(&["cell", "kelvin", "--repeat", "2"], folder.path()).stdout;
    run(&["cell", "kelvin", "--repeat", "2x2x2", "-o", "g.json"], folder.path());
    assert!(printed == std::fs::read(folder.path().join("g.json")).unwrap());
}

#[test]
fn bad_parameters_exit_with_2_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = run(&["cell", "bcc", "--size", "-3", "--repeat", "0x1x1", "--radius", "0", "-o", "g.json"], folder.path());
    assert_eq!(out.status.code(), Some(2));
    let told = String::from_utf8(out.stderr).unwrap();
    assert!(["3 faults", "size: found -3", "radius: found 0", "repeat: found 0x1x1"].iter().all(|part| told.contains(part)), "{told}");
    assert_eq!(run(&["cell", "gyroid", "-o", "g.json"], folder.path()).status.code(), Some(2));
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_folder_that_does_not_exist_exits_with_1() {
    let folder = tempfile::tempdir().unwrap();
    let out = run(&["cell", "bcc", "-o", "absent/g.json"], folder.path());
    assert_eq!(out.status.code(), Some(1));
    assert!(String::from_utf8(out.stderr).unwrap().contains("absent/g.json"));
}

#[test]
fn an_older_file_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("g.json"), "old").unwrap();
    assert!(run(&["cell", "cubic", "-o", "g.json"], folder.path()).status.success());
    assert!(graph::read(&std::fs::read(folder.path().join("g.json")).unwrap()).is_ok());
}

#[test]
fn schema_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let out = run(&["schema"], folder.path());
    assert_eq!(String::from_utf8(out.stdout).unwrap(), graph::json::schema());
}
