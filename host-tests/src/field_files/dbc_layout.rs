//! Where the values of each function stand in its data, for functions with one layout (1.6A section 6).

use dyn_can::{ByteOrder, FunctionCode, Quantity};

/// The data of a message.
pub(super) struct Layout {
    /// Most data bytes.
    pub(super) bytes: u8,
    /// None where no DBC can say it.
    pub(super) signals: Vec<Signal>,
}

/// A value in the data: `raw * factor + offset`.
pub(super) struct Signal {
    /// As in `motionctl decode --json`, where that has the same value.
    pub(super) name: &'static str,
    /// As a DBC counts: the lowest bit, or with the most significant byte first the highest.
    pub(super) first_bit: u8,
    pub(super) bits: u8,
    pub(super) order: ByteOrder,
    pub(super) is_signed: bool,
    pub(super) factor: i32,
    pub(super) offset: i32,
    pub(super) limits: (i32, i32),
    pub(super) unit: &'static str,
    /// Raw numbers with a meaning.
    pub(super) values: &'static [(u8, &'static str)],
}

/// What alarm codes are called (dyn-values, `Alarm`).
const ALARMS: &[(u8, &str)] = &[
    (0, "no alarm"),
    (1, "lost phase"),
    (2, "over-current"),
    (3, "overheat or over-power"),
    (4, "command refused"),
];
const COMMAND_MODES: &[(u8, &str)] = &[
    (0, "RS232 and CAN"),
    (1, "CW and CCW pulses"),
    (2, "pulse and direction"),
    (3, "analog"),
];
const SERVO_MODES: &[(u8, &str)] = &[(0, "position"), (1, "speed"), (2, "torque")];

impl Signal {
    /// A byte.
    fn byte(name: &'static str, at: u8, limits: (i32, i32)) -> Self {
        Self::bits(name, 8 * at, 8, limits)
    }

    /// Bits of one byte.
    fn bits(name: &'static str, first_bit: u8, bits: u8, limits: (i32, i32)) -> Self {
        Self {
            name,
            first_bit,
            bits,
            order: ByteOrder::LsbFirst,
            is_signed: false,
            factor: 1,
            offset: 0,
            limits,
            unit: "",
            values: &[],
        }
    }

    fn flag(name: &'static str, bit: u8) -> Self {
        Self::bits(name, bit, 1, (0, 1))
    }

    /// A number of several whole bytes.
    fn bytes(name: &'static str, at: u8, bytes: u8, order: ByteOrder, limits: (i32, i32)) -> Self {
        let first_bit = match order {
            ByteOrder::MsbFirst => 8 * at + 7,
            ByteOrder::LsbFirst => 8 * at,
        };
        Self {
            order,
            ..Self::bits(name, first_bit, 8 * bytes, limits)
        }
    }

    const fn meaning(self, values: &'static [(u8, &'static str)]) -> Self {
        Self { values, ..self }
    }

    /// The bits that it takes, bit 0 of the first byte lowest.
    #[cfg(test)]
    pub(super) fn mask(&self) -> u64 {
        let lowest = match self.order {
            ByteOrder::LsbFirst => self.first_bit,
            ByteOrder::MsbFirst => self.first_bit - 7,
        };
        ((1 << self.bits) - 1) << lowest
    }
}

