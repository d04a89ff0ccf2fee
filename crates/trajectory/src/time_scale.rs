//! Override, pause and resume: the time of a trajectory runs faster or slower than that of the cycles.

use core::fmt;

use crate::fixed;
use crate::quantity::Time;

/// Bits behind the point of a rate.
const RATE_BITS: u32 = 30;
const ONE: u32 = 1 << RATE_BITS;

/// The time of a trajectory, which runs at 0 to 2 times the time of the cycles.
///
/// Any trajectory that is a function of time can be slowed down, paused, resumed and sped up by asking it for the position at
/// [`TimeScale::advance`] instead of the time of the cycle. The path stays the same, and axes that share the time stay on it together.
/// The first derivative of the time, its rate, is 0 to 2, and the second one at most the change that [`TimeScale::new`] is given: a
/// velocity `v` and an acceleration `a` of the trajectory become `rate * v` and `rate² * a + change * v`.
///
/// 24 bytes; a cycle costs about 20 instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeScale {
    time: Time,
    rate: u32,
    /// The rate that it has when it is not paused.
    override_rate: u32,
    is_paused: bool,
    change: u32,
}

/// A rate or a change outside its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TimeScaleError {
    /// An override above 200 %.
    Override {
        /// The override that was asked for.
        actual_percent: u16,
    },
    /// From rate 0 to rate 1 in no cycle at all.
    Change,
}

impl fmt::Display for TimeScaleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Override { actual_percent } => {
                write!(f, "an override is 0 to 200 %, not {actual_percent} %")
            }
            Self::Change => f.write_str("a rate needs at least one cycle to change"),
        }
    }
}

impl core::error::Error for TimeScaleError {}

impl TimeScale {
    /// Largest override in percent.
    pub const MOST_PERCENT: u16 = 200;

    /// Time 0, standing still; [`Self::resume`] starts it. From standing still to the rate of the cycles and back it takes this many
    /// cycles. With at least `velocity / acceleration` cycles no pause needs more than the acceleration.
    ///
    /// # Errors
    /// [`TimeScaleError::Change`] for 0 cycles.
    pub const fn new(cycles: u32) -> Result<Self, TimeScaleError> {
        let (Some(whole), Some(rest)) = (ONE.checked_div(cycles), ONE.checked_rem(cycles)) else {
            return Err(TimeScaleError::Change);
        };
        Ok(Self {
            time: Time::ZERO,
            rate: 0,
            override_rate: ONE,
            is_paused: true,
            // Rounded up, so that the last cycle ends it.
            change: whole + (rest != 0) as u32,
        })
    }

