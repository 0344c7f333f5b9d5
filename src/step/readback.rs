//! Reads a STEP file back with an independent reader (crate `step-io`) and counts what it holds.
//! Shares no code with the writer, so that a mistake cannot cancel itself.

use serde::Serialize;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt;
use std::io::{self, BufRead};
use step_io::Orientation;
use step_io::StepModel;
use step_io::model::{Circle, DocumentFile, EntityKey, PartialEntity, RepresentationItemRef, RepresentationRef, RepresentedDefinitionRef};
use step_io::scene::{Solid, SurfaceKind};

/// Product names that are printed.
const MOST_PRODUCTS: usize = 8;

/// Why a file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadBackError {
    #[error("not a STEP file: it begins with {found:?}; a STEP file begins with \"ISO-10303-21;\"")]
    NotStep { found: String },
    #[error("broken STEP file: {0}")]
    Broken(step_io::Error),
    #[error("cannot read: {0}")]
    Io(#[from] io::Error),
}

/// What a STEP file holds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReadBack {
    /// The name in the header.
    pub file_name: String,
    /// The names in FILE_SCHEMA.
    pub schema: Vec<String>,
    pub products: Vec<String>,
    /// Names of the files that it refers to, as the master of blocks does.
    pub files: Vec<String>,
    /// Name of the length unit and its length in metres.
    pub length_unit: Option<(String, f64)>,
    /// In the length unit.
    pub uncertainty: Option<f64>,
    /// CIRCLE entities in the file.
    pub circles: usize,
    pub solids: Vec<SolidCounts>,
    pub validation: Validation,
    /// Entities in the file, and those that the reader could not take (with the first reason).
    pub entities: usize,
    pub dropped: usize,
    pub first_dropped: Option<String>,
}

/// What one solid holds. An edge is counted once, however often it is used.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SolidCounts {
    pub name: String,
    pub shells: usize,
    pub faces: usize,
    pub cylinders: usize,
    pub cones: usize,
    pub planes: usize,
    pub spheres: usize,
    pub splines: usize,
    pub other_faces: usize,
    /// Different `node_…` groups among the names of spline faces.
    pub node_groups: usize,
    pub edges: usize,
    pub vertices: usize,
    /// Edges not used exactly twice in opposite senses.
    pub bad_edges: usize,
    /// V - E + F
    pub euler: i64,
}

/// Geometric validation properties, in the file's units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Validation {
    pub volume: Option<f64>,
    pub area: Option<f64>,
    pub centroid: Option<[f64; 3]>,
}

/// Read a whole STEP file.
pub fn read_back(mut input: impl BufRead) -> Result<ReadBack, ReadBackError> {
    let start = input.fill_buf()?;
    let text = String::from_utf8_lossy(&start[..start.len().min(256)]);
    let text = text.trim_start_matches(|c: char| c == '\u{feff}' || c.is_whitespace());
    if !text.starts_with("ISO-10303-21") {
        return Err(ReadBackError::NotStep { found: text.chars().take(24).collect() });
    }
    let (model, report) = step_io::read(input).map_err(|error| match error {
        step_io::Error::Io(e) => ReadBackError::Io(e),
        other => ReadBackError::Broken(other),
    })?;
    let scene = model.scene();
    let units = scene.units();
    let header = model.header();
    Ok(ReadBack {
        file_name: header.file_name.clone(),
        schema: header.schema.raw.clone(),
        products: scene.all_products().map(|p| p.name().to_owned()).collect(),
        files: model.all::<DocumentFile>().into_iter().map(|(_, file)| model.text(file.id).to_owned()).collect(),
        length_unit: units.length.map(|u| (u.name, u.to_si)),
        uncertainty: units.precision,
        circles: model.all::<Circle>().len(),
        solids: scene.all_solids().map(|s| count(&model, &s)).collect(),
        validation: validation(&model),
        entities: report.entities_read,
        dropped: report.dropped.len(),
        first_dropped: report.dropped.first().map(|(id, reason)| format!("#{id}: {reason}")),
    })
}

