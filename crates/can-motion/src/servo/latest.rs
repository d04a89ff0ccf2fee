//! The latest readings of a drive, as an axis keeps them: [`Feedback`] in a third of its room.

use bus_user::Instant;
use dyn_can::{ConfigByte, DriveStatus, ParamGroup3, Reply, Revision, Torque};

use crate::core::snapshot::Stamped;
use crate::core::stamp::Stamp;
use crate::servo::feedback::Feedback;
use crate::servo::poll_kind::PollKind;

const KINDS: usize = PollKind::ALL.len();

/// The latest readings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Latest {
    /// When each polled value came.
    at: [Stamp; KINDS],
    position: i32,
    torque: Option<Torque>,
    speed_rpm: i16,
    status: DriveStatus,
    counter: u8,
    /// Which of the polled values have come, one bit each.
    known: u8,
    config: Option<ConfigByte>,
    group3: Option<ParamGroup3>,
    pub(super) revision: Option<Revision>,
}

impl Latest {
    /// Nothing was read.
    pub(super) const NONE: Self = Self {
        at: [Stamp::ZERO; KINDS],
        position: 0,
        torque: None,
        speed_rpm: 0,
        status: DriveStatus::from_byte(0),
        counter: 0,
        known: 0,
        config: None,
        group3: None,
        revision: None,
    };

    pub(super) fn note(&mut self, at: Instant, reply: Reply) {
        let kind = match reply {
            Reply::DriveStatus(value) => {
                self.status = value;
                PollKind::Status
            }
            Reply::Position(value) => {
                self.position = value;
                PollKind::Position
            }
            Reply::Torque(value) => {
                self.torque = Some(value);
                PollKind::Torque
            }
            Reply::MotorSpeed(value) => {
                self.speed_rpm = value;
                PollKind::Speed
            }
            Reply::DiagnosticCounter(value) => {
                self.counter = value;
                PollKind::Counter
            }
            Reply::DriveConfig(value) => {
                self.config = Some(value);
                return;
            }
            Reply::ParamGroup3(value) => {
                self.group3 = Some(value);
                return;
            }
            Reply::DriveId(_)
            | Reply::ParamGroup1(_)
            | Reply::ParamGroup2(_)
            | Reply::DriveReset(_)
            | Reply::Echo(_)
            | Reply::DriveError(_) => return,
        };
        self.known |= 1 << kind as u8;
        if let Some(stamp) = self.at.get_mut(kind as usize) {
            *stamp = Stamp::of(at);
        }
    }

    const fn knows(&self, kind: PollKind) -> bool {
        self.known & 1 << kind as u8 != 0
    }

    /// The position in read-back counts.
    pub(super) fn position(&self) -> Option<i32> {
        self.knows(PollKind::Position).then_some(self.position)
    }

    /// The diagnostic counter.
    pub(super) fn counter(&self) -> Option<u8> {
        self.knows(PollKind::Counter).then_some(self.counter)
    }

    /// The configuration byte.
    pub(super) const fn config(&self) -> Option<ConfigByte> {
        self.config
    }

    /// How old a polled value is; `None` before the first.
    pub(super) fn age_us(&self, kind: PollKind, now: Instant) -> Option<u32> {
        let stamp = self.at.get(kind as usize)?;
        self.knows(kind).then(|| stamp.age_us(now))
    }

    /// All of it, seen from a moment close to the present.
    #[inline(always)]
    pub(super) fn feedback(&self, now: Instant) -> Feedback {
        Feedback {
            status: self.stamped(PollKind::Status, self.status, now),
            position: self.stamped(PollKind::Position, self.position, now),
            torque: self
                .torque
                .and_then(|torque| self.stamped(PollKind::Torque, torque, now)),
            speed_rpm: self.stamped(PollKind::Speed, self.speed_rpm, now),
            counter: self.stamped(PollKind::Counter, self.counter, now),
            config: self.config,
            group3: self.group3,
            revision: self.revision,
        }
    }

    fn stamped<T>(&self, kind: PollKind, value: T, now: Instant) -> Option<Stamped<T>> {
        let stamp = self.at.get(kind as usize)?;
        let at = stamp.at(now);
        self.knows(kind).then_some(Stamped { value, at })
    }

    /// As [`Stamp::keep`].
    pub(super) fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        for stamp in &mut self.at {
            stamp.keep(now, is_long_ago);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_value_comes_back_with_its_time() {
        let second = |second: u64| Instant::from_us(second * 1_000_000);
        let mut latest = Latest::NONE;
        assert_eq!(latest.feedback(second(9)), Feedback::default());
        latest.note(second(1), Reply::Position(-7));
        latest.note(second(2), Reply::DiagnosticCounter(200));
        latest.note(second(3), Reply::MotorSpeed(-40));
        latest.note(second(4), Reply::DriveConfig(ConfigByte::from_byte(3)));
        let expected = Feedback {
            position: Some(Stamped {
                value: -7,
                at: second(1),
            }),
            counter: Some(Stamped {
                value: 200,
                at: second(2),
            }),
            speed_rpm: Some(Stamped {
                value: -40,
                at: second(3),
            }),
            config: Some(ConfigByte::from_byte(3)),
            ..Feedback::default()
        };
        // Also from a moment before the latest of them.
        for seen_at in [second(2), second(9)] {
            assert_eq!(latest.feedback(seen_at), expected);
        }
        assert_eq!((latest.position(), latest.counter()), (Some(-7), Some(200)));
    }
}
