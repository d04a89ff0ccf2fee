//! The three parameter groups (1.6A section 6, #16 to #21).

use can_frame::DataFrame;
use dyn_values::{
    GearNumber, IntegrationGain, LineNumber, MainGain, MaxAcceleration, MaxSpeed, OnPosRange,
    RangeError, SpeedGain, TorqueFilter,
};

use crate::byte_order::ByteOrder;
use crate::dialect::{Dialect, Group3ReplyOrder};
use crate::error::DecodeError;
use crate::frame::Payload;
use crate::revision::Revision;

/// Parameter group 1 as a drive reports it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParamGroup1 {
    /// First byte.
    pub main_gain: MainGain,
    /// Second byte.
    pub speed_gain: SpeedGain,
    /// Third byte.
    pub integration_gain: IntegrationGain,
    /// Fourth byte.
    pub torque_filter: TorqueFilter,
}

/// A change of parameter group 1; `None` keeps the stored value. Each write wears the EEPROM.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetParamGroup1 {
    /// First byte.
    pub main_gain: Option<MainGain>,
    /// Second byte.
    pub speed_gain: Option<SpeedGain>,
    /// Third byte.
    pub integration_gain: Option<IntegrationGain>,
    /// Fourth byte.
    pub torque_filter: Option<TorqueFilter>,
}

/// Parameter group 2 as a drive reports it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParamGroup2 {
    /// First byte.
    pub max_speed: MaxSpeed,
    /// Second byte.
    pub max_acceleration: MaxAcceleration,
}

/// A change of parameter group 2; `None` keeps the stored value.
///
/// The first 10 writes after power-on go to the EEPROM, later ones are lost at power-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetParamGroup2 {
    /// First byte.
    pub max_speed: Option<MaxSpeed>,
    /// Second byte.
    pub max_acceleration: Option<MaxAcceleration>,
}

/// Parameter group 3 as a drive reports it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParamGroup3 {
    /// On-position range.
    pub on_pos_range: OnPosRange,
    /// Gear number.
    pub gear_number: GearNumber,
    /// Line number; `None` for 0, from a drive that has no such parameter (D24).
    pub line_number: Option<LineNumber>,
}

/// A change of parameter group 3; `None` keeps the stored value. Each write wears the EEPROM.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetParamGroup3 {
    /// One byte. 127 also turns JP3-9 into the brake output after the next power cycle (D54).
    pub on_pos_range: Option<OnPosRange>,
    /// Two bytes; zero means keep only when both are zero (D22).
    pub gear_number: Option<GearNumber>,
    /// Two bytes.
    pub line_number: Option<LineNumber>,
}

/// 0 keeps the stored value.
fn optional<T>(
    raw: i32,
    new: impl FnOnce(i32) -> Result<T, RangeError>,
) -> Result<Option<T>, RangeError> {
    if raw == 0 {
        Ok(None)
    } else {
        new(raw).map(Some)
    }
}

fn u16_bytes(value: u16, order: ByteOrder) -> [u8; 2] {
    match order {
        ByteOrder::MsbFirst => value.to_be_bytes(),
        ByteOrder::LsbFirst => value.to_le_bytes(),
    }
}

fn u16_value(bytes: [u8; 2], order: ByteOrder) -> i32 {
    i32::from(match order {
        ByteOrder::MsbFirst => u16::from_be_bytes(bytes),
        ByteOrder::LsbFirst => u16::from_le_bytes(bytes),
    })
}

impl ParamGroup1 {
    pub(crate) fn payload(self) -> Payload {
        Payload::from_word(
            [
                self.main_gain.get(),
                self.speed_gain.get(),
                self.integration_gain.get(),
                self.torque_filter.get(),
            ],
            4,
        )
    }

