//! A typed request from the command and the arguments of a vector.

use std::fmt;

use dyn_can::{
    CommandMode, DriveConfig, FunctionCode, RangeError, ReadSelector, Refusal, Request, Revision,
    ServoMode, ServoSwitch, SetParamGroup1, SetParamGroup2, SetParamGroup3, StoredDriveId,
    SyncKind,
};
use serde_json::{Map, Value};

use crate::frame_fields::HexBytes;

/// Why a vector's arguments make no request.
#[derive(Debug, Clone, PartialEq)]
pub enum ArgumentError {
    /// The harness does not know this vector: an argument is missing or one too many.
    Schema(String),
    /// A number outside its range.
    Range(RangeError),
    /// A whole number beyond 32 bit, which no argument type can hold.
    BeyondI32(Value),
    /// Another kind of value than the argument type can hold.
    Type(String),
    /// Another number of bytes than the argument type holds.
    Length(usize),
    /// A name that is no variant of the argument type.
    Variant(String),
    /// The function code has no request.
    Refused(Refusal),
}

impl From<RangeError> for ArgumentError {
    fn from(error: RangeError) -> Self {
        Self::Range(error)
    }
}

impl fmt::Display for ArgumentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Schema(reason) => write!(f, "unknown arguments: {reason}"),
            Self::Range(error) => error.fmt(f),
            Self::BeyondI32(value) => write!(f, "{value} is beyond 32 bit"),
            Self::Type(reason) => f.write_str(reason),
            Self::Length(actual) => write!(f, "expected 4 bytes, got {actual}"),
            Self::Variant(name) => write!(f, "{name:?} is no variant"),
            Self::Refused(refusal) => refusal.fmt(f),
        }
    }
}

/// The arguments of one command; each may be taken once.
struct Arguments(Map<String, Value>);

impl Arguments {
    fn take(&mut self, name: &str) -> Result<Value, ArgumentError> {
        self.0
            .remove(name)
            .ok_or_else(|| ArgumentError::Schema(format!("{name} is missing")))
    }

    fn number(&mut self, name: &str) -> Result<i32, ArgumentError> {
        let value = self.take(name)?;
        match value.as_i64() {
            Some(number) => i32::try_from(number).map_err(|_| ArgumentError::BeyondI32(value)),
            None if value.is_u64() => Err(ArgumentError::BeyondI32(value)),
            None => Err(ArgumentError::Type(format!(
                "{name}: expected a whole number, got {value}"
            ))),
        }
    }

    /// A number through the constructor of its type.
    fn checked<T>(
        &mut self,
        name: &str,
        new: impl FnOnce(i32) -> Result<T, RangeError>,
    ) -> Result<T, ArgumentError> {
        Ok(new(self.number(name)?)?)
    }

    /// A parameter of a group, where 0 keeps the stored value.
    fn kept_or<T>(
        &mut self,
        name: &str,
        new: impl FnOnce(i32) -> Result<T, RangeError>,
    ) -> Result<Option<T>, ArgumentError> {
        match self.number(name)? {
            0 => Ok(None),
            number => Ok(Some(new(number)?)),
        }
    }

    fn flag(&mut self, name: &str) -> Result<bool, ArgumentError> {
        let value = self.take(name)?;
        let wrong = || ArgumentError::Type(format!("{name}: expected true or false, got {value}"));
        value.as_bool().ok_or_else(wrong)
    }

    fn text(&mut self, name: &str) -> Result<String, ArgumentError> {
        match self.take(name)? {
            Value::String(text) => Ok(text),
            other => Err(ArgumentError::Type(format!(
                "{name}: expected a text, got {other}"
            ))),
        }
    }

    /// One of the two variants of a selector, by name.
    fn variant<T>(&mut self, name: &str, variants: [(&str, T); 2]) -> Result<T, ArgumentError> {
        let text = self.text(name)?;
        let found = variants.into_iter().find(|(variant, _)| *variant == text);
        found
            .map(|(_, value)| value)
            .ok_or(ArgumentError::Variant(text))
    }

