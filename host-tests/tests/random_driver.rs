//! The random driver of the public API: no promise is broken, and enough happens to say so.

use host_tests::random_driver::{Finding, RUN_CYCLES, Servos, Tally, Thirds, Wheels, run};

fn play(cycles: u64, run: impl Fn(u64, usize) -> Result<Tally, Finding>) -> Tally {
    let mut tally = Tally::default();
    for seed in 0..cycles / RUN_CYCLES {
        match run(seed, 30) {
            Ok(other) => tally.add(&other),
            Err(finding) => panic!("{finding}"),
        }
    }
    println!("{tally:?}");
    assert_eq!(tally.cycles, cycles);
    tally
}

#[test]
fn servos_keep_the_promises() {
    let tally = play(100_000, run::<Servos>);
    assert!(tally.set_points > 50_000 && tally.given_back > 500);
    assert!(tally.streams > 200 && tally.faults > 500);
    assert!(tally.compared > 50_000);
    assert!(tally.arrivals > 100 && tally.triggered > 50);
}

#[test]
fn wheels_keep_the_promises() {
    let tally = play(100_000, run::<Wheels>);
    assert!(tally.set_points > 20_000 && tally.given_back > 500);
    assert!(tally.streams > 100 && tally.faults > 500);
}

#[test]
fn a_third_family_keeps_the_promises() {
    let tally = play(10_000, run::<Thirds>);
    assert!(tally.set_points > 5_000 && tally.streams > 20);
    assert!(tally.faults > 50 && tally.compared > 5_000);
}
