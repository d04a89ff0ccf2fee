//! Power: enabling, what confirms it, disabling until it is confirmed, and drives found on.

use can_motion::facts::{Brake, Class, Knowledge, Loss, Power, Work};
use can_motion::family::{CommonFault, Meaning, PowerReport};
use can_motion::{AxisState, CommonEvent, Confirmation, Instant, Reason, Stage};

use crate::drive::Call;
use crate::family::{Axis, Fault, Frame, Kind, ask, axis};
use crate::rig::{FINE, G, Rig, faulted, went};

#[test]
fn every_step_from_the_first_answer_to_streaming_is_told() {
    let mut rig = Rig::new(&[axis(1)]);
    assert_eq!(rig.state(0), AxisState::PowerOn);
    rig.says(1, Meaning::stage(Stage::Identifying));
    rig.says(1, Meaning::stage(Stage::Identifying));
    rig.says(
        1,
        Meaning {
            is_checked: true,
            ..Meaning::NONE
        },
    );
    rig.says(1, rig.power(false));
    let read = Reason::Reading;
    let steps = [
        went(0, AxisState::PowerOn, AxisState::Identifying, read),
        went(0, AxisState::Identifying, AxisState::CheckingStatus, read),
        went(0, AxisState::CheckingStatus, AxisState::Ready, read),
    ];
    assert_eq!(rig.events(), steps);
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.says(
        1,
        Meaning {
            is_checked: true,
            ..Meaning::NONE
        },
    );
    // Only what is awaited counts: a position before the shaft stands anchors nothing.
    rig.says(
        1,
        Meaning {
            is_located: true,
            ..Meaning::NONE
        },
    );
    rig.says(
        1,
        Meaning {
            stands: Some(true),
            ..Meaning::NONE
        },
    );
    rig.says(1, Meaning::NONE);
    assert_eq!(rig.state(0), AxisState::Anchoring);
    rig.says(
        1,
        Meaning {
            stands: Some(false),
            ..Meaning::NONE
        },
    );
    rig.says(1, FINE);
    rig.cycle();
    rig.cycle();
    rig.says(1, rig.power(true));
    let steps = [
        went(0, AxisState::Ready, AxisState::Probing, Reason::Command),
        went(0, AxisState::Probing, AxisState::AwaitingStandstill, read),
        went(0, AxisState::AwaitingStandstill, AxisState::Anchoring, read),
        went(0, AxisState::Anchoring, AxisState::AwaitingStandstill, read),
        went(0, AxisState::AwaitingStandstill, AxisState::Anchoring, read),
        went(0, AxisState::Anchoring, AxisState::Enabling, read),
        went(0, AxisState::Enabling, AxisState::Holding, read),
        went(0, AxisState::Holding, AxisState::Streaming, Reason::Group),
    ];
    assert_eq!(rig.events(), steps);
    let told = rig.seen(0).calls;
    assert!(told.contains(&Call::StartOver { is_cleared: false }));
    assert!(told.contains(&Call::BeginMotion));
}

