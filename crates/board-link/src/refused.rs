//! Why a request of a host is refused: a number, what was expected and what came.

use core::fmt;

use serde::{Deserialize, Serialize};
use trajectory::Position;

use crate::message::BoardState;
use crate::reason::{Reason, Unit};

/// A request that is not carried out: nothing of it moves anything.
///
/// On the wire it is this structure, so a number that a host does not know yet still has its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refused {
    /// The number of the [`Reason`]; it never changes.
    pub number: u16,
    /// The axis, from 0, where it is about one.
    pub axis: Option<u8>,
    /// What was expected, in the [`Reason::unit`] of the reason.
    pub expected: i64,
    /// What came.
    pub actual: i64,
}

impl Reason {
    /// With what was expected and what came.
    #[must_use]
    pub const fn because(self, expected: i64, actual: i64) -> Refused {
        Refused {
            number: self.number(),
            axis: None,
            expected,
            actual,
        }
    }

    /// The same about an axis.
    #[must_use]
    pub const fn at(self, axis: usize, expected: i64, actual: i64) -> Refused {
        Refused {
            axis: Some(axis as u8),
            ..self.because(expected, actual)
        }
    }

    /// Where there is nothing to compare.
    #[must_use]
    pub const fn plain(self) -> Refused {
        self.because(0, 0)
    }
}

impl Refused {
    /// Whether it is for this reason. Unlike [`Self::reason`] it needs no table with the texts, which a board leaves out of its flash (4 KB).
    #[must_use]
    pub const fn is(&self, reason: Reason) -> bool {
        self.number == reason.number()
    }

    /// The reason, where this version knows its number.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        Reason::all().find(|reason| reason.number() == self.number)
    }
}

/// A value with its unit.
struct Value(Unit, i64);

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = Fraction::<{ Position::UNITS.trailing_zeros() }, 8>(self.1);
        match self.0 {
            Unit::Nothing | Unit::Number | Unit::Fault => write!(f, "{}", self.1),
            Unit::Position => write!(f, "{counts} counts"),
            Unit::Velocity => write!(f, "{counts} counts per cycle"),
            Unit::Acceleration => write!(f, "{counts} counts per cycle²"),
            Unit::Jerk => write!(f, "{counts} counts per cycle³"),
            Unit::Time => write!(f, "{} cycles", Fraction::<32, 10>(self.1)),
            Unit::State => match BoardState::with_number(self.1) {
                Some(state) => write!(f, "'{}'", state.text()),
                None => write!(f, "state {}", self.1),
            },
        }
    }
}

/// A number of units of 2^-BITS, with so many decimals that no two of them look the same.
struct Fraction<const BITS: u32, const DECIMALS: u32>(i64);

impl<const BITS: u32, const DECIMALS: u32> fmt::Display for Fraction<BITS, DECIMALS> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.unsigned_abs();
        let (whole, units) = (magnitude >> BITS, magnitude % (1 << BITS));
        let short = self.0 as f32;
        // What was a number of 32 bits, as limits are, is told as that; beyond 24 bits it would be rounded.
        if whole < 1 << f32::MANTISSA_DIGITS && short as i64 == self.0 {
            return write!(f, "{}", short / (1_u64 << BITS) as f32);
        }
        let sign = if self.0 < 0 { "-" } else { "" };
        write!(f, "{sign}{whole}")?;
        let scaled = u128::from(units) * 10_u128.pow(DECIMALS);
        let mut decimals = ((scaled + (1 << (BITS - 1))) >> BITS) as u64;
        if decimals == 0 {
            return Ok(());
        }
        let mut width = DECIMALS as usize;
        while decimals.is_multiple_of(10) {
            (decimals, width) = (decimals / 10, width - 1);
        }
        write!(f, ".{decimals:0width$}")
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "refusal {}: ", self.number)?;
        if let Some(axis) = self.axis {
            write!(f, "axis {axis}: ")?;
        }
        let row = self.reason().and_then(Reason::row);
        let unit = match row.map_or(Unit::Number, |row| row.1) {
            Unit::Fault if self.axis.is_none() => Unit::State,
            // A state that is the expected one is none that refuses.
            Unit::State if self.expected == self.actual => Unit::Nothing,
            unit => unit,
        };
        f.write_str(row.map_or("a reason that this version does not know", |row| row.2))?;
        if unit != Unit::Nothing {
            let (expected, actual) = (Value(unit, self.expected), Value(unit, self.actual));
            write!(f, ": expected {expected}, got {actual}")?;
        }
        row.map_or(Ok(()), |row| write!(f, "; {}", row.3))
    }
}

