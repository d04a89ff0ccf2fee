//! The long run of damaged logs against the readers and the decoder.
//!
//! `cargo run --release -p can-decode --example fuzz -- [INPUTS] [SEED]`, 1,000,000 inputs from seed 0 without arguments. The inputs
//! and what must hold for them are those of the test `fuzz`.

#[path = "../tests/damage/mod.rs"]
mod damage;

use std::process::ExitCode;

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let (Ok(inputs), Ok(seed)) = (
        arguments.next().unwrap_or(Ok(1_000_000)),
        arguments.next().unwrap_or(Ok(0)),
    ) else {
        println!("usage: fuzz [INPUTS] [SEED]");
        return ExitCode::from(2);
    };
    let (mut frames, mut errors) = (0, 0);
    for seed in seed..seed.saturating_add(inputs) {
        let (log, stamps) = damage::damaged(seed);
        let outcome = std::panic::catch_unwind(|| damage::run(&log, stamps));
        match outcome {
            Ok(Ok(tally)) => {
                frames += tally.frames;
                errors += tally.errors;
            }
            Ok(Err(fault)) => {
                println!("seed {seed}: {fault}\n{log:?}");
                return ExitCode::FAILURE;
            }
            Err(_) => {
                println!("seed {seed}: a panic\n{log:?}");
                return ExitCode::FAILURE;
            }
        }
    }
    println!(
        "{inputs} inputs from seed {seed}: {frames} frames read, {errors} lines refused, at most {:.1} MB",
        ALLOCATOR.peak_usage_as_mb()
    );
    ExitCode::SUCCESS
}
