//! A motion from set-points that arrive while it runs.

use std::process::ExitCode;

use board_link::AxisLimits;

use super::arguments::Arguments;
use super::error::RunError;
use super::{Axis, admit, ask, follow, listen, open_control};
use crate::control::Wishes;
use crate::endpoint::Endpoint;
use crate::output::{print, print_json, tell};
use crate::stream::Open;

pub(super) fn run(arguments: &Arguments, endpoint: &Endpoint) -> Result<ExitCode, RunError> {
    let drives = arguments
        .motion
        .drives_of_stream()
        .map_err(RunError::Motion)?;
    let gears = arguments
        .motion
        .gears_of_stream(drives.len())
        .map_err(RunError::Motion)?;
    let axis = |(drive, gear)| Axis {
        drive,
        gear,
        needs: arguments.limits.as_needs(gear, arguments.cycle_us),
        // A stream begins where the axes stand.
        first_counts: 0.0,
    };
    let axes: Vec<Axis> = drives.into_iter().zip(gears).map(axis).collect();
    let limits = |axis: &Axis| arguments.limits.of_stream(axis.gear, arguments.cycle_us);
    let limits: Result<Vec<AxisLimits>, _> = axes.iter().map(limits).collect();
    let limits = limits.map_err(RunError::Range)?;
    let wishes = Wishes::new();
    let control = open_control(arguments, &wishes)?;
    let open = Open::new(endpoint, arguments.control.allow_remote).map_err(RunError::Endpoint)?;
    let place = open.place();
    let mut link = arguments.link.open().map_err(RunError::Open)?;
    admit(arguments, &mut link, &axes)?;
    ask(arguments, &axes, &format!("as {place} says"))?;
    let follow = follow(arguments, &mut link, &axes)?;
    // Whoever waits for it may come now; nothing moves before the drives are enabled.
    tell(format_args!("set-points are taken from {place}"));
    let config = arguments.stream.config(arguments.cycle_us);
    let (session, mut source) = open
        .start(&arguments.motion, &limits, config, arguments.cycle_us)
        .map_err(RunError::Interrupt)?;
    let listening = listen(arguments, control, &wishes)?;
    let mut summary = follow.run(&mut source, &wishes, !arguments.json);
    drop(listening);
    session.close(summary.outcome());
    summary.stream = Some(source.report());
    if arguments.json {
        print_json(&summary).map_err(RunError::Print)?;
    } else {
        print(&summary).map_err(RunError::Print)?;
    }
    Ok(summary.exit_code())
}