#[test]
fn time_counts_from_the_latest_progress() {
    let mut rig = Rig::new(&[axis(1)]);
    let since = |rig: &mut Rig, change: Meaning<Fault>| {
        rig.cycle();
        rig.says(1, change);
        rig.cycle();
        rig.says(1, Meaning::NONE);
        match rig.seen(0).calls.last() {
            Some(Call::Heard(_, since)) => rig.now.us_since(*since),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(since(&mut rig, Meaning::stage(Stage::Locating)), 1_000);
    assert_eq!(since(&mut rig, Meaning::stage(Stage::Locating)), 3_000);
    assert_eq!(
        since(
            &mut rig,
            Meaning {
                is_checked: true,
                ..Meaning::NONE
            }
        ),
        1_000
    );
    // A stage of a drive that is checked already does not count.
    assert_eq!(since(&mut rig, Meaning::stage(Stage::Probing)), 3_000);
    let off = rig.power(false);
    assert_eq!(since(&mut rig, off), 1_000);
    assert_eq!(since(&mut rig, off), 3_000);
    // Nor does a procedure beside the cycle.
    let given = Confirmation::Given;
    let started = rig.master.start(rig.now, 0, Work::Read, given);
    started.expect("a ready drive");
    assert_eq!(since(&mut rig, Meaning::NONE), 5_000);
    rig.master.enable(rig.now, G).expect("a ready drive");
    // A setback does not count.
    let stands = |stands| Meaning {
        is_checked: true,
        stands: Some(stands),
        ..Meaning::NONE
    };
    assert_eq!(since(&mut rig, stands(true)), 1_000);
    assert_eq!(since(&mut rig, stands(false)), 3_000);
    // The switch is sent in the second cycle.
    assert_eq!(since(&mut rig, FINE), 0);
    rig.cycle();
    rig.says(1, rig.power(true));
    rig.cycle();
    rig.says(1, Meaning::NONE);
    assert!(
        matches!(rig.seen(0).calls.last(), Some(Call::Heard(_, at)) if rig.now.us_since(*at) == 1_000)
    );
    // The goal alone counts too.
    rig.cycle();
    rig.master.halt(rig.now, G);
    assert_eq!(since(&mut rig, Meaning::NONE), 2_000);
}

#[test]
fn only_a_report_asked_for_a_cycle_after_the_switch_confirms_it() {
    let mut rig = Rig::ready(&[axis(1)]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.says(1, FINE);
    assert_eq!(rig.cycle(), [Frame::Switch(1, true)]);
    let switched_at = rig.now;
    let on = |asked_at| Meaning {
        power: Some(PowerReport {
            is_on: true,
            asked_at,
        }),
        ..Meaning::NONE
    };
    rig.cycle();
    rig.says(1, on(switched_at + 999));
    assert_eq!(rig.state(0), AxisState::Enabling);
    rig.says(1, on(switched_at + 1_000));
    assert_eq!(rig.state(0), AxisState::Streaming);
    // With no switch under way any report counts.
    rig.says(
        1,
        Meaning {
            power: Some(PowerReport {
                is_on: false,
                asked_at: Instant::from_us(5),
            }),
            ..Meaning::NONE
        },
    );
    assert_eq!(rig.fault(0), Some(CommonFault::SwitchedOff.into()));
}

#[test]
fn a_disable_command_is_repeated_until_it_is_confirmed() {
    let mut rig = Rig::holding(&[axis(1)]);
    rig.master.disable(rig.now, G);
    let mut sent = Vec::new();
    for cycle in 0..=900 {
        if rig.cycle() == [Frame::Switch(1, false)] {
            sent.push(cycle);
        }
        // A drive needs a moment.
        rig.says(1, rig.power(true));
    }
    assert_eq!(sent, [0, 200, 400, 600, 800]);
    let unconfirmed = |repeated| {
        let event = CommonEvent::DisableUnconfirmed { repeated };
        (Some(0), Kind::Common(event))
    };
    let disabling = went(0, AxisState::Holding, AxisState::Disabling, Reason::Command);
    assert_eq!(
        rig.events(),
        [disabling, unconfirmed(1), unconfirmed(2), unconfirmed(4)]
    );
    rig.says(1, rig.power(false));
    assert_eq!(rig.state(0), AxisState::Ready);
    // The next one counts from the start.
    rig.says(1, rig.power(true));
    rig.master.disable(rig.now, G);
    rig.events();
    for _ in 0..=200 {
        rig.cycle();
    }
    assert_eq!(rig.events(), [unconfirmed(1)]);
}

#[test]
fn a_report_that_a_drive_is_off_counts_beside_an_alarm_too() {
    let mut rig = Rig::holding(&[axis(1)]);
    rig.master.disable(rig.now, G);
    assert_eq!(rig.cycle(), [Frame::Switch(1, false)]);
    rig.cycle();
    rig.cycle();
    let alarm = |power| Meaning {
        power,
        ..Meaning::fault(Fault::Of(Loss::Drive))
    };
    let off = rig.power(false).power;
    rig.says(1, alarm(off));
    assert_eq!(rig.power_of(0), Power::Off);
    assert_eq!(rig.cycle(), []);
    // As long as the alarm lasts it comes back after each `clear`, and nothing is sent again.
    assert_eq!(rig.master.clear(rig.now, G), Ok(()));
    rig.says(1, alarm(off));
    assert_eq!((rig.power_of(0), rig.cycle()), (Power::Off, vec![]));
}

#[test]
fn an_alarm_does_not_make_an_early_report_count() {
    let mut rig = Rig::holding(&[axis(1)]);
    rig.master.disable(rig.now, G);
    assert_eq!(rig.cycle(), [Frame::Switch(1, false)]);
    let early = PowerReport {
        is_on: false,
        asked_at: rig.now + 999,
    };
    rig.says(
        1,
        Meaning {
            power: Some(early),
            ..Meaning::fault(Fault::Of(Loss::Drive))
        },
    );
    assert_eq!(rig.power_of(0), Power::OffWanted);
    assert_eq!(rig.send(), [Frame::Switch(1, false)]);
}

#[test]
fn a_switch_on_that_is_not_confirmed_is_a_fault() {
    let mut rig = Rig::ready(&[axis(1)]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.says(1, FINE);
    for _ in 0..200 {
        rig.cycle();
        assert_eq!(rig.fault(0), None);
    }
    rig.cycle();
    assert_eq!(rig.fault(0), Some(CommonFault::NotConfirmed.into()));
    assert_eq!(rig.send(), []);
    assert_eq!(rig.cycle(), []);
}

#[test]
fn a_shaft_that_does_not_stand_still_is_a_fault_after_five_seconds() {
    for (meaning, state) in [
        (
            Meaning {
                is_checked: true,
                ..Meaning::NONE
            },
            AxisState::AwaitingStandstill,
        ),
        (
            Meaning {
                is_checked: true,
                stands: Some(true),
                ..Meaning::NONE
            },
            AxisState::Anchoring,
        ),
    ] {
        let mut rig = Rig::ready(&[axis(1)]);
        for _ in 0..6_000 {
            rig.cycle();
        }
        assert_eq!(rig.state(0), AxisState::Ready);
        rig.master.enable(rig.now, G).expect("a ready drive");
        rig.says(1, meaning);
        for _ in 0..4_999 {
            rig.cycle();
            assert_eq!(rig.state(0), state);
        }
        rig.cycle();
        assert_eq!(rig.fault(0), Some(CommonFault::NotConfirmed.into()));
    }
}

#[test]
fn a_drive_found_on_is_left_alone_until_it_is_adopted() {
    let mut rig = Rig::ready(&[axis(1), axis(2)]);
    rig.says(2, rig.power(true));
    let found = (Some(1), Kind::Common(CommonEvent::FoundOn));
    let state = went(1, AxisState::Ready, AxisState::FoundOn, Reason::Reading);
    assert_eq!(rig.events(), [found, state]);
    assert_eq!(rig.cycle(), []);
    rig.master
        .adopt(rig.now, G)
        .expect("a drive that was found on");
    rig.says(2, FINE);
    assert_eq!(rig.states(), [AxisState::Ready, AxisState::Holding]);
    assert_eq!(rig.cycle(), []);
    assert!(!rig.seen(1).calls.contains(&Call::BeginMotion));
}

#[test]
fn power_that_comes_or_goes_by_itself_is_a_fault() {
    let mut rig = Rig::holding(&[axis(1)]);
    rig.says(1, rig.power(false));
    let fault = CommonFault::SwitchedOff;
    assert_eq!(
        rig.events(),
        [
            faulted(0, fault),
            went(0, AxisState::Holding, AxisState::Faulted, Reason::Reading)
        ]
    );
    let mut rig = Rig::ready(&[axis(1)]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.events();
    rig.says(1, rig.power(true));
    assert_eq!(rig.events()[0], faulted(0, CommonFault::SwitchedOn));
    assert_eq!(rig.fault(0), Some(CommonFault::SwitchedOn.into()));
}

#[test]
fn a_shaft_that_is_shaken_keeps_its_anchor_only_by_its_power() {
    let turns = Meaning {
        stands: Some(false),
        ..Meaning::NONE
    };
    let mut rig = Rig::holding(&[axis(1)]);
    rig.says(1, turns);
    assert_eq!(rig.state(0), AxisState::Holding);
    let mut rig = Rig::ready(&[axis(1)]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.says(1, FINE);
    rig.says(1, turns);
    assert_eq!(
        (rig.state(0), rig.cycle()),
        (AxisState::AwaitingStandstill, vec![])
    );
}

#[test]
fn a_position_outside_the_travel_anchors_nothing() {
    let mut rig = Rig::ready(&[axis(1)]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    can_motion::BusUser::on_frame(&mut rig.master, rig.now, &Frame::IsAt(1, 1_001));
    rig.says(1, FINE);
    assert_eq!(
        (rig.fault(0), rig.cycle()),
        (Some(Fault::OutsideTravel), vec![])
    );
}

#[test]
fn a_brake_is_opened_before_motion_and_closed_before_power_goes() {
    let mut rig = Rig::ready(&[Axis {
        brake: Brake::Unclear,
        ..axis(1)
    }]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.says(1, FINE);
    rig.cycle();
    rig.cycle();
    rig.says(1, rig.power(true));
    assert_eq!(rig.state(0), AxisState::Holding);
    rig.wants(1, ask(1, Class::BrakeOpen, 1));
    assert_eq!(rig.cycle(), [Frame::Ask(1, 1)]);
    rig.brake(1, Brake::Open);
    assert_eq!(rig.state(0), AxisState::Streaming);
    rig.cycle();
    rig.master.disable(rig.now, G);
    rig.wants(1, ask(2, Class::BrakeClose, 1));
    assert_eq!(
        (rig.cycle(), rig.power_of(0)),
        (vec![Frame::Ask(1, 2)], Power::OffWanted)
    );
    assert_eq!(rig.cycle(), []);
    rig.brake(1, Brake::Closed);
    assert_eq!(rig.send(), [Frame::Switch(1, false)]);
}

#[test]
fn a_restart_takes_everything_that_was_known() {
    let mut rig = Rig::holding(&[axis(1)]);
    let before = rig.times_told(0);
    rig.says(
        1,
        Meaning {
            restarts: true,
            ..Meaning::NONE
        },
    );
    let facts = rig.seen(0).facts;
    assert_eq!(
        (facts.knowledge, facts.power),
        (Knowledge::Unknown, Power::OnUnconfirmed)
    );
    assert_eq!(
        rig.told_since(0, before)[1..],
        [Call::StartOver { is_cleared: false }]
    );
    // Once is enough.
    rig.says(
        1,
        Meaning {
            restarts: true,
            ..Meaning::NONE
        },
    );
    assert_eq!(rig.told_since(0, before + 2).len(), 1);
    assert_eq!(rig.cycle(), []);
    rig.fails(1, Fault::Of(Loss::Nothing));
    rig.says(
        1,
        Meaning {
            is_checked: true,
            ..Meaning::NONE
        },
    );
    // A drive with a fault is not checked before it is cleared, nor is one whose fault comes with the reading.
    assert_eq!(rig.seen(0).facts.knowledge, Knowledge::Unknown);
    let mut rig = Rig::new(&[axis(1)]);
    rig.says(
        1,
        Meaning {
            is_checked: true,
            ..Meaning::fault(Fault::Of(Loss::Nothing))
        },
    );
    assert_eq!(rig.seen(0).facts.knowledge, Knowledge::Unknown);
}
