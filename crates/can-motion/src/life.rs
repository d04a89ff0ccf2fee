//! Life of an axis: the states, what each one asks the drive, and where a reply leads.
//!
//! ```text
//!  PowerOn -> Probing -> Identifying -> CheckingConfig -> CheckingStatus -> Anchoring -> Ready
//!                                                                                          | enable
//!  Streaming <- ConfirmingEnable <- Enabling <- Reanchoring <- AwaitingStandstill <--------+
//!   |   ^                                                                                  |
//!   |   | resume                                                                           |
//!   |  Holding <--+                                                                        |
//!   |             | done                                                                   |
//!   +--> RampingDown --> Disabling --> ConfirmingDisable ----------------------------------+
//!
//!  any state -- fault --> Faulted -- clear --> Probing, or Holding when only the group had a fault
//! ```

use core::fmt;

use dyn_can::{CommandMode, ReplyKind, ServoMode};

use crate::fault::Fault;
use crate::feedback::Feedback;

/// Where an axis is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AxisState {
    /// Waits until the drive has started (D58).
    PowerOn,
    /// Asks for an echo.
    Probing,
    /// Reads parameter group 3, whose length tells the revision (D62).
    Identifying,
    /// Reads the configuration: command mode 0 and position mode are needed (D45).
    CheckingConfig,
    /// Reads the status: no alarm, no built-in motion.
    CheckingStatus,
    /// Reads the position.
    Anchoring,
    /// Position known, no set-points; the drive may be enabled or not.
    Ready,
    /// Reads the speed until the shaft has stood still long enough (D59).
    AwaitingStandstill,
    /// Reads the position again: target = actual before enabling, so that nothing jumps.
    Reanchoring,
    /// The enable command waits for its frame.
    Enabling,
    /// Reads the status until it says enabled.
    ConfirmingEnable,
    /// A set-point every cycle.
    Streaming,
    /// A set-point every cycle, slowing down with its group.
    RampingDown,
    /// Enabled, no set-points; resumes on the application's word.
    Holding,
    /// The disable command waits for its frame.
    Disabling,
    /// Reads the status until it says disabled.
    ConfirmingDisable,
    /// Stopped by a fault, until `clear`.
    Faulted,
}

impl AxisState {
    /// A set-point goes out every cycle.
    #[must_use]
    pub const fn sends_set_points(self) -> bool {
        matches!(self, Self::Streaming | Self::RampingDown)
    }

    /// The drive is supposed to be enabled.
    #[must_use]
    pub const fn is_enabled(self) -> bool {
        matches!(self, Self::Streaming | Self::RampingDown | Self::Holding)
    }

    /// The drive was checked, and its position is known or was before a fault.
    #[cfg(feature = "zlac")]
    pub(crate) const fn is_known(self) -> bool {
        !matches!(
            self,
            Self::PowerOn
                | Self::Probing
                | Self::Identifying
                | Self::CheckingConfig
                | Self::CheckingStatus
                | Self::Anchoring
        )
    }

    /// A fault elsewhere in the group stops the axis: it is enabled, or about to be.
    pub(crate) const fn stops_with_group(self) -> bool {
        self.is_enabled()
            || matches!(
                self,
                Self::AwaitingStandstill
                    | Self::Reanchoring
                    | Self::Enabling
                    | Self::ConfirmingEnable
            )
    }

    /// A disable command takes effect at once.
    pub(crate) const fn may_be_disabled(self) -> bool {
        !matches!(
            self,
            Self::PowerOn
                | Self::Streaming
                | Self::RampingDown
                | Self::Disabling
                | Self::ConfirmingDisable
        )
    }

    /// The reading that this state waits for; `None` leaves the drive to the polls.
    pub(crate) const fn wanted_reading(self) -> Option<ReplyKind> {
        match self {
            Self::Probing => Some(ReplyKind::Echo),
            Self::Identifying => Some(ReplyKind::ParamGroup3),
            Self::CheckingConfig => Some(ReplyKind::DriveConfig),
            Self::CheckingStatus | Self::ConfirmingEnable | Self::ConfirmingDisable => {
                Some(ReplyKind::DriveStatus)
            }
            Self::Anchoring | Self::Reanchoring => Some(ReplyKind::Position),
            Self::AwaitingStandstill => Some(ReplyKind::MotorSpeed),
            Self::PowerOn
            | Self::Ready
            | Self::Enabling
            | Self::Streaming
            | Self::RampingDown
            | Self::Holding
            | Self::Disabling
            | Self::Faulted => None,
        }
    }

    /// Polls may run: the drive is known and nothing more urgent is asked.
    pub(crate) const fn may_poll(self) -> bool {
        matches!(
            self,
            Self::Ready | Self::Streaming | Self::RampingDown | Self::Holding | Self::Faulted
        )
    }
}

impl fmt::Display for AxisState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PowerOn => "power-on wait",
            Self::Probing => "probing",
            Self::Identifying => "identifying",
            Self::CheckingConfig => "checking configuration",
            Self::CheckingStatus => "checking status",
            Self::Anchoring => "anchoring",
            Self::Ready => "ready",
            Self::AwaitingStandstill => "awaiting standstill",
            Self::Reanchoring => "anchoring again",
            Self::Enabling => "enabling",
            Self::ConfirmingEnable => "confirming enable",
            Self::Streaming => "streaming",
            Self::RampingDown => "ramping down",
            Self::Holding => "holding",
            Self::Disabling => "disabling",
            Self::ConfirmingDisable => "confirming disable",
            Self::Faulted => "faulted",
        })
    }
}

