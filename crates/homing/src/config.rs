//! What a user decides, and what cannot work.

use trajectory::Limits;

/// The way in which positions grow or shrink.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Direction {
    /// Towards larger counts.
    Positive,
    /// Towards smaller counts.
    Negative,
}

impl Direction {
    /// 1 or -1.
    #[must_use]
    pub const fn sign(self) -> i32 {
        match self {
            Self::Positive => 1,
            Self::Negative => -1,
        }
    }
}

/// A level of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Level {
    /// A normally closed switch that pulls down, for instance.
    Low,
    /// A normally open switch that pulls up, for instance.
    High,
}

/// A hard stop, found by the torque of the motor and by its following error together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HardStop {
    /// Where it is.
    pub direction: Direction,
    /// Torque of a contact in thousandths of the peak, 1 ..= 1000: more than the axis needs to move, less than its mechanics bear.
    pub contact_permille: u16,
    /// Torque that no other thing than a contact may cause, from the contact ..= 1000.
    pub most_permille: u16,
    /// Following error of a contact in counts, 1 or more: more than the lag while the axis moves.
    pub contact_counts: u32,
    /// Following error that ends the search, more than that of a contact.
    pub most_counts: u32,
    /// By how much the two contacts, the fast and the slow one, may differ.
    pub repeat_counts: u32,
}

/// A switch beside the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Switch {
    /// The way on which it becomes operated.
    pub direction: Direction,
    /// Its level while it is operated.
    pub operated: Level,
    /// Following error that ends the search: something else is in the way.
    pub most_counts: u32,
    /// Torque that ends the search, in thousandths of the peak; `None` where the torque is not read.
    pub most_permille: Option<u16>,
}

/// How the reference is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// The axis stands at its reference: nothing moves.
    Here,
    /// The reference is a hard stop.
    HardStop(HardStop),
    /// The reference is the edge of a switch.
    Switch(Switch),
}

impl Method {
    /// The way of the search; `None` where nothing moves.
    #[must_use]
    pub const fn direction(&self) -> Option<Direction> {
        match self {
            Self::Here => None,
            Self::HardStop(stop) => Some(stop.direction),
            Self::Switch(switch) => Some(switch.direction),
        }
    }
}

/// Where an axis may be, in its own counts, the ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Travel {
    /// The smallest position.
    pub min_counts: i32,
    /// The largest position.
    pub max_counts: i32,
}

impl Travel {
    /// Whether a position is inside.
    #[must_use]
    pub const fn contains(&self, counts: i64) -> bool {
        self.min_counts as i64 <= counts && counts <= self.max_counts as i64
    }
}

/// How closely the axis is watched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Watch {
    /// A reading of torque, position or switch that is older ends the search, in microseconds. At least two periods of the polls.
    pub max_age_us: u32,
    /// Time for the axis to come to rest, at the start and after a move, in microseconds.
    pub settle_us: u32,
    /// By how much the position may be off, or change, at rest.
    pub still_counts: u32,
}

impl Watch {
    /// Readings of at most 100 ms, a second to come to rest, 16 counts.
    pub const DEFAULT: Self = Self {
        max_age_us: 100_000,
        settle_us: 1_000_000,
        still_counts: 16,
    };
}

/// One homing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// How the reference is found.
    pub method: Method,
    /// Time from one call of [`Homing::cycle`](crate::Homing::cycle) to the next in microseconds, which is the cycle of `search` and `slow`.
    pub cycle_us: u32,
    /// Limits of the search and of every way back.
    pub search: Limits,
    /// Limits of the second approach, not faster.
    pub slow: Limits,
    /// The farthest that the search goes from where it starts, in counts, 1 or more.
    pub way_counts: u32,
    /// How far the axis backs off from the reference, in counts, 1 ..= the way of the search.
    pub back_off_counts: u32,
    /// The position of the reference in the counts of the axis.
    pub reference_counts: i32,
    /// Where the axis may be from then on. The reference less the way back must be inside.
    pub travel: Travel,
    /// How closely the axis is watched.
    pub watch: Watch,
}

/// A homing that is not begun.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// A number is outside its range.
    #[error("{what} must be {min}..={max}, it is {actual}")]
    Range {
        /// What it is, with its unit.
        what: &'static str,
        /// The smallest value.
        min: u32,
        /// The largest value.
        max: u32,
        /// The value that was given.
        actual: u32,
    },
    /// The second approach is faster than the search.
    #[error(
        "the second approach must not be faster than the search, {most} counts per cycle, it is {actual}"
    )]
    SlowIsFaster {
        /// Speed of the search, in counts per cycle.
        most: f32,
        /// Speed of the second approach.
        actual: f32,
    },
    /// Until a contact is seen, the following error would grow beyond its limit.
    #[error(
        "the search must be slower than {most} counts per cycle, so that a contact is seen within two readings before the following error is at its limit; it is {actual}"
    )]
    TooFast {
        /// The fastest search, in counts per cycle.
        most: f32,
        /// The speed that was given.
        actual: f32,
    },
    /// The axis would come to rest outside its travel.
    #[error(
        "the axis comes to rest at {actual}, which must be within its travel, {min}..={max} counts"
    )]
    RestOutsideTravel {
        /// The smallest position.
        min: i32,
        /// The largest position.
        max: i32,
        /// Where it would rest, in the counts of the axis.
        actual: i64,
    },
    /// The zero of the axis may be where no drive can count.
    #[error(
        "the reference may be found where the zero of the axis is at {actual} counts of the drive, which are more than 32 bits: choose another position of the reference"
    )]
    OriginTooFar {
        /// Where the drive would report the zero.
        actual: i64,
    },
    /// The way of the search leaves 32 bit.
    #[error("the search may lead to {actual} counts, which are more than 32 bits")]
    WayTooFar {
        /// Where it would lead.
        actual: i64,
    },
}

