//! Files of parts ▶ Part 21 text of the assembly of them all: each part stands at the origin, and its shape is in a file of its own.
//!
//! References follow the PDM schema's usage guide and the CAx-IF recommended practice for external references: a DOCUMENT_FILE with the file's
//! name, applied to the part's PRODUCT_DEFINITION, and the part's shape in it as the file's "external definition".

use super::assembly::{MEMBER, PART, Product, WHOLE, member_text, numbered};
use super::options::{Decimals, StepOptions};
use super::text::string;
use super::write::{FIRST, Facts, StepError, Written, check, has_extras, preamble};
use glam::DVec3;
use std::io::Write;

/// What all references share, and one reference and how many entities it has.
const SHARED: &str = include_str!("../../step_templates/external.txt");
const FILE: (&str, u64) = (include_str!("../../step_templates/external_file.txt"), 7);

/// A file of the assembly.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct External {
    /// As seen from the folder of the assembly's file.
    pub file: String,
    /// The product in that file.
    pub product: String,
}

/// Write the assembly of some files; `facts` are of all together.
pub fn write_master(files: &[External], facts: &Facts, options: &StepOptions, mut out: impl Write + Send) -> Result<Written, StepError> {
    check(&[], facts, options)?;
    if !has_extras(options.schema) {
        return Err(StepError::NoAssembly);
    }
    if files.is_empty() {
        return Err(StepError::NoBlocks);
    }
    // all of one file together
    let each = PART.1 + MEMBER.1 + FILE.1;
    let first_of = |k: usize| FIRST + each * k as u64;
    let placements: String = (0..files.len()).map(|k| format!(",#{}", first_of(k) + PART.1 + 1)).collect();
    out.write_all(preamble("SHAPE_REPRESENTATION", &placements, &[], facts, Decimals::NONE, options).as_bytes())?;
    out.write_all(SHARED.as_bytes())?;
    for (k, External { file, product }) in files.iter().enumerate() {
        let first = first_of(k);
        let part = Product::at(first);
        let (name, file) = (string(product), string(file));
        out.write_all(numbered(PART, first, &[("name", &name), ("kind", "SHAPE_REPRESENTATION"), ("items", "")]).as_bytes())?;
        out.write_all(member_text(first + PART.1, k + 1, &format!("block_{}", k + 1), DVec3::ZERO, part, WHOLE).as_bytes())?;
        let ids = [part.definition, part.shape].map(|id| id.to_string());
        let values = [("file", &file[..]), ("definition", &ids[0]), ("shape", &ids[1])];
        out.write_all(numbered(FILE, first + PART.1 + MEMBER.1, &values).as_bytes())?;
    }
    out.write_all(include_str!("../../step_templates/footer.txt").as_bytes())?;
    out.flush()?;
    Ok(Written { last_entity: first_of(files.len()) - 1 })
}
