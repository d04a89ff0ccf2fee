//! `motionctl enable --drives zlac`: enables drives at standstill, until Ctrl-C.

use std::process::ExitCode;

use super::bus::Bus;
use super::disable::tell_end;
use super::error::HubError;
use super::look::Look;
use super::nodes::{SomeNodes, named};
use super::station::WheelStation;
use crate::confirm::confirm;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::tell;

const CYCLE_US: u32 = 20_000;
/// Nothing turns; the master wants a limit.
const LIMIT_RPM: f64 = 1.0;
const LIMIT_RPM_PER_S: f64 = 1_000.0;

const EXAMPLES: &str = "\
Examples:
  motionctl enable --drives zlac:4,5 --slcan /dev/ttyACM0
  motionctl enable --drives zlac --can can0 --for 10 --yes

The wheels are held at speed 0 by the velocity loop: they resist being turned and do not go back where they were. Ctrl-C, or the end of
--for, switches their power off: a vehicle on a slope rolls away then. A drive that is enabled already is refused.

Exit status: 0 enabled and disabled again, 1 a drive could not be enabled, had a fault, or did not confirm that its power is off, 2 not
confirmed, or enabled already, 3 the link failed.";

/// Options of `motionctl enable --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    drives: SomeNodes,
    /// Disable after so many seconds; until Ctrl-C without it.
    #[arg(long = "for", value_name = "SECONDS", value_parser = clap::value_parser!(u32).range(1..))]
    seconds: Option<u32>,
    /// Enable without asking.
    #[arg(long)]
    yes: bool,
    /// Print the drives that are disabled at the end as JSON.
    #[arg(long)]
    json: bool,
}

/// Asks, enables, holds, disables.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let nodes = arguments.drives.ascending();
    let mut bus = Bus::open(&arguments.link)?;
    let looks: Vec<Look> = nodes
        .iter()
        .map(|&node| Look::at(&mut bus, node))
        .collect::<Result<_, _>>()?;
    let question = format!(
        "Will be ENABLED and held at speed 0: {}. Is everybody clear of the machine?",
        named(&nodes)
    );
    confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    let wheels: Vec<_> = looks
        .iter()
        .map(|look| look.follows_speeds(LIMIT_RPM, LIMIT_RPM_PER_S, CYCLE_US))
        .collect();
    let mut station = WheelStation::new(bus.link(), &wheels, CYCLE_US)?;
    let held = hold(&mut station, arguments, &named(&nodes));
    let ((), end) = station.end(held)?;
    tell_end(&end.disabled, &end.unconfirmed, arguments.json)?;
    Ok(ExitCode::SUCCESS)
}

fn hold(
    station: &mut WheelStation<'_>,
    arguments: &Arguments,
    names: &str,
) -> Result<(), HubError> {
    match station.bring_up() {
        Ok(()) => {}
        Err(HubError::Interrupted) => return Ok(()),
        Err(error) => return Err(error),
    }
    tell(format_args!("enabled at speed 0: {names}; Ctrl-C ends it"));
    let start = station.now();
    let limit_us = arguments
        .seconds
        .map(|seconds| u64::from(seconds) * 1_000_000);
    while interrupt::requests() == 0
        && limit_us.is_none_or(|limit_us| station.now().us_since(start) < limit_us)
    {
        station.cycle(|_, _| {})?;
        if let Some((node, fault)) = station.first_fault() {
            return Err(HubError::WheelFault { node, fault });
        }
    }
    Ok(())
}
