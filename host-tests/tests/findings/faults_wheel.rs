//! Each fault of a wheel: its cause alone, in both signs where there is a sign, the exact fault, and the exact frames afterwards.

use can_motion::wheel::WheelFault;
use drive_sim::ReplyDamage;
use zlac8030l::{FaultCode, NmtState};

use crate::support::enums::{name_of, variants};
use crate::support::wheels::{DISABLE_VOLTAGE, Hub, QUICK_STOP, Wheels, hub, hubs, wheel_line};
use crate::support::{Call, assert_none};

/// What both wheels are told while the causes come, in r/min.
const SPEEDS: [i32; 2] = [100, -50];

struct Row {
    what: String,
    machine: Box<dyn Fn() -> Wheels>,
    cause: Box<dyn Fn(&mut Wheels)>,
    /// Cycles in which the fault must come.
    within: usize,
    fault: Expected,
    partner: Option<WheelFault>,
    /// The control words of the hundred cycles behind the fault, repeated ones once.
    words: [&'static [u16]; 2],
}

enum Expected {
    Exactly(WheelFault),
    Like(&'static str, fn(&WheelFault) -> bool),
    /// Nothing is wrong.
    None,
}

const STOP: &[u16] = &[QUICK_STOP];
const OFF: &[u16] = &[DISABLE_VOLTAGE];
const RUN: &[u16] = &[0x000F];
/// The wheel takes no frame of a cycle, so none goes to it.
const SILENT: &[u16] = &[];

fn row(
    what: &str,
    machine: impl Fn() -> Wheels + 'static,
    cause: impl Fn(&mut Wheels) + 'static,
    within: usize,
    fault: Expected,
    words: [&'static [u16]; 2],
) -> Row {
    Row {
        what: what.into(),
        machine: Box::new(machine),
        cause: Box::new(cause),
        within,
        fault,
        partner: Some(WheelFault::Group),
        words,
    }
}

fn moving_with(hubs: &[Hub]) -> Wheels {
    let mut machine = Wheels::streaming(hubs);
    machine.drive_at(&SPEEDS, 60);
    machine
}

fn moving() -> Wheels {
    moving_with(&hubs(2))
}

fn fresh() -> Wheels {
    Wheels::new(&hubs(2))
}

fn comes_in(base: u16, data: &'static [u8]) -> impl Fn(&mut Wheels) + 'static {
    move |machine| {
        let id = base + machine.node(0);
        machine.0.cycle_with(|rig| Wheels::comes_in(rig, id, data));
    }
}

/// A status with status word, fault bits and a speed of 100 r/min.
fn status(word: u16, fault: u16) -> impl Fn(&mut Wheels) + 'static {
    move |machine| {
        let mut data = [0; 8];
        data[..2].copy_from_slice(&word.to_le_bytes());
        data[2..4].copy_from_slice(&fault.to_le_bytes());
        data[4..].copy_from_slice(&1_000_i32.to_le_bytes());
        let id = 0x180 + machine.node(0);
        machine.0.cycle_with(|rig| Wheels::comes_in(rig, id, &data));
    }
}

/// Enabled, not stopped, running.
const RUNNING: u16 = 0x4027;

fn of_the_drive() -> Vec<Row> {
    let mut rows: Vec<Row> = [0x0001_u16, 0x0004, 0x0008, 0x0200, 0x8000]
        .into_iter()
        .map(|bits| {
            row(
                &format!("fault bits {bits:04X} in the status"),
                moving,
                status(RUNNING, bits),
                2,
                Expected::Exactly(WheelFault::Drive(FaultCode::new(bits))),
                [STOP, STOP],
            )
        })
        .collect();
    rows.push(row(
        "a status without anything wrong",
        moving,
        status(RUNNING, 0),
        20,
        Expected::None,
        [RUN, RUN],
    ));
    rows.push(row(
        "an emergency message",
        moving,
        comes_in(0x080, &[0x00, 0x10, 0x01, 4, 0, 0, 0, 0]),
        2,
        Expected::Like("Emergency 1000h", |fault| {
            matches!(fault, WheelFault::Emergency(emergency) if emergency.error_code == 0x1000)
        }),
        [STOP, STOP],
    ));
    rows.push(row(
        "an emergency message that an error is gone",
        moving,
        comes_in(0x080, &[0; 8]),
        20,
        Expected::None,
        [RUN, RUN],
    ));
    rows.push(row(
        "an emergency stop input",
        moving,
        status(RUNNING | 1 << 15, 0),
        2,
        Expected::Exactly(WheelFault::EmergencyInput),
        [STOP, STOP],
    ));
    // What reports no power is left without it; a state that no document describes may still have power.
    for (word, words) in [
        (0x4020_u16, OFF),
        (0x4021, OFF),
        (0x4023, OFF),
        (0x4024, STOP),
        (0x4028, OFF),
    ] {
        rows.push(row(
            &format!("a status word {word:04X}: not enabled any more"),
            moving,
            status(word, 0),
            2,
            Expected::Exactly(WheelFault::NotEnabled),
            [words, STOP],
        ));
    }
    rows.push(row(
        "a status word of a drive that is on, of one that nobody enabled",
        || {
            let mut machine = fresh();
            machine.become_ready();
            machine.call(Call::Enable).unwrap();
            machine
        },
        status(RUNNING, 0),
        2,
        Expected::Exactly(WheelFault::SwitchedOn),
        [OFF, OFF],
    ));
    rows.push(row(
        "a quick stop that nobody asked for",
        moving,
        status(RUNNING & !(1 << 5), 0),
        2,
        Expected::Exactly(WheelFault::NotEnabled),
        [STOP, STOP],
    ));
    rows
}

fn network() -> Vec<Row> {
    let mut rows: Vec<Row> = [
        (&[0x7F_u8] as &[u8], NmtState::PreOperational, STOP),
        // It is told to be pre-operational and then to stop by a transfer: `wheel_life`.
        (&[0x04], NmtState::Stopped, SILENT),
    ]
    .into_iter()
    .map(|(data, state, words)| {
        row(
            &format!("a heartbeat that says {state:?}"),
            moving,
            comes_in(0x700, data),
            2,
            Expected::Exactly(WheelFault::NotOperational(state)),
            [words, STOP],
        )
    })
    .collect();
    rows.push(row(
        "a boot-up",
        moving,
        comes_in(0x700, &[0x00]),
        2,
        Expected::Exactly(WheelFault::Reboot),
        [SILENT, STOP],
    ));
    for (what, base) in [("heartbeat", 0x700), ("status", 0x180), ("position", 0x280)] {
        rows.push(row(
            &format!("no {what} any more"),
            moving,
            move |machine| machine.lose_frames_of(0, base, 10_000),
            60,
            Expected::Exactly(WheelFault::Lost),
            [STOP, STOP],
        ));
        rows.push(row(
            &format!("one {what} that was lost"),
            moving,
            move |machine| machine.lose_frames_of(0, base, 1),
            60,
            Expected::None,
            [RUN, RUN],
        ));
    }
    rows.push(row(
        "a drive that left the bus",
        moving,
        |machine| machine.faults_mut(0).leave_bus(),
        60,
        Expected::Exactly(WheelFault::Lost),
        [STOP, STOP],
    ));
    rows.push(Row {
        partner: Some(WheelFault::Bus),
        ..row(
            "the bus is off",
            moving,
            Wheels::bus_off,
            2,
            Expected::Exactly(WheelFault::Bus),
            [SILENT, SILENT],
        )
    });
    rows
}

fn following() -> Vec<Row> {
    let mut rows = vec![row(
        "a wheel in torque mode that has lost its load",
        || Wheels::streaming(&[hub(1).torque(), hub(2).torque()]),
        |machine| machine.drive_at(&[2_000, 0], 34),
        10,
        Expected::Like("OverSpeed, 100 r/min", |fault| {
            matches!(
                fault,
                WheelFault::OverSpeed {
                    most_decirpm: 1_000,
                    actual_decirpm: 1_001..=1_400
                }
            )
        }),
        [STOP, STOP],
    )];
    for sign in [1, -1] {
        rows.push(row(
            &format!("a wheel that does not get to {} r/min", 100 * sign),
            || {
                let weak = hub(1).drive(|drive| drive.motor_acceleration_rpm_s = 1.0);
                Wheels::streaming(&[weak, hub(2)])
            },
            move |machine| machine.drive_at(&[100 * sign, 0], 90),
            2,
            if sign > 0 {
                Expected::Like("FollowingSpeed, 100 r/min", |fault| {
                    matches!(
                        fault,
                        WheelFault::FollowingSpeed {
                            sent_decirpm: 1_000,
                            actual_decirpm: 0..=20
                        }
                    )
                })
            } else {
                Expected::Like("FollowingSpeed, -100 r/min", |fault| {
                    matches!(
                        fault,
                        WheelFault::FollowingSpeed {
                            sent_decirpm: -1_000,
                            actual_decirpm: -20..=0
                        }
                    )
                })
            },
            [STOP, STOP],
        ));
        rows.push(row(
            &format!("a wheel in position mode that is too slow, direction {sign}"),
            || {
                let wheels = [1, 2].map(|node| {
                    hub(node).position(60).limits(|limits| {
                        limits.values.max_step = 400;
                        limits.following_error = 2_048;
                    })
                });
                Wheels::streaming(&wheels)
            },
            move |machine| machine.drive_at(&[100_000 * sign, 0], 15),
            2,
            if sign > 0 {
                Expected::Like("FollowingError, behind", |fault| {
                    matches!(
                        fault,
                        WheelFault::FollowingError {
                            counts: -3_000..=-2_049
                        }
                    )
                })
            } else {
                Expected::Like("FollowingError, behind", |fault| {
                    matches!(
                        fault,
                        WheelFault::FollowingError {
                            counts: 2_049..=3_000
                        }
                    )
                })
            },
            [STOP, STOP],
        ));
        let mut outside = row(
            &format!("a position outside the range of targets, direction {sign}"),
            move || {
                let far = hub(1).position(60).limits(move |limits| {
                    (limits.values.min, limits.values.max) = match sign {
                        1 => (-1_000, -100),
                        _ => (100, 1_000),
                    };
                });
                Wheels::new(&[far, hub(2).position(60)])
            },
            |_| {},
            400,
            Expected::Exactly(WheelFault::PositionRange { actual: 0 }),
            [OFF, OFF],
        );
        outside.partner = None;
        rows.push(outside);
    }
    rows
}

fn set_up() -> Vec<Row> {
    let alone = |row: Row| Row {
        partner: None,
        ..row
    };
    let mut rows = vec![
        alone(row(
            "another speed resolution",
            || Wheels::new(&[hub(1).resolution(10), hub(2)]),
            |_| {},
            400,
            Expected::Exactly(WheelFault::SpeedResolution {
                expected: 10,
                actual: 1,
            }),
            [SILENT, OFF],
        )),
        alone(row(
            "another firmware",
            || Wheels::new(&[hub(1).firmware(zlac8030l::Firmware::Version(0x99)), hub(2)]),
            |_| {},
            400,
            Expected::Like("SetUp, another firmware", |fault| {
                matches!(
                    fault,
                    WheelFault::SetUp(zlac8030l::SetUpError::Identity { expected: 0x99, .. })
                )
            }),
            [SILENT, OFF],
        )),
        alone(row(
            "no reply to any transfer",
            fresh,
            |machine| {
                for _ in 0..50 {
                    machine.faults_mut(0).damage_next_reply(ReplyDamage::Drop);
                }
            },
            800,
            Expected::Exactly(WheelFault::Lost),
            [SILENT, OFF],
        )),
    ];
    // The reply to each transfer of the set-up, one after the other, is an abort: none may count as done.
    for number in [0, 1, 2] {
        rows.push(alone(row(
            &format!("an abort of transfer {number} of a start"),
            fresh,
            move |machine| machine.abort_transfer(0, number),
            400,
            Expected::Like("Transfer", |fault| matches!(fault, WheelFault::Transfer(_))),
            [SILENT, OFF],
        )));
    }
    for number in 3..40 {
        rows.push(alone(row(
            &format!("an abort of transfer {number} of a start"),
            fresh,
            move |machine| machine.abort_transfer(0, number),
            400,
            Expected::Like("SetUp", |fault| matches!(fault, WheelFault::SetUp(_))),
            [SILENT, OFF],
        )));
    }
    rows
}

fn confirmations() -> Vec<Row> {
    let ready = || {
        let mut machine = fresh();
        machine.become_ready();
        machine
    };
    vec![
        row(
            "a drive that does not take its commands while it is enabled",
            ready,
            |machine| {
                machine.lose_commands_to(0, 10_000);
                machine.call(Call::Enable).unwrap();
            },
            200,
            Expected::Exactly(WheelFault::ConfirmTimeout),
            // It is not on yet, so it goes off.
            [OFF, STOP],
        ),
        row(
            "a wheel that does not stand",
            move || {
                let line =
                    wheel_line().timeouts(|timeouts| timeouts.standstill_limit_us = 1_000_000);
                let mut machine = Wheels::on(line, &hubs(2));
                machine.become_ready();
                machine
            },
            |machine| {
                machine.call(Call::Enable).unwrap();
                for turn in 0..400 {
                    if machine.fault(0).is_some() {
                        return;
                    }
                    let speed: i32 = if turn % 2 == 0 { 11 } else { -11 };
                    let mut data = [0x20, 0, 0, 0, 0, 0, 0, 0];
                    data[4..].copy_from_slice(&speed.to_le_bytes());
                    machine
                        .0
                        .cycle_with(|rig| Wheels::comes_in(rig, 0x181, &data));
                }
            },
            2,
            Expected::Exactly(WheelFault::ConfirmTimeout),
            [OFF, STOP],
        ),
    ]
}

fn rows() -> Vec<Row> {
    let mut rows = of_the_drive();
    rows.extend(network());
    rows.extend(following());
    rows.extend(set_up());
    rows.extend(confirmations());
    rows
}

/// What is wrong with a row, and the names of the faults that were seen.
fn try_row(row: &Row) -> (Vec<String>, Vec<String>) {
    let mut machine = (row.machine)();
    let mut found = Vec::new();
    if let Some(fault) = machine.fault(0) {
        found.push(format!(
            "{}: the fault {fault:?} before its cause",
            row.what
        ));
    }
    (row.cause)(&mut machine);
    for _ in 0..row.within {
        if machine.fault(0).is_some() {
            break;
        }
        machine.drive_at(&SPEEDS, 1);
    }
    let faults = [machine.fault(0), machine.fault(1)];
    let (wanted, is_right) = match (&row.fault, faults[0]) {
        (Expected::None, fault) => ("no fault".into(), fault.is_none()),
        (Expected::Exactly(wanted), fault) => (format!("{wanted:?}"), fault == Some(*wanted)),
        (Expected::Like(text, is_like), fault) => {
            ((*text).into(), fault.is_some_and(|fault| is_like(&fault)))
        }
    };
    if !is_right {
        found.push(format!(
            "{}: {:?} in place of {wanted}",
            row.what, faults[0]
        ));
    }
    let partner = row.partner.filter(|_| !matches!(row.fault, Expected::None));
    if faults[1] != partner {
        found.push(format!(
            "{}: the partner has {:?}, not {partner:?}",
            row.what, faults[1]
        ));
    }
    // The second wheel of a start may need a little longer to be set up.
    let settle = if row.partner.is_some() { 1 } else { 200 };
    machine.drive_at(&SPEEDS, settle);
    let mark = machine.mark();
    machine.drive_at(&SPEEDS, 100);
    for axis in 0..2 {
        let words = machine.words_since(mark, axis);
        if words != row.words[axis] {
            found.push(format!(
                "{}: wheel {axis} is told {words:04X?} afterwards, wanted {:04X?}",
                row.what, row.words[axis]
            ));
        }
    }
    (found, faults.iter().flatten().map(name_of).collect())
}

/// Findings 12 and 19.
#[test]
fn each_fault_has_its_cause_and_stops_what_it_must() {
    let found: Vec<String> = rows().iter().flat_map(|row| try_row(row).0).collect();
    assert_none(&found);
}

/// A fault that is added to the enum needs a row.
#[test]
fn each_fault_of_the_enum_has_a_row() {
    let mut seen: Vec<String> = Vec::new();
    for row in rows() {
        seen.extend(try_row(&row).1);
    }
    let variants = variants(&["WheelFault"]);
    assert!(variants.len() >= 16, "{variants:?}");
    let missing: Vec<&String> = variants
        .iter()
        .filter(|name| !seen.contains(name))
        .collect();
    assert!(missing.is_empty(), "no row raises {missing:?}");
}

/// The stop is on the bus in the cycle in which its cause came in.
#[test]
fn a_fault_stops_both_wheels_in_its_cycle() {
    let mut machine = moving();
    let mark = machine.mark();
    comes_in(0x080, &[0x00, 0x10, 0x01, 4, 0, 0, 0, 0])(&mut machine);
    for axis in 0..2 {
        assert_eq!(machine.words_since(mark, axis), STOP, "wheel {axis}");
    }
}