    fn echo_bytes(&mut self) -> Result<[u8; 4], ArgumentError> {
        let text = self.text("payload_hex")?;
        let bytes = HexBytes::parse(&text).ok_or_else(|| {
            ArgumentError::Schema(format!("payload_hex {text:?} is not hexadecimal"))
        })?;
        <[u8; 4]>::try_from(bytes.0).map_err(|bytes| ArgumentError::Length(bytes.len()))
    }

    fn drive_config(&mut self) -> Result<DriveConfig, ArgumentError> {
        Ok(DriveConfig {
            command_mode: self.checked("command_mode", CommandMode::new)?,
            absolute_mode: self.flag("absolute_mode")?,
            servo_mode: self.checked("servo_mode", ServoMode::new)?,
            servo_free: self.flag("disabled")?,
        })
    }

    fn group1(&mut self) -> Result<SetParamGroup1, ArgumentError> {
        Ok(SetParamGroup1 {
            main_gain: self.kept_or("main_gain", TryFrom::try_from)?,
            speed_gain: self.kept_or("speed_gain", TryFrom::try_from)?,
            integration_gain: self.kept_or("integration_gain", TryFrom::try_from)?,
            torque_filter: self.kept_or("torque_filter", TryFrom::try_from)?,
        })
    }

    fn group2(&mut self) -> Result<SetParamGroup2, ArgumentError> {
        Ok(SetParamGroup2 {
            max_speed: self.kept_or("max_speed", TryFrom::try_from)?,
            max_acceleration: self.kept_or("max_acceleration", TryFrom::try_from)?,
        })
    }

    fn group3(&mut self) -> Result<SetParamGroup3, ArgumentError> {
        Ok(SetParamGroup3 {
            on_pos_range: self.kept_or("on_pos_range", TryFrom::try_from)?,
            gear_number: self.kept_or("gear_number", TryFrom::try_from)?,
            line_number: self.kept_or("line_number", TryFrom::try_from)?,
        })
    }

    fn finish(self) -> Result<(), ArgumentError> {
        match self.0.keys().next() {
            None => Ok(()),
            Some(name) => Err(ArgumentError::Schema(format!(
                "{name} is not an argument of this command"
            ))),
        }
    }
}

/// The request that a vector's command and arguments describe.
///
/// # Errors
/// [`ArgumentError`] when the types of the codec refuse an argument, or have no room for it.
pub fn request(
    function: FunctionCode,
    revision: Revision,
    arguments: Map<String, Value>,
) -> Result<Request, ArgumentError> {
    let mut arguments = Arguments(arguments);
    let result = build(function, revision, &mut arguments);
    // A vector with an argument that is never looked at must not pass, not even as a refusal.
    if result.is_ok() {
        arguments.finish()?;
    }
    result
}

