//! Case study 1 of the paper (section 4.1, Table 1, figures 14 and 15): how far a node's surface lies from the original node, and how
//! fair it is. All struts have the radius 1 mm, so node units are mm.

pub mod facets;
pub mod fields;
pub mod savio;

use self::facets::Facets;
use self::fields::Fields;
use crate::ladder::{self, Degrees, Lay};
use crate::math::nurbs::Table;
use crate::node::deviation::Original;
use crate::node::fair::{self, HOLD};
use crate::node::film::{self, Control, FIXED_ROWS};
use crate::node::{Cells, Fairing, Film, Shape, Star, cut, refine};
use crate::options::Options;
use crate::patch::{Skin, fairness, figures};
use glam::DVec3;
use serde::Serialize;

/// A surface to measure: one way to read the paper's fairing (section 3.3.2), or another method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    pub name: &'static str,
    pub film: How,
}

/// How a film is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum How {
    Soap {
        /// None: the film as built.
        fairing: Option<Fairing>,
        /// Rows of vertices that stay on the cylinder, the rim among them.
        fixed_rows: usize,
        /// For `Fairing::Ray`: see `fair::HOLD`.
        hold: f64,
    },
    Savio,
}

impl Reading {
    const fn new(name: &'static str, fairing: Option<Fairing>, fixed_rows: usize) -> Reading {
        Reading { name, film: How::Soap { fairing, fixed_rows, hold: HOLD } }
    }

    /// A film on rays, without a ball, with this hold.
    const fn held(name: &'static str, hold: f64) -> Reading {
        Reading { name, film: How::Soap { fairing: Some(Fairing::Ray), fixed_rows: FIXED_ROWS, hold } }
    }

    /// What we build.
    pub const OURS: Reading = Reading::new("ours", Some(Fairing::Filled), FIXED_ROWS);

    pub const SAVIO: Reading = Reading { name: "Savio", film: How::Savio };

    /// Beside ours section 3.3.2 to the letter, uniform weights, the rim and its 2-ring fixed; and Savio's method.
    pub const USUAL: [Reading; 3] = [Reading::OURS, Reading::SAVIO, Reading::new("as printed", Some(Fairing::Paper), FIXED_ROWS)];

    /// What else the paper's words leave room for.
    pub const OTHERS: [Reading; 5] = [
        Reading::new("as printed, 1-ring fixed", Some(Fairing::Paper), 2),
        Reading::new("as printed, rim fixed", Some(Fairing::Paper), 1),
        Reading::new("on rays, 1-ring fixed", Some(Fairing::Ray), 2),
        Reading::new("on rays, rim fixed", Some(Fairing::Ray), 1),
        Reading::new("not faired", None, FIXED_ROWS),
    ];

    /// Valleys filled by a ball of this radius.
    const fn rolled(name: &'static str, ball: f64) -> Reading {
        Reading::new(name, Some(Fairing::Ball(ball)), FIXED_ROWS)
    }

    /// Deviation against fairness: films on rays from smooth to close, and valleys filled from little to much.
    pub const TRADE: [Reading; 13] = [
        Reading::held("hold 0", 0.0),
        Reading::held("hold 1", 1.0),
        Reading::held("hold 2", 2.0),
        Reading::held("hold 4", 4.0),
        Reading::held("hold 8", 8.0),
        Reading::held("hold 16", 16.0),
        Reading::held("hold 32", 32.0),
        Reading::held("hold 128", 128.0),
        Reading::rolled("ball 0", 0.0),
        Reading::rolled("ball 0.05", 0.05),
        Reading::rolled("ball 0.1", 0.1),
        Reading::rolled("ball 0.15", 0.15),
        Reading::rolled("ball 0.2", 0.2),
    ];
}

/// Absolute distances to the original node over a surface, each part counted by its area. In mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Deviation {
    pub max: f64,
    pub avg: f64,
    /// Standard deviation.
    pub std: f64,
    /// Largest distance outside and inside the original node.
    pub max_outside: f64,
    pub max_inside: f64,
    pub samples: usize,
}

