//! `lattice-brep evaluate levels`: figure 13, the time of a film by its levels of refinement.

use super::sets::SETS;
use crate::cli::output;
use clap::Args;
use lattice_brep::error::Error;
use lattice_brep::evaluate::Evaluation;
use lattice_brep::evaluate::facets::Facets;
use lattice_brep::node::deviation::Original;
use lattice_brep::node::{Fairing, Film, Method, Shape};
use std::fmt::Write;
use std::time::Instant;

/// Levels of refinement that are tried.
const MOST: u32 = 5;

/// Time, facets and deviation of one node of each set by levels of refinement (the paper's figure 13)
///
/// The time is that of the whole film: control mesh, fairing and refinement, without patches; the least of several runs on one thread.
#[derive(Args)]
#[command(after_help = "Example:
  lattice-brep evaluate levels --runs 20")]
pub struct LevelsArgs {
    /// Runs, of which the fastest counts
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Least number of points on each surface
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    samples: usize,
}

impl LevelsArgs {
    pub fn run(&self) -> Result<(), Error> {
        let mut text = String::from("| set | levels | facets | ms | Max mm | Avg mm |\n|---|---|---|---|---|---|\n");
        for set in &SETS {
            let axes = &set.kind.nodes(1, 1, None)[0];
            for levels in 0..=MOST {
                let evaluation = Evaluation::new(self.samples);
                let star = evaluation.star(axes);
                let (mut film, mut least) = (None, f64::INFINITY);
                for _ in 0..self.runs {
                    let start = Instant::now();
                    film = Some(Film::build(star.clone(), Method::SoapFilm, Fairing::Filled, levels).map_err(Error::Internal)?.shape);
                    least = least.min(start.elapsed().as_secs_f64());
                }
                let Some(Shape::Soap(mesh)) = film else { unreachable!("at least one run, of the soap film") };
                let mesh = Facets::of_mesh(&mesh);
                let deviation = evaluation.facets(&mesh, &Original::new(&star).map_err(Error::Internal)?).deviation;
                let (facets, ms) = (mesh.triangles.len(), 1e3 * least);
                writeln!(text, "| {} | {levels} | {facets} | {ms:.2} | {:.4} | {:.4} |", set.name, deviation.max, deviation.avg).expect("a string takes all");
            }
        }
        output::write(None, |out| out.write_all(text.as_bytes()))
    }
}
