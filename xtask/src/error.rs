//! What can stop a task.

use std::fmt;
use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;

use crate::target::Target;

/// Why a task stopped. The text says what to do about it.
#[derive(Debug)]
#[non_exhaustive]
pub(crate) enum Error {
    /// A program could not be started.
    Start {
        /// The program as it was called.
        program: String,
        /// The reason given by the system.
        reason: io::Error,
    },
    /// What a task found could not be printed.
    Output {
        /// The reason given by the system.
        reason: io::Error,
    },
    /// A program ended with a failure; it has said why itself.
    Failed {
        /// The program as it was called.
        program: String,
        /// How it ended.
        status: ExitStatus,
    },
    /// A program answered something else than it should.
    Answer {
        /// The program as it was called.
        program: String,
        /// What was expected of it.
        expected: &'static str,
    },
    /// Nothing ran in a context.
    Context {
        /// The context that was asked for.
        actual: String,
        /// Those in which something ran.
        known: Vec<String>,
    },
    /// There is no way to compile for the target on this machine.
    NoToolchain {
        /// The target.
        target: &'static Target,
        /// Each way that was tried and what it lacks.
        tried: Vec<String>,
    },
    /// A tool is not where it was installed.
    MissingTool {
        /// The tool.
        tool: &'static str,
        /// Where it should be.
        place: PathBuf,
    },
    /// An image linked although it can panic.
    Linked {
        /// The image.
        image: &'static str,
    },
    /// An image takes more flash than it may.
    TooLarge {
        /// The image.
        image: &'static str,
        /// What it may take, in bytes.
        limit: u64,
        /// What it takes, in bytes.
        actual: u64,
    },
    /// A package that shall have no dependency has some.
    Dependencies {
        /// The package.
        package: &'static str,
        /// What it depends on.
        found: Vec<String>,
    },
    /// Something costs more than before.
    Risen {
        /// How many figures have risen.
        figures: usize,
    },
    /// Patches of the recipes do not apply or fail.
    Recipes {
        /// What is wrong with each.
        complaints: Vec<String>,
    },
    /// Steps of the checks failed; they have said why.
    Checks {
        /// Their names.
        failed: Vec<&'static str>,
    },
    /// A package that the workspace does not have.
    UnknownPackage {
        /// Its name.
        package: String,
    },
    /// A source file could not be read.
    Source {
        /// The file.
        path: PathBuf,
        /// What was wrong with it, with the line where there is one.
        reason: String,
    },
    /// cargo-mutants is missing or does not understand.
    MutantsMissing {
        /// How it ended.
        status: ExitStatus,
    },
    /// Too many seeded mistakes were not found.
    Survivors {
        /// The share that was found.
        found_percent: usize,
        /// The share that must be found.
        at_least_percent: u8,
    },
    /// Files of a crate need each other.
    ModuleCycles {
        /// The number of ways around that were printed.
        cycles: usize,
    },
    /// The built image could not be read.
    Image {
        /// Where it should be.
        path: PathBuf,
        /// What was wrong with it.
        reason: String,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Output { reason } => write!(f, "cannot write to standard output: {reason}"),
            Self::Start { program, reason } => write!(f, "cannot run {program}: {reason}"),
            Self::Failed { program, status } => write!(f, "{program} failed ({status})"),
            Self::Answer { program, expected } => write!(f, "{program} did not print {expected}"),
            Self::Context { actual, known } => write!(
                f,
                "--context: expected one of {}, in which something ran, got {actual}",
                known.join(", ")
            ),
            Self::UnknownPackage { package } => write!(
                f,
                "the workspace has no package {package}: `cargo metadata --no-deps` lists them"
            ),
            Self::Source { path, reason } => write!(f, "{}: {reason}", path.display()),
            Self::MutantsMissing { status } => write!(
                f,
                "cargo mutants --list failed ({status}): where it is missing, `cargo install cargo-mutants --locked` installs it"
            ),
            Self::Survivors {
                found_percent,
                at_least_percent,
            } => write!(
                f,
                "expected at least {at_least_percent} % of the mistakes to be found, got {found_percent} %: see the survivors above"
            ),
            Self::ModuleCycles { cycles } => write!(
                f,
                "{cycles} cycles of files: break each at one of the lines above, see `cargo xtask module-cycles --help`"
            ),
            Self::Image { path, reason } => write!(f, "{}: {reason}", path.display()),
            Self::MissingTool { tool, place } => write!(
                f,
                "there is no {tool} below {}: remove that folder and try again, or set LIBCLANG_PATH",
                place.display()
            ),
            Self::Linked { image } => write!(
                f,
                "{image} links although it can panic: the other images prove nothing, look at their panic handler"
            ),
            Self::TooLarge {
                image,
                limit,
                actual,
            } => write!(
                f,
                "{image} may take {limit} bytes of flash and takes {actual}: find what has grown, it is linked alone for that"
            ),
            Self::Dependencies { package, found } => write!(
                f,
                "{package} must have no dependency but the shared crates without features, it has {}: make them optional",
                found.join(", ")
            ),
            Self::Risen { figures } => write!(
                f,
                "{figures} figures have risen by more than is tolerated: see above; `cargo xtask cost` accepts a rise that is meant"
            ),
            Self::Recipes { complaints } => f.write_str(&complaints.join("\n")),
            Self::Checks { failed } => write!(
                f,
                "failed: {}; `cargo xtask ci {}` runs them alone",
                failed.join(", "),
                failed.join(" ")
            ),
            Self::NoToolchain { target, tried } => {
                let triple = target.triple;
                writeln!(f, "this machine cannot compile for {triple} yet. Tried:")?;
                for way in tried {
                    writeln!(f, "  - {way}")?;
                }
                let apart = if target.linker_is_apart {
                    format!("; {} as well", target.linker)
                } else {
                    String::new()
                };
                write!(
                    f,
                    "Do one of these, then try again:\n\
                     \x20 rustup target add {triple:<38}  (needs rustup and its download server{apart})\n\
                     \x20 rustup component add rust-src                               (the same, builds {} from source)\n\
                     \x20 apt-get install {:<40}  (Debian, as root; needs no rustup server)",
                    target.libraries,
                    target.packages.join(" "),
                )
            }
        }
    }
}

impl std::error::Error for Error {}
