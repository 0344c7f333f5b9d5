//! `lattice-brep evaluate nodes`: figures, and that they depend on the arguments alone.

use serde_json::Value;
use std::process::Command;

/// The printed text and the JSON.
fn evaluate(arguments: &[&str]) -> (String, Value) {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("out.json");
    let out = Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(["evaluate", "nodes", "--json"]).arg(&json).args(arguments).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    (String::from_utf8(out.stdout).unwrap(), serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap())
}

/// Max, Avg and Std of a deviation.
fn three(deviation: &Value) -> [f64; 3] {
    ["max", "avg", "std"].map(|name| deviation[name].as_f64().unwrap())
}

/// The literal reading of the paper and Savio's method, against a prototype in another language (a kd-tree over sampled creases, 20,000
/// random points a shape): Max, Avg and Std to 4 %. Our patches keep to a quarter of the paper's Avg and half of its Max.
#[test]
fn regular_nodes_as_an_independent_program_measured_them() {
    let printed = [[0.1225, 0.0096, 0.0187], [0.1709, 0.0126, 0.0261], [0.2999, 0.0207, 0.0420], [0.5523, 0.0458, 0.0842]];
    let savio = [[0.3258, 0.2011, 0.0921], [0.1946, 0.1248, 0.0548], [0.3325, 0.1902, 0.0877], [0.6523, 0.2937, 0.1518]];
    let (text, json) = evaluate(&["--sets", "regular-6,regular-12,cuboctahedron,regular-20", "--samples", "100000"]);
    for (set, (savio, printed)) in json.as_array().unwrap().iter().zip(savio.into_iter().zip(printed)) {
        let node = &set["nodes"][0];
        assert_eq!(set["readings"], serde_json::json!(["ours", "Savio", "as printed"]));
        for (film, wanted) in [(1, savio), (2, printed)] {
            for (found, wanted) in three(&node["films"][film]["deviation"]).iter().zip(wanted) {
                assert!((found / wanted - 1.0).abs() < 0.04, "{}: {found} instead of {wanted}", set["set"]);
            }
        }
        let paper = |k: usize| set["paper"][k].as_f64().unwrap();
        let [max, avg, _] = three(&node["patches"][0]["deviation"]);
        assert!(max < 0.5 * paper(0) && avg < 0.25 * paper(1), "{}: {max} {avg}", set["set"]);
        assert!(text.contains(&format!("| {} | Table 1 |", set["set"].as_str().unwrap())));
    }
}

/// A surface as PLY: header, a line a point, a line a triangle; the figures of its points are those of the table.
#[test]
fn surfaces_are_written_with_their_figures() {
    let folder = tempfile::tempdir().unwrap();
    let (_, json) = evaluate(&["--sets", "regular-6", "--samples", "1000", "--surfaces", folder.path().to_str().unwrap()]);
    for (name, figures) in [("savio-mesh", &json[0]["nodes"][0]["films"][1]), ("ours-patches", &json[0]["nodes"][0]["patches"][0])] {
        let text = std::fs::read_to_string(folder.path().join(format!("regular-6-{name}.ply"))).unwrap();
        let (header, body) = text.split_once("end_header\n").unwrap();
        let count = |what: &str| header.lines().find_map(|l| l.strip_prefix(&format!("element {what} "))).unwrap().parse::<usize>().unwrap();
        assert_eq!(body.lines().count(), count("vertex") + count("face"));
        let vertices: Vec<Vec<f64>> = body.lines().take(count("vertex")).map(|l| l.split(' ').map(|x| x.parse().unwrap()).collect()).collect();
        let most = vertices.iter().map(|v| v[3].abs()).fold(0.0, f64::max);
        assert!((most - three(&figures["deviation"])[0]).abs() < 2e-3, "{name}: {most}");
    }
}

/// Figure 13: each level has four times the facets, and the film settles.
#[test]
fn levels_are_timed() {
    let out = Command::new(env!("CARGO_BIN_EXE_lattice-brep")).args(["evaluate", "levels", "--runs", "1", "--samples", "1000"]).output().unwrap();
    let text = String::from_utf8(out.stdout).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().filter_map(|l| l.strip_prefix("| regular-6 | ")).map(|l| l.split('|').filter_map(|cell| cell.trim().parse().ok()).collect()).collect();
    assert_eq!(rows.len(), 6, "{text}");
    for (level, row) in rows.iter().enumerate() {
        assert_eq!((row[0], row[1]), (level as f64, 768.0 * 4f64.powi(level as i32)));
        assert!(row[2] > 0.0);
    }
    assert!((rows[5][3] - rows[4][3]).abs() < (rows[2][3] - rows[1][3]).abs());
}

#[test]
fn figures_do_not_depend_on_threads() {
    let one = ["--sets", "irregular-6,irregular-12", "--count", "3", "--samples", "2000", "--readings", "--threads"];
    let run = |threads: &str| evaluate(&[&one[..], &[threads]].concat());
    let (a, b) = (run("1"), run("3"));
    assert_eq!(a, b);
    // the nodes are the seeds', not each other
    let nodes = a.1[0]["nodes"].as_array().unwrap();
    assert_eq!(nodes.len(), 3);
    assert_ne!(nodes[0], nodes[1]);
    assert_eq!(nodes[0]["films"].as_array().unwrap().len(), a.1[0]["readings"].as_array().unwrap().len());
    let (_, later) = evaluate(&["--sets", "irregular-6", "--count", "1", "--seed", "2", "--samples", "2000", "--readings"]);
    assert_eq!(later[0]["nodes"][0], nodes[1]);
}
