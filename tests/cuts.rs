//! Cuts over a whole graph.

mod common;

use lattice_brep::cuts::{Means, negotiate, shrink};
use lattice_brep::graph::{Graph, json};
use std::time::Instant;

/// Figures of lattices given as a list of files: `LATTICES="a.json b.json" cargo test --release --test cuts -- --ignored --nocapture`.
#[test]
#[ignore = "needs files"]
fn figures_of_given_lattices() {
    let files = std::env::var("LATTICES").expect("LATTICES: a list of files");
    for file in files.split_whitespace() {
        let (input, faults) = json::read(&std::fs::read(file).unwrap());
        assert!(faults.is_empty());
        let graph = Graph::new(input.nodes, input.struts);
        println!("{file}: {} struts", graph.struts().len());
        let start = Instant::now();
        let result = negotiate(&graph, 0.3);
        println!("  negotiate {:.3} s", start.elapsed().as_secs_f64());
        match result {
            Ok(cuts) => print_means(&cuts.means),
            Err(conflicts) => {
                println!("  {} conflicts", conflicts.len());
                for c in conflicts.iter().take(3) {
                    println!("    {}", c.fault());
                }
                let longest = conflicts.iter().flat_map(|c| c.because.iter().map(Vec::len)).max().unwrap();
                println!("  longest proof {longest} links");
                let start = Instant::now();
                let (small, cuts, shrunk) = shrink(&graph, 0.3);
                println!("  shrink {:.3} s", start.elapsed().as_secs_f64());
                print_means(&cuts.means);
                let volume: f64 = graph.struts().iter().zip(small.struts()).map(|(s, _)| s.ra * s.ra * std::f64::consts::PI * graph.nodes()[s.a.index()].distance(graph.nodes()[s.b.index()])).sum();
                let lost: f64 = shrunk.iter().map(|s| s.volume).sum();
                let least = shrunk.iter().map(|s| s.after[0] / s.before[0]).fold(1.0, f64::min);
                let mean = shrunk.iter().map(|s| s.after[0] / s.before[0]).sum::<f64>() / shrunk.len() as f64;
                println!("  {} shrunk, least factor {least:.4}, mean {mean:.4}, volume {:.3} %", shrunk.len(), 100.0 * lost / volume);
            }
        }
    }
}

fn print_means(means: &[Means]) {
    for m in [Means::Preferred, Means::SmallerLambda, Means::UnequalCuts, Means::UnequalSharing] {
        println!("    {m:?}: {}", means.iter().filter(|&&x| x == m).count());
    }
}
