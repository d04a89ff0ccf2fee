//! Node numbers and the identifiers that belong to them (guide section 3; CiA 301 predefined connection set).

use core::fmt;

use crate::error::{DecodeError, NodeError};

/// A drive on the bus, 1 ..= 127.
///
/// The DIP switch gives 1 ..= 3 and 4 ..= 127 are stored in 200Dh; the factory setting is 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NodeId(u8);

impl NodeId {
    /// Node 1.
    pub const MIN: Self = Self(1);
    /// Node 127.
    pub const MAX: Self = Self(127);
    /// Node 4, as a drive leaves the factory (200Dh).
    pub const FACTORY: Self = Self(4);

    /// Checks a node number.
    ///
    /// # Errors
    /// [`NodeError`] outside 1 ..= 127.
    pub const fn new(number: i32) -> Result<Self, NodeError> {
        if number < 1 || number > 127 {
            return Err(NodeError { actual: number });
        }
        Ok(Self(number as u8))
    }

    /// The number, 1 ..= 127.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// Every node in ascending order, for a scan.
    pub fn all() -> impl Iterator<Item = Self> {
        (Self::MIN.0..=Self::MAX.0).map(Self)
    }
}

impl TryFrom<i32> for NodeId {
    type Error = NodeError;

    fn try_from(number: i32) -> Result<Self, NodeError> {
        Self::new(number)
    }
}

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// One of the four PDOs of a direction. The guide counts them from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum PdoNumber {
    /// PDO 0, the first PDO of CiA 301.
    Pdo0,
    /// PDO 1.
    Pdo1,
    /// PDO 2.
    Pdo2,
    /// PDO 3.
    Pdo3,
}

impl PdoNumber {
    /// All four, in order.
    pub const ALL: [Self; 4] = [Self::Pdo0, Self::Pdo1, Self::Pdo2, Self::Pdo3];
}

impl fmt::Display for PdoNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (*self as u8).fmt(f)
    }
}

/// What an identifier is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Service {
    /// 000h: network management, master to all.
    Nmt,
    /// 080h: SYNC.
    Sync,
    /// 080h + node: emergency message of a drive. The guide prints 080h alone (Z21).
    Emcy(NodeId),
    /// 180h, 280h, 380h, 480h + node: process data from a drive.
    Tpdo(PdoNumber, NodeId),
    /// 200h, 300h, 400h, 500h + node: process data to a drive.
    Rpdo(PdoNumber, NodeId),
    /// 580h + node: SDO, drive to master.
    SdoReply(NodeId),
    /// 600h + node: SDO, master to drive.
    SdoRequest(NodeId),
    /// 700h + node: boot-up and heartbeat.
    Heartbeat(NodeId),
}

/// Function code of TPDO 0; the other PDOs follow in pairs of TPDO and RPDO.
const TPDO_0: u16 = 3;
/// Function code of SYNC and EMCY.
pub(crate) const EMCY: u16 = 1;
/// Function code of SDO replies.
pub(crate) const SDO_REPLY: u16 = 0xB;
/// Function code of SDO requests.
pub(crate) const SDO_REQUEST: u16 = 0xC;
/// Function code of boot-up and heartbeat.
pub(crate) const HEARTBEAT: u16 = 0xE;

impl Service {
    /// The identifier.
    #[must_use]
    pub const fn can_id(self) -> u16 {
        let (function, node) = match self {
            Self::Nmt => return 0,
            Self::Sync => return 0x080,
            Self::Emcy(node) => (EMCY, node),
            Self::Tpdo(number, node) => (TPDO_0 + 2 * number as u16, node),
            Self::Rpdo(number, node) => (TPDO_0 + 1 + 2 * number as u16, node),
            Self::SdoReply(node) => (SDO_REPLY, node),
            Self::SdoRequest(node) => (SDO_REQUEST, node),
            Self::Heartbeat(node) => (HEARTBEAT, node),
        };
        function << 7 | node.0 as u16
    }

    /// What an identifier is for.
    ///
    /// # Errors
    /// [`DecodeError::Node`] for node 0 of a service that has none, [`DecodeError::Service`] for identifiers that nothing here uses.
    pub const fn of(can_id: u16) -> Result<Self, DecodeError> {
        let number = (can_id & 0x7F) as u8;
        let function = can_id >> 7;
        match (function, number) {
            (0, 0) => return Ok(Self::Nmt),
            (1, 0) => return Ok(Self::Sync),
            (0 | 2 | 0xD | 0xF.., _) => return Err(DecodeError::Service { can_id }),
            (_, 0) => return Err(DecodeError::Node { can_id }),
            _ => {}
        }
        let node = NodeId(number);
        Ok(match function {
            EMCY => Self::Emcy(node),
            3 => Self::Tpdo(PdoNumber::Pdo0, node),
            4 => Self::Rpdo(PdoNumber::Pdo0, node),
            5 => Self::Tpdo(PdoNumber::Pdo1, node),
            6 => Self::Rpdo(PdoNumber::Pdo1, node),
            7 => Self::Tpdo(PdoNumber::Pdo2, node),
            8 => Self::Rpdo(PdoNumber::Pdo2, node),
            9 => Self::Tpdo(PdoNumber::Pdo3, node),
            0xA => Self::Rpdo(PdoNumber::Pdo3, node),
            SDO_REPLY => Self::SdoReply(node),
            SDO_REQUEST => Self::SdoRequest(node),
            _ => Self::Heartbeat(node),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_as_printed_for_node_4() {
        let node = NodeId::FACTORY;
        let expected = [
            (Service::Nmt, 0x000),
            (Service::Sync, 0x080),
            (Service::Emcy(node), 0x084),
            (Service::Tpdo(PdoNumber::Pdo0, node), 0x184),
            (Service::Rpdo(PdoNumber::Pdo0, node), 0x204),
            (Service::Rpdo(PdoNumber::Pdo1, node), 0x304),
            (Service::Tpdo(PdoNumber::Pdo3, node), 0x484),
            (Service::SdoReply(node), 0x584),
            (Service::SdoRequest(node), 0x604),
            (Service::Heartbeat(node), 0x704),
        ];
        for (service, can_id) in expected {
            assert_eq!(service.can_id(), can_id, "{service:?}");
        }
    }

    #[test]
    fn every_identifier_is_one_service_or_refused() {
        let mut services = 0;
        for can_id in 0..=0x7FF {
            match Service::of(can_id) {
                Ok(service) => {
                    assert_eq!(service.can_id(), can_id);
                    services += 1;
                }
                Err(DecodeError::Node { .. }) => assert_eq!(can_id & 0x7F, 0),
                Err(error) => assert_eq!(error, DecodeError::Service { can_id }),
            }
        }
        // Twelve services with 127 nodes each, NMT and SYNC.
        assert_eq!(services, 12 * 127 + 2);
    }

    #[test]
    fn node_0_and_128_do_not_exist() {
        assert_eq!(NodeId::new(0), Err(NodeError { actual: 0 }));
        assert_eq!(NodeId::new(128), Err(NodeError { actual: 128 }));
        assert_eq!(NodeId::all().count(), 127);
    }

    #[test]
    fn nodes_and_pdos_print_as_their_numbers() {
        let node = NodeId::new(127).unwrap();
        let numbers = PdoNumber::ALL.map(|number| std::format!("{number}"));
        assert_eq!(
            (std::format!("{node}"), numbers.concat()),
            ("127".into(), "0123".into())
        );
    }
}
