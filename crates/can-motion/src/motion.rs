//! A motion that is known beforehand: keyframes, and from one to the next a minimum-jerk move at rest on both ends.
//!
//! The profile is the quintic `10 u^3 - 15 u^4 + 6 u^5` of the elapsed share `u`: velocity and acceleration are zero at
//! both keyframes, and all axes keep the ratio of their distances, so they move on a straight line. Computed with
//! integers alone: no rounding error of a floating-point unit, the same set-points on every machine.

use core::fmt;

/// Bits of the elapsed share `u` of a move. A move of `u32::MAX` milliseconds is below 2^42 us, so with 22 bits more it
/// still fits 64: 0.24 us of resolution in a move of one second, less than a 1 kHz cycle up to 70 minutes.
const SHARE_BITS: u32 = 22;
/// Bits of the profile, chosen so that its product with a distance below 2^32 fits 64.
const PROFILE_BITS: u32 = 31;

const US_PER_MS: u64 = 1_000;

/// Where all axes shall be at one moment, and at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Keyframe<const N: usize> {
    /// Time since the start of the motion in milliseconds.
    pub at_ms: u32,
    /// Distance of each axis from where it stood at the start, in command counts.
    pub positions_counts: [i32; N],
}

/// Keyframes that make no motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MotionError {
    /// There is no keyframe.
    Empty,
    /// The motion starts at time 0, the first keyframe does not.
    StartTime {
        /// The time of the first keyframe.
        actual_ms: u32,
    },
    /// The motion starts where the axes stand, which is distance 0; the first keyframe is elsewhere.
    StartPosition {
        /// The axis.
        axis: usize,
        /// Its distance in the first keyframe.
        actual_counts: i32,
    },
    /// A keyframe is not later than the one before it.
    Order {
        /// The keyframe, counted from 0.
        keyframe: usize,
        /// The time of the one before it.
        after_ms: u32,
        /// Its time.
        actual_ms: u32,
    },
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("a motion needs at least one keyframe"),
            Self::StartTime { actual_ms } => {
                write!(
                    f,
                    "the first keyframe must be at 0 ms, it is at {actual_ms} ms"
                )
            }
            Self::StartPosition {
                axis,
                actual_counts,
            } => write!(
                f,
                "distances count from where the motion starts: axis {axis} must be at 0 in the first keyframe, it is at {actual_counts}"
            ),
            Self::Order {
                keyframe,
                after_ms,
                actual_ms,
            } => write!(
                f,
                "keyframe {keyframe} must be later than {after_ms} ms, it is at {actual_ms} ms"
            ),
        }
    }
}

impl core::error::Error for MotionError {}

/// A motion of `N` axes along keyframes, relative to where the axes stand when it starts.
///
/// Between two keyframes an axis moves in one direction and goes no further than the second one. Its highest velocity,
/// in the middle, is 15/8 of the mean one, see [`Self::peak_step_counts`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KeyframeMotion<'a, const N: usize> {
    keyframes: &'a [Keyframe<N>],
}

impl<'a, const N: usize> KeyframeMotion<'a, N> {
    /// A motion along these keyframes; in a constant a mistake stops the build.
    ///
    /// # Errors
    /// [`MotionError`] unless the first keyframe is at time 0 and distance 0 and each other one is later than the one
    /// before it.
    pub const fn new(keyframes: &'a [Keyframe<N>]) -> Result<Self, MotionError> {
        let [first, later @ ..] = keyframes else {
            return Err(MotionError::Empty);
        };
        if first.at_ms != 0 {
            return Err(MotionError::StartTime {
                actual_ms: first.at_ms,
            });
        }
        if let Some((axis, actual_counts)) = first_not_zero(&first.positions_counts) {
            return Err(MotionError::StartPosition {
                axis,
                actual_counts,
            });
        }
        let (mut before, mut rest, mut keyframe) = (first, later, 1);
        while let [next, after @ ..] = rest {
            if next.at_ms <= before.at_ms {
                return Err(MotionError::Order {
                    keyframe,
                    after_ms: before.at_ms,
                    actual_ms: next.at_ms,
                });
            }
            (before, rest, keyframe) = (next, after, keyframe + 1);
        }
        Ok(Self { keyframes })
    }

