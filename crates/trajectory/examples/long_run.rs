//! Plans any number of random moves and judges each: `cargo run --release -p trajectory --example long_run -- --count 100000000`.

#[path = "../tests/independent/mod.rs"]
mod independent;

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::Instant;

use independent::cases::Case;
use independent::judge::{judge, judge_samples};
use independent::optimum::{is_beyond_range, lower_bound, optimum};
use trajectory::Profile;

const USAGE: &str = "usage: long_run [--count N] [--seed N] [--optimum-every N] [--show N]

Plans N random moves (default 1000000), starting with a seed (default 0), and judges each by the extrema of its segments. Every
N-th (default 1000) is sampled as well and compared with the time-optimal solver rsruckig. Prints the first failures (default 3) of
each kind and exits with 1 when there is one.";

struct Options {
    count: u64,
    seed: u64,
    optimum_every: u64,
    show: usize,
}

fn main() -> ExitCode {
    match options() {
        Ok(options) => run(&options),
        Err(reason) => {
            eprintln!("{reason}\n{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn options() -> Result<Options, String> {
    let mut options = Options {
        count: 1_000_000,
        seed: 0,
        optimum_every: 1_000,
        show: 3,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        let value = arguments.next().ok_or(format!("{name} needs a number"))?;
        let number: u64 = value
            .parse()
            .map_err(|_| format!("{name} needs a number, got {value}"))?;
        match name.as_str() {
            "--count" => options.count = number,
            "--seed" => options.seed = number,
            "--optimum-every" => options.optimum_every = number.max(1),
            "--show" => options.show = number as usize,
            _ => return Err(format!("unknown option {name}")),
        }
    }
    Ok(options)
}

fn run(options: &Options) -> ExitCode {
    let begin = Instant::now();
    let mut failures: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut figures = Figures::default();
    for place in 0..options.count {
        let seed = options.seed.wrapping_add(place);
        let compared = place % options.optimum_every == 0;
        if let Err((kind, reason)) = check(seed, compared, &mut figures) {
            failures
                .entry(format!("{:?}: {kind}", Case::of_seed(seed).class))
                .or_default()
                .push(format!("seed {seed}: {reason}"));
        }
        if (place + 1) % (options.count / 20).max(100_000) == 0 {
            eprintln!(
                "{} of {} moves, {:.0} s",
                place + 1,
                options.count,
                begin.elapsed().as_secs_f64()
            );
        }
    }
    println!("{} moves, {figures}", options.count);
    for (kind, reasons) in &failures {
        println!("{} times {kind}", reasons.len());
        for reason in reasons.iter().take(options.show) {
            println!("    {reason}");
        }
    }
    if failures.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

#[derive(Default)]
struct Figures {
    compared: u64,
    no_answer: u64,
    /// Rightly without a profile: too long or too far.
    refused: u64,
    /// The other solver's moves that are more than a thousandth longer than ours.
    beaten: u64,
    /// Largest duration over the optimum, of moves of at least one cycle.
    worst: f64,
    worst_seed: u64,
}

impl std::fmt::Display for Figures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} of them rightly refused; {} sampled and compared with rsruckig ({} without an answer, {} where ours is faster); longest {:.5} times the optimum (seed {})",
            self.refused, self.compared, self.no_answer, self.beaten, self.worst, self.worst_seed
        )
    }
}

fn check(seed: u64, compared: bool, figures: &mut Figures) -> Result<(), (&'static str, String)> {
    let case = Case::of_seed(seed);
    let profile = match Profile::to_rest(&case.start, case.target, &case.limits) {
        Ok(profile) => profile,
        Err(_) if is_beyond_range(&case) => {
            figures.refused += 1;
            return Ok(());
        }
        Err(error) => return Err(("no profile", error.to_string())),
    };
    judge(&case, &profile).map_err(|reason| ("judge", reason))?;
    let duration = profile.duration().ticks() as f64 / 4_294_967_296.0;
    if duration < lower_bound(&case) * 0.999_9 - LATER_CYCLES {
        return Err(("too fast", format!("{duration} cycles")));
    }
    if !compared {
        return Ok(());
    }
    judge_samples(&case, &profile, 1_000).map_err(|reason| ("samples", reason))?;
    figures.compared += 1;
    let Some(best) = optimum(&case) else {
        figures.no_answer += 1;
        return Ok(());
    };
    let ratio = (duration - LATER_CYCLES) / best;
    if ratio > figures.worst {
        (figures.worst, figures.worst_seed) = (ratio, seed);
    }
    if duration > best * SLOWER + LATER_CYCLES {
        return Err(("slow", format!("{duration} cycles, the optimum is {best}")));
    }
    if duration < best * (1.0 - 1e-3) - LATER_CYCLES {
        figures.beaten += 1;
    }
    Ok(())
}

/// See tests/random_states.rs.
const SLOWER: f64 = 1.01;
const LATER_CYCLES: f64 = 1.0 / 256.0;
