//! Random faults against the master, and broken masters against the observer.
//!
//! `CAMPAIGN_SEED=123 cargo test -p host-tests --test campaign` replays one seed. The long run is
//! `cargo run --release -p host-tests --bin campaign -- --count 100000`.

use std::sync::atomic::{AtomicU64, Ordering};

use host_tests::campaign::{Mutation, Promise, Scenario, run};

const SEEDS: u64 = 2_000;

/// Runs seeds on every core; the lowest one that breaks a promise, with its report.
fn first_violation(
    seeds: std::ops::Range<u64>,
    mutation: Mutation,
) -> Option<(u64, Promise, String)> {
    let next = AtomicU64::new(seeds.start);
    let worker = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return None;
            }
            let scenario = Scenario::from_seed(seed);
            if let Err(violation) = run(&scenario, mutation) {
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

#[test]
fn the_master_keeps_its_promises() {
    let seeds = match std::env::var("CAMPAIGN_SEED") {
        Ok(seed) => {
            let seed = seed.parse().expect("CAMPAIGN_SEED is a number");
            seed..seed + 1
        }
        Err(_) => 0..SEEDS,
    };
    if let Some((seed, _, report)) = first_violation(seeds, Mutation::None) {
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
        // A queue takes set-points while the bus fails, so the master does not notice.
        Mutation::ReplaysQueue | Mutation::BridgesOutages => Some(Promise::Noticed),
    };
    for mutation in Mutation::BROKEN {
        let caught = first_violation(0..SEEDS, mutation);
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