    pub(crate) fn decode(data: [u8; 4]) -> Result<Self, RangeError> {
        let [main, speed, integration, filter] = data.map(i32::from);
        Ok(Self {
            main_gain: MainGain::new(main)?,
            speed_gain: SpeedGain::new(speed)?,
            integration_gain: IntegrationGain::new(integration)?,
            torque_filter: TorqueFilter::new(filter)?,
        })
    }
}

impl SetParamGroup1 {
    pub(crate) fn payload(self) -> Payload {
        Payload::from_word(
            [
                self.main_gain.map_or(0, MainGain::get),
                self.speed_gain.map_or(0, SpeedGain::get),
                self.integration_gain.map_or(0, IntegrationGain::get),
                self.torque_filter.map_or(0, TorqueFilter::get),
            ],
            4,
        )
    }

    pub(crate) fn decode(data: [u8; 4]) -> Result<Self, RangeError> {
        let [main, speed, integration, filter] = data.map(i32::from);
        Ok(Self {
            main_gain: optional(main, MainGain::new)?,
            speed_gain: optional(speed, SpeedGain::new)?,
            integration_gain: optional(integration, IntegrationGain::new)?,
            torque_filter: optional(filter, TorqueFilter::new)?,
        })
    }
}

impl ParamGroup2 {
    pub(crate) fn payload(self) -> Payload {
        Payload::from_word([self.max_speed.get(), self.max_acceleration.get(), 0, 0], 2)
    }

    pub(crate) fn decode(data: [u8; 4]) -> Result<Self, RangeError> {
        let [speed, acceleration, ..] = data.map(i32::from);
        Ok(Self {
            max_speed: MaxSpeed::new(speed)?,
            max_acceleration: MaxAcceleration::new(acceleration)?,
        })
    }
}

impl SetParamGroup2 {
    pub(crate) fn payload(self) -> Payload {
        let speed = self.max_speed.map_or(0, MaxSpeed::get);
        let acceleration = self.max_acceleration.map_or(0, MaxAcceleration::get);
        Payload::from_word([speed, acceleration, 0, 0], 2)
    }

    pub(crate) fn decode(data: [u8; 4]) -> Result<Self, RangeError> {
        let [speed, acceleration, ..] = data.map(i32::from);
        Ok(Self {
            max_speed: optional(speed, MaxSpeed::new)?,
            max_acceleration: optional(acceleration, MaxAcceleration::new)?,
        })
    }
}

impl ParamGroup3 {
    pub(crate) fn payload(self, dialect: &Dialect) -> Payload {
        let line = self.line_number.map_or(0, LineNumber::get);
        // A reply that is to be recognised may be sent in either order; 1.6A prints LSB first, 1.2A follows its requests.
        let (order, usual) = match dialect.revision {
            Revision::V1_2A => (dialect.group3_reply_order_1_2a, ByteOrder::MsbFirst),
            Revision::V1_6A => (dialect.group3_reply_order_1_6a, ByteOrder::LsbFirst),
        };
        let order = match order {
            Group3ReplyOrder::Fixed(order) => order,
            Group3ReplyOrder::Recognise => usual,
        };
        let [a, b] = u16_bytes(u16::from(self.on_pos_range.get()), order);
        let [c, d] = u16_bytes(self.gear_number.get(), order);
        let [e, f] = u16_bytes(line, order);
        match dialect.revision {
            Revision::V1_2A => Payload::five([self.on_pos_range.get(), c, d, e, f]),
            Revision::V1_6A => Payload::six([a, b, c, d, e, f]),
        }
    }

    pub(crate) fn decode(frame: &DataFrame, dialect: &Dialect) -> Result<Self, DecodeError> {
        let [a, b, c, d, e, f, ..] = *frame.bytes();
        match dialect.revision {
            Revision::V1_2A => {
                let read = |order| Self::from_raw(i32::from(a), [b, c], [d, e], order);
                match dialect.group3_reply_order_1_2a {
                    Group3ReplyOrder::Fixed(order) => read(order),
                    Group3ReplyOrder::Recognise => {
                        the_one_order(read(ByteOrder::MsbFirst), read(ByteOrder::LsbFirst))
                    }
                }
            }
            Revision::V1_6A => {
                let order = match dialect.group3_reply_order_1_6a {
                    Group3ReplyOrder::Fixed(order) => order,
                    Group3ReplyOrder::Recognise => recognise_order([a, b])?,
                };
                Self::from_raw(u16_value([a, b], order), [c, d], [e, f], order)
            }
        }
    }