/// Figures of a refined mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Refined {
    pub deviation: Deviation,
    /// 99 % of the area keeps to it. 1/mm.
    pub usual_mean_curvature: f64,
}

/// Figures of the patches fitted to a film. Lengths in mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Patches {
    pub deviation: Deviation,
    pub patches: usize,
    pub area: f64,
    pub max_mean_curvature: f64,
    /// 99 % of the area keeps to it.
    pub usual_mean_curvature: f64,
    /// 1 / the largest concave curvature.
    pub least_concave_radius: f64,
    /// 99 % of the area is no more concave.
    pub usual_concave_radius: f64,
    pub thin_plate: f64,
    pub variation: f64,
    pub max_edge_jump: f64,
    /// Against the original node, mm³.
    pub added: f64,
    pub removed: f64,
    /// Added, removed and least concave radius from the few samples of a report.
    pub reported: [f64; 3],
}

/// What was measured of one node, by reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Of the refined mesh; none where fairing failed.
    pub films: Vec<Option<Refined>>,
    /// Of the patches fitted to it as on the first rung of the ladder; none where they fail their checks, and for Savio's film.
    pub patches: Vec<Option<Patches>>,
}

/// Gauss points each way on a patch whose volume is measured.
const VOLUME_POINTS: usize = 32;

/// Measures nodes with the options of a usual run.
pub struct Evaluation {
    /// Least number of points on each surface.
    pub samples: usize,
    options: Options,
    degrees: Degrees,
}

impl Evaluation {
    pub fn new(samples: usize) -> Evaluation {
        Evaluation { samples, options: Options::default(), degrees: Degrees::new() }
    }

    /// The node of struts along these unit vectors.
    pub fn star(&self, axes: &[DVec3]) -> Star {
        Star::uniform(axes.to_vec(), cut::cuts(axes, self.options.lambda))
    }

    /// Measure the node of struts along these unit vectors.
    pub fn node(&self, axes: &[DVec3], readings: &[Reading]) -> Result<Measured, String> {
        let star = self.star(axes);
        let original = Original::new(&star)?;
        let mut measured = Measured { films: vec![], patches: vec![] };
        for reading in readings {
            let (film, skin) = self.build(&star, reading).ok().unzip();
            measured.films.push(film.map(|film| self.facets(&film, &original)));
            measured.patches.push(skin.flatten().map(|skin| self.patches(&skin, &star, &original)));
        }
        Ok(measured)
    }

    /// The refined mesh of one reading, and its patches as `export` fits them; none where they fail their checks.
    pub fn build(&self, star: &Star, reading: &Reading) -> Result<(Facets, Option<Skin>), String> {
        let How::Soap { fairing, fixed_rows, hold } = reading.film else {
            return Ok((savio::film(star, &Cells::new(star)?), None));
        };
        let film = |cells: Cells| -> Result<(Facets, Film), String> {
            let mut control = film::mesh_for(star, &cells, fairing.unwrap_or(Fairing::Ray));
            let rows = rows(&control);
            control.free = rows.iter().map(|&row| row >= fixed_rows).collect();
            if let Some(fairing) = fairing {
                fair::fair(&mut control, star, fairing, hold)?;
            }
            let mesh = refine::refine(&control, star, self.options.levels);
            let facets = Facets::of_mesh(&mesh);
            Ok((facets, Film { star: star.clone(), cells, shape: Shape::Soap(mesh) }))
        };
        let both = |cells, lay: Lay| {
            let (facets, film) = film(cells)?;
            let fitted = ladder::by_degree(&lay(star, &film.cells)?, &film, &self.options, &self.degrees)?;
            Ok((fitted, facets))
        };
        match ladder::in_turn(star, &self.options, both) {
            Ok((fitted, facets)) => Ok((facets, Some(fitted.skin))),
            Err(_) => Ok((film(Cells::new(star)?)?.0, None)),
        }
    }

