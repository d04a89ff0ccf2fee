//! The frames of a command, for `--dry-run`.

use can_decode::dyn_drives::{Content, Message};
use dyn_can::{
    Address, DataFrame, Dialect, DriveId, RangeError, ReadSelector, Request, Revision,
    StoredDriveId, ZeroAddress,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::{DrivesError, Setting, can, serial};

/// When a frame would be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum When {
    /// To see who is there and what is stored.
    Before,
    /// Where the drive has another value.
    IfDifferent,
    /// In any case.
    Always,
    /// To a drive of one revision only.
    #[serde(rename = "revision-1.2A")]
    Revision12A,
    /// To a drive of one revision only.
    #[serde(rename = "revision-1.6A")]
    Revision16A,
    /// To see what the drive has made of it.
    ReadBack,
}

impl When {
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Before => "before",
            Self::IfDifferent => "if different",
            Self::Always => "always",
            Self::Revision12A => "to 1.2A",
            Self::Revision16A => "to 1.6A",
            Self::ReadBack => "read back",
        }
    }
}

/// One frame that a command would send.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct Step {
    pub(crate) when: When,
    /// On CAN identifier and data, as candump prints them; over the serial port the bytes of the packet.
    pub(crate) hex: String,
    pub(crate) words: String,
}

/// Makes the frames of one kind of connection. Nothing is opened and nothing is sent.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Frames {
    Can,
    Serial,
}

impl Frames {
    /// The reads that show the state and every setting of a drive.
    pub(crate) fn reads(self, drive: StoredDriveId) -> Vec<Step> {
        match self {
            Self::Can => [
                Request::ReadDriveId,
                Request::ReadParamGroup3,
                Request::ReadDriveConfig,
                Request::ReadParamGroup1,
                Request::ReadParamGroup2,
                Request::ReadDriveStatus,
                Request::GeneralRead(ReadSelector::Position),
                Request::GeneralRead(ReadSelector::Torque),
                Request::ReadMotorSpeed,
            ]
            .into_iter()
            .filter_map(|request| on_can(When::Before, drive, request, Dialect::V1_6A))
            .collect(),
            Self::Serial => [
                dyn_serial::Request::ReadDriveId,
                dyn_serial::Request::ReadDriveStatus,
                dyn_serial::Request::GeneralRead(dyn_serial::ReadSelector::Position),
            ]
            .into_iter()
            .chain(serial::read_requests())
            .filter_map(|request| on_line(When::Before, drive, &request, "read"))
            .collect(),
        }
    }

    /// The write of a setting.
    ///
    /// # Errors
    /// When it is out of range, or the protocol cannot carry it.
    pub(crate) fn write(self, drive: StoredDriveId, setting: Setting) -> Result<Step, DrivesError> {
        let when = When::IfDifferent;
        let does = format!("store {}", setting.value);
        let fault = |reason: String| DrivesError::Fault { drive, reason };
        let out_of_range = |error: RangeError| fault(error.to_string());
        let step = match self {
            Self::Can => {
                let request = can::request_of(setting).map_err(out_of_range)?;
                on_can(when, drive, request, Dialect::V1_6A)
            }
            Self::Serial => serial::request_of(setting)
                .map_err(out_of_range)?
                .and_then(|request| on_line(when, drive, &request, &does)),
        };
        step.ok_or_else(|| {
            let Setting { parameter, value } = setting;
            fault(format!(
                "{parameter} = {value} cannot be sent over this connection: use CAN"
            ))
        })
    }

