//! Options of `motionctl record`.

use std::path::PathBuf;

use crate::link::PortOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl record --can can0                       files of 100 MB in this folder, the newest 20 of them
  motionctl record --slcan /dev/ttyACM0 --folder /var/log/can --name cell-3 --file-mb 20 --keep 200
  motionctl decode cell-3-20260301T220000Z-0001.log --report out     the motion in one of them, as a page

The files are candump logs; a new one begins when one is full, and the oldest of this recording goes when there are
more than --keep. It sends nothing. When little room is left on the disk it says so, and it ends before the disk is
full. Ctrl-C ends it with whole files.

Exit status: 0 ended by Ctrl-C and every frame is in a file, 1 some frames are missing (they are counted) or the disk is
full, 2 a file cannot be made, 3 the bus cannot be opened, or has failed.";

/// Options of `motionctl record`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Listen to a CAN network interface, on Linux, or to pcan:PCAN_USBBUS1 on Windows.
    #[arg(long, value_name = "INTERFACE", required_unless_present = "slcan")]
    pub(super) can: Option<String>,
    /// Listen to a Lawicel (slcan) adapter; it does not even acknowledge.
    #[arg(long, value_name = "TTY", conflicts_with = "can")]
    pub(super) slcan: Option<String>,
    #[command(flatten)]
    pub(super) port: PortOptions,
    /// Let the adapter acknowledge frames, where it cannot only listen. With a wrong --bit-rate it disturbs the bus.
    #[arg(long, requires = "slcan")]
    pub(super) acknowledge: bool,
    /// Bit rate in kbit/s that a serial adapter is set to.
    #[arg(long, value_name = "KBIT", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    pub(super) bit_rate: u32,
    /// Folder of the files; it is made when it is not there.
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub(super) folder: PathBuf,
    /// First part of the names of the files; the time of the start and a number follow.
    #[arg(long, value_name = "NAME", default_value = "can", value_parser = file_name)]
    pub(super) name: String,
    /// Size of a file in megabytes, after which the next one begins.
    #[arg(long, value_name = "MB", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub(super) file_mb: u64,
    /// Files that are kept; the oldest one of this recording is removed when there are more.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub(super) keep: u64,
    /// Room in megabytes that stays free on the disk: with less the recording ends, with twice as much left it says so.
    #[arg(long, value_name = "MB", default_value_t = 200)]
    pub(super) least_free_mb: u64,
    /// Print the summary as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

/// A name without a folder.
fn file_name(text: &str) -> Result<String, String> {
    let is_fit = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if !text.is_empty() && !text.starts_with('.') && text.chars().all(is_fit) {
        Ok(text.to_owned())
    } else {
        Err("expected letters, digits, - and _".to_owned())
    }
}
