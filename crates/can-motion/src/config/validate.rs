//! Which configurations can work.

use dyn_can::{Counts28, DriveId};

use super::{AxisConfig, ConfigError, Limits, MasterConfig, Timeouts};
use crate::polls::PollKind;

impl MasterConfig {
    pub(crate) fn validate(&self, axes: &[AxisConfig], room: usize) -> Result<(), ConfigError> {
        let most = room.min(usize::from(DriveId::MAX.get()));
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
        if self.requests_per_cycle == 0 {
            return Err(ConfigError::NoRequests);
        }
        let Timeouts {
            reply_us,
            settle_us,
            standstill_limit_us,
            confirm_us,
            lost_after,
            ..
        } = self.timeouts;
        if [
            reply_us,
            settle_us,
            standstill_limit_us,
            confirm_us,
            u32::from(lost_after),
        ]
        .contains(&0)
        {
            return Err(ConfigError::Timeout);
        }
        for pair in axes.windows(2) {
            if let [lower, upper] = pair
                && upper.drive <= lower.drive
            {
                return Err(ConfigError::Order { drive: upper.drive });
            }
        }
        axes.iter().try_for_each(|axis| self.validate_axis(axis))
    }

    fn validate_axis(&self, axis: &AxisConfig) -> Result<(), ConfigError> {
        let drive = axis.drive;
        let Limits {
            travel_min: min,
            travel_max: max,
            ramp_change,
            ..
        } = axis.limits;
        let widest = Limits::WIDEST;
        if min > max || min < widest.travel_min || max > widest.travel_max {
            return Err(ConfigError::Travel { drive, min, max });
        }
        if ramp_change == 0 {
            return Err(ConfigError::RampChange { drive });
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
                && actual_us < self.cycle_us
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ReadBackScale;

    fn axis(drive: i32) -> AxisConfig {
        AxisConfig::new(DriveId::new(drive).unwrap())
    }

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
        let mut wide = axis(1);
        wide.limits.travel_max = 1 << 27;
        assert!(matches!(
            config.validate(&[wide], 4),
            Err(ConfigError::Travel { .. })
        ));
        let mut fine = axis(1);
        fine.read_back = ReadBackScale::ENCODER_COUNTS;
        assert_eq!(
            config.validate(&[fine], 4),
            Err(ConfigError::ReadBackRange {
                drive,
                most: (1 << 27) - 1,
                actual: -(1 << 27)
            })
        );
        (fine.limits.travel_min, fine.limits.travel_max) = (-(1 << 25), (1 << 25) - 1);
        assert_eq!(config.validate(&[fine], 4), Ok(()));
        fine.limits.travel_max += 1;
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
}
