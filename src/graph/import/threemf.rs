//! 3MF with the beam lattice extension: beams of `mesh` and `displacementmesh` objects, as often as the build has them.
//!
//! In the archive only names that its own files mention are looked up; nothing is written anywhere. Elements are known by
//! namespace, whatever the prefix. Left out with a note: surface meshes, balls, clip meshes, representation meshes. Cap modes
//! are noted: how free ends are closed is an option of the solid.

use super::draft::{Draft, Place};
use super::ltcx::named;
use super::xml::{Piece, Tag, Xml, decode};
use super::{Units, limits, text};
use crate::error::Fault;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Namespaces of core, beam lattice (and balls) and displacement, in all their years.
const SPACES: &[&str] = &["/3dmanufacturing/core/", "/3dmanufacturing/beamlattice/", "/3dmanufacturing/displacement/"];
/// A transform keeps shapes if its axes are equal and square to each other within this (relative). Reason: matrices are
/// written with four digits or more.
const SIMILAR: f64 = 1e-4;
/// A scale this near to 1 is 1. Reason: round-off of the matrix must not change a radius.
const NO_SCALE: f64 = 1e-6;

pub fn read(bytes: &[u8], draft: &mut Draft) {
    if let Err(fault) = package(bytes, draft) {
        draft.fault_at(fault.path, fault.found, fault.wanted);
    }
}

fn package(bytes: &[u8], draft: &mut Draft) -> Result<(), Fault> {
    let mut files = Files::open(bytes)?;
    let root = files.root_model()?;
    let mut models: BTreeMap<String, Model> = BTreeMap::new();
    // a model may name others, which are read in turn
    let mut wanted = vec![root.clone()];
    while let Some(path) = wanted.pop() {
        if models.contains_key(&path) {
            continue;
        }
        let prefix = if path == root { String::new() } else { format!("{}: ", text::shown(&path)) };
        let bytes = files.bytes(&path)?;
        let model = Model::read(decode(&bytes, &prefix)?, prefix, draft)?;
        wanted.extend(model.others());
        models.insert(path, model);
    }
    let model = &models[&root];
    draft.units = model.unit;
    for (path, other) in models.iter().filter(|(_, m)| m.unit != model.unit) {
        draft.fault_at(text::shown(path), format!("unit {:?}", other.unit), format!("{:?} as in the first model", model.unit));
    }
    draft.name = model.title.clone();
    let mut build = Build { models: &models, root: &root, draft, used: BTreeMap::new(), bare: 0, instances: 0 };
    build.items();
    Ok(())
}

/// The archive; what it may still unpack.
struct Files<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    most: u64,
    left: u64,
}

impl<'a> Files<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, Fault> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|e| Fault::new("document", text::shown(&e.to_string()), "a zip archive with a 3MF model"))?;
        let most = limits::unpacked(bytes.len());
        Ok(Files { zip, most, left: most })
    }

    /// The name of the model that the package starts with.
    fn root_model(&mut self) -> Result<String, Fault> {
        if let Ok(bytes) = self.bytes("_rels/.rels") {
            let mut xml = Xml::new(decode(&bytes, "_rels/.rels: ")?, &[], "_rels/.rels: ".into());
            while let Some(piece) = xml.next()? {
                let Piece::Open(tag) = piece else { continue };
                if tag.name() == "Relationship" && tag.get("Type").is_some_and(|t| t.ends_with("/3dmodel")) {
                    return Ok(tag.get("Target").unwrap_or_default().trim_start_matches('/').to_owned());
                }
            }
        }
        Ok("3D/3dmodel.model".to_owned())
    }

    /// A file of the archive, unpacked as far as the limit allows; what the archive says of its size is not believed.
    fn bytes(&mut self, path: &str) -> Result<Vec<u8>, Fault> {
        let of = |e: String| Fault::new(text::shown(path), e, "a file of the archive, stored or deflated, not encrypted");
        let index = self.zip.index_for_name(path).or_else(|| {
            let mut names = self.zip.file_names().enumerate();
            names.find(|(_, n)| n.as_ref().is_ok_and(|n| n.eq_ignore_ascii_case(path))).map(|(k, _)| k)
        });
        let index = index.ok_or_else(|| of("no such file".into()))?;
        let file = self.zip.by_index(index).map_err(|e| of(text::shown(&e.to_string())))?;
        let mut bytes = Vec::new();
        file.take(self.left + 1).read_to_end(&mut bytes).map_err(|e| of(text::shown(&e.to_string())))?;
        if bytes.len() as u64 > self.left {
            return Err(Fault::new(text::shown(path), format!("more than {} bytes unpacked", self.most), "a file that is not a zip bomb"));
        }
        self.left -= bytes.len() as u64;
        Ok(bytes)
    }
}

