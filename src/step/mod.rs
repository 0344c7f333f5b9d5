//! STEP layer: `Model` ▶ text (ISO 10303-21), and a reader that counts what a file holds.
//! Small fixed parts come from `step_templates/`; geometry and topology are streamed.
//!
//! Promised: bytes depend on the model and the options alone; strings are plain ASCII; numbers
//! read back to the same bits (unless rounding is asked for).

mod assembly;
pub mod compressed;
pub mod geometry;
mod groups;
mod master;
pub mod options;
pub mod readback;
pub mod template;
pub mod text;
pub mod write;

pub use assembly::write_assembly;
pub use master::{External, write_master};
pub use options::{Digits, Schema, StepOptions, TimeStamp};
pub use readback::{ReadBack, ReadBackError, SolidCounts, Validation, read_back};
pub use write::{Facts, StepError, Written, write, write_some};
