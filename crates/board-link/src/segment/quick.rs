//! The counts of every axis in a cycle: the same as of the exact curve, for a fifth of its instructions.
//!
//! The powers of a curve are kept with 32 bits, all with as many places behind the point as fit. Where what that leaves out could decide
//! to which count a position is rounded, the caller asks the exact curve.

use core::hint::black_box;

use trajectory::curve::Piece;
use trajectory::{Position, Time};

/// The sum of all powers stays below 2^30, so that no sum overflows.
const SUM_BITS: u32 = 30;
const POSITION_BITS: u32 = Position::UNITS.trailing_zeros();
/// The most by which both can differ, in units of the last place, and a little more. The quick one leaves out up to 6 of the powers and 10 of
/// the products, and its share is off by up to three steps of 31 bits, which is 8 of the sum; the exact one leaves out up to 25, or has 5 too
/// many. All but the share and these 5 go the same way: 33 at most.
const LEFT_OUT: i32 = 48;
/// With fewer places every position would be in doubt.
const FEWEST_PLACES: u32 = 7;

/// A curve of fifth degree.
#[derive(Debug, Clone, Copy)]
struct Curve {
    powers: [i32; 5],
    /// The start: whole counts, and what is behind the point, with half a count for the rounding and without what is left out.
    whole: i32,
    fraction: i32,
    places: u32,
}

impl Curve {
    /// In doubt everywhere.
    const UNKNOWN: Self = Self {
        powers: [0; 5],
        whole: 0,
        fraction: -LEFT_OUT,
        places: 1,
    };

    fn new(piece: &Piece, places: Places) -> Self {
        let down = POSITION_BITS.wrapping_sub(u32::from(places.0));
        if down > POSITION_BITS - FEWEST_PLACES {
            return Self::UNKNOWN;
        }
        let start = piece.start().units();
        let fraction = (start & (Position::UNITS - 1)) as i32;
        // A loop: `map` of an array is a copy and a dozen calls in small code.
        let mut powers = [0; 5];
        for (short, power) in powers.iter_mut().zip(piece.coefficients()) {
            *short = (power >> down) as i32;
        }
        Self {
            powers,
            whole: (start >> POSITION_BITS) as i32,
            fraction: ((fraction + (Position::UNITS / 2) as i32) >> down) - LEFT_OUT,
            places: places.0.into(),
        }
    }

    /// The least and the most counts that it may be.
    #[inline(always)]
    fn at(&self, share: i32) -> (i32, i32) {
        // The upper half of a product is one instruction, and twice of it is added in another.
        let part = |value: i32| (((i64::from(value) * i64::from(share)) >> 32) as i32) << 1;
        let [one, two, three, four, five] = self.powers;
        let way = part(part(part(part(part(five) + four) + three) + two) + one);
        let least = way + self.fraction;
        let most = least + 2 * LEFT_OUT;
        (
            self.whole.wrapping_add(least >> self.places),
            self.whole.wrapping_add(most >> self.places),
        )
    }
}

/// Places behind the point with which a curve is kept. With too few of them the exact one is asked always.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Places(u8);

impl Places {
    /// Too few.
    pub(super) const NONE: Self = Self(0);

    pub(super) fn of(piece: &Piece) -> Self {
        let sum = piece.coefficients().into_iter().map(i64::unsigned_abs);
        let sum = sum.fold(Position::UNITS as u64, u64::saturating_add);
        let down = (u64::BITS - sum.leading_zeros()).saturating_sub(SUM_BITS);
        Self(POSITION_BITS.saturating_sub(down) as u8)
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
    /// It is shifted by so much, and a little less than 2^63 divided by it. The share has 31 bits.
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
        let inverse = u32::try_from(i64::MAX as u64 / divisor).unwrap_or(u32::MAX);
        Self { down, inverse }
    }

    /// The share of the duration that has passed, 31 bits; `elapsed` is less than the duration.
    #[inline(always)]
    fn share(self, elapsed: Time) -> i32 {
        let elapsed = (elapsed.ticks() >> self.down) as u32;
        ((u64::from(elapsed) * u64::from(self.inverse)) >> 32) as i32
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

    /// Forgets the segment: another one may have the same stream number and start.
    pub(super) fn forget(&mut self) {
        self.of = None;
    }

    /// Takes a segment on, unless it has it: its stream and its start, its scale, and the piece of each axis with its places.
    pub(super) fn take<'p>(
        &mut self,
        of: (u16, Time),
        scale: Scale,
        pieces: impl Iterator<Item = (&'p Piece, &'p Places)>,
    ) {
        if self.of == Some(of) {
            return;
        }
        (self.of, self.scale) = (Some(of), scale);
        for (curve, (piece, places)) in self.curves.iter_mut().zip(pieces) {
            *curve = Curve::new(piece, *places);
        }
    }

