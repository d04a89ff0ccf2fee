//! Software origins in a file: what `home` writes, and `jog` and `run` use.
//!
//! An origin stands on the count of its drive. An incremental drive counts from 0 again when it lost its power, and nothing in its replies
//! says so; but its diagnostic counter (function 1Fh) counts the reads of itself, starts at 0 at power-on, and no other command of this
//! tool reads it. So the file has the value that was read last: the next one follows it, or the drive has lost its power, or somebody else
//! has read the counter. In both cases the origin is refused.

mod error;
mod wheel;

use std::path::{Path, PathBuf};

use board_settings::file::Place;
use dyn_can::{DriveId, GearNumber, units};
use homing::Frame;
use serde::{Deserialize, Serialize};
use toml::value::Datetime;

use crate::backup::{create_file, this_tool};
use crate::drives::Life;
pub(crate) use error::{OriginsError, Spoilt};
pub(crate) use wheel::{HomedWheel, WheelLife};

const FORMAT: u8 = 1;
/// Reads of the counter that may have been lost on the bus.
const LOST_READS: u8 = 3;
/// A drive that was reset, or was given a zero of its own, stands at 0.
const AT_ZERO_COUNTS: u32 = 16;
/// A share of a turn from 0 below which a position of 0 says nothing.
const FAR_TURNS: u32 = 8;

/// What becomes of an origin when the drive loses its power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum AfterPowerLoss {
    /// It is lost: home again.
    HomeAgain,
    /// The motor moves to the drive's own zero by itself, and whether whole turns are kept is not stated: home again or compare with a mark.
    MovesAndCheck,
}

impl AfterPowerLoss {
    /// For the configuration of a drive: in absolute mode it moves to its stored zero (1.6A section 6, #0).
    pub(crate) fn of(is_absolute: bool) -> Self {
        use homing::PositionMemory::{Incremental, MovesToStoredZero};
        let memory = if is_absolute {
            MovesToStoredZero
        } else {
            Incremental
        };
        match homing::AfterPowerLoss::of(memory) {
            homing::AfterPowerLoss::MovesAndCheck => Self::MovesAndCheck,
            homing::AfterPowerLoss::HomeAgain | homing::AfterPowerLoss::Known => Self::HomeAgain,
        }
    }

    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::HomeAgain => "after a loss of its power the origin is lost: home again",
            Self::MovesAndCheck => {
                "after a loss of its power the drive MOVES its motor to its own zero by itself, and whether it kept whole turns is not stated: home again, or compare with a mark on the machine"
            }
        }
    }
}

/// One axis of the file. Counts are command counts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) struct HomedAxis {
    pub(crate) drive: u8,
    pub(crate) gear_number: i32,
    /// stop, switch, here, or stated where the user said it.
    pub(crate) method: String,
    pub(crate) homed: Datetime,
    /// What the drive reports at the zero of the axis.
    pub(crate) origin_counts: i32,
    pub(crate) uncertainty_counts: u32,
    /// Where the axis may be, from its zero.
    pub(crate) min_counts: i32,
    pub(crate) max_counts: i32,
    pub(crate) after_power_loss: AfterPowerLoss,
    /// What the drive reported when this was last checked.
    pub(crate) position_counts: i32,
    /// Its diagnostic counter then.
    pub(crate) counter: u8,
}

impl HomedAxis {
    fn travel(&self) -> homing::Travel {
        homing::Travel {
            min_counts: self.min_counts,
            max_counts: self.max_counts,
        }
    }

    /// The origin with its travel.
    pub(crate) fn frame(&self) -> Frame {
        Frame::new(self.origin_counts, self.travel())
    }

    /// Whether the drive still stands on the count on which the origin stands.
    fn check(&self, life: &Life) -> Result<(), Spoilt> {
        let gear = i32::from(life.gear.get());
        if gear != self.gear_number {
            return Err(Spoilt::Gear {
                expected: self.gear_number,
                actual: gear,
            });
        }
        let expected = self.counter.wrapping_add(1);
        if life.first_counter.wrapping_sub(expected) > LOST_READS {
            return Err(Spoilt::Counter {
                expected,
                actual: life.first_counter,
            });
        }
        let far = units::command_counts_per_turn(life.gear) / FAR_TURNS;
        let was_far = self.position_counts.unsigned_abs() > far;
        if life.position_counts.unsigned_abs() <= AT_ZERO_COUNTS && was_far {
            return Err(Spoilt::Zeroed {
                before_counts: self.position_counts,
            });
        }
        let axis = self.frame().to_axis_inside(life.position_counts);
        axis.map(drop).map_err(Spoilt::Outside)
    }
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: u8,
    #[serde(default)]
    axis: Vec<HomedAxis>,
    #[serde(default)]
    wheel: Vec<HomedWheel>,
}

/// A file of origins.
#[derive(Debug)]
pub(crate) struct Origins {
    path: PathBuf,
    axes: Vec<HomedAxis>,
    wheels: Vec<HomedWheel>,
}

