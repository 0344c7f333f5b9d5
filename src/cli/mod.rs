//! The command line: translates arguments into calls of the library, nothing else.

pub mod bench;
pub mod cell;
pub mod check;
pub mod evaluate;
pub mod export;
pub mod input;
pub mod inspect;
pub mod output;
pub mod repair;
pub mod schema;