/// The layout of a function's data.
pub(super) fn layout(function: FunctionCode) -> Layout {
    use FunctionCode as F;
    let keep_or = |quantity: Quantity| (0, quantity.limits().1);
    let (bytes, signals) = match function {
        F::SetOrigin => (
            1,
            vec![Signal::byte("magic", 0, (0, 255)).meaning(&[(0xAB, "1.6A"), (0xFF, "1.2A")])],
        ),
        F::AssignDriveId | F::ReadDriveId => (
            1,
            vec![Signal::byte(
                "drive_id",
                0,
                Quantity::StoredDriveId.limits(),
            )],
        ),
        F::SetDriveConfig | F::ReadDriveConfig => (1, config()),
        F::ReadDriveStatus => (1, status()),
        F::SsFrequency => (
            1,
            vec![Signal {
                unit: "Hz",
                ..Signal::byte("frequency_hz", 0, Quantity::FrequencyHz.limits())
            }],
        ),
        F::SetParamGroup1 => (4, group1(keep_or)),
        F::ReadParamGroup1 => (4, group1(Quantity::limits)),
        F::SetParamGroup2 => (2, group2(keep_or)),
        F::ReadParamGroup2 => (2, group2(Quantity::limits)),
        F::SetParamGroup3 => (5, group3(1, ByteOrder::MsbFirst, keep_or)),
        F::ReadParamGroup3 => (6, group3(2, ByteOrder::LsbFirst, Quantity::limits)),
        F::SyncTrigger => (
            1,
            vec![
                Signal::byte("sync_kind", 0, (0, 255))
                    .meaning(&[(0xFF, "absolute"), (0xEE, "relative")]),
            ],
        ),
        F::ServoDisable => (
            1,
            vec![
                Signal::byte("servo_switch", 0, (0, 255))
                    .meaning(&[(0x00, "enable"), (0xFF, "disable")]),
            ],
        ),
        F::ReadMotorSpeed => (2, vec![motor_speed()]),
        F::DriveReset => (
            1,
            vec![Signal::byte("answer", 0, (0, 255)).meaning(&[(0xFE, "request")])],
        ),
        F::DriveError => (
            1,
            vec![
                Signal::byte("drive_error", 0, (0, 255))
                    .meaning(&[(0xFF, "data error"), (0xEE, "alarm")]),
            ],
        ),
        F::EchoFunction => (
            4,
            (0..4)
                .map(|at| {
                    Signal::byte(
                        ["byte_0", "byte_1", "byte_2", "byte_3"][at],
                        at as u8,
                        (0, 255),
                    )
                })
                .collect(),
        ),
        F::DiagnosticCounter => (1, vec![Signal::byte("counter", 0, (0, 255))]),
        F::TurnConstSpeed | F::GoRelativePosPd => (2, vec![]),
        F::SquareWave | F::SinWave => (3, vec![]),
        F::GoAbsolutePosPtp
        | F::GoRelativePosPtp
        | F::MakeLinearLine
        | F::MakeCircularArc
        | F::GoAbsolutePosSync
        | F::GoRelativePosSync
        | F::GeneralRead => (4, vec![]),
        F::ForMotorDefine => (0, vec![]),
    };
    Layout { bytes, signals }
}

/// The bit of the drive says that it is off position.
fn status() -> Vec<Signal> {
    vec![
        Signal {
            factor: -1,
            offset: 1,
            ..Signal::flag("on_position", 0)
        },
        Signal::flag("disabled", 1),
        Signal::bits("alarm_code", 2, 3, (0, 7)).meaning(ALARMS),
        Signal::flag("motion_busy", 5),
    ]
}

fn config() -> Vec<Signal> {
    vec![
        Signal::bits("command_mode", 0, 2, Quantity::CommandMode.limits()).meaning(COMMAND_MODES),
        Signal::flag("absolute_mode", 2),
        Signal::bits("servo_mode", 3, 2, Quantity::ServoMode.limits()).meaning(SERVO_MODES),
        Signal::flag("servo_free", 5),
    ]
}

fn group1(limits: impl Fn(Quantity) -> (i32, i32)) -> Vec<Signal> {
    vec![
        Signal::byte("main_gain", 0, limits(Quantity::MainGain)),
        Signal::byte("speed_gain", 1, limits(Quantity::SpeedGain)),
        Signal::byte("integration_gain", 2, limits(Quantity::IntegrationGain)),
        Signal::byte("torque_filter", 3, limits(Quantity::TorqueFilter)),
    ]
}

fn group2(limits: impl Fn(Quantity) -> (i32, i32)) -> Vec<Signal> {
    vec![
        Signal::byte("max_speed", 0, limits(Quantity::MaxSpeed)),
        Signal::byte("max_acceleration", 1, limits(Quantity::MaxAcceleration)),
    ]
}

/// The on-position range has one byte in a request and two in a reply of 1.6A.
fn group3(
    range_bytes: u8,
    order: ByteOrder,
    limits: impl Fn(Quantity) -> (i32, i32),
) -> Vec<Signal> {
    // A drive without a line number sends 0 (D24).
    let line_limits = (0, Quantity::LineNumber.limits().1);
    let word = |name, at, limits| Signal::bytes(name, at, 2, order, limits);
    vec![
        Signal::bytes(
            "on_pos_range",
            0,
            range_bytes,
            order,
            limits(Quantity::OnPosRange),
        ),
        word("gear_number", range_bytes, limits(Quantity::GearNumber)),
        word("line_number", range_bytes + 2, line_limits),
    ]
}

fn motor_speed() -> Signal {
    let limits = (i32::from(i16::MIN), i32::from(i16::MAX));
    Signal {
        is_signed: true,
        unit: "rpm",
        ..Signal::bytes("speed_rpm", 0, 2, ByteOrder::MsbFirst, limits)
    }
}
