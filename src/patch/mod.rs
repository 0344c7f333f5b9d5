//! Patch layer: `Film ▶ Skin`. A skin is all spline patches of one node with their shared edges.
//! Everything is in node units: the node at the origin, lengths divided by the node's radius.

pub mod check;
pub mod fairness;
pub mod figures;
pub mod fit;
pub mod forms;
pub mod layout;
pub mod map;
pub mod sampled;
pub mod shelf;
pub mod skin;

use crate::math::nurbs::{NurbsCurve, NurbsSurface};
use crate::node::Film;
use crate::patch::check::Quality;
use crate::patch::layout::Layout;
use crate::patch::sampled::Sampled;
pub use crate::patch::shelf::{Shelf, Shelved};
use glam::DVec3;

/// All patches of one node, with the topology that the B-rep takes over.
/// Node units: node at the origin, radius 1.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Corner points and rim points.
    pub vertices: Vec<DVec3>,
    pub edges: Vec<SkinEdge>,
    pub patches: Vec<Patch>,
    /// One rim per arm, in the order of the node's arms (`Graph::arms(node)`).
    pub rims: Vec<Rim>,
}

/// An edge between two vertices of the skin. Border of two patches, or of one patch and a strut.
#[derive(Clone, Debug)]
pub struct SkinEdge {
    /// Start and end, indices into `Skin::vertices`.
    pub ends: [usize; 2],
    pub curve: SkinCurve,
}

#[derive(Clone, Debug)]
pub enum SkinCurve {
    /// An arc of the rim circle of arm `.0` (index into `Skin::rims`), running
    /// counter-clockwise about the rim's axis from `ends[0]` to `ends[1]`.
    RimArc(usize),
    /// A spline inside the node; its control points and weights (up to one common factor) are
    /// bit for bit the border row of both patches that share it.
    Spline(NurbsCurve),
}

/// One spline patch: the surface over one sector.
#[derive(Clone, Debug)]
pub struct Patch {
    /// u runs along the rim, v from the rim (v = 0) to the cell side (v = 1).
    /// du × dv points out of the solid.
    pub surface: NurbsSurface,
    /// The boundary loop, counter-clockwise seen from outside: (edge, runs forward).
    /// Starts with the rim arc (v = 0).
    pub boundary: [(usize, bool); 4],
    /// Index of the arm whose cell holds this sector.
    pub arm: usize,
}

/// The end circle of a strut at this node.
#[derive(Clone, Debug)]
pub struct Rim {
    /// Unit vector from the node along the strut.
    pub axis: DVec3,
    /// Distance of the circle's centre from the node (the cut), node units; 0 for a degree-1 end.
    pub cut: f64,
    /// Circle radius in node units (1 for equal radii).
    pub radius: f64,
    /// Growth of the strut's radius per unit of length away from the node: 0 for a cylinder.
    pub taper: f64,
    /// The arcs of the rim, indices into `Skin::edges`, counter-clockwise about `axis`, closed.
    /// Empty for a degree-1 end: there the strut ends in a cap.
    pub arcs: Vec<usize>,
}

/// Stiffness of the control nets, in r²: the first that gives positive weights everywhere is taken. Measured: of 27
/// random nodes of degree 4-40, the first serves 21, the second 5 more, the third all.
const STIFFNESS: [f64; 4] = [1e-5, 1e-4, 1e-3, 1e-2];

/// The same for fine layouts, where stiffness counts what the surface moves: the first whose skin passes the checks is taken.
const FINE_STIFFNESS: [f64; 6] = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// Weights that bend more than this (`skin::bend`) are not taken at once: a stiffer net is tried, and they are taken only if none serves. Reason: a needle in
/// the weights makes the surface's parameters run so unevenly that readers may lose the patch. Measured on two blocks of shrunk real lattices, 4,238 and
/// 4,662 patches: 99 % bend less than 6; OCC 8 found one invalid in each, with 122 and 12; with this limit none bends more than 5 and none is invalid.
const EVEN_BEND: f64 = 5.0;

/// Weights that bend more than this are not taken at all.
const MOST_BEND: f64 = 100.0;

/// A skin that passed the patch layer's checks.
pub struct Fitted {
    pub skin: Skin,
    pub quality: Quality,
}

