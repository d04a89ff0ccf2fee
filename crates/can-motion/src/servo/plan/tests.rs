use super::*;
use crate::servo::config::{PollPeriods, test_axis as axis};
use bus_plan::{BitRate, BusSetup, Canopen, RequestMix, ResponseWindow, TxOrder, Warning};
use std::string::ToString;
use std::vec::Vec;

fn axes(count: i32, polls: PollPeriods) -> Vec<AxisConfig> {
    let axis = |drive| AxisConfig {
        polls,
        unwatched: polls.status_us.is_none(),
        ..axis(drive)
    };
    (1..=count).map(axis).collect()
}

fn around(delay_us: u32, percent: u32) -> BusSetup {
    let spread_us = delay_us * percent / 100;
    BusSetup {
        response: ResponseWindow {
            min_us: delay_us - spread_us,
            max_us: delay_us + spread_us,
        },
        ..BusSetup::DEFAULT
    }
}

fn most(bus: BusSetup, requests_per_cycle: u8, polls: PollPeriods) -> i32 {
    let config = MasterConfig {
        requests_per_cycle,
        bus,
        ..MasterConfig::DEFAULT
    };
    let fits = |count: &i32| BusPlan::new(&config, &axes(*count, polls)).check().is_ok();
    (1..=20).take_while(fits).last().unwrap_or(0)
}

/// Simulated policies reach 14 without polls, and 11 with them when every poll keeps its 20 ms; one request a cycle, which
/// lets the periods of twelve axes grow to 24 ms, leaves room for one more when the drives answer fast.
#[test]
fn what_the_wire_allows_is_admitted() {
    assert_eq!(most(BusSetup::DEFAULT, 1, PollPeriods::OFF), 14);
    assert_eq!(most(around(200, 25), 1, PollPeriods::DEFAULT), 12);
    assert_eq!(most(around(500, 25), 1, PollPeriods::DEFAULT), 11);
    assert_eq!(most(around(2_000, 25), 1, PollPeriods::DEFAULT), 10);
}

#[test]
fn whatever_may_come_on_top_costs_axes() {
    let most = |bus| most(bus, 1, PollPeriods::DEFAULT);
    let bus = around(500, 25);
    let by_identifier = BusSetup {
        order: TxOrder::Identifier,
        ..bus
    };
    assert_eq!(most(by_identifier), 10);
    let any_request = BusSetup {
        requests: RequestMix::Any,
        ..bus
    };
    assert_eq!(most(any_request), 10);
    let jitter = BusSetup {
        release_jitter_us: 100,
        ..bus
    };
    assert_eq!(most(jitter), 10);
    let errors = BusSetup {
        error_interval_us: Some(1_000),
        ..bus
    };
    assert_eq!(most(errors), 8);
    let alarms = BusSetup {
        alarm_burst: 2,
        ..bus
    };
    assert_eq!(most(alarms), 9);
    let slow = BusSetup {
        bit_rate: BitRate::Kbit500,
        ..bus
    };
    assert_eq!(most(slow), 4);
}

#[test]
fn one_axis_too_many_names_the_frame_and_what_would_help() {
    let axes = axes(13, PollPeriods::DEFAULT);
    let config = MasterConfig {
        bus: around(500, 25),
        ..MasterConfig::DEFAULT
    };
    let plan = BusPlan::new(&config, &axes);
    let refusal = plan.check().unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "set-point of drive 13 does not fit: with it a cycle carries 1061 bit times, but lasts 1000"
    );
    assert_eq!(
        plan.remedies().to_string(),
        "it would fit with no polls, or cycle_us = 1250, or the first 11 axes"
    );
}

#[test]
fn a_late_set_point_has_response_and_deadline() {
    let axes = axes(11, PollPeriods::DEFAULT);
    let config = MasterConfig {
        bus: around(2_000, 25),
        ..MasterConfig::DEFAULT
    };
    let refusal = BusPlan::new(&config, &axes).check().unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "set-point of drive 11 is late: its response time is 1046 bit times, its deadline 1000"
    );
}

#[test]
fn set_points_end_one_behind_the_other() {
    let axes = axes(3, PollPeriods::OFF);
    let plan = BusPlan::new(&MasterConfig::DEFAULT, &axes);
    let ends: Vec<_> = (0..4)
        .map(|axis| plan.set_point(axis).and_then(|response| response.bits))
        .collect();
    let bits = |drive: u16| u32::from(can_frame::wire::worst_bits(drive << 5 | 0x1C, 2));
    let (first, second) = (bits(1), bits(1) + bits(2));
    assert_eq!(
        ends,
        [Some(first), Some(second), Some(second + bits(3)), None]
    );
    let cycle = plan.cycle();
    assert_eq!(
        (cycle.requests(), cycle.replies(), cycle.alarms()),
        (None, None, None)
    );
}

