//! Options of `motionctl bench`.

use std::path::PathBuf;

use drive_sim::BitRate;
use dyn_can::DriveId;

use super::board::BoardOptions;
use super::mechanics::MechanicsOptions;
use crate::drive_ids::drive_ids;
use crate::host_port::Place;
use crate::virtual_drives::{VirtualDriveOptions, bit_rate};

const EXAMPLES: &str = "\
Examples:
  motionctl bench --drives 1,2,3 --slcan /tmp/can-adapter
  motionctl bench --drives 1,2 --slcan /tmp/can-adapter --serial /tmp/drive-port
  motionctl bench --fresh --slcan /tmp/can-adapter                  one drive as it comes out of its box
  motionctl run --slcan /tmp/can-adapter --drives 1,2 --axes 2     in another terminal
  slcand -o -s8 /tmp/can-adapter can0                              as a network interface, on Linux
  motionctl bench --drives 1,2 --slcan tcp:7000                    on any system, for programs of this machine
  motionctl run --slcan tcp:7000 --drives 1,2 --axes 2             in another terminal; python-can opens socket://127.0.0.1:7000
  motionctl bench --drives 1,2 --board /tmp/board --settings board.toml    drives behind a motion board
  motionctl board info --port /tmp/board                    in another terminal

The adapter speaks the Lawicel protocol (S0..S8, O, L, C, t, T, r, R, F, V, N, Z) and drives a virtual
bus with exact bit timing, in real time. The serial port is that of the same drives: 38400 baud, DYN232M.
The motion board speaks the protocol of the real one, docs/board.md; its cycles are on time, in the time of the bus.
Ctrl-C ends it and shows what each drive has received. SIGUSR1 switches the power of the drives and of the board off and on,
where the system has it. A TCP port takes one program at a time.

Exit status: 0 ended on request, 1 the log is not complete, 2 the bench could not be set up, 3 the terminal failed.";

/// Options of `motionctl bench`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Ids of the drives on the bus, in any order: numbers and ranges, as in 1,2,5-7. Default: 1, and none with --fresh.
    #[arg(long, value_name = "IDS", value_parser = drive_ids)]
    pub(crate) drives: Option<std::vec::Vec<DriveId>>,
    /// One more drive, or N more, which were never given an id: on their serial port they are drive 0.
    #[arg(
        long,
        value_name = "N",
        num_args = 0..=1,
        default_value_t = 0,
        default_missing_value = "1"
    )]
    pub(crate) fresh: u8,
    #[command(flatten)]
    pub(crate) troubles: Troubles,
    #[command(flatten)]
    pub(super) mechanics: MechanicsOptions,
    #[command(flatten)]
    pub(crate) terminals: Terminals,
    #[command(flatten)]
    pub(super) board: BoardOptions,
    /// Write the bus traffic as a candump log; the time is the end of each frame.
    #[arg(long, value_name = "FILE")]
    pub(super) candump: Option<PathBuf>,
    /// Bit rate of the bus in kbit/s: 10, 20, 50, 125, 250, 500, 800 or 1000.
    #[arg(long, value_name = "KBIT", default_value = "1000", value_parser = bit_rate)]
    pub(crate) bit_rate: BitRate,
    #[command(flatten)]
    pub(crate) drive_options: VirtualDriveOptions,
    /// Print what the drives have received as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

impl Arguments {
    /// The ids of the drives that have one.
    pub(super) fn ids(&self) -> std::vec::Vec<DriveId> {
        match &self.drives {
            Some(ids) => ids.clone(),
            None if self.fresh > 0 => std::vec::Vec::new(),
            None => vec![DriveId::MIN],
        }
    }
}

/// What is wrong with the drives.
#[derive(Debug, clap::Args)]
pub(crate) struct Troubles {
    /// One more drive with each of these ids.
    #[arg(long, value_name = "IDS", value_parser = drive_ids)]
    pub(crate) twin: Option<std::vec::Vec<DriveId>>,
    /// Drives that are in alarm from the start: over-current.
    #[arg(long, value_name = "IDS", value_parser = drive_ids)]
    pub(crate) alarm: Option<std::vec::Vec<DriveId>>,
    /// Each drive obeys N commands that store something and ignores those behind them, without a word.
    #[arg(long, value_name = "N")]
    pub(crate) ignore_settings_after: Option<u64>,
}

/// What the drives are behind, one at least.
#[derive(Debug, clap::Args)]
#[group(multiple = true)]
pub(crate) struct Terminals {
    /// Where programs find the CAN adapter (slcan): a link that does not exist yet, or tcp:PORT of this machine; port 0 takes one that is free.
    #[arg(long, value_name = "PATH|tcp:PORT", required_unless_present_any = ["serial", "board"])]
    pub(crate) slcan: Option<Place>,
    /// Where programs find the drives' serial line: likewise.
    #[arg(long, value_name = "PATH|tcp:PORT")]
    pub(crate) serial: Option<Place>,
}
