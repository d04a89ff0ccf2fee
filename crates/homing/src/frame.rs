//! The counts of an axis and those of its drive.

use crate::config::Travel;

/// The software origin of an axis with its travel: the drive knows nothing of either.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame {
    origin_counts: i32,
    travel: Travel,
}

/// A position outside the travel of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("a position must be {min_counts}..={max_counts} counts, it is {actual_counts}")]
pub struct OutsideTravel {
    /// The smallest position.
    pub min_counts: i32,
    /// The largest position.
    pub max_counts: i32,
    /// The position that was given, in the counts of the axis.
    pub actual_counts: i64,
}

impl Frame {
    /// An axis whose zero is where its drive reports `origin_counts`.
    #[must_use]
    pub const fn new(origin_counts: i32, travel: Travel) -> Self {
        Self {
            origin_counts,
            travel,
        }
    }

    /// What the drive reports at the zero of the axis.
    #[must_use]
    pub const fn origin_counts(&self) -> i32 {
        self.origin_counts
    }

    /// Where the axis may be.
    #[must_use]
    pub const fn travel(&self) -> Travel {
        self.travel
    }

    /// The position of the drive for a position of the axis.
    ///
    /// # Errors
    /// [`OutsideTravel`]; also where the drive cannot count so far.
    pub const fn to_drive(&self, axis_counts: i32) -> Result<i32, OutsideTravel> {
        let drive = axis_counts as i64 + self.origin_counts as i64;
        let fits = drive >= i32::MIN as i64 && drive <= i32::MAX as i64;
        if !self.travel.contains(axis_counts as i64) || !fits {
            return Err(self.outside(axis_counts as i64));
        }
        Ok(drive as i32)
    }

    /// The position of the axis for a position of the drive, inside or outside the travel.
    #[must_use]
    pub const fn to_axis(&self, drive_counts: i32) -> i64 {
        drive_counts as i64 - self.origin_counts as i64
    }

    /// The same where the axis must be inside.
    ///
    /// # Errors
    /// [`OutsideTravel`].
    pub const fn to_axis_inside(&self, drive_counts: i32) -> Result<i32, OutsideTravel> {
        let axis = self.to_axis(drive_counts);
        if !self.travel.contains(axis) {
            return Err(self.outside(axis));
        }
        // The travel has 32 bits.
        Ok(axis as i32)
    }

    /// The travel in the counts of the drive, for the limits of its master. An end that the drive cannot count is the end of 32 bit.
    #[must_use]
    pub const fn travel_of_drive(&self) -> Travel {
        Travel {
            min_counts: self.travel.min_counts.saturating_add(self.origin_counts),
            max_counts: self.travel.max_counts.saturating_add(self.origin_counts),
        }
    }

    /// The same axis after its drive took another zero of its own: a shaft that stood still was reported at `before_counts`, and is at
    /// `after_counts` now.
    #[must_use]
    pub const fn with_drive_zero(&self, before_counts: i32, after_counts: i32) -> Self {
        Self {
            origin_counts: self
                .origin_counts
                .wrapping_add(after_counts.wrapping_sub(before_counts)),
            travel: self.travel,
        }
    }

    const fn outside(&self, actual_counts: i64) -> OutsideTravel {
        OutsideTravel {
            min_counts: self.travel.min_counts,
            max_counts: self.travel.max_counts,
            actual_counts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame::new(
        -1_200,
        Travel {
            min_counts: -100,
            max_counts: 5_000,
        },
    );

    #[test]
    fn positions_of_axis_and_drive_belong_together() {
        assert_eq!(FRAME.to_drive(0), Ok(-1_200));
        assert_eq!(FRAME.to_drive(-100), Ok(-1_300));
        assert_eq!(FRAME.to_axis(-1_200), 0);
        assert_eq!(FRAME.to_axis_inside(3_800), Ok(5_000));
        let travel = FRAME.travel_of_drive();
        assert_eq!((travel.min_counts, travel.max_counts), (-1_300, 3_800));
    }

    #[test]
    fn outside_the_travel_is_an_error_with_the_travel() {
        let error = FRAME.to_drive(5_001).unwrap_err();
        assert_eq!(
            (error.min_counts, error.max_counts, error.actual_counts),
            (-100, 5_000, 5_001)
        );
        assert!(FRAME.to_drive(-101).is_err());
        assert!(FRAME.to_axis_inside(-1_301).is_err());
        let far = Frame::new(
            i32::MAX,
            Travel {
                min_counts: 0,
                max_counts: 10,
            },
        );
        assert!(far.to_drive(1).is_err());
    }

    #[test]
    fn another_zero_of_the_drive_moves_no_axis() {
        let moved = FRAME.with_drive_zero(-700, 0);
        assert_eq!(moved.to_axis(0), FRAME.to_axis(-700));
        assert_eq!(moved.travel(), FRAME.travel());
    }
}
