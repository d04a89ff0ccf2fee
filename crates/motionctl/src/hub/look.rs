//! What a command that moves has to know of a drive first.

use can_motion::wheel::{WheelConfig, WheelLimits, WheelMode};
use zlac8030l::{NodeId, objects};

use super::bus::Bus;
use super::error::HubError;
use super::identity::require_settable;
use crate::home::Turning;

/// Time of the drive's own ramps while the master makes the speeds, in ms: it takes the edges off the steps of a PC that was late.
const STREAM_RAMP_MS: u16 = 100;
/// Counts of a line of the encoder.
const COUNTS_PER_LINE: f64 = 4.0;

/// A drive that may be moved: a ZLAC8030L without power and without a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    pub(super) node: NodeId,
    /// Speeds count 1/n r/min (202Fh:05).
    pub(super) speed_resolution: u16,
    pub(super) counts_per_turn: f64,
    /// The sense of rotation that is set in the drive; it stays.
    counter_clockwise: bool,
    /// 200Ah, to which the drive scales its ramps.
    max_speed_rpm: u16,
}

impl Look {
    /// Reads it.
    ///
    /// # Errors
    /// [`HubError::Enabled`], [`HubError::Fault`], [`HubError::OtherDevice`], or the bus's.
    pub(super) fn at(bus: &mut Bus, node: NodeId) -> Result<Self, HubError> {
        let state = require_settable(bus, node)?;
        if state.fault.is_some() {
            return Err(HubError::Fault {
                node,
                fault: state.fault_code(),
            });
        }
        let lines = bus.read(node, objects::ENCODER_LINES)?;
        Ok(Self {
            node,
            speed_resolution: bus.read(node, objects::SPEED_RESOLUTION)?,
            counts_per_turn: f64::from(lines) * COUNTS_PER_LINE,
            counter_clockwise: bus.read(node, objects::ROTATION)? == 1,
            max_speed_rpm: bus.read(node, objects::MAX_SPEED_RPM)?,
        })
    }

    /// Numbers of 60FFh for a speed.
    pub(super) fn units(&self, rpm: f64) -> f64 {
        rpm * f64::from(self.speed_resolution)
    }

    /// A wheel that follows speeds up to `most_rpm`, which change by `rpm_per_s` at most.
    pub(super) fn follows_speeds(
        &self,
        most_rpm: f64,
        rpm_per_s: f64,
        cycle_us: u32,
    ) -> WheelConfig {
        let most = self.units(most_rpm).ceil().clamp(1.0, 10_000.0) as u16;
        let change = self.units(rpm_per_s * f64::from(cycle_us) * 1e-6).ceil();
        WheelConfig {
            speed_resolution: self.speed_resolution,
            ramp_ms: STREAM_RAMP_MS,
            counter_clockwise: self.counter_clockwise,
            ..WheelConfig::new(
                self.node,
                WheelMode::Velocity,
                WheelLimits::speed(most, change.max(1.0) as u32),
            )
        }
    }

    /// The sense of rotation towards larger counts.
    pub(super) const fn positive_way(&self) -> Turning {
        if self.counter_clockwise {
            Turning::CounterClockwise
        } else {
            Turning::Clockwise
        }
    }

    /// A wheel that follows positions, with a profile of the drive to each of them.
    pub(super) fn follows_positions(
        &self,
        limits: WheelLimits,
        profile_speed_rpm: u16,
        rpm_per_s: f64,
    ) -> WheelConfig {
        WheelConfig {
            speed_resolution: self.speed_resolution,
            ramp_ms: self.ramp_ms(rpm_per_s),
            counter_clockwise: self.counter_clockwise,
            ..WheelConfig::new(self.node, WheelMode::Position { profile_speed_rpm }, limits)
        }
    }

    /// The drive takes this time from standstill to its highest speed.
    fn ramp_ms(&self, rpm_per_s: f64) -> u16 {
        let ms = f64::from(self.max_speed_rpm) / rpm_per_s * 1_000.0;
        ms.round().clamp(1.0, 32_767.0) as u16
    }

    /// A wheel that makes one move with the profile of the drive.
    pub(super) fn makes_a_move(&self, way: u32, rpm: u16, rpm_per_s: f64) -> WheelConfig {
        let limits = WheelLimits {
            // It is as far from its target as the move is long, and half a turn farther when it overshoots.
            following_error: way.saturating_add(self.counts_per_turn as u32 / 2),
            ..WheelLimits::position(
                -zlac8030l::MoveKind::Absolute.limit(),
                zlac8030l::MoveKind::Absolute.limit(),
                MOST_STEP,
                MOST_STEP,
            )
        };
        self.follows_positions(limits, rpm, rpm_per_s)
    }
}

/// The target of a move goes out at once.
const MOST_STEP: u32 = 1_000_000;
