//! What a user can ask for, as the pipeline takes it. The doors (command line, later others) fill this in once.

use crate::brep::Caps;
use crate::graph::check::Overlaps;
use crate::node::Fairing;
use crate::step::StepOptions;
use std::path::PathBuf;

/// What to do where no cuts fit on a strut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnConflict {
    /// Refuse the graph, naming all struts with the numbers.
    #[default]
    Refuse,
    /// Make radii smaller until cuts fit, nodes can be built, and (`part`) struts that overlap without a common node are apart.
    Shrink { part: bool },
}

/// What becomes a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Divide {
    /// Each connected part of the lattice.
    #[default]
    Not,
    /// Each different node with its half struts: the parts of an assembly, placed wherever they stand.
    Nodes,
    /// Each connected part of so many blocks of neighbouring nodes; each block is a file.
    Blocks(usize),
}

/// Default of [`Options::skins_in_memory`]. Guessed: some 100,000 patches, so that few lattices need the disk.
pub const SKINS_IN_MEMORY: usize = 256 << 20;

/// Options of one run from graph to STEP text.
#[derive(Clone, Debug)]
pub struct Options {
    /// λ of the paper's equation 5: how far cuts reach beyond the least. In (0, 0.5).
    pub lambda: f64,
    pub on_conflict: OnConflict,
    /// What to do where the skin of a node meets a strut that does not end there, or another skin.
    pub overlaps: Overlaps,
    /// Refinement levels of the film (the paper: 3).
    pub levels: u32,
    pub fairing: Fairing,
    /// Largest distance wanted between a node's patches and its film, in strut radii. Nodes that miss it get more
    /// control points; those that still miss it are counted in the report.
    pub tolerance: f64,
    pub caps: Caps,
    pub divide: Divide,
    /// Nodes of equal stars are built once; else each for itself, to measure what that costs.
    pub cache: bool,
    /// A folder for a temporary file without a name, where what is built waits if it is much; none: all stays in memory.
    pub scratch: Option<PathBuf>,
    /// Bytes of skins that stay in memory where there is such a folder.
    pub skins_in_memory: usize,
    pub step: StepOptions,
}

impl Options {
    /// Radius of the ball that fills valleys, node radii, where one was asked for.
    pub fn blend(&self) -> Option<f64> {
        if let Fairing::Ball(ball) = self.fairing { Some(ball) } else { None }
    }
}

impl Default for Options {
    fn default() -> Self {
        Options {
            lambda: 0.3,
            on_conflict: OnConflict::Refuse,
            overlaps: Overlaps::Refuse,
            levels: 3,
            fairing: Fairing::Filled,
            tolerance: 0.05,
            caps: Caps::Flat,
            divide: Divide::Not,
            cache: true,
            scratch: None,
            skins_in_memory: SKINS_IN_MEMORY,
            step: StepOptions::default(),
        }
    }
}
