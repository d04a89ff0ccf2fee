//! The unit in which a drive reports its position.

use dyn_can::{Counts28, GearNumber};

/// Read-back counts per command count as a fraction (D44).
///
/// The documents do not state the unit of the read-back: command counts (4 times the gear number a turn), movement positions (65536 a
/// turn) or motor steps (16384 a turn). Turn the shaft once by a command and compare before you trust one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ReadBackScale {
    /// Read-back counts ...
    pub read_back_counts: u32,
    /// ... for this many command counts.
    pub command_counts: u32,
}

impl ReadBackScale {
    /// The drive reports command counts.
    pub const COMMAND_COUNTS: Self = Self {
        read_back_counts: 1,
        command_counts: 1,
    };

    /// The drive reports movement positions, 65536 a turn whatever the gear.
    #[must_use]
    pub const fn movement_positions(gear: GearNumber) -> Self {
        Self {
            read_back_counts: 16_384,
            command_counts: gear.get() as u32,
        }
    }

    /// The drive reports motor steps, 16384 a turn whatever the gear.
    #[must_use]
    pub const fn motor_steps(gear: GearNumber) -> Self {
        Self {
            read_back_counts: 4_096,
            command_counts: gear.get() as u32,
        }
    }

    /// A read-back position in command counts, rounded to the nearest; `None` beyond 32 bit.
    #[must_use]
    pub fn to_command_counts(self, read_back: i32) -> Option<i32> {
        if self.command_counts == self.read_back_counts {
            return Some(read_back);
        }
        let (numerator, denominator) = (
            i64::from(self.command_counts),
            i64::from(self.read_back_counts),
        );
        let scaled = i64::from(read_back).checked_mul(numerator)?;
        let half = if scaled < 0 {
            -denominator / 2
        } else {
            denominator / 2
        };
        i32::try_from(scaled.checked_add(half)?.checked_div(denominator)?).ok()
    }

    /// Whether a position can be read back at all: within the 28 bit of the protocol (D16, D17).
    pub(super) fn reaches(self, command_counts: i32) -> bool {
        let read_back = i64::from(command_counts) * i64::from(self.read_back_counts);
        let range = |end: i32| i64::from(end) * i64::from(self.command_counts);
        (range(Counts28::MIN.get())..=range(Counts28::MAX.get())).contains(&read_back)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn read_back_scales_and_rounds() {
        let gear = |number| GearNumber::new(number).unwrap();
        let scale = ReadBackScale::movement_positions(gear(4_096));
        assert_eq!(scale.to_command_counts(400), Some(100));
        assert_eq!(scale.to_command_counts(402), Some(101));
        assert_eq!(scale.to_command_counts(-402), Some(-101));
        // A turn is 4 * 2048 command counts, 65536 movement positions, 16384 motor steps.
        let half = ReadBackScale::movement_positions(gear(2_048));
        assert_eq!(half.to_command_counts(65_536), Some(8_192));
        let half = ReadBackScale::motor_steps(gear(2_048));
        assert_eq!(half.to_command_counts(16_384), Some(8_192));
        let huge = ReadBackScale {
            read_back_counts: 1,
            command_counts: u32::MAX,
        };
        assert_eq!(huge.to_command_counts(i32::MAX), None);
    }
}
