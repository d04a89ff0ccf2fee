//! Options of `motionctl restore`.

use std::path::PathBuf;

use dyn_can::StoredDriveId;

use crate::drive_ids::stored_ids;
use crate::drives::DrivesOptions;
use crate::station::ReplyOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl restore machine.toml --slcan /dev/ttyACM0
  motionctl restore machine.toml --can can0 --drives 2 --yes --json
  motionctl restore machine.toml --can can0 --compare       which settings differ
  motionctl restore machine.toml --can can0 --dry-run       every frame, nothing is sent

The file is one of `motionctl backup`. Every drive of it, or those of --drives, must answer, be disabled, stand still, have no alarm
and be of the revision that the file has; otherwise nothing is written to any of them. What differs is shown and confirmed, written
one by one and read back; what is the same is not written, because the memory of a drive wears. max-speed and max-acceleration
are stored by the first 10 writes after power-on only.

Absolute mode, on-position range 127, and a configuration that switches the servo on are confirmed on their own.

Exit status: 0 the drives have every value of the file, 1 a drive refuses or has other values and nothing was written, 2 the file
cannot be used or nobody confirmed and nothing was written, 3 the link failed and nothing was written, 4 some values are
written and others are not: the output says which.";

/// Options of `motionctl restore`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// The file with the settings, as `motionctl backup` writes it.
    #[arg(value_name = "FILE.toml")]
    pub(super) file: PathBuf,
    #[command(flatten)]
    pub(super) drives: DrivesOptions,
    #[command(flatten)]
    pub(super) replies: ReplyOptions,
    /// Only these drives of the file: numbers and ranges, as in 1,2,5-7.
    #[arg(long = "drives", value_name = "IDS", value_parser = stored_ids)]
    pub(super) ids: Option<std::vec::Vec<StoredDriveId>>,
    /// Show what differs and write nothing.
    #[arg(long, conflicts_with_all = ["dry_run", "yes"])]
    pub(super) compare: bool,
    /// Write without asking.
    #[arg(long)]
    pub(super) yes: bool,
    /// Allow absolute mode, in which the motor moves by itself at each power-on; --yes does not.
    #[arg(long)]
    pub(super) allow_absolute_mode: bool,
    /// Allow on-position range 127, which makes an output the brake output; --yes does not.
    #[arg(long)]
    pub(super) allow_brake_output: bool,
    /// Allow a configuration that switches on the servo of a drive that is kept free; --yes does not.
    #[arg(long)]
    pub(super) allow_servo_on: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Print what was done as JSON.
    #[arg(long)]
    pub(super) json: bool,
}
