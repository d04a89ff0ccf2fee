//! What procedures of every family have in common.

/// The application's word for what is hard to undo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Confirmation {
    /// Nobody was asked.
    None,
    /// A person who knows the machine has agreed.
    Given,
}
