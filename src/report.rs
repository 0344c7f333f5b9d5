//! What a run found and made, for people and for programs. Lengths in mm unless a name says otherwise.

use crate::error::Note;
use crate::graph::repair::Repair;
use crate::ids::{NodeId, StrutId};
use schemars::JsonSchema;
use serde::Serialize;

/// The whole report (`--report`).
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Report {
    /// Program and version.
    pub program: String,
    /// What the file holds; of an assembly, what its different parts hold; of blocks, what all of them hold: half a strut counts as one.
    pub counts: Counts,
    /// Parts placed in an assembly; 0 without `--assembly`.
    pub instances: usize,
    /// One for each connected part, in the order of the file.
    pub solids: Vec<Solid>,
    /// Volume, area and centroid of all together; in an assembly each part counts as often as it is placed. Discs between parts or blocks count on both sides.
    pub volume_mm3: f64,
    pub area_mm2: f64,
    pub centroid_mm: [f64; 3],
    /// Volume that the nodes add to the union of their struts and node spheres, and volume of it that they leave out: sampled.
    pub added_mm3: f64,
    pub removed_mm3: f64,
    /// Least radius of a valley inside the nodes (1 / the largest concave curvature), at samples of each patch. None where nothing is concave;
    /// sharp nodes apart, whose creases have none.
    pub concave_radius_mm: Option<Worst>,
    /// The same for each node that has one, where a blend was asked for.
    pub valleys: Vec<Valley>,
    pub quality: Quality,
    pub rungs: Rungs,
    pub cuts: Cuts,
    /// Everything changed in the input or left out of it.
    pub changes: Vec<Note>,
    /// The repairs that were asked for and the nodes that needed no skin, in the order they were made, with all that is needed to take them back.
    pub repairs: Vec<Repair>,
    /// Size of the STEP text, of all files.
    pub bytes: u64,
    pub stages: Vec<StageTime>,
}

/// How much there is of everything.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Counts {
    /// Nodes with at least one strut.
    pub nodes: usize,
    pub struts: usize,
    pub faces: usize,
    /// Cylindrical faces: one per strut of one radius.
    pub cylinders: usize,
    /// Conical faces: one per tapered strut.
    pub cones: usize,
    /// Spline faces.
    pub patches: usize,
    /// Faces that close degree-1 ends, and struts halved between parts or blocks.
    pub caps: usize,
    /// Rim circles: two per strut.
    pub circles: usize,
    pub edges: usize,
    pub vertices: usize,
    /// Connected components: one solid each.
    pub components: usize,
    /// Sum of the solids' genera: struts - nodes + components, where each half of a strut has an end node of its own.
    pub genus: i64,
}

/// One solid: a connected part of the lattice.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Solid {
    /// The smallest of its nodes' ids.
    pub first_node: NodeId,
    pub nodes: usize,
    pub struts: usize,
    /// Independent loops of struts.
    pub genus: i64,
    pub volume_mm3: f64,
}

/// A figure and where it was found.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Worst {
    pub value: f64,
    /// Names as in the STEP file, such as `node_12/strut_7/1`.
    pub place: String,
}

/// The least radius of a node's valleys.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Valley {
    pub node: NodeId,
    pub radius_mm: f64,
}

/// The worst figures of the solid, sampled along all edges and inside all patches.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Quality {
    /// Largest angle between the normals of two patches at their common edge, degrees. Sharp nodes apart.
    pub inner_jump_deg: Worst,
    /// Largest angle between patch and strut at a rim, degrees.
    pub rim_jump_deg: Worst,
    /// Largest distance between a border and its edge curve or circle, mm.
    pub gap_mm: Worst,
    /// Least cosine between a patch's normal and the ray from its node; below 0 it would be folded.
    pub facing: Worst,
    /// Largest distance between patches and film, in strut radii.
    pub deviation_radii: Worst,
    /// Mean over nodes of the mean distance between patches and film, in strut radii.
    pub mean_deviation_radii: f64,
    /// Least angle between the lines of constant parameters of a patch, degrees, and its node: small ones are hard for other programs.
    pub isoline_deg: Worst,
    /// Largest difference of the mean curvatures on both sides of an edge, times the largest radius of its node's struts: the solid is tangent-continuous, not
    /// curvature-continuous.
    pub curvature_jump: Worst,
    /// Nodes whose patches stay further from their film than the tolerance asks.
    pub over_tolerance: usize,
}

