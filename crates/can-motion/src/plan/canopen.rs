//! DYN and CANopen on one bus: both use plain 11-bit identifiers, and what is a harmless service in one protocol moves motors
//! or zeroes positions in the other (D9).

use dyn_can::{Address, FunctionCode};

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

/// An identifier that means something in both protocols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Clash {
    /// The identifier.
    pub id: u16,
    /// What CANopen uses it for.
    pub service: CanopenService,
    /// The CANopen node, 0 for NMT and SYNC.
    pub node: u8,
    /// Which drive would take the frame for its own.
    pub address: Address,
    /// What that drive would take it for.
    pub function: FunctionCode,
}

impl Canopen {
    /// The first node id outside 1 ..= 127.
    pub(super) const fn invalid_node(&self) -> Option<u8> {
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