#[test]
fn what_cannot_be_on_one_bus_is_refused() {
    let refusal = |bus, axes: &[AxisConfig]| {
        let config = MasterConfig {
            bus,
            ..MasterConfig::DEFAULT
        };
        BusPlan::new(&config, axes).check().unwrap_err().to_string()
    };
    let sync = BusSetup {
        canopen: Some(Canopen {
            nodes: &[],
            uses_nmt: false,
            uses_sync: true,
        }),
        ..BusSetup::DEFAULT
    };
    assert_eq!(
        refusal(sync, &[axis(4)]),
        "CANopen SYNC 0x80 is Set_Origin of drive 4: use separate buses"
    );
    let upside_down = BusSetup {
        response: ResponseWindow {
            min_us: 2,
            max_us: 1,
        },
        ..BusSetup::DEFAULT
    };
    assert_eq!(
        refusal(upside_down, &[axis(4)]),
        "the response window must not end before it begins, got 2..1 us"
    );
    assert_eq!(
        refusal(BusSetup::DEFAULT, &[axis(4), axis(4)]),
        "list the axes in ascending order of drive id, each once: drive 4 is not above the one before it"
    );
}

#[test]
fn broadcast_and_reserved_ids_cannot_even_be_named() {
    assert!(DriveId::new(0).is_err() && DriveId::new(64).is_err());
}

#[test]
fn drive_63_and_stretched_polls_are_warned_about() {
    let mut twelve = axes(11, PollPeriods::DEFAULT);
    assert_eq!(
        BusPlan::new(&MasterConfig::DEFAULT, &twelve)
            .cycle()
            .warnings(),
        [None, Some(Warning::PollsStretched { permille: 1_100 })]
    );
    twelve.truncate(2);
    twelve.push(axis(63));
    assert_eq!(
        BusPlan::new(&MasterConfig::DEFAULT, &twelve)
            .cycle()
            .warnings(),
        [Some(Warning::HighIdentifiers { drive: 63 }), None]
    );
}

#[test]
fn a_cycle_of_no_time_is_refused_and_not_divided_by() {
    let config = MasterConfig {
        cycle_us: 0,
        ..MasterConfig::DEFAULT
    };
    assert!(
        BusPlan::new(&config, &axes(1, PollPeriods::DEFAULT))
            .check()
            .is_err()
    );
}

#[test]
fn the_master_takes_no_axes_that_the_plan_refuses_and_tells_its_warnings() {
    use crate::{ConfigError, EventKind, ServoMaster};
    let config = MasterConfig {
        bus: around(500, 25),
        ..MasterConfig::DEFAULT
    };
    let refused = ServoMaster::<13>::new(config, &axes(13, PollPeriods::DEFAULT));
    let Err(ConfigError::Plan { refusal, remedies }) = refused else {
        panic!("13 polled axes do not fit");
    };
    let plan_axes = axes(13, PollPeriods::DEFAULT);
    let plan = BusPlan::new(&config, &plan_axes);
    assert_eq!((plan.check(), plan.remedies()), (Err(refusal), remedies));

    let mut master = ServoMaster::<1>::new(config, &[axis(63)]).unwrap();
    let warning = master.next_event().map(|event| event.kind);
    assert_eq!(
        warning,
        Some(EventKind::Plan(Warning::HighIdentifiers { drive: 63 }))
    );
}

/// NMT is a broadcast Set_Origin; D9: PDOs of node 1 are Go_Absolute, of node 3 Go_Relative, of node 10 Turn_ConstSpeed, of drive
/// base / 32 + n / 32.
#[test]
fn identifiers_of_canopen_that_move_motors_or_zero_positions_are_found() {
    let clash = |canopen, drives: &[i32]| {
        let axes: Vec<_> = drives.iter().map(|drive| axis(*drive)).collect();
        let bus = BusSetup {
            canopen: Some(canopen),
            ..BusSetup::DEFAULT
        };
        let config = MasterConfig {
            bus,
            ..MasterConfig::DEFAULT
        };
        match BusPlan::new(&config, &axes).check() {
            Err(Refusal::Clash(clash)) => Some((clash.canopen.id, clash.drive, clash.meaning)),
            Err(other) => panic!("{other}"),
            Ok(()) => None,
        }
    };
    let nmt = Canopen {
        uses_nmt: true,
        ..Canopen::NONE
    };
    assert_eq!(clash(nmt, &[60]), Some((0x000, None, "Set_Origin")));
    let sync = Canopen {
        uses_sync: true,
        ..Canopen::NONE
    };
    let zeroes_drive_4 = Some((0x080, Some(4), "Set_Origin"));
    assert_eq!(clash(sync, &[1, 4]), zeroes_drive_4);
    assert_eq!(clash(sync, &[1, 2, 3, 5]), None);
    let nodes: [(&[u8], _); 3] = [
        (&[1], FunctionCode::GoAbsolutePosPtp),
        (&[3], FunctionCode::GoRelativePosPtp),
        (&[10], FunctionCode::TurnConstSpeed),
    ];
    for (nodes, function) in nodes {
        let canopen = Canopen {
            nodes,
            ..Canopen::NONE
        };
        let id = 0x180 + u16::from(nodes[0]);
        let moves_drive_12 = Some((id, Some(12), function.name()));
        assert_eq!(clash(canopen, &[12]), moves_drive_12);
        assert_eq!(clash(canopen, &[1, 2, 3, 5]), None);
    }
}

/// 64 axes cannot have 64 drives: whatever comes behind them, the drive that is there twice is found.
#[test]
fn more_axes_than_drive_ids_are_refused_for_their_order() {
    let mut many = axes(63, PollPeriods::OFF);
    many.extend(axes(3, PollPeriods::OFF));
    let refusal = BusPlan::new(&MasterConfig::DEFAULT, &many).check();
    assert_eq!(refusal, Err(Refusal::Order { drive: 1 }));
}