impl core::error::Error for Refused {}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::message::BoardState;
    use crate::reason::REASONS;

    #[test]
    fn the_numbers_are_1_to_60_in_order() {
        let numbers: std::vec::Vec<u16> = Reason::all().map(Reason::number).collect();
        assert_eq!(numbers, (1..=60).collect::<std::vec::Vec<u16>>());
    }

    #[test]
    fn the_readme_has_every_number_with_its_text() {
        let readme = include_str!("../README.md");
        for (reason, _, why, what_to_do) in REASONS {
            let row = readme
                .lines()
                .find(|line| line.starts_with(&std::format!("| {} | {why} |", reason.number())));
            let row = row.unwrap_or_else(|| panic!("{reason:?} is missing"));
            assert!(row.ends_with(&std::format!("| {what_to_do} |")), "{row}");
        }
    }

    /// A number of 32 bits would round the counts of a travel until both are the same.
    #[test]
    fn values_that_differ_are_told_apart() {
        let counts = |whole: i64| whole << 24;
        for (expected, actual, text) in [
            (
                counts(2_147_483_600),
                counts(2_147_483_601),
                "expected 2147483600 counts, got 2147483601 counts",
            ),
            (
                counts(-16_777_217),
                counts(-16_777_218),
                "expected -16777217 counts, got -16777218 counts",
            ),
            (
                counts(100_000_000),
                counts(100_000_000) + (1 << 23),
                "expected 100000000 counts, got 100000000.5 counts",
            ),
            (
                counts(i64::from(i32::MAX)),
                counts(i64::from(i32::MAX)) + 1,
                "expected 2147483647 counts, got 2147483647.00000006 counts",
            ),
            (
                counts(1),
                counts(1) + 1,
                "expected 1 counts, got 1.00000006 counts",
            ),
            (-1, 0, "expected -0.000000059604645 counts, got 0 counts"),
            (
                i64::MIN,
                i64::MAX,
                "expected -549755813888 counts, got 549755813887.99999994 counts",
            ),
        ] {
            let told = Reason::Travel.at(0, expected, actual).to_string();
            assert!(told.contains(text), "{told}");
        }
        // What is a number of 32 bits is told as short as it is.
        let velocity = (163.84_f32 * Position::UNITS as f32) as i64;
        let told = Reason::Velocity.at(0, velocity, velocity).to_string();
        assert!(told.contains("expected 163.84 counts per cycle"), "{told}");
        let cycles = 10_000_i64 << 32;
        let told = Reason::Close.because(cycles, cycles + 1).to_string();
        assert!(
            told.contains("expected 10000 cycles, got 10000.0000000002 cycles"),
            "{told}"
        );
    }

    #[test]
    fn a_refusal_says_what_to_do() {
        assert_eq!(
            Reason::Velocity.at(2, 3 << 23, 2 << 24).to_string(),
            "refusal 8: axis 2: too fast: expected 1.5 counts per cycle, got 2 counts per cycle; give the segment more time"
        );
        assert_eq!(
            Reason::StopInput.plain().to_string(),
            "refusal 25: the stop circuit is open; close it at the machine"
        );
        let (off, none) = (BoardState::Off as i64, BoardState::NoSettings as i64);
        assert_eq!(
            Reason::NotReady.because(off, none).to_string(),
            "refusal 28: the board is in another state: expected 'off', got 'no settings'; read its state"
        );
        assert_eq!(
            Reason::NotReady.plain().to_string(),
            "refusal 28: the board is in another state; read its state"
        );
        let faulted = BoardState::Faulted as i64;
        assert_eq!(
            Reason::Faulted.because(off, faulted).to_string(),
            "refusal 27: the axis has a fault: expected 'off', got 'faulted'; read it, remove its cause, clear it"
        );
        assert_eq!(
            Reason::Faulted.at(1, 0, 105).to_string(),
            "refusal 27: axis 1: the axis has a fault: expected 0, got 105; read it, remove its cause, clear it"
        );
        let unknown = Refused {
            number: 999,
            axis: None,
            expected: 1,
            actual: 2,
        };
        assert_eq!(unknown.reason(), None);
        assert!(
            unknown
                .to_string()
                .ends_with("does not know: expected 1, got 2")
        );
    }
}
