use super::*;
use crate::wire::{bound_bits, worst_bits};
use crate::{BitRate, BusSetup, Canopen, CanopenService, Clash, Identifier, RequestMix};
use crate::{Requests, ResponseWindow};
use std::string::ToString;
use std::vec::Vec;

const SETUP: CycleSetup = CycleSetup {
    bus: BusSetup::DEFAULT,
    cycle_us: 1_000,
    requests_per_cycle: 1,
    reply_us: 10_000,
    any_request: Requests::any(bound_bits(0), bound_bits(5), bound_bits(6)),
    bit_rates: &BitRate::ALL,
    clash: None,
};

fn drive(number: u8) -> Drive {
    let id = u16::from(number) << 5;
    Drive {
        set_point_bits: worst_bits(id + 28, 2),
        ..Drive::silent(number, id + 31)
    }
}

fn polled(number: u8) -> Drive {
    Drive {
        polls: Requests::NONE.and(20_000, 1_000, 57, 92),
        ..drive(number)
    }
}

fn drives(count: u8, drive: impl FnMut(u8) -> Drive) -> Vec<Drive> {
    (1..=count).map(drive).collect()
}

fn refusal(setup: &CycleSetup, drives: &[Drive]) -> Refusal {
    CyclePlan::new(setup, drives).check().unwrap_err()
}

#[test]
fn set_points_end_one_behind_the_other() {
    let all = drives(3, drive);
    let plan = CyclePlan::new(&SETUP, &all);
    assert_eq!(plan.check(), Ok(()));
    let bits = u64::from(all[0].set_point_bits) + u64::from(all[1].set_point_bits);
    assert_eq!(plan.set_points(bits).bits, Some(bits as u32));
    assert_eq!(
        (plan.requests(), plan.replies(), plan.alarms()),
        (None, None, None)
    );
}

#[test]
fn one_drive_too_many_names_the_frame_and_what_would_help() {
    let all = drives(15, drive);
    assert!(CyclePlan::new(&SETUP, &all[..14]).check().is_ok());
    let plan = CyclePlan::new(&SETUP, &all);
    assert_eq!(
        plan.check().unwrap_err().to_string(),
        "set-point of drive 15 does not fit: with it a cycle carries 1052 bit times, but lasts 1000"
    );
    assert_eq!(
        plan.remedies().to_string(),
        "it would fit with cycle_us = 1250, or the first 14 axes"
    );
}

#[test]
fn only_bit_rates_that_the_drives_know_are_advised() {
    let mut setup = SETUP;
    setup.bus.bit_rate = BitRate::Kbit125;
    let all = drives(3, drive);
    let advised = |setup: &CycleSetup| CyclePlan::new(setup, &all).remedies().bit_rate;
    assert_eq!(advised(&setup), Some(BitRate::Kbit250));
    setup.bit_rates = &[BitRate::Kbit125, BitRate::Kbit1000];
    assert_eq!(advised(&setup), Some(BitRate::Kbit1000));
}

#[test]
fn drives_of_several_groups_may_be_asked_anything() {
    let mut all = drives(2, drive);
    assert_eq!(CyclePlan::new(&SETUP, &all).requests_per_cycle(), 0);
    all[1].group = 1;
    let plan = CyclePlan::new(&SETUP, &all);
    assert_eq!(plan.requests_per_cycle(), 1);
    let mut any = SETUP;
    any.bus.requests = RequestMix::Any;
    all[1].group = 0;
    assert_eq!(
        CyclePlan::new(&any, &all).load_bits(),
        plan.load_bits(),
        "the same requests"
    );
}

#[test]
fn what_no_rate_helps_against_is_refused_first() {
    let pair = [drive(4), drive(4)];
    assert_eq!(refusal(&SETUP, &pair), Refusal::Order { drive: 4 });
    let window = ResponseWindow {
        min_us: 2,
        max_us: 1,
    };
    let mut setup = SETUP;
    setup.bus.response = window;
    assert_eq!(
        refusal(&setup, &pair[..1]),
        Refusal::ResponseWindow { window }
    );
    let mut setup = SETUP;
    setup.bus.canopen = Some(Canopen {
        nodes: &[0],
        ..Canopen::NONE
    });
    assert_eq!(
        refusal(&setup, &pair[..1]),
        Refusal::CanopenNode { actual: 0 }
    );
    let mut setup = SETUP;
    setup.clash = Some(Clash {
        canopen: Identifier {
            id: 0x181,
            service: CanopenService::Pdo,
            node: 1,
        },
        drive: Some(12),
        meaning: "Go_Absolute",
    });
    // A clash comes before a load that does not fit.
    assert_eq!(
        refusal(&setup, &drives(15, drive)).to_string(),
        "CANopen PDO 0x181 is Go_Absolute of drive 12: use separate buses"
    );
}

#[test]
fn polls_that_come_too_seldom_and_high_identifiers_are_warned_about() {
    let twice = |number| {
        let mut drive = polled(number);
        drive.polls = drive.polls.and(20_000, 1_000, 57, 92);
        drive
    };
    let plan = CyclePlan::new(&SETUP, &drives(11, twice));
    assert_eq!(
        plan.warnings(),
        [None, Some(Warning::PollsStretched { permille: 1_100 })]
    );
    let plan = CyclePlan::new(&SETUP, &[drive(62), drive(63)]);
    assert_eq!(
        plan.warnings(),
        [Some(Warning::HighIdentifiers { drive: 63 }), None]
    );
}

#[test]
fn a_cycle_of_no_time_is_refused_and_not_divided_by() {
    let setup = CycleSetup {
        cycle_us: 0,
        ..SETUP
    };
    assert!(CyclePlan::new(&setup, &[polled(1)]).check().is_err());
}

#[test]
fn each_drive_is_asked_once_in_a_cycle_and_answers_behind_its_request() {
    let mut setup = SETUP;
    setup.requests_per_cycle = 4;
    setup.bus.response = ResponseWindow {
        min_us: 100,
        max_us: 400,
    };
    let two_polled = [polled(1), drive(2), polled(3)];
    let plan = CyclePlan::new(&setup, &two_polled);
    assert_eq!(plan.requests_per_cycle(), 2);
    let one = CyclePlan::new(&setup, &[polled(1)]);
    // The earliest reply comes 100 behind the request without its interframe space, the latest 400 behind the end of all.
    let end = one.requests().and_then(|response| response.bits);
    let earliest = 57 - 3 + 100;
    assert_eq!(
        Some(one.reply_jitter_bits()),
        end.map(|end| end + 400 - earliest)
    );
}
