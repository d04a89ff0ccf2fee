//! Why a request of a host is refused: a number, what was expected and what came.

use core::fmt;

use serde::{Deserialize, Serialize};
use trajectory::Position;

/// A request that is not carried out: nothing of it moves anything.
///
/// On the wire it is this structure, so a number that a host does not know yet still has its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refused {
    /// The number of the [`Reason`]; it never changes.
    pub number: u16,
    /// The axis, from 0, where it is about one.
    pub axis: Option<u8>,
    /// What was expected, in the [`Reason::unit`] of the reason.
    pub expected: i64,
    /// What came.
    pub actual: i64,
}

/// What the values of a refusal are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// There is nothing to compare.
    Nothing,
    /// A plain number.
    Number,
    /// 2^-24 counts.
    Position,
    /// 2^-24 counts per cycle.
    Velocity,
    /// 2^-24 counts per cycle².
    Acceleration,
    /// 2^-24 counts per cycle³.
    Jerk,
    /// 2^-32 cycles.
    Time,
}

/// Why a request is refused. 1 to 13 mean what they mean for [`Refusal`](crate::Refusal).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
#[repr(u16)]
pub enum Reason {
    /// Another number of axes than the board has.
    Axes = 1,
    /// The motion does not start where an axis stands.
    Start = 2,
    /// The start is in the past.
    Past = 3,
    /// A segment is not the next one.
    Order = 4,
    /// A segment is too short.
    Close = 5,
    /// A segment is too long, or the start too far ahead.
    Ahead = 6,
    /// An axis would leave its travel.
    Travel = 7,
    /// An axis would be too fast.
    Velocity = 8,
    /// An axis would accelerate too much.
    Acceleration = 9,
    /// The acceleration of an axis would change too fast.
    Jerk = 10,
    /// There is no room: the sender has no credit.
    Full = 11,
    /// The segments ran out before this one came, and the motion has ended.
    Late = 12,
    /// The end was announced, or the motion was told to stop.
    Ended = 13,
    /// The velocity of an axis has a step between two segments.
    VelocityStep = 14,
    /// The acceleration of an axis has a step between two segments, and its jerk is limited.
    AccelerationStep = 15,
    /// The last segment does not end at rest.
    NotAtRest = 16,
    /// An override beyond its range.
    Override = 17,
    /// Another stream than the one that was begun.
    Stream = 18,
    /// No stream was begun.
    NoStream = 19,
    /// A stream is still played.
    Moving = 20,
    /// The session does not command: it was never claimed, was released, was silent for too long, or the board was reset.
    NoSession = 21,
    /// Another session commands.
    Taken = 22,
    /// The command before is still carried out.
    Busy = 23,
    /// The axes are not enabled.
    NotEnabled = 24,
    /// The stop circuit is open.
    StopInput = 25,
    /// The enable input is not active.
    EnableInput = 26,
    /// An axis has a fault.
    Faulted = 27,
    /// The board is not in a state for this.
    NotReady = 28,
    /// The application did not answer in time.
    NoAnswer = 29,
    /// A piece of the settings is not the next one.
    Chunk = 30,
    /// The settings are too long, or not complete.
    Length = 31,
    /// The settings are not what their checksum says.
    Checksum = 32,
    /// The settings make no board that works.
    Settings = 33,
    /// Not while an axis is enabled.
    Enabled = 34,
    /// There is no such entry.
    NoEntry = 35,
    /// The board cannot do this.
    Unsupported = 36,
    /// The frame is complete, and its body is no message.
    Message = 37,
    /// The board runs another version of the protocol.
    Version = 38,
    /// The firmware failed; the board must be switched off and on.
    Locked = 39,
    /// The flash does not keep what is stored.
    Store = 40,
}

