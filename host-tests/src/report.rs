//! The outcome of one vector file.

use std::fmt;

/// One vector that does not hold, or a file that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The vector's `id`; the file name when the whole file is at fault.
    pub id: String,
    /// The vector's `name`.
    pub name: String,
    /// What the vector says.
    pub expected: String,
    /// What the code under test says.
    pub actual: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} ({})", self.id, self.name)?;
        writeln!(f, "    expected: {}", self.expected)?;
        write!(f, "    actual:   {}", self.actual)
    }
}

/// What differs between a vector and the code under test.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// What the vector says.
    pub expected: String,
    /// What the code under test says.
    pub actual: String,
}

impl Mismatch {
    /// A vector that this harness does not understand.
    pub fn unreadable(actual: impl fmt::Display) -> Self {
        Self {
            expected: "a vector of the known schema".into(),
            actual: actual.to_string(),
        }
    }
}

/// `Ok` when both are equal, otherwise both with the name of what was compared.
///
/// # Errors
/// [`Mismatch`] with both values.
pub fn same<T: PartialEq + fmt::Debug>(
    what: &str,
    expected: &T,
    actual: &T,
) -> Result<(), Mismatch> {
    if expected == actual {
        return Ok(());
    }
    Err(Mismatch {
        expected: format!("{what} {expected:?}"),
        actual: format!("{what} {actual:?}"),
    })
}

/// All failures of one vector file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// The file name.
    pub file: String,
    /// Number of vectors that were checked.
    pub checked: usize,
    /// The vectors that do not hold.
    pub failures: Vec<Failure>,
}

impl Report {
    /// Prints the number of vectors checked.
    ///
    /// # Panics
    /// When a vector does not hold; the message lists every one of them.
    pub fn assert_passed(&self) {
        assert!(self.failures.is_empty(), "{self}");
        println!("{self}");
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (file, checked, failed) = (&self.file, self.checked, self.failures.len());
        write!(f, "{file}: {checked} vectors checked, {failed} failures")?;
        self.failures
            .iter()
            .try_for_each(|failure| write!(f, "\n{failure}"))
    }
}
