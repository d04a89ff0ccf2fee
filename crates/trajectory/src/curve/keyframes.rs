//! A motion that is known beforehand: keyframes, and from one to the next a minimum-jerk move or, where velocities are given, a cubic.

use core::fmt;

use super::{Piece, Share};
use crate::fixed::part_of;
use crate::quantity::Position;

const US_PER_MS: u64 = 1_000;
const MS_PER_S: i64 = 1_000;

/// Where all axes shall be at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keyframe<const N: usize> {
    /// Time since the start of the motion in milliseconds.
    pub at_ms: u32,
    /// Distance of each axis from where it stood at the start, in command counts.
    pub positions_counts: [i32; N],
}

impl<const N: usize> Keyframe<N> {
    const fn us(&self) -> u64 {
        self.at_ms as u64 * US_PER_MS
    }
}

/// Where a motion is played.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Playhead {
    /// The keyframe before.
    place: usize,
    /// No axis goes far from one to the next: see [`SHORT_COUNTS`].
    is_short: bool,
    /// The share of the time to the next one that a microsecond is.
    per_us: u64,
    /// And what that leaves out, 22 bits more.
    more_per_us: u64,
}

/// A time between two keyframes is below 2^42 microseconds.
const MORE_BITS: u32 = 22;

/// A way of fewer counts is computed with one multiplication, which differs from the other one by 2^-11 counts at most.
const SHORT_COUNTS: u32 = 1 << 20;

impl Playhead {
    /// At the start of any motion.
    pub const START: Self = Self {
        place: usize::MAX,
        is_short: false,
        per_us: 0,
        more_per_us: 0,
    };

    /// The share that has passed, too small by 2^-64 for each 2^22 microseconds at most, and by another one.
    const fn share(&self, elapsed_us: u64) -> Share {
        let more = elapsed_us.wrapping_mul(self.more_per_us) >> MORE_BITS;
        Share(elapsed_us.wrapping_mul(self.per_us).wrapping_add(more))
    }
}

/// Keyframes that make no motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum KeyframeError {
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
    /// There is not one row of velocities for each keyframe.
    Velocities {
        /// Keyframes.
        expected: usize,
        /// Rows of velocities.
        actual: usize,
    },
    /// A motion starts and ends at rest.
    NotAtRest {
        /// The keyframe, counted from 0: the first or the last one.
        keyframe: usize,
        /// The axis.
        axis: usize,
        /// Its velocity.
        actual_counts_per_s: i32,
    },
    /// With its velocity an axis would go beyond 32 bits before the next keyframe.
    Fast {
        /// The keyframe, counted from 0.
        keyframe: usize,
        /// The axis.
        axis: usize,
        /// Its velocity there, or in the next keyframe.
        actual_counts_per_s: i32,
    },
}

impl fmt::Display for KeyframeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("a motion needs at least one keyframe"),
            Self::StartTime { actual_ms } => write!(
                f,
                "the first keyframe must be at 0 ms, it is at {actual_ms} ms"
            ),
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
            Self::Velocities { expected, actual } => write!(
                f,
                "expected a row of velocities for each of the {expected} keyframes, got {actual}"
            ),
            Self::NotAtRest {
                keyframe,
                axis,
                actual_counts_per_s,
            } => write!(
                f,
                "a motion starts and ends at rest: axis {axis} must have velocity 0 in keyframe {keyframe}, it has {actual_counts_per_s} counts per second"
            ),
            Self::Fast {
                keyframe,
                axis,
                actual_counts_per_s,
            } => write!(
                f,
                "behind keyframe {keyframe} axis {axis} would go more than 2147483647 counts with its {actual_counts_per_s} counts per second: put keyframes between"
            ),
        }
    }
}

impl core::error::Error for KeyframeError {}