    fn from_raw(
        on_pos_range: i32,
        gear: [u8; 2],
        line: [u8; 2],
        order: ByteOrder,
    ) -> Result<Self, DecodeError> {
        Ok(Self {
            on_pos_range: OnPosRange::new(on_pos_range)?,
            gear_number: GearNumber::new(u16_value(gear, order))?,
            line_number: optional(u16_value(line, order), LineNumber::new)?,
        })
    }
}

/// ON_POS_RANGE is 1..=127, so exactly one of its two bytes is zero (D20).
fn recognise_order(on_pos_range: [u8; 2]) -> Result<ByteOrder, DecodeError> {
    match on_pos_range {
        [1..=127, 0] => Ok(ByteOrder::LsbFirst),
        [0, 1..=127] => Ok(ByteOrder::MsbFirst),
        _ => Err(DecodeError::ByteOrder { on_pos_range }),
    }
}

/// The reading that is within its ranges; two different ones that both are leave the gear number open (D21).
fn the_one_order(
    msb_first: Result<ParamGroup3, DecodeError>,
    lsb_first: Result<ParamGroup3, DecodeError>,
) -> Result<ParamGroup3, DecodeError> {
    match (msb_first, lsb_first) {
        (Ok(msb), Ok(lsb)) if msb != lsb => Err(DecodeError::OrderUnknown {
            msb_first: msb.gear_number.get(),
            lsb_first: lsb.gear_number.get(),
        }),
        (Err(_), Ok(lsb)) => Ok(lsb),
        (msb, _) => msb,
    }
}

impl SetParamGroup3 {
    pub(crate) fn payload(self, order: ByteOrder) -> Payload {
        let [b, c] = u16_bytes(self.gear_number.map_or(0, GearNumber::get), order);
        let [d, e] = u16_bytes(self.line_number.map_or(0, LineNumber::get), order);
        Payload::five([self.on_pos_range.map_or(0, OnPosRange::get), b, c, d, e])
    }

