//! Options of `motionctl home`.

use std::path::PathBuf;

use dyn_can::{DriveId, GearNumber};

use super::options::{SearchOptions, Turning};
use crate::drive_ids::drive_id;
use crate::link::LinkOptions;
use crate::station::AxisOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl home --slcan /dev/ttyACM0 --drive 3 --method stop --direction negative --max-turns 4 --travel 0:3.5 --origins machine.toml
  motionctl home --can can0 --drive 3 --method here --travel -1:1 --origins machine.toml
  motionctl home --slcan /dev/ttyACM0 --drive 3 --method switch --direction positive --switch-input /dev/ttyUSB1

stop: slowly against a hard stop, until torque and following error both say that the axis is in contact; back, once more at --slow-rpm, back.
switch: until the switch is operated, back, slowly to its edge, back. An adapter has no inputs: a program writes the level of the switch to
--switch-input, 1 or 0 on a line of its own, at each change and at least five times a second.
here: nothing moves and nothing is enabled; the axis stands at its reference.
The reference is at --reference of the axis, which may be within --travel from then on. The origin is kept in --origins, for `jog` and `run`,
until the drive loses its power. Over CAN only: the serial protocol cannot stream.

Exit status: 0 found, and kept where --origins says; 1 not found, or the drive did not confirm that it is disabled; 2 not confirmed, or
options that cannot work, and nothing has moved; 3 the link failed; 130 stopped by Ctrl-C.";

/// Options of `motionctl home`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) link: LinkOptions,
    #[command(flatten)]
    pub(super) axes: AxisOptions,
    /// Id of the drive.
    #[arg(long, value_name = "ID", value_parser = drive_id)]
    pub(super) drive: DriveId,
    #[command(flatten)]
    pub(super) search: SearchOptions,
    /// File of software origins in which the result is kept, in TOML; other drives in it stay.
    #[arg(long, value_name = "FILE.toml", requires = "travel")]
    pub(super) origins: Option<PathBuf>,
    /// Make the place where the axis rests the drive's own zero too, disabled and at standstill: one write of its EEPROM.
    #[arg(long)]
    pub(super) in_drive: bool,
    /// Gear number that the drive must have, 500..=16384. Default: the one that it reports.
    #[arg(long, value_name = "NUMBER", value_parser = gear_number)]
    pub(super) gear_number: Option<GearNumber>,
    /// Move and write without asking.
    #[arg(long)]
    pub(super) yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Print the result as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    pub(super) fn question(&self) -> String {
        let stores = if self.in_drive {
            " It will store where it rests as its own zero, in its EEPROM; in absolute mode its motor MOVES there at each power-on."
        } else {
            ""
        };
        self.search
            .question(&format!("drive {}", self.drive), stores, Turning::Clockwise)
    }
}

fn gear_number(text: &str) -> Result<GearNumber, String> {
    let number = text.parse().map_err(|_| "expected a number".to_owned())?;
    GearNumber::new(number).map_err(|error| error.to_string())
}
