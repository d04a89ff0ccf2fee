//! Drives that answer at once, as far as a master needs it to stream.

use dyn_can::{
    ConfigByte, DataFrame, Dialect, DriveStatus, GearNumber, OnPosRange, ParamGroup3, ReadSelector,
    Reply, Request, ServoSwitch,
};

const DIALECT: Dialect = Dialect::V1_6A;

/// Bit 1 of the status byte: disabled.
const DISABLED: u8 = 0x02;

/// Whether each drive is enabled, one bit an id.
#[derive(Debug, Default)]
pub(crate) struct Drives {
    enabled: u64,
}

impl Drives {
    /// The reply to a frame of the master, if there is one.
    pub(crate) fn reply(&mut self, frame: &DataFrame) -> Option<DataFrame> {
        let (address, request) = Request::decode(frame, &DIALECT).ok()?;
        let bit = 1 << address.drive()?.get();
        let reply = match request {
            Request::ServoDisable(ServoSwitch::Enable) => {
                self.enabled |= bit;
                return None;
            }
            Request::ServoDisable(ServoSwitch::Disable) => {
                self.enabled &= !bit;
                return None;
            }
            Request::EchoFunction(bytes) => Reply::Echo(bytes),
            Request::ReadParamGroup3 => Reply::ParamGroup3(ParamGroup3 {
                on_pos_range: OnPosRange::MIN,
                gear_number: GearNumber::MAX,
                line_number: None,
            }),
            Request::ReadDriveConfig => Reply::DriveConfig(ConfigByte::from_byte(0)),
            Request::ReadDriveStatus => {
                let is_enabled = self.enabled & bit != 0;
                Reply::DriveStatus(DriveStatus::from_byte(if is_enabled {
                    0
                } else {
                    DISABLED
                }))
            }
            Request::GeneralRead(ReadSelector::Position) => Reply::Position(0),
            Request::ReadMotorSpeed => Reply::MotorSpeed(0),
            _ => return None,
        };
        Some(reply.encode(address, &DIALECT))
    }
}
