//! What goes to a wheel in the gaps of the cycle.

use zlac8030l::{DataFrame, NmtCommand, NmtRequest, NodeId, SdoRequest, objects};

use crate::core::facts::Brake;

/// What a transfer is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The checks of the drive.
    Check,
    /// Whether the motor has power, while no feedback says so.
    Power,
    /// The quick stop of a drive that takes no frames of a cycle.
    Stop,
    /// The holding brake.
    Brake(Brake),
    /// A procedure of the application.
    Procedure,
    /// A reading that no PDO brings.
    Health(HealthReading),
}

/// A reading that no PDO brings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HealthReading {
    /// 2026h:01.
    #[default]
    MotorTemperature,
    /// 2026h:02.
    DriverTemperature,
    /// 2029h.
    BusVoltage,
}

impl HealthReading {
    /// Readings in a round.
    pub(super) const COUNT: u32 = 3;

    /// The one behind it.
    pub(super) const fn next(self) -> Self {
        match self {
            Self::MotorTemperature => Self::DriverTemperature,
            Self::DriverTemperature => Self::BusVoltage,
            Self::BusVoltage => Self::MotorTemperature,
        }
    }

    pub(super) const fn request(self) -> SdoRequest {
        match self {
            Self::MotorTemperature => objects::MOTOR_TEMPERATURE.read(),
            Self::DriverTemperature => objects::DRIVER_TEMPERATURE.read(),
            Self::BusVoltage => objects::BUS_VOLTAGE.read(),
        }
    }
}

/// Something that goes out in the gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WheelRequest {
    /// A command of network management.
    Nmt(NmtCommand),
    /// The start of a transfer.
    Transfer(Purpose, SdoRequest),
    /// The abort of a transfer that was given up.
    Abort(SdoRequest),
}

impl WheelRequest {
    pub(super) fn encode(self, node: NodeId) -> DataFrame {
        match self {
            Self::Nmt(command) => NmtRequest {
                command,
                node: Some(node),
            }
            .encode(),
            Self::Transfer(_, request) | Self::Abort(request) => request.encode(node),
        }
    }
}
