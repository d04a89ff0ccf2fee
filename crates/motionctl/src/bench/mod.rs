//! `motionctl bench`: simulated drives behind a CAN adapter, in real time.

mod adapter;
mod arguments;
mod board;
mod candump;
mod error;
mod mechanics;
mod report;
mod rig;
mod serial;

use std::process::ExitCode;

use crate::counted::counted;
use crate::interrupt;
use crate::output::{print, print_json, tell};
pub(crate) use adapter::{Adapter, Refusals};
pub(crate) use arguments::Arguments;
pub(crate) use error::BenchError;
pub(crate) use mechanics::{MechanicsOptions, SwitchOutput};
use rig::Rig;
pub(crate) use rig::power_cycles;

/// Offers the drives until the user asks to stop, then shows what each has received.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, BenchError> {
    interrupt::listen().map_err(BenchError::Interrupt)?;
    let mut rig = Rig::new(arguments)?;
    tell(format_args!(
        "{} at {} kbit/s on {}; Ctrl-C ends",
        counted(rig.drives(), "virtual drive", "virtual drives"),
        arguments.bit_rate.kbit_per_s(),
        rig.places(),
    ));
    rig.serve()?;
    let report = rig.report()?;
    if arguments.json {
        print_json(&report).map_err(BenchError::Print)?;
    } else {
        print(&report).map_err(BenchError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<report::Report>()
}
