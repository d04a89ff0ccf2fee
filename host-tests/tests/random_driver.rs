//! The random driver of the public API: no promise is broken, and enough happens to say so.

use host_tests::random_driver::{Finding, Servos, Tally, run};

fn play(runs: u64, run: impl Fn(u64) -> Result<Tally, Finding>) -> Tally {
    let mut tally = Tally::default();
    for seed in 0..runs {
        match run(seed) {
            Ok(other) => tally.add(&other),
            Err(finding) => panic!("{finding}"),
        }
    }
    println!("{tally:?}");
    tally
}

#[test]
fn servos() {
    let tally = play(20, run::<Servos>);
    assert_eq!(tally.cycles, 100_000);
    assert!(tally.set_points > 10_000 && tally.given_back > 1_000);
    assert!(tally.streams > 100 && tally.faults > 100 && tally.compared > 10_000);
}
