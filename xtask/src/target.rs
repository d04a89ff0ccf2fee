//! What a program is compiled for.

/// A target, and what it takes to compile for it.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Target {
    /// Its name.
    pub(crate) triple: &'static str,
    /// The libraries that are built when they are built from source.
    pub(crate) libraries: &'static str,
    /// The linker.
    pub(crate) linker: &'static str,
    /// The linker does not come with a compiler of Rust: it must be on the search path whatever the way is.
    pub(crate) linker_is_apart: bool,
    /// The packages of Debian that bring everything.
    pub(crate) packages: &'static [&'static str],
}
