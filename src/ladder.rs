//! The ladder: how one node is built, and what is tried next when a node's checks fail. No rung is taken silently.
//!
//! Soap film with valleys filled by a ball ▶ soap film without a ball ▶ level-set film ▶ level-set film with more control points ▶ sharp ▶ refused.
//! With the paper's fairing there is no ball.

use crate::node::cells::{LEAST_SNAP, SNAP};
use crate::node::{Cells, Fairing, Film, Method, Star};
use crate::options::Options;
use crate::patch::check::Quality;
use crate::patch::figures::{self, Figures};
use crate::patch::layout::Layout;
use crate::patch::{self, Degree, Fitted, Rim, Skin};

/// Degree of the patches, and of those with more control points.
const DEGREE: usize = 6;
const MORE_DEGREE: usize = 8;

/// A forecast of so many tolerances is taken for sure. Measured on 357 nodes of tet lattices, of which 258 miss the tolerance of 0.05 r: 94 % of
/// these are found, and 3 of the 99 others get more control points than they need.
const SURE: f64 = 1.4;

/// Tables for both degrees, made once per run.
pub struct Degrees {
    usual: Degree,
    more: Degree,
}

impl Degrees {
    pub fn new() -> Self {
        Degrees { usual: Degree::new(DEGREE), more: Degree::new(MORE_DEGREE) }
    }
}

impl Default for Degrees {
    fn default() -> Self {
        Degrees::new()
    }
}

/// The way a node was built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rung {
    /// A degree-1 end: no skin.
    End,
    SoapFilm,
    /// A soap film faired without a ball in the valleys.
    NoBall,
    LevelSet,
    MoreControl,
    Sharp,
}

/// A node that was built.
pub struct Built {
    pub skin: Skin,
    pub rung: Rung,
    pub quality: Quality,
    pub figures: Figures,
    /// Why each higher rung failed.
    pub reasons: Vec<String>,
}

/// Build one node with at least one strut; on failure the reasons, one for each rung.
pub fn build(star: Star, options: &Options, degrees: &Degrees) -> Result<Built, Vec<String>> {
    if star.degree() == 1 {
        let rims = vec![Rim { axis: star.axes[0], cut: 0.0, radius: 1.0, taper: star.tapers[0], arcs: vec![] }];
        return Ok(Built {
            skin: Skin { rims, ..Skin::default() },
            rung: Rung::End,
            quality: Quality::default(),
            figures: Figures::default(),
            reasons: vec![],
        });
    }
    let mut reasons = Vec::new();
    let built = |fitted: Fitted, rung, reasons| {
        let figures = figures::measure(&fitted.skin, &star);
        Built { skin: fitted.skin, rung, quality: fitted.quality, figures, reasons }
    };
    let film = |cells, method, fairing| Film::of_cells(star.clone(), cells, method, fairing, options.levels);
    let soap = |fairing| {
        let build = |cells, lay: Lay| film(cells, Method::SoapFilm, fairing).and_then(|film| by_degree(&lay(&star, &film.cells)?, &film, options, degrees));
        in_turn(&star, build)
    };
    let fairing = options.fairing.at(&star);
    match soap(fairing) {
        Ok(fitted) => return Ok(built(fitted, Rung::SoapFilm, reasons)),
        Err(e) => reasons.push(format!("soap film: {e}")),
    }
    if fairing != Fairing::Paper && fairing != Fairing::Ray {
        match soap(Fairing::Ray) {
            Ok(fitted) => return Ok(built(fitted, Rung::NoBall, reasons)),
            Err(e) => reasons.push(format!("soap film without a ball: {e}")),
        }
    }
    let film = |cells, method| film(cells, method, Fairing::Ray);
    for (rung, tables) in [(Rung::LevelSet, &degrees.usual), (Rung::MoreControl, &degrees.more)] {
        let level_set = |cells, lay: Lay| film(cells, Method::LevelSet).and_then(|film| patch::fit_on(&lay(&star, &film.cells)?, &film, tables));
        match in_turn(&star, level_set) {
            Ok(fitted) => return Ok(built(fitted, rung, reasons)),
            Err(e) => reasons.push(format!("level-set film, degree {}: {e}", tables.along())),
        }
    }
    match Cells::joined(&star, LEAST_SNAP).and_then(|cells| film(cells, Method::LevelSet)).and_then(|film| patch::sharp(&film, &degrees.usual)) {
        Ok(fitted) => return Ok(built(fitted, Rung::Sharp, reasons)),
        Err(e) => reasons.push(format!("sharp: {e}")),
    }
    Err(reasons)
}

/// How sectors are laid out.
pub type Lay = fn(&Star, &Cells) -> Result<Layout, String>;

/// With corners joined as usual; where that fails, with as few as must be; then both on a fine layout. On failure the different reasons.
pub fn in_turn<T>(star: &Star, build: impl Fn(Cells, Lay) -> Result<T, String>) -> Result<T, String> {
    let usual = Cells::joined(star, SNAP);
    let mut last = match usual.clone().and_then(|cells| build(cells, Layout::new)) {
        Ok(built) => return Ok(built),
        Err(e) => e,
    };
    let mut told = last.clone();
    let least = Cells::joined(star, LEAST_SNAP);
    let same = usual.as_ref().map(|c| c.corners.len()) == least.as_ref().map(|c| c.corners.len());
    let ways: [(&str, &Result<Cells, String>, Lay); 3] =
        [("with all corners", &least, Layout::new), ("on a fine layout", &usual, Layout::fine), ("on a fine layout with all corners", &least, Layout::fine)];
    for (way, cells, lay) in ways {
        if same && way.ends_with("all corners") {
            continue;
        }
        match cells.clone().and_then(|cells| build(cells, lay)) {
            Ok(built) => return Ok(built),
            Err(e) if e == last => {}
            Err(e) => {
                told += &format!(" ({way}: {e})");
                last = e;
            }
        }
    }
    Err(told)
}

/// Fit on one layout at both degrees, the second only where the first fails or misses the tolerance, or is sure to by its forecast.
pub fn by_degree(layout: &Layout, film: &Film, options: &Options, degrees: &Degrees) -> Result<Fitted, String> {
    let sampled = patch::sample_unless_rough(layout, film, &degrees.usual, SURE * options.tolerance);
    let mut failed = None;
    if matches!(sampled, Ok(None)) {
        match patch::fit_on(layout, film, &degrees.more) {
            Ok(more) => return Ok(more),
            Err(e) => failed = Some(e),
        }
    }
    let usual = sampled.and_then(|sampled| match sampled {
        Some(sampled) => patch::fit_sampled(layout, film, &degrees.usual, &sampled),
        None => patch::fit_on(layout, film, &degrees.usual),
    });
    if usual.as_ref().is_ok_and(|f| f.quality.deviation <= options.tolerance) {
        return usual;
    }
    let more = failed.map_or_else(|| patch::fit_on(layout, film, &degrees.more), Err);
    match (usual, more) {
        (Ok(usual), Ok(more)) => Ok(if more.quality.deviation < usual.quality.deviation { more } else { usual }),
        (Ok(one), Err(_)) | (Err(_), Ok(one)) => Ok(one),
        (Err(e), Err(_)) => Err(e),
    }
}