impl Origins {
    /// Reads a file.
    ///
    /// # Errors
    /// [`OriginsError`] with the place of what is wrong.
    pub(crate) fn read(path: &Path) -> Result<Self, OriginsError> {
        let text = std::fs::read_to_string(path).map_err(|source| OriginsError::Read {
            path: path.to_owned(),
            source,
        })?;
        let at = |place, reason| OriginsError::Content {
            path: path.to_owned(),
            place,
            reason,
        };
        let file: File = toml::from_str(&text).map_err(|error| {
            let byte = error.span().map_or(0, |span| span.start);
            at(Place::of(&text, byte), error.message().to_owned())
        })?;
        let start = Place { line: 1, column: 1 };
        if file.format != FORMAT {
            let reason = format!("expected format = {FORMAT}, got {}", file.format);
            return Err(at(start, reason));
        }
        for (number, axis) in file.axis.iter().enumerate() {
            let reason = if DriveId::new(axis.drive.into()).is_err() {
                Some(format!("expected a drive id of 1..=63, got {}", axis.drive))
            } else if GearNumber::new(axis.gear_number).is_err() {
                Some(format!(
                    "expected a gear number of 500..=16384, got {}",
                    axis.gear_number
                ))
            } else if axis.min_counts > axis.max_counts {
                Some(format!(
                    "expected min-counts below max-counts, got {} and {}",
                    axis.min_counts, axis.max_counts
                ))
            } else if file
                .axis
                .iter()
                .take(number)
                .any(|other| other.drive == axis.drive)
            {
                Some("expected each drive once, got it twice".to_owned())
            } else {
                None
            };
            if let Some(reason) = reason {
                return Err(at(start, format!("drive {}: {reason}", axis.drive)));
            }
        }
        if let Some(reason) = wheel::wrong(&file.wheel) {
            return Err(at(start, reason));
        }
        Ok(Self {
            path: path.to_owned(),
            axes: file.axis,
            wheels: file.wheel,
        })
    }

    /// Reads a file, or begins one that does not exist.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(crate) fn read_or_begin(path: &Path) -> Result<Self, OriginsError> {
        if path.symlink_metadata().is_err() {
            return Ok(Self {
                path: path.to_owned(),
                axes: Vec::new(),
                wheels: Vec::new(),
            });
        }
        Self::read(path)
    }

    /// The axis of a drive, after a look at the drive; the file notes what was seen.
    ///
    /// # Errors
    /// [`OriginsError::Missing`], or [`OriginsError::Spoilt`] when the origin does not hold any more: nothing may move to a position then.
    pub(crate) fn take(&mut self, drive: DriveId, life: &Life) -> Result<HomedAxis, OriginsError> {
        let path = self.path.clone();
        let axis = self.axes.iter_mut().find(|axis| axis.drive == drive.get());
        let Some(axis) = axis else {
            return Err(OriginsError::Missing { path, drive });
        };
        axis.check(life).map_err(|reason| OriginsError::Spoilt {
            path,
            drive,
            reason,
        })?;
        axis.counter = life.last_counter;
        axis.position_counts = life.position_counts;
        let axis = axis.clone();
        self.write()?;
        Ok(axis)
    }

    /// Puts an axis into the file, in the place of an older one of the same drive.
    ///
    /// # Errors
    /// [`OriginsError::Write`]; the file is as it was.
    pub(crate) fn put(&mut self, axis: HomedAxis) -> Result<(), OriginsError> {
        self.axes.retain(|other| other.drive != axis.drive);
        self.axes.push(axis);
        self.axes.sort_by_key(|axis| axis.drive);
        self.write()
    }

    /// Makes sure that the file holds no origin of a drive that is about to lose it.
    ///
    /// # Errors
    /// As [`Self::put`].
    pub(crate) fn forget(&mut self, drive: DriveId) -> Result<(), OriginsError> {
        let before = self.axes.len();
        self.axes.retain(|axis| axis.drive != drive.get());
        if self.axes.len() == before && self.path.symlink_metadata().is_ok() {
            return Ok(());
        }
        self.write()
    }

    fn write(&self) -> Result<(), OriginsError> {
        let mut text = String::from(HEAD);
        text.push_str(&format!("format = {FORMAT}\n"));
        for axis in &self.axes {
            // Everything in it can be written.
            let body = toml::to_string(axis).unwrap_or_default();
            text.push_str(&format!("\n[[axis]]\n{body}"));
        }
        for wheel in &self.wheels {
            let body = toml::to_string(wheel).unwrap_or_default();
            text.push_str(&format!("\n[[wheel]]\n{body}"));
        }
        create_file(&self.path, &text, true).map_err(OriginsError::Write)
    }
}

const HEAD: &str = "\
# Software origins of axes, written by `motionctl home` and used by `jog` and `run` with --origins. Counts are command counts.
# An axis is at (what its drive reports) - origin-counts. Each use notes position and diagnostic counter of the drive: keep one file for
# one machine, and do not copy it while it is in use. An origin that its drive has lost is refused.
";

/// The present date.
pub(crate) fn now() -> Datetime {
    this_tool().date
}

#[cfg(test)]
mod tests;
