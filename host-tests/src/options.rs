//! The readings that a vector needs, as a [`Dialect`].

use dyn_can::{
    ByteOrder, Dialect, Group3ReplyOrder, Revision, SetOriginData, TorqueFullScale, ZeroAddress,
};
use serde::{Deserialize, Deserializer, de};
use serde_json::Value;

/// Byte order by name.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Most significant byte first.
    Big,
    /// Least significant byte first.
    Little,
}

impl From<Order> for ByteOrder {
    fn from(order: Order) -> Self {
        match order {
            Order::Big => Self::MsbFirst,
            Order::Little => Self::LsbFirst,
        }
    }
}

/// Byte order of a reply, or to be recognised in each reply.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReplyOrder {
    /// Most significant byte first.
    Big,
    /// Least significant byte first.
    Little,
    /// Recognised from the zero byte of ON_POS_RANGE.
    Auto,
}

impl From<ReplyOrder> for Group3ReplyOrder {
    fn from(order: ReplyOrder) -> Self {
        match order {
            ReplyOrder::Big => Self::Fixed(ByteOrder::MsbFirst),
            ReplyOrder::Little => Self::Fixed(ByteOrder::LsbFirst),
            ReplyOrder::Auto => Self::Recognise,
        }
    }
}

/// Non-default readings; a field that is absent keeps the preset of the revision.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// Byte order of signed numbers.
    number_order: Option<Order>,
    /// Byte order of GEAR and LINE in Set_Param_Group3.
    group3_request_order: Option<Order>,
    /// Byte order of the 5-byte Read_Param_Group3 reply.
    group3_reply_order_12a: Option<ReplyOrder>,
    /// Byte order of the 6-byte Read_Param_Group3 reply.
    group3_reply_order_16a: Option<ReplyOrder>,
    /// Dummy byte on requests without arguments.
    read_dummy: Option<u8>,
    /// Accept positions beyond 28 bit.
    accept_beyond_28_bit: Option<bool>,
    /// Refuse numbers in more bytes than they need.
    strict_minimal: Option<bool>,
    /// Permit more than Sync_Trigger on identifier 0.
    allow_broadcast: Option<bool>,
    /// Permit Assign_Drive_ID to store 0.
    allow_assign_zero: Option<bool>,
    /// Data of Set_Origin: a number, or no byte at all.
    #[serde(
        alias = "set_origin_magic",
        alias = "set_origin_byte",
        default,
        deserialize_with = "set_origin"
    )]
    set_origin: Option<SetOriginData>,
    /// Set_Origin without data.
    #[serde(alias = "set_origin_dlc0")]
    set_origin_empty: Option<bool>,
    /// Torque at peak current.
    #[serde(alias = "full_scale", default, deserialize_with = "torque_full_scale")]
    torque_full_scale: Option<TorqueFullScale>,
}

impl Options {
    /// The same, with the printed order of the 6-byte Read_Param_Group3 reply where none is given: the order in which the vectors of
    /// refusals were made, before it was recognised by default (D20).
    pub fn with_printed_group3_order(self) -> Self {
        Self {
            group3_reply_order_16a: self.group3_reply_order_16a.or(Some(ReplyOrder::Little)),
            ..self
        }
    }

