//! The name of the family.

/// ZLAC8030L hub-motor drives: each cycle a PDO with control word and target for each drive that is set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Zlac;
