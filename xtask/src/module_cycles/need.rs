//! Why one file needs another.

use std::fmt;
use std::path::PathBuf;

/// A need of one file, where it is first seen.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Need {
    pub(super) from: PathBuf,
    pub(super) line: usize,
    /// What the code says.
    pub(super) path: String,
    pub(super) to: PathBuf,
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}:{}: {} -> {}",
            self.from.display(),
            self.line,
            self.path,
            self.to.display()
        )
    }
}
