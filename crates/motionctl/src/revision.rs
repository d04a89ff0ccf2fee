//! The revision of the drives as an option.

use clap::ValueEnum;
use dyn_can::Revision;

/// A published revision of the CAN specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum RevisionOption {
    /// CAN specification 1.2A.
    #[value(name = "1.2A", alias = "1.2a")]
    V1_2A,
    /// CAN specification 1.6A.
    #[default]
    #[value(name = "1.6A", alias = "1.6a")]
    V1_6A,
}

impl From<RevisionOption> for Revision {
    fn from(option: RevisionOption) -> Self {
        match option {
            RevisionOption::V1_2A => Self::V1_2A,
            RevisionOption::V1_6A => Self::V1_6A,
        }
    }
}