#[derive(Default)]
struct Model {
    unit: Units,
    title: Option<String>,
    /// What stands before a place in this model: its file name, but for the first model.
    prefix: String,
    objects: BTreeMap<u64, Object>,
    items: Vec<Reference>,
}

#[derive(Default)]
struct Object {
    name: Option<String>,
    vertices: Vec<Option<[f64; 3]>>,
    triangles: usize,
    lattice: Option<Lattice>,
    components: Vec<Reference>,
}

#[derive(Default)]
struct Lattice {
    radius: Option<String>,
    min_length: f64,
    beams: Vec<Beam>,
    /// Ends by cap mode.
    caps: BTreeMap<String, usize>,
    cap: String,
    /// What is left out, as notes.
    ignored: Vec<String>,
    balls: usize,
    all_balls: bool,
}

struct Beam {
    ends: [u32; 2],
    radii: Option<[f64; 2]>,
}

/// A component or a build item.
struct Reference {
    object: u64,
    /// The file of the object, if it is another.
    path: Option<String>,
    transform: DAffine3,
    place: String,
}

impl Model {
    fn read(text: &str, prefix: String, draft: &mut Draft) -> Result<Model, Fault> {
        let mut model = Model { prefix: prefix.clone(), ..Model::default() };
        let mut xml = Xml::new(text, SPACES, prefix.clone());
        let mut object: Option<(u64, Object)> = None;
        let mut title = None;
        while let Some(piece) = xml.next()? {
            match piece {
                Piece::Text(t) => _ = title.as_mut().map(|title: &mut String| title.push_str(&t)),
                Piece::Close(name) => match name.as_ref() {
                    "object" => {
                        if let Some((id, mut object)) = object.take() {
                            object.close(&format!("{prefix}object[{id}]"), draft);
                            if model.objects.insert(id, object).is_some() {
                                draft.fault_at(format!("{prefix}object[{id}]"), "a second object of this id", "each id once");
                            }
                        }
                    }
                    "metadata" => model.title = title.take().map(|t| t.trim().to_owned()).filter(|t| !t.is_empty()).or(model.title),
                    _ => {}
                },
                Piece::Open(tag) => match (tag.name(), object.as_mut()) {
                    ("model", None) => {
                        let unit = tag.get("unit").unwrap_or("millimeter".into());
                        match named(&unit) {
                            Some(unit) => model.unit = unit,
                            None => draft.fault_at(
                                format!("{prefix}model.unit"),
                                text::quoted(Some(&unit)),
                                "one of micron, millimeter, centimeter, inch, foot, meter",
                            ),
                        }
                    }
                    ("metadata", None) if tag.get("name").is_some_and(|n| n == "Title") => title = Some(String::new()),
                    ("object", None) => match tag.get("id").and_then(|id| id.parse().ok()) {
                        Some(id) => {
                            let name = tag.get("name").filter(|n| !n.is_empty()).map(|n| n.into_owned());
                            object = Some((id, Object { name, ..Object::default() }));
                        }
                        None => draft.fault_at(format!("{prefix}object"), text::quoted(tag.get("id").as_deref()), "a whole number as id"),
                    },
                    ("item", None) => {
                        let place = format!("{prefix}build.item[{}]", model.items.len());
                        model.items.extend(reference(&tag, place, draft));
                    }
                    (name, Some((id, object))) => object.element(name, &tag, || format!("{prefix}object[{id}]"), draft),
                    _ => {}
                },
            }
        }
        Ok(model)
    }

