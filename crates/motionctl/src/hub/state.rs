//! What a drive tells of itself at one moment.

use core::fmt;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::{FaultCode, Mode, NodeId, State, StatusWord, objects};

use super::bus::Bus;
use super::error::HubError;

/// The state of a drive.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(super) struct HubState {
    /// The power stage, in the words of CiA 402.
    pub(super) state: String,
    pub(super) enabled: bool,
    /// A commanded quick stop holds.
    pub(super) quick_stop: bool,
    /// An emergency stop input is active.
    pub(super) emergency_input: bool,
    pub(super) fault: Option<String>,
    /// 6061h in words; none while no mode is set.
    pub(super) mode: Option<&'static str>,
    pub(super) position_counts: i32,
    pub(super) speed_rpm: f64,
    /// 6077h as the drive counts it: 0.1 A by its text, mA by its range (Z25).
    pub(super) torque: i16,
    pub(super) motor_celsius: f64,
    pub(super) driver_celsius: f64,
    pub(super) bus_volts: f64,
    #[serde(skip)]
    pub(super) status: StatusWordOf,
    #[serde(skip)]
    pub(super) fault_code: u16,
}

/// The status word, which is shown in words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StatusWordOf(pub(super) StatusWord);

impl Default for StatusWordOf {
    fn default() -> Self {
        Self(StatusWord::new(0))
    }
}

impl HubState {
    /// Reads it, object by object.
    ///
    /// # Errors
    /// As [`Bus::read`].
    pub(super) fn read(bus: &mut Bus, node: NodeId) -> Result<Self, HubError> {
        let status = StatusWord::new(bus.read(node, objects::STATUS_WORD)?);
        let fault = FaultCode::new(bus.read(node, objects::FAULT_CODE)?);
        let mode = bus.read(node, objects::MODE_DISPLAY)?;
        let tenths = |value: i32| f64::from(value) / 10.0;
        Ok(Self {
            state: status.state().to_string(),
            enabled: has_power(status),
            quick_stop: has_power(status) && status.emergency_stop(),
            emergency_input: status.external_emergency_stop(),
            fault: fault.is_fault().then(|| fault.to_string()),
            mode: mode_words(mode),
            position_counts: bus.read(node, objects::ACTUAL_POSITION)?,
            speed_rpm: tenths(bus.read(node, objects::ACTUAL_SPEED)?),
            torque: bus.read(node, objects::ACTUAL_TORQUE)?,
            motor_celsius: tenths(bus.read(node, objects::MOTOR_TEMPERATURE)?.into()),
            driver_celsius: tenths(bus.read(node, objects::DRIVER_TEMPERATURE)?.into()),
            bus_volts: f64::from(bus.read(node, objects::BUS_VOLTAGE)?) / 100.0,
            status: StatusWordOf(status),
            fault_code: fault.get(),
        })
    }

    /// The fault bits.
    pub(super) fn fault_code(&self) -> FaultCode {
        FaultCode::new(self.fault_code)
    }
}

/// Whether the motor may be energised: a state that no document describes counts as power.
pub(super) fn has_power(status: StatusWord) -> bool {
    match status.state() {
        State::OperationEnabled => true,
        State::Undocumented => !status.fault_bit(),
        State::NotEnabled | State::ReadyToSwitchOn | State::SwitchedOn => false,
    }
}

/// 6061h; torque is 4 in the examples of the guide and 6 in its dictionary (Z4).
fn mode_words(value: i8) -> Option<&'static str> {
    match (Mode::from_value(value), value) {
        (Some(Mode::Position), _) => Some("position"),
        (Some(Mode::Velocity), _) => Some("velocity"),
        (Some(Mode::Torque), _) | (None, 6) => Some("torque"),
        _ => None,
    }
}

impl fmt::Display for HubState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.state)?;
        if let Some(fault) = &self.fault {
            write!(f, ", FAULT {fault}")?;
        }
        if self.emergency_input {
            f.write_str(", EMERGENCY INPUT ACTIVE")?;
        }
        if self.quick_stop {
            f.write_str(", quick stop holds")?;
        }
        write!(
            f,
            "; {}; position {} counts, {:.1} r/min, torque {}; motor {:.1} degC, driver {:.1} degC, {:.2} V",
            self.mode.unwrap_or("no mode"),
            self.position_counts,
            self.speed_rpm,
            self.torque,
            self.motor_celsius,
            self.driver_celsius,
            self.bus_volts
        )
    }
}
