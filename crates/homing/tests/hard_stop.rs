//! A search for a hard stop on an axis that does not follow.

use homing::{
    Abort, Config, Direction, HardStop, Homing, Inputs, Method, Progress, Reading, Travel, Watch,
};
use trajectory::Limits;

const MOST_COUNTS: u32 = 1_500;

fn config(direction: Direction) -> Config {
    Config {
        method: Method::HardStop(HardStop {
            direction,
            contact_permille: 300,
            most_permille: 800,
            contact_counts: 50,
            most_counts: MOST_COUNTS,
            repeat_counts: 3,
        }),
        cycle_us: 1_000,
        search: Limits::new(6.0, 0.2, 0.02).unwrap(),
        slow: Limits::new(1.5, 0.2, 0.02).unwrap(),
        way_counts: 10_000,
        back_off_counts: 300,
        reference_counts: 0,
        travel: Travel {
            min_counts: -20_000,
            max_counts: 20_000,
        },
        watch: Watch {
            max_age_us: 100_000,
            ..Watch::DEFAULT
        },
    }
}

/// Searches with an axis that is so far ahead of its set-points, with the torque that pulls it back. Returns how it ends.
fn search(direction: Direction, ahead_counts: i32) -> Progress {
    let mut homing = Homing::new(config(direction), 0).unwrap();
    let (mut sent_counts, sign) = (0, direction.sign());
    for cycle in 0..60_000 {
        let at_us = cycle * 1_000;
        let offset = if sent_counts == 0 {
            0
        } else {
            sign * ahead_counts
        };
        let inputs = Inputs {
            sent_counts,
            position: Some(Reading {
                value: sent_counts + offset,
                at_us,
            }),
            torque_permille: Some(Reading {
                value: (-sign * ahead_counts.signum() * 100) as i16,
                at_us,
            }),
            switch: None,
        };
        match homing.cycle(at_us, &inputs) {
            Progress::Target(target) => sent_counts = target,
            end => return end,
        }
    }
    panic!("it never ended");
}

#[test]
fn an_axis_that_runs_ahead_is_no_less_wrong_than_one_that_stays_behind() {
    for direction in [Direction::Positive, Direction::Negative] {
        let Progress::Failed(Abort::Blocked {
            limit_counts,
            actual_counts,
        }) = search(direction, 5_000)
        else {
            panic!("{direction:?}: {:?}", search(direction, 5_000));
        };
        assert_eq!((limit_counts, actual_counts), (MOST_COUNTS, 5_000));
        let behind = search(direction, -5_000);
        assert!(
            matches!(behind, Progress::Failed(Abort::ErrorWithoutTorque { .. })),
            "{behind:?}"
        );
        // A little ahead is what an axis in motion may be.
        let little = search(direction, 100);
        assert!(
            matches!(little, Progress::Failed(Abort::NotFound { .. })),
            "{little:?}"
        );
    }
}
