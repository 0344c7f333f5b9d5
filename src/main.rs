//! The command `lattice-brep`.

mod cli;

use clap::{Parser, Subcommand};
use lattice_brep::error::Error;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Most faults shown on the terminal; a report or the library lists them all.
const MOST_FAULTS_SHOWN: usize = 50;

/// A lattice graph becomes one closed, smooth, exact solid in a STEP file
#[derive(Parser)]
#[command(version)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Bench(cli::bench::BenchArgs),
    Cell(cli::cell::CellArgs),
    Check(cli::check::CheckArgs),
    Evaluate(cli::evaluate::EvaluateArgs),
    Export(cli::export::ExportArgs),
    Inspect(cli::inspect::InspectArgs),
    Repair(cli::repair::RepairArgs),
    Schema(cli::schema::SchemaArgs),
}

fn main() -> ExitCode {
    let command = Args::parse().command;
    let result = cli::output::clean_up_on_interrupt().and_then(|()| run(&command));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", error.brief(MOST_FAULTS_SHOWN));
            if let Command::Export(args) = &command
                && let Some(advice) = args.on_conflict.advice(&error)
            {
                eprintln!("help: {advice}");
            }
            ExitCode::from(error.exit_code() as u8)
        }
    }
}

fn run(command: &Command) -> Result<(), Error> {
    match command {
        Command::Bench(args) => cli::bench::run(args),
        Command::Cell(args) => cli::cell::run(args),
        Command::Check(args) => cli::check::run(args),
        Command::Evaluate(args) => cli::evaluate::run(args),
        Command::Export(args) => cli::export::run(args),
        Command::Inspect(args) => cli::inspect::run(args),
        Command::Repair(args) => cli::repair::run(args),
        Command::Schema(args) => cli::schema::run(args),
    }
}
