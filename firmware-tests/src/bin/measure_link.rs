//! Measures what a busy link costs the cycle and prints the figures as one line of JSON, for `cargo xtask cost`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use firmware_tests::motion::{self, Drives};
use firmware_tests::orders::{self, Handlers};
use firmware_tests::{Image, Rig};
use serde_json::{Value, json};

/// Milliseconds that are counted.
const MILLISECONDS: u64 = 2_000;
/// Length of the stream, from before they are counted until after.
const STREAM_MS: u32 = 8_000;
/// Time until a drive answers, more or less by a quarter: one from which both images ask in every cycle, which costs them most. From
/// another one of them may ask a fifth less than the other, and that is no matter of the link.
const fn response_us(axes: i32) -> u64 {
    if axes <= 4 { 500 } else { 300 }
}

/// Measures the handlers of the cycle and of the bus while every axis moves: in an image that takes orders, with a host that streams and reads
/// snapshots, and in one that plays its built-in motion.
#[derive(Parser)]
#[command(name = "measure_link")]
struct Arguments {
    /// The image that takes orders
    with: PathBuf,
    /// The image with the built-in motion of as many axes
    without: PathBuf,
    /// Axes
    #[arg(long)]
    axes: i32,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match measure(&arguments) {
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

fn measure(arguments: &Arguments) -> Result<Value, String> {
    let drives = Drives {
        count: arguments.axes,
        response_us: response_us(arguments.axes),
    };
    let image = |path: &Path| Image::read(path).map_err(|error| error.to_string());
    let (mut rig, mut host) = orders::enabled(image(&arguments.with)?, drives);
    orders::set_moving(&mut rig, &mut host, STREAM_MS);
    let with = Handlers::count(&mut rig, MILLISECONDS, |rig| host.run_ms(rig, 1));
    let mut rig = motion::standing(image(&arguments.without)?, drives)?;
    motion::set_moving(&mut rig);
    let without = Handlers::count(&mut rig, MILLISECONDS, |rig: &mut Rig| {
        rig.run_ms(1);
    });
    let figures = |handlers: Handlers| json!({"mean": handlers.mean, "worst": handlers.worst, "thread": handlers.thread});
    Ok(json!({"with": figures(with), "without": figures(without)}))
}