    pub(crate) fn decode(frame: &DataFrame, order: ByteOrder) -> Result<Self, RangeError> {
        let [on_pos_range, b, c, d, e, ..] = *frame.bytes();
        Ok(Self {
            on_pos_range: optional(i32::from(on_pos_range), OnPosRange::new)?,
            gear_number: optional(u16_value([b, c], order), GearNumber::new)?,
            line_number: optional(u16_value([d, e], order), LineNumber::new)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group3() -> ParamGroup3 {
        ParamGroup3 {
            on_pos_range: OnPosRange::new(20).unwrap(),
            gear_number: GearNumber::new(4096).unwrap(),
            line_number: Some(LineNumber::new(2500).unwrap()),
        }
    }

    #[test]
    fn group_3_reply_has_two_layouts() {
        assert_eq!(
            group3().payload(&Dialect::V1_2A).as_slice(),
            [0x14, 0x10, 0x00, 0x09, 0xC4]
        );
        assert_eq!(
            group3().payload(&Dialect::V1_6A).as_slice(),
            [0x14, 0x00, 0x00, 0x10, 0xC4, 0x09]
        );
    }

    #[test]
    fn group_3_byte_order_recognises_itself() {
        let recognise = Dialect::V1_6A;
        for bytes in [
            [0x14, 0x00, 0x00, 0x10, 0xC4, 0x09],
            [0x00, 0x14, 0x10, 0x00, 0x09, 0xC4],
        ] {
            let frame = DataFrame::new(0x075, &bytes).unwrap();
            assert_eq!(ParamGroup3::decode(&frame, &recognise), Ok(group3()));
        }
        let neither = DataFrame::new(0x075, &[0, 0, 0x10, 0x00, 0x09, 0xC4]).unwrap();
        assert_eq!(
            ParamGroup3::decode(&neither, &recognise),
            Err(DecodeError::ByteOrder {
                on_pos_range: [0, 0]
            })
        );
    }

    fn of_1_2a(bytes: [u8; 5], dialect: &Dialect) -> Result<(u16, Option<u16>), DecodeError> {
        let frame = DataFrame::new(0x075, &bytes).unwrap();
        ParamGroup3::decode(&frame, dialect).map(|group| {
            (
                group.gear_number.get(),
                group.line_number.map(LineNumber::get),
            )
        })
    }

    #[test]
    fn group_3_of_1_2a_is_read_in_the_one_order_that_fits() {
        let read = |bytes| of_1_2a(bytes, &Dialect::V1_2A);
        // 4096 and 2500, MSB first and LSB first; 4096 without a line number, both ways.
        assert_eq!(read([20, 0x10, 0x00, 0x09, 0xC4]), Ok((4096, Some(2500))));
        assert_eq!(read([20, 0x00, 0x10, 0xC4, 0x09]), Ok((4096, Some(2500))));
        assert_eq!(read([20, 0x10, 0x00, 0x00, 0x00]), Ok((4096, None)));
        assert_eq!(read([20, 0x00, 0x10, 0x00, 0x00]), Ok((4096, None)));
        // 0808h is the same number in both orders.
        assert_eq!(read([20, 0x08, 0x08, 0x00, 0x00]), Ok((2056, None)));
        // 2000 or 53255: one of them is a gear number.
        assert_eq!(read([20, 0x07, 0xD0, 0x00, 0x00]), Ok((2000, None)));
        // The gear number fits both ways, the line number one way: 1000 fits, E803h does not.
        assert_eq!(read([20, 0x10, 0x08, 0x03, 0xE8]), Ok((4104, Some(1000))));
        assert_eq!(read([20, 0x10, 0x08, 0xE8, 0x03]), Ok((2064, Some(1000))));
    }

    #[test]
    fn group_3_of_1_2a_that_fits_both_orders_is_refused_and_may_be_fixed() {
        let ambiguous = [20, 0x10, 0x08, 0x00, 0x00];
        let both = DecodeError::OrderUnknown {
            msb_first: 4104,
            lsb_first: 2064,
        };
        assert_eq!(of_1_2a(ambiguous, &Dialect::V1_2A), Err(both));
        for (order, gear) in [(ByteOrder::MsbFirst, 4104), (ByteOrder::LsbFirst, 2064)] {
            let fixed = Dialect {
                group3_reply_order_1_2a: Group3ReplyOrder::Fixed(order),
                ..Dialect::V1_2A
            };
            assert_eq!(of_1_2a(ambiguous, &fixed), Ok((gear, None)));
        }
        // Neither order: said in the usual one.
        assert!(matches!(
            of_1_2a([20, 0x00, 0x01, 0x00, 0x00], &Dialect::V1_2A),
            Err(DecodeError::Range(_))
        ));
    }

    #[test]
    fn a_gear_with_a_zero_byte_is_not_keep() {
        // D22: 4096 is 10 00 on the wire.
        let set = SetParamGroup3 {
            gear_number: GearNumber::new(4096).ok(),
            ..Default::default()
        };
        let payload = set.payload(ByteOrder::MsbFirst);
        assert_eq!(payload.as_slice(), [0x00, 0x10, 0x00, 0x00, 0x00]);
        let frame = DataFrame::new(0x072, payload.as_slice()).unwrap();
        assert_eq!(SetParamGroup3::decode(&frame, ByteOrder::MsbFirst), Ok(set));
    }
}
