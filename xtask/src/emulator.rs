//! `cargo xtask firmware-tests`: runs the real image on the emulated board.

use std::env;
use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::error::Error;
use crate::images::{Board, Image, LINK_HOMING};
use crate::thumb::Builder;
use crate::toolchain::Preference;
use crate::workspace::{Workspace, cargo};

/// The workspace of the emulator, below the root.
const FOLDER: &str = "firmware-tests";
/// The variable that tells the tests where the images are, and their folder among the build products.
const IMAGES: &str = "FIRMWARE_IMAGES";
const IMAGES_FOLDER: &str = "firmware-images";
/// The variable that says whose images they are.
const BOARD: &str = "FIRMWARE_BOARD";
/// What Unicorn's build needs and a plain machine lacks; both are on PyPI.
const BUILD_TOOLS: [&str; 2] = ["cmake", "libclang"];

/// Builds the images for both boards and runs the tests that execute them, instruction by instruction, against simulated drives.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask firmware-tests                   build, lint, test\n  \
    cargo xtask firmware-tests --board stm32g474 only one board\n  \
    cargo xtask firmware-tests -- boot           only tests with `boot` in their name\n  \
    cargo xtask firmware-tests -- --nocapture    show what the tests print\n\n\
    The emulator builds Unicorn, which takes some minutes once and needs cmake and libclang: those of PyPI are installed\n\
    into target/ with python3, unless the variable LIBCLANG_PATH says that you bring your own.")]
pub(crate) struct Arguments {
    /// Where the target's core library comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,

    /// Only this board
    #[arg(long, value_enum)]
    board: Option<Board>,

    /// Further arguments for the tests
    #[arg(last = true, value_name = "TEST ARGUMENTS")]
    tests: Vec<String>,
}

impl Arguments {
    fn boards(&self) -> Vec<Board> {
        self.board.map_or(Board::ALL.to_vec(), |board| vec![board])
    }
}

/// Builds an image with your configuration and runs it on the emulated board, with simulated drives and an operator who closes the
/// contacts.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask emulate                                           src/config.rs, drives 1 and 2, four seconds\n  \
    cargo xtask emulate -- --drives 5,6:8192,9 --ms 8000          other drives, one with gear number 8192, longer\n  \
    cargo xtask emulate --config my-machine.rs -- --drives 5,6,9  another configuration\n  \
    cargo xtask emulate --link /tmp/board -- --drives 1,2,3,4     the image that takes orders, for host programs\n  \
    cargo xtask emulate --link /tmp/board --homing -- --drives 1,2 --stops=-2:3   the same with homing, and stops beside the shafts\n  \
    cargo xtask emulate -- --help                                 what the emulator can do")]
pub(crate) struct EmulateArguments {
    /// Where the target's core library comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,

    /// The board
    #[arg(long, value_enum, default_value = "stm32f405")]
    board: Board,

    /// Configuration to compile in the place of src/config.rs
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,

    /// The image that takes orders, in real time, with its serial port on a pseudo-terminal under this name
    #[arg(long, value_name = "PATH", conflicts_with = "config")]
    link: Option<PathBuf>,

    /// With --link: the axes can be homed as the settings of the board say
    #[arg(long, requires = "link")]
    homing: bool,

    /// Arguments for the emulator
    #[arg(last = true, value_name = "EMULATOR ARGUMENTS")]
    emulator: Vec<String>,
}

/// Runs the task.
///
/// # Errors
/// When the image or the emulator does not build, or the emulator fails.
pub(crate) fn emulate(arguments: &EmulateArguments) -> Result<(), Error> {
    let builder = Builder::find(arguments.toolchain)?;
    let emulator = Emulator::prepare()?;
    let image = match arguments.link {
        Some(_) if arguments.homing => Image::with_orders(arguments.board, LINK_HOMING, "info"),
        Some(_) => Image::with_link(arguments.board),
        None => Image::with_config(arguments.board, arguments.config.as_deref()),
    };
    let image = image.build(&builder, &emulator.images)?;
    emulator.build("emulate")?;
    let mut command = emulator.command(&["run", "--quiet", "--bin", "emulate", "--"])?;
    command
        .arg(image)
        .args(&arguments.emulator)
        .env(BOARD, arguments.board.feature());
    if let Some(link) = &arguments.link {
        // The emulator runs in its own folder.
        let link = std::path::absolute(link).unwrap_or_else(|_| link.clone());
        command.arg("--link").arg(link);
    }
    succeed("the emulator's program `emulate`", &mut command)
}