    /// Looking who is there, the assignment, and its confirmation.
    pub(crate) fn assign(self, from: StoredDriveId, to: DriveId) -> Vec<Step> {
        let mut steps = Vec::new();
        // A drive that has no id may share its address with every other, and on a serial line any two do.
        if from.drive_id().is_none() || matches!(self, Self::Serial) {
            let others = DriveId::all().map(StoredDriveId::from);
            let others = others.filter(|other| *other != from);
            steps.extend(others.filter_map(|other| self.read_id(When::Before, other)));
        }
        steps.extend(self.read_id(When::Before, from));
        match self {
            Self::Can => {
                let group3 = Request::ReadParamGroup3;
                let assign = Request::AssignDriveId(to.into());
                steps.extend(on_can(When::Before, from, group3, Dialect::V1_6A));
                steps.extend(self.read_id(When::Before, to.into()));
                steps.extend(on_can(When::Always, from, assign, Dialect::V1_6A));
            }
            Self::Serial => {
                let new = dyn_serial::DriveId::new(to.get().into()).ok();
                let assign = new.map(dyn_serial::Request::AssignDriveId);
                steps.extend(assign.and_then(|assign| {
                    on_line(When::Always, from, &assign, &format!("store drive id {to}"))
                }));
            }
        }
        steps.extend(self.read_id(When::ReadBack, to.into()));
        steps.extend(self.read_id(When::ReadBack, from));
        steps
    }

    /// The drive's own origin.
    pub(crate) fn set_origin(self, drive: StoredDriveId) -> Vec<Step> {
        match self {
            Self::Can => [Revision::V1_2A, Revision::V1_6A]
                .into_iter()
                .filter_map(|revision| {
                    let when = match revision {
                        Revision::V1_2A => When::Revision12A,
                        Revision::V1_6A => When::Revision16A,
                    };
                    on_can(when, drive, Request::SetOrigin, Dialect::of(revision))
                })
                .collect(),
            Self::Serial => on_line(
                When::Always,
                drive,
                &dyn_serial::Request::SetOrigin,
                "make this position the zero, stored",
            )
            .into_iter()
            .collect(),
        }
    }

    /// One request to a drive on CAN.
    pub(crate) fn on_can(when: When, drive: DriveId, request: Request) -> Option<Step> {
        on_can(when, drive.into(), request, Dialect::V1_6A)
    }

    /// One request to a drive on its serial port; `does` says what it is for.
    pub(crate) fn on_line(
        when: When,
        drive: StoredDriveId,
        request: &dyn_serial::Request,
        does: &str,
    ) -> Option<Step> {
        on_line(when, drive, request, does)
    }

    /// One request to every drive on CAN: the trigger.
    pub(crate) fn to_all(when: When, request: Request) -> Option<Step> {
        on_can(when, StoredDriveId::NONE, request, Dialect::V1_6A)
    }

    fn read_id(self, when: When, drive: StoredDriveId) -> Option<Step> {
        match self {
            Self::Can => on_can(when, drive, Request::ReadDriveId, Dialect::V1_6A),
            Self::Serial => on_line(when, drive, &dyn_serial::Request::ReadDriveId, "read"),
        }
    }
}

/// `None` for a request that the revision does not have.
fn on_can(when: When, drive: StoredDriveId, request: Request, dialect: Dialect) -> Option<Step> {
    let dialect = Dialect {
        zero_address: ZeroAddress::LoneFreshDrive,
        ..dialect
    };
    let address = drive.drive_id().map_or(Address::Broadcast, Address::Drive);
    let frame = request.encode(address, &dialect).ok()?;
    let message = Message {
        address,
        function: request.function(),
        content: Content::Request(request),
        note: None,
    };
    Some(Step {
        when,
        hex: candump(&frame),
        words: message.said().to_string(),
    })
}

fn candump(frame: &DataFrame) -> String {
    let data: String = frame
        .data()
        .iter()
        .map(|byte| format!("{byte:02X}"))
        .collect();
    format!("{:03X}#{data}", frame.id())
}

fn on_line(
    when: When,
    drive: StoredDriveId,
    request: &dyn_serial::Request,
    does: &str,
) -> Option<Step> {
    let to = dyn_serial::DriveId::new(drive.get().into()).ok()?;
    let packet = request
        .encode(to.into(), &dyn_serial::Dialect::MANUAL)
        .ok()?;
    Some(Step {
        when,
        hex: packet.to_string(),
        words: format!("to drive {drive}    {}: {does}", request.function().name()),
    })
}