impl Config {
    /// Checks what can be checked before anything moves.
    ///
    /// # Errors
    /// [`Refusal`] with what is expected.
    pub fn check(&self) -> Result<(), Refusal> {
        let range = |what, actual: u32, min: u32, max: u32| {
            if (min..=max).contains(&actual) {
                return Ok(());
            }
            Err(Refusal::Range {
                what,
                min,
                max,
                actual,
            })
        };
        range("the cycle in microseconds", self.cycle_us, 1, 1_000_000)?;
        range(
            "the age of readings in microseconds",
            self.watch.max_age_us,
            self.cycle_us,
            10_000_000,
        )?;
        range(
            "the time to settle in microseconds",
            self.watch.settle_us,
            self.cycle_us,
            60_000_000,
        )?;
        if self.method != Method::Here {
            range(
                "the way of the search in counts",
                self.way_counts,
                1,
                i32::MAX.unsigned_abs(),
            )?;
            range(
                "the way back in counts",
                self.back_off_counts,
                1,
                self.way_counts,
            )?;
        }
        match self.method {
            Method::Here => {}
            Method::HardStop(stop) => {
                range(
                    "the torque of a contact in thousandths",
                    stop.contact_permille.into(),
                    1,
                    1_000,
                )?;
                range(
                    "the highest torque in thousandths",
                    stop.most_permille.into(),
                    stop.contact_permille.into(),
                    1_000,
                )?;
                let most = stop.most_counts;
                range(
                    "the following error of a contact in counts",
                    stop.contact_counts,
                    1,
                    most.saturating_sub(1),
                )?;
                self.check_speeds()?;
                self.check_search(stop.most_counts - stop.contact_counts)?;
            }
            Method::Switch(switch) => {
                range(
                    "the following error limit in counts",
                    switch.most_counts,
                    1,
                    i32::MAX.unsigned_abs(),
                )?;
                if let Some(most) = switch.most_permille {
                    range("the highest torque in thousandths", most.into(), 1, 1_000)?;
                }
                self.check_speeds()?;
            }
        }
        self.check_rest()
    }

    fn check_speeds(&self) -> Result<(), Refusal> {
        let (search, slow) = (self.search.velocity(), self.slow.velocity());
        if slow > search {
            return Err(Refusal::SlowIsFaster {
                most: search,
                actual: slow,
            });
        }
        Ok(())
    }

    /// Whether the following error stays below its limit until two readings have shown a contact.
    fn check_search(&self, room_counts: u32) -> Result<(), Refusal> {
        let search = self.search.velocity();
        let cycles = 2.0 * self.watch.max_age_us as f32 / self.cycle_us as f32;
        let most = room_counts as f32 / cycles;
        if search > most {
            return Err(Refusal::TooFast {
                most,
                actual: search,
            });
        }
        Ok(())
    }

    fn check_rest(&self) -> Result<(), Refusal> {
        let back = match self.method.direction() {
            Some(direction) => i64::from(direction.sign()) * i64::from(self.back_off_counts),
            None => 0,
        };
        let rest = i64::from(self.reference_counts) - back;
        if !self.travel.contains(rest) {
            return Err(Refusal::RestOutsideTravel {
                min: self.travel.min_counts,
                max: self.travel.max_counts,
                actual: rest,
            });
        }
        Ok(())
    }

    /// The ends of the way that the search may go from here, for the limits of the master.
    ///
    /// # Errors
    /// [`Refusal::WayTooFar`].
    pub fn reach(&self, start_counts: i32) -> Result<Travel, Refusal> {
        let searched = i64::from(self.way_counts) + i64::from(self.back_off_counts);
        let way = match self.method {
            // Nothing moves.
            Method::Here => 0,
            Method::HardStop(stop) => searched + i64::from(stop.most_counts),
            Method::Switch(switch) => searched + i64::from(switch.most_counts),
        };
        let end = |actual: i64| i32::try_from(actual).map_err(|_| Refusal::WayTooFar { actual });
        Ok(Travel {
            min_counts: end(i64::from(start_counts) - way)?,
            max_counts: end(i64::from(start_counts) + way)?,
        })
    }
    /// Whether a drive can count to the zero of the axis, wherever on its way the reference is found.
    pub(crate) fn check_origin(&self, reach: Travel) -> Result<(), Refusal> {
        for found in [reach.min_counts, reach.max_counts] {
            let actual = i64::from(found) - i64::from(self.reference_counts);
            if i32::try_from(actual).is_err() {
                return Err(Refusal::OriginTooFar { actual });
            }
        }
        Ok(())
    }
}
