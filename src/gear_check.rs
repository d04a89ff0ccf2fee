//! Whether a drive has the gear number of the configuration.
//!
//! With another one every step is longer or shorter than meant, and the drive would move to the wrong place.

use can_motion::AxisSnapshot;

use crate::config;
use crate::telemetry::{self, Message};

/// The check of one axis.
#[derive(Clone, Copy)]
pub(crate) struct GearCheck {
    /// The user knows about the number that was read.
    told: Option<u16>,
}

impl GearCheck {
    /// Nothing was read yet.
    pub(crate) const fn new() -> Self {
        Self { told: None }
    }

    /// Whether the drive that was identified has the right one; tells once when it has not. A drive whose parameters do not decode has not.
    pub(crate) fn fits(&mut self, axis: usize, snapshot: &AxisSnapshot) -> bool {
        let expected = config::gear_number(axis).get();
        let actual = snapshot
            .feedback
            .group3
            .map_or(0, |group| group.gear_number.get());
        if actual != expected && self.told != Some(actual) {
            self.told = Some(actual);
            telemetry::tell(Message::WrongGear {
                axis,
                expected,
                actual,
            });
        }
        actual == expected
    }
}
