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
    // What is more than 31 bits and the sign.
    let excess = 33_u32.saturating_sub(value.unsigned_abs().leading_zeros());
    let mantissa = (value >> excess) as i32 as f32;
    // A power of two, which is in range for 64 bits.
    let exponent = (127 + excess).saturating_sub(bits);
    mantissa * f32::from_bits(exponent << 23)
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
