//! `motionctl scan --drives zlac`: which nodes are there.

use std::process::ExitCode;

use crate::drives::DrivesError;
use crate::scan;

use super::nodes::SomeNodes;
use crate::link::LinkOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl scan --drives zlac --slcan /dev/ttyACM0
  motionctl scan --drives zlac --can can0 --yes --json

Every node from 1 to 127 is asked for its device type 1000h and its software version. This changes nothing and moves nothing.
Never on a bus with DYN drives: the same identifiers are moves there. It asks first, scripts answer with --yes. Hub motors leave the
factory with 500 kbit/s, which is what it uses unless --bit-rate is given.

Exit status: 0 at least one node answered, 1 none did, 2 not confirmed, 3 the link failed.";

/// Options of `motionctl scan --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    drives: SomeNodes,
    /// Do not ask whether the bus is one of CANopen drives only.
    #[arg(long)]
    yes: bool,
    /// Print the nodes as JSON, and no progress.
    #[arg(long)]
    json: bool,
}

/// Asks every node and prints what answered.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let _ = &arguments.drives;
    scan::run_canopen(&arguments.link, arguments.yes, arguments.json)
}