    /// Time of the last keyframe in microseconds.
    #[must_use]
    pub const fn duration_us(&self) -> u64 {
        match self.keyframes {
            [.., last] => last.at_ms as u64 * US_PER_MS,
            [] => 0,
        }
    }

    /// Distance of each axis from where it stood at the start, in command counts, `time_us` after the start; the last
    /// keyframe afterwards. Exact at each keyframe, in between within one count for moves below 2^20 counts and within
    /// 2^-20 of the distance for longer ones.
    #[must_use]
    pub fn position(&self, time_us: u64) -> [i32; N] {
        let reached = |keyframe: &Keyframe<N>| u64::from(keyframe.at_ms) * US_PER_MS <= time_us;
        let next = self.keyframes.partition_point(reached);
        let from = next
            .checked_sub(1)
            .and_then(|place| self.keyframes.get(place));
        match (from, self.keyframes.get(next)) {
            (Some(from), Some(to)) => between(from, to, time_us),
            (Some(last), None) => last.positions_counts,
            // `new` has made sure of a keyframe at time 0.
            (None, _) => [0; N],
        }
    }

    /// Upper bound of the largest step of each axis from one cycle to the next, in command counts: 15/8 of the mean
    /// velocity of its fastest move, rounded up, and the rounding of [`Self::position`]. To compare with `Limits::max_step`.
    #[must_use]
    pub const fn peak_step_counts(&self, cycle_us: u32) -> [u64; N] {
        let mut peaks = [0; N];
        let mut rest = self.keyframes;
        while let [from, after @ ..] = rest {
            if let [to, ..] = after {
                let mut axis = 0;
                while axis < N {
                    let peak = peak_step(from, to, axis, cycle_us);
                    if peak > peaks[axis] {
                        peaks[axis] = peak;
                    }
                    axis += 1;
                }
            }
            rest = after;
        }
        peaks
    }
}

const fn first_not_zero(counts: &[i32]) -> Option<(usize, i32)> {
    let (mut rest, mut place) = (counts, 0);
    while let [first, after @ ..] = rest {
        if *first != 0 {
            return Some((place, *first));
        }
        (rest, place) = (after, place + 1);
    }
    None
}

/// `axis` must be below `N`.
const fn peak_step<const N: usize>(
    from: &Keyframe<N>,
    to: &Keyframe<N>,
    axis: usize,
    cycle_us: u32,
) -> u64 {
    let distance = from.positions_counts[axis].abs_diff(to.positions_counts[axis]) as u64;
    let duration_us = to.at_ms.saturating_sub(from.at_ms) as u64 * US_PER_MS;
    if distance == 0 || duration_us == 0 {
        return 0;
    }
    let travelled = (15 * distance).saturating_mul(cycle_us as u64);
    // One count from rounding, and less than one unit of the share, of which each is at most 15/8 of the distance.
    travelled.div_ceil(8 * duration_us) + 1 + (distance >> (SHARE_BITS - 1))
}

/// The position on the way between two keyframes.
fn between<const N: usize>(from: &Keyframe<N>, to: &Keyframe<N>, time_us: u64) -> [i32; N] {
    let start_us = u64::from(from.at_ms) * US_PER_MS;
    let duration_us = u64::from(to.at_ms.saturating_sub(from.at_ms)) * US_PER_MS;
    let elapsed_us = time_us.saturating_sub(start_us).min(duration_us);
    // The times ascend, so the duration is never zero.
    let share = (elapsed_us << SHARE_BITS)
        .checked_div(duration_us)
        .unwrap_or(0);
    let profile = profile(share);
    let mut counts = from.positions_counts;
    for (start, end) in counts.iter_mut().zip(to.positions_counts) {
        *start = along(*start, end, profile);
    }
    counts
}

/// `10 u^3 - 15 u^4 + 6 u^5` for a share with [`SHARE_BITS`], with [`PROFILE_BITS`].
///
/// The polynomial is computed without any rounding, in 110 bits, and rounded down once. That makes the result
/// monotone, which rounding in each step would not: near the ends its noise is larger than the slope.
fn profile(share: u64) -> u64 {
    const ONE: u64 = 1 << SHARE_BITS;
    let square = share * share;
    // 10 - 15 u + 6 u^2, which is 10 at the start and falls to 1, in twice as many bits.
    let factor = 10 * ONE * ONE + 6 * square - 15 * ONE * share;
    let exact = u128::from(square) * u128::from(share) * u128::from(factor);
    (exact >> (5 * SHARE_BITS - PROFILE_BITS)) as u64
}