/// Runs the task.
///
/// # Errors
/// When the image or the emulator does not build, or a test fails.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let builder = Builder::find(arguments.toolchain)?;
    let emulator = Emulator::prepare()?;
    for image in arguments
        .boards()
        .iter()
        .flat_map(|board| Image::for_tests(*board))
    {
        image.build(&builder, &emulator.images)?;
    }
    emulator.cargo(&["clippy", "--all-targets"], &["-D", "warnings"])?;
    let tests: Vec<&str> = arguments.tests.iter().map(String::as_str).collect();
    // All boards are tested, also when one has failed.
    let results: Vec<_> = arguments
        .boards()
        .iter()
        .map(|board| {
            eprintln!("the image for {}", board.feature());
            emulator.test(*board, &tests)
        })
        .collect();
    results.into_iter().collect()
}

/// What an image has to do while it is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Load {
    /// Number of axes.
    pub(crate) axes: usize,
    /// Time until a drive answers, each time up to a quarter more or less.
    pub(crate) response_us: u32,
    pub(crate) motion: AxisMotion,
}

/// What the axes do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AxisMotion {
    /// They hold their positions.
    Standing,
    /// They follow the motion of the image.
    BuiltIn,
    /// They follow the stream of a host, which also reads snapshots.
    Streamed,
}

impl AxisMotion {
    /// The option of `cargo xtask profile`, and of the emulator's program of that name.
    pub(crate) const fn option(self) -> Option<&'static str> {
        match self {
            Self::Standing => None,
            Self::BuiltIn => Some("--moving"),
            Self::Streamed => Some("--link"),
        }
    }
}

impl fmt::Display for AxisMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Standing => "standing",
            Self::BuiltIn => "moving",
            Self::Streamed => "following a stream",
        })
    }
}

impl fmt::Display for Load {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            axes,
            response_us,
            motion,
        } = self;
        write!(
            f,
            "{axes} axes, {motion}, drives answer after {} to {} us",
            response_us * 3 / 4,
            response_us * 5 / 4
        )
    }
}

/// The emulator's workspace with the tools to build it.
pub(crate) struct Emulator {
    folder: PathBuf,
    /// Where the images for it are.
    images: PathBuf,
    /// The virtual environment with the tools; `None` when the user brings them.
    tools: Option<PathBuf>,
}

impl Emulator {
    /// Finds the workspace, and installs the tools unless the user brings them.
    ///
    /// # Errors
    /// When the tools cannot be installed.
    pub(crate) fn prepare() -> Result<Self, Error> {
        let workspace = Workspace::find()?;
        let tools = match env::var_os("LIBCLANG_PATH") {
            Some(_) => None,
            None => Some(install_tools(&workspace.target)?),
        };
        Ok(Self {
            folder: workspace.root.join(FOLDER),
            images: workspace.target.join(IMAGES_FOLDER),
            tools,
        })
    }

    /// The folder of the images.
    pub(crate) fn images(&self) -> &Path {
        &self.images
    }

    /// Measures an image standing and moving, for each time until a drive answers: one entry each, in that order.
    ///
    /// # Errors
    /// When the emulator does not build, fails, or answers something else than JSON.
    pub(crate) fn measure(
        &self,
        image: &Path,
        board: Board,
        axes: usize,
        responses_us: &[u32],
    ) -> Result<Value, Error> {
        let times: Vec<String> = responses_us.iter().map(u32::to_string).collect();
        self.answer("measure", |command| {
            command
                .arg(image)
                .args(["--axes", &axes.to_string()])
                .args(["--response-us", &times.join(",")])
                .env(BOARD, board.feature())
        })
    }

    /// Measures an image that takes orders, with a busy link, and one with as many axes and the built-in motion.
    ///
    /// # Errors
    /// When the emulator does not build, fails, or answers something else than JSON.
    pub(crate) fn measure_link(
        &self,
        (with, without): (&Path, &Path),
        board: Board,
        axes: usize,
    ) -> Result<Value, Error> {
        self.answer("measure_link", |command| {
            command
                .arg(with)
                .arg(without)
                .args(["--axes", &axes.to_string()])
                .env(BOARD, board.feature())
        })
    }

