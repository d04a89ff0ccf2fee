//! A homing with a plant that follows at once. What needs a bus, a master and a real lag is in `host-tests/tests/homing`.

use std::vec::Vec;

use proptest::prelude::*;
use trajectory::Limits;

use super::*;
use crate::{Direction, HardStop, Level, Reading, Switch, Travel, Watch};

const STOP: HardStop = HardStop {
    direction: Direction::Positive,
    contact_permille: 300,
    most_permille: 800,
    contact_counts: 50,
    most_counts: 1_500,
    repeat_counts: 3,
};

fn config(method: Method) -> Config {
    Config {
        method,
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

/// A shaft that follows its set-point up to a stop, where it pushes 4 thousandths a count; read every 10 ms.
struct Plant {
    stop: i32,
    inputs: Inputs,
}

impl Plant {
    fn new(start: i32, stop: i32) -> Self {
        let inputs = Inputs {
            sent_counts: start,
            position: None,
            torque_permille: None,
            switch: None,
        };
        Self { stop, inputs }
    }

    fn read(&mut self, now_us: u64) {
        let sent = self.inputs.sent_counts;
        let value = sent.min(self.stop);
        let (at_us, push) = (now_us, (sent - value) * 4);
        self.inputs.position = Some(Reading { value, at_us });
        self.inputs.torque_permille = Some(Reading {
            value: push.min(1_000) as i16,
            at_us,
        });
    }

    /// To the end, with every target on the way.
    fn run(&mut self, homing: &mut Homing) -> (Progress, Vec<i32>) {
        let mut targets = Vec::new();
        for cycle in 0..100_000_u64 {
            let now_us = cycle * 1_000;
            if cycle % 10 == 0 {
                self.read(now_us);
            }
            self.inputs.switch = Some(Reading {
                value: self.inputs.sent_counts >= 2_000,
                at_us: now_us,
            });
            match homing.cycle(now_us, &self.inputs) {
                Progress::Target(target) => {
                    targets.push(target);
                    self.inputs.sent_counts = target;
                }
                end => return (end, targets),
            }
        }
        panic!("no end: {homing:?}");
    }
}

fn switch() -> Method {
    Method::Switch(Switch {
        direction: Direction::Positive,
        operated: Level::High,
        most_counts: 500,
        most_permille: None,
    })
}

proptest! {
    /// No two targets are further apart than the search is fast, whatever happens, and the last two are the same.
    #[test]
    fn targets_keep_the_limits(
        start in -3_000..1_500_i32,
        stop in 1_600..12_000_i32,
        cancelled_at in 0..12_000_u32,
        is_switch in any::<bool>(),
    ) {
        let method = if is_switch { switch() } else { Method::HardStop(STOP) };
        let mut homing = Homing::new(config(method), start).unwrap();
        let mut plant = Plant::new(start, stop);
        let mut targets = std::vec![start];
        for cycle in 0..40_000_u32 {
            let now_us = u64::from(cycle) * 1_000;
            if cycle == cancelled_at {
                homing.cancel();
            }
            if cycle % 10 == 0 {
                plant.read(now_us);
            }
            let value = plant.inputs.sent_counts.min(stop) >= 2_000;
            plant.inputs.switch = Some(Reading { value, at_us: now_us });
            match homing.cycle(now_us, &plant.inputs) {
                Progress::Target(target) => {
                    targets.push(target);
                    plant.inputs.sent_counts = target;
                }
                Progress::Failed(Abort::Plan(error)) => panic!("{error}"),
                _ => break,
            }
        }
        // A step of 6 counts a cycle, rounded to whole counts, and changes of 0.2.
        let steps: Vec<i32> = targets.windows(2).map(|pair| pair[1] - pair[0]).collect();
        prop_assert!(steps.iter().all(|step| step.abs() <= 7));
        prop_assert!(steps.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 2));
        prop_assert_eq!(steps.last().copied().unwrap_or(0).abs() <= 1, true);
        prop_assert!(targets.iter().all(|target| (start - 10_300..=start + 11_500).contains(target)));
    }
}

#[test]
fn the_end_is_told_again_and_again() {
    let mut homing = Homing::new(config(Method::HardStop(STOP)), 0).unwrap();
    let mut plant = Plant::new(0, 4_000);
    let (end, targets) = plant.run(&mut homing);
    let Progress::Found(home) = end else {
        panic!("{end:?}")
    };
    assert_eq!((home.found_counts, targets.last()), (4_000, Some(&3_700)));
    homing.cancel();
    assert_eq!(homing.cycle(9_000_000, &plant.inputs), end);
}

#[test]
fn the_edge_of_a_switch_is_found_slowly() {
    let mut homing = Homing::new(config(switch()), 0).unwrap();
    let (end, _) = Plant::new(0, 100_000).run(&mut homing);
    let Progress::Found(home) = end else {
        panic!("{end:?}")
    };
    assert!(home.found_counts.abs_diff(2_000) <= 3, "{home:?}");
    assert!(home.uncertainty_counts <= 30, "{home:?}");
}

#[test]
fn the_motion_waits_for_set_points_that_are_not_sent() {
    let mut homing = Homing::new(config(Method::HardStop(STOP)), 0).unwrap();
    let mut plant = Plant::new(0, 4_000);
    let mut last = 0;
    for cycle in 0..5_000_u64 {
        plant.read(cycle * 1_000);
        // Nothing gets out.
        let Progress::Target(target) = homing.cycle(cycle * 1_000, &plant.inputs) else {
            panic!("no end is expected");
        };
        last = target;
    }
    assert!((48..=54).contains(&last), "{last}");
}

/// Searches with an axis that is so far ahead of its set-points, with the torque that pulls it back. Returns how it ends.
fn search_ahead(direction: Direction, ahead_counts: i32) -> Progress {
    let mut homing =
        Homing::new(config(Method::HardStop(HardStop { direction, ..STOP })), 0).unwrap();
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
        }) = search_ahead(direction, 5_000)
        else {
            panic!("{direction:?}: {:?}", search_ahead(direction, 5_000));
        };
        assert_eq!((limit_counts, actual_counts), (STOP.most_counts, 5_000));
        let behind = search_ahead(direction, -5_000);
        assert!(
            matches!(behind, Progress::Failed(Abort::ErrorWithoutTorque { .. })),
            "{behind:?}"
        );
        // A little ahead is what an axis in motion may be.
        let little = search_ahead(direction, 100);
        assert!(
            matches!(little, Progress::Failed(Abort::NotFound { .. })),
            "{little:?}"
        );
    }
}

