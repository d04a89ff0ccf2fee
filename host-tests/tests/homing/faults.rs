//! Each reason by its cause.

use drive_sim::{EndStops, Mechanics, Switch as SimSwitch, SwitchSide};
use dyn_can::Revision;
use homing::{Abort, Awaited, Config, Method, Progress};

use crate::stage::{Machine, Stage};

const PLAIN: Machine = Machine::PLAIN;

#[test]
fn a_torque_that_grows_old_ends_the_search() {
    let mut stage = Stage::with_stop(PLAIN);
    let end = stage.run(PLAIN.hard_stop(), |stage, _, cycle| {
        if cycle == 500 {
            // From here on the application repeats an old reading.
            let until_us = stage.rig.now().as_us();
            stage.lie = Box::new(move |inputs| {
                if let Some(torque) = &mut inputs.torque_permille {
                    torque.at_us = torque.at_us.min(until_us);
                }
            });
        }
    });
    let Progress::Failed(Abort::TooOld {
        what: Awaited::Torque,
        limit_us: 50_000,
        age_us: Some(age_us),
    }) = end
    else {
        panic!("{end:?}");
    };
    assert!((50_001..53_000).contains(&age_us), "{age_us}");
    // It slowed down on its way, far from the stop.
    assert!(
        stage.position() > 100 && stage.position() < 4_900,
        "{}",
        stage.position()
    );
}

#[test]
fn what_is_never_read_is_named_before_anything_moves() {
    type Lie = fn(&mut homing::Inputs);
    let cases: [(Lie, Config, Awaited); 3] = [
        (
            |inputs| inputs.torque_permille = None,
            PLAIN.hard_stop(),
            Awaited::Torque,
        ),
        (
            |inputs| inputs.position = None,
            PLAIN.hard_stop(),
            Awaited::Position,
        ),
        (
            |inputs| inputs.switch = None,
            PLAIN.limit_switch(),
            Awaited::Switch,
        ),
    ];
    for (lie, config, awaited) in cases {
        let mut stage = Stage::with_stop(PLAIN);
        stage.lie = Box::new(lie);
        let abort = stage.failed(config);
        let expected = Abort::TooOld {
            what: awaited,
            limit_us: 50_000,
            age_us: None,
        };
        assert_eq!(abort, expected);
        assert_eq!(stage.rig.drive(0).commanded_counts(), 0);
    }
}

#[test]
fn a_drive_that_falls_silent_ends_it_before_the_master_calls_it_lost() {
    let mut stage = Stage::with_stop(PLAIN);
    let mut config = PLAIN.hard_stop();
    config.watch.max_age_us = 25_000;
    let mut homing = stage.homing(config);
    let mut end = None;
    for cycle in 0..2_000 {
        if cycle == 600 {
            stage.rig.drive_mut(0).faults_mut().fall_silent();
        }
        match stage.cycle(&mut homing) {
            Progress::Target(_) => {}
            other => {
                end = Some(other);
                break;
            }
        }
    }
    assert!(
        matches!(end, Some(Progress::Failed(Abort::TooOld { .. }))),
        "{end:?} {:?}",
        stage.rig.axis(0).fault
    );
}

/// The torque of a drive whose revision is taken for the other one has the wrong sign.
#[test]
fn a_torque_of_the_wrong_sign_is_named() {
    for revision in [Revision::V1_2A, Revision::V1_6A] {
        let machine = Machine { revision, ..PLAIN };
        let mut stage = Stage::with_stop(machine);
        stage.lie = Box::new(|inputs| {
            if let Some(torque) = &mut inputs.torque_permille {
                torque.value = -torque.value;
            }
        });
        let abort = stage.failed(machine.hard_stop());
        assert!(
            matches!(
                abort,
                Abort::TorqueAgainst {
                    contact_permille: 200,
                    actual_permille: ..=-200,
                    error_counts: 90..
                }
            ),
            "{abort:?}"
        );
        // The motor was relieved.
        let torque = stage.inputs().torque_permille.unwrap();
        assert!(torque.value.abs() < 100, "{torque:?}");
    }
}

#[test]
fn a_following_error_without_torque_is_no_contact() {
    let mut stage = Stage::with_stop(PLAIN);
    stage.lie = Box::new(|inputs| {
        if let Some(torque) = &mut inputs.torque_permille {
            torque.value = 30;
        }
    });
    let abort = stage.failed(PLAIN.hard_stop());
    assert!(
        matches!(
            abort,
            Abort::ErrorWithoutTorque {
                limit_counts: 2_000,
                error_counts: 2_000..2_200,
                contact_permille: 200,
                actual_permille: 30
            }
        ),
        "{abort:?}"
    );
    let torque = stage.rig.axis(0).feedback.torque.unwrap().value;
    assert!(torque.of_peak().abs() < 0.05, "{torque:?}");
}

