//! Repairs of an unchecked `Input`, each only when asked for but `chains::straight`: `Input ▶ Input` and a record from which `undo` makes the old one again.
//!
//! Order: weld, drop loose parts, collapse chains. `merge` is apart: it answers conflicts of cuts, which only the node layer knows.
//! What stays keeps its order and, if nothing is said of it in the record, its place and radii bit for bit. Pieces that are out of
//! range or not finite are left for the checks to tell. Promised: the same input gives the same bytes; a repair made again on its own
//! result changes nothing.

pub mod chains;
pub mod loose;
pub mod merge;
pub mod record;
pub mod weld;

pub use merge::{Merged, merge};
pub use record::{Repair, undo};

use super::Input;

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Nodes at most this far apart (mm) become one.
    pub weld: Option<f64>,
    /// Parts of less volume than this share of the largest part's are dropped, in (0, 1].
    pub drop_loose: Option<f64>,
    /// Straight chains become one strut where that moves nothing by more than this, in radii of the chain's thinnest strut.
    pub collapse_chains: Option<f64>,
}

/// A lattice after its repairs, not yet checked, and their records in the order they were made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Repaired {
    pub input: Input,
    pub repairs: Vec<Repair>,
}

/// Make all repairs that are asked for.
pub fn repair(input: Input, wanted: &Wanted) -> Repaired {
    let mut repaired = Repaired { input, repairs: Vec::new() };
    let steps: [(Option<f64>, fn(&Input, f64) -> (Input, Repair)); 3] =
        [(wanted.weld, weld::weld), (wanted.drop_loose, loose::drop_loose), (wanted.collapse_chains, chains::collapse)];
    for (limit, step) in steps {
        if let Some(limit) = limit {
            repaired.then(|input| step(input, limit));
        }
    }
    repaired
}

impl Repaired {
    /// Make one more repair.
    pub fn then(&mut self, step: impl FnOnce(&Input) -> (Input, Repair)) {
        let (input, repair) = step(&self.input);
        self.input = input;
        self.repairs.push(repair);
    }
}
