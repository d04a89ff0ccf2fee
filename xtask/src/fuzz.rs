//! `cargo xtask fuzz`: LLVM's fuzzer against every decoder, with a stable compiler.
//!
//! `cargo fuzz` runs the same targets; it wants a nightly compiler for its sanitizers, which code without `unsafe` does not need.

use std::env;
use std::path::PathBuf;
use std::process::Command;

use crate::error::Error;
use crate::workspace::{Workspace, cargo};

/// The workspace of the targets, from the root.
const FOLDER: &str = "fuzz";
/// The targets, by the names of their files.
const TARGETS: [&str; 6] = [
    "can_log",
    "dyn_can",
    "dyn_serial",
    "frames_in_words",
    "program",
    "zlac8030l",
];
/// With more inputs the fuzzer shows its progress.
const LONG_RUN: u64 = 1_000_000;
/// What makes the compiler note which code an input reaches, as `cargo fuzz` does it.
const FLAGS: &str = "--cfg fuzzing -Ccodegen-units=1 -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares";

/// Runs LLVM's fuzzer against the decoders; what it learnt stays in target/fuzz/corpus.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask fuzz                              100000 inputs for each target\n  \
    cargo xtask fuzz dyn_can --runs 100000000     a long run of one\n  \
    cargo +nightly fuzz run dyn_can               the same target under cargo-fuzz\n\n\
    An input that breaks a promise is kept in target/fuzz/found; its name is the last word of the fuzzer's message.")]
pub(crate) struct Arguments {
    /// The targets; all of them when none is named
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(TARGETS))]
    targets: Vec<String>,

    /// Inputs for each target
    #[arg(long, default_value_t = 100_000)]
    runs: u64,

    /// First seed of the fuzzer, for runs that can be repeated; 0 for one of its own
    #[arg(long, default_value_t = 0)]
    seed: u32,
}

/// Runs the task.
///
/// # Errors
/// When a target does not build, or an input breaks a promise.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let workspace = Workspace::find()?;
    let folder = workspace.target.join(FOLDER);
    let host = host()?;
    let mut build = Command::new(cargo());
    build
        .current_dir(workspace.root.join(FOLDER))
        // With a target the flags are for the code of the target alone, and not for build scripts.
        .args([
            "build",
            "--release",
            "--locked",
            "--bins",
            "--target",
            &host,
        ])
        .arg("--target-dir")
        .arg(&folder)
        .env("RUSTFLAGS", FLAGS);
    finish("cargo build in fuzz", &mut build)?;
    let found = folder.join("found");
    let all = TARGETS.map(String::from);
    let targets = if arguments.targets.is_empty() {
        &all[..]
    } else {
        &arguments.targets
    };
    for target in targets {
        let corpus = folder.join("corpus").join(target);
        for place in [&corpus, &found] {
            std::fs::create_dir_all(place).map_err(|reason| Error::Start {
                program: place.display().to_string(),
                reason,
            })?;
        }
        let program = folder.join(&host).join("release").join(target);
        let mut fuzzer = Command::new(&program);
        fuzzer
            .arg(format!("-runs={}", arguments.runs))
            .arg(format!("-seed={}", arguments.seed))
            .arg(format!("-artifact_prefix={}/", found.display()))
            .arg(corpus);
        println!("{target}: {} inputs", arguments.runs);
        if arguments.runs > LONG_RUN {
            finish(target, &mut fuzzer)?;
        } else {
            finish_quietly(target, &mut fuzzer)?;
        }
    }
    Ok(())
}

/// What the fuzzer says is for long runs, and for inputs that break something.
fn finish_quietly(program: &str, command: &mut Command) -> Result<(), Error> {
    let program = program.to_owned();
    match command.output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => {
            eprint!("{}", String::from_utf8_lossy(&output.stderr));
            let status = output.status;
            Err(Error::Failed { program, status })
        }
        Err(reason) => Err(Error::Start { program, reason }),
    }
}

/// The host, as the compiler names it.
fn host() -> Result<String, Error> {
    let rustc = env::var_os("RUSTC").map_or_else(|| "rustc".into(), PathBuf::from);
    let output = Command::new(&rustc).arg("-vV").output();
    let output = output.map_err(|reason| Error::Start {
        program: rustc.display().to_string(),
        reason,
    })?;
    crate::toolchain::host_of(&String::from_utf8_lossy(&output.stdout))
        .map(str::to_owned)
        .ok_or(Error::Answer {
            program: rustc.display().to_string(),
            expected: "a line `host: ...` of -vV",
        })
}

fn finish(program: &str, command: &mut Command) -> Result<(), Error> {
    let program = program.to_owned();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Error::Failed { program, status }),
        Err(reason) => Err(Error::Start { program, reason }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_a_target_is_run() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fuzz/fuzz_targets");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
            .collect();
        files.sort();
        assert_eq!(files, TARGETS);
    }
}
