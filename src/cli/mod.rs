//! The command line: translates arguments into calls of the library, nothing else.

pub mod cell;
pub mod export;
pub mod output;
pub mod schema;
