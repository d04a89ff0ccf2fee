//! Measures an image in motion and prints the figures as one line of JSON, for `cargo xtask cost`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use firmware_tests::load::Masked;
use firmware_tests::nvic::FIRST_INTERRUPT;
use firmware_tests::{Image, Rig, load};
use serde_json::{Value, json};

/// Milliseconds of motion that are measured; each is one cycle.
const CYCLES: u64 = 2_000;

/// The interrupts whose instructions are told apart, by number in the vector table behind the exceptions (RM0090, table 62).
const HANDLERS: [(&str, u16); 4] = [
    ("cycle", 28),
    ("transmit", 19),
    ("receive", 20),
    ("timer", 43),
];

/// Measures an image of the firmware in motion on the emulated board.
#[derive(Parser)]
#[command(name = "measure")]
struct Arguments {
    /// The image
    image: PathBuf,
    /// Its axes
    #[arg(long)]
    axes: i32,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match Image::read(&arguments.image) {
        Ok(image) => {
            println!("{}", measure(image, arguments.axes));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn measure(image: Image, axes: i32) -> Value {
    let mut rig = Rig::with_numbered_drives(image, axes);
    rig.bring_up();
    // With many axes on a full bus the last one streams late.
    rig.run_ms(1_000);
    let stack_at_start = rig.board().stack_high_water();
    rig.board_mut()
        .repaint_stack()
        .expect("the emulator can write to its memory");
    rig.board_mut().clear_accounts();
    rig.board_mut().soc_mut().masked = Masked::default();
    let start = rig.board().soc().instructions;
    let (mut before, mut worst) = (start, 0);
    for _ in 0..CYCLES {
        rig.run_ms(1);
        let now = rig.board().soc().instructions;
        worst = worst.max(now - before);
        before = now;
    }
    let per_cycle = |instructions: u64| instructions as f64 / CYCLES as f64;
    let mut figures = json!({
        "axes": axes,
        "all": per_cycle(before - start),
        "worst": worst,
        "thread": per_cycle(rig.board().load_of(load::THREAD).instructions),
        "stack_at_start": stack_at_start,
        "stack_in_motion": rig.board().stack_high_water(),
        "masked": rig.board().soc().masked.longest,
        "masked_at": rig.board().soc().masked.begins_at,
        "late": rig.statistic("late"),
    });
    for (name, interrupt) in HANDLERS {
        let load = rig.board().load_of(interrupt + FIRST_INTERRUPT);
        figures[name] = per_cycle(load.instructions).into();
    }
    figures
}
