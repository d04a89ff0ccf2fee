//! `motionctl bench`: simulated drives behind a CAN adapter, in real time.

mod adapter;
mod arguments;
mod error;
mod report;
mod rig;
mod serial;

use std::process::ExitCode;

use crate::interrupt;
pub(crate) use arguments::Arguments;
use error::BenchError;
use rig::Rig;

/// Offers the drives until the user asks to stop, then shows what each has received.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, BenchError> {
    interrupt::listen().map_err(BenchError::Interrupt)?;
    let mut rig = Rig::new(arguments)?;
    eprintln!(
        "{} virtual drives at {} kbit/s on {}; Ctrl-C ends",
        rig.drives(),
        arguments.bit_rate.kbit_per_s(),
        rig.terminals(),
    );
    rig.serve()?;
    let report = rig.report();
    if arguments.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&report).map_err(BenchError::Json)?
        );
    } else {
        println!("{report}");
    }
    Ok(ExitCode::SUCCESS)
}
