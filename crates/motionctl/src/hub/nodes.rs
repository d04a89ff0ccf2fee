//! The nodes of a command line.

use zlac8030l::NodeId;

use crate::drive_ids::{DriveSet, drive_set};

/// The nodes behind `--drives zlac`; none are named by `zlac` alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Nodes(Vec<NodeId>);

impl Nodes {
    /// The nodes that were named, or the one that a drive has when it leaves the factory.
    pub(super) fn or_factory(&self) -> Vec<NodeId> {
        match self.0.as_slice() {
            [] => vec![NodeId::FACTORY],
            named => named.to_vec(),
        }
    }

    /// The nodes that were named, in ascending order.
    pub(super) fn ascending(&self) -> Vec<NodeId> {
        let mut nodes = self.or_factory();
        nodes.sort_unstable();
        nodes
    }
}

/// `zlac` or `zlac:4,5`.
pub(super) fn nodes(text: &str) -> Result<Nodes, String> {
    match drive_set(text)? {
        DriveSet::Zlac(nodes) => Ok(Nodes(nodes)),
        DriveSet::Dyn(_) => Err("expected zlac or zlac:NODES".to_owned()),
    }
}

/// The nodes for a message, as in `node 4` and `nodes 4, 5`.
pub(super) fn named(nodes: &[NodeId]) -> String {
    let numbers: Vec<String> = nodes.iter().map(ToString::to_string).collect();
    match numbers.as_slice() {
        [number] => format!("node {number}"),
        numbers => format!("nodes {}", numbers.join(", ")),
    }
}