    /// The files of other models that this one names.
    fn others(&self) -> impl Iterator<Item = String> {
        self.items.iter().chain(self.objects.values().flat_map(|o| &o.components)).filter_map(|r| r.path.clone())
    }
}

impl Object {
    fn element(&mut self, name: &str, tag: &Tag, place: impl Fn() -> String, draft: &mut Draft) {
        match name {
            "vertex" => {
                let path = || format!("{}.vertices[{}]", place(), self.vertices.len());
                let mut sound = true;
                let position = ["x", "y", "z"].map(|axis| {
                    let value = tag.get(axis);
                    let x = value.as_deref().and_then(text::number);
                    if x.is_none() {
                        sound = false;
                        draft.fault_at(format!("{}.{axis}", path()), text::quoted(value.as_deref()), "a finite number");
                    }
                    x.unwrap_or_default()
                });
                self.vertices.push(sound.then_some(position));
            }
            "triangle" => self.triangles += 1,
            "component" => {
                let place = format!("{}.components[{}]", place(), self.components.len());
                self.components.extend(reference(tag, place, draft));
            }
            "beamlattice" => self.lattice = Some(Lattice::open(tag, &place(), draft)),
            "beam" => {
                if let Some(lattice) = &mut self.lattice {
                    lattice.beam(tag, place, draft);
                }
            }
            "ball" => {
                if let Some(lattice) = &mut self.lattice {
                    lattice.balls += 1;
                }
            }
            _ => {}
        }
    }

    /// The object is complete: beams end at its vertices. Vertices that no beam needs are given back.
    fn close(&mut self, place: &str, draft: &mut Draft) {
        let count = self.vertices.len();
        match &self.lattice {
            None => self.vertices = Vec::new(),
            Some(lattice) => {
                for (k, beam) in lattice.beams.iter().enumerate() {
                    for (name, end) in ["v1", "v2"].into_iter().zip(beam.ends).filter(|(_, end)| *end != u32::MAX && *end as usize >= count) {
                        draft.fault_at(format!("{place}.beams[{k}].{name}"), end, format!("a vertex index below {count}"));
                    }
                }
            }
        }
    }
}

impl Lattice {
    fn open(tag: &Tag, place: &str, draft: &mut Draft) -> Lattice {
        let place = format!("{place}.beamlattice");
        let mut length = |name: &str| {
            let value = tag.get(name)?;
            let read = text::number(&value).filter(|x| *x >= 0.0);
            if read.is_none() {
                draft.fault_at(format!("{place}.{name}"), text::quoted(Some(&value)), "a number, at least 0");
            }
            read
        };
        // a radius of 0 is none: such files give one with each beam
        let radius = length("radius").filter(|r| *r > 0.0).and_then(|_| tag.get("radius")).map(|r| r.into_owned());
        let min_length = length("minlength").unwrap_or_default();
        let mut ignored = Vec::new();
        if let Some(mode) = tag.get("clippingmode").or_else(|| tag.get("clipping")).filter(|m| m != "none") {
            let mesh = tag.get("clippingmesh").unwrap_or_default();
            ignored.push(format!("clipped {} by object {}: ignored, struts keep their whole length", text::shown(&mode), text::shown(&mesh)));
        }
        if let Some(mesh) = tag.get("representationmesh") {
            ignored.push(format!("representation mesh {}: ignored", text::shown(&mesh)));
        }
        let cap = tag.get("cap").unwrap_or("sphere".into()).into_owned();
        let all_balls = tag.get("ballmode").is_some_and(|m| m == "all");
        Lattice { radius, min_length, cap, ignored, all_balls, ..Lattice::default() }
    }

