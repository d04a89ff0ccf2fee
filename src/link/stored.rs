//! The settings as they are stored.

use board_link::AxisLimits;
use can_motion::{AxisConfig, Limits, MotorLimits, Travel};
use dyn_can::{DriveId, GearNumber};
use trajectory::Position;

use crate::config::{CYCLE_US, MASTER};
use crate::machine::Machine;

pub(crate) fn read() -> Option<Machine> {
    let mut machine = Machine {
        master: MASTER,
        axes: heapless::Vec::new(),
        limits: heapless::Vec::new(),
        has_enable_input: true,
    };
    for drive in 1..=4 {
        let gear = GearNumber::new(4_096).ok()?;
        let motor = MotorLimits {
            speed_rpm: 600,
            acceleration_rpm_per_s: 8_000,
        };
        let limits = Limits::of_motor(motor, Travel::WHOLE, gear, CYCLE_US).ok()?;
        let axis = AxisConfig::new(DriveId::new(drive).ok()?, gear, limits);
        machine.axes.push(axis).ok()?;
        let motion = trajectory::Limits::without_jerk(
            f32::from(limits.max_step.get()),
            limits.max_step_change.per_256_cycles() as f32 / 256.0,
        );
        let limits = AxisLimits {
            motion: motion.ok()?,
            lowest: Position::from_counts(limits.travel.min_counts),
            highest: Position::from_counts(limits.travel.max_counts),
        };
        machine.limits.push(limits).ok()?;
    }
    Some(machine)
}
