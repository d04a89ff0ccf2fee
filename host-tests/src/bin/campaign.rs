//! The long run of the fault campaign, with a progress bar.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::{Parser, ValueEnum};
use host_tests::campaign::wheels::{self, WheelMutation, WheelScenario};
use host_tests::campaign::{Mutation, Promise, Scenario, Violation, run};
use indicatif::{ProgressBar, ProgressStyle};

const EXAMPLES: &str = "\
Examples:
  cargo run --release -p host-tests --bin campaign -- --count 100000
  cargo run --release -p host-tests --bin campaign -- --seed 123     replay one seed and print it
  cargo run --release -p host-tests --bin campaign -- --family wheels --seed 123

Exit status: 0 every promise kept, 1 a promise broken, 2 wrong arguments.";

/// Plays random fault scenarios against the master and checks its promises.
#[derive(Debug, Parser)]
#[command(name = "campaign", after_help = EXAMPLES)]
struct Arguments {
    /// The drives.
    #[arg(long, value_enum, default_value_t = FamilyName::Servos)]
    family: FamilyName,
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FamilyName {
    Servos,
    Wheels,
}

impl FamilyName {
    fn play(self, seed: u64) -> Result<(), Violation> {
        match self {
            Self::Servos => run(&Scenario::from_seed(seed), Mutation::None),
            Self::Wheels => wheels::run(&WheelScenario::from_seed(seed), WheelMutation::None),
        }
    }

    fn describe(self, seed: u64) -> String {
        match self {
            Self::Servos => Scenario::from_seed(seed).to_string(),
            Self::Wheels => WheelScenario::from_seed(seed).to_string(),
        }
    }
}

/// Seeds that broke a promise.
type Broken = BTreeMap<Promise, Vec<(u64, String)>>;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let seeds = match arguments.seed {
        Some(seed) => {
            print!("{}", arguments.family.describe(seed));
            seed..seed.saturating_add(1)
        }
        None => arguments.from..arguments.from.saturating_add(arguments.count),
    };
    let total = seeds.end - seeds.start;
    let broken = play(arguments.family, seeds);
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

fn play(family: FamilyName, seeds: std::ops::Range<u64>) -> Broken {
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
            if let Err(violation) = family.play(seed) {
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
