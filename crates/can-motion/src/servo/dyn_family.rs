//! The name of the family.

/// DYN2 and DYN4 servo drives: each cycle a `Go_Relative_Pos_PD` for each axis in motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dyn;
