//! Options of `motionctl home --drives zlac`.

use std::path::PathBuf;

use clap::ValueEnum;
use homing::Abort;

use crate::home::SearchOptions;
use crate::hub::error::HubError;
use crate::hub::look::Look;
use crate::hub::nodes::OneNode;
use crate::link::LinkOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl home --drives zlac --slcan /dev/ttyACM0 --method stop --direction negative --max-turns 2 --travel 0:1.5 --origins machine.toml
  motionctl home --drives zlac:5 --can can0 --method here --travel -1:1 --origins machine.toml
  motionctl home --drives zlac --slcan /dev/ttyACM0 --method switch --direction positive --max-turns 2 --switch-input X1

For a hub motor that moves an axis: a lift, a steering, a slide. A wheel on the ground has neither stop nor switch: `here` is for it.
The methods are those of servo drives (`motionctl home --help`). The drive moves in position mode, and its largest current (2015h) is
lowered to --max-torque for the time of the search, in its RAM: percents are of that current as it was before. Whether 2015h counts at once is
not stated, so --torque and --max-degrees end the search without it too.
--switch-input X0 or X1 is an input of the drive (2003h), which must have no function (2030h:02, :03); anything else is a file, a pipe or a terminal
on which another program writes the level, as for servo drives. The encoder is incremental: the origin is lost with the power. --origins notes it (1803h:04), so that `jog --origins` refuses it then.

Exit status: 0 found, and kept where --origins says; 1 not found, or the drive did not confirm that its power is off; 2 not confirmed,
enabled already, or options that cannot work, and nothing has moved; 3 the link failed; 130 stopped by Ctrl-C.";

/// What 1 of 6077h is; the guide has both (Z25).
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum CurrentUnit {
    /// 0.1 A, by the text of the guide.
    #[value(name = "0.1A")]
    Deciampere,
    /// 1 mA, by the range that it prints.
    #[value(name = "mA")]
    Milliampere,
}

/// Options of `motionctl home --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(in crate::hub) struct Arguments {
    #[command(flatten)]
    pub(super) link: LinkOptions,
    #[command(flatten)]
    pub(super) node: OneNode,
    #[command(flatten)]
    pub(super) search: SearchOptions,
    /// File of software origins in which the result is kept, in TOML; other drives in it stay.
    #[arg(long, value_name = "FILE.toml", requires = "travel")]
    pub(super) origins: Option<PathBuf>,
    /// Make the place where the axis rests the 0 of the drive too (2005h, 2006h), until its power goes.
    #[arg(long)]
    pub(super) in_drive: bool,
    /// What 1 of the torque that the drive reports is (6077h, Z25).
    #[arg(long, value_enum, default_value = "0.1A")]
    pub(super) current_unit: CurrentUnit,
    /// The drive reports torque with the other sign: negative where it turns towards larger counts.
    #[arg(long)]
    pub(super) torque_reversed: bool,
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
    pub(super) fn question(&self, look: &Look) -> Result<String, HubError> {
        let node = self.node.get()?;
        let stores = if self.in_drive {
            " The drive will count 0 where it rests."
        } else {
            ""
        };
        let whose = format!("node {node}");
        Ok(self.search.question(&whose, stores, look.positive_way()))
    }

    /// What the guide leaves open, where that may be the reason.
    pub(super) fn hint(&self, abort: &Abort) -> &'static str {
        match (abort, self.current_unit) {
            (Abort::TorqueAgainst { .. }, _) => {
                ". The guide does not state the sign of 6077h: try --torque-reversed, with the stop in sight"
            }
            (
                Abort::TorqueWithoutError { .. } | Abort::TorqueAtRest { .. },
                CurrentUnit::Deciampere,
            ) => {
                ". Where 6077h counts mA every torque looks a hundred times too large: see --current-unit (Z25)"
            }
            (Abort::ErrorWithoutTorque { .. }, CurrentUnit::Milliampere) => {
                ". Where 6077h counts 0.1 A every torque looks a hundred times too small: see --current-unit (Z25)"
            }
            _ => "",
        }
    }
}