/// How the nodes were built, from the best way down. Degree-1 ends need no building and are not counted.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct Rungs {
    /// Soap film, exactly tangent-continuous patches.
    pub soap_film: usize,
    /// As those, where the ball that fills the valleys (that of `--blend`, or the usual small one) leads to no skin: faired without a ball.
    pub no_ball: Vec<Lowered>,
    /// Level-set film, exactly tangent-continuous patches.
    pub level_set: Vec<Lowered>,
    /// Level-set film, exactly tangent-continuous patches with more control points.
    pub more_control: Vec<Lowered>,
    /// The struts' own cylinders meeting in sharp creases: tangency dropped inside the node, kept at the rims.
    pub sharp: Vec<Lowered>,
}

/// A node below the first rung.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Lowered {
    pub node: NodeId,
    /// Number of struts.
    pub degree: usize,
    /// Why each higher rung failed.
    pub reasons: Vec<String>,
}

/// How struts came to their cuts. A strut counts once, under the last of these means that it needed; shrunk ones count again.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct Cuts {
    /// Struts with the cuts that lambda asks for.
    pub preferred: usize,
    /// Struts with cuts between those and touching rims.
    pub smaller_lambda: usize,
    /// Struts cut shorter than their neighbours at a node, or longer to make room for one.
    pub unequal_cuts: usize,
    /// Struts that share their length between their ends in another proportion than their cuts asked for.
    pub unequal_sharing: usize,
    /// All struts without their preferred cuts.
    pub changed: Vec<ChangedCuts>,
    /// Struts whose radii were made smaller (`--on-conflict shrink`).
    pub shrunk: Vec<ShrunkStrut>,
    /// Sum of the volume they lost, from node to node.
    pub shrunk_volume_mm3: f64,
}

/// A strut without its preferred cuts: distances of its rims from its nodes, at ends a and b.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ChangedCuts {
    pub strut: StrutId,
    pub means: String,
    pub before_mm: [f64; 2],
    pub after_mm: [f64; 2],
}

/// A strut whose radii were made smaller, at one end or both: radii at ends a and b, and the volume lost from node to node.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ShrunkStrut {
    pub strut: StrutId,
    pub before_mm: [f64; 2],
    pub after_mm: [f64; 2],
    pub volume_mm3: f64,
}

/// Wall-clock time of one stage.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct StageTime {
    pub stage: String,
    pub seconds: f64,
}

/// What `--blocks` wrote: all files, and what is in them together.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// Program and version.
    pub program: String,
    /// The assembly that refers to the blocks.
    pub master: Hashed,
    pub solids: usize,
    pub nodes: usize,
    /// Those of the lattice: two halves are one.
    pub struts: usize,
    pub volume_mm3: f64,
    /// The discs between blocks count on both sides.
    pub area_mm2: f64,
    /// In the order of their numbers.
    pub blocks: Vec<BlockFile>,
}

/// The file of a block.
#[derive(Clone, Debug, Serialize)]
pub struct BlockFile {
    #[serde(flatten)]
    pub file: Hashed,
    pub solids: usize,
    pub nodes: usize,
    /// Whole ones.
    pub struts: usize,
    /// Struts that lead to other blocks, closed by a disc.
    pub half_struts: usize,
    pub volume_mm3: f64,
    pub area_mm2: f64,
}

/// A file and its bytes.
#[derive(Clone, Debug, Serialize)]
pub struct Hashed {
    /// Its name, in the folder of the manifest.
    pub file: String,
    /// Of its bytes, in hexadecimal digits.
    pub sha256: String,
    pub bytes: u64,
}

/// The JSON Schema of the report.
pub fn schema() -> String {
    serde_json::to_string_pretty(&schemars::schema_for!(Report)).expect("a schema is plain JSON") + "\n"
}
