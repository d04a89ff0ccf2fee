//! `motionctl tune`: how an axis answers to steps, for several sets of gains.

mod arguments;
mod error;
mod figures;
mod gains;
mod measure;
mod outcome;
mod picture;
mod wave;

use std::process::ExitCode;

use dyn_can::{PdStep, Request, ServoSwitch};

use crate::backup::{create_file, require_room};
use crate::confirm::confirm;
use crate::drives::{CanDrives, Drives as _, DrivesError, Frames, Parameter, Step, When, WriteEnd};
use crate::dry_run;
use crate::exit;
use crate::interrupt;
use crate::output::{print, print_json, tell};
pub(crate) use arguments::{Arguments, MOST_SETS, amplitude};
use error::TuneError;
pub(crate) use figures::Figures;
use gains::Gains;
use measure::measure;
pub(crate) use measure::{Measured, Sample};
use outcome::{Outcome, Set};
pub(crate) use picture::{Panel, draw};
pub(crate) use wave::WaveOption;

/// Asks, measures each set of gains, brings the old gains back.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, TuneError> {
    arguments.check()?;
    if arguments.dry_run {
        dry_run::show(frames(arguments)?, arguments.json).map_err(TuneError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(path) = &arguments.svg {
        require_room(path, arguments.force).map_err(TuneError::Write)?;
    }
    let link = arguments.link.open().map_err(DrivesError::Open)?;
    let drive = arguments.drive;
    let mut drives = CanDrives::new(link, arguments.axes);
    let readings = drives.read(drive.into())?;
    if readings.state.enabled != Some(false) {
        return Err(DrivesError::Enabled {
            drive: drive.into(),
        }
        .into());
    }
    let old = Gains::of(&readings).ok_or(DrivesError::Incomplete {
        drive: drive.into(),
    })?;
    let sets = if arguments.gains.is_empty() {
        vec![old]
    } else {
        arguments.gains.clone()
    };
    confirm(&arguments.question(&sets), arguments.yes).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(DrivesError::Interrupt)?;
    let turn = readings.value(Parameter::GearNumber).unwrap_or(0);
    let mut outcome = Outcome::new(drive, old, wave::told_counts(arguments.amplitude, turn));
    let measured = measure_all(arguments, &mut drives, &sets, &mut outcome);
    // Whatever has happened.
    restore(arguments, &mut drives, old, &mut outcome)?;
    let status = match measured {
        Ok(()) => ExitCode::SUCCESS,
        Err(TuneError::Drives(DrivesError::Interrupted)) => exit::INTERRUPTED.into(),
        Err(error) => return Err(error),
    };
    if let (Some(path), false) = (&arguments.svg, outcome.sets.is_empty()) {
        let panels: Vec<Panel<'_>> = outcome
            .sets
            .iter()
            .map(|set| Panel {
                caption: set.gains.to_string(),
                samples: &set.samples,
                has_set_points: arguments.wave.shape().is_none(),
            })
            .collect();
        let text = draw(&panels, "counts").map_err(TuneError::Draw)?;
        create_file(path, &text, arguments.force).map_err(TuneError::Write)?;
    }
    if arguments.json {
        print_json(&outcome).map_err(TuneError::Print)?;
    } else {
        print(&outcome).map_err(TuneError::Print)?;
    }
    Ok(status)
}

fn measure_all(
    arguments: &Arguments,
    drives: &mut CanDrives,
    sets: &[Gains],
    outcome: &mut Outcome,
) -> Result<(), TuneError> {
    for &gains in sets {
        let mut writes = 0;
        let written = drives.write(arguments.drive.into(), &gains.settings(), &mut |_, end| {
            writes += u32::from(end == WriteEnd::Written);
        });
        outcome.eeprom_writes += writes;
        written?;
        if !arguments.json {
            tell(format_args!(
                "{gains}: the motor moves; Ctrl-C stops it and brings the old gains back"
            ));
        }
        let Measured {
            samples,
            is_complete,
        } = match arguments.wave.shape() {
            None => measure(drives.link(), arguments)?,
            Some(shape) => wave::measure(drives.link(), arguments, shape)?,
        };
        if !is_complete {
            return Err(DrivesError::Interrupted.into());
        }
        outcome
            .sets
            .push(Set::new(gains, samples, outcome.told_counts, arguments));
    }
    Ok(())
}

/// Writes the gains that the drive had, and says so where that was needed or did not succeed.
fn restore(
    arguments: &Arguments,
    drives: &mut CanDrives,
    old: Gains,
    outcome: &mut Outcome,
) -> Result<(), TuneError> {
    let mut writes = 0;
    let written = drives.write_back(arguments.drive, &old.settings(), &mut |_, end| {
        writes += u32::from(end == WriteEnd::Written);
    });
    outcome.eeprom_writes += writes;
    written.map_err(|source| TuneError::NotRestored {
        drive: arguments.drive,
        old,
        source,
    })?;
    outcome.restored = true;
    if writes > 0 && !arguments.json {
        tell(format_args!(
            "drive {} has its old gains again: {old}",
            arguments.drive
        ));
    }
    Ok(())
}

fn frames(arguments: &Arguments) -> Result<Vec<Step>, TuneError> {
    let drive = arguments.drive;
    let mut steps = Frames::Can.reads(drive.into());
    for gains in &arguments.gains {
        for setting in gains.settings() {
            steps.push(Frames::Can.write(drive.into(), setting)?);
        }
    }
    let mut moves = vec![Request::ServoDisable(ServoSwitch::Enable)];
    match arguments.wave.shape() {
        None => moves.push(Request::GoRelativePosPd(
            PdStep::new(1).unwrap_or(PdStep::ZERO),
        )),
        Some(shape) => moves.extend(wave::requests(arguments, shape)),
    }
    moves.push(Request::ServoDisable(ServoSwitch::Disable));
    let moves = moves.into_iter();
    steps.extend(moves.filter_map(|request| Frames::on_can(When::Always, drive, request)));
    Ok(steps)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<outcome::Outcome>()
}
