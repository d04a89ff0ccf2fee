//! The long run of the fault campaign, with a progress bar.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;
use host_tests::campaign::{Mutation, Promise, Scenario, run};
use indicatif::{ProgressBar, ProgressStyle};

const EXAMPLES: &str = "\
Examples:
  cargo run --release -p host-tests --bin campaign -- --count 100000
  cargo run --release -p host-tests --bin campaign -- --seed 123     replay one seed and print it

Exit status: 0 every promise kept, 1 a promise broken, 2 wrong arguments.";

/// Plays random fault scenarios against the master and checks its promises.
#[derive(Debug, Parser)]
#[command(name = "campaign", after_help = EXAMPLES)]
struct Arguments {
    /// Number of scenarios.
    #[arg(long, default_value_t = 2_000)]
    count: u64,
    /// First seed.
    #[arg(long, default_value_t = 0)]
    from: u64,
    /// Play this seed alone, and print what it does.
    #[arg(long, conflicts_with_all = ["count", "from"])]
    seed: Option<u64>,
}

/// Seeds that broke a promise.
type Broken = BTreeMap<Promise, Vec<(u64, String)>>;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let seeds = match arguments.seed {
        Some(seed) => {
            print!("{}", Scenario::from_seed(seed));
            seed..seed.saturating_add(1)
        }
        None => arguments.from..arguments.from.saturating_add(arguments.count),
    };
    let total = seeds.end - seeds.start;
    let broken = play(seeds);
    for (promise, cases) in &broken {
        println!("{promise:?}: {} seeds", cases.len());
        for (seed, what) in cases.iter().take(5) {
            println!("  seed {seed}: {what}");
        }
    }
    let failed: usize = broken.values().map(Vec::len).sum();
    println!("{total} scenarios, {failed} broke a promise");
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn play(seeds: std::ops::Range<u64>) -> Broken {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} scenarios, {eta} left");
    let bar = ProgressBar::new(seeds.end - seeds.start);
    let bar = style.map_or(bar.clone(), |style| bar.with_style(style));
    let next = AtomicU64::new(seeds.start);
    let worker = || {
        let mut found = Vec::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return found;
            }
            if let Err(violation) = run(&Scenario::from_seed(seed), Mutation::None) {
                found.push((violation.promise, seed, violation.to_string()));
            }
            bar.inc(1);
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut broken = Broken::new();
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(worker)).collect();
        for worker in workers {
            // A panic in a run is a failure of the campaign itself.
            for (promise, seed, what) in worker.join().expect("no panic in a run") {
                broken.entry(promise).or_default().push((seed, what));
            }
        }
    });
    bar.finish_and_clear();
    broken.values_mut().for_each(|cases| cases.sort());
    broken
}
