//! A motion from set-points that arrive while it runs.

use std::io::{self, IsTerminal as _};
use std::process::ExitCode;

use board_link::AxisLimits;

use super::arguments::Arguments;
use super::error::RunError;
use super::summary::Summary;
use super::{Axis, ask, buses, listen, open_control, recording};
use crate::control::Wishes;
use crate::endpoint::Endpoint;
use crate::output::tell;
use crate::recording::AxisAbout;
use crate::stream::Open;

pub(super) fn run(arguments: &Arguments, endpoint: &Endpoint) -> Result<ExitCode, RunError> {
    let reads_input = *endpoint == Endpoint::StandardInput;
    if arguments.live && reads_input && io::stdin().is_terminal() {
        return Err(RunError::SharedKeyboard);
    }
    let drives = match arguments.link.drives() {
        Some(drives) => drives,
        None => arguments
            .motion
            .drives_of_stream()
            .map_err(RunError::Motion)?,
    };
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
        about: AxisAbout::of_drive(drive),
    };
    let axes: Vec<Axis> = drives.iter().copied().zip(gears).map(axis).collect();
    let jerk = arguments.stream.max_jerk;
    let limits = |axis: &Axis| {
        let limits = &arguments.limits;
        limits.of_stream(axis.gear, arguments.cycle_us, jerk)
    };
    let limits: Result<Vec<AxisLimits>, _> = axes.iter().map(limits).collect();
    let limits = limits.map_err(RunError::Range)?;
    let wishes = Wishes::new();
    let control = open_control(arguments, &wishes)?;
    let open = Open::new(endpoint, arguments.control.allow_remote).map_err(RunError::Endpoint)?;
    let place = open.place();
    let mut buses = buses::open(arguments, axes)?;
    recording::begin(arguments, &mut buses)?;
    buses::admit_all(arguments, &mut buses)?;
    ask(arguments, &drives, &format!("as {place} says"))?;
    let (follows, view) = buses::ready(arguments, &mut buses, &wishes)?;
    // Whoever waits for it may come now; nothing moves before the drives are enabled.
    tell(format_args!("set-points are taken from {place}"));
    let config = arguments.stream.config(arguments.cycle_us);
    let (session, mut source) = open
        .start(&arguments.motion, &limits, config, arguments.cycle_us)
        .map_err(RunError::Interrupt)?;
    let listening = listen(arguments, control, &wishes)?;
    let shows_progress = !arguments.json && view.is_none();
    let results = buses::follow_all(follows, &mut source, &wishes, shows_progress);
    drop(listening);
    let summaries = results.iter().map(|(summary, _)| summary);
    let how = summaries.max_by_key(|summary| summary.ending.severity());
    session.close(how.map_or("", Summary::outcome));
    recording::end_view(view, &results);
    let summaries = recording::close(arguments, &buses, results);
    buses::show(arguments, &summaries, None, Some(&source.report()))
}
