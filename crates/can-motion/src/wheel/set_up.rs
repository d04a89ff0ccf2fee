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
    let ramp_ms = u32::from(wheel.ramp_ms);
    let acceleration = value(objects::ACCELERATION_TIME_MS, ramp_ms);
    let mode = mode_of(wheel.mode).value();
    let set_mode = value(objects::MODE, mode);
    // Steps are as many in every mode; one that is done already is compared once more.
    let (acceleration, profile, last) = match wheel.mode {
        WheelMode::Velocity => (acceleration, set_mode, set_mode),
        WheelMode::Position { profile_speed_rpm } => {
            let speed = value(objects::PROFILE_SPEED, u32::from(profile_speed_rpm));
            (acceleration, speed, set_mode)
        }
        WheelMode::Torque { slope_ma_s } => {
            // The slope takes the place of the acceleration. The guide has two values for this mode (Z4): a drive that shows another one
            // has not taken it.
            let shown = SetUpStep::Expect(Setting::new(objects::MODE_DISPLAY, mode));
            (value(objects::TORQUE_SLOPE, slope_ma_s), set_mode, shown)
        }
    };
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
        acceleration,
        value(objects::DECELERATION_TIME_MS, ramp_ms),
        profile,
        last,
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

const fn mode_of(mode: WheelMode) -> zlac8030l::Mode {
    match mode {
        WheelMode::Velocity => zlac8030l::Mode::Velocity,
        WheelMode::Position { .. } => zlac8030l::Mode::Position,
        WheelMode::Torque { .. } => zlac8030l::Mode::Torque,
    }
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
