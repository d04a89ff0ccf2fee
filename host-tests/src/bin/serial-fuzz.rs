//! The long run of random bytes against the serial decoder, with a progress bar.

use std::process::ExitCode;

use clap::Parser;
use host_tests::serial_noise::{Tally, run};
use indicatif::{ProgressBar, ProgressStyle};

const EXAMPLES: &str = "\
Examples:
  cargo run --release -p host-tests --bin serial-fuzz                      10 million bytes
  cargo run --release -p host-tests --bin serial-fuzz -- --bytes 1000000000
  cargo run --release -p host-tests --bin serial-fuzz -- --from 123 --bytes 1    replay stream 123

Exit status: 0 every packet found and every byte accounted for, 1 not, 2 wrong arguments.";

/// Bytes of one stream, which has its own seed.
const STREAM_BYTES: usize = 10_000;

/// Feeds random bytes with packets in them to the serial decoder, and checks that it finds exactly the packets.
#[derive(Debug, Parser)]
#[command(name = "serial-fuzz", after_help = EXAMPLES)]
struct Arguments {
    /// Number of bytes, rounded up to whole streams of 10,000.
    #[arg(long, default_value_t = 10_000_000)]
    bytes: u64,
    /// Seed of the first stream; the others follow.
    #[arg(long, default_value_t = 0)]
    from: u64,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} bytes, {eta} left");
    let bar = ProgressBar::new(arguments.bytes);
    let bar = style.map_or(bar.clone(), |style| bar.with_style(style));
    let mut total = Tally::default();
    let mut seed = arguments.from;
    while total.bytes < arguments.bytes {
        match run(seed, STREAM_BYTES) {
            Ok(tally) => total.add(tally),
            Err(fault) => {
                bar.finish_and_clear();
                println!("stream {seed}: {fault}");
                println!("replay with --from {seed} --bytes 1");
                return ExitCode::FAILURE;
            }
        }
        bar.set_position(total.bytes);
        seed = seed.wrapping_add(1);
    }
    bar.finish_and_clear();
    println!(
        "{} bytes: all {} planted packets found, {} packets in all, {} other events, no byte lost",
        total.bytes, total.planted, total.found, total.other_events
    );
    ExitCode::SUCCESS
}
