//! `Model` ▶ Part 21 text: header, product, context, solids, colours, validation properties.

use super::geometry::{Numbers, write_solid};
use super::options::{Decimals, Schema, StepOptions, TimeStamp};
use super::template::fill;
use super::text::{real, string};
use crate::brep::{Measure, Model, Solid};
use std::io::{self, Write};
use std::ops::Range;

/// Entities of the solids start here; the templates use the numbers below.
pub(super) const FIRST: u64 = 101;

/// The file never claims an uncertainty below this (mm): the resolution that common kernels assume
/// anyway, and far below any strut.
pub const LEAST_UNCERTAINTY: f64 = 1e-7;

/// The rule that the validation properties follow, in the wording that checkers look for.
const VALIDATION_PRACTICE: &str = "CAx-IF Rec.Pracs.---Geometric and Assembly Validation Properties---4.6---2023-04-21";

/// What was measured on the model and goes into the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts {
    /// Of all solids together.
    pub measure: Measure,
    /// Largest gap between an edge and a face, mm.
    pub gap_mm: f64,
}

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// The largest entity number.
    pub last_entity: u64,
}

#[derive(Debug, thiserror::Error)]
pub enum StepError {
    #[error("solid {solid}: a coordinate, weight, radius or knot is not a finite number")]
    NotFinite { solid: usize },
    #[error("the measured volume, area, centroid or gap is not a finite number")]
    FactsNotFinite,
    #[error("the product's name has no character to be seen")]
    NoProductName,
    #[error("colour {0:?}: wanted three numbers from 0 to 1")]
    Colour([f64; 3]),
    #[error("AP203 edition 1 files hold no assemblies here: each part would need its own approvals")]
    NoAssembly,
    #[error("no file to refer to")]
    NoBlocks,
    #[error("cannot write: {0}")]
    Io(#[from] io::Error),
}

/// Write the model as one part with one solid per component. `out` should be buffered.
pub fn write(model: &Model, facts: &Facts, options: &StepOptions, out: impl Write + Send) -> Result<Written, StepError> {
    write_some(model, 0..model.solids.len(), facts, options, out)
}

/// The same for some solids of a model; reals are rounded as in a file of all, so that what two files share is the same in both.
pub fn write_some(model: &Model, solids: Range<usize>, facts: &Facts, options: &StepOptions, mut out: impl Write + Send) -> Result<Written, StepError> {
    let (solids, decimals) = (&model.solids[solids], decimals(&model.solids, options));
    check(solids, facts, options)?;
    let (numbers, next) = numbers(solids);
    let breps: String = numbers.iter().map(|n| format!(",#{}", n.brep)).collect();
    out.write_all(preamble("ADVANCED_BREP_SHAPE_REPRESENTATION", &breps, &numbers, facts, decimals, options).as_bytes())?;
    write_solids(&mut out, solids, &numbers, "solid", decimals, options)?;
    out.write_all(include_str!("../../step_templates/footer.txt").as_bytes())?;
    out.flush()?;
    Ok(Written { last_entity: next - 1 })
}

/// The numbers of all solids, and the next free one.
pub(super) fn numbers(solids: &[Solid]) -> (Vec<Numbers>, u64) {
    let mut next = FIRST;
    let of_solid = |solid| {
        let ids = Numbers::new(solid, next);
        next = ids.styled + 1;
        ids
    };
    let numbers = solids.iter().map(of_solid).collect();
    (numbers, next)
}

pub(super) fn write_solids(
    out: &mut (impl Write + Send),
    solids: &[Solid],
    numbers: &[Numbers],
    noun: &str,
    decimals: Decimals,
    options: &StepOptions,
) -> io::Result<()> {
    for (k, (solid, ids)) in solids.iter().zip(numbers).enumerate() {
        let name = format!("'{noun}_{}'", k + 1);
        write_solid(out, solid, &name, ids, decimals)?;
        if has_extras(options.schema) {
            writeln!(out, "#{}=STYLED_ITEM('colour',(#22),#{});", ids.styled, ids.brep)?;
        }
    }
    Ok(())
}

/// How reals of these solids are rounded.
pub(super) fn decimals(solids: &[Solid], options: &StepOptions) -> Decimals {
    let radii = solids.iter().flat_map(|solid| &solid.circles).map(|circle| circle.radius);
    Decimals::new(options.digits, radii.fold([f64::INFINITY, 0.0], |[least, largest], r| [least.min(r), largest.max(r)]))
}

/// AP203 edition 1 has neither styles nor measure items.
pub(super) fn has_extras(schema: Schema) -> bool {
    schema != Schema::Ap203
}

/// Numbers must be finite: Part 21 has no token for others.
pub(super) fn check(solids: &[Solid], facts: &Facts, options: &StepOptions) -> Result<(), StepError> {
    let m = &facts.measure;
    if !(m.volume.is_finite() && m.area.is_finite() && m.centroid.is_finite() && facts.gap_mm.is_finite()) {
        return Err(StepError::FactsNotFinite);
    }
    if options.product.chars().all(|c| c.is_control() || c.is_whitespace()) {
        return Err(StepError::NoProductName);
    }
    if !options.colour.iter().all(|c| (0.0..=1.0).contains(c)) {
        return Err(StepError::Colour(options.colour));
    }
    match solids.iter().position(|s| !s.is_finite()) {
        Some(solid) => Err(StepError::NotFinite { solid }),
        None => Ok(()),
    }
}

/// All before the solids; the product's shape is of this kind and holds these items.
pub(super) fn preamble(kind: &str, items: &str, numbers: &[Numbers], facts: &Facts, decimals: Decimals, options: &StepOptions) -> String {
    let product = string(&options.product);
    let author = string(&options.author);
    let organization = string(&options.organization);
    let description = match has_extras(options.schema) {
        true => format!("'Lattice solid','{VALIDATION_PRACTICE}'"),
        false => "'Lattice solid'".into(),
    };
    let mut text = fill(
        include_str!("../../step_templates/header.txt"),
        &[
            ("description", &description),
            ("file_name", &string(&options.file_name)),
            ("time_stamp", &options.time_stamp.to_string()),
            ("author", &author),
            ("organization", &organization),
            ("preprocessor", &string(concat!("lattice-brep ", env!("CARGO_PKG_VERSION")))),
            ("system", "'lattice-brep'"),
            ("schema", options.schema.identifier()),
        ],
    );
    let common = |application: &str, protocol: &str, year: &str| {
        fill(include_str!("../../step_templates/product.txt"), &[("application", application), ("protocol", protocol), ("year", year), ("product", &product)])
    };
    text += &match options.schema {
        Schema::Ap242 => common("Managed model based 3d engineering", "ap242_managed_model_based_3d_engineering", "2013"),
        Schema::Ap214 => common("core data for automotive mechanical design processes", "automotive_design", "2000"),
        Schema::Ap203 => {
            let TimeStamp { year, month, day, hour, minute, second } = options.time_stamp;
            fill(
                include_str!("../../step_templates/product_ap203.txt"),
                &[
                    ("product", &product),
                    ("author", &author),
                    ("organization", &organization),
                    ("date", &format!("{year},{day},{month}")),
                    ("time", &format!("{hour},{minute},{second}.")),
                ],
            )
        }
    };
    text += &fill(include_str!("../../step_templates/shape.txt"), &[("kind", kind), ("items", items)]);
    let uncertainty = real(uncertainty(facts.gap_mm + decimals.off()));
    text += &fill(include_str!("../../step_templates/context.txt"), &[("uncertainty", &uncertainty)]);
    if has_extras(options.schema) {
        let [red, green, blue] = options.colour.map(real);
        let styled: Vec<String> = numbers.iter().map(|n| format!("#{}", n.styled)).collect();
        let values = [("styled", &styled.join(",")[..]), ("red", &red), ("green", &green), ("blue", &blue)];
        if !styled.is_empty() {
            text += &fill(include_str!("../../step_templates/appearance.txt"), &values);
        }
        let m = &facts.measure;
        text += &fill(
            include_str!("../../step_templates/validation.txt"),
            &[("volume", &real(m.volume)), ("area", &real(m.area)), ("centroid", &m.centroid.to_array().map(real).join(","))],
        );
    }
    text
}

/// What the file claims: the power of ten at or above the gap, at least `LEAST_UNCERTAINTY`.
fn uncertainty(gap: f64) -> f64 {
    if gap <= LEAST_UNCERTAINTY {
        return LEAST_UNCERTAINTY;
    }
    let exponent = gap.log10().ceil() as i32;
    // Through text, so that the value is the double nearest to the power.
    let power = |e: i32| format!("1e{e}").parse::<f64>().expect("a power of ten");
    if power(exponent) >= gap { power(exponent) } else { power(exponent + 1) }
}

#[cfg(test)]
mod tests {
    use super::uncertainty;

    #[test]
    fn uncertainty_is_never_below_the_gap() {
        for (gap, claim) in [(0.0, 1e-7), (1e-7, 1e-7), (1.1e-7, 1e-6), (1e-5, 1e-5), (3e-3, 1e-2)] {
            assert_eq!(uncertainty(gap), claim);
        }
    }
}
