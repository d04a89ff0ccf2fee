//! What a controller says about itself.

use core::fmt;

use crate::confinement::ErrorState;

/// State of a controller as software sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ControllerState {
    /// Switched off.
    Off,
    /// On, in one of the three error states.
    On(ErrorState),
}

impl fmt::Display for ControllerState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::On(ErrorState::Active) => "error-active",
            Self::On(ErrorState::Passive) => "error-passive",
            Self::On(ErrorState::BusOff) => "bus-off",
        })
    }
}

/// Why a controller refuses to work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ControllerError {
    /// The controller is switched off.
    Off,
    /// The controller is bus-off.
    BusOff {
        /// Its transmit error counter.
        tec: u16,
    },
}

impl fmt::Display for ControllerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("the controller is off; switch it on first"),
            Self::BusOff { tec } => {
                write!(
                    f,
                    "the controller is bus-off (transmit error counter {tec}, limit 255); request its recovery first"
                )
            }
        }
    }
}

impl core::error::Error for ControllerError {}

impl embedded_can::Error for ControllerError {
    fn kind(&self) -> embedded_can::ErrorKind {
        embedded_can::ErrorKind::Other
    }
}

/// What a controller has counted since it was made. Numbers of frames, unless stated otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Sent and acknowledged.
    pub tx_frames: u64,
    /// Attempts to send that ended in an error.
    pub tx_errors: u64,
    /// Refused: no room, off or bus-off.
    pub tx_refused: u64,
    /// Displaced by a frame of higher priority.
    pub tx_displaced: u64,
    /// Given up by an abort.
    pub tx_aborted: u64,
    /// Stored on the receive side.
    pub rx_frames: u64,
    /// Errors seen as a receiver.
    pub rx_errors: u64,
    /// Lost by a full receive FIFO.
    pub rx_overruns: u64,
    /// Lost because the fault model said so.
    pub rx_dropped: u64,
}