    /// Counts the instructions of an image by function.
    ///
    /// # Errors
    /// When the emulator does not build, fails, or answers something else than JSON.
    pub(crate) fn profile(
        &self,
        image: &Path,
        board: Board,
        load: Load,
        ms: u32,
    ) -> Result<Value, Error> {
        self.answer("profile", |command| {
            command
                .arg(image)
                .args(["--axes", &load.axes.to_string()])
                .args(["--response-us", &load.response_us.to_string()])
                .args(["--ms", &ms.to_string()])
                .args(load.motion.option())
                .env(BOARD, board.feature())
        })
    }

    /// Builds a program of the emulator with cargo's own messages, and says beforehand when that takes its time.
    fn build(&self, program: &str) -> Result<(), Error> {
        let built = self.folder.join("target/debug").join(program);
        if !built.is_file() {
            eprintln!("{}", first_build(system_unicorn().as_deref()));
        }
        let mut command = self.command(&["build", "--bin", program])?;
        succeed(
            &format!("cargo build --bin {program} in {FOLDER}"),
            &mut command,
        )
    }

    /// What a program of the emulator prints.
    fn answer(
        &self,
        name: &str,
        with: impl FnOnce(&mut Command) -> &mut Command,
    ) -> Result<Value, Error> {
        let program = format!("the emulator's program `{name}`");
        self.build(name)?;
        let mut command = self.command(&["run", "--quiet", "--bin", name, "--"])?;
        let output = with(&mut command).output().map_err(|reason| Error::Start {
            program: program.clone(),
            reason,
        })?;
        if !output.status.success() {
            eprint!("{}", String::from_utf8_lossy(&output.stderr));
            return Err(Error::Failed {
                program,
                status: output.status,
            });
        }
        serde_json::from_slice(&output.stdout).map_err(|_| Error::Answer {
            program,
            expected: "one line of JSON",
        })
    }

    /// Counts the instructions of an image until it sleeps.
    ///
    /// # Errors
    /// When the emulator does not build, fails, or the image does not sleep.
    pub(crate) fn count(&self, image: &Path) -> Result<u64, Error> {
        let answer = self.answer("count", |command| command.arg(image))?;
        answer.as_u64().ok_or_else(|| Error::Answer {
            program: "the emulator's program `count`".into(),
            expected: "a number",
        })
    }

    /// Counts the instructions of an image by function until it sleeps.
    ///
    /// # Errors
    /// When the emulator does not build, fails, or the image does not sleep.
    pub(crate) fn count_by_function(&self, image: &Path) -> Result<Value, Error> {
        self.answer("count", |command| command.arg(image).arg("--functions"))
    }

    /// Runs an image until it sleeps, and reads the figures that it has kept.
    ///
    /// # Errors
    /// When the emulator does not build, fails, or the image does not sleep.
    pub(crate) fn figures(&self, image: &Path) -> Result<Value, Error> {
        self.answer("figures", |command| command.arg(image))
    }

    /// Runs cargo in the emulator's workspace.
    fn cargo(&self, arguments: &[&str], behind_dashes: &[&str]) -> Result<(), Error> {
        let mut command = self.command(arguments)?;
        command.arg("--").args(behind_dashes);
        succeed(
            &format!("cargo {} in {FOLDER}", arguments.join(" ")),
            &mut command,
        )
    }

    /// Runs the tests with the images of a board.
    fn test(&self, board: Board, tests: &[&str]) -> Result<(), Error> {
        let mut command = self.command(&["test", "--no-fail-fast", "--"])?;
        command.args(tests).env(BOARD, board.feature());
        succeed(
            &format!("cargo test in {FOLDER}, {}", board.feature()),
            &mut command,
        )
    }

    fn command(&self, arguments: &[&str]) -> Result<Command, Error> {
        let mut command = Command::new(cargo());
        command
            .args(arguments)
            .current_dir(&self.folder)
            .env(IMAGES, &self.images)
            // This cargo runs for another workspace.
            .env_remove("CARGO_MANIFEST_DIR")
            .env_remove("RUSTC");
        if system_unicorn().is_none() {
            // An older one would be linked without a word.
            command.env("UNICORN_NO_PKG_CONFIG", "1");
        }
        if let Some(tools) = &self.tools {
            command
                .env("PATH", with_first(&tools.join("bin"))?)
                .env("LIBCLANG_PATH", libclang_folder(tools)?)
                .env("BINDGEN_EXTRA_CLANG_ARGS", compiler_headers()?);
        }
        Ok(command)
    }
}

