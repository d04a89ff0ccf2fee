//! `motionctl tune --drives zlac`: how a wheel answers to steps, for several sets of gains.

mod arguments;
mod gains;
mod measure;
mod outcome;

use std::process::ExitCode;

use zlac8030l::objects;

use super::bus::Bus;
use super::error::HubError;
use super::for_now::ForNow;
use super::frames;
use super::look::Look;
use crate::backup::{create_file, require_room};
use crate::confirm::confirm;
use crate::drives::{Step as Frame, When};
use crate::dry_run;
use crate::exit;
use crate::interrupt;
use crate::output::{print, print_json, tell};
use crate::tune::draw;
pub(super) use arguments::Arguments;
use gains::Gains;
use measure::{Step, measure};
use outcome::{Outcome, Set};

/// Asks, measures each set of gains, brings the old gains back.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    let control = arguments.control();
    let given = arguments.sets()?;
    if arguments.dry_run {
        dry_run::show(frames(arguments, given)?, arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(path) = &arguments.svg {
        require_room(path, arguments.force).map_err(|error| HubError::File(error.to_string()))?;
    }
    let mut bus = Bus::open(&arguments.link)?;
    let look = Look::at(&mut bus, node)?;
    let step = Step::new(arguments, &mut bus, &look)?;
    let old = Gains::of(&mut bus, node, control)?;
    let sets = if given.is_empty() {
        vec![old.clone()]
    } else {
        given.to_vec()
    };
    confirm(&arguments.question(&sets)?, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    let mut outcome = Outcome::new(node, arguments, &old);
    let mut changed = ForNow::new(&mut bus, node)?;
    let measure_all = || -> Result<(), HubError> {
        for gains in sets {
            changed.set(&mut bus, &gains.settings(control)?)?;
            if !arguments.json {
                tell(format_args!(
                    "{}: the wheel moves; Ctrl-C stops it and brings the old gains back",
                    gains.words(control)
                ));
            }
            let measured = measure(&mut bus, arguments, &look, step)?;
            if !measured.is_complete {
                return Err(HubError::Interrupted);
            }
            let set = Set::new(gains, measured.samples, step.height(), arguments);
            outcome.sets.push(set);
        }
        Ok(())
    };
    let measured = measure_all();
    // Whatever has happened.
    let measured = changed.end(&mut bus, measured);
    let status = match measured {
        Ok(()) => ExitCode::SUCCESS,
        Err(HubError::Interrupted) => exit::INTERRUPTED.into(),
        Err(error) => return Err(error),
    };
    outcome.restored = true;
    show(arguments, &outcome)?;
    Ok(status)
}

fn show(arguments: &Arguments, outcome: &Outcome) -> Result<(), HubError> {
    if let (Some(path), false) = (&arguments.svg, outcome.sets.is_empty()) {
        let text = draw(&outcome.panels(), outcome.axis()).map_err(HubError::Picture)?;
        create_file(path, &text, arguments.force)
            .map_err(|error| HubError::File(error.to_string()))?;
    }
    let printed = if arguments.json {
        print_json(outcome)
    } else {
        print(outcome)
    };
    printed.map_err(HubError::Print)?;
    Ok(())
}

/// What the tool itself would send; the master sets the drive up, moves it by PDO and switches it off.
fn frames(arguments: &Arguments, sets: &[Gains]) -> Result<Vec<Frame>, HubError> {
    let node = arguments.node.get()?;
    let control = arguments.control();
    let rows = control.rows().map(|row| row.read());
    let reads = [objects::DEVICE_TYPE.read(), objects::STATUS_WORD.read()];
    let mut steps: Vec<Frame> = reads
        .into_iter()
        .chain(rows)
        .map(|read| frames::transfer(When::Before, node, read))
        .collect();
    let off = objects::EEPROM_UPDATE.write(objects::EEPROM_UPDATE_OFF);
    steps.push(frames::transfer(When::Always, node, off));
    for gains in sets {
        for setting in gains.settings(control)? {
            let write = super::store::request(&setting)?;
            steps.push(frames::transfer(When::IfDifferent, node, write));
            let read = setting.entry.read();
            steps.push(frames::transfer(When::ReadBack, node, read));
        }
    }
    Ok(steps)
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<outcome::Outcome>()
}