    /// Time 0, running at the rate of the cycles.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub const fn running(cycles: u32) -> Result<Self, TimeScaleError> {
        match Self::new(cycles) {
            Ok(scale) => Ok(Self {
                rate: ONE,
                is_paused: false,
                ..scale
            }),
            error => error,
        }
    }

    /// Changes the rate to this share of the time of the cycles; while it is paused, the rate that it resumes with.
    ///
    /// # Errors
    /// [`TimeScaleError::Override`] above 200 %.
    pub const fn set_override(&mut self, percent: u16) -> Result<(), TimeScaleError> {
        if percent > Self::MOST_PERCENT {
            return Err(TimeScaleError::Override {
                actual_percent: percent,
            });
        }
        self.override_rate = (percent as u64 * ONE as u64 / 100) as u32;
        Ok(())
    }

    /// Slows down to a standstill.
    pub const fn pause(&mut self) {
        self.is_paused = true;
    }

    /// Runs on.
    pub const fn resume(&mut self) {
        self.is_paused = false;
    }

    /// One cycle later: returns the time of the trajectory.
    pub const fn advance(&mut self) -> Time {
        self.advance_by_at_most(self.change)
    }

    /// The same where the axes have no more than this left for the change of the rate in this cycle: what the limit leaves of the
    /// acceleration of the trajectory, divided by its velocity. What is no number leaves nothing.
    pub fn advance_within(&mut self, change: f32) -> Time {
        // A conversion ends at the range, and makes 0 of what is no number.
        let most = (change * ONE as f32) as u32;
        self.advance_by_at_most(if most < self.change {
            most
        } else {
            self.change
        })
    }

    const fn advance_by_at_most(&mut self, change: u32) -> Time {
        let before = self.rate;
        let goal = self.goal();
        self.rate = if before < goal {
            let raised = before.saturating_add(change);
            if raised < goal { raised } else { goal }
        } else {
            let lowered = before.saturating_sub(change);
            if lowered > goal { lowered } else { goal }
        };
        // The mean of both rates.
        let ticks = (before as u64 + self.rate as u64) << (fixed::TIME_BITS - RATE_BITS - 1);
        self.time = self.time.after(Time::from_ticks(ticks));
        self.time
    }

    /// The time of the trajectory.
    #[must_use]
    pub const fn time(&self) -> Time {
        self.time
    }

    /// Time of the trajectory in a cycle, 0 to 2.
    #[must_use]
    pub fn rate(&self) -> f32 {
        self.rate as f32 / ONE as f32
    }

    /// Whether it is paused and stands still.
    #[must_use]
    pub const fn is_standing(&self) -> bool {
        self.rate == 0 && self.goal() == 0
    }

    /// The time of the trajectory at which it would stand still if it were paused now.
    #[must_use]
    pub const fn time_if_paused(&self) -> Time {
        let (rate, change) = (self.rate as u64, self.change as u64);
        let (whole, rest) = match (rate.checked_div(change), rate.checked_rem(change)) {
            (Some(whole), Some(rest)) => (whole, rest),
            _ => (0, 0),
        };
        // Sum of the means: rate, then lower by the change each, until the last cycle that goes from the rest to zero.
        let doubled = whole * (rate + rest) + rest;
        let ticks = doubled << (fixed::TIME_BITS - RATE_BITS - 1);
        self.time.after(Time::from_ticks(ticks))
    }

    const fn goal(&self) -> u32 {
        if self.is_paused {
            0
        } else {
            self.override_rate
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: u64 = 1 << 32;

    fn running(cycles: u32) -> TimeScale {
        TimeScale::running(cycles).unwrap()
    }

    #[test]
    fn a_pause_slows_down_in_even_steps() {
        let mut scale = running(4);
        scale.pause();
        let expected = scale.time_if_paused();
        let times = [(); 5].map(|()| scale.advance().ticks());
        let eighth = CYCLE / 8;
        assert_eq!(
            times,
            [
                7 * eighth,
                12 * eighth,
                15 * eighth,
                16 * eighth,
                16 * eighth
            ]
        );
        assert_eq!(scale.time(), expected);
        assert!(scale.is_standing());
        scale.resume();
        assert!(!scale.is_standing());
        assert_eq!(scale.advance().ticks(), 17 * eighth);
        assert_eq!(scale.rate(), 0.25);
    }

    #[test]
    fn it_starts_standing() {
        let mut scale = TimeScale::new(2).unwrap();
        assert!(scale.is_standing());
        assert_eq!(scale.advance(), Time::ZERO);
        scale.resume();
        scale.advance();
        scale.advance();
        assert_eq!((scale.time().cycles(), scale.rate()), (1.0, 1.0));
        assert_eq!(scale.advance().cycles(), 2.0);
    }

    #[test]
    fn an_override_is_0_to_200_percent() {
        let mut scale = running(10);
        assert_eq!(
            scale.set_override(201),
            Err(TimeScaleError::Override {
                actual_percent: 201
            })
        );
        scale.set_override(200).unwrap();
        for _ in 0..10 {
            scale.advance();
        }
        assert!((scale.rate() - 2.0).abs() < 1e-6, "{}", scale.rate());
        let before = scale.time();
        assert!((scale.advance().since(before).cycles() - 2.0).abs() < 1e-6);
        scale.set_override(0).unwrap();
        for _ in 0..21 {
            scale.advance();
        }
        assert!(scale.is_standing());
        scale.set_override(50).unwrap();
        for _ in 0..6 {
            scale.advance();
        }
        assert_eq!(scale.rate(), 0.5);
    }

    #[test]
    fn a_cycle_changes_the_rate_by_no_more_than_is_left() {
        let mut scale = running(4);
        scale.pause();
        let mut rate_after = |left| {
            scale.advance_within(left);
            scale.rate()
        };
        assert_eq!(rate_after(0.125), 0.875);
        for nothing in [0.0, -1.0, f32::NAN] {
            assert_eq!(rate_after(nothing), 0.875);
        }
        for plenty in [0.25, f32::INFINITY] {
            let before = rate_after(0.0);
            assert_eq!(rate_after(plenty), before - 0.25);
        }
    }

    #[test]
    fn no_cycle_at_all_is_refused() {
        assert_eq!(TimeScale::new(0), Err(TimeScaleError::Change));
        assert_eq!(TimeScale::running(0), Err(TimeScaleError::Change));
        assert!(TimeScale::new(u32::MAX).is_ok());
        let mut slow = running(u32::MAX);
        slow.pause();
        slow.advance();
        assert!(slow.time() < Time::from_cycles(1));
    }

    /// Rate and its change stay in their bounds, and a pause ends where it was said, whatever is done in between.
    #[test]
    fn derivatives_are_bounded() {
        let mut state = 1_u32;
        let mut scale = running(37);
        let change = 1.0 / 37.0 + 1e-6;
        for cycle in 0..100_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match state >> 24 {
                0..4 => scale.pause(),
                4..8 => scale.resume(),
                8..12 => scale.set_override((state >> 8) as u16 % 201).unwrap(),
                // Another one in every cycle.
                _ if cycle > 50_000 => scale.set_override((state >> 8) as u16 % 201).unwrap(),
                _ => {}
            }
            let (time, rate) = (scale.time(), scale.rate());
            let step = scale.advance().since(time).cycles();
            assert!((0.0..=2.0).contains(&scale.rate()));
            assert!((scale.rate() - rate).abs() <= change);
            assert!((step - (scale.rate() + rate) / 2.0).abs() < 1e-5);
            let mut paused = scale;
            paused.pause();
            while !paused.is_standing() {
                paused.advance();
            }
            assert_eq!(paused.time(), scale.time_if_paused());
        }
    }

    #[test]
    fn errors_say_what_is_expected() {
        use std::string::ToString;
        let error = TimeScaleError::Override {
            actual_percent: 300,
        };
        assert_eq!(error.to_string(), "an override is 0 to 200 %, not 300 %");
        assert!(TimeScaleError::Change.to_string().contains("one cycle"));
    }
}
