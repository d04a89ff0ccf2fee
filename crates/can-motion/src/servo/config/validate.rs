//! Which configurations can work.

use dyn_can::{Counts28, DriveId};

use super::{AxisConfig, ConfigError, MasterConfig, Timeouts, Travel};
use crate::core::group::MOST_AXES;
use crate::core::settings::{first_out_of_order, first_too_long, first_too_short};
use crate::core::stamp::MOST_AGE_US;
use crate::servo::poll_kind::PollKind;
use crate::servo::polls::cycles_of;

impl MasterConfig {
    pub(crate) fn validate(&self, axes: &[AxisConfig], room: usize) -> Result<(), ConfigError> {
        let most = room.min(MOST_AXES).min(usize::from(DriveId::MAX.get()));
        if axes.is_empty() || axes.len() > most {
            return Err(ConfigError::AxisCount {
                most,
                actual: axes.len(),
            });
        }
        if !(250..=1_000_000).contains(&self.cycle_us) {
            return Err(ConfigError::Cycle {
                actual_us: self.cycle_us,
            });
        }
        if !dyn_can::knows_bit_rate(self.bus.bit_rate) {
            return Err(ConfigError::BitRate {
                actual: self.bus.bit_rate,
            });
        }
        if self.requests_per_cycle == 0 {
            return Err(ConfigError::NoRequests);
        }
        self.timeouts.validate(self.cycle_us)?;
        if let Some(drive) = first_out_of_order(axes.iter().map(|axis| axis.drive)) {
            return Err(ConfigError::Order { drive });
        }
        axes.iter().try_for_each(|axis| self.validate_axis(axis))
    }

    fn validate_axis(&self, axis: &AxisConfig) -> Result<(), ConfigError> {
        let drive = axis.drive;
        let limits = &axis.limits;
        let (min, max) = (limits.travel.min_counts, limits.travel.max_counts);
        let widest = Travel::WHOLE;
        if min > max || min < widest.min_counts || max > widest.max_counts {
            return Err(ConfigError::Travel { drive, min, max });
        }
        let max_step = limits.max_step.get();
        if limits.backlog_counts < u32::from(max_step) {
            return Err(ConfigError::Backlog {
                drive,
                max_step,
                actual: limits.backlog_counts,
            });
        }
        if limits.drift_tolerance_counts > limits.following_error_counts {
            return Err(ConfigError::Tolerance {
                drive,
                following_error: limits.following_error_counts,
                actual: limits.drift_tolerance_counts,
            });
        }
        if axis.polls.status_us.is_none() && !axis.unwatched {
            return Err(ConfigError::Unwatched { drive });
        }
        if axis.read_back.read_back_counts == 0 || axis.read_back.command_counts == 0 {
            return Err(ConfigError::ReadBack { drive });
        }
        for end in [min, max] {
            if !axis.read_back.reaches(end) {
                return Err(ConfigError::ReadBackRange {
                    drive,
                    most: Counts28::MAX.get(),
                    actual: end,
                });
            }
        }
        for kind in PollKind::ALL {
            if let Some(actual_us) = axis.polls.of(kind)
                && cycles_of(actual_us, self.cycle_us).is_none()
            {
                return Err(ConfigError::PollPeriod {
                    drive,
                    kind,
                    actual_us,
                });
            }
        }
        Ok(())
    }
}

