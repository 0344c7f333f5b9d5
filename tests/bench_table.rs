//! `lattice-brep bench table`: counts are the lattice's own, times are in order, what cannot be built is refused.

use std::process::{Command, Output};

fn table(lattices: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(["bench", "table", "--runs", "2"]).args(lattices).output().unwrap()
}

#[test]
fn rows_of_the_paper_and_of_the_lattices() {
    let done = table(&["tests/examples/bcc.json", "tests/examples/irregular.json"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = String::from_utf8(done.stdout).unwrap();
    let (models, degrees) = text.split_once("\n\n").unwrap();
    let rows = |table: &str| -> Vec<Vec<String>> {
        table.lines().skip(2).map(|l| l.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()).collect()
    };
    let (models, degrees) = (rows(models), rows(degrees));
    assert_eq!(models.iter().filter(|r| r[0].starts_with("paper: ")).count(), 9);
    assert_eq!(models[9][..4], ["bcc", "64", "35", "8"]);
    assert_eq!(models[10][..4], ["irregular", "9", "10", "9"]);
    // free ends need no building
    let counts: Vec<[usize; 2]> = degrees.iter().map(|r| [0, 1].map(|k| r[k].parse().unwrap())).collect();
    assert_eq!(counts, [[2, 12], [4, 6], [8, 9], [9, 1]]);
    for row in models[9..].iter().map(|r| &r[4..]).chain(degrees.iter().map(|r| &r[2..])) {
        let ms: Vec<f64> = row.iter().map(|x| x.parse().unwrap()).collect();
        for three in ms.chunks(3) {
            assert!(0.0 < three[0] && three[0] <= three[2] && three[2] <= three[1], "{row:?}");
        }
        assert!(ms[2] < ms[5], "smoothing is a part of the construction: {row:?}");
    }
}

/// Two struts 1° apart, far shorter than their cuts.
#[test]
fn what_cannot_be_built_is_refused_with_its_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("narrow.json");
    std::fs::write(&path, r#"{"nodes":[[0,0,0],[10,0,0],[10,0.2,0]],"struts":[{"a":0,"b":1,"ra":1,"rb":1},{"a":0,"b":2,"ra":1,"rb":1}]}"#).unwrap();
    let done = table(&[path.to_str().unwrap()]);
    assert_eq!(done.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&done.stderr).contains("struts[0]"));
}
