//! Counts the instructions of an image from reset until it sleeps, and prints them, for `cargo xtask cost`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use drive_sim::{BitRate, Bus, ScriptedFaults};
use firmware_tests::can::Wire;
use firmware_tests::chip::STM32F405;
use firmware_tests::{Board, Image};

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
}

fn main() -> ExitCode {
    match count(&Arguments::parse().image) {
        Ok(instructions) => {
            println!("{instructions}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn count(path: &std::path::Path) -> Result<u64, String> {
    let image = Image::read(path).map_err(|error| error.to_string())?;
    let wire = Wire::new(Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new()));
    let mut board = Board::new(&STM32F405, image, HSE_HZ, wire)
        .map_err(|error| format!("emulator: {error:?}"))?;
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
    Ok(first)
}
