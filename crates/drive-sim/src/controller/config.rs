//! How a controller is set up.

use crate::mailbox::TxOrder;
use crate::receive::{AcceptanceFilter, Overrun, RxQueue};

/// Transmit side of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TxQueue {
    /// Three mailboxes, as in hardware.
    Mailboxes(TxOrder),
    /// Three mailboxes in the order of request with an unbounded queue behind them, for simulated devices whose software is not under test.
    Unbounded,
}

/// How a controller is set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ControllerConfig {
    /// Transmit side.
    pub tx: TxQueue,
    /// Receive side.
    pub rx: RxQueue,
    /// Which frames are stored.
    pub filter: AcceptanceFilter,
}

impl ControllerConfig {
    /// Three mailboxes in the given order, a three-deep receive FIFO that overwrites, every frame accepted.
    pub const fn bxcan(order: TxOrder) -> Self {
        Self {
            tx: TxQueue::Mailboxes(order),
            rx: RxQueue::Fifo(Overrun::Overwrite),
            filter: AcceptanceFilter::ALL,
        }
    }

    /// Unbounded on both sides, every frame accepted: for simulated devices.
    pub const fn device() -> Self {
        Self {
            tx: TxQueue::Unbounded,
            rx: RxQueue::Unbounded,
            filter: AcceptanceFilter::ALL,
        }
    }

    /// The same with another acceptance filter.
    pub const fn with_filter(self, filter: AcceptanceFilter) -> Self {
        Self { filter, ..self }
    }
}
