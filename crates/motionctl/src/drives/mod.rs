//! The seam between the commissioning commands and whatever connects the drives.
//!
//! `scan`, `read`, `write` and `jog` know [`Drives`] and no protocol. Each protocol implements it in its own folder and is
//! chosen by [`DrivesOptions`].

mod assign;
mod can;
mod error;
mod frames;
mod options;
mod parameter;
mod probe;
mod readings;
mod serial;

use dyn_can::{DriveId, GearNumber, StoredDriveId};
use schemars::JsonSchema;
use serde::Serialize;

use crate::station::MotionLimits;

pub(crate) use assign::{AssignEnd, AssignError};
pub(crate) use can::{CanDrives, Life, life_of, read_curve, state_of};
pub(crate) use error::DrivesError;
pub(crate) use frames::{Frames, Step, When};
pub(crate) use options::DrivesOptions;
pub(crate) use parameter::{Parameter, Setting};
pub(crate) use probe::ProbeEnd;
pub(crate) use readings::{DriveState, Readings};
pub(crate) use serial::{LineMove, SerialDrives, Way};

/// A drive that answered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct FoundDrive {
    pub(crate) drive: u8,
    /// The protocol that it speaks, with its revision where that is known.
    pub(crate) protocol: String,
}

/// How a write ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum WriteEnd {
    /// The drive already had the value: nothing was written.
    Unchanged,
    /// Written, and read back as written.
    Written,
}

/// A move by hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jog {
    /// Motor turns, positive clockwise.
    pub(crate) turns: f64,
    /// Highest speed on the way, in rpm.
    pub(crate) rpm: f64,
    /// Limits of a profile that is streamed; a built-in move has those of its drive.
    pub(crate) limits: MotionLimits,
    /// The gear number that the drive must have.
    pub(crate) gear: Option<GearNumber>,
}

/// Where a jog has led.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct JogEnd {
    /// The distance asked for, in command counts.
    pub(crate) asked_counts: i32,
    /// The distance that was commanded: less when the jog was stopped.
    pub(crate) sent_counts: i32,
    /// The distance that the drive reports, in command counts.
    pub(crate) read_counts: Option<i32>,
    /// It was stopped by Ctrl-C.
    pub(crate) interrupted: bool,
    /// The drive is still enabled, as it was before.
    pub(crate) enabled: bool,
}

/// What a reset has changed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct ResetEnd {
    pub(crate) drive: u8,
    pub(crate) alarm_before: Option<String>,
    pub(crate) alarm_after: Option<String>,
    /// In the unit of the drive's read-back.
    pub(crate) position_before_counts: Option<i32>,
    pub(crate) position_after_counts: Option<i32>,
    /// The reset has switched the servo on, and it was switched off again.
    pub(crate) was_switched_on: bool,
}

/// Drives that can be commissioned. Every call ends by itself: with a result, or when nothing answers.
pub(crate) trait Drives {
    /// Asks every id for an answer; tells each id before it is asked.
    fn scan(&mut self, on_id: &mut dyn FnMut(u8)) -> Result<Vec<FoundDrive>, DrivesError>;

    /// Reads the state and every parameter of a drive.
    fn read(&mut self, drive: StoredDriveId) -> Result<Readings, DrivesError>;

    /// Compares, writes where a value differs, and reads back, one setting after the other; tells how each ended and stops
    /// at the first that did not succeed. The user has agreed.
    fn write(
        &mut self,
        drive: StoredDriveId,
        settings: &[Setting],
        on_end: &mut dyn FnMut(Setting, WriteEnd),
    ) -> Result<(), DrivesError>;

    /// Moves the drive. One that is on stays on; one that is off is enabled and disabled again, where the protocol has such
    /// commands. The user has agreed. Ctrl-C is listened to and stops the move.
    fn jog(&mut self, drive: StoredDriveId, jog: Jog) -> Result<JogEnd, DrivesError>;

    /// Makes sure that exactly one drive answers to the id.
    fn require_one(&mut self, drive: StoredDriveId) -> Result<(), DrivesError>;

    /// Stores another id in a drive, after looking who else is there. The user has agreed.
    fn assign_id(&mut self, from: StoredDriveId, to: DriveId) -> Result<AssignEnd, DrivesError>;

    /// Makes the present position the zero that the drive stores. The user has agreed. Nothing acknowledges it: read the position.
    fn set_origin(&mut self, drive: StoredDriveId) -> Result<(), DrivesError>;

    /// Clears the fault and the position of a drive, where its protocol has that. The user has agreed.
    fn reset(&mut self, drive: StoredDriveId) -> Result<ResetEnd, DrivesError>;

    /// Looks at the diagnostic counter of a drive, where its protocol has one, and at its position.
    fn life(&mut self, drive: StoredDriveId) -> Result<Life, DrivesError>;

    /// Finds out the byte orders of a drive without power. The user has agreed.
    fn probe(&mut self, drive: StoredDriveId) -> Result<ProbeEnd, DrivesError>;
}
