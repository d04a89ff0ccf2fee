//! `motionctl write`: changes parameters of a drive, after comparing and asking.

use std::process::ExitCode;

use dyn_can::{GearNumber, StoredDriveId};
use schemars::JsonSchema;
use serde::Serialize;

use crate::confirm::confirm;
use crate::drive_ids::stored_id;
use crate::drives::{DrivesError, DrivesOptions, Parameter, Readings, Setting, WriteEnd};
use crate::dry_run;
use crate::output::{self, print_json};
use crate::side_effect::SideEffect;
use crate::station::ReplyOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl write --slcan /dev/ttyACM0 --drive 3 max-speed=40 max-acceleration=20
  motionctl write --can can0 --drive 3 gear-number=4096 --yes --json
  motionctl write --can can0 --drive 3 config=0x00      commands by link, position servo
  motionctl write --serial /dev/ttyUSB0 --drive 3 main-gain=40

The drive must be disabled, except over --serial. It is read first; what it has already is not written, because its memory wears. The rest is
shown, confirmed, written one by one and read back.

Two settings do more than their name says, and are confirmed on their own: absolute mode (bit 2 of config), in which the motor moves to the
stored zero at each power-on, and on-position range 127, which makes an output the brake output at the next power-on.

Exit status: 0 the drive has every value, 1 it does not, 2 not confirmed and nothing was written,
3 the link failed.";

/// Options of `motionctl write`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drives: DrivesOptions,
    #[command(flatten)]
    replies: ReplyOptions,
    /// Id of the drive; over --serial also 0, a drive that was never given one.
    #[arg(long, value_name = "ID", value_parser = stored_id)]
    drive: StoredDriveId,
    /// Parameters and their new values; `motionctl read` shows their names.
    #[arg(value_name = "NAME=VALUE", required = true, value_parser = Setting::parse)]
    settings: Vec<Setting>,
    /// Write without asking.
    #[arg(long)]
    yes: bool,
    /// Allow absolute mode, in which the motor moves by itself at each power-on; --yes does not.
    #[arg(long)]
    allow_absolute_mode: bool,
    /// Allow on-position range 127, which makes an output the brake output; --yes does not.
    #[arg(long)]
    allow_brake_output: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print what was done as JSON.
    #[arg(long)]
    json: bool,
}

/// What became of one setting.
#[derive(Debug, Serialize, JsonSchema)]
struct Change {
    parameter: Parameter,
    before: Option<i32>,
    value: i32,
    result: WriteEnd,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Changes {
    drive: u8,
    changes: Vec<Change>,
}

/// Reads, compares, asks, writes.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let drive = arguments.drive;
    refuse_twice(&arguments.settings)?;
    if arguments.dry_run {
        return show_frames(arguments);
    }
    let mut drives = arguments
        .drives
        .open(arguments.replies.into())
        .map_err(DrivesError::Open)?;
    let before = drives.read(drive)?;
    let (same, different): (Vec<Setting>, Vec<Setting>) = arguments
        .settings
        .iter()
        .partition(|setting| before.value(setting.parameter) == Some(setting.value));
    let mut done: Vec<_> = same
        .iter()
        .map(|&setting| (setting, WriteEnd::Unchanged))
        .collect();
    if !different.is_empty() {
        // Over the serial port a drive cannot be switched off, and the question says that its motor may react.
        if before.state.enabled == Some(true) && !arguments.drives.is_serial() {
            return Err(DrivesError::Enabled { drive });
        }
        confirm_side_effects(arguments, &different)?;
        confirm(&question(drive, &before, &different), arguments.yes)
            .map_err(DrivesError::NotConfirmed)?;
        let written = drives.write(drive, &different, &mut |setting, end| {
            done.push((setting, end))
        });
        // What was written before something failed is told too.
        print(arguments, &before, &done)?;
        written?;
        return Ok(ExitCode::SUCCESS);
    }
    print(arguments, &before, &done)?;
    Ok(ExitCode::SUCCESS)
}

fn show_frames(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let (frames, drive) = (arguments.drives.frames(), arguments.drive);
    let mut steps = frames.reads(drive);
    for &setting in &arguments.settings {
        steps.push(frames.write(drive, setting)?);
    }
    dry_run::show(steps, arguments.json).map_err(DrivesError::Print)?;
    Ok(ExitCode::SUCCESS)
}

fn confirm_side_effects(arguments: &Arguments, settings: &[Setting]) -> Result<(), DrivesError> {
    for effect in settings.iter().filter_map(SideEffect::of) {
        let is_allowed = match effect {
            SideEffect::AbsoluteMode => arguments.allow_absolute_mode,
            SideEffect::BrakeOutput => arguments.allow_brake_output,
            // The question of `write` shows both configurations in words.
            SideEffect::ServoOn => true,
        };
        effect
            .confirm(is_allowed)
            .map_err(DrivesError::NotConfirmed)?;
    }
    Ok(())
}

fn refuse_twice(settings: &[Setting]) -> Result<(), DrivesError> {
    for (place, setting) in settings.iter().enumerate() {
        let parameter = setting.parameter;
        if settings[..place]
            .iter()
            .any(|other| other.parameter == parameter)
        {
            return Err(DrivesError::Twice { parameter });
        }
    }
    Ok(())
}

fn question(drive: StoredDriveId, before: &Readings, settings: &[Setting]) -> String {
    let gear = new_gear(before, settings);
    let mut question =
        format!("Drive {drive} will store these values, which outlast a power cycle:\n");
    for &Setting { parameter, value } in settings {
        let old = before.value(parameter);
        question.push_str(&format!(
            "  {parameter}: {} -> {}\n",
            old.map_or_else(
                || "?".to_owned(),
                |old| parameter.in_units(old, before.gear())
            ),
            parameter.in_units(value, gear)
        ));
    }
    if before.state.enabled == Some(true) {
        question.push_str("The drive is ENABLED: its motor may react at once.\n");
    }
    question.push_str("Write?");
    question
}

/// The gear number that the drive will have.
fn new_gear(before: &Readings, settings: &[Setting]) -> Option<GearNumber> {
    let changed = settings
        .iter()
        .find(|setting| setting.parameter == Parameter::GearNumber);
    changed.map_or(before.gear(), |setting| GearNumber::new(setting.value).ok())
}

fn print(
    arguments: &Arguments,
    before: &Readings,
    done: &[(Setting, WriteEnd)],
) -> Result<(), DrivesError> {
    let change = |&(Setting { parameter, value }, result): &(Setting, WriteEnd)| Change {
        parameter,
        before: before.value(parameter),
        value,
        result,
    };
    let changes = Changes {
        drive: arguments.drive.get(),
        changes: done.iter().map(change).collect(),
    };
    if arguments.json {
        print_json(&changes).map_err(DrivesError::Print)?;
        return Ok(());
    }
    for change in &changes.changes {
        let result = match change.result {
            WriteEnd::Unchanged => "is already",
            WriteEnd::Written => "is now",
        };
        output::print(format_args!(
            "{} {result} {}",
            change.parameter, change.value
        ))
        .map_err(DrivesError::Print)?;
    }
    Ok(())
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Changes>()
}
