//! `motionctl home`: finds where an axis is, and keeps it.

mod arguments;
mod error;
mod options;
mod outcome;
mod plan;
mod scale;
mod search;
mod store;
mod switch_lines;

use std::process::ExitCode;

use dyn_can::{PdStep, Request, ServoSwitch};

use crate::confirm::confirm;
use crate::drives::{DrivesError, Frames, Step, When};
use crate::dry_run;
use crate::exit;
use crate::interrupt;
use crate::origins::Origins;
use crate::output::{print, print_json, tell};
use crate::station::look;
pub(crate) use arguments::Arguments;
pub(crate) use error::HomeError;
pub(crate) use options::{Family, SearchOptions, Turning};
pub(crate) use outcome::{Kept, Outcome, Whose};
use plan::Plan;
pub(crate) use scale::Scale;
use search::{Ended, search};
pub(crate) use switch_lines::SwitchLines;

/// Checks, asks, searches, and keeps what was found.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, HomeError> {
    arguments.search.check(&plan::SERVO)?;
    if arguments.dry_run {
        dry_run::show(frames(arguments), arguments.json).map_err(HomeError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut origins = match &arguments.origins {
        Some(path) => Some(Origins::read_or_begin(path).map_err(HomeError::Origins)?),
        None => None,
    };
    let mut link = arguments.link.open().map_err(DrivesError::Open)?;
    let drive = arguments.drive;
    let seen = look(&mut link, arguments.axes, &[drive]).map_err(DrivesError::Look)?;
    let seen = seen.first().ok_or(DrivesError::Incomplete {
        drive: drive.into(),
    })?;
    if let Some(expected) = arguments.gear_number.filter(|gear| *gear != seen.gear) {
        return Err(DrivesError::Gear {
            drive,
            expected,
            actual: seen.gear,
        }
        .into());
    }
    let plan = Plan::new(arguments, &link, seen)?;
    let lines = match &arguments.search.switch_input {
        Some(path) => Some(SwitchLines::open(path).map_err(HomeError::SwitchLines)?),
        None => None,
    };
    confirm(&arguments.question(), arguments.yes).map_err(DrivesError::NotConfirmed)?;
    if let Some(origins) = &mut origins {
        // Whatever happens from here on, the old origin is not used.
        origins.forget(drive).map_err(HomeError::Origins)?;
    }
    interrupt::listen_in_motion().map_err(DrivesError::Interrupt)?;
    if !arguments.json && arguments.search.moves() {
        tell(format_args!(
            "drive {drive} is being enabled and searches; Ctrl-C stops it"
        ));
    }
    let ended = search(&mut link, arguments, &plan, lines.as_ref())?;
    let whose = Whose::Drive(drive.get());
    let (search_options, origins_path) = (&arguments.search, arguments.origins.as_deref());
    let outcome = match ended {
        Ended::Found(home, enabled) => {
            let kept = store::keep(arguments, link, &plan, home, enabled, origins)?;
            Outcome::found(whose, search_options, origins_path, &home, &kept)
        }
        Ended::Failed(abort, enabled) => {
            Outcome::failed(whose, search_options, abort.to_string(), enabled)
        }
        Ended::Interrupted(enabled) => Outcome::failed(
            whose,
            search_options,
            "stopped by the user".to_owned(),
            enabled,
        ),
    };
    if arguments.json {
        print_json(&outcome).map_err(HomeError::Print)?;
    } else {
        print(&outcome).map_err(HomeError::Print)?;
    }
    Ok(match ended {
        Ended::Found(..) => ExitCode::SUCCESS,
        Ended::Failed(..) => exit::BROKEN_PROMISE.into(),
        Ended::Interrupted(_) => exit::INTERRUPTED.into(),
    })
}

/// What would go out; how often, and where to, depends on what the drive tells.
fn frames(arguments: &Arguments) -> Vec<Step> {
    let drive = arguments.drive;
    // A count in the direction of the search.
    let first = PdStep::new(arguments.search.sign()).unwrap_or(PdStep::ZERO);
    let mut steps = Frames::Can.reads(drive.into());
    let mut add = |when, request| steps.extend(Frames::on_can(when, drive, request));
    if arguments.search.moves() {
        add(When::Always, Request::ServoDisable(ServoSwitch::Enable));
        add(When::Always, Request::GoRelativePosPd(first));
        add(When::Always, Request::ServoDisable(ServoSwitch::Disable));
    }
    if arguments.origins.is_some() {
        add(When::ReadBack, Request::DiagnosticCounter);
    }
    if arguments.in_drive {
        steps.extend(Frames::Can.set_origin(drive.into()));
    }
    steps
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Outcome>()
}
