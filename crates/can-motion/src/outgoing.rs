//! A frame that the master wants on the bus, and what it means to the books.

use crate::dyn_axes::Dyn;
use crate::family::{Family, Switch};

/// What a frame is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose<F: Family> {
    SetPoint(F::SetPoint),
    /// A reading, or the command of a procedure.
    Request(F::Request),
    Switch(Switch),
    /// What goes out once a cycle and concerns no axis.
    Cycle,
}

/// A frame to hand to the controller.
///
/// The books change only when `Master::on_accepted` gets it back: offering it twice, or never, counts nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub struct Outgoing<F: Family = Dyn> {
    pub(crate) frame: F::Frame,
    /// The axis concerned; `None` for a frame of the whole bus.
    pub(crate) axis: Option<u8>,
    pub(crate) purpose: Purpose<F>,
}

impl<F: Family> AsRef<F::Frame> for Outgoing<F> {
    fn as_ref(&self) -> &F::Frame {
        &self.frame
    }
}
