//! Runs an image until it sleeps and prints the figures that it has kept, for `cargo xtask cost`: statics with `FIGURE_` in their names,
//! each a sum and a largest value, and the depth of its stack.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use drive_sim::{BitRate, Bus, ScriptedFaults};
use firmware_tests::can::Wire;
use firmware_tests::chip::STM32F405;
use firmware_tests::{Board, Image};
use serde_json::{Map, Value, json};

/// Crystal of the board; an image that does not switch clocks runs at the 16 MHz of the internal oscillator.
const HSE_HZ: u64 = 8_000_000;
/// The image is looked at so often, and must sleep in the end.
const LOOK_NS: u64 = 5_000_000_000;
const LOOKS: u64 = 200;
const MARK: &str = "FIGURE_";

/// Runs an image until it sleeps and prints the figures that it has kept, as JSON.
#[derive(Parser)]
#[command(name = "figures")]
struct Arguments {
    /// The image
    image: PathBuf,
}

fn main() -> ExitCode {
    match figures(&Arguments::parse().image) {
        Ok(figures) => {
            println!("{figures}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn figures(path: &Path) -> Result<Value, String> {
    let image = Image::read(path).map_err(|error| error.to_string())?;
    let wire = Wire::new(Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new()));
    let mut board = Board::new(&STM32F405, image, HSE_HZ, wire)
        .map_err(|error| format!("emulator: {error:?}"))?;
    run_until_asleep(&mut board).ok_or_else(|| format!("{} does not sleep", path.display()))?;
    let mut figures = Map::new();
    for (symbol, address) in board.image().symbols_with(MARK) {
        let (sum, largest) = board
            .peek(address)
            .zip(board.peek(address + 4))
            .ok_or_else(|| format!("{symbol} is not in memory"))?;
        figures.insert(name(symbol).into(), json!({"sum": sum, "largest": largest}));
    }
    figures.insert("stack".into(), board.stack_high_water().into());
    Ok(figures.into())
}

/// `None` when it never sleeps.
fn run_until_asleep(board: &mut Board) -> Option<()> {
    let mut before = 0;
    for look in 1..=LOOKS {
        board.run_until_ns(look * LOOK_NS);
        let now = board.soc().instructions;
        if now == before {
            return Some(());
        }
        before = now;
    }
    None
}

/// What follows the mark, in capitals; what the compiler adds begins with another letter.
fn name(symbol: &str) -> &str {
    let start = symbol.find(MARK).map_or(0, |place| place + MARK.len());
    let name = symbol.get(start..).unwrap_or_default();
    let end = name.find(|letter: char| !letter.is_ascii_uppercase() && letter != '_');
    name.get(..end.unwrap_or(name.len())).unwrap_or_default()
}
