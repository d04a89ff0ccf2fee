//! The nodes of a command line.

use zlac8030l::NodeId;

use super::error::HubError;
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

/// One drive: by `--drive`, or the one behind `--drives`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct OneNode {
    /// Hub motors: zlac for node 4, zlac:NODE for another.
    #[arg(long, value_name = "zlac[:NODE]", value_parser = nodes)]
    drives: Nodes,
    /// Node number of the drive, in place of the one behind --drives.
    #[arg(long, value_name = "NODE", value_parser = node)]
    drive: Option<NodeId>,
}

impl OneNode {
    /// The node.
    ///
    /// # Errors
    /// [`HubError::Input`] when it is not exactly one.
    pub(super) fn get(&self) -> Result<NodeId, HubError> {
        match (self.drive, self.drives.0.as_slice()) {
            (Some(node), []) => Ok(node),
            (None, []) => Ok(NodeId::FACTORY),
            (None, [node]) => Ok(*node),
            (Some(node), [other]) if node == *other => Ok(node),
            _ => Err(HubError::Input(
                "this command is for one drive: name it once, with --drives zlac:NODE or --drive NODE"
                    .to_owned(),
            )),
        }
    }
}

/// Several drives.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct SomeNodes {
    /// Hub motors: zlac for node 4, zlac:NODES for others, as in zlac:4,5.
    #[arg(long, value_name = "zlac[:NODES]", value_parser = nodes)]
    drives: Nodes,
}

impl SomeNodes {
    /// The nodes in ascending order.
    pub(super) fn ascending(&self) -> Vec<NodeId> {
        self.drives.ascending()
    }

    /// The nodes in the order given.
    pub(super) fn in_order(&self) -> Vec<NodeId> {
        self.drives.or_factory()
    }

    /// The nodes were named.
    pub(super) fn are_named(&self) -> bool {
        !self.drives.0.is_empty()
    }
}

/// A node number.
pub(super) fn node(text: &str) -> Result<NodeId, String> {
    let number: i32 = text.parse().map_err(|_| "expected a number".to_owned())?;
    NodeId::new(number).map_err(|error| error.to_string())
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
