//! Lengths along the path, with 20 bits behind the point of a unit.

use trajectory::fixed::scaled;

/// Bits behind the point of a length, and of a velocity along the path.
pub(crate) const LENGTH_BITS: u32 = 20;

/// Fastest velocity along a path, in units per cycle: what fits 32 bits.
pub(crate) const FASTEST: f32 = 4_000.0;

const UNIT: f32 = 1.0 / (1_u32 << LENGTH_BITS) as f32;

/// Not negative, below 2^40 units.
pub(crate) fn from_units(units: f32) -> i64 {
    scaled(units, LENGTH_BITS as i32)
}

/// To 24 bits.
pub(crate) fn units(length: i64) -> f32 {
    // One conversion instruction where it fits, as it mostly does.
    match i32::try_from(length) {
        Ok(length) => length as f32 * UNIT,
        Err(_) => length as f32 * UNIT,
    }
}

/// Velocity, not negative, rounded down.
pub(crate) fn velocity(units_per_cycle: f32) -> u32 {
    (units_per_cycle * (1_u32 << LENGTH_BITS) as f32) as u32
}

pub(crate) fn velocity_units(velocity: u32) -> f32 {
    velocity as f32 * UNIT
}