impl Timeouts {
    fn validate(&self, cycle_us: u32) -> Result<(), ConfigError> {
        let too_short = first_too_short(&[
            // A reply cannot be waited for in less than the cycle that notices it.
            ("reply_us", cycle_us, self.reply_us),
            ("settle_us", 1, self.settle_us),
            ("standstill_us", 1, self.standstill_us),
            (
                "standstill_limit_us",
                self.standstill_us.saturating_add(1),
                self.standstill_limit_us,
            ),
            // A switch, its reading, and the time that the reading may take.
            (
                "confirm_us",
                self.reply_us.saturating_add(cycle_us.saturating_mul(2)),
                self.confirm_us,
            ),
            ("stuck_us", 1, self.stuck_us),
            ("lost_after", 1, u32::from(self.lost_after)),
        ]);
        if let Some((name, least, actual)) = too_short {
            return Err(ConfigError::Timeout {
                name,
                least,
                actual,
            });
        }
        let waits = [
            ("power_on_us", self.power_on_us),
            ("reply_us", self.reply_us),
            ("settle_us", self.settle_us),
            ("alarm_quiet_us", self.alarm_quiet_us),
            ("arrival_us", self.arrival_us),
            ("standstill_us", self.standstill_us),
            ("standstill_limit_us", self.standstill_limit_us),
            ("confirm_us", self.confirm_us),
            ("stuck_us", self.stuck_us),
        ];
        match first_too_long(&waits) {
            None => Ok(()),
            Some((name, actual_us)) => Err(ConfigError::LongWait {
                name,
                most_us: MOST_AGE_US,
                actual_us,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo::config::{ReadBackScale, test_axis as axis};

    #[test]
    fn what_cannot_work_is_refused() {
        let config = MasterConfig::DEFAULT;
        assert_eq!(config.validate(&[axis(1), axis(2)], 4), Ok(()));
        assert_eq!(
            config.validate(&[], 4),
            Err(ConfigError::AxisCount { most: 4, actual: 0 })
        );
        let drive = DriveId::MIN;
        assert_eq!(
            config.validate(&[axis(1), axis(1)], 4),
            Err(ConfigError::Order { drive })
        );
        assert_eq!(
            config.validate(&[axis(2), axis(1)], 4),
            Err(ConfigError::Order { drive })
        );
        let mut of_hub_motors = config;
        of_hub_motors.bus.bit_rate = can_frame::BitRate::Kbit100;
        assert_eq!(
            of_hub_motors.validate(&[axis(1)], 4),
            Err(ConfigError::BitRate {
                actual: can_frame::BitRate::Kbit100
            })
        );
        let mut often = axis(1);
        often.polls.status_us = Some(999);
        assert_eq!(
            config.validate(&[often], 4),
            Err(ConfigError::PollPeriod {
                drive,
                kind: PollKind::Status,
                actual_us: 999
            })
        );
        often.polls.status_us = Some(65_535_999);
        assert_eq!(config.validate(&[often], 4), Ok(()));
        often.polls.status_us = Some(65_536_000);
        assert!(matches!(
            config.validate(&[often], 4),
            Err(ConfigError::PollPeriod { .. })
        ));
        let mut patient = config;
        patient.timeouts.arrival_us = MOST_AGE_US;
        assert_eq!(patient.validate(&[axis(1)], 4), Ok(()));
        patient.timeouts.arrival_us += 1;
        assert_eq!(
            patient.validate(&[axis(1)], 4),
            Err(ConfigError::LongWait {
                name: "arrival_us",
                most_us: MOST_AGE_US,
                actual_us: MOST_AGE_US + 1
            })
        );
        let mut wide = axis(1);
        wide.limits.travel.max_counts = 1 << 27;
        assert!(matches!(
            config.validate(&[wide], 4),
            Err(ConfigError::Travel { .. })
        ));
        let mut fine = axis(1);
        fine.read_back = ReadBackScale::movement_positions(fine.gear);
        assert_eq!(
            config.validate(&[fine], 4),
            Err(ConfigError::ReadBackRange {
                drive,
                most: (1 << 27) - 1,
                actual: -(1 << 27)
            })
        );
        fine.limits.travel = Travel {
            min_counts: -(1 << 25),
            max_counts: (1 << 25) - 1,
        };
        assert_eq!(config.validate(&[fine], 4), Ok(()));
        fine.limits.travel.max_counts += 1;
        assert!(config.validate(&[fine], 4).is_err());
        let fast = MasterConfig {
            cycle_us: 249,
            ..config
        };
        assert_eq!(
            fast.validate(&[axis(1)], 4),
            Err(ConfigError::Cycle { actual_us: 249 })
        );
    }

    #[test]
    fn what_contradicts_itself_is_refused() {
        let config = MasterConfig::DEFAULT;
        let refused = |axis| config.validate(&[axis], 4).unwrap_err();
        let mut narrow = axis(1);
        narrow.limits.backlog_counts = 16_383;
        assert!(matches!(
            refused(narrow),
            ConfigError::Backlog {
                max_step: 16_384,
                actual: 16_383,
                ..
            }
        ));
        let mut loose = axis(1);
        loose.limits.drift_tolerance_counts = loose.limits.following_error_counts + 1;
        assert!(matches!(refused(loose), ConfigError::Tolerance { .. }));
        let mut blind = axis(1);
        blind.polls.status_us = None;
        assert!(matches!(refused(blind), ConfigError::Unwatched { .. }));
        blind.unwatched = true;
        assert_eq!(config.validate(&[blind], 4), Ok(()));
        let hasty = Timeouts {
            confirm_us: 11_999,
            ..Timeouts::DEFAULT
        };
        let hasty = MasterConfig {
            timeouts: hasty,
            ..config
        };
        assert_eq!(
            hasty.validate(&[axis(1)], 4),
            Err(ConfigError::Timeout {
                name: "confirm_us",
                least: 12_000,
                actual: 11_999
            })
        );
    }
}
