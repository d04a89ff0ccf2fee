//! What the user asks for.

/// Seeds small mistakes into a part of a crate and counts those that its tests find; goes on where the last run stopped.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**'                      all that is left\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**' --minutes 60         one hour of it\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**' --shard 0/4          a quarter of it\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**' --in-diff main       only what changed since main\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**' -- --lib core        with these tests\n\n\
    Results are kept in target/mutants; those of a source file are dropped when the file changes. --again tests survivors\n\
    anew, after a test was added. Needs `cargo install cargo-mutants --locked`.")]
pub(crate) struct Arguments {
    /// The package
    #[arg(long, value_name = "PACKAGE")]
    pub(crate) package: String,

    /// The files to change, a glob below the folder of the package
    #[arg(long, value_name = "GLOB", default_value = "src/**")]
    pub(crate) path: String,

    /// Only part k of n, counted from 0
    #[arg(long, value_name = "K/N")]
    pub(crate) shard: Option<String>,

    /// Only lines that differ from this revision
    #[arg(long, value_name = "REVISION")]
    pub(crate) in_diff: Option<String>,

    /// Stop after so many minutes; the next run goes on
    #[arg(long, value_name = "MINUTES")]
    pub(crate) minutes: Option<u64>,

    /// Percentage that must be found
    #[arg(long, value_name = "PERCENT", default_value_t = 95, value_parser = clap::value_parser!(u8).range(0..=100))]
    pub(crate) at_least: u8,

    /// Test survivors of earlier runs anew
    #[arg(long)]
    pub(crate) again: bool,

    /// Further arguments for `cargo test`
    #[arg(last = true, value_name = "TEST ARGUMENTS")]
    pub(crate) tests: Vec<String>,
}
