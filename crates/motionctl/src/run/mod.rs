//! `motionctl run`: a motion on the drives of a real bus, in real time: from a file, or from set-points that arrive meanwhile.

mod arguments;
mod buses;
mod error;
mod file;
mod follow;
mod places;
mod recording;
mod streamed;
mod summary;
mod together;

use std::process::ExitCode;

use can_motion::AxisConfig;
use dyn_can::{DriveId, GearNumber};

use crate::confirm::confirm;
use crate::control::{ControlSocket, Listening, Wishes};
use crate::drive_ids::about;
use crate::endpoint::Endpoint;
use crate::interrupt;
use crate::link::Link;
use crate::output::tell;
use crate::recording::AxisAbout;
use crate::station::{Needs, Seen, Station, look};
pub(crate) use arguments::Arguments;
use error::{GearDifference, RunError};
pub(crate) use follow::progress_bar;

/// One axis of the motion, in the order of the columns.
#[derive(Debug, Clone)]
struct Axis {
    drive: DriveId,
    gear: GearNumber,
    needs: Needs,
    /// The first position of the file, in command counts.
    first_counts: f64,
    about: AxisAbout,
}

/// Checks everything, asks, runs the motion, prints the summary.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, RunError> {
    match &arguments.stream.stream {
        Some(endpoint) => streamed::run(arguments, endpoint),
        None => file::run(arguments),
    }
}

/// The axes as the master wants them: with their limits around these positions, in ascending order of drive id.
fn configs(
    arguments: &Arguments,
    axes: &[Axis],
    position: impl Fn(DriveId) -> i32,
) -> Vec<AxisConfig> {
    let config = |axis: &Axis| {
        let limits = arguments.limits.of_axis(
            &axis.needs,
            position(axis.drive),
            axis.gear,
            arguments.cycle_us,
        );
        arguments
            .axes
            .axis(axis.drive, axis.gear, limits, arguments.polls())
    };
    let mut configs: Vec<AxisConfig> = axes.iter().map(config).collect();
    configs.sort_unstable_by_key(|config| config.drive);
    configs
}

/// Refuses what the bus cannot carry, before anything is asked or sent.
fn admit(arguments: &Arguments, link: &mut Link, axes: &[Axis]) -> Result<(), RunError> {
    let configs = configs(arguments, axes, |_| 0);
    Station::new(link, &configs, arguments.cycle_us)
        .map(drop)
        .map_err(RunError::Config)
}

/// Asks whether the motors may move, and listens to signals from then on.
fn ask(arguments: &Arguments, drives: &[DriveId], what: &str) -> Result<(), RunError> {
    let question = format!(
        "{} {what}, {}. Is everybody clear of the machine?",
        about(
            drives,
            "will be enabled and its motor will MOVE",
            "will be enabled and their motors will MOVE"
        ),
        arguments.limits
    );
    confirm(&question, arguments.yes).map_err(RunError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(RunError::Interrupt)?;
    if !arguments.json {
        tell(format_args!("limits: {}", arguments.limits));
        if arguments.polls().status_us.is_none() {
            tell(
                "note: with --status-hz 0 nobody notices a drive that leaves the bus or loses its power",
            );
        }
    }
    Ok(())
}

/// Opens the socket of those who give orders; obeyed is nobody yet.
fn open_control(arguments: &Arguments, wishes: &Wishes) -> Result<Option<ControlSocket>, RunError> {
    let socket = arguments.control.open(wishes).map_err(RunError::Endpoint)?;
    if let Some(port) = socket.as_ref().and_then(ControlSocket::port) {
        tell(format_args!("orders are taken at port {port}"));
    }
    Ok(socket)
}

/// Takes the keys of the terminal, where neither set-points come from there nor a view has it.
fn listen(
    arguments: &Arguments,
    socket: Option<ControlSocket>,
    wishes: &Wishes,
) -> Result<Listening, RunError> {
    let takes_input = arguments.stream.stream == Some(Endpoint::StandardInput);
    let takes_keys = !takes_input && !arguments.live;
    let listening = Listening::new(socket, wishes, takes_keys).map_err(RunError::Interrupt)?;
    if !arguments.json
        && let Some(help) = listening.help()
    {
        tell(help);
    }
    Ok(listening)
}

/// Asks the drives what they are and where they stand, and refuses a scale that is not theirs.
fn look_at(arguments: &Arguments, link: &mut Link, axes: &[Axis]) -> Result<Vec<Seen>, RunError> {
    let mut ascending: Vec<DriveId> = axes.iter().map(|axis| axis.drive).collect();
    ascending.sort_unstable();
    let seen = look(link, arguments.axes, &ascending).map_err(RunError::Look)?;
    let of = |drive: DriveId| seen.iter().find(|seen| seen.drive == drive);
    let differences: Vec<GearDifference> = axes
        .iter()
        .filter_map(|axis| {
            Some(GearDifference {
                drive: axis.drive,
                expected: axis.gear,
                actual: of(axis.drive)?.gear,
            })
        })
        .collect();
    if differences.iter().any(GearDifference::is_one) {
        return Err(RunError::Gear(differences));
    }
    if let Some(path) = &arguments.origins {
        places::check(arguments, link, axes, path)?;
    }
    Ok(seen)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    buses::schema()
}