#[test]
fn a_torque_without_following_error_is_no_contact() {
    let mut stage = Stage::with_stop(PLAIN);
    let end = stage.run(PLAIN.hard_stop(), |stage, _, cycle| {
        if cycle == 600 {
            stage.lie = Box::new(|inputs| {
                if let Some(torque) = &mut inputs.torque_permille {
                    torque.value = 650;
                }
            });
        }
    });
    assert!(
        matches!(
            end,
            Progress::Failed(Abort::TorqueWithoutError {
                limit_permille: 600,
                actual_permille: 650,
                contact_counts: 90,
                ..
            })
        ),
        "{end:?}"
    );
    assert!(stage.position() < 4_000);
}

#[test]
fn a_motor_that_pushes_at_rest_is_refused() {
    let mut stage = Stage::with_stop(PLAIN);
    stage.lie = Box::new(|inputs| {
        if let Some(torque) = &mut inputs.torque_permille {
            torque.value = 250;
        }
    });
    let expected = Abort::TorqueAtRest {
        limit_permille: 200,
        actual_permille: 250,
    };
    assert_eq!(stage.failed(PLAIN.hard_stop()), expected);
    assert_eq!(stage.rig.drive(0).commanded_counts(), 0);
}

#[test]
fn a_shaft_that_turns_is_refused() {
    for config in [
        PLAIN.hard_stop(),
        Config {
            method: Method::Here,
            ..PLAIN.hard_stop()
        },
    ] {
        let mut stage = Stage::with_stop(PLAIN);
        stage.lie = Box::new(|inputs| {
            if let Some(position) = &mut inputs.position {
                position.value += (position.at_us / 10_000) as i32;
            }
        });
        let abort = stage.failed(config);
        assert_eq!(
            abort,
            Abort::NotStill {
                limit_counts: 16,
                actual_counts: 17
            }
        );
        assert_eq!(stage.rig.drive(0).commanded_counts(), 0);
    }
}

/// The first contact is with something that gives way before the second.
#[test]
fn what_gives_way_is_no_stop() {
    let mut stage = Stage::with_stop(PLAIN);
    let mut contact = None;
    let end = stage.run(PLAIN.hard_stop(), |stage, _, _| {
        let torque = stage
            .inputs()
            .torque_permille
            .map_or(0, |torque| torque.value);
        contact = contact.or((torque > 150).then_some(stage.cycles));
        // Backed off by then; a position 40 counts further is as a stop that was pushed back.
        if contact.is_some_and(|at| stage.cycles > at + 300) {
            stage.lie = Box::new(|inputs| {
                if let Some(position) = &mut inputs.position {
                    position.value -= 12;
                }
            });
        }
    });
    assert!(
        matches!(
            end,
            Progress::Failed(Abort::NotRepeated {
                limit_counts: 10,
                actual_counts: Some(11..14)
            })
        ),
        "{end:?}"
    );
    assert!(stage.position() < 4_700, "{}", stage.position());
}

#[test]
fn a_stop_that_is_gone_is_not_repeated() {
    let mut stage = Stage::with_stop(PLAIN);
    let mut contact = None;
    let end = stage.run(PLAIN.hard_stop(), |stage, _, _| {
        let torque = stage
            .inputs()
            .torque_permille
            .map_or(0, |torque| torque.value);
        contact = contact.or((torque > 150).then_some(stage.cycles));
        if contact.is_some_and(|at| stage.cycles > at + 300) {
            // Neither torque nor error: the axis goes on.
            stage.lie = Box::new(|inputs| {
                inputs.torque_permille = inputs
                    .torque_permille
                    .map(|torque| homing::Reading { value: 0, ..torque });
                if let Some(position) = &mut inputs.position {
                    position.value = inputs.sent_counts;
                }
            });
        }
    });
    let expected = Abort::NotRepeated {
        limit_counts: 10,
        actual_counts: None,
    };
    assert_eq!(end, Progress::Failed(expected));
}

/// Runs to a stop; from the time at which the motor has backed off on, the application tells something else.
fn after_backing_off(lie: fn(&mut homing::Inputs)) -> Progress {
    let mut stage = Stage::with_stop(PLAIN);
    let mut contact = None;
    stage.run(PLAIN.hard_stop(), |stage, _, _| {
        let torque = stage.inputs().torque_permille;
        let pushes = torque.is_some_and(|torque| torque.value > 150);
        contact = contact.or(pushes.then_some(stage.cycles));
        if contact.is_some_and(|at| stage.cycles > at + 100) {
            stage.lie = Box::new(lie);
        }
    })
}

