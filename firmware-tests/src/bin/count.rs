//! Counts the instructions of an image from reset until it sleeps, and prints them, for `cargo xtask cost`; with `--functions` by
//! function, as one line of JSON.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use drive_sim::{BitRate, Bus, ScriptedFaults};
use firmware_tests::can::Wire;
use firmware_tests::chip::STM32F405;
use firmware_tests::names::Names;
use firmware_tests::profile::Profile;
use firmware_tests::{Board, Image};
use serde_json::{Value, json};

/// Crystal of the board; an image that does not switch clocks runs at the 16 MHz of the internal oscillator.
const HSE_HZ: u64 = 8_000_000;

/// An image must sleep by then, and the same time later it must not have done any more.
const LIMIT_NS: u64 = 5_000_000_000;

/// Counts the instructions of an image until it sleeps.
#[derive(Parser)]
#[command(name = "count")]
struct Arguments {
    /// The image
    image: PathBuf,
    /// Tell them by function
    #[arg(long)]
    functions: bool,
}

fn main() -> ExitCode {
    let Arguments { image, functions } = Arguments::parse();
    match count(&image, functions) {
        Ok(answer) => {
            println!("{answer}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn count(path: &Path, by_function: bool) -> Result<Value, String> {
    let image = Image::read(path).map_err(|error| error.to_string())?;
    let names = Names::read(path)?;
    let wire = Wire::new(Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new()));
    let mut board = Board::new(&STM32F405, image, HSE_HZ, wire)
        .map_err(|error| format!("emulator: {error:?}"))?;
    board.soc_mut().profile = by_function.then(Profile::default);
    let mut count_until = |ns| {
        board.run_until_ns(ns);
        board.soc().instructions
    };
    let (first, second) = (count_until(LIMIT_NS), count_until(2 * LIMIT_NS));
    if first != second {
        return Err(format!(
            "{} does not sleep: {first} instructions, later {second}",
            path.display()
        ));
    }
    let Some(profile) = board.soc_mut().profile.take() else {
        return Ok(json!(first));
    };
    let functions: Vec<Value> = profile
        .functions(board.image(), &names)
        .into_iter()
        .map(|(function, contexts)| {
            let instructions: u64 = contexts.values().sum();
            json!({"function": function.name, "file": function.file, "instructions": instructions})
        })
        .collect();
    Ok(json!({"instructions": first, "functions": functions}))
}
