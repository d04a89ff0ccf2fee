//! What is set up in a drive before it moves.

use zlac8030l::{
    Object, ObjectValue, PdoDirection, PdoMapping, PdoNumber, PdoSetUp, SetUpOptions, SetUpStep,
    Setting, objects,
};

use crate::wheel::config::{FeedbackTiming, WheelConfig, WheelMasterConfig, WheelMode};
use crate::wheel::process_data;

/// Transmission type of a PDO by timer, in the guide's words (Z12).
const BY_TIMER: u8 = 255;
/// Transmission type of a PDO after each SYNC.
const BY_SYNC: u8 = 1;

pub(super) const STEPS: usize = 15;

pub(super) const fn options(wheel: &WheelConfig) -> SetUpOptions {
    SetUpOptions {
        firmware: wheel.firmware,
        // The mapping is made at every start; the EEPROM is left alone.
        save: false,
    }
}

/// The steps, in order. They must be the same at every call for one wheel.
pub(super) fn steps(config: &WheelMasterConfig, wheel: &WheelConfig) -> [SetUpStep; STEPS] {
    let (mode, speed_rpm) = match wheel.mode {
        WheelMode::Velocity => (zlac8030l::Mode::Velocity, None),
        WheelMode::Position { profile_speed_rpm } => {
            (zlac8030l::Mode::Position, Some(profile_speed_rpm))
        }
    };
    let mode = value(objects::MODE, mode.value());
    let ramp_ms = u32::from(wheel.ramp_ms);
    let (stops, timeouts) = (&wheel.stops, &config.timeouts);
    let emergency_ms = u32::from(stops.emergency_ms);
    [
        value(objects::QUICK_STOP_OPTION, stops.quick_stop),
        value(objects::SHUTDOWN_OPTION, stops.shutdown),
        value(objects::DISABLE_OPTION, stops.disable),
        value(objects::HALT_OPTION, stops.halt),
        value(objects::EMERGENCY_DECELERATION_TIME_MS, emergency_ms),
        value(objects::ROTATION, u16::from(wheel.counter_clockwise)),
        value(objects::PRODUCER_HEARTBEAT_MS, timeouts.heartbeat_ms),
        value(objects::OFFLINE_TIME_MS, timeouts.offline_ms),
        value(objects::ACCELERATION_TIME_MS, ramp_ms),
        value(objects::DECELERATION_TIME_MS, ramp_ms),
        speed_rpm.map_or(mode, |rpm| value(objects::PROFILE_SPEED, u32::from(rpm))),
        mode,
        SetUpStep::Pdo(receive(process_data::command_mapping(wheel.mode))),
        SetUpStep::Pdo(transmit(
            config,
            process_data::STATUS,
            process_data::status_mapping(),
        )),
        SetUpStep::Pdo(transmit(
            config,
            process_data::POSITION,
            process_data::position_mapping(),
        )),
    ]
}

fn value<T: ObjectValue>(object: Object<T>, value: T) -> SetUpStep {
    SetUpStep::Value(Setting::new(object, value))
}

/// Targets are taken as they come, whatever the feedback does.
const fn receive(mapping: PdoMapping) -> PdoSetUp {
    PdoSetUp {
        direction: PdoDirection::Receive,
        number: process_data::COMMAND,
        mapping,
        transmission_type: Some(BY_TIMER),
        inhibit_time: None,
        event_timer: None,
    }
}

const fn transmit(config: &WheelMasterConfig, number: PdoNumber, mapping: PdoMapping) -> PdoSetUp {
    let (transmission_type, ticks) = match config.feedback {
        FeedbackTiming::Timer { ticks } => (BY_TIMER, ticks),
        FeedbackTiming::Sync => (BY_SYNC, 0),
    };
    PdoSetUp {
        direction: PdoDirection::Transmit,
        number,
        mapping,
        transmission_type: Some(transmission_type),
        inhibit_time: Some(0),
        event_timer: Some(ticks),
    }
}
