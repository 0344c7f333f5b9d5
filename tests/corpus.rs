//! Small lattices that were hard once, or that stand for a kind of node. Each file's name says what becomes of it: `NAME.accepted.json`
//! becomes a solid that passes all checks, `NAME.refused.json` is refused with reasons, never with a failure of our own.

use lattice_brep::error::Error;
use lattice_brep::graph::check::Overlaps;
use lattice_brep::graph::import::{self, ImportOptions, Source};
use lattice_brep::options::Options;
use lattice_brep::pipeline::{self, Silent};
use lattice_brep::report::Report;
use std::path::{Path, PathBuf};

fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files
}

/// What `export` does, with the STEP text thrown away.
fn export(path: &Path) -> Result<Report, Error> {
    let bytes = std::fs::read(path).unwrap();
    let source = Source { name: path.to_str().unwrap(), bytes: &bytes, sibling: &|_| None };
    let lattice = import::read(&source, &ImportOptions::default()).admit(Overlaps::Refuse)?;
    let options = Options::default();
    let mut solved = pipeline::solve(&lattice, &options, &Silent)?;
    pipeline::write(&mut solved, &options, &mut std::io::sink(), &Silent).unwrap();
    Ok(solved.report)
}

#[test]
fn each_file_ends_as_its_name_says() {
    let mut wrong = Vec::new();
    for path in files() {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let found = match export(&path) {
            Ok(_) => "accepted".to_owned(),
            Err(Error::CannotBuild { reasons }) if !reasons.is_empty() => "refused".to_owned(),
            Err(Error::BadInput(faults)) if !faults.is_empty() => "refused".to_owned(),
            Err(other) => other.to_string(),
        };
        if !name.ends_with(&format!(".{found}.json")) {
            wrong.push(format!("{name}: {found}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