/// Number, unit and text of each reason.
const REASONS: [(Reason, Unit, &str, &str); 40] = {
    use Reason as R;
    use Unit as U;
    [
        (
            R::Axes,
            U::Number,
            "another number of axes than the board has",
            "send one value for each axis",
        ),
        (
            R::Start,
            U::Position,
            "the motion must start where the axis stands",
            "read the set-points again and begin from there",
        ),
        (
            R::Past,
            U::Number,
            "the start, in cycles of the board, is in the past",
            "synchronise the time, begin later",
        ),
        (
            R::Order,
            U::Number,
            "the segment is not the next one",
            "send the expected one",
        ),
        (
            R::Close,
            U::Time,
            "the segment is too short",
            "send fewer, longer segments",
        ),
        (
            R::Ahead,
            U::Time,
            "it is too long, or too far ahead",
            "divide the segment, or begin later",
        ),
        (
            R::Travel,
            U::Position,
            "beyond the travel of the axis",
            "stay within the travel, or change it in the settings",
        ),
        (
            R::Velocity,
            U::Velocity,
            "too fast",
            "give the segment more time",
        ),
        (
            R::Acceleration,
            U::Acceleration,
            "too much acceleration",
            "give the segment more time",
        ),
        (
            R::Jerk,
            U::Jerk,
            "too much jerk",
            "give the segment more time",
        ),
        (R::Full, U::Number, "the buffer is full", "wait for credit"),
        (
            R::Late,
            U::Number,
            "the segments ran out and the motion has ended",
            "begin a new stream, and send further ahead",
        ),
        (
            R::Ended,
            U::Number,
            "the motion ends: no segment is taken any more",
            "begin a new stream",
        ),
        (
            R::VelocityStep,
            U::Velocity,
            "the velocity has a step at the start of the segment",
            "start with the velocity at the end of the one before",
        ),
        (
            R::AccelerationStep,
            U::Acceleration,
            "the acceleration has a step at the start of the segment, and the jerk is limited",
            "start with the acceleration at the end of the one before",
        ),
        (
            R::NotAtRest,
            U::Velocity,
            "the last segment does not end at rest",
            "send one that does before the end",
        ),
        (
            R::Override,
            U::Number,
            "the override in percent is beyond its range",
            "send 0 to 200",
        ),
        (
            R::Stream,
            U::Number,
            "another stream than the one that was begun",
            "send its number",
        ),
        (R::NoStream, U::Number, "no stream was begun", "begin one"),
        (
            R::Moving,
            U::Number,
            "a stream is still played",
            "stop it, or wait for its end",
        ),
        (
            R::NoSession,
            U::Number,
            "the session does not command",
            "claim the command",
        ),
        (
            R::Taken,
            U::Number,
            "another session commands",
            "let it release the command first",
        ),
        (
            R::Busy,
            U::Number,
            "the command before is still carried out",
            "wait for its reply",
        ),
        (
            R::NotEnabled,
            U::Number,
            "the axes are not enabled",
            "enable them first",
        ),
        (
            R::StopInput,
            U::Nothing,
            "the stop circuit is open",
            "close it at the machine",
        ),
        (
            R::EnableInput,
            U::Nothing,
            "the enable input is not active",
            "activate it at the machine",
        ),
        (
            R::Faulted,
            U::Number,
            "the axis has a fault",
            "read it, remove its cause, clear it",
        ),
        (
            R::NotReady,
            U::Number,
            "the board is in another state",
            "read its state",
        ),
        (
            R::NoAnswer,
            U::Number,
            "the application did not answer in so many cycles",
            "read the state of the board and repeat",
        ),
        (
            R::Chunk,
            U::Number,
            "the piece of the settings is not the next one",
            "continue at the expected byte",
        ),
        (
            R::Length,
            U::Number,
            "the settings have another length",
            "send as many bytes as were announced and fit",
        ),
        (
            R::Checksum,
            U::Number,
            "the settings are not what their checksum says",
            "write them again",
        ),
        (
            R::Settings,
            U::Number,
            "the settings make no board that works",
            "correct the value that the check names",
        ),
        (
            R::Enabled,
            U::Number,
            "not while an axis is enabled",
            "disable first",
        ),
        (
            R::NoEntry,
            U::Number,
            "there is no such entry",
            "ask for one below the expected number",
        ),
        (
            R::Unsupported,
            U::Nothing,
            "the board cannot do this",
            "read its info",
        ),
        (
            R::Message,
            U::Number,
            "the body of the frame is no message",
            "use the message format of this version",
        ),
        (
            R::Version,
            U::Number,
            "the board runs another version of the protocol",
            "use a host of that version, or update the board",
        ),
        (
            R::Locked,
            U::Nothing,
            "the firmware failed and enables nothing",
            "read the fault log, switch the board off and on",
        ),
        (
            R::Store,
            U::Number,
            "the flash does not keep what is stored: its status",
            "repeat it; replace the board if it fails again",
        ),
    ]
};

