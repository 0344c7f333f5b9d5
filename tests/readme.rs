//! The README says what the program says.

use lattice_brep::graph;
use std::collections::BTreeSet;
use std::process::Command;

const README: &str = include_str!("../README.md");

fn help(arguments: &[&str]) -> String {
    let out = Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(arguments).output().unwrap();
    assert!(out.status.success());
    String::from_utf8(out.stdout).unwrap()
}

/// All `--options` in a text.
fn options(text: &str) -> BTreeSet<String> {
    let words = text.split(|c: char| !(c.is_ascii_lowercase() || c == '-'));
    words.filter(|w| w.starts_with("--") && w.len() > 2).map(str::to_owned).collect()
}

#[test]
fn the_table_of_export_options_is_complete() {
    let section = README.split("### `export`").nth(1).unwrap().split("### ").next().unwrap();
    let table: String = section.lines().filter(|l| l.starts_with("| `")).map(|l| l.split(" | ").next().unwrap().to_owned() + "\n").collect();
    let mut wanted = options(help(&["export", "--help"]).split("Examples:").next().unwrap());
    for plain in ["--help", "--output", "--quiet"] {
        assert!(wanted.remove(plain), "{plain} is gone");
    }
    assert!(table.contains("`-o") && table.contains("`-q`"));
    assert_eq!(options(&table), wanted);
}

#[test]
fn every_subcommand_has_a_section() {
    let list = help(&["--help"]);
    let names = list.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    for name in names.lines().filter_map(|l| l.split_whitespace().next()).filter(|n| *n != "help") {
        assert!(README.contains(&format!("### `{name}`")), "README has no section on {name}");
    }
}

#[test]
fn the_json_sample_is_a_sound_lattice() {
    let sample = README.split("```json\n").nth(1).unwrap().split("```").next().unwrap();
    let lattice = graph::read(sample.as_bytes()).unwrap();
    assert!(lattice.notes.is_empty());
}