/// Tables for one degree along creases, made once per run.
pub struct Degree {
    /// Columns that keep their azimuth, and those that turn.
    straight: (forms::Tables, fit::Samples),
    turned: (forms::Tables, fit::Samples),
}

impl Degree {
    /// `p`: degree along creases, at least 6.
    pub fn new(p: usize) -> Self {
        let with_samples = |tables| {
            let samples = fit::Samples::new(&tables);
            (tables, samples)
        };
        Degree { straight: with_samples(forms::Tables::new(p)), turned: with_samples(forms::Tables::turned(p)) }
    }

    /// The degree along creases.
    pub fn along(&self) -> usize {
        self.straight.0.p
    }

    fn tables(&self, turned: bool) -> &(forms::Tables, fit::Samples) {
        if turned { &self.turned } else { &self.straight }
    }
}

/// Fit an exactly G1 skin of the given degree to a film. Errors say what failed, without the node's name.
pub fn fit(film: &Film, degree: &Degree) -> Result<Fitted, String> {
    fit_on(&Layout::new(&film.star, &film.cells)?, film, degree)
}

/// The same on a layout of the film, which all degrees share.
pub fn fit_on(layout: &Layout, film: &Film, degree: &Degree) -> Result<Fitted, String> {
    let (tables, samples) = degree.tables(layout.turned);
    fit_sampled(layout, film, degree, &Sampled::new(tables, samples, layout, film)?)
}

/// What a fit of a degree asks of the film; none where it is sure to miss the film by more than `most`, node units (see `Sampled::unless_rougher`).
pub fn sample_unless_rough(layout: &Layout, film: &Film, degree: &Degree, most: f64) -> Result<Option<Sampled>, String> {
    let (tables, samples) = degree.tables(layout.turned);
    Sampled::unless_rougher(tables, samples, layout, film, most)
}

/// Fit to what was sampled for this degree.
pub fn fit_sampled(layout: &Layout, film: &Film, degree: &Degree, sampled: &Sampled) -> Result<Fitted, String> {
    let (tables, samples) = degree.tables(layout.turned);
    let problem = fit::Problem::new(tables, samples, layout, sampled)?;
    let mut reason = String::new();
    let mut uneven = None;
    for &stiffness in if layout.fine { &FINE_STIFFNESS[..] } else { &STIFFNESS[..] } {
        let solved = problem.solve(stiffness).and_then(|fit| Ok((skin::bend(tables, &fit), skin::skin(tables, layout, &fit)?)));
        match solved {
            Ok((bend, _)) if bend > MOST_BEND => reason = format!("the skin's weights bend {bend:.0}-fold (largest allowed {MOST_BEND})"),
            Ok((bend, skin)) => match accepted(skin, film) {
                Ok(fitted) if bend <= EVEN_BEND => return Ok(fitted),
                Ok(fitted) => _ = uneven.get_or_insert(fitted),
                Err(e) => {
                    reason = e;
                    if !layout.fine {
                        break;
                    }
                }
            },
            Err(e) => reason = e,
        }
    }
    uneven.ok_or(reason)
}

fn accepted(skin: Skin, film: &Film) -> Result<Fitted, String> {
    let quality = check::measure(&skin, film);
    check::accept(&quality).map(|()| Fitted { skin, quality })
}

/// The last rung before refusal: every sector keeps its strut's own cylinder up to the cell side (w = w2), so struts
/// meet in sharp creases. Tangent to the struts, closed and free of folds, but not smooth inside the node.
///
/// Only where the struts are cylinders of one radius: others do not meet on the cells' sides.
pub fn sharp(film: &Film, degree: &Degree) -> Result<Fitted, String> {
    if !film.cells.uniform || film.star.tapers.iter().any(|&k| k != 0.0) {
        return Err("struts of unequal radius do not meet in the sides of their cells".into());
    }
    let (tables, _) = degree.tables(false);
    let layout = Layout::straight(&film.star, &film.cells)?;
    let skin = skin::skin(tables, &layout, &fit::cylinders(tables, &layout))?;
    let quality = check::measure(&skin, film);
    check::accept_sharp(&quality).map(|()| Fitted { skin, quality })
}
