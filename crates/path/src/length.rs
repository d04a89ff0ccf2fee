//! Lengths along the path, with 20 bits behind the point of a unit.

use trajectory::fixed::scaled;

/// Bits behind the point of a length, and of a velocity along the path.
pub(crate) const LENGTH_BITS: u32 = 20;

/// Fastest velocity along a path, in units per cycle: what fits 32 bits.
pub(crate) const FASTEST: f32 = 4_000.0;

/// Of a velocity.
const UNIT: f32 = 1.0 / (1_u32 << LENGTH_BITS) as f32;

/// Not negative, below 2^40 units.
pub(crate) fn from_units(units: f32) -> i64 {
    scaled(units, LENGTH_BITS as i32)
}

/// To 24 bits.
pub(crate) fn units(length: i64) -> f32 {
    to_float(length, LENGTH_BITS)
}

/// A number with bits behind its point as a float, to 24 bits: the processor converts 32 bits in one instruction, and 64 in none.
pub(crate) fn to_float(value: i64, bits: u32) -> f32 {
    let low = value as i32;
    let whole = if i64::from(low) == value {
        low as f32
    } else {
        // The upper half is not 0 or -1, so that the lower one may lose its last bits.
        (value >> 32) as i32 as f32 * 4_294_967_296.0 + value as u32 as f32
    };
    // A power of two, which is in range for 64 bits.
    whole * f32::from_bits((127 - bits) << 23)
}

/// Velocity, not negative, rounded down.
pub(crate) fn velocity(units_per_cycle: f32) -> u32 {
    (units_per_cycle * (1_u32 << LENGTH_BITS) as f32) as u32
}

pub(crate) fn velocity_units(velocity: u32) -> f32 {
    velocity as f32 * UNIT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_lose_the_last_bits_alone() {
        let mut value = 1_i64;
        while value < 1 << 61 {
            for signed in [value, -value, value + 1, value - 1] {
                for bits in [20, 24] {
                    let exact = signed as f64 / f64::from(1_u32 << bits);
                    let error = f64::from(to_float(signed, bits)) - exact;
                    assert!(
                        error.abs() <= exact.abs() * 2_f64.powi(-23),
                        "{signed}: {error}"
                    );
                }
            }
            value += value / 8 + 1;
        }
    }
}
