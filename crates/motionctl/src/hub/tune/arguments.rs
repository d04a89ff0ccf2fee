//! Options of `motionctl tune --drives zlac`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::gains::{Gains, Loop};
use crate::counted::counted;
use crate::hub::error::HubError;
use crate::hub::nodes::OneNode;
use crate::link::LinkOptions;
use crate::tune::{MOST_SETS, WaveOption, amplitude};

const EXAMPLES: &str = "\
Examples:
  motionctl tune --drives zlac --slcan /dev/ttyACM0                                the gains that the drive has
  motionctl tune --drives zlac --slcan /dev/ttyACM0 --gains 500,100,1000 --gains 500,400,1000 --gains 800,100,1000 --svg answer.svg
  motionctl tune --drives zlac:5 --can can0 --of position --gains 50,200 --gains 90,200 --periods 4 --json

--of speed: the wheel is told --rpm and, --hold-ms later, 0 again, with its ramps at --ramp-ms; more --periods make a square wave. Gains are
Kp, Ki and Kf of its speed loop (201Dh, 201Eh, 201Fh). --of position: it is told a place --amplitude turns away and back, which it reaches by
its own profile at --rpm and --ramp-ms: what is measured is profile and loops together. Gains are Kp and Kf of its position loop (2020h, 2021h).
Speeds and positions come by PDO every 4 to 8 ms, and are stamped when they come in. The gains go to the RAM of the drive alone, with
read-back; afterwards it gets those back that it had, also after Ctrl-C or a fault. Keep what you like with `motionctl write`. Let the wheel hang free.

Exit status: 0 measured and the old gains are back; 1 a fault, or the old gains are not back; 2 not confirmed, enabled already, or out of range,
and nothing was done; 3 the link failed; 130 stopped by Ctrl-C, and the old gains are back.";

/// What is stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Of {
    /// The speed.
    Speed,
    /// The position, by the profile of the drive.
    Position,
}

/// Options of `motionctl tune --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(in crate::hub) struct Arguments {
    #[command(flatten)]
    pub(super) link: LinkOptions,
    #[command(flatten)]
    pub(super) node: OneNode,
    /// What is stepped.
    #[arg(long, value_enum, default_value = "speed")]
    pub(super) of: Of,
    /// Gains to measure, up to three times: Kp,Ki,Kf of the speed loop or Kp,Kf of the position loop. Default: those that the drive has.
    #[arg(long, value_name = "K,K[,K]", value_parser = Gains::parse)]
    gains: Vec<Gains>,
    /// Height of a step of the speed, and the speed of a move to a position, in r/min, at most 200.
    #[arg(long, value_name = "RPM", default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..=200))]
    pub(super) rpm: u16,
    /// Height of a step of the position in turns, at most 0.25 either way.
    #[arg(long, value_name = "TURNS", default_value = "0.1", allow_hyphen_values = true, value_parser = amplitude)]
    pub(super) amplitude: f64,
    /// Ramps of the drive meanwhile: the time from standstill to its highest speed (6083h, 6084h), in milliseconds.
    #[arg(long, value_name = "MS", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=30_000))]
    pub(super) ramp_ms: u16,
    /// Time for which each value is held, in milliseconds.
    #[arg(long, value_name = "MS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(100..=10_000))]
    pub(super) hold_ms: u32,
    /// Steps there and back: 1 is a step, more are a square wave.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=50))]
    pub(super) periods: u32,
    /// Who makes the wave. Hub motors have none of their own: step alone.
    #[arg(long, value_enum, default_value = "step")]
    wave: WaveOption,
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
    /// The loop whose gains are measured.
    pub(super) const fn control(&self) -> Loop {
        match self.of {
            Of::Speed => Loop::Speed,
            Of::Position => Loop::Position,
        }
    }

    /// The sets that were given; none where those of the drive are measured.
    ///
    /// # Errors
    /// [`HubError::Input`] for what does not fit together.
    pub(super) fn sets(&self) -> Result<&[Gains], HubError> {
        if self.wave != WaveOption::Step {
            return Err(HubError::Input(
                "hub motors have no wave of their own: no object of the ZLAC8030L dictionary makes one. Use --wave step with --periods, which is a square wave. Nothing was sent".to_owned(),
            ));
        }
        if self.gains.len() > MOST_SETS {
            return Err(HubError::Input(format!(
                "--gains may be given {MOST_SETS} times, it is given {} times",
                self.gains.len()
            )));
        }
        let control = self.control();
        for gains in &self.gains {
            gains.check(control)?;
        }
        Ok(&self.gains)
    }

    pub(super) fn question(&self, sets: &[Gains]) -> Result<String, HubError> {
        let node = self.node.get()?;
        let control = self.control();
        let sets: Vec<String> = sets.iter().map(|gains| gains.words(control)).collect();
        let jump = match self.of {
            Of::Speed => format!("JUMP to {} r/min and back to 0", self.rpm),
            Of::Position => format!(
                "MOVE by {} turns and back, at {} r/min",
                self.amplitude, self.rpm
            ),
        };
        Ok(format!(
            "Node {node} will get these gains one after the other, until its power goes: {}. With each its wheel will {jump}, {}. Is everybody clear, and does it hang free?",
            sets.join("; "),
            counted(self.periods, "time", "times")
        ))
    }
}
