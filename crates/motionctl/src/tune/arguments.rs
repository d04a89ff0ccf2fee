//! Options of `motionctl tune`.

use std::path::PathBuf;

use dyn_can::DriveId;

use super::gains::Gains;
use super::wave::WaveOption;
use crate::counted::counted;
use crate::drive_ids::drive_id;
use crate::link::LinkOptions;
use crate::station::AxisOptions;

/// Sets of gains that are compared.
pub(crate) const MOST_SETS: usize = 3;

/// Periods of a wave of the drive, whose place in it nobody knows: two go through the middle at least.
const LEAST_PERIODS: u32 = 3;

const EXAMPLES: &str = "\
Examples:
  motionctl tune --slcan /dev/ttyACM0 --drive 3                                        the gains that the drive has
  motionctl tune --slcan /dev/ttyACM0 --drive 3 --gains 20,20,10 --gains 30,30,10 --gains 40,45,10 --svg answer.svg
  motionctl tune --can can0 --drive 3 --periods 8 --hold-ms 250 --json                 a square wave
  motionctl tune --can can0 --drive 3 --wave drive-square --frequency 4 --periods 8    the square wave of the drive

The axis is told a step of --amplitude and, --hold-ms later, the way back; more --periods make a square wave. Its position is read as
often as the bus allows, and stamped when it comes in, so that times are as good as this computer and its adapter keep them. With --wave
drive-square or drive-sine the drive makes the wave (functions 0Bh to 0Dh), to --amplitude at either side; where it is in its wave no
message tells, so the figures come from the positions alone. The gains of each set are written with read-back; afterwards the drive gets
those back that it had, also after Ctrl-C or a fault. Gains live in an EEPROM of 1,000,000 writes: the command counts them. Over CAN only.

Exit status: 0 measured and the old gains are back; 1 a fault, or the old gains are not back; 2 not confirmed or the drive is enabled, and nothing was
done; 3 the link failed; 130 stopped by Ctrl-C, and the old gains are back.";

/// Options of `motionctl tune`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) link: LinkOptions,
    #[command(flatten)]
    pub(super) axes: AxisOptions,
    /// Id of the drive, which must be disabled.
    #[arg(long, value_name = "ID", value_parser = drive_id)]
    pub(super) drive: DriveId,
    /// Gains to measure, up to three times: main, speed and integration gain. Default: those that the drive has.
    #[arg(long, value_name = "M,S,I", value_parser = Gains::parse)]
    pub(super) gains: Vec<Gains>,
    /// Height of the step in motor turns, at most 0.25 either way.
    #[arg(long, value_name = "TURNS", default_value = "0.02", allow_hyphen_values = true, value_parser = amplitude)]
    pub(super) amplitude: f64,
    /// Time for which each position is held, in milliseconds.
    #[arg(long, value_name = "MS", default_value_t = 500, value_parser = clap::value_parser!(u32).range(50..=10_000))]
    pub(super) hold_ms: u32,
    /// Steps there and back: 1 is a step, more are a square wave [default: 1, and 5 for a wave of the drive].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=50))]
    periods: Option<u32>,
    /// Who makes the wave: this computer steps the set-points, or the drive makes its own square wave or sine around where it stands.
    #[arg(long, value_enum, default_value = "step")]
    pub(super) wave: WaveOption,
    /// Frequency of a wave of the drive in Hz; --periods of it are measured, and --hold-ms has no meaning then.
    #[arg(long, value_name = "HZ", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=50))]
    pub(super) frequency: u8,
    /// Picture of the answers, side by side: a file that does not exist yet.
    #[arg(long, value_name = "FILE.svg")]
    pub(super) svg: Option<PathBuf>,
    /// Replace a picture that exists.
    #[arg(long, requires = "svg")]
    pub(super) force: bool,
    /// Write and move without asking.
    #[arg(long)]
    pub(super) yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Print the figures as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    pub(super) fn periods(&self) -> u32 {
        let usual = match self.wave {
            WaveOption::Step => 1,
            WaveOption::DriveSquare | WaveOption::DriveSine => 5,
        };
        self.periods.unwrap_or(usual)
    }

    pub(super) fn question(&self, sets: &[Gains]) -> String {
        let drive = self.drive;
        let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
        let times = counted(self.periods(), "time", "times");
        let how = match self.wave {
            WaveOption::Step => format!("JUMP by {} turns and back, {times}", self.amplitude),
            WaveOption::DriveSquare => format!(
                "JUMP by {} turns to either side, {times} at {} Hz",
                self.amplitude.abs(),
                self.frequency
            ),
            WaveOption::DriveSine => format!(
                "SWING by {} turns to either side, {times} at {} Hz",
                self.amplitude.abs(),
                self.frequency
            ),
        };
        format!(
            "Drive {drive} will get these gains one after the other, in its EEPROM: {}. With each its motor will {how}. Is everybody clear of the machine?",
            sets.join("; ")
        )
    }

    /// Refuses what clap cannot.
    pub(super) fn check(&self) -> Result<(), super::error::TuneError> {
        if self.gains.len() > MOST_SETS {
            return Err(super::error::TuneError::TooManySets {
                most: MOST_SETS,
                actual: self.gains.len(),
            });
        }
        if self.wave != WaveOption::Step && self.periods() < LEAST_PERIODS {
            return Err(super::error::TuneError::TooFewPeriods {
                least: LEAST_PERIODS,
                actual: self.periods(),
            });
        }
        Ok(())
    }
}

/// A step in turns.
pub(crate) fn amplitude(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if (0.001..=0.25).contains(&turns.abs()) => Ok(turns),
        _ => Err(format!(
            "must be 0.001..=0.25 turns, or as much below 0, got {text}"
        )),
    }
}