    /// The refined mesh of a reading, and its patches where they can be fitted, with figures at their points.
    pub fn surfaces(&self, axes: &[DVec3], reading: &Reading) -> Result<[Option<(&'static str, Fields)>; 2], String> {
        let star = self.star(axes);
        let original = Original::new(&star)?;
        let (film, skin) = self.build(&star, reading)?;
        Ok([Some(("mesh", Fields::of_facets(film, &original))), skin.map(|skin| ("patches", Fields::of_skin(&skin, &original)))])
    }

    /// Figures of a refined mesh.
    pub fn facets(&self, facets: &Facets, original: &Original) -> Refined {
        let mut means: Vec<(f64, f64)> = fields::mean_curvatures(facets).into_iter().map(|(mean, area)| (mean.abs(), area)).collect();
        let deviation = of_facets(&facets.corners().collect::<Vec<_>>(), original, self.samples);
        Refined { deviation, usual_mean_curvature: fairness::share(&mut means, 0.99) }
    }

    fn patches(&self, skin: &Skin, star: &Star, original: &Original) -> Patches {
        let fairness = fairness::measure(skin);
        let [added, removed] = figures::volumes(skin, star, VOLUME_POINTS);
        let few = figures::measure(skin, star);
        Patches {
            deviation: of_skin(skin, original, self.samples),
            patches: skin.patches.len(),
            area: fairness.area,
            max_mean_curvature: fairness.most_mean,
            usual_mean_curvature: fairness.usual_mean,
            least_concave_radius: 1.0 / fairness.most_concave,
            usual_concave_radius: 1.0 / fairness.usual_concave,
            thin_plate: fairness.thin_plate,
            variation: fairness.variation,
            max_edge_jump: fairness.most_jump,
            added,
            removed,
            reported: [few.added, few.removed, 1.0 / few.concave],
        }
    }
}

/// The row of each vertex: edges between it and the nearest rim.
fn rows(control: &Control) -> Vec<usize> {
    let mut rows: Vec<usize> = control.rims.iter().map(|rim| if rim.is_some() { 0 } else { usize::MAX }).collect();
    for row in 0.. {
        let before = rows.clone();
        for t in &control.triangles.0 {
            let t = t.map(|v| v as usize);
            if t.iter().any(|&v| before[v] == row) {
                t.iter().for_each(|&v| rows[v] = rows[v].min(row + 1));
            }
        }
        if rows == before {
            break;
        }
    }
    rows
}

/// The deviation of facets by the trapezoidal rule: each is cut into equal triangles, their corners are the samples.
fn of_facets(facets: &[[DVec3; 3]], original: &Original, samples: usize) -> Deviation {
    let parts = parts(samples, facets.len());
    let mut sum = Sum::default();
    for &[a, b, c] in facets {
        let (e, f) = ((b - a) / parts as f64, (c - a) / parts as f64);
        let share = 0.5 * e.cross(f).length() / 3.0;
        for i in 0..=parts {
            for j in 0..=parts - i {
                // triangles that meet there
                let around = match [i, j, parts - i - j].iter().filter(|&&at| at == 0).count() {
                    0 => 6.0,
                    1 => 3.0,
                    _ => 1.0,
                };
                sum.add(original.distance(a + i as f64 * e + j as f64 * f), around * share);
            }
        }
    }
    sum.deviation()
}

/// The deviation of a skin's patches by the trapezoidal rule, even in u and v, borders among the samples.
pub fn of_skin(skin: &Skin, original: &Original, samples: usize) -> Deviation {
    let parts = parts(samples, skin.patches.len());
    let end = |k: usize| if k == 0 || k == parts { 0.5 } else { 1.0 };
    let mut sum = Sum::default();
    for patch in &skin.patches {
        let surface = &patch.surface;
        let [u, v] = [0, 1].map(|k| Table::even(surface.degree[k], &surface.knots[k], parts + 1));
        for (at, jet) in surface.jets1([&u, &v]).into_iter().enumerate() {
            let share = end(at / (parts + 1)) * end(at % (parts + 1)) / (parts * parts) as f64;
            sum.add(original.distance(jet.p), share * jet.du.cross(jet.dv).length());
        }
    }
    sum.deviation()
}

/// Parts each way on each of `count` pieces, so that all together have at least so many samples.
fn parts(samples: usize, count: usize) -> usize {
    (samples as f64 / count as f64).sqrt().ceil().max(1.0) as usize
}

/// Sums over samples.
#[derive(Default)]
struct Sum {
    area: f64,
    first: f64,
    second: f64,
    outside: f64,
    inside: f64,
    samples: usize,
}

impl Sum {
    fn add(&mut self, distance: f64, area: f64) {
        self.area += area;
        self.first += area * distance.abs();
        self.second += area * distance * distance;
        self.outside = self.outside.max(distance);
        self.inside = self.inside.max(-distance);
        self.samples += 1;
    }

