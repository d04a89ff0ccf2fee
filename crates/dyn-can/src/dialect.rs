//! The documented doubts, one small value.

use crate::byte_order::ByteOrder;
use crate::revision::Revision;

/// Data of Set_Origin: the text wants a magic byte, the tables print 0 and 1 data bytes (D13, D14).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SetOriginData {
    /// One magic byte.
    Magic(u8),
    /// No data byte.
    Empty,
}

/// Byte order of GEAR and LINE in a Read_Param_Group3 reply (D19, D20, D21).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Group3ReplyOrder {
    /// The order is known.
    Fixed(ByteOrder),
    /// Recognised in each reply.
    ///
    /// 1.6A: ON_POS_RANGE is 1..=127, so exactly one of its two bytes is zero. 1.2A, where it is one byte: the order in which gear
    /// number and line number are within their ranges; a reply that is within them in both orders, with different values, is refused.
    Recognise,
}

/// What may go to identifier 0, which every drive hears.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ZeroAddress {
    /// Sync_Trigger, the one documented use of broadcast.
    SyncTrigger,
    /// Also Servo_Disable with FF: every motor coasts (D7).
    Disable,
    /// Also Turn_ConstSpeed with 0. It brakes every motor, and it leaves every drive of 1.6A in speed mode, where it takes no
    /// set-points and holds no position (D7, D41).
    DisableAndSpeedZero,
    /// Any request: commissioning of one fresh drive that is alone on the bus (D2), and bus monitors.
    LoneFreshDrive,
}

/// How to read the documents where they leave a choice.
///
/// Start from [`Dialect::V1_2A`] or [`Dialect::V1_6A`] and change a field when a measurement on the drive says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Dialect {
    /// The revision, which decides which functions exist and the length of the group 3 reply.
    pub revision: Revision,
    /// Byte order of signed numbers: the documents have one example, MSB first (D18, D26).
    pub number_order: ByteOrder,
    /// Byte order of GEAR and LINE in Set_Param_Group3: not stated, MSB first by analogy (D21).
    pub group3_request_order: ByteOrder,
    /// Byte order of the 5-byte Read_Param_Group3 reply of 1.2A: not stated, recognised in each reply (D21). Sent MSB first then, by
    /// analogy.
    pub group3_reply_order_1_2a: Group3ReplyOrder,
    /// Byte order of the 6-byte Read_Param_Group3 reply of 1.6A: printed as little endian by a text that uses the word for both orders,
    /// so it is recognised in each reply (D20). Sent LSB first then, as printed.
    pub group3_reply_order_1_6a: Group3ReplyOrder,
    /// Data of Set_Origin: FF in 1.2A, AB in 1.6A (D13, D14). Never try the other one by itself.
    pub set_origin: SetOriginData,
    /// Torque at the drive's peak current: 700 in 1.2A, 981 in 1.6A (D28).
    pub torque_full_scale: TorqueFullScale,
    /// Direction of a positive torque: counter-clockwise in 1.2A, clockwise in 1.6A (D30).
    pub positive_torque: Rotation,
    /// A data byte on requests that need none, for the overview's "1~4 bytes data" (D11).
    pub read_dummy: Option<u8>,
    /// Accept a position reply beyond 28 bit: the text calls it 32-bit, the range is 28 bit (D16).
    pub accept_beyond_28_bit: bool,
    /// Refuse numbers in more bytes than they need. Off: accepted on receive, never sent (D25).
    pub strict_minimal: bool,
    /// What may be sent to identifier 0 (D2, D7).
    pub zero_address: ZeroAddress,
    /// Let Assign_Drive_ID store 0, the broadcast address (D2).
    pub allow_assign_zero: bool,
}

/// Torque that stands for the drive's peak current (D28).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TorqueFullScale {
    /// 700, revision 1.2A.
    Raw700,
    /// 981, revision 1.6A.
    Raw981,
}

impl TorqueFullScale {
    /// The raw torque at peak current.
    #[must_use]
    pub const fn get(self) -> i16 {
        match self {
            Self::Raw700 => 700,
            Self::Raw981 => 981,
        }
    }
}

/// Sense of rotation, seen from the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rotation {
    /// Clockwise.
    Clockwise,
    /// Counter-clockwise.
    CounterClockwise,
}

impl Dialect {
    /// The recommended reading of revision 1.2A.
    pub const V1_2A: Self = Self {
        revision: Revision::V1_2A,
        number_order: ByteOrder::MsbFirst,
        group3_request_order: ByteOrder::MsbFirst,
        group3_reply_order_1_2a: Group3ReplyOrder::Recognise,
        group3_reply_order_1_6a: Group3ReplyOrder::Recognise,
        set_origin: SetOriginData::Magic(0xFF),
        torque_full_scale: TorqueFullScale::Raw700,
        positive_torque: Rotation::CounterClockwise,
        read_dummy: None,
        accept_beyond_28_bit: false,
        strict_minimal: false,
        zero_address: ZeroAddress::SyncTrigger,
        allow_assign_zero: false,
    };

    /// The recommended reading of revision 1.6A.
    pub const V1_6A: Self = Self {
        revision: Revision::V1_6A,
        set_origin: SetOriginData::Magic(0xAB),
        torque_full_scale: TorqueFullScale::Raw981,
        positive_torque: Rotation::Clockwise,
        ..Self::V1_2A
    };

    /// The preset of a revision.
    #[must_use]
    pub const fn of(revision: Revision) -> Self {
        match revision {
            Revision::V1_2A => Self::V1_2A,
            Revision::V1_6A => Self::V1_6A,
        }
    }
}