/// A motion of `N` axes along keyframes, relative to where the axes stand when it starts.
///
/// Made by [`Self::new`], the axes are at rest in each keyframe. From one to the next every axis makes a [`Piece::minimum_jerk`], so the axes
/// keep the ratio of their distances: they move on a straight line. Made by [`Self::passing`], they pass each keyframe with a velocity of its
/// own, and every axis makes a [`Piece::cubic`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeyframeMotion<'a, const N: usize> {
    keyframes: &'a [Keyframe<N>],
    /// In counts per second, one row a keyframe; none for rest in each.
    velocities: &'a [[i32; N]],
}

impl<'a, const N: usize> KeyframeMotion<'a, N> {
    /// A motion along these keyframes; in a constant a mistake stops the build.
    ///
    /// # Errors
    /// [`KeyframeError`] unless the first keyframe is at time 0 and distance 0 and each other one is later than the one before it.
    pub const fn new(keyframes: &'a [Keyframe<N>]) -> Result<Self, KeyframeError> {
        let [first, later @ ..] = keyframes else {
            return Err(KeyframeError::Empty);
        };
        if first.at_ms != 0 {
            return Err(KeyframeError::StartTime {
                actual_ms: first.at_ms,
            });
        }
        if let Some((axis, actual_counts)) = first_not_zero(&first.positions_counts) {
            return Err(KeyframeError::StartPosition {
                axis,
                actual_counts,
            });
        }
        let (mut before, mut rest, mut keyframe) = (first, later, 1);
        while let [next, after @ ..] = rest {
            if next.at_ms <= before.at_ms {
                return Err(KeyframeError::Order {
                    keyframe,
                    after_ms: before.at_ms,
                    actual_ms: next.at_ms,
                });
            }
            (before, rest, keyframe) = (next, after, keyframe + 1);
        }
        Ok(Self {
            keyframes,
            velocities: &[],
        })
    }

    /// A motion that passes these keyframes, each with its row of velocities in counts per second; in a constant a mistake stops the build.
    ///
    /// # Errors
    /// As [`Self::new`]; [`KeyframeError::Velocities`], [`KeyframeError::NotAtRest`], [`KeyframeError::Fast`].
    pub const fn passing(
        keyframes: &'a [Keyframe<N>],
        velocities: &'a [[i32; N]],
    ) -> Result<Self, KeyframeError> {
        if let Err(error) = Self::new(keyframes) {
            return Err(error);
        }
        if keyframes.len() != velocities.len() {
            return Err(KeyframeError::Velocities {
                expected: keyframes.len(),
                actual: velocities.len(),
            });
        }
        if let Err(error) = check_ends(velocities) {
            return Err(error);
        }
        let (mut frames, mut rows, mut keyframe) = (keyframes, velocities, 0);
        while let ([from, later @ ..], [leaving, rows_later @ ..]) = (frames, rows) {
            if let ([to, ..], [arriving, ..]) = (later, rows_later) {
                let ms = to.at_ms.saturating_sub(from.at_ms);
                if let Some((axis, actual_counts_per_s)) = first_too_fast(leaving, arriving, ms) {
                    return Err(KeyframeError::Fast {
                        keyframe,
                        axis,
                        actual_counts_per_s,
                    });
                }
            }
            (frames, rows, keyframe) = (later, rows_later, keyframe + 1);
        }
        Ok(Self {
            keyframes,
            velocities,
        })
    }

    /// Time of the last keyframe in microseconds.
    #[must_use]
    pub const fn duration_us(&self) -> u64 {
        match self.keyframes {
            [.., last] => last.at_ms as u64 * US_PER_MS,
            [] => 0,
        }
    }

    /// Distance of each axis from where it stood at the start, in command counts, `time_us` after the start; the last keyframe
    /// afterwards. Exact at each keyframe, in between the nearest count.
    #[must_use]
    pub fn position(&self, time_us: u64) -> [i32; N] {
        let mut head = Playhead::START;
        self.position_from(&mut head, time_us)
    }

