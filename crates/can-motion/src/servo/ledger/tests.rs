use super::*;
use crate::servo::config::{StepChange, Travel};
use dyn_can::StepLimit;
use proptest::prelude::*;
use std::vec::Vec;

fn limits(step: i32, change: u32) -> Limits {
    Limits::new(
        StepLimit::new(step).unwrap(),
        StepChange::from_counts(change).unwrap(),
        Travel::WHOLE,
    )
}

fn sent(ledger: &mut Ledger, limits: &Limits) -> i16 {
    ledger.begin_cycle();
    ledger.offer(limits);
    ledger.accepted()
}

#[test]
fn set_points_within_the_limits_are_sent_as_they_come() {
    let limits = limits(100, 10);
    let mut ledger = Ledger::NEW;
    let steps: Vec<i16> = [5, 20, 100, 100, 0, -40]
        .into_iter()
        .scan(0, |target, step| {
            *target += step;
            ledger.set_target(*target);
            Some(sent(&mut ledger, &limits))
        })
        .collect();
    assert_eq!(steps, [5, 20, 100, 100, 0, -40]);
}

#[test]
fn a_target_out_of_reach_is_followed_within_the_limits() {
    let limits = limits(100, 10);
    let mut ledger = Ledger::NEW;
    ledger.anchor(1_000);
    ledger.set_target(3_000);
    let steps: Vec<i16> = (0..40).map(|_| sent(&mut ledger, &limits)).collect();
    assert_eq!(ledger.sent_counts(), 3_000);
    assert_eq!(steps[0], 100, "the first step is the application's own");
    let tail: Vec<i16> = steps.into_iter().take_while(|step| *step != 0).collect();
    assert!(
        tail.windows(2).all(|pair| pair[0] - pair[1] <= 10),
        "{tail:?}"
    );
}

#[test]
fn a_missed_cycle_is_caught_up_from_standstill() {
    let limits = limits(200, 10);
    let mut ledger = Ledger::NEW;
    let mut target = 0;
    for _ in 0..5 {
        target += 50;
        ledger.set_target(target);
        assert_eq!(sent(&mut ledger, &limits), 50);
    }
    target += 50;
    ledger.set_target(target);
    ledger.missed();
    let mut before = 0;
    for cycle in 0..200 {
        target += 50;
        ledger.set_target(target);
        let step = sent(&mut ledger, &limits);
        assert!(
            (step - before).abs() <= 10,
            "cycle {cycle}: {before} then {step}"
        );
        before = step;
    }
    assert_eq!((before, ledger.backlog_counts()), (50, 0));
}

#[test]
fn a_returned_frame_is_owed_again() {
    let limits = limits(100, 100);
    let mut ledger = Ledger::NEW;
    ledger.set_target(40);
    let step = ledger.offer(&limits);
    ledger.accepted();
    ledger.returned(step);
    assert_eq!(ledger.backlog_counts(), 40);
    assert_eq!(sent(&mut ledger, &limits), 40);
}

#[test]
fn a_ramp_ends_where_it_says() {
    let limits = limits(100, 10);
    for sign in [1, -1] {
        let mut ledger = Ledger::NEW;
        for cycle in 1..=3 {
            ledger.set_target(sign * 100 * cycle);
            sent(&mut ledger, &limits);
        }
        let cycles = ledger.cycles_to_stop(&limits);
        assert_eq!(cycles, 10);
        let end = ledger.end_of_ramp(cycles);
        ledger.begin_ramp(cycles);
        for _ in 0..10 {
            sent(&mut ledger, &limits);
        }
        assert!(ledger.has_stopped());
        assert_eq!((ledger.sent_counts(), end), (sign * 750, sign * 750));
    }
}

proptest! {
    /// Whatever the targets and the fate of each frame: delivered plus owed is the target, no frame carries more than the step, none
    /// leads past the target, and after a cycle without a frame the velocity grows by the acceleration only.
    #[test]
    fn no_count_is_lost_and_no_limit_exceeded(
        step in 1..=16_384_i32,
        change in 1..=2_000_u32,
        cycles in proptest::collection::vec((-100_000..100_000_i32, 0..3_u8), 1..200),
    ) {
        let limits = limits(step, change);
        let mut ledger = Ledger::NEW;
        let (mut delivered, mut was_missed) = (0_i32, false);
        for (target, fate) in cycles {
            ledger.set_target(target);
            let before = target - ledger.sent_counts();
            let offered = ledger.offer(&limits);
            let counts = i32::from(offered.get());
            prop_assert!(offered.get().unsigned_abs() <= limits.max_step.get());
            prop_assert!((before - counts).abs() <= before.abs());
            prop_assert!(!was_missed || counts.unsigned_abs() <= change);
            match fate {
                0 => ledger.missed(),
                1 => { ledger.accepted(); ledger.returned(offered); ledger.missed(); }
                _ => { delivered += i32::from(ledger.accepted()); }
            }
            // Where nothing was left over, the next step is the application's own.
            was_missed = fate != 2 && ledger.backlog_counts() != 0;
            prop_assert_eq!(ledger.sent_counts(), delivered);
            prop_assert_eq!(delivered + ledger.backlog_counts(), target);
        }
    }

    /// A target that stands still is reached, and not passed on the way.
    #[test]
    fn what_is_left_over_arrives(step in 1..=500_i32, change in 1..=500_u32, distance in -20_000..20_000_i32) {
        let limits = limits(step, change);
        let mut ledger = Ledger::NEW;
        ledger.set_target(distance);
        ledger.missed();
        let mut before = 0;
        for _ in 0..45_000 {
            let counts = i32::from(sent(&mut ledger, &limits));
            prop_assert!((counts - before).abs() <= change as i32 + 1);
            before = counts;
        }
        prop_assert_eq!(ledger.backlog_counts(), 0);
        prop_assert_eq!(ledger.catch_up, CatchUp::NONE);
    }
}
