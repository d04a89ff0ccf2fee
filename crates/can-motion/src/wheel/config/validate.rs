//! Which configurations can work.

use zlac8030l::NodeId;

use super::{WheelConfig, WheelConfigError, WheelMasterConfig, WheelMode, WheelTimeouts};
use crate::core::group::MOST_AXES;
use crate::core::settings::{first_out_of_order, first_too_long, first_too_short};
use crate::core::stamp::MOST_AGE_US;
use crate::wheel::config::FeedbackTiming;

/// Steps and changes of steps with which a ramp can be computed in 64 bit.
const STEPS: core::ops::RangeInclusive<i64> = 1..=1_000_000;

/// Range of the times of the drive in ms (2000h, 6083h to 6085h).
const OBJECT_MS: core::ops::RangeInclusive<i64> = 0..=32_767;
/// A round of readings of health in us: a third of it for each.
const HEALTH_US: core::ops::RangeInclusive<i64> = 3..=0xFFFF_FFFF;

impl WheelMasterConfig {
    pub(crate) fn validate(
        &self,
        wheels: &[WheelConfig],
        room: usize,
    ) -> Result<(), WheelConfigError> {
        let actual = wheels.len();
        let most = room.min(MOST_AXES).min(usize::from(NodeId::MAX.get()));
        if actual == 0 || actual > most {
            return Err(WheelConfigError::AxisCount { most, actual });
        }
        if !(1_000..=1_000_000).contains(&self.cycle_us) {
            return Err(WheelConfigError::Cycle {
                actual_us: self.cycle_us,
            });
        }
        if !zlac8030l::knows_bit_rate(self.bit_rate) {
            return Err(WheelConfigError::BitRate {
                actual: self.bit_rate,
            });
        }
        if self.requests_per_cycle == 0 {
            return Err(WheelConfigError::NoRequests);
        }
        self.validate_timeouts()?;
        let offline_ms = i64::from(self.timeouts.offline_ms);
        if let Some(first) = wheels.first()
            && !OBJECT_MS.contains(&offline_ms)
        {
            return Err(first.outside("offline_ms", &OBJECT_MS, offline_ms));
        }
        if let Some(node) = first_out_of_order(wheels.iter().map(|wheel| wheel.node)) {
            return Err(WheelConfigError::Order { node });
        }
        wheels.iter().try_for_each(WheelConfig::validate)
    }
}

impl WheelMasterConfig {
    fn validate_timeouts(&self) -> Result<(), WheelConfigError> {
        let times = &self.timeouts;
        let cycle_us = self.cycle_us;
        // At most 65,535 ticks of 1 ms, which is the longer of the two readings (Z11). An event timer of 0 is off, and the feedback
        // never comes.
        let (ticks, feedback_us) = match self.feedback {
            FeedbackTiming::Timer { ticks } => (u32::from(ticks), u32::from(ticks) * 1_000),
            FeedbackTiming::Sync => (1, cycle_us),
        };
        let heartbeat_ms = u32::from(times.heartbeat_ms);
        let too_short = first_too_short(&[
            ("feedback.ticks", 1, ticks),
            ("sdo.reply_us", 1, times.sdo.reply_us),
            ("heartbeat_ms", 1, heartbeat_ms),
            // One heartbeat may be lost.
            (
                "heartbeat_lost_us",
                2_000 * heartbeat_ms,
                times.heartbeat_lost_us,
            ),
            (
                "feedback_lost_us",
                feedback_us.saturating_mul(2).max(1),
                times.feedback_lost_us,
            ),
            // The drive stops by itself after it: one frame of a cycle may be lost.
            (
                "offline_ms",
                cycle_us.saturating_mul(2).div_ceil(1_000),
                u32::from(times.offline_ms),
            ),
            ("standstill_us", 1, times.standstill_us),
            (
                "standstill_limit_us",
                times.standstill_us.saturating_add(1),
                times.standstill_limit_us,
            ),
            // Three control words, each after the feedback of the one before.
            (
                "confirm_us",
                feedback_us.max(cycle_us).saturating_mul(4),
                times.confirm_us,
            ),
            ("stuck_us", 1, times.stuck_us),
            ("lost_after", 1, u32::from(times.lost_after)),
        ]);
        match too_short {
            None => times.validate_longest(),
            Some((name, least, actual)) => Err(WheelConfigError::Timeout {
                name,
                least,
                actual,
            }),
        }
    }
}