    fn beam(&mut self, tag: &Tag, place: impl Fn() -> String, draft: &mut Draft) {
        let k = self.beams.len();
        let path = |name: &str| format!("{}.beams[{k}].{name}", place());
        let ends = ["v1", "v2"].map(|name| {
            let value = tag.get(name);
            let end = value.as_deref().and_then(|v| v.parse().ok()).filter(|v| *v != u32::MAX);
            if end.is_none() {
                draft.fault_at(path(name), text::quoted(value.as_deref()), "the index of a vertex");
            }
            end.unwrap_or(u32::MAX)
        });
        let mut sound = true;
        let [r1, r2] = ["r1", "r2"].map(|name| {
            let value = tag.get(name)?;
            let radius = text::number(&value).filter(|r| *r > 0.0);
            if radius.is_none() {
                sound = false;
                draft.fault_at(path(name), text::quoted(Some(&value)), "a radius > 0");
            }
            radius
        });
        let r1 = r1.or_else(|| self.radius.as_deref().and_then(text::number));
        let radii = r1.map(|r1| [r1, r2.unwrap_or(r1)]);
        for name in ["cap1", "cap2"] {
            let cap = tag.get(name);
            let cap = cap.as_deref().unwrap_or(&self.cap);
            match self.caps.get_mut(cap) {
                Some(count) => *count += 1,
                None => _ = self.caps.insert(text::shown(cap), 1),
            }
        }
        let ends = if sound { ends } else { [u32::MAX; 2] };
        self.beams.push(Beam { ends, radii });
    }

    /// What a person should know of this lattice.
    fn notes(&self) -> Vec<String> {
        let mut notes = self.ignored.clone();
        if self.balls > 0 || self.all_balls {
            let which = if self.all_balls { "at all nodes".to_owned() } else { self.balls.to_string() };
            notes.push(format!("balls ({which}): ignored"));
        }
        let caps: Vec<String> = self.caps.iter().map(|(mode, count)| format!("{count} {mode}")).collect();
        notes.push(format!("cap modes of beam ends: {}; free ends are closed as --caps says", caps.join(", ")));
        notes
    }
}

fn reference(tag: &Tag, place: String, draft: &mut Draft) -> Option<Reference> {
    let object = tag.get("objectid").and_then(|id| id.parse().ok());
    if object.is_none() {
        draft.fault_at(format!("{place}.objectid"), text::quoted(tag.get("objectid").as_deref()), "the id of an object");
    }
    let transform = match tag.get("transform") {
        None => Some(DAffine3::IDENTITY),
        Some(text) => {
            let numbers: Option<Vec<f64>> = text.split_whitespace().map(text::number).collect();
            let matrix = numbers.and_then(|n| <[f64; 12]>::try_from(n).ok()).map(|n| DAffine3::from_cols_array(&n));
            if matrix.is_none() {
                draft.fault_at(format!("{place}.transform"), text::quoted(Some(&text)), "12 finite numbers");
            }
            matrix
        }
    };
    let path = tag.get("path").map(|p| p.trim_start_matches('/').to_owned()).filter(|p| !p.is_empty());
    Some(Reference { object: object?, path, transform: transform?, place })
}

/// The factor by which a matrix changes lengths; `None` if it changes shapes too.
fn scale(m: DMat3) -> Option<f64> {
    let scale = m.determinant().abs().cbrt();
    let axes = m.to_cols_array_2d().map(|c| DVec3::from(c) / scale);
    let is_similar = (0..3).all(|i| (axes[i].length() - 1.0).abs() <= SIMILAR && axes[i].dot(axes[(i + 1) % 3]).abs() <= SIMILAR);
    is_similar.then_some(if (scale - 1.0).abs() <= NO_SCALE { 1.0 } else { scale })
}

/// Puts the instances of all lattices into the draft.
struct Build<'m, 'd> {
    models: &'m BTreeMap<String, Model>,
    root: &'m str,
    draft: &'d mut Draft,
    /// Instances of each lattice, by place.
    used: BTreeMap<String, (usize, &'m Object)>,
    /// Instances of objects without a lattice.
    bare: usize,
    instances: usize,
}

impl<'m> Build<'m, '_> {
    fn items(&mut self) {
        let items = &self.models[self.root].items;
        for item in items {
            let place = if items.len() > 1 { format!("{}.", item.place) } else { String::new() };
            self.instance(self.root, item, DAffine3::IDENTITY, &place, 0);
        }
        if self.used.is_empty() && !self.draft.has_faults() {
            let lattices = self.models.values().flat_map(|m| m.objects.values()).filter(|o| o.lattice.is_some()).count();
            let found = format!("{} items without a beam lattice ({lattices} objects with one)", items.len());
            self.draft.fault_at("build", found, "an item whose object has a <beamlattice>");
        }
        if self.bare > 0 {
            self.draft.note("build", format!("{} instances of meshes without a beam lattice: left out", self.bare));
        }
        for (place, (instances, object)) in std::mem::take(&mut self.used) {
            if instances > 1 {
                self.draft.note(place.clone(), format!("{instances} instances in the build"));
            }
            if object.triangles > 0 {
                self.draft.note(place.clone(), format!("a surface of {} triangles: left out", object.triangles));
            }
            for note in object.lattice.iter().flat_map(Lattice::notes) {
                self.draft.note(place.clone(), note);
            }
            if self.draft.name.is_none() {
                self.draft.name = object.name.clone();
            }
        }
    }

