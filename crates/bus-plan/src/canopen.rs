//! CANopen devices beside drives of another protocol: both use plain 11-bit identifiers, and what is a harmless service in one
//! protocol may move motors in the other.

/// CANopen devices on the bus of the drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Canopen {
    /// Their node ids, 1 ..= 127.
    pub nodes: &'static [u8],
    /// Somebody sends NMT commands (identifier 0x000). Without them the devices stay pre-operational: SDO, but no PDO.
    pub uses_nmt: bool,
    /// Somebody sends SYNC (identifier 0x080).
    pub uses_sync: bool,
}

/// What a CANopen identifier is for (CiA 301, predefined connection set).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CanopenService {
    /// Network management command, 0x000.
    Nmt,
    /// SYNC, 0x080.
    Sync,
    /// Emergency of a node, 0x080 + n.
    Emergency,
    /// One of the four transmit and four receive PDOs of a node, 0x180 + n ..= 0x500 + n.
    Pdo,
    /// SDO of a node, 0x580 + n and 0x600 + n.
    Sdo,
    /// Heartbeat of a node, 0x700 + n.
    Heartbeat,
}

impl CanopenService {
    /// The usual name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nmt => "NMT",
            Self::Sync => "SYNC",
            Self::Emergency => "emergency",
            Self::Pdo => "PDO",
            Self::Sdo => "SDO",
            Self::Heartbeat => "heartbeat",
        }
    }
}

/// An identifier on which the CANopen devices of a bus send or listen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identifier {
    /// The identifier.
    pub id: u16,
    /// What CANopen uses it for.
    pub service: CanopenService,
    /// The CANopen node, 0 for NMT and SYNC.
    pub node: u8,
}

/// An identifier that means something in both protocols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Clash {
    /// The identifier, and what it is to CANopen.
    pub canopen: Identifier,
    /// The number of the drive that would take the frame for its own; `None` for every drive.
    pub drive: Option<u8>,
    /// What it would take the frame for, by the name of its protocol.
    pub meaning: &'static str,
}

const NODE_SERVICES: [(u16, CanopenService); 12] = [
    (0x080, CanopenService::Emergency),
    (0x180, CanopenService::Pdo),
    (0x200, CanopenService::Pdo),
    (0x280, CanopenService::Pdo),
    (0x300, CanopenService::Pdo),
    (0x380, CanopenService::Pdo),
    (0x400, CanopenService::Pdo),
    (0x480, CanopenService::Pdo),
    (0x500, CanopenService::Pdo),
    (0x580, CanopenService::Sdo),
    (0x600, CanopenService::Sdo),
    (0x700, CanopenService::Heartbeat),
];

impl Canopen {
    /// No devices.
    pub const NONE: Self = Self {
        nodes: &[],
        uses_nmt: false,
        uses_sync: false,
    };

    /// The identifier in this place: first NMT and SYNC, then those of each node; `None` behind the last. A family walks through
    /// them and says which one of its drives would take for its own ([`Clash`]).
    #[must_use]
    pub const fn identifier(&self, place: usize) -> Option<Identifier> {
        let before_nodes = self.uses_nmt as usize + self.uses_sync as usize;
        let (id, service, node) = if let Some(of_nodes) = place.checked_sub(before_nodes) {
            let services = NODE_SERVICES.len();
            let (Some((_, [node, ..])), Some((_, [(base, service), ..]))) = (
                self.nodes.split_at_checked(of_nodes / services),
                NODE_SERVICES.split_at_checked(of_nodes % services),
            ) else {
                return None;
            };
            (*base + *node as u16, *service, *node)
        } else if place == 0 && self.uses_nmt {
            (0x000, CanopenService::Nmt, 0)
        } else {
            (0x080, CanopenService::Sync, 0)
        };
        Some(Identifier { id, service, node })
    }

    /// The first node id outside 1 ..= 127.
    pub(crate) const fn invalid_node(&self) -> Option<u8> {
        let mut rest = self.nodes;
        while let Some((node, behind)) = rest.split_first() {
            if *node == 0 || *node > 127 {
                return Some(*node);
            }
            rest = behind;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn identifiers(canopen: Canopen) -> Vec<(u16, CanopenService, u8)> {
        (0..)
            .map_while(|place| canopen.identifier(place))
            .map(|Identifier { id, service, node }| (id, service, node))
            .collect()
    }

    #[test]
    fn nmt_and_sync_come_before_the_nodes() {
        let mut canopen = Canopen {
            nodes: &[3, 127],
            uses_nmt: true,
            uses_sync: true,
        };
        let all = identifiers(canopen);
        assert_eq!(all.len(), 2 + 2 * 12);
        assert_eq!(all[0], (0x000, CanopenService::Nmt, 0));
        assert_eq!(all[1], (0x080, CanopenService::Sync, 0));
        assert_eq!(all[2], (0x083, CanopenService::Emergency, 3));
        assert_eq!(all[13], (0x703, CanopenService::Heartbeat, 3));
        assert_eq!(all[25], (0x77F, CanopenService::Heartbeat, 127));
        canopen.uses_nmt = false;
        assert_eq!(identifiers(canopen), all[1..]);
        canopen.uses_sync = false;
        assert_eq!(identifiers(canopen), all[2..]);
        assert_eq!(identifiers(Canopen::NONE), []);
    }

    #[test]
    fn node_ids_end_at_127() {
        let canopen = Canopen {
            nodes: &[127, 128],
            ..Canopen::NONE
        };
        assert_eq!(canopen.invalid_node(), Some(128));
        assert_eq!(Canopen::NONE.invalid_node(), None);
    }
}
