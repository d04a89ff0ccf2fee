//! Each fault of a servo: its cause alone, in both signs where there is a sign, the exact fault, and the exact frames afterwards.

use can_motion::{DriftCause, Fault};
use dyn_can::{Alarm, ConfigByte, DriveStatus, FunctionCode, Reply};

use crate::support::enums::{name_of, variants};
use crate::support::servos::{Line, Servo, Servos, Told, line, servo};
use crate::support::{Call, assert_none};

/// Counts of the two axes in a cycle while the causes come.
const STEPS: [i32; 2] = [20, -10];

/// What the bus sees of an axis behind a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Aftermath {
    /// No set-point and no command any more.
    Nothing,
    /// Set-points that slow down within the limit, then none; no command.
    Ramp,
    /// The command to switch off, and no set-point.
    SwitchedOff,
    /// Nothing at all, not even readings.
    Silence,
    /// It goes on as if nothing had been: the fault is not of its group.
    GoesOn,
}

use Aftermath::{GoesOn, Nothing, Ramp, Silence, SwitchedOff};

struct Row {
    what: String,
    machine: fn() -> Servos,
    cause: Box<dyn Fn(&mut Servos)>,
    /// Cycles of motion in which the fault must come.
    within: i32,
    fault: Expected,
    partner: Option<Fault>,
    after: [Aftermath; 2],
}

