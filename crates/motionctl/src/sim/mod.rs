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
pub(crate) use arguments::Arguments;
use bench::Bench;
use error::SimError;
use summary::Summary;

/// Checks everything, runs the motion, prints the summary.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, SimError> {
    let motion = arguments.motion.read().map_err(SimError::Motion)?;
    let setup = arguments.setup(&motion)?;
    let plan = motion
        .plan(setup.cycle_us, setup.max_step)
        .map_err(SimError::Motion)?;
    let candump = arguments.candump.as_deref().map(create).transpose()?;
    if let Some(note) = motion.note().filter(|_| !arguments.json) {
        eprintln!("{note}");
    }
    let summary = Bench::new(setup, candump)?.run(&plan, !arguments.json)?;
    print(arguments, &summary)?;
    Ok(if summary.promises_kept() {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
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