/// Why an axis changed its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reason {
    /// The application asked for it.
    Command,
    /// The reading that the state waited for came.
    Reading,
    /// The command frame was handed to the controller.
    Sent,
    /// The controller gave the command frame back unsent.
    Displaced,
    /// The time of the state is over.
    Elapsed,
    /// The ramp reached standstill.
    Standstill,
    /// A fault of this axis or its group.
    Fault,
}

/// Where a reading leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    /// Stay.
    Stay,
    /// Go on.
    Go(AxisState),
    /// Take the position as the anchor, then go on.
    Anchor(AxisState),
    /// Stop.
    Fault(Fault),
}

/// Where the readings collected so far lead, when the one that `state` waits for has just come.
pub(crate) fn after_reading(state: AxisState, feedback: &Feedback, standstill: bool) -> Step {
    let status = feedback.status.map(|stamped| stamped.value);
    match state {
        AxisState::Probing => Step::Go(AxisState::Identifying),
        AxisState::Identifying => Step::Go(AxisState::CheckingConfig),
        AxisState::CheckingConfig => after_config(feedback),
        AxisState::CheckingStatus => match status {
            // In absolute mode the motor moves to its stored zero first (D58).
            Some(status) if status.motion_busy() => Step::Stay,
            _ => Step::Go(AxisState::Anchoring),
        },
        AxisState::Anchoring => Step::Anchor(AxisState::Ready),
        AxisState::AwaitingStandstill if standstill => Step::Go(AxisState::Reanchoring),
        AxisState::Reanchoring => Step::Anchor(AxisState::Enabling),
        AxisState::ConfirmingEnable if status.is_some_and(|status| !status.is_disabled()) => {
            Step::Go(AxisState::Streaming)
        }
        AxisState::ConfirmingDisable if status.is_some_and(|status| status.is_disabled()) => {
            Step::Go(AxisState::Ready)
        }
        _ => Step::Stay,
    }
}

fn after_config(feedback: &Feedback) -> Step {
    let Some(byte) = feedback.config else {
        return Step::Stay;
    };
    match byte.config() {
        Ok(config)
            if config.command_mode == CommandMode::Rs232
                && config.servo_mode == ServoMode::Position =>
        {
            Step::Go(AxisState::CheckingStatus)
        }
        _ => Step::Fault(Fault::Config(byte)),
    }
}

/// A fault that the latest status byte shows in this state.
pub(crate) fn status_fault(state: AxisState, feedback: &Feedback) -> Option<Fault> {
    let status = feedback.status?.value;
    if state == AxisState::Faulted {
        return None;
    }
    if status.alarm().is_alarm() {
        return Some(Fault::AlarmStatus(status.alarm()));
    }
    (state.is_enabled() && status.is_disabled()).then_some(Fault::DisabledWhileStreaming)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feedback::Stamped;
    use crate::time::Instant;
    use dyn_can::{Alarm, ConfigByte, DriveStatus};

    fn with_status(byte: u8) -> Feedback {
        let status = Stamped {
            value: DriveStatus::from_byte(byte),
            at: Instant::default(),
        };
        Feedback {
            status: Some(status),
            ..Feedback::default()
        }
    }

    fn with_config(byte: u8) -> Feedback {
        Feedback {
            config: Some(ConfigByte::from_byte(byte)),
            ..Feedback::default()
        }
    }

    #[test]
    fn only_rs232_and_position_mode_can_stream() {
        let after = |byte| after_reading(AxisState::CheckingConfig, &with_config(byte), false);
        assert_eq!(after(0x00), Step::Go(AxisState::CheckingStatus));
        assert_eq!(after(0x24), Step::Go(AxisState::CheckingStatus));
        for byte in [0x01, 0x08, 0x18] {
            assert_eq!(
                after(byte),
                Step::Fault(Fault::Config(ConfigByte::from_byte(byte)))
            );
        }
    }

    #[test]
    fn enable_waits_for_the_status_and_for_standstill() {
        use AxisState::{AwaitingStandstill, ConfirmingEnable, Reanchoring, Streaming};
        assert_eq!(
            after_reading(ConfirmingEnable, &with_status(0x02), false),
            Step::Stay
        );
        assert_eq!(
            after_reading(ConfirmingEnable, &with_status(0x00), false),
            Step::Go(Streaming)
        );
        let idle = Feedback::default();
        assert_eq!(after_reading(AwaitingStandstill, &idle, false), Step::Stay);
        assert_eq!(
            after_reading(AwaitingStandstill, &idle, true),
            Step::Go(Reanchoring)
        );
    }

    #[test]
    fn a_status_can_be_a_fault() {
        let alarm = Fault::AlarmStatus(Alarm::OverCurrent);
        assert_eq!(
            status_fault(AxisState::Ready, &with_status(0x0A)),
            Some(alarm)
        );
        assert_eq!(status_fault(AxisState::Faulted, &with_status(0x0A)), None);
        assert_eq!(status_fault(AxisState::Ready, &with_status(0x02)), None);
        assert_eq!(
            status_fault(AxisState::Streaming, &with_status(0x02)),
            Some(Fault::DisabledWhileStreaming)
        );
    }
}
