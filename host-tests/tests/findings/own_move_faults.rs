//! Each fault while two drives of a group move by themselves: the exact fault, and what each drive was told and did afterwards.

use can_motion::{AxisState, DriveMove, Fault};
use dyn_can::{Alarm, ConfigByte, DriveStatus, FunctionCode, Reply};

use crate::own_moves::slow_servo;
use crate::support::enums::name_of;
use crate::support::servos::{Servo, Servos, Told, line};
use crate::support::{Call, assert_none};

/// Where the drives go: it takes them almost a second.
const ENDS: [i32; 2] = [100_000, -100_000];

/// What becomes of an axis behind a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Aftermath {
    /// It is told to stop, and stops on its way.
    Stops,
    /// It is told nothing: its motor is free, or it is at rest.
    Nothing,
    /// It is told to stop, and nobody knows whether it hears that.
    ToldInVain,
    /// It arrives as if nothing had been.
    Arrives,
}

use Aftermath::{Arrives, Nothing, Stops, ToldInVain};

struct Row {
    what: String,
    cause: Box<dyn Fn(&mut Servos)>,
    /// Cycles in which the fault must come.
    within: usize,
    fault: Option<Fault>,
    is_exact: bool,
    after: [Aftermath; 2],
}

fn row(
    what: &str,
    cause: impl Fn(&mut Servos) + 'static,
    within: usize,
    fault: Fault,
    after: [Aftermath; 2],
) -> Row {
    Row {
        what: what.into(),
        cause: Box::new(cause),
        within,
        fault: Some(fault),
        is_exact: true,
        after,
    }
}

/// A drive that answers after 3 ms, so that a test can answer before it.
fn slow(id: i32) -> Servo {
    slow_servo(id)
        .counter_polled()
        .drive(|drive| drive.response_delay = drive_sim::ResponseDelay::fixed(3_000_000))
}

/// Two drives in the middle of their moves.
fn moving() -> Servos {
    let mut machine = Servos::on(line().responses_up_to_us(3_500), &[slow(1), slow(2)]);
    machine.stream();
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    for axis in 0..2 {
        machine
            .start(axis, can_motion::Procedure::ReadGroup2)
            .unwrap();
    }
    machine.run(60);
    for (axis, end) in ENDS.into_iter().enumerate() {
        machine.lets_move(axis, DriveMove::To(end)).unwrap();
    }
    machine.run(200);
    for axis in 0..2 {
        assert_eq!(machine.state(axis), AxisState::DriveMoving);
    }
    machine
}

