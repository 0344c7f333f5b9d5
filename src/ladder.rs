//! The ladder: how one node is built, and what is tried next when a node's checks fail. No rung is taken silently.
//!
//! Soap film with valleys filled by a ball ▶ soap film without a ball ▶ level-set film ▶ level-set film with more control points ▶ sharp ▶ refused.
//! With the paper's fairing there is no ball.

use crate::node::cells::{LEAST_SNAP, LESS_SNAP, SNAP};
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

/// What short sides are contracted with (`Cells::joined`), in turn.
const SNAPS: [(&str, f64); 3] = [("", SNAP), ("with more corners", LESS_SNAP), ("with all corners", LEAST_SNAP)];

/// Skins farther from their film than this and the tolerance, strut radii, give way to nearer ones with more corners. At tight tolerances that many nodes miss, few
/// meet them with more corners: of 208 nodes of a tet lattice that miss 0.01, 6 do.
const FAR: f64 = 0.05;

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
        let fit = |film: Film, lay: Lay| by_degree(&lay(&star, &film.cells)?, &film, options, degrees);
        let build = |cells, lay| film(cells, Method::SoapFilm, fairing).and_then(|film| fit(film, lay)).map(|fitted| (fitted, ()));
        in_turn(&star, options, build).map(|(fitted, ())| fitted)
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
        let fit = |film: Film, lay: Lay| patch::fit_on(&lay(&star, &film.cells)?, &film, tables);
        let level_set = |cells, lay| film(cells, Method::LevelSet).and_then(|film| fit(film, lay)).map(|fitted| (fitted, ()));
        match in_turn(&star, options, level_set) {
            Ok((fitted, ())) => return Ok(built(fitted, rung, reasons)),
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

/// With sides contracted as usual, with fewer, and with as few as must be (`SNAPS`), the usual layout before a fine one: the first that comes near enough to its film;
/// where of one layout none does, the first. All corners are tried only where nothing else can be built: the slivers between them are nearer, but curvature jumps there
/// without bound. On failure the different reasons. `build` may hand on what it made besides the skin.
pub fn in_turn<T>(star: &Star, options: &Options, build: impl Fn(Cells, Lay) -> Result<(Fitted, T), String>) -> Result<(Fitted, T), String> {
    let enough = options.tolerance.max(FAR);
    let (mut told, mut last) = (String::new(), String::new());
    for (layout, lay) in [("", Layout::new as Lay), ("on a fine layout", Layout::fine)] {
        let mut first: Option<(Fitted, T)> = None;
        let mut tried = Vec::new();
        for (name, snap) in SNAPS {
            if snap == LEAST_SNAP && first.is_some() {
                break;
            }
            let cells = Cells::joined(star, snap);
            let corners = cells.as_ref().ok().map(|c| c.corners.len());
            if tried.contains(&corners) {
                continue;
            }
            tried.push(corners);
            match cells.and_then(|cells| build(cells, lay)) {
                Ok(built) if built.0.quality.deviation <= enough => return Ok(built),
                Ok(built) => first = first.or(Some(built)),
                Err(e) if e == last => {}
                Err(e) => {
                    let way = [layout, name].join(" ");
                    told += &if told.is_empty() { e.clone() } else { format!(" ({}: {e})", way.trim()) };
                    last = e;
                }
            }
        }
        if let Some(first) = first {
            return Ok(first);
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
