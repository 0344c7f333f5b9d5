//! `lattice-brep cell`: writes a block of a unit cell as a lattice graph.

use super::output;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use lattice_brep::error::Error;
use lattice_brep::graph::catalogue::{self, Cell};
use lattice_brep::graph::json;
use std::path::PathBuf;

/// Write a block of unit cells as a lattice graph in JSON
#[derive(Debug, clap::Args)]
pub struct CellArgs {
    /// Unit cell
    #[arg(value_name = "NAME", value_parser = cell_parser())]
    cell: Cell,

    /// Edge length of one cell, in mm
    #[arg(long, value_name = "MM", default_value_t = 10.0, allow_negative_numbers = true)]
    size: f64,

    /// Number of cells along x, y and z (no unit), such as 3x3x3
    #[arg(long, value_name = "NXxNYxNZ", default_value = "1x1x1", value_parser = parse_repeat)]
    repeat: [u32; 3],

    /// Radius of all struts, in mm
    #[arg(long, value_name = "MM", default_value_t = 0.5, allow_negative_numbers = true)]
    radius: f64,

    /// File to write (JSON, lengths in mm); standard output if absent
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(args: &CellArgs) -> Result<(), Error> {
    let graph = catalogue::generate(args.cell, args.size, args.repeat, args.radius)?;
    output::write(args.output.as_deref(), |out| json::write(&graph, Some(args.cell.name()), out))
}

fn cell_parser() -> impl TypedValueParser<Value = Cell> {
    let names = Cell::ALL.map(|cell| PossibleValue::new(cell.name()).help(cell.description()));
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Cell>())
}

/// `3x3x3`, or `3` for the same along each axis.
fn parse_repeat(text: &str) -> Result<[u32; 3], String> {
    let counts: Result<Vec<u32>, _> = text.split('x').map(str::parse).collect();
    match counts.as_deref() {
        Ok(&[n]) => Ok([n; 3]),
        Ok(&[nx, ny, nz]) => Ok([nx, ny, nz]),
        _ => Err("wanted three whole numbers, such as 3x3x3".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeat_is_three_whole_numbers_or_one() {
        assert_eq!(parse_repeat("3x2x1"), Ok([3, 2, 1]));
        assert_eq!(parse_repeat("4"), Ok([4, 4, 4]));
        for wrong in ["", "3x3", "3x3x3x3", "3x-1x3", "axbxc", "3.5"] {
            assert!(parse_repeat(wrong).is_err(), "{wrong}");
        }
    }
}