    /// One item or component: `outer` takes its coordinates to those of the build, `place` says how it came here.
    fn instance(&mut self, file: &'m str, reference: &'m Reference, outer: DAffine3, place: &str, depth: usize) {
        self.instances += 1;
        if self.draft.is_full() || self.instances > limits::INSTANCES {
            if self.instances == limits::INSTANCES + 1 {
                self.draft.fault_at("build", format!("more than {} instances", limits::INSTANCES), format!("at most {}", limits::INSTANCES));
            }
            return;
        }
        if depth > limits::COMPONENT_DEPTH {
            return self.draft.fault_at(&reference.place, format!("components nested more than {depth} deep"), format!("at most {}", limits::COMPONENT_DEPTH));
        }
        let file = reference.path.as_deref().unwrap_or(file);
        let Some((model, object)) = self.models.get(file).and_then(|m| Some((m, m.objects.get(&reference.object)?))) else {
            return self.draft.fault_at(format!("{}.objectid", reference.place), reference.object, "the id of an object");
        };
        let transform = outer * reference.transform;
        if let Some(lattice) = &object.lattice {
            match scale(transform.matrix3) {
                Some(scale) => {
                    let name = format!("{}object[{}]", model.prefix, reference.object);
                    self.pour(object, lattice, transform, scale, &format!("{place}{name}"));
                    self.used.entry(name).or_insert((0, object)).0 += 1;
                }
                None => {
                    let m = transform.matrix3.to_cols_array_2d().map(|c| DVec3::from(c).length());
                    let found = format!("a transform that changes shapes (lengths of the axes {}, {}, {})", m[0], m[1], m[2]);
                    self.draft.fault_at(format!("{}.transform", reference.place), found, "rotation, mirror, one scale: a round strut must stay round");
                }
            }
        } else if object.components.is_empty() {
            self.bare += 1;
        }
        for component in &object.components {
            self.instance(file, component, transform, place, depth + 1);
        }
    }

    fn pour(&mut self, object: &Object, lattice: &Lattice, transform: DAffine3, scale: f64, place: &str) {
        let vertex_kind = self.draft.kind(format!("{place}.vertices["), "]");
        let beam_kind = self.draft.kind(format!("{place}.beams["), "]");
        let mut node = vec![u32::MAX; object.vertices.len()];
        let mut too_short = 0;
        for (k, beam) in lattice.beams.iter().enumerate() {
            let corners = beam.ends.map(|v| object.vertices.get(v as usize).copied());
            let [Some(p), Some(q)] = corners else { continue };
            let is_short = p.zip(q).is_some_and(|(p, q)| DVec3::from(p).distance(DVec3::from(q)) < lattice.min_length);
            if is_short {
                too_short += 1;
                continue;
            }
            let ends = [(beam.ends[0], p), (beam.ends[1], q)].map(|(v, position)| {
                if node[v as usize] == u32::MAX {
                    let moved = position.map(|p| transform.transform_point3(DVec3::from(p)).to_array());
                    node[v as usize] = self.draft.node(Place { kind: vertex_kind, at: v }, moved);
                }
                node[v as usize]
            });
            self.draft.strut(Place { kind: beam_kind, at: k as u32 }, ends, beam.radii.map(|r| r.map(|r| r * scale)));
            if self.draft.is_full() {
                return;
            }
        }
        if too_short > 0 {
            self.draft.note(place, format!("{too_short} beams shorter than minlength {}: left out, as the format asks", lattice.min_length));
        }
    }
}