    /// The same. Whoever plays a motion keeps the head, so that nothing is searched or divided but between two keyframes.
    #[must_use]
    pub fn position_from(&self, head: &mut Playhead, time_us: u64) -> [i32; N] {
        let [from, to] = match self.around(head.place) {
            Some(around) if around[0].us() <= time_us && time_us < around[1].us() => around,
            _ => {
                *head = self.seek(time_us);
                match self.around(head.place) {
                    Some(around) => around,
                    // `new` has made sure of a keyframe at time 0.
                    None => {
                        return self
                            .keyframes
                            .last()
                            .map_or([0; N], |last| last.positions_counts);
                    }
                }
            }
        };
        let share = head.share(time_us.saturating_sub(from.us()));
        if let Some([leaving, arriving, ..]) = self.velocities.get(head.place..) {
            return passing([from, to], [leaving, arriving], share);
        }
        let share = share.with_minimum_jerk();
        if head.is_short {
            return shortly_between(from, to, share);
        }
        between(from, to, share)
    }

    /// A keyframe and the one behind it.
    fn around(&self, place: usize) -> Option<[&Keyframe<N>; 2]> {
        match self.keyframes.get(place..)? {
            [from, to, ..] => Some([from, to]),
            _ => None,
        }
    }

    #[cold]
    fn seek(&self, time_us: u64) -> Playhead {
        let reached = |keyframe: &Keyframe<N>| keyframe.us() <= time_us;
        let place = self.keyframes.partition_point(reached).saturating_sub(1);
        let around = self.around(place);
        let duration_us = around.map_or(0, |[from, to]| to.us().saturating_sub(from.us()));
        let is_short = around.is_some_and(|[from, to]| {
            let mut ways = from.positions_counts.iter().zip(&to.positions_counts);
            ways.all(|(from, to)| from.abs_diff(*to) < SHORT_COUNTS)
        });
        Playhead {
            place,
            is_short,
            per_us: u64::MAX.checked_div(duration_us).unwrap_or(0),
            more_per_us: u64::MAX
                .checked_rem(duration_us)
                .and_then(|rest| (rest << MORE_BITS).checked_div(duration_us))
                .unwrap_or(0),
        }
    }