/// The drive of axis 0 answers the next question of this kind like this.
fn answers(reply: impl Fn(&Servos) -> Reply + 'static) -> impl Fn(&mut Servos) + 'static {
    move |machine| {
        machine.until_asked(0, reply(machine).function(), |machine| machine.run(1));
        let reply = reply(machine);
        machine
            .0
            .cycle_with(|rig| Servos::reply_comes_in(rig, 0, reply));
    }
}

fn comes_in(data: &'static [u8]) -> impl Fn(&mut Servos) + 'static {
    move |machine| {
        machine
            .0
            .cycle_with(|rig| Servos::comes_in(rig, 0, FunctionCode::DriveError, data));
    }
}

fn alarms() -> Vec<Row> {
    let mut rows = vec![row(
        "an alarm of the drive",
        |machine| machine.faults_mut(0).raise_alarm(Alarm::OverCurrent),
        2,
        Fault::AlarmFrame,
        [Nothing, Stops],
    )];
    for code in 1..=7_u8 {
        let status = DriveStatus::from_byte(code << 2);
        rows.push(row(
            &format!("status with alarm code {code}"),
            answers(move |_| Reply::DriveStatus(status)),
            2,
            Fault::AlarmStatus(Alarm::from_code(code)),
            // The drive itself has no alarm and goes on: what it does is not known to anybody.
            [ToldInVain, Stops],
        ));
    }
    for (data, fault, after) in [
        (&[0xFF_u8] as &[u8], Fault::DataError, Stops),
        (
            &[0x12],
            Fault::UnknownError { byte: Some(0x12) },
            ToldInVain,
        ),
    ] {
        rows.push(row(
            &format!("Drive_Error with {data:02X?}"),
            comes_in(data),
            2,
            fault,
            [after, Stops],
        ));
    }
    rows
}

fn readings() -> Vec<Row> {
    let mut rows = vec![
        row(
            "a drive that switches itself off",
            |machine| machine.faults_mut(0).disable_itself(),
            60,
            Fault::SwitchedOff,
            [Nothing, Stops],
        ),
        row(
            "a drive that left position mode",
            answers(|_| Reply::DriveConfig(ConfigByte::from_byte(0x08))),
            2,
            Fault::Config(ConfigByte::from_byte(0x08)),
            [Stops, Stops],
        ),
    ];
    // Beyond the end, where nothing is left to stop, and behind the start, by more than a drive may be off.
    for (position, counts, after) in [
        (ENDS[0] + 8_193, 8_193, ToldInVain),
        (-8_193, -8_193, Stops),
    ] {
        rows.push(row(
            &format!("a position of {position} on the way from 0 to {}", ENDS[0]),
            answers(move |_| Reply::Position(position)),
            2,
            Fault::FollowingError { counts },
            [after, Stops],
        ));
    }
    for position in [ENDS[0] + 8_192, -8_192] {
        rows.push(Row {
            fault: None,
            ..row(
                &format!("a position of {position}, as far off as is allowed"),
                answers(move |_| Reply::Position(position)),
                2,
                Fault::Group,
                [Arrives, Arrives],
            )
        });
    }
    rows.push(Row {
        is_exact: false,
        ..row(
            "a counter that starts anew",
            answers(|machine| {
                let counter = machine
                    .0
                    .axis(0)
                    .feedback
                    .counter
                    .map_or(0, |read| read.value);
                Reply::DiagnosticCounter(counter.wrapping_sub(50))
            }),
            2,
            Fault::Reboot {
                expected: 0,
                actual: 0,
            },
            [ToldInVain, Stops],
        )
    });
    rows
}

fn silence() -> Vec<Row> {
    vec![
        row(
            "a drive that is unplugged",
            |machine| machine.unplug(0),
            300,
            Fault::Lost,
            [ToldInVain, Stops],
        ),
        row(
            "a blocked bus, and then bus-off",
            |machine| {
                machine.bus_off();
                machine.run(20);
                machine.bus_recovered();
            },
            2,
            Fault::Bus,
            [Stops, Stops],
        ),
        Row {
            is_exact: false,
            ..row(
                "a drive that crawls",
                |machine| {
                    let stranger = machine.add_stranger();
                    machine.stranger_sends(stranger, 0x31, &[1, 1]);
                },
                4_000,
                Fault::NotArrived { counts: 0 },
                // The partner has arrived long before.
                [Stops, Nothing],
            )
        },
    ]
}

fn rows() -> Vec<Row> {
    let mut rows = alarms();
    rows.extend(readings());
    rows.extend(silence());
    rows
}

fn try_row(row: &Row) -> (Vec<String>, Vec<String>) {
    let mut machine = moving();
    let mark = machine.mark();
    (row.cause)(&mut machine);
    for _ in 0..row.within {
        if machine.fault(0).is_some() {
            break;
        }
        machine.run(1);
    }
    let faults = [machine.fault(0), machine.fault(1)];
    let mut found = Vec::new();
    let is_right = match (faults[0], row.fault) {
        (None, None) => true,
        (Some(actual), Some(wanted)) if row.is_exact => actual == wanted,
        (Some(actual), Some(wanted)) => name_of(&actual) == name_of(&wanted),
        _ => false,
    };
    if !is_right {
        found.push(format!(
            "{}: {:?} in place of {:?}",
            row.what, faults[0], row.fault
        ));
    }
    let partner = row.fault.map(|fault| match fault {
        Fault::Bus => Fault::Bus,
        _ => Fault::Group,
    });
    // One that has arrived by then is not concerned.
    if faults[1] != partner && machine.state(1) != AxisState::Holding {
        found.push(format!("{}: the partner has {:?}", row.what, faults[1]));
    }
    machine.run(6_000);
    for axis in 0..2 {
        found.extend(judge(&mut machine, mark, axis, row));
    }
    machine.call(Call::Disable).unwrap();
    machine.run(1_000);
    if row.after[1] == Stops && machine.energised(1) {
        found.push(format!("{}: the partner cannot be switched off", row.what));
    }
    (found, faults.iter().flatten().map(name_of).collect())
}

fn judge(machine: &mut Servos, mark: usize, axis: usize, row: &Row) -> Option<String> {
    let told = machine.commands_since(mark, axis);
    let at = machine.position(axis);
    let is_stop = |told: &Told| {
        matches!(told, Told::Own(FunctionCode::GoAbsolutePosPtp, to)
            if to.abs() <= ENDS[0] && to.signum() * ENDS[axis].signum() >= 0)
    };
    let end = i64::from(ENDS[axis]);
    let is_on_the_way = at != end && at.signum() == end.signum() && at.abs() < end.abs();
    let stops = !told.is_empty() && told.iter().all(is_stop);
    let is_right = match row.after[axis] {
        Stops => stops && is_on_the_way && machine.state(axis) == AxisState::Faulted,
        Nothing => told.is_empty(),
        ToldInVain => told.iter().all(is_stop),
        Arrives => told.is_empty() && at == end && machine.state(axis) == AxisState::Holding,
    };
    (!is_right).then(|| {
        format!(
            "{}: axis {axis} is at {at}, {}, and was told {:?}; wanted {:?}",
            row.what,
            machine.state(axis),
            &told[..told.len().min(6)],
            row.after[axis]
        )
    })
}

#[test]
fn each_fault_stops_what_drives_do_by_themselves() {
    let found: Vec<String> = rows().iter().flat_map(|row| try_row(row).0).collect();
    assert_none(&found);
}

/// The faults that can be seen here and nowhere else: one that a row raises, and one of constant speed.
pub(crate) fn names_of_faults() -> Vec<String> {
    let crawls = rows()
        .into_iter()
        .filter(|row| matches!(row.fault, Some(Fault::NotArrived { .. })));
    let mut names: Vec<String> = crawls.flat_map(|row| try_row(&row).1).collect();
    let travel = slow_servo(1).travel(-60_000, 60_000);
    let mut machine = crate::own_moves::holding(&[travel]);
    machine.lets_move(0, DriveMove::Speed(120)).unwrap();
    machine.run(5_000);
    names.extend(machine.fault(0).iter().map(name_of));
    names
}

/// A move that is under way, and the bus is blocked: nothing can reach the drive, which goes on to its end. Nothing else moves then.
#[test]
fn what_a_blocked_bus_cannot_stop_ends_where_it_was_told() {
    let mut machine = moving();
    machine.block_bus_for_ms(3_000);
    machine.run(2_990);
    for (axis, end) in ENDS.into_iter().enumerate() {
        assert_eq!(machine.position(axis), i64::from(end));
        assert_eq!(machine.fault(axis), Some(Fault::Bus));
    }
    machine.run(3_000);
    for (axis, end) in ENDS.into_iter().enumerate() {
        assert_eq!(machine.state(axis), AxisState::Faulted);
        assert_eq!(machine.position(axis), i64::from(end));
    }
    machine.call(Call::Clear).unwrap();
    machine.0.run_until(AxisState::Holding);
}

/// A fault that asks for it takes the power at once, also from a drive that moves by itself.
#[test]
fn a_reaction_that_disables_does_not_wait_for_a_stop() {
    let disable =
        |one: Servo| one.react(|reactions| reactions.alarm = can_motion::Reaction::Disable);
    let mut machine = Servos::on(
        line().responses_up_to_us(3_500),
        &[disable(slow(1)), disable(slow(2))],
    );
    machine.stream();
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    machine.start(1, can_motion::Procedure::ReadGroup2).unwrap();
    machine.run(60);
    machine.lets_move(1, DriveMove::To(ENDS[1])).unwrap();
    machine.run(200);
    machine.faults_mut(0).raise_alarm(Alarm::OverCurrent);
    machine.run(5);
    assert!(!machine.energised(1));
    machine.run(300);
    assert_eq!(machine.state(1), AxisState::Faulted);
}