fn count(model: &StepModel, solid: &Solid) -> SolidCounts {
    let mut out = SolidCounts { name: solid.name().to_owned(), ..SolidCounts::default() };
    out.shells = solid.outer().is_some() as usize + solid.voids().count();
    let mut uses: HashMap<EntityKey, [usize; 2]> = HashMap::new();
    let mut vertices = HashSet::new();
    let mut groups = BTreeSet::new();
    let voids = solid.voids().flat_map(|(shell, _)| shell.faces());
    for face in solid.faces().chain(voids) {
        out.faces += 1;
        let kind = match face.surface().kind() {
            SurfaceKind::Cylindrical(_) => &mut out.cylinders,
            SurfaceKind::Conical(_) => &mut out.cones,
            SurfaceKind::Plane(_) => &mut out.planes,
            SurfaceKind::Spherical(_) => &mut out.spheres,
            SurfaceKind::BSpline(_) | SurfaceKind::BSplineWithKnots(_) | SurfaceKind::Bezier(_) => &mut out.splines,
            SurfaceKind::Other(_) if is_complex_spline(model, face.surface().key()) => &mut out.splines,
            _ => &mut out.other_faces,
        };
        *kind += 1;
        if let Some((node, _)) = face.name().split_once('/')
            && node.starts_with("node_")
            && !face.name().ends_with("/cap")
        {
            groups.insert(node.to_owned());
        }
        for bound in face.bounds() {
            let whole = bound.orientation() == Orientation::Forward;
            for (edge, sense) in bound.oriented_edges() {
                let forward = (sense == Orientation::Forward) == whole;
                uses.entry(edge.key()).or_default()[forward as usize] += 1;
                vertices.extend([edge.start(), edge.end()].into_iter().flatten().map(|v| v.key()));
            }
        }
    }
    out.node_groups = groups.len();
    out.edges = uses.len();
    out.vertices = vertices.len();
    out.bad_edges = uses.values().filter(|&&u| u != [1, 1]).count();
    out.euler = out.vertices as i64 - out.edges as i64 + out.faces as i64;
    out
}

/// A rational spline surface is one instance of several entity types.
fn is_complex_spline(model: &StepModel, key: EntityKey) -> bool {
    let EntityKey::ComplexEntity(id) = key else { return false };
    model[id].parts.iter().any(|part| matches!(part, PartialEntity::BSplineSurface { .. }))
}

fn validation(model: &StepModel) -> Validation {
    use step_io::model::PropertyDefinitionRepresentation as Link;
    let mut out = Validation::default();
    for (_, link) in model.all::<Link>() {
        let RepresentedDefinitionRef::PropertyDefinition(property) = &link.definition else { continue };
        if model.text(model[*property].name) != "geometric validation property" {
            continue;
        }
        let RepresentationRef::Representation(values) = &link.used_representation else { continue };
        for item in &model[*values].items {
            match item {
                RepresentationItemRef::MeasureRepresentationItem(id) => {
                    let value = Some(model[*id].value_component.value.as_f64());
                    match model.text(model[*id].name) {
                        "volume measure" => out.volume = value,
                        "surface area measure" => out.area = value,
                        _ => {}
                    }
                }
                RepresentationItemRef::CartesianPoint(id) if model.text(model[*id].name) == "centre point" => {
                    out.centroid = model[*id].coordinates[..].try_into().ok();
                }
                _ => {}
            }
        }
    }
    out
}

impl ReadBack {
    /// What a sound file of solids would not show; empty if all is well.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = vec![];
        if self.solids.is_empty() {
            let elsewhere = if self.files.is_empty() { String::new() } else { format!("; it refers to {}", self.files.join(", ")) };
            faults.push(format!("no solid in the file{elsewhere}"));
        }
        for s in &self.solids {
            if s.bad_edges > 0 {
                faults.push(format!("{}: {} of {} edges are not used exactly twice in opposite senses", s.name, s.bad_edges, s.edges));
            }
            if s.euler > 2 || s.euler % 2 != 0 {
                faults.push(format!("{}: Euler number {} is not that of one closed surface", s.name, s.euler));
            }
        }
        if let Some(first) = &self.first_dropped {
            faults.push(format!("{} of {} entities could not be read; the first is {first}", self.dropped, self.entities));
        }
        faults
    }
}

impl fmt::Display for ReadBack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let or_none = |x: Option<f64>| x.map_or("none".to_owned(), |x| x.to_string());
        writeln!(f, "schema       {}", self.schema.join(", "))?;
        let (shown, rest) = self.products.split_at(self.products.len().min(MOST_PRODUCTS));
        let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
        writeln!(f, "product      {}{more}", shown.join(", "))?;
        let unit = self.length_unit.as_ref().map_or("none".to_owned(), |(name, metres)| format!("{name} ({metres} m)"));
        writeln!(f, "length unit  {unit}, uncertainty {}", or_none(self.uncertainty))?;
        writeln!(f, "entities     {}, of which CIRCLE {}", self.entities, self.circles)?;
        writeln!(f, "solids       {}", self.solids.len())?;
        for s in &self.solids {
            writeln!(f, "  {}: {} shell(s), {} faces, {} edges, {} vertices", s.name, s.shells, s.faces, s.edges, s.vertices)?;
            writeln!(
                f,
                "    cylinders {}, cones {}, planes {}, spheres {}, splines {} in {} nodes, others {}",
                s.cylinders, s.cones, s.planes, s.spheres, s.splines, s.node_groups, s.other_faces
            )?;
            writeln!(f, "    V - E + F = {}, edges not used twice in opposite senses: {}", s.euler, s.bad_edges)?;
        }
        let v = &self.validation;
        writeln!(f, "stated       volume {}, area {}", or_none(v.volume), or_none(v.area))?;
        let centroid = v.centroid.map_or("none".to_owned(), |c| format!("{}, {}, {}", c[0], c[1], c[2]));
        write!(f, "             centroid {centroid}")
    }
}