impl Reason {
    /// Every reason, by number.
    pub fn all() -> impl Iterator<Item = Self> {
        REASONS.iter().map(|row| row.0)
    }

    /// The number on the wire.
    #[must_use]
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// What its values are.
    #[must_use]
    pub fn unit(self) -> Unit {
        self.row().map_or(Unit::Number, |row| row.1)
    }

    fn row(self) -> Option<&'static (Self, Unit, &'static str, &'static str)> {
        REASONS.iter().find(|row| row.0 == self)
    }

    /// With what was expected and what came.
    #[must_use]
    pub const fn because(self, expected: i64, actual: i64) -> Refused {
        Refused {
            number: self.number(),
            axis: None,
            expected,
            actual,
        }
    }

    /// The same about an axis.
    #[must_use]
    pub const fn at(self, axis: usize, expected: i64, actual: i64) -> Refused {
        Refused {
            axis: Some(axis as u8),
            ..self.because(expected, actual)
        }
    }

    /// Where there is nothing to compare.
    #[must_use]
    pub const fn plain(self) -> Refused {
        self.because(0, 0)
    }
}

impl Refused {
    /// The reason, where this version knows its number.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        Reason::all().find(|reason| reason.number() == self.number)
    }
}

/// A value with its unit.
struct Value(Unit, i64);

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = self.1 as f32 / Position::UNITS as f32;
        match self.0 {
            Unit::Nothing | Unit::Number => write!(f, "{}", self.1),
            Unit::Position => write!(f, "{counts} counts"),
            Unit::Velocity => write!(f, "{counts} counts per cycle"),
            Unit::Acceleration => write!(f, "{counts} counts per cycle²"),
            Unit::Jerk => write!(f, "{counts} counts per cycle³"),
            Unit::Time => write!(f, "{} cycles", self.1 as f32 / (1_u64 << 32) as f32),
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "refusal {}: ", self.number)?;
        if let Some(axis) = self.axis {
            write!(f, "axis {axis}: ")?;
        }
        let row = self.reason().and_then(Reason::row);
        let unit = row.map_or(Unit::Number, |row| row.1);
        f.write_str(row.map_or("a reason that this version does not know", |row| row.2))?;
        if unit != Unit::Nothing {
            let (expected, actual) = (Value(unit, self.expected), Value(unit, self.actual));
            write!(f, ": expected {expected}, got {actual}")?;
        }
        row.map_or(Ok(()), |row| write!(f, "; {}", row.3))
    }
}

impl core::error::Error for Refused {}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn the_numbers_are_1_to_40_in_order() {
        let numbers: std::vec::Vec<u16> = Reason::all().map(Reason::number).collect();
        assert_eq!(numbers, (1..=40).collect::<std::vec::Vec<u16>>());
    }

    #[test]
    fn a_refusal_says_what_to_do() {
        assert_eq!(
            Reason::Velocity.at(2, 3 << 23, 2 << 24).to_string(),
            "refusal 8: axis 2: too fast: expected 1.5 counts per cycle, got 2 counts per cycle; give the segment more time"
        );
        assert_eq!(
            Reason::StopInput.plain().to_string(),
            "refusal 25: the stop circuit is open; close it at the machine"
        );
        let unknown = Refused {
            number: 999,
            axis: None,
            expected: 1,
            actual: 2,
        };
        assert_eq!(unknown.reason(), None);
        assert!(
            unknown
                .to_string()
                .ends_with("does not know: expected 1, got 2")
        );
    }
}
