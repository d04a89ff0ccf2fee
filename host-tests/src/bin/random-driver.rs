//! The long run of the random driver, with a progress bar.

use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::{Parser, ValueEnum};
use host_tests::random_driver::{Finding, RUN_CYCLES, Servos, Tally, Thirds, Wheels, run};
use indicatif::{ProgressBar, ProgressStyle};

const EXAMPLES: &str = "\
Examples:
  cargo run --release -p host-tests --bin random-driver -- --cycles 10000000
  cargo run --release -p host-tests --bin random-driver -- --family wheels --seed 123     replay one seed

Exit status: 0 every promise kept, 1 a promise broken, 2 wrong arguments.";

/// Drives the public API of the master at random and checks its promises.
#[derive(Debug, Parser)]
#[command(name = "random-driver", after_help = EXAMPLES)]
struct Arguments {
    /// Cycles of each family.
    #[arg(long, default_value_t = 1_000_000)]
    cycles: u64,
    /// First seed; each seed is a run of 5000 cycles.
    #[arg(long, default_value_t = 0)]
    from: u64,
    /// Play this seed alone.
    #[arg(long, conflicts_with_all = ["cycles", "from"])]
    seed: Option<u64>,
    /// How many of the latest frames, calls and events a finding has.
    #[arg(long, default_value_t = 30)]
    history: usize,
    /// The family; all of them when it is not given.
    #[arg(long)]
    family: Option<FamilyName>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FamilyName {
    Servos,
    Wheels,
    Thirds,
}

type Play = fn(u64, usize) -> Result<Tally, Finding>;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let runs = arguments.cycles.div_ceil(RUN_CYCLES);
    let seeds = match arguments.seed {
        Some(seed) => seed..seed.saturating_add(1),
        None => arguments.from..arguments.from.saturating_add(runs),
    };
    let families: [(FamilyName, Play); 3] = [
        (FamilyName::Servos, run::<Servos>),
        (FamilyName::Wheels, run::<Wheels>),
        (FamilyName::Thirds, run::<Thirds>),
    ];
    let mut found = 0;
    for (family, play) in families {
        if arguments.family.is_none_or(|wanted| wanted == family) {
            println!("{family:?}: seeds {}..{}", seeds.start, seeds.end);
            found += play_all(seeds.clone(), |seed| play(seed, arguments.history));
        }
    }
    println!("{found} findings");
    if found == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Plays the seeds on every core, prints what was found and returns how much that is.
fn play_all(
    seeds: std::ops::Range<u64>,
    play: impl Fn(u64) -> Result<Tally, Finding> + Sync,
) -> usize {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} seeds, {eta} left");
    let bar = ProgressBar::new(seeds.end - seeds.start);
    let bar = style.map_or(bar.clone(), |style| bar.with_style(style));
    let next = AtomicU64::new(seeds.start);
    let worker = || {
        let (mut tally, mut findings) = (Tally::default(), Vec::new());
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return (tally, findings);
            }
            match play(seed) {
                Ok(other) => tally.add(&other),
                Err(finding) => findings.push(finding),
            }
            bar.inc(1);
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let (mut tally, mut findings) = (Tally::default(), Vec::new());
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(worker)).collect();
        for worker in workers {
            let (other, found) = worker.join().expect("panics are findings");
            tally.add(&other);
            findings.extend(found);
        }
    });
    bar.finish_and_clear();
    findings.sort_by_key(|finding| finding.seed);
    for finding in findings.iter().take(5) {
        println!("{finding}");
    }
    println!("{tally:?}, {} findings", findings.len());
    findings.len()
}