    fn deviation(&self) -> Deviation {
        let avg = self.first / self.area;
        Deviation {
            max: self.outside.max(self.inside),
            avg,
            std: (self.second / self.area - avg * avg).max(0.0).sqrt(),
            max_outside: self.outside,
            max_inside: self.inside,
            samples: self.samples,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octahedron() -> Star {
        let axes: Vec<DVec3> = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|a| [a, -a]).collect();
        let cuts = cut::cuts(&axes, 0.3);
        Star::uniform(axes, cuts)
    }

    #[test]
    fn usual_rows_are_those_of_the_film() {
        let star = octahedron();
        let control = film::control_mesh(&star, &Cells::new(&star).unwrap());
        let free: Vec<bool> = rows(&control).iter().map(|&row| row >= FIXED_ROWS).collect();
        assert_eq!(free, control.free);
        assert_eq!(rows(&control).into_iter().max(), Some(film::LAYERS));
    }

    /// Distances from 0 to 1 over a strut, each as often as the others.
    #[test]
    fn max_avg_and_std_of_a_ramp() {
        let original = Original::new(&octahedron()).unwrap();
        let mut sum = Sum::default();
        let n = 1000;
        for k in 0..n {
            sum.add(original.distance(DVec3::new(5.0, 1.0 + (k as f64 + 0.5) / n as f64, 0.0)), 2.0);
        }
        let d = sum.deviation();
        assert!((d.avg - 0.5).abs() < 1e-12 && (d.std - (1.0 / 12f64).sqrt()).abs() < 1e-6 && (d.max - 0.9995).abs() < 1e-12, "{d:?}");
        assert_eq!((d.max_inside, d.samples), (0.0, n));
    }

    /// A triangle 6 radii along a strut, 0 to 1 above it: the mean of its corners.
    #[test]
    fn a_facet_counts_by_its_area() {
        let facet = [DVec3::new(5.0, 1.0, 0.0), DVec3::new(11.0, 1.0, 0.0), DVec3::new(5.0, 2.0, 0.0)];
        let d = of_facets(&[facet], &Original::new(&octahedron()).unwrap(), 10_000);
        assert!((d.avg - 1.0 / 3.0).abs() < 1e-12 && (d.max - 1.0).abs() < 1e-12, "{d:?}");
        // of a height h the share 2 (1 - h): the variance is 1/18
        assert!((d.std - (1.0 / 18f64).sqrt()).abs() < 1e-4, "{d:?}");
    }

    /// Mesh and patches of one node are one shape: their figures agree, and more samples change them little.
    #[test]
    fn mesh_and_patches_agree() {
        let axes = octahedron().axes;
        let [few, many] = [20_000, 80_000].map(|samples| Evaluation::new(samples).node(&axes, &Reading::USUAL).unwrap());
        let patches = |m: &Measured| m.patches[0].as_ref().unwrap().deviation;
        let mesh = |m: &Measured| m.films[0].unwrap().deviation;
        for (a, b) in [(mesh(&few), mesh(&many)), (mesh(&many), patches(&many)), (patches(&few), patches(&many))] {
            assert!(a.samples >= 20_000 && (a.max - b.max).abs() < 0.01 && (a.avg - b.avg).abs() < 1e-3 && (a.std - b.std).abs() < 1e-3, "{a:?} {b:?}");
        }
    }
}
