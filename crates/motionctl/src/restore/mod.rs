//! `motionctl restore`: the settings of a file into drives.

mod arguments;
mod check;
mod difference;
mod error;
mod outcome;
mod plan;
mod write;

use std::process::ExitCode;

use crate::confirm::confirm;
use crate::drives::DrivesError;
use crate::dry_run;
use crate::exit;
use crate::interrupt;
use crate::output::{print, print_json, tell};
use crate::side_effect::SideEffect;
pub(crate) use arguments::Arguments;
use difference::Difference;
use error::RestoreError;
use outcome::Outcome;

/// Reads the file, compares, asks, writes what differs.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, RestoreError> {
    let wanted = plan::read(arguments)?;
    if arguments.dry_run {
        let steps = plan::frames(arguments, &wanted)?;
        dry_run::show(steps, arguments.json).map_err(DrivesError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut drives = arguments
        .drives
        .open(arguments.replies.into())
        .map_err(DrivesError::Open)?;
    let differences = check::compare(drives.as_mut(), &wanted, !arguments.compare)?;
    let is_same = differences.iter().all(Difference::is_empty);
    if !is_same {
        show(arguments, &differences)?;
    }
    if is_same || arguments.compare {
        let outcome = Outcome::untouched(&arguments.file, &differences);
        report(arguments, &outcome)?;
        return Ok(if is_same {
            ExitCode::SUCCESS
        } else {
            exit::BROKEN_PROMISE.into()
        });
    }
    confirm_all(arguments, &differences).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen().map_err(DrivesError::Interrupt)?;
    let mut outcome = Outcome::untouched(&arguments.file, &differences);
    let written = write::write(drives.as_mut(), &differences, &mut outcome);
    // Whatever failed, and even when this cannot be printed: the user has to know what is in the drives now.
    let printed = report(arguments, &outcome);
    match written {
        Ok(()) => printed.map(|()| ExitCode::SUCCESS),
        Err(error) => {
            if printed.is_err() {
                tell(&outcome);
            }
            Err(RestoreError::Unfinished {
                error,
                is_started: outcome.has_written(),
            })
        }
    }
}

/// The table of differences, where it does not get in the way of JSON.
fn show(arguments: &Arguments, differences: &[Difference]) -> Result<(), RestoreError> {
    let table = difference::table(differences);
    if arguments.json {
        tell(&table);
    } else {
        print(&table).map_err(DrivesError::Print)?;
    }
    Ok(())
}

fn report(arguments: &Arguments, outcome: &Outcome) -> Result<(), RestoreError> {
    let printed = if arguments.json {
        print_json(outcome)
    } else {
        print(outcome)
    };
    printed.map_err(DrivesError::Print)?;
    Ok(())
}

/// Asks for what does more than its name says, then for everything.
fn confirm_all(
    arguments: &Arguments,
    differences: &[Difference],
) -> Result<(), crate::confirm::NotConfirmed> {
    let changes = || differences.iter().flat_map(|drive| &drive.changes);
    for change in changes() {
        match SideEffect::of(&change.setting) {
            Some(SideEffect::AbsoluteMode) => {
                SideEffect::AbsoluteMode.confirm(arguments.allow_absolute_mode)?;
            }
            Some(effect) => effect.confirm(arguments.allow_brake_output)?,
            None => {}
        }
        if SideEffect::switches_servo_on(&change.setting, change.before) {
            SideEffect::ServoOn.confirm(arguments.allow_servo_on)?;
        }
    }
    let question = format!(
        "The drives will store these values, which outlast a power cycle. EEPROM writes: {}. Write?",
        changes().count()
    );
    confirm(&question, arguments.yes)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<outcome::Outcome>()
}
