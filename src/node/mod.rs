//! Node layer: `Graph, node ▶ Film`. One file per step of the soap-film method
//! (Luo & Zou 2025): cut, cells, film, fair, refine; `level_set` is the fall-back shape;
//! `deviation` measures against the shape before blending.
//!
//! Node units throughout: the node at the origin, lengths divided by the node's radius.
//! The film that leaves this layer is star-shaped enough to be met by every ray asked of it:
//! the patch layer sees it as a distance along a direction, nothing else.

pub mod cells;
pub mod cut;
pub mod deviation;
pub mod fair;
pub mod film;
mod join;
pub mod level_set;
pub mod mesh;
pub mod refine;
pub mod rolling;
pub mod sleeve;
pub mod star;

pub use cells::Cells;
pub use star::Star;

use crate::node::level_set::LevelSet;
use crate::node::mesh::{Caster, Mesh};
use glam::DVec3;

/// The shape that a node's patches are fitted to, with the layout of its cells.
#[derive(Clone, Debug)]
pub struct Film {
    pub star: Star,
    pub cells: Cells,
    pub shape: Shape,
}

/// Where the film's points come from.
#[derive(Clone, Debug)]
pub enum Shape {
    /// The soap film after fairing and refinement.
    Soap(Mesh),
    /// The level-set film: the fall-back.
    LevelSet(LevelSet),
}

/// Where a ray from the node meets the film.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance from the node, node units.
    pub distance: f64,
    /// Unit normal of the film there, pointing out.
    pub normal: DVec3,
}

/// Which film to build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    SoapFilm,
    LevelSet,
}

/// How the film is faired (section 3.3.2).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Fairing {
    /// As `Ray`, from where a small ball leaves the valleys (`fair::FILL`).
    #[default]
    Filled,
    /// Each vertex stays on its ray from the node; cotangent weights.
    Ray,
    /// As printed in the paper: uniform weights, vertices free in space. It folds on many nodes.
    Paper,
    /// None: vertices lie where a ball of this radius rolls along the valleys (`rolling`), node radii.
    Ball(f64),
}

impl Fairing {
    /// What a node gets: the usual small ball is for struts of equal radii. On others it also fills the edge between a thin strut and the node sphere of the
    /// thickest, which adds to the node where there is no valley.
    pub fn at(self, star: &Star) -> Fairing {
        if self == Fairing::Filled && !star.is_of_equal_cylinders() { Fairing::Ray } else { self }
    }
}

impl Film {
    /// Run all steps of one method on one node.
    pub fn build(star: Star, method: Method, fairing: Fairing, levels: u32) -> Result<Film, String> {
        let cells = Cells::new(&star)?;
        Film::of_cells(star, cells, method, fairing, levels)
    }

    /// The same with these cells.
    pub fn of_cells(star: Star, cells: Cells, method: Method, fairing: Fairing, levels: u32) -> Result<Film, String> {
        let shape = match method {
            Method::SoapFilm => {
                let mut control = film::mesh_for(&star, &cells, fairing);
                fair::fair(&mut control, &star, fairing, fair::HOLD)?;
                Shape::Soap(refine::refine(&control, &star, levels))
            }
            Method::LevelSet => Shape::LevelSet(LevelSet::new(&star)),
        };
        Ok(Film { star, cells, shape })
    }

    /// A sampler for rays from the node; keeps a place to start from, so ask it for near rays in turn.
    pub fn sampler(&self) -> Sampler<'_> {
        match &self.shape {
            Shape::Soap(mesh) => Sampler::Soap(Caster::new(mesh)),
            Shape::LevelSet(set) => Sampler::LevelSet(set),
        }
    }
}

/// Answers where rays from the node meet the film.
pub enum Sampler<'a> {
    Soap(Caster<'a>),
    LevelSet(&'a LevelSet),
}

impl Sampler<'_> {
    /// The film along the ray of `direction` (any length), or none where no facet is met.
    pub fn hit(&mut self, direction: DVec3) -> Option<Hit> {
        match self {
            Sampler::Soap(caster) => caster.hit(direction),
            Sampler::LevelSet(set) => Some(set.hit(direction)),
        }
    }
}
