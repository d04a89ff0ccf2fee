//! Random faults against the master, and broken masters against the observer.
//!
//! `CAMPAIGN_SEED=123 cargo test -p host-tests --test campaign` replays one seed. The long run is
//! `cargo run --release -p host-tests --bin campaign -- --count 100000`.

use std::sync::atomic::{AtomicU64, Ordering};

use host_tests::campaign::wheels::{self, WheelMutation, WheelScenario};
use host_tests::campaign::{Mutation, Promise, Scenario, Violation, run};

const SEEDS: u64 = 2_000;

/// Runs seeds on every core; the lowest one that breaks a promise, with its report.
fn first_violation(
    seeds: std::ops::Range<u64>,
    play: impl Fn(u64) -> Result<(), (Violation, String)> + Sync,
) -> Option<(u64, Promise, String)> {
    let next = AtomicU64::new(seeds.start);
    let worker = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return None;
            }
            if let Err((violation, scenario)) = play(seed) {
                next.store(seeds.end, Ordering::Relaxed);
                return Some((seed, violation.promise, format!("{violation}\n{scenario}")));
            }
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(worker)).collect();
        let found = workers
            .into_iter()
            .filter_map(|worker| worker.join().expect("no panic in a run"));
        found.min_by_key(|(seed, ..)| *seed)
    })
}

fn servos(mutation: Mutation) -> impl Fn(u64) -> Result<(), (Violation, String)> {
    move |seed| {
        let scenario = Scenario::from_seed(seed);
        run(&scenario, mutation).map_err(|violation| (violation, scenario.to_string()))
    }
}

fn hub_motors(mutation: WheelMutation) -> impl Fn(u64) -> Result<(), (Violation, String)> {
    move |seed| {
        let scenario = WheelScenario::from_seed(seed);
        wheels::run(&scenario, mutation).map_err(|violation| (violation, scenario.to_string()))
    }
}

/// The longer runs of wheels.
const WHEEL_SEEDS: u64 = 400;

fn seeds(count: u64) -> std::ops::Range<u64> {
    match std::env::var("CAMPAIGN_SEED") {
        Ok(seed) => {
            let seed = seed.parse().expect("CAMPAIGN_SEED is a number");
            seed..seed + 1
        }
        Err(_) => 0..count,
    }
}

#[test]
fn the_master_keeps_its_promises() {
    if let Some((seed, _, report)) = first_violation(seeds(SEEDS), servos(Mutation::None)) {
        panic!("replay with CAMPAIGN_SEED={seed}: {report}");
    }
}

#[test]
fn every_broken_master_is_caught() {
    let expected = |mutation| match mutation {
        Mutation::None => None,
        Mutation::DropsDisplaced | Mutation::CountsOnWouldBlock => Some(Promise::Books),
        Mutation::BelievesLateReply => Some(Promise::TrueReplies),
        Mutation::AsksTogether => Some(Promise::OneRequest),
        Mutation::ResumesAfterBusOff => Some(Promise::FaultStops),
        Mutation::RepeatsMoves | Mutation::MissesEnds => Some(Promise::Commands),
        // A queue takes set-points while the bus fails, so the master does not notice.
        Mutation::ReplaysQueue | Mutation::BridgesOutages => Some(Promise::Noticed),
    };
    for mutation in Mutation::BROKEN {
        let caught = first_violation(0..SEEDS, servos(mutation));
        println!(
            "{mutation:?}: {:?}",
            caught.as_ref().map(|(seed, promise, _)| (seed, promise))
        );
        assert_eq!(
            caught.map(|(_, promise, _)| promise),
            expected(mutation),
            "{mutation:?}"
        );
    }
}

#[test]
fn the_master_of_wheels_keeps_its_promises() {
    if let Some((seed, _, report)) =
        first_violation(seeds(WHEEL_SEEDS), hub_motors(WheelMutation::None))
    {
        panic!("replay with CAMPAIGN_SEED={seed}: {report}");
    }
}

#[test]
fn every_broken_run_of_wheels_is_caught() {
    for mutation in WheelMutation::BROKEN {
        let expected = match mutation {
            WheelMutation::None => None,
            WheelMutation::EnablesByItself | WheelMutation::StaysOn => Some(Promise::Commands),
            WheelMutation::BridgesOutages => Some(Promise::Noticed),
            WheelMutation::ChangesTooFast => Some(Promise::Limits),
        };
        let caught = first_violation(0..WHEEL_SEEDS, hub_motors(mutation));
        println!(
            "{mutation:?}: {:?}",
            caught.as_ref().map(|(seed, promise, _)| (seed, promise))
        );
        assert_eq!(
            caught.map(|(_, promise, _)| promise),
            expected,
            "{mutation:?}"
        );
    }
}