impl WheelTimeouts {
    /// Points in time are kept for so long; what is longer would end early.
    fn validate_longest(&self) -> Result<(), WheelConfigError> {
        let waits = [
            ("power_on_us", self.power_on_us),
            ("heartbeat_lost_us", self.heartbeat_lost_us),
            ("feedback_lost_us", self.feedback_lost_us),
            ("standstill_us", self.standstill_us),
            ("standstill_limit_us", self.standstill_limit_us),
            ("confirm_us", self.confirm_us),
            ("stuck_us", self.stuck_us),
        ];
        match first_too_long(&waits) {
            None => Ok(()),
            Some((name, actual_us)) => Err(WheelConfigError::LongWait {
                name,
                most_us: MOST_AGE_US,
                actual_us,
            }),
        }
    }
}

/// Range of 6071h either way.
const MOST_TORQUE_MA: i32 = 30_000;

impl WheelConfig {
    /// The largest target either way.
    fn most(&self) -> i32 {
        match self.mode {
            WheelMode::Velocity => 1_000 * i32::from(self.speed_resolution),
            WheelMode::Position { .. } => zlac8030l::MoveKind::Absolute.limit(),
            WheelMode::Torque { .. } => MOST_TORQUE_MA,
        }
    }

    const fn outside(
        &self,
        name: &'static str,
        range: &core::ops::RangeInclusive<i64>,
        actual: i64,
    ) -> WheelConfigError {
        WheelConfigError::Setting {
            node: self.node,
            name,
            least: *range.start(),
            most: *range.end(),
            actual,
        }
    }