enum Expected {
    Exactly(Fault),
    Like(&'static str, fn(&Fault) -> bool),
    /// Nothing is wrong.
    None,
}

fn line_for_answers() -> Line {
    line().responses_up_to_us(3_500)
}

/// Two servos that answer after 3 ms, so that a test can answer before them.
fn two() -> Vec<Servo> {
    [1, 2].map(slow).to_vec()
}

fn slow(id: i32) -> Servo {
    servo(id)
        .ramp_change(4)
        .counter_polled()
        .drive(|drive| drive.response_delay = drive_sim::ResponseDelay::fixed(3_000_000))
}

fn moving_with(servos: &[Servo]) -> Servos {
    let mut machine = Servos::on(line_for_answers(), servos);
    machine.stream();
    machine.move_all(&STEPS, 100);
    machine
}

fn moving() -> Servos {
    moving_with(&two())
}

fn standing() -> Servos {
    let mut machine = moving();
    machine.move_all(&[0, 0], 400);
    machine
}

fn backward() -> Servos {
    let mut machine = moving();
    machine.move_all(&[-20, 10], 200);
    machine
}

/// Nothing was enabled yet.
fn fresh() -> Servos {
    Servos::on(line_for_answers(), &two())
}

fn row(
    what: &str,
    machine: fn() -> Servos,
    cause: impl Fn(&mut Servos) + 'static,
    within: i32,
    fault: Expected,
    after: [Aftermath; 2],
) -> Row {
    Row {
        what: what.into(),
        machine,
        cause: Box::new(cause),
        within,
        fault,
        partner: Some(Fault::Group),
        after,
    }
}

/// The drive of axis 0 answers the next question of this kind like this.
fn answers(reply: impl Fn(&Servos) -> Reply + 'static) -> impl Fn(&mut Servos) + 'static {
    answers_while(STEPS, reply)
}

fn answers_while(
    steps: [i32; 2],
    reply: impl Fn(&Servos) -> Reply + 'static,
) -> impl Fn(&mut Servos) + 'static {
    move |machine| {
        let function = reply(machine).function();
        machine.until_asked(0, function, |machine| machine.move_all(&steps, 1));
        let reply = reply(machine);
        machine
            .0
            .cycle_with(|rig| Servos::reply_comes_in(rig, 0, reply));
    }
}

fn comes_in(function: FunctionCode, data: &'static [u8]) -> impl Fn(&mut Servos) + 'static {
    move |machine| {
        machine
            .0
            .cycle_with(|rig| Servos::comes_in(rig, 0, function, data));
    }
}

fn sent(machine: &Servos) -> i32 {
    machine.0.axis(0).sent_counts
}

fn alarms() -> Vec<Row> {
    let mut rows: Vec<Row> = (1..=7_u8)
        .map(|code| {
            let status = DriveStatus::from_byte(code << 2);
            row(
                &format!("status with alarm code {code}"),
                moving,
                answers(move |_| Reply::DriveStatus(status)),
                2,
                Expected::Exactly(Fault::AlarmStatus(Alarm::from_code(code))),
                [Nothing, Nothing],
            )
        })
        .collect();
    rows.push(row(
        "an alarm of the drive",
        moving,
        |machine| machine.faults_mut(0).raise_alarm(Alarm::OverCurrent),
        2,
        Expected::Exactly(Fault::AlarmFrame),
        [Nothing, Nothing],
    ));
    for (data, fault) in [
        (&[0xEE_u8] as &[u8], Fault::AlarmFrame),
        (&[0xFF], Fault::DataError),
        (&[0x00], Fault::UnknownError { byte: Some(0x00) }),
        (&[0x12], Fault::UnknownError { byte: Some(0x12) }),
        (&[0xFE], Fault::UnknownError { byte: Some(0xFE) }),
    ] {
        rows.push(row(
            &format!("Drive_Error with {data:02X?}"),
            moving,
            comes_in(FunctionCode::DriveError, data),
            2,
            Expected::Exactly(fault),
            [Nothing, Nothing],
        ));
    }
    rows
}

fn power() -> Vec<Row> {
    let off = DriveStatus::from_byte(0x02);
    let away_from_position = DriveStatus::from_byte(0x01);
    vec![
        row(
            "a drive that switches itself off",
            moving,
            |machine| machine.faults_mut(0).disable_itself(),
            60,
            Expected::Exactly(Fault::SwitchedOff),
            [Nothing, Nothing],
        ),
        row(
            "status: off",
            moving,
            answers(move |_| Reply::DriveStatus(off)),
            2,
            Expected::Exactly(Fault::SwitchedOff),
            [Nothing, Nothing],
        ),
        row(
            "status: off, while the group holds",
            || {
                let mut machine = moving();
                machine.call(Call::Halt).unwrap();
                machine.run(50);
                machine
            },
            answers(move |_| Reply::DriveStatus(off)),
            2,
            Expected::Exactly(Fault::SwitchedOff),
            [Nothing, Nothing],
        ),
        row(
            "status: on, of a drive that is to be enabled and was not yet",
            || {
                let mut machine = fresh();
                machine.become_ready();
                machine.call(Call::Enable).unwrap();
                machine
            },
            answers(move |_| Reply::DriveStatus(DriveStatus::from_byte(0x00))),
            2,
            Expected::Exactly(Fault::SwitchedOn),
            [Nothing, Nothing],
        ),
        row(
            "status: away from its position, which a moving drive is",
            moving,
            answers(move |_| Reply::DriveStatus(away_from_position)),
            100,
            Expected::None,
            [GoesOn, GoesOn],
        ),
    ]
}

/// A position that is so far from what was sent.
fn position_off_by(counts: i32) -> impl Fn(&Servos) -> Reply + 'static {
    move |machine| Reply::Position(sent(machine) + counts)
}

fn positions() -> Vec<Row> {
    let mut rows = Vec::new();
    for sign in [1, -1] {
        rows.push(row(
            &format!(
                "standing, {} and then {} counts off, one more than is allowed",
                10 * sign,
                17 * sign
            ),
            standing,
            move |machine| {
                for counts in [10 * sign, 17 * sign] {
                    answers_while([0, 0], position_off_by(counts))(machine);
                }
            },
            2,
            Expected::Like("Drift of 17", |fault| {
                matches!(
                    fault,
                    Fault::Drift {
                        counts: 17 | -17,
                        ..
                    }
                )
            }),
            [Nothing, Nothing],
        ));
        rows.push(row(
            &format!("standing, {} counts off, which is allowed", 16 * sign),
            standing,
            answers_while([0, 0], position_off_by(16 * sign)),
            2,
            Expected::None,
            [GoesOn, GoesOn],
        ));
        rows.push(row(
            &format!(
                "standing, another {} counts off at each reading, more than any step",
                16 * sign
            ),
            standing,
            move |machine| {
                for counts in [16 * sign, 32 * sign] {
                    answers_while([0, 0], position_off_by(counts))(machine);
                }
            },
            2,
            Expected::Like("Drift of 32", |fault| {
                matches!(
                    fault,
                    Fault::Drift {
                        counts: 32 | -32,
                        ..
                    }
                )
            }),
            [Nothing, Nothing],
        ));
        rows.push(row(
            &format!(
                "standing, the position jumps by {} counts, one more than is allowed",
                17 * sign
            ),
            standing,
            answers_while([0, 0], position_off_by(17 * sign)),
            2,
            Expected::Exactly(Fault::PositionJump { counts: 17 * sign }),
            [Nothing, Nothing],
        ));
        rows.push(row(
            &format!("standing, {} counts off: half a turn and one", 8_193 * sign),
            standing,
            answers_while([0, 0], position_off_by(8_193 * sign)),
            2,
            Expected::Exactly(Fault::FollowingError {
                counts: 8_193 * sign,
            }),
            [Nothing, Nothing],
        ));
        rows.push(row(
            &format!("moving, 9000 counts {}", if sign > 0 { "ahead" } else { "behind" }),
            moving,
            answers(position_off_by(9_000 * sign)),
            2,
            Expected::Like("FollowingError of about 9000", |fault| {
                matches!(fault, Fault::FollowingError { counts: 8_800..=9_000 | -9_000..=-8_800 })
            }),
            [Nothing, Nothing],
        ));
        rows.push(row(
            &format!(
                "moving, 8000 counts {}",
                if sign > 0 { "ahead" } else { "behind" }
            ),
            moving,
            answers(position_off_by(8_000 * sign)),
            2,
            Expected::Like("PositionJump of about 8000", |fault| {
                matches!(fault, Fault::PositionJump { counts: 7_900..=8_100 | -8_100..=-7_900 })
            }),
            [Nothing, Nothing],
        ));
        rows.push(row(
            &format!(
                "moving, 1000 counts {}, as a drive may lag",
                if sign > 0 { "ahead" } else { "behind" }
            ),
            moving,
            answers(position_off_by(1_000 * sign)),
            2,
            Expected::None,
            [GoesOn, GoesOn],
        ));
    }
    rows
}

fn lost_steps() -> Vec<Row> {
    let mut rows = Vec::new();
    let machines: [(fn() -> Servos, i32); 2] = [(moving, 1), (backward, -1)];
    for (machine, sign) in machines {
        rows.push(row(
            &format!("a set-point of {} counts that the drive missed", 20 * sign),
            machine,
            move |machine| {
                machine.lose_set_points(0, 1);
                machine.move_all(&[20 * sign, 0], 10);
                machine.move_all(&[0, 0], 400);
            },
            400,
            Expected::Like("Drift, one step lost", |fault| {
                matches!(
                    fault,
                    Fault::Drift {
                        counts: 20 | -20,
                        cause: DriftCause::OneStepLost | DriftCause::OneStepLostOrRepeated
                    }
                )
            }),
            [Nothing, Nothing],
        ));
        rows.push(row(
            &format!("a set-point of {} counts that came twice", 20 * sign),
            machine,
            move |machine| {
                machine.double_set_points(0, 1);
                machine.move_all(&[20 * sign, 0], 10);
                machine.move_all(&[0, 0], 400);
            },
            400,
            Expected::Like("Drift, one step repeated", |fault| {
                matches!(
                    fault,
                    Fault::Drift {
                        counts: 20 | -20,
                        cause: DriftCause::OneStepRepeated | DriftCause::OneStepLostOrRepeated
                    }
                )
            }),
            [Nothing, Nothing],
        ));
    }
    rows
}

fn backlogs() -> Vec<Row> {
    let mut rows = Vec::new();
    for sign in [1, -1] {
        rows.push(row(
            &format!("a gap of 8 ms in a motion of {} counts a cycle", 50 * sign),
            || {
                moving_with(
                    &two()
                        .into_iter()
                        .map(|one| one.backlog(200).max_step(60))
                        .collect::<Vec<_>>(),
                )
            },
            move |machine| {
                machine.move_all(&[50 * sign, 0], 100);
                machine.block_bus_for_ms(8);
                machine.move_all(&[50 * sign, 0], 10);
            },
            2,
            if sign > 0 {
                Expected::Like("Backlog, positive", |fault| {
                    matches!(fault, Fault::Backlog { counts: 201..=400 })
                })
            } else {
                Expected::Like("Backlog, negative", |fault| {
                    matches!(
                        fault,
                        Fault::Backlog {
                            counts: -400..=-201
                        }
                    )
                })
            },
            [Nothing, Nothing],
        ));
        rows.push(row(
            &format!(
                "a gap of 3 ms in a motion of {} counts a cycle, and time to catch up",
                50 * sign
            ),
            || {
                moving_with(
                    &two()
                        .into_iter()
                        .map(|one| one.backlog(1_000).max_step(60))
                        .collect::<Vec<_>>(),
                )
            },
            move |machine| {
                machine.move_all(&[50 * sign, 0], 100);
                machine.block_bus_for_ms(3);
                machine.move_all(&[50 * sign, 0], 10);
            },
            2,
            Expected::None,
            [GoesOn, GoesOn],
        ));
    }
    rows
}

fn silence() -> Vec<Row> {
    vec![
        row(
            "a drive that left the bus",
            moving,
            |machine| machine.faults_mut(0).leave_bus(),
            150,
            Expected::Exactly(Fault::Lost),
            [Silence, Ramp],
        ),
        row(
            "a drive that hears and says nothing",
            moving,
            |machine| machine.faults_mut(0).fall_silent(),
            150,
            Expected::Exactly(Fault::Lost),
            [Silence, Ramp],
        ),
        row(
            "two replies that did not come",
            moving,
            |machine| machine.faults_mut(0).drop_next_replies(2),
            150,
            Expected::None,
            [GoesOn, GoesOn],
        ),
        row(
            "the counter starts again",
            || {
                let mut machine = moving();
                machine.move_all(&STEPS, 600);
                machine
            },
            answers(|_| Reply::DiagnosticCounter(0)),
            2,
            Expected::Like("Reboot to 0", |fault| {
                matches!(fault, Fault::Reboot { actual: 0, .. })
            }),
            [Nothing, Nothing],
        ),
        Row {
            partner: Some(Fault::Bus),
            ..row(
                "the bus is off",
                moving,
                Servos::bus_off,
                2,
                Expected::Exactly(Fault::Bus),
                [Silence, Silence],
            )
        },
    ]
}

fn bring_up() -> Vec<Row> {
    let mut rows: Vec<Row> = [0x01_u8, 0x02, 0x03, 0x08, 0x10, 0x18]
        .into_iter()
        .map(|byte| {
            let config = ConfigByte::from_byte(byte);
            let mut row = row(
                &format!("configuration {byte:02X}"),
                fresh,
                answers(move |_| Reply::DriveConfig(config)),
                2,
                Expected::Exactly(Fault::Config(config)),
                [Nothing, GoesOn],
            );
            row.partner = None;
            row
        })
        .collect();
    for gear in [500_u16, 4_095, 4_097, 8_192, 16_384] {
        let mut row = row(
            &format!("gear number {gear} in place of 4096"),
            fresh,
            answers(move |machine| machine.group3_with(0, gear, 1)),
            2,
            Expected::Exactly(Fault::Gear {
                expected: 4_096,
                actual: Some(gear),
            }),
            [Nothing, GoesOn],
        );
        row.partner = None;
        rows.push(row);
    }
    for (range, fault) in [(126_u8, Some(Fault::NoBrake)), (127, None)] {
        let mut row = row(
            &format!("a load that can fall, and an on-position range of {range}"),
            || Servos::on(line_for_answers(), &[slow(1).load_can_fall(), slow(2)]),
            answers(move |machine| machine.group3_with(0, 4_096, range)),
            2,
            fault.map_or(Expected::None, Expected::Exactly),
            [Nothing, GoesOn],
        );
        row.partner = None;
        rows.push(row);
    }
    for position in [1_001, -1_001] {
        let mut row = row(
            &format!("a position of {position} at the start, the travel is 1000 both ways"),
            || {
                let one = slow(1).travel(-1_000, 1_000);
                Servos::on(line_for_answers(), &[one, slow(2)])
            },
            answers(move |_| Reply::Position(position)),
            2,
            Expected::Exactly(Fault::PositionRange {
                read_back: position,
            }),
            [Nothing, GoesOn],
        );
        row.partner = None;
        rows.push(row);
    }
    rows
}

fn confirmations() -> Vec<Row> {
    let enabling = || {
        let mut machine = fresh();
        machine.become_ready();
        machine
    };
    vec![
        row(
            "a drive that does not take its enable command",
            enabling,
            |machine| {
                machine.lose_switches(0, 1);
                machine.call(Call::Enable).unwrap();
            },
            450,
            Expected::Exactly(Fault::ConfirmTimeout),
            [Nothing, Nothing],
        ),
        row(
            "a drive that says off after its enable command",
            enabling,
            |machine| {
                machine.call(Call::Enable).unwrap();
                let mark = machine.mark();
                while !machine.commands_since(mark, 0).contains(&Told::On) {
                    machine.run(1);
                }
                machine.faults_mut(0).drop_next_replies(u64::MAX);
                for _ in 0..200 {
                    machine.until_asked(0, FunctionCode::ReadDriveStatus, |machine| machine.run(1));
                    machine.0.cycle_with(|rig| {
                        Servos::reply_comes_in(
                            rig,
                            0,
                            Reply::DriveStatus(DriveStatus::from_byte(2)),
                        );
                    });
                    if machine.fault(0).is_some() {
                        return;
                    }
                }
            },
            10,
            Expected::Exactly(Fault::ConfirmTimeout),
            // The enable command may still take effect, so it is followed by a disable command.
            [SwitchedOff, Nothing],
        ),
        row(
            "a shaft that does not stand",
            || {
                let line =
                    line_for_answers().timeouts(|timeouts| timeouts.standstill_limit_us = 300_000);
                let mut machine = Servos::on(line, &two());
                machine.become_ready();
                machine
            },
            |machine| {
                machine.call(Call::Enable).unwrap();
                for sign in (0..200).map(|turn| if turn % 2 == 0 { 1 } else { -1 }) {
                    if machine.fault(0).is_some() || machine.energised(0) {
                        return;
                    }
                    let mark = machine.mark();
                    machine.run(1);
                    let speed = Told::Reading(FunctionCode::ReadMotorSpeed);
                    let told = machine.told_since(mark);
                    if told.iter().any(|to| to.axis == 0 && to.told == speed) {
                        machine.0.cycle_with(|rig| {
                            Servos::reply_comes_in(rig, 0, Reply::MotorSpeed(sign));
                        });
                    }
                }
            },
            300,
            Expected::Exactly(Fault::ConfirmTimeout),
            [Nothing, Nothing],
        ),
    ]
}

fn rows() -> Vec<Row> {
    let mut rows = alarms();
    rows.extend(power());
    rows.extend(positions());
    rows.extend(lost_steps());
    rows.extend(backlogs());
    rows.extend(silence());
    rows.extend(bring_up());
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
        machine.move_all(&STEPS, 1);
    }
    let faults = [machine.fault(0), machine.fault(1)];
    let is_right = match (&row.fault, faults[0]) {
        (Expected::None, fault) => fault.is_none(),
        (Expected::Exactly(wanted), Some(fault)) => fault == *wanted,
        (Expected::Like(_, is_like), Some(fault)) => is_like(&fault),
        (_, None) => false,
    };
    let wanted = match &row.fault {
        Expected::None => "no fault".into(),
        Expected::Exactly(fault) => format!("{fault:?}"),
        Expected::Like(text, _) => (*text).into(),
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
    // What was in a mailbox when the cause came is on the bus by now.
    if row.after.contains(&Ramp) {
        found.extend(judge(&mut machine, row));
    } else {
        machine.move_all(&STEPS, 1);
        found.extend(judge(&mut machine, row));
    }
    let names = faults.iter().flatten().map(name_of).collect();
    (found, names)
}

fn judge(machine: &mut Servos, row: &Row) -> Vec<String> {
    let mark = machine.mark();
    machine.move_all(&STEPS, 100);
    let mut found = Vec::new();
    for axis in 0..2 {
        let steps = machine.steps_since(mark, axis);
        let commands = machine.commands_since(mark, axis);
        let told = machine.told_since(mark);
        let readings = told.iter().filter(|to| to.axis == axis).count();
        let is_ramp = |steps: &[i32]| {
            let change =
                |pair: &[i32]| (pair[1] - pair[0]).abs() <= 5 && pair[1].abs() <= pair[0].abs();
            !steps.is_empty()
                && steps.len() < 20
                && steps.windows(2).all(change)
                && steps.last().is_some_and(|last| last.abs() <= 5)
        };
        let is_right = match row.after[axis] {
            Nothing => steps.is_empty() && commands.is_empty(),
            Ramp => is_ramp(&steps) && commands.is_empty(),
            SwitchedOff => steps.is_empty() && commands == [Told::Off],
            Silence => readings == 0,
            GoesOn => commands.is_empty(),
        };
        if !is_right {
            found.push(format!(
                "{}: axis {axis} got {} set-points {:?}, commands {commands:?}, {readings} frames in all; wanted {:?}",
                row.what,
                steps.len(),
                &steps[..steps.len().min(8)],
                row.after[axis]
            ));
        }
    }
    found
}

/// Findings 15, 18 and 19.
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
    seen.extend(crate::own_move_faults::names_of_faults());
    let variants = variants(&["ServoFault", "Fault"]);
    assert!(variants.len() >= 15, "{variants:?}");
    let missing: Vec<&String> = variants
        .iter()
        .filter(|name| !seen.contains(name))
        .collect();
    assert!(missing.is_empty(), "no row raises {missing:?}");
}

