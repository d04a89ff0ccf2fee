//! What torque, following error and switch say.

use crate::abort::{Abort, Awaited};
use crate::config::{Config, HardStop, Level, Method, Switch};
use crate::inputs::{Inputs, Reading};

/// As many torque readings in a row have to agree.
const READINGS: u8 = 2;

/// What was read lately.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Witness {
    /// When the torque that was judged last came.
    torque_us: Option<u64>,
    /// Torque readings in a row with a contact.
    contacts: u8,
    /// Torque readings in a row with a torque of the wrong sign.
    against: u8,
    /// Torque readings in a row above the limit.
    overloads: u8,
    /// When the switch was last seen released.
    pub(super) released_us: Option<u64>,
}

impl Witness {
    /// Starts to count anew.
    pub(super) fn forget(&mut self) {
        *self = Self {
            torque_us: self.torque_us,
            released_us: self.released_us,
            ..Self::default()
        };
    }

    /// Refuses readings that are too old for this method.
    pub(super) fn check_age(
        &self,
        config: &Config,
        now_us: u64,
        inputs: &Inputs,
    ) -> Result<(), Abort> {
        let limit_us = config.watch.max_age_us;
        let check = |what, age_us: Option<u64>| match age_us {
            Some(us) if us <= u64::from(limit_us) => Ok(()),
            _ => Err(Abort::TooOld {
                what,
                limit_us,
                age_us,
            }),
        };
        let needs_torque = match config.method {
            Method::Here => false,
            Method::HardStop(_) => true,
            Method::Switch(switch) => switch.most_permille.is_some(),
        };
        check(Awaited::Position, age(inputs.position, now_us))?;
        if needs_torque {
            check(Awaited::Torque, age(inputs.torque_permille, now_us))?;
        }
        if matches!(config.method, Method::Switch(_)) {
            check(Awaited::Switch, age(inputs.switch, now_us))?;
        }
        Ok(())
    }

    /// The torque in the direction of the search.
    pub(super) fn push(&self, sign: i32, inputs: &Inputs) -> i32 {
        inputs
            .torque_permille
            .map_or(0, |torque| sign * i32::from(torque.value))
    }

    /// The following error in the direction of the search.
    pub(super) fn error(sign: i32, inputs: &Inputs) -> i64 {
        inputs.position.map_or(0, |position| {
            i64::from(sign) * (i64::from(inputs.sent_counts) - i64::from(position.value))
        })
    }

    pub(super) fn is_operated(&self, switch: &Switch, inputs: &Inputs) -> bool {
        let operated = switch.operated == Level::High;
        inputs.switch.is_some_and(|level| level.value == operated)
    }

    /// Whether the torque came since the last call.
    fn is_new(&mut self, inputs: &Inputs) -> bool {
        let at_us = inputs.torque_permille.map(|torque| torque.at_us);
        let is_new = at_us != self.torque_us;
        self.torque_us = at_us;
        is_new
    }

    /// Whether the axis is in contact: torque and following error say so together.
    pub(super) fn is_in_contact(
        &mut self,
        stop: &HardStop,
        inputs: &Inputs,
    ) -> Result<bool, Abort> {
        let sign = stop.direction.sign();
        let is_new = u8::from(self.is_new(inputs));
        let (push, error) = (self.push(sign, inputs), Self::error(sign, inputs));
        let (contact, most) = (
            i32::from(stop.contact_permille),
            i32::from(stop.most_permille),
        );
        // Pulled or driven on by something else: that is no stop.
        if error <= -i64::from(stop.most_counts) {
            return Err(Abort::Blocked {
                limit_counts: stop.most_counts,
                actual_counts: -error,
            });
        }
        let is_held = error >= i64::from(stop.contact_counts);
        if is_held && push >= contact {
            self.contacts = self.contacts.saturating_add(is_new);
            return Ok(self.contacts >= READINGS || push >= most);
        }
        self.contacts = 0;
        let is_against = is_held && push <= -contact;
        self.against = if is_against {
            self.against.saturating_add(is_new)
        } else {
            0
        };
        if self.against >= READINGS {
            return Err(Abort::TorqueAgainst {
                contact_permille: stop.contact_permille,
                actual_permille: push as i16,
                error_counts: error,
            });
        }
        if error >= i64::from(stop.most_counts) {
            return Err(Abort::ErrorWithoutTorque {
                limit_counts: stop.most_counts,
                error_counts: error,
                contact_permille: stop.contact_permille,
                actual_permille: push as i16,
            });
        }
        // A single reading may have caught the jerk of a set-point.
        let is_over = push >= most;
        self.overloads = if is_over {
            self.overloads.saturating_add(is_new)
        } else {
            0
        };
        if self.overloads >= READINGS {
            return Err(Abort::TorqueWithoutError {
                limit_permille: stop.most_permille,
                actual_permille: push as i16,
                contact_counts: stop.contact_counts,
                error_counts: error,
            });
        }
        Ok(false)
    }

    /// Refuses a way on which the axis does not follow, in whatever direction.
    pub(super) fn check_way(&self, most_counts: u32, inputs: &Inputs) -> Result<(), Abort> {
        let error = Self::error(1, inputs);
        if error.abs() >= i64::from(most_counts) {
            return Err(Abort::Blocked {
                limit_counts: most_counts,
                actual_counts: error.abs(),
            });
        }
        Ok(())
    }

    /// Refuses a torque above the limit of a way, in whatever direction.
    pub(super) fn check_load(&mut self, most_permille: u16, inputs: &Inputs) -> Result<(), Abort> {
        let is_new = u8::from(self.is_new(inputs));
        let push = self.push(1, inputs);
        let is_over = push.abs() >= i32::from(most_permille);
        self.overloads = if is_over {
            self.overloads.saturating_add(is_new)
        } else {
            0
        };
        if self.overloads >= READINGS {
            return Err(Abort::Overload {
                limit_permille: most_permille,
                actual_permille: push as i16,
            });
        }
        Ok(())
    }
}

fn age<T>(reading: Option<Reading<T>>, now_us: u64) -> Option<u64> {
    reading.map(|reading| reading.age_us(now_us))
}
