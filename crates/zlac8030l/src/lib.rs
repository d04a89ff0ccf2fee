#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod abort;
mod bit_rates;
mod control_word;
pub mod dictionary;
mod emcy;
mod error;
mod fault_code;
mod frame;
mod heartbeat_watch;
mod message;
mod nmt;
mod node;
mod object;
pub mod objects;
mod pdo;
mod sdo;
mod sdo_client;
mod set_up;
pub mod settings;
mod status_word;
mod typed_object;

pub use abort::AbortCode;
pub use bit_rates::{BIT_RATES, FACTORY_BIT_RATE, knows_bit_rate};
pub use can_frame::{DataFrame, FrameError};
pub use control_word::{ControlWord, Mode, MoveKind, TargetPositionError};
pub use emcy::{Emcy, Sync};
pub use error::{DecodeError, NodeError, WriteError};
pub use fault_code::FaultCode;
pub use frame::CanopenFrame;
pub use heartbeat_watch::{HeartbeatEvent, HeartbeatWatch};
pub use message::Message;
pub use nmt::{Heartbeat, NmtCommand, NmtRequest, NmtState};
pub use node::{NodeId, PdoNumber, Service};
pub use object::{DataType, ObjectAddress, ObjectData, ObjectValue, WidthError};
pub use pdo::{MAX_ENTRIES, MappingEntry, MappingError, PdoDirection, PdoMapping, PdoObjects};
pub use sdo::{SdoReply, SdoRequest};
pub use sdo_client::{
    SdoBusy, SdoClient, SdoEnd, SdoEvent, SdoHeard, SdoIgnored, SdoQuirks, SdoTimeouts,
};
pub use set_up::{
    Firmware, PdoSetUp, SetUp, SetUpError, SetUpOptions, SetUpReport, SetUpStep, Setting,
};
pub use status_word::{State, StatusWord};
pub use typed_object::Object;
