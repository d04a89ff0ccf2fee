//! Options of `motionctl sim`.

use core::str::FromStr;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use can_motion::PollPeriods;
use clap::ValueEnum;
use drive_sim::{BitRate, TxOrder};
use dyn_can::{DriveId, StepLimit};

use super::error::SimError;
use super::faults::Script;
use super::setup::{MOST_AXES, Setup};
use crate::drive_ids::drive_ids;
use crate::recording::RecordingOptions;
use crate::trajectory::{MotionFile, MotionOptions};
use crate::twist::TwistOptions;
use crate::virtual_drives::{VirtualDriveOptions, bit_rate};

const EXAMPLES: &str = "\
Examples:
  cargo sim                                     the built-in four-axis pick-and-place
  cargo sim -- --trajectory plan.csv            the columns that the header line names as positions
  cargo sim -- --trajectory plan.csv --time-column 1 --axes 6   a file without names: the next six columns
  cargo sim -- --trajectory plan.csv --columns shoulder,elbow --gear-ratio 50
  cargo sim -- --program examples/programs/circle.ngc --axes 2 --mm-per-turn 5 --axis-rpm 3000   G-code, see docs/paths.md
  cargo sim -- --report out                     and a page with pictures, out/index.html
  cargo sim -- --live                           watch it in the terminal and interfere
  cargo sim -- --faults examples/faults.toml    see what the master does when things go wrong
  cargo sim -- --candump run.log                and the bus traffic as a candump log
  cargo sim -- --mcap run.mcap                  and everything for Foxglove or PlotJuggler
  cargo sim -- --trajectory plan.csv --bus a=1,2 --bus b=1,2     four columns on two buses
  cargo sim -- --drives zlac                    two hub motors of a differential drive on CANopen
  cargo sim -- --drives zlac --twist examples/square-twist.csv --track 0.4 --wheel-radius 0.085

Exit status: 0 every promise kept, 1 a promise broken (a sum differs, a cycle was late, an axis
faulted) or a recording that is not complete, 2 the input cannot be used and nothing was run.";

/// Options of `motionctl sim`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) motion: MotionOptions,
    /// Cycle time in microseconds. Default: 1000, of hub motors 10000.
    #[arg(long, value_name = "US", value_parser = clap::value_parser!(u32).range(250..=1_000_000))]
    cycle_us: Option<u32>,
    /// Bit rate in kbit/s: 10, 20, 50, 125, 250, 500, 800 or 1000. Default: 1000, of hub motors 500.
    #[arg(long, value_name = "KBIT", value_parser = bit_rate)]
    bit_rate: Option<BitRate>,
    /// Hub motors: speeds count 1/N r/min, up to 1000 of them (202Fh:05).
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=10))]
    pub(super) speed_resolution: u16,
    /// Hub motors: time of the drives' own ramps to their largest speed, in milliseconds (6083h, 6084h); 0 is as fast as they can.
    #[arg(long, value_name = "MS", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=32_767))]
    pub(super) ramp_ms: u16,
    #[command(flatten)]
    pub(super) twist: TwistOptions,
    /// Largest step of an axis in one cycle, in command counts.
    #[arg(long, value_name = "COUNTS", default_value_t = 16_384)]
    max_step: i32,
    /// Status polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    status_hz: u32,
    /// Position polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    position_hz: u32,
    #[command(flatten)]
    pub(super) drive_options: VirtualDriveOptions,
    /// Order in which the master's controller sends its mailboxes.
    #[arg(long, value_enum, default_value_t)]
    tx_order: TxOrderOption,
    /// A bus with its drives, once for each: NAME=IDS, as in a=1,2. The first columns are for the drives of the first bus. All start together,
    /// what stops one stops all, and recordings are named after the bus.
    #[arg(long, value_name = "NAME=IDS", conflicts_with_all = ["drives", "faults", "live"])]
    pub(super) bus: Vec<SimulatedBus>,
    #[command(flatten)]
    pub(crate) recording: RecordingOptions,
    /// Play the faults of a script, see docs/fault-scripts.md.
    #[arg(long, value_name = "FILE")]
    faults: Option<PathBuf>,
    /// Show axes, load and events in the terminal while the motion runs in real time; keys stop it, raise alarms and pull
    /// drives off the bus.
    #[arg(long, conflicts_with = "json")]
    pub(crate) live: bool,
    /// Print the summary as JSON, and no progress.
    #[arg(long)]
    pub(crate) json: bool,
}

/// A bus and its drives, in the order of the columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SimulatedBus {
    name: String,
    drives: Vec<DriveId>,
}

