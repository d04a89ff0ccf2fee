//! `motionctl bench --drives zlac`: simulated hub motors behind a CAN adapter, in real time.

mod arguments;
mod report;
mod rig;

use std::process::ExitCode;

use crate::bench::BenchError;
use crate::counted::counted;
use crate::interrupt;
use crate::output::{print, print_json, tell};
pub(super) use arguments::Arguments;
use rig::Rig;

/// Offers the drives until the user asks to stop, then shows what each has received.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BenchError> {
    interrupt::listen().map_err(BenchError::Interrupt)?;
    let mut rig = Rig::new(arguments)?;
    tell(format_args!(
        "{} at {} kbit/s on {}; Ctrl-C ends",
        counted(rig.drives(), "virtual hub motor", "virtual hub motors"),
        arguments.bit_rate.kbit_per_s(),
        rig.port(),
    ));
    rig.serve()?;
    let report = rig.report();
    if arguments.json {
        print_json(&report).map_err(BenchError::Print)?;
    } else {
        print(&report).map_err(BenchError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<report::Report>()
}
