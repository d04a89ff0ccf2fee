//! Finds a way to compile for another target: the installed target, one that rustup can install, or its libraries built from the
//! source that belongs to a compiler.

use std::env;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::error::Error;
use crate::target::Target;

/// Debian's package `rustc-web` puts its compiler here; its source, `rust-web-src`, lies in the same sysroot.
const DISTRIBUTION_RUSTC: &str = "/usr/bin/rustc";
/// Longer than this rustup is not waited for: on a closed network it may never come back.
const RUSTUP_PATIENCE: Duration = Duration::from_secs(60);
const RUSTUP_POLL: Duration = Duration::from_millis(100);

/// Which way to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Preference {
    /// The installed target, else rustup, else source.
    Auto,
    /// Only the installed target.
    Installed,
    /// Only libraries built from source, even when the target is installed.
    Source,
}

/// A way to compile for the target.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Toolchain {
    /// The usual compiler, with the target installed.
    Installed,
    /// A compiler that builds the libraries from its own source first.
    Source {
        /// The compiler.
        rustc: PathBuf,
        /// The folder of the linker.
        linker: PathBuf,
        /// The libraries.
        libraries: &'static str,
    },
}

impl Toolchain {
    /// The first way that works for `target`.
    ///
    /// # Errors
    /// [`Error::NoToolchain`] with each way and what it lacks.
    pub(crate) fn find(target: &'static Target, preference: Preference) -> Result<Self, Error> {
        let usual = Compiler::ask(&env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
        let mut tried = Vec::new();
        if let Err(lack) = linker_apart(target) {
            tried.push(lack);
            return Err(Error::NoToolchain { target, tried });
        }
        if preference != Preference::Source {
            match installed(usual.as_ref(), target.triple) {
                Ok(()) => return Ok(Self::Installed),
                Err(lack) => tried.push(lack),
            }
        }
        if preference == Preference::Auto {
            match add_with_rustup(target.triple)
                .and_then(|()| installed(usual.as_ref(), target.triple))
            {
                Ok(()) => return Ok(Self::Installed),
                Err(lack) => tried.push(lack),
            }
        }
        if preference != Preference::Installed {
            match from_source(usual.as_ref(), target) {
                Ok(toolchain) => return Ok(toolchain),
                Err(mut lacks) => tried.append(&mut lacks),
            }
        }
        Err(Error::NoToolchain { target, tried })
    }

    /// The value of `--toolchain` that takes this way.
    pub(crate) fn option(&self) -> &'static str {
        match self {
            Self::Installed => "installed",
            Self::Source { .. } => "source",
        }
    }

    /// One line for the user.
    pub(crate) fn describe(&self) -> String {
        match self {
            Self::Installed => "installed target".into(),
            Self::Source {
                rustc, libraries, ..
            } => format!("{libraries} built from source by {}", rustc.display()),
        }
    }

    /// The compiler.
    pub(crate) fn rustc(&self) -> OsString {
        match self {
            Self::Installed => env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()),
            Self::Source { rustc, .. } => rustc.into(),
        }
    }

    /// The version of the compiler, and where the core library comes from: what has the same one makes the same code.
    pub(crate) fn version(&self) -> String {
        let libraries = match self {
            Self::Installed => "core as installed".to_owned(),
            Self::Source { libraries, .. } => format!("{libraries} from source"),
        };
        let output = Command::new(self.rustc()).arg("--version").output();
        let version = output.map_or_else(
            |_| "unknown".to_owned(),
            |output| String::from_utf8_lossy(&output.stdout).trim().to_owned(),
        );
        format!("{version}, {libraries}")
    }

    /// Makes `cargo` use this toolchain.
    pub(crate) fn apply(&self, cargo: &mut Command) {
        let Self::Source {
            rustc,
            linker,
            libraries,
        } = self
        else {
            return;
        };
        cargo
            .env("RUSTC", rustc)
            // `build-std` is unstable, the compiler is a stable one.
            .env("RUSTC_BOOTSTRAP", "1")
            .env("PATH", with_first(linker, env::var_os("PATH").as_deref()))
            .arg(format!("-Zbuild-std={libraries}"));
    }
}

/// What a compiler says of itself.
struct Compiler {
    rustc: PathBuf,
    sysroot: PathBuf,
    host: String,
}

impl Compiler {
    /// `None` when there is no such compiler.
    fn ask(rustc: &OsStr) -> Option<Self> {
        let answer = |arguments: &[&str]| {
            let output = Command::new(rustc)
                .args(arguments)
                .stderr(Stdio::null())
                .output()
                .ok()?;
            output
                .status
                .success()
                .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
        };
        let version = answer(&["-vV"])?;
        Some(Self {
            rustc: rustc.into(),
            sysroot: answer(&["--print", "sysroot"])?.trim().into(),
            host: host_of(&version)?.into(),
        })
    }

