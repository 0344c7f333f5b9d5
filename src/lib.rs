//! A lattice graph becomes one closed, smooth, exact solid in a STEP file.
//!
//! Data flows one way: `graph ▶ cuts ▶ node ▶ patch ▶ brep ▶ step`. `docs/architecture.md` draws it.

pub mod brep;
pub mod cuts;
pub mod error;
pub mod evaluate;
pub mod graph;
pub mod ids;
pub mod inspect;
pub mod ladder;
pub mod math;
pub mod node;
pub mod options;
pub mod patch;
pub mod pipeline;
pub mod report;
pub mod settle;
pub mod step;
pub mod timing;
