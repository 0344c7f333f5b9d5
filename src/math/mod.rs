//! Floor: plain geometry and numbers that every layer may use. Knows nothing of lattices.

pub mod bernstein;
pub mod gauss;
pub mod nurbs;
pub mod sparse;
