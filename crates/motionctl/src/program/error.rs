//! Why a program does not run.

use core::fmt;
use std::path::PathBuf;

use board_settings::file::FileError;
use path::PathError;
use program::ProgramError;

/// A program that is refused, or that cannot be read any further.
#[derive(Debug)]
pub(crate) enum ProgramFileError {
    /// The file cannot be read.
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// A picture cannot be written.
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The program is not usable.
    Program { path: PathBuf, source: ProgramError },
    /// The machine file is not usable.
    Machine { path: PathBuf, source: FileError },
    /// A motor whose play cannot be taken up on the way.
    Backlash {
        path: PathBuf,
        line: u32,
        source: trajectory::PlanError,
    },
    /// A move that makes no path.
    Path {
        path: PathBuf,
        line: u32,
        source: PathError,
    },
    /// A pause in a program that nobody attends.
    Pause { path: PathBuf, line: u32 },
    /// The program lasts longer than it may.
    Long {
        path: PathBuf,
        line: u32,
        most_s: f64,
    },
    /// An axis leaves the range of its counter.
    Travel {
        path: PathBuf,
        line: u32,
        axis: String,
        counts: i64,
        most: i32,
    },
    /// A step in one cycle that is larger than allowed.
    Step {
        path: PathBuf,
        line: u32,
        axis: String,
        counts: i64,
        most: u16,
    },
    /// An option that a program needs, or cannot use.
    Option(String),
}

impl fmt::Display for ProgramFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(f, "cannot read {}: {source}", path.display()),
            Self::Write { path, source } => write!(f, "cannot write {}: {source}", path.display()),
            Self::Program { path, source } => write!(f, "{}: {source}", path.display()),
            Self::Machine { path, source } => write!(f, "{}: {source}", path.display()),
            Self::Backlash { path, line, source } => write!(
                f,
                "{}: line {line}: the backlash cannot be taken up: {source}",
                path.display()
            ),
            Self::Path { path, line, source } => {
                write!(f, "{}: line {line}: {source}", path.display())
            }
            Self::Pause { path, line } => write!(
                f,
                "{}: line {line}: M0 waits for somebody to let the program go on, which nobody can here: take it out, or pass over it with --skip-pauses",
                path.display()
            ),
            Self::Long { path, line, most_s } => write!(
                f,
                "{}: line {line}: the program lasts longer than {most_s} s: allow more with --max-duration",
                path.display()
            ),
            Self::Travel {
                path,
                line,
                axis,
                counts,
                most,
            } => write!(
                f,
                "{}: line {line}: {axis} must stay within {most} counts of its start, it would be at {counts}",
                path.display()
            ),
            Self::Step {
                path,
                line,
                axis,
                counts,
                most,
            } => write!(
                f,
                "{}: line {line}: {axis} must move at most {most} counts in a cycle, it would move {counts}: lower --axis-rpm, or rpm in the machine file",
                path.display()
            ),
            Self::Option(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for ProgramFileError {}