/// The position that lies the share `profile` of the way from `start` to `end`, rounded to the nearest count.
fn along(start: i32, end: i32, profile: u64) -> i32 {
    const HALF: u64 = 1 << (PROFILE_BITS - 1);
    let travelled = (u64::from(start.abs_diff(end)) * profile + HALF) >> PROFILE_BITS;
    // Not more than the distance, so the sum lies between two 32-bit numbers.
    if end < start {
        (i64::from(start) - travelled as i64) as i32
    } else {
        (i64::from(start) + travelled as i64) as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const fn keyframe(at_ms: u32, counts: i32) -> Keyframe<1> {
        Keyframe {
            at_ms,
            positions_counts: [counts],
        }
    }

    const THERE_AND_BACK: [Keyframe<2>; 4] = [
        Keyframe {
            at_ms: 0,
            positions_counts: [0, 0],
        },
        Keyframe {
            at_ms: 1_000,
            positions_counts: [16_000, -8_000],
        },
        Keyframe {
            at_ms: 1_500,
            positions_counts: [16_000, -8_000],
        },
        Keyframe {
            at_ms: 3_500,
            positions_counts: [0, 0],
        },
    ];

    #[test]
    fn keyframes_are_met_exactly_and_the_last_one_stays() {
        let motion = KeyframeMotion::new(&THERE_AND_BACK).unwrap();
        assert_eq!(motion.position(0), [0, 0]);
        assert_eq!(motion.position(1_000_000), [16_000, -8_000]);
        assert_eq!(motion.position(1_250_000), [16_000, -8_000]);
        assert_eq!(motion.position(3_500_000), [0, 0]);
        assert_eq!(motion.position(u64::MAX), [0, 0]);
        assert_eq!(motion.duration_us(), 3_500_000);
    }

    #[test]
    fn the_way_is_the_minimum_jerk_profile() {
        let motion = KeyframeMotion::new(&THERE_AND_BACK).unwrap();
        // 10 u^3 - 15 u^4 + 6 u^5 by hand: 0.1035156 at 1/4, 1/2 at 1/2, 0.8964844 at 3/4.
        assert_eq!(motion.position(250_000), [1_656, -828]);
        assert_eq!(motion.position(500_000), [8_000, -4_000]);
        assert_eq!(motion.position(750_000), [14_344, -7_172]);
        assert_eq!(motion.position(2_500_000), [8_000, -4_000]);
    }

    #[test]
    fn the_peak_step_is_15_eighths_of_the_mean() {
        const MOTION: KeyframeMotion<'static, 2> = match KeyframeMotion::new(&THERE_AND_BACK) {
            Ok(motion) => motion,
            Err(_) => panic!("the keyframes make no motion"),
        };
        const PEAKS: [u64; 2] = MOTION.peak_step_counts(1_000);
        // 16 and 8 counts a cycle on average.
        assert_eq!(PEAKS, [31, 16]);
        let at_the_middle: Vec<_> = (495..505)
            .map(|ms| MOTION.position(ms * 1_000 + 1_000)[0] - MOTION.position(ms * 1_000)[0])
            .collect();
        assert!(at_the_middle.contains(&30), "{at_the_middle:?}");
    }

    #[test]
    fn keyframes_that_make_no_motion_are_refused() {
        let refused = |keyframes: &[Keyframe<1>]| KeyframeMotion::new(keyframes).unwrap_err();
        assert_eq!(refused(&[]), MotionError::Empty);
        assert_eq!(
            refused(&[keyframe(1, 0)]),
            MotionError::StartTime { actual_ms: 1 }
        );
        assert_eq!(
            refused(&[keyframe(0, 7)]),
            MotionError::StartPosition {
                axis: 0,
                actual_counts: 7
            }
        );
        for actual_ms in [4, 5] {
            assert_eq!(
                refused(&[keyframe(0, 0), keyframe(5, 1), keyframe(actual_ms, 2)]),
                MotionError::Order {
                    keyframe: 2,
                    after_ms: 5,
                    actual_ms
                }
            );
        }
    }

    #[test]
    fn the_longest_and_widest_move_stays_in_range() {
        let keyframes = [
            keyframe(0, 0),
            keyframe(1, i32::MIN),
            keyframe(u32::MAX, i32::MAX),
        ];
        let motion = KeyframeMotion::new(&keyframes).unwrap();
        let duration_us = motion.duration_us();
        assert_eq!(motion.position(1_000), [i32::MIN]);
        assert_eq!(motion.position(duration_us), [i32::MAX]);
        let middle = motion.position(duration_us / 2 + 500)[0];
        assert!(middle.abs() < 4_096, "{middle}");
        assert!(motion.position(duration_us - 1)[0] > i32::MAX - 4);
    }

    fn keyframes() -> impl Strategy<Value = Vec<Keyframe<2>>> {
        let step = (1..100_000_u32, any::<i32>(), -1_000..1_000_i32);
        proptest::collection::vec(step, 0..6).prop_map(|steps| {
            let mut keyframes = Vec::from([Keyframe {
                at_ms: 0,
                positions_counts: [0; 2],
            }]);
            let mut at_ms = 0;
            for (duration_ms, wide, narrow) in steps {
                at_ms += duration_ms;
                keyframes.push(Keyframe {
                    at_ms,
                    positions_counts: [wide, narrow],
                });
            }
            keyframes
        })
    }

    fn profile_in_floating_point(u: f64) -> f64 {
        u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
    }

    proptest! {
        #[test]
        fn every_keyframe_is_met_exactly(keyframes in keyframes()) {
            let motion = KeyframeMotion::new(&keyframes).unwrap();
            for keyframe in &keyframes {
                let position = motion.position(u64::from(keyframe.at_ms) * 1_000);
                prop_assert_eq!(position, keyframe.positions_counts);
            }
        }

        /// From one moment to any later one of the same move an axis never turns round, and never leaves the move.
        #[test]
        fn between_two_keyframes_an_axis_goes_one_way(
            duration_ms in 1..=u32::MAX,
            end in any::<i32>(),
            at in any::<u64>(),
            later_us in 0..3_000_u64,
        ) {
            let keyframes = [keyframe(0, 0), keyframe(duration_ms, end)];
            let motion = KeyframeMotion::new(&keyframes).unwrap();
            let at_us = at % motion.duration_us();
            let [first] = motion.position(at_us);
            let [second] = motion.position(at_us + later_us);
            let (first, second, end) = if end < 0 { (-i64::from(first), -i64::from(second), -i64::from(end)) }
                else { (i64::from(first), i64::from(second), i64::from(end)) };
            prop_assert!(0 <= first && first <= second && second <= end, "{first} {second} {end}");
        }

        /// Near both ends, where the slope is smallest and noise would show first.
        #[test]
        fn the_profile_is_monotone_at_its_ends(offset in 0..(1_u64 << (SHARE_BITS - 6))) {
            let end = 1 << SHARE_BITS;
            prop_assert!(profile(offset) <= profile(offset + 1));
            prop_assert!(profile(end - offset - 1) <= profile(end - offset));
            prop_assert!(profile(end - offset) <= 1 << PROFILE_BITS);
        }

        #[test]
        fn the_position_is_the_profile_within_a_count(
            duration_ms in 1..4_000_u32,
            end in -(1_i32 << 20)..(1 << 20),
            at in any::<u64>(),
        ) {
            let keyframes = [keyframe(0, 0), keyframe(duration_ms, end)];
            let motion = KeyframeMotion::new(&keyframes).unwrap();
            let at_us = at % motion.duration_us();
            let share = at_us as f64 / motion.duration_us() as f64;
            let expected = f64::from(end) * profile_in_floating_point(share);
            let actual = f64::from(motion.position(at_us)[0]);
            prop_assert!((actual - expected).abs() <= 1.0, "{actual} {expected}");
        }

        #[test]
        fn no_step_is_larger_than_the_peak(
            duration_ms in 1..100_000_u32,
            end in any::<i32>(),
            at in any::<u64>(),
            cycle_us in 250..10_000_u32,
        ) {
            let keyframes = [keyframe(0, 0), keyframe(duration_ms, end)];
            let motion = KeyframeMotion::new(&keyframes).unwrap();
            let at_us = at % motion.duration_us();
            let [first] = motion.position(at_us);
            let [second] = motion.position(at_us + u64::from(cycle_us));
            let [peak] = motion.peak_step_counts(cycle_us);
            prop_assert!(u64::from(first.abs_diff(second)) <= peak, "{first} {second} {peak}");
        }
    }
}