    /// Writes the counts of each axis so long after the start, within the duration. Where that is false, some are in doubt and must be
    /// asked from the exact curve: those of [`Self::is_in_doubt`].
    #[inline(always)]
    pub(super) fn write(&self, elapsed: Time, out: &mut [i32]) -> bool {
        let share = self.scale.share(elapsed);
        let mut differences = 0;
        for (out, curve) in out.iter_mut().zip(&self.curves) {
            // Where the compiler sees that it is the same for every axis, it widens it before the loop, and forgets in the loop that a product of
            // 32 bits is one instruction.
            let (least, most) = curve.at(black_box(share));
            differences |= least ^ most;
            *out = least;
        }
        differences == 0
    }

    /// Whether the counts of an axis are in doubt.
    pub(super) fn is_in_doubt(&self, elapsed: Time, axis: usize) -> bool {
        let share = self.scale.share(elapsed);
        self.curves.get(axis).is_none_or(|curve| {
            let (least, most) = curve.at(share);
            least != most
        })
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

    fn quick(piece: Piece, duration: u64) -> Quick<1> {
        let mut quick = Quick::new();
        let scale = Scale::of(Time::from_ticks(duration));
        let pieces = [(&piece, &Places::of(&piece))];
        quick.take((1, Time::from_cycles(77)), scale, pieces.into_iter());
        quick
    }

    /// `None` where they are in doubt.
    fn counts(quick: &Quick<1>, elapsed: u64) -> Option<i32> {
        let mut out = [0];
        let elapsed = Time::from_ticks(elapsed);
        let is_clear = quick.write(elapsed, &mut out);
        assert_eq!(quick.is_in_doubt(elapsed, 0), !is_clear);
        is_clear.then_some(out[0])
    }

    proptest! {
        /// What is not in doubt is what the exact curve says.
        #[test]
        fn it_is_the_exact_curve(
            from in value(60),
            // Up to the fewest places, where what is left out matters most.
            way in prop_oneof![value(46), (1_i64 << 38)..(1 << 43)],
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
            let quick = quick(piece, duration);
            for place in places {
                let elapsed = ((duration as f64 * place) as u64).min(duration - 1);
                let exact = piece.at(Share::of(elapsed, duration)).counts();
                let counts = counts(&quick, elapsed);
                prop_assert!(counts.is_none_or(|counts| counts == exact), "{counts:?} {exact}");
            }
        }
    }

    proptest! {
        /// The start is put so that the position just comes to a half, or just does not.
        #[test]
        fn at_a_half_it_is_in_doubt_or_right(
            way in value(47),
            borders in [value(45), value(45), value(45), value(45)],
            duration in (1_u64 << 31)..(10_000_u64 << 32),
            place in prop_oneof![0.0_f64..1.0, 0.99..1.0],
        ) {
            let [l, r, a, b] = borders.map(Position::from_units);
            let elapsed = ((duration as f64 * place) as u64).min(duration - 1);
            let from = |start: i64| {
                let (from, to) = (Position::from_units(start), Position::from_units(start + way));
                let leaving = Border { velocity: l, acceleration: a };
                Piece::quintic(from, to, leaving, Border { velocity: r, acceleration: b })
            };
            let share = Share::of(elapsed, duration);
            let way = from(0).at(share).units();
            for more in -2..=2 {
                let piece = from(Position::UNITS / 2 - way + more);
                let counts = counts(&quick(piece, duration), elapsed);
                let exact = piece.at(share).counts();
                prop_assert!(counts.is_none_or(|counts| counts == exact), "{counts:?} {exact}");
            }
        }
    }

    #[test]
    fn the_largest_ways_of_each_number_of_bits_fit() {
        let duration = 100_u64 << 32;
        for bits in 25..60 {
            let way = (1_i64 << bits) - Position::UNITS - 1;
            for (way, start) in [(way, 0), (way, Position::UNITS - 1), (-way, 0), (-way, 1)] {
                let to = Position::from_units(start + way);
                let piece = Piece::line(Position::from_units(start), to);
                for elapsed in [duration - 1, 99 << 32, 0] {
                    let exact = piece.at(Share::of(elapsed, duration)).counts();
                    let counts = counts(&quick(piece, duration), elapsed);
                    assert!(counts.is_none_or(|counts| counts == exact), "{bits} {way}");
                }
            }
        }
    }

    #[test]
    fn counts_beyond_32_bits_wrap() {
        let duration = 100_u64 << 32;
        for (from, way) in [(i32::MAX - 500, 1_000), (i32::MIN + 500, -1_000)] {
            let from = Position::from_counts(from);
            let piece = Piece::line(from, from.moved_by(Position::from_counts(way)));
            for cycle in 0..100 {
                let exact = piece.at(Share::of(cycle << 32, duration)).counts();
                let counts = counts(&quick(piece, duration), cycle << 32);
                assert!(
                    counts.is_none_or(|counts| counts == exact),
                    "{counts:?} {exact}"
                );
            }
        }
    }

    #[test]
    fn hardly_anything_is_in_doubt() {
        let to = Position::from_counts(2_000);
        let piece = Piece::minimum_jerk(Position::ZERO, to);
        let quick = quick(piece, Time::from_cycles(10_000).ticks());
        let doubts =
            (0..10_000).filter(|cycle| counts(&quick, Time::from_cycles(*cycle).ticks()).is_none());
        let doubts = doubts.count();
        assert!(doubts < 300, "{doubts}");
    }
}
