//! Inputs, outputs and the Hall sensors, as the objects show them.
//!
//! Specification: an input with the function of an emergency stop is pressed or not; X1 without a function has the level of the switch beside the
//! shaft, X0 without one is low. The inversions change what the objects
//! show and not what an input does, since the fault panel commands the button and not the wire.

use super::objects;
use super::power_stage::Stage;
use super::{ZlacDrive, ZlacFaults};

/// Functions of an output (2030h:0D and :0F).
const ALARM: u32 = 1;
const DRIVE_STATUS: u32 = 2;
const IN_POSITION: u32 = 4;
/// Hall sensors that are wrong: all of them on.
const HALL_ERROR: u32 = 7;
/// Fault bit of the Hall sensors.
const HALL_FAULT: u16 = 0x0200;
/// The six sectors of an electrical turn; 0 and 7 are errors. No document lists the order.
const HALL_SECTORS: [u32; 6] = [1, 3, 2, 6, 4, 5];

impl ZlacDrive {
    /// 2003h: bit 0 X0, bit 1 X1.
    pub(super) fn input_levels(&self, now_ns: u64) -> u32 {
        let pressed = |input| {
            let is_stop = self.memory.get(input) == objects::INPUT_EMERGENCY_STOP;
            u32::from(is_stop && self.emergency_input)
        };
        let is_plain = self.memory.get(objects::INPUT_X1) != objects::INPUT_EMERGENCY_STOP;
        let switch = is_plain && self.motion.at(now_ns).switch_is_operated();
        let levels =
            pressed(objects::INPUT_X0) | pressed(objects::INPUT_X1) << 1 | u32::from(switch) << 1;
        levels ^ self.memory.get(objects::INPUT_INVERSION) & 0b11
    }

    /// 2004h: bits 0 and 1 Y0 and Y1, bit 2 the brake B0.
    pub(super) fn output_levels(&self, now_ns: u64) -> u32 {
        let level = |output| {
            u32::from(match self.memory.get(output) {
                ALARM => self.stage.fault() != 0,
                DRIVE_STATUS => self.stage.stage() == Stage::Enabled,
                IN_POSITION => self.motion.at(now_ns).has_arrived(),
                _ => false,
            })
        };
        let outputs = level(objects::OUTPUT_Y0) | level(objects::OUTPUT_Y1) << 1;
        let inversion = self.memory.get(objects::OUTPUT_INVERSION) & 0b11;
        (outputs ^ inversion) | self.memory.get(objects::HOLDING_BRAKE) << 2
    }

    /// 2028h.
    pub(super) fn hall_inputs(&self, now_ns: u64) -> u32 {
        if self.stage.fault() & HALL_FAULT != 0 {
            return HALL_ERROR;
        }
        let pole_pairs = f64::from(self.memory.get(objects::POLE_PAIRS).max(1));
        let electrical_turns = self.motion.at(now_ns).shaft_turns() * pole_pairs;
        let sector = (electrical_turns.rem_euclid(1.0) * 6.0) as usize;
        HALL_SECTORS[sector.min(5)]
    }

    /// Faults, to command some.
    pub fn faults_mut(&mut self) -> &mut ZlacFaults {
        &mut self.faults
    }
}
