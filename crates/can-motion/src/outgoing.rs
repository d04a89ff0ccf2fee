//! A frame that the master wants on the bus, and what it means to the books.

use dyn_can::{DataFrame, PdStep, Request, ServoSwitch};

/// What a frame is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) enum Purpose {
    SetPoint(PdStep),
    /// A reading, or the command of a procedure.
    Request(Request),
    Switch(ServoSwitch),
}

/// A frame to hand to the controller.
///
/// The books change only when `Master::on_accepted` gets it back: offering it twice, or never, counts nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub struct Outgoing {
    pub(crate) frame: DataFrame,
    pub(crate) axis: u8,
    pub(crate) purpose: Purpose,
}

impl AsRef<DataFrame> for Outgoing {
    fn as_ref(&self) -> &DataFrame {
        &self.frame
    }
}