    /// The preset of the revision with these readings in place.
    ///
    /// `allow_broadcast` is one switch in the vectors and has two steps in [`ZeroAddress`]; it becomes `broadcast`.
    pub fn dialect(&self, revision: Revision, broadcast: ZeroAddress) -> Dialect {
        let preset = Dialect::of(revision);
        let order = |option: Option<Order>, preset| option.map_or(preset, ByteOrder::from);
        let group3_reply_order_1_6a = self
            .group3_reply_order_16a
            .map_or(preset.group3_reply_order_1_6a, Into::into);
        let empty = (self.set_origin_empty == Some(true)).then_some(SetOriginData::Empty);
        let zero_address = if self.allow_broadcast == Some(true) {
            broadcast
        } else {
            preset.zero_address
        };
        Dialect {
            revision,
            number_order: order(self.number_order, preset.number_order),
            group3_request_order: order(self.group3_request_order, preset.group3_request_order),
            group3_reply_order_1_2a: self
                .group3_reply_order_12a
                .map_or(preset.group3_reply_order_1_2a, Into::into),
            group3_reply_order_1_6a,
            set_origin: empty.or(self.set_origin).unwrap_or(preset.set_origin),
            torque_full_scale: self.torque_full_scale.unwrap_or(preset.torque_full_scale),
            positive_torque: preset.positive_torque,
            read_dummy: self.read_dummy.or(preset.read_dummy),
            accept_beyond_28_bit: self
                .accept_beyond_28_bit
                .unwrap_or(preset.accept_beyond_28_bit),
            strict_minimal: self.strict_minimal.unwrap_or(preset.strict_minimal),
            zero_address,
            allow_assign_zero: self.allow_assign_zero.unwrap_or(preset.allow_assign_zero),
        }
    }
}

/// A magic byte as a number, or `"empty"`.
fn set_origin<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<SetOriginData>, D::Error> {
    let value = Value::deserialize(deserializer)?;
    let magic = value.as_u64().and_then(|magic| u8::try_from(magic).ok());
    match (magic, value.as_str()) {
        (Some(magic), _) => Ok(Some(SetOriginData::Magic(magic))),
        (None, Some("empty" | "")) => Ok(Some(SetOriginData::Empty)),
        _ => Err(de::Error::custom(format!(
            "Set_Origin data must be 0..=255 or \"empty\", got {value}"
        ))),
    }
}

fn torque_full_scale<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<TorqueFullScale>, D::Error> {
    match i32::deserialize(deserializer)? {
        700 => Ok(Some(TorqueFullScale::Raw700)),
        981 => Ok(Some(TorqueFullScale::Raw981)),
        other => Err(de::Error::custom(format!(
            "torque full scale must be 700 or 981, got {other}"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_can::Rotation;

    fn dialect(json: &str) -> Result<Dialect, serde_json::Error> {
        let options: Options = serde_json::from_str(json)?;
        Ok(options.dialect(Revision::V1_6A, ZeroAddress::DisableAndSpeedZero))
    }

    #[test]
    fn no_option_is_the_preset() {
        assert_eq!(dialect("{}").unwrap(), Dialect::V1_6A);
    }

    #[test]
    fn every_option_changes_its_field() {
        let all = r#"{"number_order": "little", "group3_request_order": "little", "group3_reply_order_12a": "little",
            "group3_reply_order_16a": "auto", "read_dummy": 7, "accept_beyond_28_bit": true, "strict_minimal": true,
            "allow_broadcast": true, "allow_assign_zero": true, "set_origin": 255, "torque_full_scale": 700}"#;
        let expected = Dialect {
            revision: Revision::V1_6A,
            number_order: ByteOrder::LsbFirst,
            group3_request_order: ByteOrder::LsbFirst,
            group3_reply_order_1_2a: Group3ReplyOrder::Fixed(ByteOrder::LsbFirst),
            group3_reply_order_1_6a: Group3ReplyOrder::Recognise,
            set_origin: SetOriginData::Magic(0xFF),
            torque_full_scale: TorqueFullScale::Raw700,
            positive_torque: Rotation::Clockwise,
            read_dummy: Some(7),
            accept_beyond_28_bit: true,
            strict_minimal: true,
            zero_address: ZeroAddress::DisableAndSpeedZero,
            allow_assign_zero: true,
        };
        assert_eq!(dialect(all).unwrap(), expected);
        assert_eq!(
            dialect(r#"{"set_origin": "empty"}"#).unwrap().set_origin,
            SetOriginData::Empty
        );
        assert_eq!(
            dialect(r#"{"set_origin_empty": true}"#).unwrap().set_origin,
            SetOriginData::Empty
        );
    }

    #[test]
    fn an_unknown_option_is_not_skipped() {
        assert!(dialect(r#"{"number_ordr": "little"}"#).is_err());
        assert!(dialect(r#"{"number_order": "middle"}"#).is_err());
    }
}
