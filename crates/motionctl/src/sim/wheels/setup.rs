//! What is simulated.

use drive_sim::{BitRate, ResponseDelay};
use zlac8030l::NodeId;

use super::faults::Script;

/// Wheels that a simulation can hold.
pub(super) const MOST_WHEELS: usize = 16;

/// Largest number that 60FFh holds, whatever it counts (Z34).
pub(super) const MOST_SPEED: i32 = 1_000;

/// What to simulate.
#[derive(Debug)]
pub(super) struct Setup {
    /// Node of each wheel, in the order of the columns.
    pub(super) nodes: Vec<NodeId>,
    pub(super) cycle_us: u32,
    pub(super) bit_rate: BitRate,
    /// Speeds count 1/n r/min.
    pub(super) speed_resolution: u16,
    /// Ramps of the drives themselves (6083h, 6084h); 0: as fast as the motor can.
    pub(super) ramp_ms: u16,
    pub(super) response_delay: ResponseDelay,
    /// Seed of the response delays.
    pub(super) seed: u64,
    pub(super) faults: Script,
}
