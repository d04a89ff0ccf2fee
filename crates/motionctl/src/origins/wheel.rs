//! Origins of hub motors.
//!
//! Their encoder is incremental and a drive that lost its power counts from 0 again. What a drive does not keep tells of it: the homing
//! writes a number to an object that nothing uses and that no EEPROM holds (1803h:04, reserved in the guide and in CiA 301). The drive still
//! has it, or it was without power.

use core::fmt;
use std::path::PathBuf;

use homing::{Frame, OutsideTravel, Travel};
use serde::{Deserialize, Serialize};
use toml::value::Datetime;

use super::{AfterPowerLoss, Origins, OriginsError};

/// One hub motor of the file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) struct HomedWheel {
    pub(crate) node: u8,
    /// Counts of a turn (200Bh, four a line).
    pub(crate) turn_counts: u32,
    /// stop, switch or here.
    pub(crate) method: String,
    pub(crate) homed: Datetime,
    /// What the drive reports at the zero of the axis.
    pub(crate) origin_counts: i32,
    pub(crate) uncertainty_counts: u32,
    /// Where the axis may be, from its zero.
    pub(crate) min_counts: i32,
    pub(crate) max_counts: i32,
    pub(crate) after_power_loss: AfterPowerLoss,
    /// What stands in 1803h:04 since the homing.
    pub(crate) mark: u8,
}

/// What a drive says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct WheelLife {
    pub(crate) turn_counts: u32,
    pub(crate) position_counts: i32,
    pub(crate) mark: u8,
}

/// Why the origin of a hub motor does not hold any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SpoiltWheel {
    /// Its encoder has other lines: its counts are others.
    Encoder { expected: u32, actual: u32 },
    /// The drive has lost its power.
    Mark { expected: u8, actual: u8 },
    /// The axis is outside its travel.
    Outside(OutsideTravel),
}

impl fmt::Display for SpoiltWheel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Encoder { expected, actual } => write!(
                f,
                "it was homed with {expected} counts a turn, the drive has {actual} (200Bh);"
            ),
            Self::Mark { expected, actual } => write!(
                f,
                "1803h:04 must be {expected} as the homing wrote it, it is {actual}: the drive has lost its power since and counts from another place, or it was homed again into another file;"
            ),
            Self::Outside(error) => write!(
                f,
                "{error}: bring it back with `motionctl jog --drives zlac --turns` without --origins, or"
            ),
        }
    }
}

impl HomedWheel {
    /// The origin with its travel.
    pub(crate) fn frame(&self) -> Frame {
        Frame::new(
            self.origin_counts,
            Travel {
                min_counts: self.min_counts,
                max_counts: self.max_counts,
            },
        )
    }

    fn check(&self, life: &WheelLife) -> Result<(), SpoiltWheel> {
        if life.turn_counts != self.turn_counts {
            return Err(SpoiltWheel::Encoder {
                expected: self.turn_counts,
                actual: life.turn_counts,
            });
        }
        if life.mark != self.mark {
            return Err(SpoiltWheel::Mark {
                expected: self.mark,
                actual: life.mark,
            });
        }
        let axis = self.frame().to_axis_inside(life.position_counts);
        axis.map(drop).map_err(SpoiltWheel::Outside)
    }
}

/// What is wrong with the hub motors of a file.
pub(super) fn wrong(wheels: &[HomedWheel]) -> Option<String> {
    wheels.iter().enumerate().find_map(|(place, wheel)| {
        let node = wheel.node;
        if !(1..=127).contains(&node) {
            Some(format!("expected a node of 1..=127, got {node}"))
        } else if wheel.mark == 0 {
            Some(format!(
                "node {node}: expected a mark of 1..=255, got 0, which a drive has after its power-on"
            ))
        } else if wheel.min_counts > wheel.max_counts {
            Some(format!(
                "node {node}: expected min-counts below max-counts, got {} and {}",
                wheel.min_counts, wheel.max_counts
            ))
        } else if wheels.iter().take(place).any(|other| other.node == node) {
            Some(format!("node {node}: expected each node once, got it twice"))
        } else {
            None
        }
    })
}

impl Origins {
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// The axis of a hub motor, after a look at its drive.
    ///
    /// # Errors
    /// [`OriginsError::MissingWheel`], or [`OriginsError::SpoiltWheel`]: nothing may move to a position then.
    pub(crate) fn wheel(&self, node: u8, life: &WheelLife) -> Result<&HomedWheel, OriginsError> {
        let path = self.path();
        let wheel = self.wheels.iter().find(|wheel| wheel.node == node);
        let Some(wheel) = wheel else {
            return Err(OriginsError::MissingWheel { path, node });
        };
        match wheel.check(life) {
            Ok(()) => Ok(wheel),
            Err(reason) => Err(OriginsError::SpoiltWheel { path, node, reason }),
        }
    }

    /// Puts a hub motor into the file, in the place of an older one of the same node.
    ///
    /// # Errors
    /// [`OriginsError::Write`]; the file is as it was.
    pub(crate) fn put_wheel(&mut self, wheel: HomedWheel) -> Result<(), OriginsError> {
        self.wheels.retain(|other| other.node != wheel.node);
        self.wheels.push(wheel);
        self.wheels.sort_by_key(|wheel| wheel.node);
        self.write()
    }

    /// Makes sure that the file holds no origin of a hub motor that is about to lose it, and that it can be written.
    ///
    /// # Errors
    /// As [`Self::put_wheel`].
    pub(crate) fn forget_wheel(&mut self, node: u8) -> Result<(), OriginsError> {
        self.wheels.retain(|wheel| wheel.node != node);
        self.write()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::origins::now;

    fn wheel() -> HomedWheel {
        HomedWheel {
            node: 4,
            turn_counts: 4_096,
            method: "stop".to_owned(),
            homed: now(),
            origin_counts: -500,
            uncertainty_counts: 1,
            min_counts: -100,
            max_counts: 5_000,
            after_power_loss: AfterPowerLoss::HomeAgain,
            mark: 77,
        }
    }

    const LIFE: WheelLife = WheelLife {
        turn_counts: 4_096,
        position_counts: 0,
        mark: 77,
    };

    #[test]
    fn an_origin_holds_while_its_drive_has_power() {
        assert_eq!(wheel().check(&LIFE), Ok(()));
        let restarted = WheelLife { mark: 0, ..LIFE };
        assert!(matches!(
            wheel().check(&restarted),
            Err(SpoiltWheel::Mark {
                expected: 77,
                actual: 0
            })
        ));
        let other = WheelLife {
            turn_counts: 8_192,
            ..LIFE
        };
        assert!(matches!(
            wheel().check(&other),
            Err(SpoiltWheel::Encoder { .. })
        ));
        let outside = WheelLife {
            position_counts: -601,
            ..LIFE
        };
        assert!(matches!(
            wheel().check(&outside),
            Err(SpoiltWheel::Outside(_))
        ));
    }

    #[test]
    fn a_file_with_a_wrong_wheel_is_refused() {
        assert_eq!(wrong(&[wheel()]), None);
        let unmarked = HomedWheel { mark: 0, ..wheel() };
        let reversed = HomedWheel {
            min_counts: 6_000,
            ..wheel()
        };
        let nobody = HomedWheel { node: 0, ..wheel() };
        for wheels in [
            vec![unmarked],
            vec![reversed],
            vec![nobody],
            vec![wheel(), wheel()],
        ] {
            assert!(wrong(&wheels).is_some(), "{wheels:?}");
        }
    }
}
