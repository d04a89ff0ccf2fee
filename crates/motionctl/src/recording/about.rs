//! What is recorded, and by whom.

use std::time::{SystemTime, UNIX_EPOCH};

use can_decode::Decoder;
use dyn_can::{DriveId, FunctionCode};
use zlac8030l::{NodeId, PdoNumber, Service};

/// Where the frames and cycles come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Origin {
    /// Simulated drives in virtual time.
    Simulation,
    /// A real bus.
    Bus,
    /// A log of a bus: what the application wanted is not known.
    Log,
}

/// What the set-points are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Quantity {
    /// Positions of DYN drives.
    #[default]
    Position,
    /// Speeds of hub motors on CANopen.
    Speed,
}

impl Quantity {
    /// What the user calls a drive.
    pub(crate) const fn drive_word(self) -> &'static str {
        match self {
            Self::Position => "drive",
            Self::Speed => "node",
        }
    }

    /// What follows the conversation on a bus with such drives.
    pub(super) fn decoder(self) -> Decoder {
        match self {
            Self::Position => Decoder::default(),
            Self::Speed => Decoder::canopen(),
        }
    }
}

/// Command counts of an r/min in a recording of speeds.
pub(crate) const COUNTS_PER_RPM: f64 = 1_000.0;

/// One axis as the motion file has it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisAbout {
    /// The name of the column, or of the drive where there is none.
    pub(crate) name: String,
    /// Id of the drive, or node of the wheel.
    pub(crate) drive: u8,
    /// The unit behind its numbers.
    pub(crate) unit: String,
    /// Command counts of one unit; negative for an axis that is reversed.
    pub(crate) counts_per_unit: f64,
    /// The value in the file at the start of the motion, in the unit.
    pub(crate) start: f64,
    /// Identifier of its set-points.
    pub(crate) set_point_id: u16,
}

/// What a file or a stream calls an axis, and its unit. A stream says so when its sender comes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisNaming {
    pub(crate) name: String,
    pub(crate) unit: String,
    /// Command counts of one unit; negative for an axis that is reversed.
    pub(crate) counts_per_unit: f64,
}

impl AxisAbout {
    /// The same axis in other words.
    pub(crate) fn named(self, naming: AxisNaming) -> Self {
        let AxisNaming {
            name,
            unit,
            counts_per_unit,
        } = naming;
        Self {
            name,
            unit,
            counts_per_unit,
            ..self
        }
    }

    /// A drive of which only the id is known.
    pub(crate) fn of_drive(drive: DriveId) -> Self {
        Self {
            name: format!("drive {drive}"),
            drive: drive.get(),
            unit: "counts".to_owned(),
            counts_per_unit: 1.0,
            start: 0.0,
            set_point_id: drive.can_id(FunctionCode::GoRelativePosPd),
        }
    }

    /// A hub motor, whose speeds are recorded in thousandths of an r/min.
    pub(crate) fn of_node(node: NodeId) -> Self {
        Self {
            name: format!("node {node}"),
            drive: node.get(),
            unit: "r/min".to_owned(),
            counts_per_unit: COUNTS_PER_RPM,
            start: 0.0,
            set_point_id: Service::Rpdo(PdoNumber::Pdo1, node).can_id(),
        }
    }
}

/// What is recorded, and by whom.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct About {
    pub(crate) origin: Origin,
    pub(crate) quantity: Quantity,
    /// In the order of the columns.
    pub(crate) axes: Vec<AxisAbout>,
    pub(crate) cycle_us: u32,
    pub(crate) bit_ns: u64,
    /// As logs name the bus.
    pub(crate) interface: String,
    pub(crate) command_line: String,
    /// Since 1970, when the recording began; of a log the time of its first frame.
    pub(crate) started_unix_ns: u64,
    /// Of the random numbers, where there are any.
    pub(crate) seed: Option<u64>,
}

impl About {
    /// A recording that this command begins now.
    pub(crate) fn now(origin: Origin, axes: Vec<AxisAbout>, cycle_us: u32, bit_ns: u64) -> Self {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            origin,
            quantity: Quantity::default(),
            axes,
            cycle_us,
            bit_ns,
            interface: "can0".to_owned(),
            command_line: command_line(std::env::args()),
            started_unix_ns: since_1970
                .ok()
                .and_then(|time| u64::try_from(time.as_nanos()).ok())
                .unwrap_or(0),
            seed: None,
        }
    }

    /// The version of this tool.
    pub(crate) const fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }

    /// When it began, as `2026-03-01 12:30:05 UTC`.
    pub(crate) fn date(&self) -> String {
        if self.started_unix_ns == 0 {
            return "unknown: the times count from the begin of the log".to_owned();
        }
        let seconds = i64::try_from(self.started_unix_ns / 1_000_000_000).unwrap_or(0);
        let Ok(time) = time::OffsetDateTime::from_unix_timestamp(seconds) else {
            return "unknown".to_owned();
        };
        format!(
            "{:04}-{:02}-{:02} {:02}:{:02}:{:02} UTC",
            time.year(),
            u8::from(time.month()),
            time.day(),
            time.hour(),
            time.minute(),
            time.second()
        )
    }

    /// Name and text of everything that tells this recording from another.
    pub(crate) fn facts(&self) -> Vec<(&'static str, String)> {
        let mut facts = vec![
            ("command line", self.command_line.clone()),
            ("version", format!("motionctl {}", Self::version())),
            ("date", self.date()),
        ];
        facts.push((
            "seed",
            self.seed.map_or_else(
                || "none: it is no simulation".to_owned(),
                |seed| seed.to_string(),
            ),
        ));
        facts
    }
}

/// The words with the program's name alone in front, quoted where a shell needs it.
fn command_line(words: impl Iterator<Item = String>) -> String {
    let quoted = |word: String| {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
        if !word.is_empty() && word.chars().all(is_plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    let arguments = words.skip(1).map(quoted);
    core::iter::once("motionctl".to_owned())
        .chain(arguments)
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_can_be_given_to_a_shell_again() {
        let words = [
            "/usr/bin/x",
            "sim",
            "--trajectory",
            "my plan.csv",
            "it's",
            "",
        ];
        let line = command_line(words.map(str::to_owned).into_iter());
        assert_eq!(
            line,
            r"motionctl sim --trajectory 'my plan.csv' 'it'\''s' ''"
        );
    }

    #[test]
    fn the_date_is_that_of_the_start() {
        let about = About {
            started_unix_ns: 1_772_368_205_000_000_000,
            ..About::now(Origin::Bus, Vec::new(), 1_000, 1_000)
        };
        assert_eq!(about.date(), "2026-03-01 12:30:05 UTC");
    }
}