    fn rustlib(&self) -> PathBuf {
        self.sysroot.join("lib").join("rustlib")
    }

    fn has_target(&self, target: &str) -> bool {
        let Ok(files) = self.rustlib().join(target).join("lib").read_dir() else {
            return false;
        };
        files
            .flatten()
            .any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
    }

    fn has_source(&self) -> bool {
        self.rustlib()
            .join("src/rust/library/core/Cargo.toml")
            .is_file()
    }

    /// The folder with the tools that come with the compiler.
    fn tools(&self) -> PathBuf {
        self.rustlib().join(&self.host).join("bin")
    }
}

/// The host triple in the answer to `rustc -vV`.
pub(crate) fn host_of(version: &str) -> Option<&str> {
    version.lines().find_map(|line| line.strip_prefix("host: "))
}

/// Where the linker is no part of any way, whether it is there.
fn linker_apart(target: &Target) -> Result<(), String> {
    let is_there = || {
        path_folders()
            .iter()
            .any(|folder| folder.join(target.linker).is_file())
    };
    if target.linker_is_apart && !is_there() {
        return Err(format!(
            "any way: there is no {} on the path, which links and compiles C for this target",
            target.linker
        ));
    }
    Ok(())
}

fn installed(usual: Option<&Compiler>, target: &str) -> Result<(), String> {
    let usual = usual.ok_or("the installed target: there is no rustc")?;
    if usual.has_target(target) {
        Ok(())
    } else {
        Err(format!(
            "the installed target: {} has no {target}",
            usual.sysroot.display()
        ))
    }
}

/// Lets rustup install the target: quietly, without retries, for a limited time.
fn add_with_rustup(target: &str) -> Result<(), String> {
    eprintln!(
        "installing {target} with rustup, for at most {} s",
        RUSTUP_PATIENCE.as_secs()
    );
    let started = Instant::now();
    let mut rustup = Command::new("rustup")
        .args(["target", "add", target])
        .env("RUSTUP_MAX_RETRIES", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|reason| format!("rustup: {reason}"))?;
    while started.elapsed() < RUSTUP_PATIENCE {
        match rustup.try_wait() {
            Ok(Some(status)) if status.success() => return Ok(()),
            Ok(Some(status)) => {
                return Err(format!(
                    "rustup: `rustup target add {target}` failed ({status})"
                ));
            }
            Ok(None) => sleep(RUSTUP_POLL),
            Err(reason) => return Err(format!("rustup: {reason}")),
        }
    }
    // It may have ended by itself a moment ago; then there is nothing left to stop.
    let _ = rustup.kill();
    let _ = rustup.wait();
    Err(format!(
        "rustup: no answer within {} s",
        RUSTUP_PATIENCE.as_secs()
    ))
}

/// A compiler with its source, and a linker: first the usual compiler, then the distribution's.
fn from_source(usual: Option<&Compiler>, target: &Target) -> Result<Toolchain, Vec<String>> {
    let distribution = Compiler::ask(DISTRIBUTION_RUSTC.as_ref());
    let compilers: Vec<&Compiler> = usual.into_iter().chain(&distribution).collect();
    let (libraries, linker) = (target.libraries, target.linker);
    let mut lacks = Vec::new();
    let with_source = compilers.iter().find(|compiler| compiler.has_source());
    if with_source.is_none() {
        lacks.push(match compilers.as_slice() {
            [] => {
                format!("{libraries} from source: there is neither rustc nor {DISTRIBUTION_RUSTC}")
            }
            all => {
                let places: Vec<_> = all
                    .iter()
                    .map(|compiler| compiler.rustlib().join("src").display().to_string())
                    .collect();
                format!(
                    "{libraries} from source: no source in {}",
                    places.join(" or ")
                )
            }
        });
    }
    let folders = compilers
        .iter()
        .map(|compiler| compiler.tools())
        .chain(path_folders());
    let found = folders
        .into_iter()
        .find(|folder| folder.join(linker).is_file());
    if found.is_none() {
        lacks.push(format!("{libraries} from source: no {linker} beside a rustc or on the path (a rustup toolchain has rust-lld)"));
    }
    match (with_source, found) {
        (Some(compiler), Some(linker)) => Ok(Toolchain::Source {
            rustc: compiler.rustc.clone(),
            linker,
            libraries,
        }),
        _ => Err(lacks),
    }
}

fn path_folders() -> Vec<PathBuf> {
    env::var_os("PATH")
        .map(|path| env::split_paths(&path).collect())
        .unwrap_or_default()
}