    /// Upper bound of the largest step of each axis from one cycle to the next, in command counts, rounded up, and one count for the
    /// rounding of set-points: 15/8 of the mean velocity of its fastest move, or the highest velocity that its cubics can have.
    #[must_use]
    pub const fn peak_step_counts(&self, cycle_us: u32) -> [u64; N] {
        let mut peaks = [0; N];
        let (mut rest, mut rows) = (self.keyframes, self.velocities);
        while let [from, after @ ..] = rest {
            if let [to, ..] = after {
                let mut axis = 0;
                while axis < N {
                    let peak = match rows {
                        [leaving, arriving, ..] => {
                            let velocities = [leaving[axis], arriving[axis]];
                            peak_step_passing(from, to, axis, velocities, cycle_us)
                        }
                        _ => peak_step(from, to, axis, cycle_us),
                    };
                    if peak > peaks[axis] {
                        peaks[axis] = peak;
                    }
                    axis += 1;
                }
            }
            rest = after;
            if let [_, later @ ..] = rows {
                rows = later;
            }
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

/// The first and the last row must be at rest.
const fn check_ends<const N: usize>(velocities: &[[i32; N]]) -> Result<(), KeyframeError> {
    let ([first, ..], [.., last]) = (velocities, velocities) else {
        return Ok(());
    };
    let ends = [(0, first), (velocities.len() - 1, last)];
    let mut rest: &[(usize, &[i32; N])] = &ends;
    while let [(keyframe, row), after @ ..] = rest {
        if let Some((axis, actual_counts_per_s)) = first_not_zero(*row) {
            return Err(KeyframeError::NotAtRest {
                keyframe: *keyframe,
                axis,
                actual_counts_per_s,
            });
        }
        rest = after;
    }
    Ok(())
}

/// The first axis that would go beyond 32 bits in a time with one of its velocities.
const fn first_too_fast<const N: usize>(
    leaving: &[i32; N],
    arriving: &[i32; N],
    ms: u32,
) -> Option<(usize, i32)> {
    let mut axis = 0;
    while axis < N {
        let (one, other) = (leaving[axis], arriving[axis]);
        let faster = if one.unsigned_abs() > other.unsigned_abs() {
            one
        } else {
            other
        };
        if (faster as i64).unsigned_abs() * ms as u64 > i32::MAX as u64 * MS_PER_S as u64 {
            return Some((axis, faster));
        }
        axis += 1;
    }
    None
}

/// `axis` must be below `N`. The velocity of a cubic is a polynomial of degree two, which lies within the hull of its Bernstein
/// coefficients: both velocities, and three times the mean one less both.
const fn peak_step_passing<const N: usize>(
    from: &Keyframe<N>,
    to: &Keyframe<N>,
    axis: usize,
    [leaving, arriving]: [i32; 2],
    cycle_us: u32,
) -> u64 {
    let ms = to.at_ms.saturating_sub(from.at_ms) as i64;
    let distance = to.positions_counts[axis] as i64 - from.positions_counts[axis] as i64;
    if ms == 0 {
        return 0;
    }
    let ends = leaving as i64 + arriving as i64;
    // Times the duration in milliseconds.
    let middle = (3 * MS_PER_S * distance - ends * ms).unsigned_abs();
    let mut peak = middle.div_ceil(ms.unsigned_abs());
    if leaving.unsigned_abs() as u64 > peak {
        peak = leaving.unsigned_abs() as u64;
    }
    if arriving.unsigned_abs() as u64 > peak {
        peak = arriving.unsigned_abs() as u64;
    }
    if peak == 0 {
        return 0;
    }
    (peak.saturating_mul(cycle_us as u64)).div_ceil(US_PER_MS * MS_PER_S as u64) + 1
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
    // A time is rounded to 2^-32 of the duration, which is less than two counts of the longest way.
    travelled.div_ceil(8 * duration_us) + 1 + (distance >> 31)
}

/// The way with a velocity in counts per second, in so many microseconds.
const fn way(counts_per_s: i32, us: i64) -> Position {
    /// What a count has more than 16 units for each microsecond of a second: 0.777216, 64 bits behind the point.
    const REST: u64 = 14_337_104_641_992_242_868;
    // At most 2^31 counts, times a million.
    let product = (counts_per_s as i64).wrapping_mul(us);
    Position::from_units(product.wrapping_shl(4).wrapping_add(part_of(product, REST)))
}

/// The position at a share of the time from one keyframe to the next, which are passed with these velocities.
fn passing<const N: usize>(
    [from, to]: [&Keyframe<N>; 2],
    [leaving, arriving]: [&[i32; N]; 2],
    share: Share,
) -> [i32; N] {
    let us = to.us().saturating_sub(from.us()).cast_signed();
    let mut counts = from.positions_counts;
    let velocities = leaving.iter().zip(arriving);
    let axes = counts.iter_mut().zip(to.positions_counts).zip(velocities);
    for ((start, end), (leaving, arriving)) in axes {
        let piece = Piece::cubic(
            Position::from_counts(*start),
            Position::from_counts(end),
            way(*leaving, us),
            way(*arriving, us),
        );
        *start = piece.at(share).counts();
    }
    counts
}

/// As [`between`], for short ways.
#[inline]
fn shortly_between<const N: usize>(from: &Keyframe<N>, to: &Keyframe<N>, share: Share) -> [i32; N] {
    let mut ways = from.positions_counts.iter().zip(&to.positions_counts);
    core::array::from_fn(|_| {
        ways.next().map_or(0, |(start, end)| {
            start.wrapping_add(share.of_few_counts(end.wrapping_sub(*start)))
        })
    })
}

/// The position at a share of the way between two keyframes.
#[inline]
fn between<const N: usize>(from: &Keyframe<N>, to: &Keyframe<N>, share: Share) -> [i32; N] {
    let mut counts = from.positions_counts;
    for (start, &end) in counts.iter_mut().zip(&to.positions_counts) {
        *start = match end.checked_sub(*start) {
            Some(way) => start.wrapping_add(share.of_counts(way)),
            // From one end of 32 bits towards the other.
            None => {
                let piece = Piece::line(Position::from_counts(*start), Position::from_counts(end));
                piece.at(share).counts()
            }
        };
    }
    counts
}