fn build(
    function: FunctionCode,
    revision: Revision,
    arguments: &mut Arguments,
) -> Result<Request, ArgumentError> {
    use FunctionCode as F;
    const POSITION: &str = "position_counts";
    const DISTANCE: &str = "distance_counts";
    const VALUE: &str = "value_counts";
    const AMPLITUDE: &str = "amplitude_counts";
    Ok(match function {
        F::SetOrigin => Request::SetOrigin,
        F::GoAbsolutePosPtp => {
            Request::GoAbsolutePosPtp(arguments.checked(POSITION, TryFrom::try_from)?)
        }
        F::MakeLinearLine => Request::MakeLinearLine(arguments.checked(VALUE, TryFrom::try_from)?),
        F::GoRelativePosPtp => {
            Request::GoRelativePosPtp(arguments.checked(DISTANCE, TryFrom::try_from)?)
        }
        F::MakeCircularArc => {
            Request::MakeCircularArc(arguments.checked(VALUE, TryFrom::try_from)?)
        }
        F::AssignDriveId => {
            Request::AssignDriveId(arguments.checked("new_drive_id", StoredDriveId::new)?)
        }
        F::ReadDriveId => Request::ReadDriveId,
        F::SetDriveConfig => Request::SetDriveConfig(arguments.drive_config()?),
        F::ReadDriveConfig => Request::ReadDriveConfig,
        F::ReadDriveStatus => Request::ReadDriveStatus,
        F::TurnConstSpeed => {
            Request::TurnConstSpeed(arguments.checked("speed_rpm", TryFrom::try_from)?)
        }
        F::SquareWave => Request::SquareWave(arguments.checked(AMPLITUDE, TryFrom::try_from)?),
        F::SinWave => Request::SinWave(arguments.checked(AMPLITUDE, TryFrom::try_from)?),
        F::SsFrequency => {
            Request::SsFrequency(arguments.checked("frequency_hz", TryFrom::try_from)?)
        }
        F::GeneralRead => {
            let selectors = [
                ("position", ReadSelector::Position),
                ("torque", ReadSelector::Torque),
            ];
            Request::GeneralRead(arguments.variant("what", selectors)?)
        }
        F::ForMotorDefine | F::DriveError => return Err(no_request(function, revision)),
        F::SetParamGroup1 => Request::SetParamGroup1(arguments.group1()?),
        F::SetParamGroup2 => Request::SetParamGroup2(arguments.group2()?),
        F::SetParamGroup3 => Request::SetParamGroup3(arguments.group3()?),
        F::ReadParamGroup1 => Request::ReadParamGroup1,
        F::ReadParamGroup2 => Request::ReadParamGroup2,
        F::ReadParamGroup3 => Request::ReadParamGroup3,
        F::GoAbsolutePosSync => {
            Request::GoAbsolutePosSync(arguments.checked(POSITION, TryFrom::try_from)?)
        }
        F::GoRelativePosSync => {
            Request::GoRelativePosSync(arguments.checked(DISTANCE, TryFrom::try_from)?)
        }
        F::SyncTrigger => {
            let kinds = [
                ("absolute", SyncKind::Absolute),
                ("relative", SyncKind::Relative),
            ];
            Request::SyncTrigger(arguments.variant("kind", kinds)?)
        }
        F::ServoDisable => Request::ServoDisable(match arguments.flag("disable")? {
            true => ServoSwitch::Disable,
            false => ServoSwitch::Enable,
        }),
        F::ReadMotorSpeed => Request::ReadMotorSpeed,
        F::DriveReset => Request::DriveReset,
        F::GoRelativePosPd => {
            Request::GoRelativePosPd(arguments.checked(DISTANCE, TryFrom::try_from)?)
        }
        F::EchoFunction => Request::EchoFunction(arguments.echo_bytes()?),
        F::DiagnosticCounter => Request::DiagnosticCounter,
    })
}

/// The codec has no type for these requests; what it says about their function code is the refusal.
fn no_request(function: FunctionCode, revision: Revision) -> ArgumentError {
    match function.admit_request(revision) {
        Err(refusal) => ArgumentError::Refused(refusal),
        Ok(()) => ArgumentError::Schema(format!("{function} is admitted but has no request type")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn of(function: FunctionCode, arguments: Value) -> Result<Request, ArgumentError> {
        let Value::Object(arguments) = arguments else {
            panic!("arguments are an object")
        };
        request(function, Revision::V1_6A, arguments)
    }

    #[test]
    fn missing_and_surplus_arguments_are_schema_errors() {
        let pd = FunctionCode::GoRelativePosPd;
        assert!(matches!(of(pd, json!({})), Err(ArgumentError::Schema(_))));
        let surplus = json!({"distance_counts": 1, "speed_rpm": 2});
        assert!(matches!(of(pd, surplus), Err(ArgumentError::Schema(_))));
    }

    #[test]
    fn what_the_types_cannot_hold_keeps_its_reason() {
        let pd = FunctionCode::GoRelativePosPd;
        let step = |value: Value| of(pd, json!({"distance_counts": value}));
        assert!(matches!(step(json!(16_385)), Err(ArgumentError::Range(_))));
        assert!(matches!(
            step(json!(4_294_967_296_i64)),
            Err(ArgumentError::BeyondI32(_))
        ));
        assert!(matches!(step(json!(1.5)), Err(ArgumentError::Type(_))));
        let echo = json!({"payload_hex": "010203"});
        assert_eq!(
            of(FunctionCode::EchoFunction, echo),
            Err(ArgumentError::Length(3))
        );
        let both = json!({"kind": "both"});
        assert_eq!(
            of(FunctionCode::SyncTrigger, both),
            Err(ArgumentError::Variant("both".into()))
        );
    }
}