#[test]
fn an_axis_that_sticks_where_it_backs_off_is_named() {
    let end = after_backing_off(|inputs| {
        if let Some(torque) = &mut inputs.torque_permille {
            torque.value = 300;
        }
    });
    let expected = Abort::StillPressed {
        limit_permille: 200,
        actual_permille: 300,
    };
    assert_eq!(end, Progress::Failed(expected));
    let end = after_backing_off(|inputs| {
        if let Some(position) = &mut inputs.position {
            position.value = 4_900;
        }
    });
    let expected = Abort::NotArrived {
        limit_counts: 16,
        actual_counts: 300,
    };
    assert_eq!(end, Progress::Failed(expected));
}

/// A switch beyond a stop is never reached.
#[test]
fn something_in_the_way_of_a_switch_ends_it() {
    let mechanics = Mechanics {
        stops: Some(EndStops {
            low_counts: -100_000,
            high_counts: 3_000,
        }),
        switch: Some(SimSwitch {
            at_counts: 5_000,
            side: SwitchSide::Above,
        }),
    };
    let mut stage = Stage::with(PLAIN, mechanics);
    let abort = stage.failed(PLAIN.limit_switch());
    assert!(
        matches!(
            abort,
            Abort::Blocked {
                limit_counts: 1_000,
                actual_counts: 1_000..1_100
            }
        ),
        "{abort:?}"
    );
    assert!(stage.inputs().torque_permille.unwrap().value.abs() < 100);
    // With a limit of the torque it ends sooner.
    let mut stage = Stage::with(PLAIN, mechanics);
    let mut config = PLAIN.limit_switch();
    if let Method::Switch(switch) = &mut config.method {
        switch.most_permille = Some(300);
    }
    let abort = stage.failed(config);
    assert!(
        matches!(
            abort,
            Abort::Overload {
                limit_permille: 300,
                actual_permille: 300..700
            }
        ),
        "{abort:?}"
    );
}

#[test]
fn a_switch_that_stays_operated_is_stuck() {
    let mut stage = Stage::with_switch(PLAIN);
    let mut is_stuck = false;
    let end = stage.run(PLAIN.limit_switch(), |stage, _, _| {
        is_stuck |= stage
            .rig
            .drive(0)
            .switch_is_operated(stage.rig.bench.now_ns());
        if is_stuck {
            stage.lie = Box::new(|inputs| {
                if let Some(level) = &mut inputs.switch {
                    level.value = true;
                }
            });
        }
    });
    let expected = Abort::SwitchStuck { way_counts: 400 };
    assert_eq!(end, Progress::Failed(expected));
}

#[test]
fn a_switch_that_lets_go_is_unsteady() {
    let mut stage = Stage::with_switch(PLAIN);
    let (mut visits, mut was_operated, mut since) = (0, false, 0);
    let end = stage.run(PLAIN.limit_switch(), |stage, _, cycle| {
        let is_operated = stage
            .rig
            .drive(0)
            .switch_is_operated(stage.rig.bench.now_ns());
        visits += u32::from(is_operated && !was_operated);
        if is_operated && !was_operated {
            since = cycle;
        }
        was_operated = is_operated;
        // At the second visit it lets go after 2 ms.
        if visits == 2 && cycle > since + 2 {
            stage.lie = Box::new(|inputs| {
                if let Some(level) = &mut inputs.switch {
                    level.value = false;
                }
            });
        }
    });
    assert!(
        matches!(
            end,
            Progress::Failed(Abort::SwitchUnsteady {
                edge_counts: 4_980..5_020
            })
        ),
        "{end:?}"
    );
}

#[test]
fn a_switch_that_is_read_no_more_ends_the_search() {
    let mut stage = Stage::with_switch(PLAIN);
    let end = stage.run(PLAIN.limit_switch(), |stage, _, cycle| {
        if cycle == 500 {
            let until_us = stage.rig.now().as_us();
            stage.lie = Box::new(move |inputs| {
                if let Some(level) = &mut inputs.switch {
                    level.at_us = level.at_us.min(until_us);
                }
            });
        }
    });
    assert!(
        matches!(
            end,
            Progress::Failed(Abort::TooOld {
                what: Awaited::Switch,
                age_us: Some(50_001..53_000),
                ..
            })
        ),
        "{end:?}"
    );
}
