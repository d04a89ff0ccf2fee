//! Machines: what the axes do where the tool is.

use trajectory::Position;

pub use crate::backlash::Backlash;

/// The axes of a machine as a function of a place in space, whose coordinates are in units such as micrometres.
///
/// The limits of a path are those of the axes: [`Self::rates`] says how much an axis moves for a small move in space. For a machine that
/// is not linear both the rates and their change from place to place matter; give the largest rates that occur, and room in the limits
/// for the rest.
pub trait Machine<const SPACE: usize, const AXES: usize> {
    /// The positions of the axes in counts, at a place in units.
    fn axes(&self, place: [Position; SPACE]) -> [Position; AXES];

    /// Counts of each axis for a move by a vector in units.
    fn rates(&self, vector: &[f32; SPACE]) -> [f32; AXES];
}

/// Counts of an axis per unit of space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// With [`Scale::BITS`] behind the point.
    fixed: i64,
    counts_per_unit: f32,
}

/// A number of counts per unit that no axis has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScaleError {
    /// With 32 bits behind the point.
    pub actual: i64,
}

impl core::fmt::Display for ScaleError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "counts per unit must be 2^-16 to 2^20 or the same negative, expected {} to {} in steps of 2^-32, got {}",
            Scale::LEAST,
            Scale::MOST,
            self.actual
        )
    }
}

impl core::error::Error for ScaleError {}

impl Scale {
    /// Bits behind the point of [`Self::from_fixed`].
    pub const BITS: u32 = 32;
    const LEAST: u64 = 1 << 16;
    const MOST: u64 = 1 << 52;
    /// One count per unit.
    pub const ONE: Self = Self {
        fixed: 1 << Self::BITS,
        counts_per_unit: 1.0,
    };

    /// Counts per unit in steps of 2^-32, negative for an axis that runs the other way.
    ///
    /// # Errors
    /// [`ScaleError`] for fewer than 2^-16 or more than 2^20 counts per unit.
    pub const fn from_fixed(fixed: i64) -> Result<Self, ScaleError> {
        let size = fixed.unsigned_abs();
        if size < Self::LEAST || size > Self::MOST {
            return Err(ScaleError { actual: fixed });
        }
        Ok(Self {
            fixed,
            counts_per_unit: fixed as f32 / 4_294_967_296.0,
        })
    }

    /// Counts per unit as a fraction; see [`Self::from_fixed`].
    ///
    /// # Errors
    /// As [`Self::from_fixed`].
    pub const fn from_ratio(ratio: trajectory::units::Ratio) -> Result<Self, ScaleError> {
        let wide = (ratio.numerator() as i64) << Self::BITS;
        match wide.checked_div(ratio.denominator() as i64) {
            Some(fixed) => Self::from_fixed(fixed),
            None => Err(ScaleError { actual: 0 }),
        }
    }

    /// Counts at a coordinate.
    #[must_use]
    pub const fn counts(&self, coordinate: Position) -> Position {
        // Four products of 32 bits instead of one of 128.
        let (units, fixed) = (coordinate.units(), self.fixed);
        let (high, low) = (units >> 32, units as u32 as i64);
        let (fixed_high, fixed_low) = (fixed >> 32, fixed as u32 as u64);
        let lowest = (low as u64).wrapping_mul(fixed_low) >> 32;
        Position::from_units(
            high.wrapping_mul(fixed)
                .wrapping_add(low.wrapping_mul(fixed_high))
                .wrapping_add(lowest as i64),
        )
    }

    /// Counts per unit.
    #[must_use]
    pub const fn counts_per_unit(&self) -> f32 {
        self.counts_per_unit
    }
}

/// One axis a coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cartesian<const N: usize> {
    /// Of each coordinate.
    pub scales: [Scale; N],
}

impl<const N: usize> Machine<N, N> for Cartesian<N> {
    fn axes(&self, place: [Position; N]) -> [Position; N] {
        let mut axes = place;
        for (axis, scale) in axes.iter_mut().zip(&self.scales) {
            *axis = scale.counts(*axis);
        }
        axes
    }