impl FromStr for SimulatedBus {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "expected NAME=IDS with a name of letters, digits, - and _, as in a=1,2, got {text}"
            )
        };
        let (name, ids) = text.split_once('=').ok_or_else(expected)?;
        let is_name = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
        if name.is_empty() || !name.chars().all(is_name) {
            return Err(expected());
        }
        Ok(Self {
            name: name.to_owned(),
            drives: drive_ids(ids)?,
        })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum TxOrderOption {
    /// In the order of the requests, as bxCAN with TXFP or FDCAN in FIFO mode.
    #[default]
    Fifo,
    /// The lowest identifier first, as bxCAN out of reset.
    Identifier,
}

impl Arguments {
    /// What to simulate on each bus, in the order of the columns.
    pub(crate) fn setups(&self, motion: &MotionFile<'_>) -> Result<Vec<Setup>, SimError> {
        if self.bus.is_empty() {
            let drives = motion.drives().map_err(SimError::Motion)?;
            return Ok(vec![self.setup_of(String::new(), drives, 0)?]);
        }
        let mut names: Vec<&str> = self.bus.iter().map(|bus| bus.name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            let name = pair[0].to_owned();
            return Err(SimError::SameBus { name });
        }
        let all = self.bus.iter().flat_map(|bus| &bus.drives).copied();
        motion
            .takes_drives(all.collect())
            .map_err(SimError::Motion)?;
        let buses = self.bus.iter().zip(0..);
        let setup = |(bus, number): (&SimulatedBus, u8)| {
            self.setup_of(bus.name.clone(), bus.drives.clone(), number)
        };
        buses.map(setup).collect()
    }

    /// Drives on the bus of this number, which makes their response delays their own.
    fn setup_of(&self, bus: String, drives: Vec<DriveId>, number: u8) -> Result<Setup, SimError> {
        let period_us = |hz: u32| 1_000_000_u32.checked_div(hz);
        if drives.len() > MOST_AXES {
            return Err(SimError::AxisCount {
                most: MOST_AXES,
                actual: drives.len(),
            });
        }
        Ok(Setup {
            bus,
            faults: self.script(&drives)?,
            drives,
            cycle_us: self.servo_cycle_us(),
            bit_rate: self.bit_rate.unwrap_or(BitRate::Kbit1000),
            max_step: self.most_step()?,
            polls: PollPeriods {
                status_us: period_us(self.status_hz),
                position_us: period_us(self.position_hz),
                ..PollPeriods::OFF
            },
            drive_options: self.drive_options.nth(number),
            tx_order: match self.tx_order {
                TxOrderOption::Fifo => TxOrder::Fifo,
                TxOrderOption::Identifier => TxOrder::ByIdentifier,
            },
        })
    }

    pub(super) fn servo_cycle_us(&self) -> u32 {
        self.cycle_us.unwrap_or(1_000)
    }

    pub(super) fn most_step(&self) -> Result<StepLimit, SimError> {
        StepLimit::new(self.max_step).map_err(|source| SimError::Option {
            name: "--max-step",
            source,
        })
    }

    pub(super) fn wheel_cycle_us(&self) -> u32 {
        self.cycle_us.unwrap_or(10_000)
    }

    pub(super) fn wheel_bit_rate(&self) -> BitRate {
        self.bit_rate.unwrap_or(BitRate::Kbit500)
    }

    /// Whether a bar shows how far the motion is.
    pub(super) fn shows_progress(&self) -> bool {
        !self.json && !self.live
    }

    fn script(&self, drives: &[DriveId]) -> Result<Script, SimError> {
        let Some((path, text)) = self.script_text()? else {
            return Ok(Script::default());
        };
        Script::parse(&text, drives).map_err(|source| SimError::Script { path, source })
    }

    /// The fault script, where there is one, and its path.
    pub(super) fn script_text(&self) -> Result<Option<(PathBuf, String)>, SimError> {
        let read = |path: &PathBuf| match read_script(path) {
            Ok(text) => Ok((path.clone(), text)),
            Err(source) => Err(SimError::Read {
                path: path.clone(),
                source,
            }),
        };
        self.faults.as_ref().map(read).transpose()
    }
}

/// Largest fault script: a thousand faults of a thousand bytes.
const MOST_SCRIPT_BYTES: u64 = 1 << 20;

/// The text of a fault script; a file without end is none.
fn read_script(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let mut file = File::open(path)?.take(MOST_SCRIPT_BYTES + 1);
    file.read_to_string(&mut text)?;
    if text.len() as u64 > MOST_SCRIPT_BYTES {
        return Err(io::Error::other(format!(
            "expected a fault script of at most {MOST_SCRIPT_BYTES} bytes, got a longer file"
        )));
    }
    Ok(text)
}