/// A search path with `folder` in front of `path`.
fn with_first(folder: &Path, path: Option<&OsStr>) -> OsString {
    let mut joined = OsString::from(folder);
    if let Some(path) = path.filter(|path| !path.is_empty()) {
        joined.push(if cfg!(windows) { ";" } else { ":" });
        joined.push(path);
    }
    joined
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    use crate::thumb::TARGET;
    use crate::windows::TARGET as WINDOWS;

    /// A compiler of which only the folders exist; `name` keeps the tests apart.
    fn compiler(name: &str, files: &[&str]) -> Compiler {
        let sysroot = env::temp_dir().join(format!("xtask-{}-{name}", std::process::id()));
        for file in files {
            let file = sysroot.join("lib/rustlib").join(file);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, "").unwrap();
        }
        Compiler {
            rustc: "rustc".into(),
            sysroot,
            host: "x86_64-unknown-linux-gnu".into(),
        }
    }

    #[test]
    fn the_host_is_read_from_the_version() {
        let version =
            "rustc 1.95.0\nbinary: rustc\nhost: x86_64-unknown-linux-gnu\nrelease: 1.95.0\n";
        assert_eq!(host_of(version), Some("x86_64-unknown-linux-gnu"));
        assert_eq!(host_of("rustc 1.95.0\n"), None);
    }

    #[test]
    fn a_target_counts_as_installed_when_its_core_is_there() {
        let with = compiler(
            "with",
            &["thumbv7em-none-eabihf/lib/libcore-0147d103acb464ac.rlib"],
        );
        let without = compiler(
            "without",
            &["thumbv7em-none-eabihf/lib/liballoc-71d093c14198c12f.rlib"],
        );
        assert_eq!(installed(Some(&with), TARGET.triple), Ok(()));
        assert!(
            installed(Some(&without), TARGET.triple)
                .unwrap_err()
                .contains("has no thumbv7em-none-eabihf")
        );
        assert!(
            installed(None, TARGET.triple)
                .unwrap_err()
                .contains("no rustc")
        );
        fs::remove_dir_all(with.sysroot).unwrap();
        fs::remove_dir_all(without.sysroot).unwrap();
    }

    #[test]
    fn the_usual_compiler_with_source_and_linker_is_taken_first() {
        let usual = compiler(
            "source",
            &[
                "src/rust/library/core/Cargo.toml",
                "x86_64-unknown-linux-gnu/bin/rust-lld",
            ],
        );
        let found = from_source(Some(&usual), &TARGET).unwrap();
        assert_eq!(
            found,
            Toolchain::Source {
                rustc: "rustc".into(),
                linker: usual.tools(),
                libraries: "core",
            }
        );
        fs::remove_dir_all(usual.sysroot).unwrap();
    }

    #[test]
    fn a_linker_of_its_own_is_looked_for_whatever_the_way_is() {
        let absent = Target {
            linker: "no-such-linker",
            ..WINDOWS
        };
        assert!(
            linker_apart(&absent)
                .unwrap_err()
                .contains("no no-such-linker on the path")
        );
        let of_a_compiler = Target {
            linker: "no-such-linker",
            ..TARGET
        };
        assert_eq!(linker_apart(&of_a_compiler), Ok(()));
    }

    #[test]
    fn building_from_source_sets_compiler_linker_and_flag() {
        let mut cargo = Command::new("cargo");
        Toolchain::Source {
            rustc: "/r/rustc".into(),
            linker: "/l".into(),
            libraries: WINDOWS.libraries,
        }
        .apply(&mut cargo);
        assert_eq!(
            cargo.get_args().collect::<Vec<_>>(),
            ["-Zbuild-std=std,panic_abort"]
        );
        let value = |name: &str| {
            cargo
                .get_envs()
                .find(|(key, _)| *key == name)
                .and_then(|(_, value)| value)
                .unwrap()
        };
        assert_eq!(value("RUSTC"), "/r/rustc");
        assert_eq!(value("RUSTC_BOOTSTRAP"), "1");
        assert_eq!(env::split_paths(value("PATH")).next(), Some("/l".into()));
    }

    #[test]
    fn the_option_of_a_toolchain_is_one_that_clap_accepts() {
        let source = Toolchain::Source {
            rustc: "/r/rustc".into(),
            linker: "/l".into(),
            libraries: "core",
        };
        for (toolchain, expected) in [
            (Toolchain::Installed, Preference::Installed),
            (source, Preference::Source),
        ] {
            let accepted = <Preference as clap::ValueEnum>::from_str(toolchain.option(), false);
            assert_eq!(accepted, Ok(expected));
        }
    }

    #[test]
    fn the_installed_target_needs_nothing_set() {
        let mut cargo = Command::new("cargo");
        Toolchain::Installed.apply(&mut cargo);
        assert_eq!(cargo.get_args().count() + cargo.get_envs().count(), 0);
    }

    #[test]
    fn an_empty_path_is_not_searched_as_the_current_folder() {
        assert_eq!(with_first("/l".as_ref(), Some("".as_ref())), "/l");
        assert_eq!(with_first("/l".as_ref(), None), "/l");
    }
}