/// Each reaction, for a fault that leaves its axis able to do all of them.
#[test]
fn each_reaction_does_what_it_says() {
    use can_motion::Reaction;
    let mut found = Vec::new();
    for (reaction, after) in [
        (Reaction::Halt, [Nothing, Nothing]),
        (Reaction::RampDown, [Ramp, Ramp]),
        (Reaction::Disable, [SwitchedOff, SwitchedOff]),
    ] {
        let servos: Vec<Servo> = two()
            .into_iter()
            .map(|one| one.react(|reactions| reactions.alarm = reaction))
            .collect();
        let mut machine = moving_with(&servos);
        let mark = machine.mark();
        comes_in(FunctionCode::DriveError, &[0x12])(&mut machine);
        let case = row("x", moving, |_| {}, 0, Expected::None, after);
        machine.move_all(&STEPS, 100);
        for axis in 0..2 {
            let steps = machine.steps_since(mark, axis);
            let commands = machine.commands_since(mark, axis);
            let (most, on) = match case.after[axis] {
                Ramp => (8, true),
                SwitchedOff => (1, false),
                _ => (1, true),
            };
            let wanted: &[Told] = if on { &[] } else { &[Told::Off] };
            if steps.len() > most || commands != wanted || machine.energised(axis) != on {
                found.push(format!(
                    "{reaction:?}: axis {axis} got set-points {steps:?} and {commands:?}, it is {}",
                    if machine.energised(axis) { "on" } else { "off" }
                ));
            }
        }
    }
    assert_none(&found);
}

/// Promise 6: a disable that the drive did not get is repeated, and it is said.
#[test]
fn a_disable_that_was_lost_is_repeated_until_the_drive_is_off() {
    let mut found = Vec::new();
    for lost in [1, 3] {
        let mut machine = moving();
        machine.lose_switches(0, lost);
        machine.call(Call::Disable).unwrap();
        machine.run(3_000);
        if machine.energised(0) {
            found.push(format!(
                "{lost} disable commands were lost: the drive is still on three seconds later, the master says {}, fault {:?}",
                if machine.believed_on(0) { "on" } else { "off" },
                machine.fault(0)
            ));
        }
    }
    assert_none(&found);
}
