//! The counts of every axis in a cycle: the same as of the exact curve, for a fifth of its instructions.
//!
//! The powers of a curve are kept with 32 bits, all with as many places behind the point as fit. Where what that leaves out could decide
//! to which count a position is rounded, the caller asks the exact curve.

use trajectory::curve::Piece;
use trajectory::{Position, Time};

/// The sum of all powers stays below 2^30, so that no sum overflows.
const SUM_BITS: u32 = 30;
const POSITION_BITS: u32 = Position::UNITS.trailing_zeros();
/// What is left out, in units of the last place: 6 of the powers, 10 of the products, 4 of the share that count up to 5 times a half, 15 of
/// the exact curve itself; and a little more.
const LEFT_OUT: i32 = 48;
/// With fewer places nearly every position would be in doubt.
const FEWEST_PLACES: u32 = 7;

/// A curve of fifth degree.
#[derive(Debug, Clone, Copy)]
struct Curve {
    powers: [i32; 5],
    /// The start: whole counts, and what is behind the point.
    whole: i32,
    fraction: i32,
    /// 0 where the exact curve must be asked always.
    places: u32,
}

impl Curve {
    const UNKNOWN: Self = Self {
        powers: [0; 5],
        whole: 0,
        fraction: 0,
        places: 0,
    };

    fn new(piece: &Piece) -> Self {
        let (start, powers) = (piece.start().units(), piece.coefficients());
        let sum = powers.iter().map(|power| power.unsigned_abs());
        let sum = sum.fold(Position::UNITS as u64, u64::saturating_add);
        let down = (u64::BITS - sum.leading_zeros()).saturating_sub(SUM_BITS);
        let places = POSITION_BITS.saturating_sub(down);
        let Ok(whole) = i32::try_from(start >> POSITION_BITS) else {
            return Self::UNKNOWN;
        };
        if places < FEWEST_PLACES {
            return Self::UNKNOWN;
        }
        let fraction = start & (Position::UNITS - 1);
        Self {
            powers: powers.map(|power| (power >> down) as i32),
            whole,
            fraction: (fraction >> down) as i32,
            places,
        }
    }

    /// `None` where it is in doubt.
    #[inline(always)]
    fn at(&self, share: i32) -> Option<i32> {
        let places = self.places;
        if places == 0 {
            return None;
        }
        // The upper half of a product is one instruction, and twice of it is added in another.
        let part = |value: i32| (((i64::from(value) * i64::from(share)) >> 32) as i32) << 1;
        let [one, two, three, four, five] = self.powers;
        let way = if five | four == 0 {
            part(three)
        } else {
            part(part(part(five) + four) + three)
        };
        let way = part(part(way + two) + one) + self.fraction;
        let half = 1 << (places - 1);
        let (rounded, last) = (way + half, (1 << places) - 1);
        let rest = rounded & last;
        let is_clear = rest > LEFT_OUT && rest < last - LEFT_OUT;
        is_clear.then(|| self.whole.wrapping_add(rounded >> places))
    }
}

/// The curves of a segment.
#[derive(Debug)]
pub(super) struct Quick<const AXES: usize> {
    /// The segment that they were made of: its stream and its start.
    of: Option<(u16, Time)>,
    curves: [Curve; AXES],
    scale: Scale,
}

/// The duration of a segment, for the share of it that has passed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// It is shifted by so much, and 2^63 divided by it. The share has 31 bits.
    down: u32,
    inverse: u32,
}

impl Scale {
    const UNKNOWN: Self = Self {
        down: 0,
        inverse: 0,
    };

    pub(super) fn of(duration: Time) -> Self {
        let ticks = duration.ticks();
        let down = u32::BITS.saturating_sub(ticks.leading_zeros());
        let divisor = (ticks >> down).max(1);
        let inverse = u32::try_from((1_u64 << 63) / divisor).unwrap_or(u32::MAX);
        Self { down, inverse }
    }
}

impl<const AXES: usize> Quick<AXES> {
    pub(super) const fn new() -> Self {
        Self {
            of: None,
            curves: [Curve::UNKNOWN; AXES],
            scale: Scale::UNKNOWN,
        }
    }

    /// Takes a segment on, unless it has it.
    #[inline(always)]
    pub(super) fn take(&mut self, of: (u16, Time), scale: Scale, pieces: &[Piece]) {
        if self.of != Some(of) {
            self.of = Some(of);
            self.scale = scale;
            self.make(pieces);
        }
    }

    #[inline(never)]
    fn make(&mut self, pieces: &[Piece]) {
        for (curve, piece) in self.curves.iter_mut().zip(pieces) {
            *curve = Curve::new(piece);
        }
    }

    /// The counts of each axis so long after the start, within the duration; `None` for one that must be asked from the exact curve.
    #[inline(always)]
    pub(super) fn counts(&self, elapsed: Time) -> impl Iterator<Item = Option<i32>> + '_ {
        let elapsed = (elapsed.ticks() >> self.scale.down) as u32;
        let share = (u64::from(elapsed) * u64::from(self.scale.inverse)) >> 32;
        let share = i32::try_from(share).unwrap_or(i32::MAX);
        self.curves.iter().map(move |curve| curve.at(share))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use trajectory::curve::{Border, Share};

    use super::*;

    /// A number with any number of bits.
    fn value(bits: u32) -> impl Strategy<Value = i64> {
        (0..bits, any::<i64>()).prop_map(|(bits, value)| value >> (63 - bits))
    }

    proptest! {
        /// What is not in doubt is what the exact curve says.
        #[test]
        fn it_is_the_exact_curve(
            from in value(50),
            way in value(46),
            borders in [value(40), value(40), value(40), value(40)],
            kind in 0..4,
            duration in (1_u64 << 31)..(10_000_u64 << 32),
            places in proptest::collection::vec(0.0_f64..1.0, 1..50),
        ) {
            let [l, r, a, b] = borders.map(Position::from_units);
            let (from, to) = (Position::from_units(from), Position::from_units(from + way));
            let piece = match kind {
                0 => Piece::line(from, to),
                1 => Piece::cubic(from, to, l, r),
                2 => Piece::minimum_jerk(from, to),
                _ => Piece::quintic(
                    from,
                    to,
                    Border { velocity: l, acceleration: a },
                    Border { velocity: r, acceleration: b },
                ),
            };
            let mut quick = Quick::<1>::new();
            let start = Time::from_cycles(77);
            quick.take((1, start), Scale::of(Time::from_ticks(duration)), &[piece]);
            for place in places {
                let elapsed = ((duration as f64 * place) as u64).min(duration - 1);
                let exact = piece.at(Share::of(elapsed, duration)).counts();
                let counts = quick.counts(Time::from_ticks(elapsed)).next().unwrap();
                prop_assert!(counts.is_none_or(|counts| counts == exact), "{counts:?} {exact}");
            }
        }
    }

    #[test]
    fn hardly_anything_is_in_doubt() {
        let to = Position::from_counts(2_000);
        let piece = Piece::minimum_jerk(Position::ZERO, to);
        let mut quick = Quick::<1>::new();
        let duration = Time::from_cycles(10_000);
        quick.take((1, Time::ZERO), Scale::of(duration), &[piece]);
        let doubts = (0..10_000).filter(|cycle| {
            let counts = quick.counts(Time::from_cycles(*cycle)).next().unwrap();
            counts.is_none()
        });
        let doubts = doubts.count();
        assert!(doubts < 300, "{doubts}");
    }
}