    fn validate(&self) -> Result<(), WheelConfigError> {
        let (node, stops, values) = (self.node, &self.stops, &self.limits.values);
        let health_us = self.polls.health_us.map_or(*HEALTH_US.end(), i64::from);
        let (profile_speed_rpm, slope_ma_s) = match self.mode {
            WheelMode::Velocity => (1, 1),
            WheelMode::Position { profile_speed_rpm } => (profile_speed_rpm, 1),
            WheelMode::Torque { slope_ma_s } => (1, slope_ma_s),
        };
        let settings = [
            ("speed_resolution", 1..=10, self.speed_resolution.into()),
            ("profile_speed_rpm", 1..=1_000, profile_speed_rpm.into()),
            ("slope_ma_s", STEPS, slope_ma_s.into()),
            ("max_step", STEPS, values.max_step.into()),
            ("max_step_change", STEPS, values.max_step_change.into()),
            ("the stop option 605Ah", 5..=7, stops.quick_stop.into()),
            ("the stop option 605Bh", 0..=1, stops.shutdown.into()),
            ("the stop option 605Ch", 0..=1, stops.disable.into()),
            ("the stop option 605Dh", 0..=3, stops.halt.into()),
            ("ramp_ms", OBJECT_MS, self.ramp_ms.into()),
            ("emergency_ms", OBJECT_MS, stops.emergency_ms.into()),
            ("health_us", HEALTH_US, health_us),
        ];
        for (name, range, actual) in settings {
            if !range.contains(&actual) {
                return Err(self.outside(name, &range, actual));
            }
        }
        let (most, min, max) = (self.most(), values.min, values.max);
        if min > max || min < -most || max > most {
            return Err(WheelConfigError::Range {
                node,
                most,
                min,
                max,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wheel::config::WheelLimits;
    use can_frame::BitRate;
    use std::string::ToString;

    fn wheel(node: i32) -> WheelConfig {
        let limits = WheelLimits::speed(1_000, 10);
        WheelConfig::new(NodeId::new(node).unwrap(), WheelMode::Velocity, limits)
    }

    fn refused(wheel: WheelConfig) -> WheelConfigError {
        WheelMasterConfig::DEFAULT
            .validate(&[wheel], 1)
            .unwrap_err()
    }

    #[test]
    fn what_cannot_work_is_refused() {
        let config = WheelMasterConfig::DEFAULT;
        assert_eq!(config.validate(&[wheel(1), wheel(2)], 2), Ok(()));
        let node = NodeId::new(1).unwrap();
        assert_eq!(
            config.validate(&[wheel(1), wheel(1)], 2),
            Err(WheelConfigError::Order { node })
        );
        assert_eq!(
            config.validate(&[], 2),
            Err(WheelConfigError::AxisCount { most: 2, actual: 0 })
        );
        let silent = WheelMasterConfig {
            timeouts: WheelTimeouts {
                offline_ms: 0,
                ..WheelTimeouts::DEFAULT
            },
            ..config
        };
        assert_eq!(
            silent.validate(&[wheel(1)], 1),
            Err(WheelConfigError::Timeout {
                name: "offline_ms",
                least: 20,
                actual: 0
            })
        );
        let slow = WheelMasterConfig {
            cycle_us: 1_000_000,
            ..config
        };
        assert!(matches!(
            slow.validate(&[wheel(1)], 1),
            Err(WheelConfigError::Timeout { .. })
        ));
        let hasty = WheelMasterConfig {
            timeouts: WheelTimeouts {
                heartbeat_lost_us: 1,
                ..WheelTimeouts::DEFAULT
            },
            ..config
        };
        assert!(matches!(
            hasty.validate(&[wheel(1)], 1),
            Err(WheelConfigError::Timeout {
                name: "heartbeat_lost_us",
                least: 200_000,
                actual: 1
            })
        ));
        let mut odd = wheel(1);
        odd.stops.quick_stop = 4;
        assert!(matches!(
            refused(odd),
            WheelConfigError::Setting {
                name: "the stop option 605Ah",
                actual: 4,
                ..
            }
        ));
    }

    #[test]
    fn a_bus_that_cannot_carry_its_frames_is_refused() {
        use crate::core::family::Plan;
        use crate::wheel::plan::WheelPlan;
        let config = WheelMasterConfig {
            cycle_us: 2_000,
            feedback: FeedbackTiming::Timer { ticks: 4 },
            ..WheelMasterConfig::DEFAULT
        };
        let four = [1, 2, 3, 4].map(wheel);
        let refused = WheelPlan::new(&config, &four).admit(4).unwrap_err();
        assert!(
            matches!(
                refused,
                WheelConfigError::Late {
                    frame: "command",
                    ..
                }
            ),
            "{refused}"
        );
        let fast = WheelMasterConfig {
            bit_rate: BitRate::Kbit1000,
            ..config
        };
        assert_eq!(WheelPlan::new(&fast, &four[..2]).admit(4), Ok(()));
    }

    #[test]
    fn each_setting_has_its_range() {
        let text = |change: fn(&mut WheelConfig)| {
            let mut changed = wheel(1);
            changed.mode = WheelMode::Position {
                profile_speed_rpm: 100,
            };
            change(&mut changed);
            refused(changed).to_string()
        };
        let of_profile = |rpm| WheelMode::Position {
            profile_speed_rpm: rpm,
        };
        let texts = [
            text(|wheel| wheel.speed_resolution = 0),
            text(|wheel| wheel.limits.values.max_step = 0),
            text(|wheel| wheel.limits.values.max_step_change = 1_000_001),
            text(|wheel| wheel.stops.quick_stop = 4),
            text(|wheel| wheel.stops.shutdown = 2),
            text(|wheel| wheel.stops.disable = -1),
            text(|wheel| wheel.stops.halt = 4),
            text(|wheel| wheel.ramp_ms = 32_768),
            text(|wheel| wheel.stops.emergency_ms = 32_768),
            text(|wheel| wheel.polls.health_us = Some(2)),
        ];
        assert_eq!(
            texts,
            [
                "speed_resolution of node 1 must be 1..=10, got 0",
                "max_step of node 1 must be 1..=1000000, got 0",
                "max_step_change of node 1 must be 1..=1000000, got 1000001",
                "the stop option 605Ah of node 1 must be 5..=7, got 4",
                "the stop option 605Bh of node 1 must be 0..=1, got 2",
                "the stop option 605Ch of node 1 must be 0..=1, got -1",
                "the stop option 605Dh of node 1 must be 0..=3, got 4",
                "ramp_ms of node 1 must be 0..=32767, got 32768",
                "emergency_ms of node 1 must be 0..=32767, got 32768",
                "health_us of node 1 must be 3..=4294967295, got 2",
            ]
        );
        let mut config = WheelMasterConfig::DEFAULT;
        config.timeouts.offline_ms = 32_767;
        assert_eq!(config.validate(&[wheel(1)], 1), Ok(()));
        config.timeouts.offline_ms = 32_768;
        assert_eq!(
            config.validate(&[wheel(1)], 1).unwrap_err().to_string(),
            "offline_ms of node 1 must be 0..=32767, got 32768"
        );
        for rpm in [0, 1_001] {
            let mut changed = wheel(1);
            changed.mode = of_profile(rpm);
            assert_eq!(
                refused(changed).to_string(),
                std::format!("profile_speed_rpm of node 1 must be 1..=1000, got {rpm}")
            );
        }
    }

    #[test]
    fn targets_stay_within_their_object() {
        let node = NodeId::new(1).unwrap();
        let mut fast = wheel(1);
        fast.limits.values.max = 1_001;
        assert_eq!(
            refused(fast),
            WheelConfigError::Range {
                node,
                most: 1_000,
                min: -1_000,
                max: 1_001
            }
        );
        fast.speed_resolution = 10;
        assert_eq!(WheelMasterConfig::DEFAULT.validate(&[fast], 1), Ok(()));
        fast.speed_resolution = 11;
        assert!(matches!(
            refused(fast),
            WheelConfigError::Setting { actual: 11, .. }
        ));
        let far = WheelConfig {
            mode: WheelMode::Position {
                profile_speed_rpm: 100,
            },
            limits: WheelLimits::position(0, 0x4000_0000, 400, 20),
            ..wheel(1)
        };
        assert!(matches!(refused(far), WheelConfigError::Range { .. }));
    }

    #[test]
    fn a_waiting_time_beyond_what_is_kept_is_refused() {
        type Field = fn(&mut WheelTimeouts) -> &mut u32;
        let set: [(_, Field); 7] = [
            ("power_on_us", |times| &mut times.power_on_us),
            ("heartbeat_lost_us", |times| &mut times.heartbeat_lost_us),
            ("feedback_lost_us", |times| &mut times.feedback_lost_us),
            ("standstill_us", |times| &mut times.standstill_us),
            ("standstill_limit_us", |times| {
                &mut times.standstill_limit_us
            }),
            ("confirm_us", |times| &mut times.confirm_us),
            ("stuck_us", |times| &mut times.stuck_us),
        ];
        for (name, of) in set {
            let mut config = WheelMasterConfig::DEFAULT;
            // It is the longer of the two.
            config.timeouts.standstill_limit_us = MOST_AGE_US;
            *of(&mut config.timeouts) = MOST_AGE_US - 1;
            assert_eq!(config.validate(&[wheel(1)], 1), Ok(()), "{name}");
            if name == "standstill_us" {
                config.timeouts.standstill_limit_us = MOST_AGE_US + 2;
            }
            *of(&mut config.timeouts) = MOST_AGE_US + 1;
            let expected = WheelConfigError::LongWait {
                name,
                most_us: MOST_AGE_US,
                actual_us: MOST_AGE_US + 1,
            };
            assert_eq!(config.validate(&[wheel(1)], 1), Err(expected));
        }
    }
}
