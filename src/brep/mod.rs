//! B-rep layer: `Skin`s and struts ▶ `Model`, one closed solid per connected component.
//! Lengths in mm.
//!
//! Promised: every edge used twice in opposite senses, shared points bit for bit equal, exact
//! cylinders, cones and circles, ids that depend on the graph alone. Each promise has its own check.

pub mod assemble;
pub mod blocks;
pub mod clearance;
pub mod continuity;
pub mod error;
pub mod measure;
pub mod model;
pub mod part;
pub mod rim_map;
pub mod seam;
pub mod topology;
pub mod units;

pub use assemble::{AssembleOptions, Caps, assemble};
pub use blocks::blocks;
pub use clearance::{Crossing, Other, crossings, unit_crossings};
pub use continuity::{Quality, QualityLimits, Worst, quality};
pub use error::BrepError;
pub use measure::{Measure, measure, total as measure_total};
pub use model::{Circle, Curve, Edge, EdgeUse, Face, Label, Model, Part, Solid, SplineCurve, SplineSurface, Surface};
pub use rim_map::RimMap;
pub use topology::{Borders, Counts, check_topology};
pub use units::{Instance, units};