/// The oldest Unicorn of a system on which the images run right: with the 2.0.1 of Debian 12 interrupts get lost and 8 axes never start.
const LEAST_UNICORN: (u32, u32) = (2, 1);

fn is_recent(version: &str) -> bool {
    let mut parts = version.split('.').map(|part| part.parse().unwrap_or(0));
    let version: (u32, u32) = (parts.next().unwrap_or(0), parts.next().unwrap_or(0));
    version >= LEAST_UNICORN
}

/// The version of the Unicorn that this system has and that is recent enough, as its package for development says (Debian:
/// libunicorn-dev).
fn system_unicorn() -> Option<String> {
    let output = Command::new("pkg-config")
        .args(["--modversion", "unicorn"])
        .output()
        .ok()?;
    let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    (output.status.success() && is_recent(&version)).then_some(version)
}

fn first_build(system_unicorn: Option<&str>) -> String {
    match system_unicorn {
        Some(version) => {
            format!("the emulator is built, once, with the Unicorn {version} of this system")
        }
        None => "the emulator is built, once: Unicorn is compiled from its source, which takes some minutes. A package \
                 libunicorn-dev of 2.1 or newer saves that time"
            .to_owned(),
    }
}

/// Makes a virtual environment with the tools, unless it is there.
fn install_tools(target: &Path) -> Result<PathBuf, Error> {
    let tools = target.join("emulator-tools");
    if libclang_folder(&tools).is_ok() {
        return Ok(tools);
    }
    eprintln!(
        "installing {} from PyPI into {}",
        BUILD_TOOLS.join(" and "),
        tools.display()
    );
    succeed(
        "python3 -m venv",
        Command::new("python3").args(["-m", "venv"]).arg(&tools),
    )?;
    succeed(
        "pip install",
        Command::new(tools.join("bin/pip"))
            .args(["install", "--quiet"])
            .args(BUILD_TOOLS),
    )?;
    Ok(tools)
}

/// The folder of libclang in the virtual environment; the version of Python is part of its path.
fn libclang_folder(tools: &Path) -> Result<PathBuf, Error> {
    let library = tools.join("lib");
    let pythons = library.read_dir().into_iter().flatten().flatten();
    let folders = pythons.map(|python| python.path().join("site-packages/clang/native"));
    folders
        .into_iter()
        .find(|folder| folder.join("libclang.so").is_file())
        .ok_or(Error::MissingTool {
            tool: "libclang",
            place: library,
        })
}

/// PyPI's libclang comes without the headers of a compiler; the C compiler that is there has them.
fn compiler_headers() -> Result<String, Error> {
    let program = "cc -print-file-name=include";
    let output = Command::new("cc")
        .arg("-print-file-name=include")
        .output()
        .map_err(|reason| Error::Start {
            program: program.into(),
            reason,
        })?;
    Ok(format!(
        "-I{}",
        String::from_utf8_lossy(&output.stdout).trim()
    ))
}

fn with_first(folder: &Path) -> Result<OsString, Error> {
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(folder.to_path_buf()).chain(env::split_paths(&path));
    env::join_paths(folders).map_err(|_| Error::Answer {
        program: "the search path".into(),
        expected: "folders without a separator in their names",
    })
}

fn succeed(program: &str, command: &mut Command) -> Result<(), Error> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Error::Failed {
            program: program.into(),
            status,
        }),
        Err(reason) => Err(Error::Start {
            program: program.into(),
            reason,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_build_is_announced_with_what_would_shorten_it() {
        let from_source = first_build(None);
        assert!(from_source.contains("some minutes") && from_source.contains("libunicorn-dev"));
        assert!(first_build(Some("2.1.5")).contains("Unicorn 2.1.5 of this system"));
    }

    #[test]
    fn an_old_unicorn_is_not_used() {
        for (version, expected) in [
            ("2.0.1", false),
            ("2.1.0", true),
            ("2.1.5", true),
            ("2.10.0", true),
            ("3.0", true),
            ("1.9", false),
            ("", false),
        ] {
            assert_eq!(is_recent(version), expected, "{version}");
        }
    }
}
