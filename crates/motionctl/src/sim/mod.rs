//! `motionctl sim`: a motion from a file on simulated drives.

mod arguments;
mod bench;
mod error;
mod summary;
mod watch;

use std::fs::File;
use std::io::BufWriter;
use std::process::ExitCode;

use crate::exit;
use crate::trajectory::{Columns, Plan, Table};
pub(crate) use arguments::Arguments;
use bench::{Bench, Setup};
use error::SimError;
use summary::Summary;

/// The motion that runs when no file is given.
const EXAMPLE: &str = include_str!("../../../../examples/pick-and-place.csv");
const EXAMPLE_NAME: &str = "examples/pick-and-place.csv";

/// Checks everything, runs the motion, prints the summary.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, SimError> {
    let (table, columns) = read(arguments)?;
    let axes = columns.positions.len();
    let setup = arguments.setup(axes)?;
    let plan = plan(arguments, &table, &columns, &setup)?;
    let candump = arguments.candump.as_deref().map(create).transpose()?;
    if !columns.velocities.is_empty() && !arguments.json {
        let first = columns.velocities[0] + 1;
        let last = first + columns.velocities.len() - 1;
        eprintln!(
            "note: columns {first} to {last} are the velocities of the others and are not driven"
        );
    }
    let summary = Bench::new(setup, candump)?.run(&plan, !arguments.json)?;
    print(arguments, &summary)?;
    Ok(if summary.promises_kept() {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
}

fn read(arguments: &Arguments) -> Result<(Table, Columns), SimError> {
    let text = match &arguments.trajectory {
        Some(path) => std::fs::read_to_string(path).map_err(|source| SimError::Read {
            path: path.clone(),
            source,
        })?,
        None => EXAMPLE.to_owned(),
    };
    let in_file = |source| SimError::Trajectory {
        path: file_name(arguments),
        source,
    };
    let table = Table::parse(&text).map_err(in_file)?;
    let columns = Columns::choose(&arguments.column_choice(), &table).map_err(in_file)?;
    Ok((table, columns))
}

fn plan(
    arguments: &Arguments,
    table: &Table,
    columns: &Columns,
    setup: &Setup,
) -> Result<Plan, SimError> {
    let in_file = |source| SimError::Trajectory {
        path: file_name(arguments),
        source,
    };
    let scales = arguments.scales(columns.positions.len()).map_err(in_file)?;
    let limits = vec![setup.max_step; columns.positions.len()];
    Plan::new(
        table,
        columns,
        &scales,
        arguments.time_unit.seconds(),
        arguments.interpolation,
        setup.cycle_us,
        &limits,
    )
    .map_err(in_file)
}

fn file_name(arguments: &Arguments) -> String {
    arguments.trajectory.as_ref().map_or_else(
        || EXAMPLE_NAME.to_owned(),
        |path| path.display().to_string(),
    )
}

fn create(path: &std::path::Path) -> Result<BufWriter<File>, SimError> {
    File::create(path)
        .map(BufWriter::new)
        .map_err(|source| SimError::Write {
            path: path.to_owned(),
            source,
        })
}

fn print(arguments: &Arguments, summary: &Summary) -> Result<(), SimError> {
    if arguments.json {
        println!(
            "{}",
            serde_json::to_string_pretty(summary).map_err(SimError::Json)?
        );
    } else {
        println!("{summary}");
    }
    Ok(())
}