#[test]
fn an_origin_that_leaves_32_bits_is_refused() {
    let far = |method, reference_counts, start| {
        let travel = Travel {
            min_counts: i32::MIN,
            max_counts: i32::MAX,
        };
        let config = Config {
            reference_counts,
            travel,
            ..config(method)
        };
        Homing::new(config, start).err()
    };
    let stop = Method::HardStop(STOP);
    // The reach of the search is 11,800 counts to either side, that to a switch 10,800.
    let most = i32::MAX - 11_800;
    assert_eq!(far(stop, most, 0), None);
    assert_eq!(
        far(stop, most + 2, 0),
        Some(Refusal::OriginTooFar {
            actual: i64::from(i32::MIN) - 1
        })
    );
    assert_eq!(far(switch(), most + 1_000, 0), None);
    assert_eq!(
        far(Method::Here, -1, i32::MAX),
        Some(Refusal::OriginTooFar {
            actual: i64::from(i32::MAX) + 1
        })
    );
}

#[test]
fn an_axis_that_stays_where_it_is_needs_no_way() {
    for start in [i32::MIN, i32::MIN + 1, 0, i32::MAX] {
        let here = config(Method::Here);
        let ends = Travel {
            min_counts: start,
            max_counts: start,
        };
        assert_eq!(here.reach(start), Ok(ends));
        let mut homing = Homing::new(here, start).unwrap();
        let (end, _) = Plant::new(start, i32::MAX).run(&mut homing);
        let Progress::Found(home) = end else {
            panic!("{end:?}")
        };
        assert_eq!(home.frame.origin_counts(), start);
    }
}

/// A drive that reports a position which it cannot have: the origin does not wrap.
#[test]
fn a_place_far_beyond_the_reach_is_not_found() {
    let here = Config {
        reference_counts: 10,
        ..config(Method::Here)
    };
    let mut homing = Homing::new(here, 0).unwrap();
    let mut plant = Plant::new(0, i32::MAX);
    for cycle in 0..2_000_u64 {
        let at_us = cycle * 1_000;
        let value = i32::MIN;
        plant.inputs.position = Some(Reading { value, at_us });
        let end = homing.cycle(at_us, &plant.inputs);
        if end != Progress::Target(0) {
            assert!(
                matches!(end, Progress::Failed(Abort::NotFound { .. })),
                "{end:?}"
            );
            return;
        }
    }
    panic!("no end: {homing:?}");
}

/// From a switch that is operated down to this edge and read every 80 ms, at most 300 counts off it and then 40 back.
fn home_beside_an_edge(start: i32, edge: i32, settle_us: u32) -> Progress {
    let short = Config {
        search: Limits::new(0.3, 0.2, 0.02).unwrap(),
        slow: Limits::new(0.3, 0.2, 0.02).unwrap(),
        way_counts: 300,
        back_off_counts: 40,
        watch: Watch {
            max_age_us: 100_000,
            settle_us,
            ..Watch::DEFAULT
        },
        ..config(switch())
    };
    let mut homing = Homing::new(short, start).unwrap();
    let mut plant = Plant::new(start, i32::MAX);
    for cycle in 0..100_000_u64 {
        let now_us = cycle * 1_000;
        plant.read(now_us);
        if cycle % 80 == 0 {
            plant.inputs.switch = Some(Reading {
                value: plant.inputs.sent_counts >= edge,
                at_us: now_us,
            });
        }
        match homing.cycle(now_us, &plant.inputs) {
            Progress::Target(target) => plant.inputs.sent_counts = target,
            end => return end,
        }
    }
    panic!("no end: {homing:?}");
}

/// The way off the switch ends just behind its edge.
#[test]
fn a_switch_at_the_end_of_the_way_off_it_has_time_to_be_read() {
    let end = home_beside_an_edge(2_290, 2_000, 1_000_000);
    let Progress::Found(home) = end else {
        panic!("{end:?}");
    };
    assert!(home.found_counts.abs_diff(2_000) <= 30, "{home:?}");
    let end = home_beside_an_edge(2_290, 1_500, 1_000_000);
    assert_eq!(
        end,
        Progress::Failed(Abort::SwitchStuck { way_counts: 300 })
    );
}

/// Where an axis comes to rest in less time than a reading takes.
#[test]
fn a_switch_that_was_left_has_time_to_be_read() {
    for start in 2_200..2_299 {
        let end = home_beside_an_edge(start, 2_000, 1_000);
        assert!(matches!(end, Progress::Found(_)), "{start}: {end:?}");
    }
}