    fn rates(&self, vector: &[f32; N]) -> [f32; N] {
        let mut rates = *vector;
        for (rate, scale) in rates.iter_mut().zip(&self.scales) {
            *rate *= scale.counts_per_unit;
        }
        rates
    }
}

/// Two wheels beside each other; the coordinates are the way of the middle between them, and the way of a wheel at the track width
/// around that middle: the heading in radians times the track width.
///
/// A line in these coordinates is a drive straight ahead, a turn on the spot, or an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DifferentialDrive {
    /// Left wheel, in counts per unit of its way.
    pub left: Scale,
    /// Right wheel; negative when its motor is mounted the other way round.
    pub right: Scale,
}

impl Machine<2, 2> for DifferentialDrive {
    fn axes(&self, [ahead, turned]: [Position; 2]) -> [Position; 2] {
        let half = Position::from_units(turned.units() >> 1);
        [
            self.left.counts(ahead.distance_from(half)),
            self.right.counts(ahead.moved_by(half)),
        ]
    }

    fn rates(&self, [ahead, turned]: &[f32; 2]) -> [f32; 2] {
        [
            self.left.counts_per_unit * (ahead - 0.5 * turned),
            self.right.counts_per_unit * (ahead + 0.5 * turned),
        ]
    }
}

/// A motor of one coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Counted from 0; a motor of a coordinate that the space does not have stands still.
    pub coordinate: usize,
    /// Counts per unit; negative when it is mounted the other way round.
    pub scale: Scale,
}

/// Motors of which several may share a coordinate: a gantry has two on one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gantry<const AXES: usize> {
    /// In the order of the axes.
    pub motors: [Motor; AXES],
}

impl<const SPACE: usize, const AXES: usize> Machine<SPACE, AXES> for Gantry<AXES> {
    fn axes(&self, place: [Position; SPACE]) -> [Position; AXES] {
        self.motors.map(|motor| {
            let coordinate = place.get(motor.coordinate).copied();
            motor.scale.counts(coordinate.unwrap_or(Position::ZERO))
        })
    }

    fn rates(&self, vector: &[f32; SPACE]) -> [f32; AXES] {
        self.motors.map(|motor| {
            let coordinate = vector.get(motor.coordinate).copied();
            motor.scale.counts_per_unit * coordinate.unwrap_or(0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_exact_and_have_a_range() {
        let scale =
            Scale::from_ratio(trajectory::units::Ratio::new(-16_384, 5_000).unwrap()).unwrap();
        let counts = scale.counts(Position::from_counts(100_000_000));
        assert!(
            (counts.units() - Position::from_counts(-327_680_000).units()).abs()
                <= Position::UNITS / 8
        );
        assert!(Scale::from_fixed(0).is_err());
        assert!(Scale::from_fixed((1 << 52) + 1).is_err());
        assert!(Scale::from_fixed(-(1 << 16)).is_ok());
    }

    #[test]
    fn wheels_of_a_drive_turn_against_each_other_on_the_spot() {
        let machine = DifferentialDrive {
            left: Scale::ONE,
            right: Scale::ONE,
        };
        let [left, right] =
            machine.axes([Position::from_counts(1_000), Position::from_counts(200)]);
        assert_eq!((left.counts(), right.counts()), (900, 1_100));
        assert_eq!(machine.rates(&[0.0, 2.0]), [-1.0, 1.0]);
    }

    #[test]
    fn both_motors_of_a_gantry_go_the_same_way() {
        let other = Scale::from_fixed(-2 << 32).unwrap();
        let motor = |coordinate, scale| Motor { coordinate, scale };
        let machine = Gantry {
            motors: [
                motor(0, Scale::ONE),
                motor(0, other),
                motor(1, Scale::ONE),
                motor(2, Scale::ONE),
            ],
        };
        let axes = machine.axes([Position::from_counts(50), Position::from_counts(7)]);
        assert_eq!(axes.map(Position::counts), [50, -100, 7, 0]);
        assert_eq!(machine.rates(&[1.0, 0.5]), [1.0, -2.0, 0.5, 0.0]);
    }
}
