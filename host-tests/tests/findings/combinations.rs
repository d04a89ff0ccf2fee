//! Every stage of a life, with every cause of trouble, and two calls of the application behind it.
//!
//! What holds whatever happened: set-points and turns only by a word that was given after the trouble, off after `disable`, and a
//! master that knows which of its drives are on.

use can_motion::Reaction;
use dyn_can::Alarm;

use crate::support::servos::{Servos, servo};
use crate::support::wheels::{Wheels, hub};
use crate::support::{Call, assert_none};

/// The second call may be none.
const CALLS: [Option<Call>; 7] = [
    None,
    Some(Call::Enable),
    Some(Call::Resume),
    Some(Call::Stop),
    Some(Call::Halt),
    Some(Call::Disable),
    Some(Call::Clear),
];

/// Where the machine is when the trouble comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    BringUp,
    Ready,
    Enabling,
    Confirming,
    Moving,
    Stopping,
    Held,
    Halted,
    Disabling,
}

/// Every stage, for the long run.
const STAGES: [Stage; 9] = [
    Stage::BringUp,
    Stage::Ready,
    Stage::Enabling,
    Stage::Confirming,
    Stage::Moving,
    Stage::Stopping,
    Stage::Held,
    Stage::Halted,
    Stage::Disabling,
];

/// One test for each stage, so that they run side by side.
macro_rules! in_each_stage {
    ($check:expr) => {
        in_each_stage!(
            $check,
            from_bring_up: BringUp, from_ready: Ready, from_enabling: Enabling,
            from_confirming: Confirming, from_motion: Moving, from_a_ramp: Stopping,
            from_a_stop: Held, from_a_halt: Halted, from_a_disable: Disabling
        );
    };
    ($check:expr, $($name:ident: $stage:ident),+) => {
        $(
            #[test]
            fn $name() {
                let check: fn(Stage) = $check;
                check(Stage::$stage);
            }
        )+
    };
}

/// Of how many pairs of calls one is tried in the usual run; which one differs from trouble to trouble.
const ONE_OF: usize = 7;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trouble {
    None,
    Alarm,
    PartnerAlarm,
    PartnerOff,
    Silent,
    Restart,
    BusOff,
    Unplugged,
    Speedless,
}

const TROUBLES: [Trouble; 9] = [
    Trouble::None,
    Trouble::Alarm,
    Trouble::PartnerAlarm,
    Trouble::PartnerOff,
    Trouble::Silent,
    Trouble::Restart,
    Trouble::BusOff,
    Trouble::Unplugged,
    Trouble::Speedless,
];

const STEPS: [i32; 2] = [20, -10];

fn servos_at(stage: Stage) -> Servos {
    let quick = |id| {
        servo(id)
            .ramp_change(1)
            .drive(|drive| drive.power_on_delay_ns = 1_000_000)
    };
    let mut machine = Servos::new(&[quick(1), quick(2)]);
    if stage == Stage::BringUp {
        machine.run(153);
        return machine;
    }
    machine.become_ready();
    if stage == Stage::Ready {
        return machine;
    }
    machine.call(Call::Enable).unwrap();
    match stage {
        Stage::Enabling => machine.run(80),
        Stage::Confirming => machine.run(154),
        _ => machine.run(300),
    }
    if matches!(stage, Stage::Enabling | Stage::Confirming) {
        return machine;
    }
    machine.move_all(&STEPS, 60);
    let call = match stage {
        Stage::Stopping | Stage::Held => Some(Call::Stop),
        Stage::Halted => Some(Call::Halt),
        Stage::Disabling => Some(Call::Disable),
        _ => None,
    };
    if let Some(call) = call {
        machine.call(call).unwrap();
    }
    machine.move_all(
        &STEPS,
        if matches!(stage, Stage::Held | Stage::Halted) {
            50
        } else {
            3
        },
    );
    machine
}

fn troubled(machine: &mut Servos, trouble: Trouble) {
    match trouble {
        Trouble::None => {}
        Trouble::Alarm => machine.faults_mut(0).raise_alarm(Alarm::OverCurrent),
        Trouble::PartnerAlarm => machine.faults_mut(1).raise_alarm(Alarm::OverCurrent),
        Trouble::PartnerOff => machine.faults_mut(1).disable_itself(),
        Trouble::Silent => machine.faults_mut(0).fall_silent(),
        Trouble::Restart => machine.faults_mut(0).reboot(),
        Trouble::BusOff => {
            machine.bus_off();
            machine.move_all(&STEPS, 5);
            machine.bus_recovered();
        }
        Trouble::Unplugged => {
            machine.unplug(0);
            machine.unplug(1);
            machine.move_all(&STEPS, 60);
            machine.plug_in(0);
            machine.plug_in(1);
        }
        Trouble::Speedless => machine
            .faults_mut(0)
            .misconfigure(dyn_can::ConfigByte::from_byte(0x08)),
    }
}

fn one_case(stage: Stage, trouble: Trouble, calls: [Option<Call>; 2], gap: i32) -> Vec<String> {
    let mut machine = servos_at(stage);
    let mut may_move = matches!(stage, Stage::Enabling | Stage::Confirming | Stage::Moving);
    let mut wants_off = stage == Stage::Disabling;
    let mut answers = Vec::new();
    troubled(&mut machine, trouble);
    // An outage is a fault, whether the master says so or not.
    if matches!(trouble, Trouble::Unplugged | Trouble::BusOff) && stage != Stage::BringUp {
        may_move = false;
    }
    for call in calls {
        for _ in 0..gap {
            machine.move_all(&STEPS, 1);
            if (0..2).any(|axis| machine.fault(axis).is_some()) {
                may_move = false;
            }
        }
        let Some(call) = call else { continue };
        let answer = machine.call(call);
        match call {
            Call::Enable | Call::Resume if answer.is_ok() => (may_move, wants_off) = (true, false),
            Call::Stop | Call::Halt => may_move = false,
            Call::Disable => (may_move, wants_off) = (false, true),
            _ => {}
        }
        answers.push(answer.is_ok());
    }
    // A mode that changed after the check of an axis is noticed by a motion that is not followed, within a second.
    let settle = if trouble == Trouble::Speedless {
        1_000
    } else {
        450
    };
    for _ in 0..settle {
        machine.move_all(&STEPS, 1);
        if (0..2).any(|axis| machine.fault(axis).is_some()) {
            may_move = false;
        }
    }
    let mark = machine.mark();
    machine.move_all(&STEPS, 50);
    let case = format!("{stage:?}, {trouble:?}, {calls:?} {answers:?} {gap} cycles apart");
    let mut found = Vec::new();
    for axis in 0..2 {
        let set_points = machine.steps_since(mark, axis).len();
        let (on, believed) = (machine.energised(axis), machine.believed_on(axis));
        let fault = machine.fault(axis);
        if set_points > 0 && !may_move {
            found.push(format!(
                "{case}: axis {axis} gets set-points, and nobody said so"
            ));
        }
        if set_points > 0 && !on {
            found.push(format!("{case}: axis {axis} is off and gets set-points"));
        }
        if wants_off && on && !(trouble == Trouble::Restart) {
            found.push(format!("{case}: axis {axis} was disabled and is on"));
        }
        if fault.is_none() && on != believed {
            let is = |on: bool| if on { "on" } else { "off" };
            found.push(format!(
                "{case}: axis {axis} is {} and the master says {}",
                is(on),
                is(believed)
            ));
        }
        if trouble == Trouble::Speedless && axis == 0 && set_points > 0 {
            found.push(format!("{case}: set-points go to a drive in speed mode"));
        }
    }
    found
}

/// What is broken, one line for each kind, with an example.
fn summary(found: &[String]) -> Vec<String> {
    let mut lines: Vec<(&str, &str, &str, usize)> = Vec::new();
    for line in found {
        let (case, what) = line.split_once(": ").expect("case: what");
        let (place, _) = case.split_once(", [").expect("stage, trouble, [calls]");
        let same = lines
            .iter_mut()
            .find(|(other, text, ..)| (*other, *text) == (place, what));
        match same {
            Some((.., count)) => *count += 1,
            None => lines.push((place, what, case, 1)),
        }
    }
    let text = |(place, what, case, count)| format!("{count} x {place}: {what}, e.g. {case}");
    lines.into_iter().map(text).collect()
}

/// Each pair of calls, at once or with time between them by turns.
fn pairs() -> impl Iterator<Item = ([Option<Call>; 2], i32)> {
    let firsts = CALLS.into_iter().enumerate();
    let all = firsts.flat_map(|(row, first)| {
        let seconds = CALLS.into_iter().enumerate();
        seconds.map(move |(column, second)| (row + column, first, second))
    });
    all.filter(|(_, first, second)| first.is_none() || second.is_some())
        .map(|(place, first, second)| ([first, second], if place % 2 == 0 { 1 } else { 120 }))
}

fn broken_at(stage: Stage, one_of: usize) -> Vec<String> {
    let mut found = Vec::new();
    for (number, trouble) in TROUBLES.into_iter().enumerate() {
        for (calls, gap) in pairs().skip(number % one_of).step_by(one_of) {
            found.extend(one_case(stage, trouble, calls, gap));
        }
    }
    summary(&found)
}

/// Beyond the list: two calls, and a call and a fault, in each stage.
mod servos_know_their_power_and_move_only_by_a_word {
    use super::{ONE_OF, Stage, assert_none, broken_at};

    in_each_stage!(|stage| assert_none(&broken_at(stage, ONE_OF)));
}

/// What may happen to a wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WheelTrouble {
    None,
    Trip,
    PartnerTrip,
    GoneForAWhile,
    Restart,
    PartnerRestart,
    BusOff,
    Blocked,
    EmergencyInput,
}

const WHEEL_TROUBLES: [WheelTrouble; 9] = [
    WheelTrouble::None,
    WheelTrouble::Trip,
    WheelTrouble::PartnerTrip,
    WheelTrouble::GoneForAWhile,
    WheelTrouble::Restart,
    WheelTrouble::PartnerRestart,
    WheelTrouble::BusOff,
    WheelTrouble::Blocked,
    WheelTrouble::EmergencyInput,
];

/// What a wheel is told while it may move: half a turn a second, or a place far away.
const fn goal(is_position: bool) -> [i32; 2] {
    if is_position {
        [1_000_000, -1_000_000]
    } else {
        [30, -30]
    }
}

fn wheels_at(stage: Stage, is_position: bool, reaction: Reaction) -> Wheels {
    let wheels = [1, 2].map(|node| {
        let wheel = if is_position {
            hub(node).position(30)
        } else {
            hub(node)
        };
        wheel.react(|reactions| reactions.drive = reaction)
    });
    let mut machine = Wheels::new(&wheels);
    if stage == Stage::BringUp {
        machine.run(30);
        return machine;
    }
    machine.become_ready();
    if stage == Stage::Ready {
        return machine;
    }
    machine.call(Call::Enable).unwrap();
    match stage {
        Stage::Enabling => machine.run(5),
        Stage::Confirming => machine.run(13),
        _ => machine.run(50),
    }
    if matches!(stage, Stage::Enabling | Stage::Confirming) {
        return machine;
    }
    machine.drive_at(&goal(is_position), 30);
    let call = match stage {
        Stage::Stopping | Stage::Held => Some(Call::Stop),
        Stage::Halted => Some(Call::Halt),
        Stage::Disabling => Some(Call::Disable),
        _ => None,
    };
    if let Some(call) = call {
        machine.call(call).unwrap();
    }
    let cycles = if matches!(stage, Stage::Held | Stage::Halted) {
        50
    } else {
        1
    };
    machine.drive_at(&goal(is_position), cycles);
    machine
}

fn wheels_troubled(machine: &mut Wheels, trouble: WheelTrouble, goal: &[i32; 2]) {
    match trouble {
        WheelTrouble::None => {}
        WheelTrouble::Trip => trip(machine, 0, goal),
        WheelTrouble::PartnerTrip => trip(machine, 1, goal),
        WheelTrouble::GoneForAWhile => {
            machine.faults_mut(0).leave_bus();
            machine.drive_at(goal, 60);
            machine.faults_mut(0).wake();
        }
        WheelTrouble::Restart => machine.faults_mut(0).power_cycle(1_000_000),
        WheelTrouble::PartnerRestart => machine.faults_mut(1).power_cycle(1_000_000),
        WheelTrouble::BusOff => {
            machine.bus_off();
            machine.drive_at(goal, 5);
            machine.bus_recovered();
        }
        WheelTrouble::Blocked => {
            machine.block_bus_for_ms(200);
            machine.drive_at(goal, 20);
        }
        WheelTrouble::EmergencyInput => {
            machine.faults_mut(0).emergency_input(true);
            machine.drive_at(goal, 5);
            machine.faults_mut(0).emergency_input(false);
        }
    }
}

fn trip(machine: &mut Wheels, axis: usize, goal: &[i32; 2]) {
    machine.faults_mut(axis).trip(0x0004);
    machine.drive_at(goal, 3);
    machine.faults_mut(axis).remove_cause();
}

fn one_wheel_case(
    stage: Stage,
    is_position: bool,
    reaction: Reaction,
    trouble: WheelTrouble,
    calls: [Option<Call>; 2],
    gap: i32,
) -> Vec<String> {
    let goal = goal(is_position);
    let mut machine = wheels_at(stage, is_position, reaction);
    let mut may_move = matches!(stage, Stage::Enabling | Stage::Confirming | Stage::Moving);
    let mut wants_off = stage == Stage::Disabling;
    let has_fault = |machine: &Wheels| (0..2).any(|axis| machine.fault(axis).is_some());
    let mut answers = Vec::new();
    wheels_troubled(&mut machine, trouble, &goal);
    if matches!(trouble, WheelTrouble::Blocked | WheelTrouble::BusOff) && stage != Stage::BringUp {
        may_move = false;
    }
    may_move &= !has_fault(&machine);
    for call in calls {
        // Longer than a restart.
        for _ in 0..gap / 4 {
            machine.drive_at(&goal, 1);
            may_move &= !has_fault(&machine);
        }
        let Some(call) = call else { continue };
        let answer = machine.call(call);
        match call {
            Call::Enable | Call::Resume if answer.is_ok() => (may_move, wants_off) = (true, false),
            Call::Stop | Call::Halt => may_move = false,
            Call::Disable => (may_move, wants_off) = (false, true),
            _ => {}
        }
        answers.push(answer.is_ok());
    }
    for _ in 0..250 {
        machine.drive_at(&goal, 1);
        may_move &= !has_fault(&machine);
    }
    let from = [0, 1].map(|axis| machine.travel(axis));
    let mark = machine.mark();
    machine.drive_at(&goal, 20);
    let case = format!(
        "{stage:?}, {trouble:?} with {reaction:?}, {}, {calls:?} {answers:?} {} cycles apart",
        if is_position { "position" } else { "speed" },
        gap / 4
    );
    let mut found = Vec::new();
    for (axis, from) in from.into_iter().enumerate() {
        let moved = machine.travel(axis) - from;
        let (on, believed) = (machine.energised(axis), machine.believed_on(axis));
        let fault = machine.fault(axis);
        if on && moved.abs() > 10 && !may_move {
            found.push(format!("{case}: wheel {axis} moves, and nobody said so"));
        }
        if wants_off && on {
            found.push(format!("{case}: wheel {axis} was disabled and is on"));
        }
        if fault.is_none() && on != believed {
            let is = |on: bool| if on { "on" } else { "off" };
            found.push(format!(
                "{case}: wheel {axis} is {} and the master says {}",
                is(on),
                is(believed)
            ));
        }
        let commands = machine.commands_since(mark, axis).len();
        if fault.is_none() && commands == 0 {
            found.push(format!(
                "{case}: wheel {axis} has no fault and gets no frame"
            ));
        }
    }
    found
}

fn broken_wheels_at(stage: Stage, one_of: usize) -> Vec<String> {
    let mut found = Vec::new();
    for (number, trouble) in WHEEL_TROUBLES.into_iter().enumerate() {
        for is_position in [false, true] {
            let first = (number + usize::from(is_position)) % one_of;
            for (place, (calls, gap)) in pairs().enumerate().skip(first).step_by(one_of) {
                let reactions = [Reaction::Halt, Reaction::RampDown, Reaction::Disable];
                let reaction = reactions[(place + usize::from(is_position)) % 3];
                found.extend(one_wheel_case(
                    stage,
                    is_position,
                    reaction,
                    trouble,
                    calls,
                    gap,
                ));
            }
        }
    }
    summary(&found)
}

/// Beyond the list: the same for wheels, in both modes.
mod wheels_know_their_power_and_move_only_by_a_word {
    use super::{ONE_OF, Stage, assert_none, broken_wheels_at};

    in_each_stage!(|stage| assert_none(&broken_wheels_at(stage, 2 * ONE_OF)));
}

/// Every pair of calls, for servos and wheels.
#[test]
#[ignore = "takes minutes: cargo test -p host-tests --release --test findings -- --ignored every_pair"]
fn every_pair_of_calls_behind_every_trouble_in_every_stage() {
    let servos = STAGES.into_iter().flat_map(|stage| broken_at(stage, 1));
    let wheels = STAGES
        .into_iter()
        .flat_map(|stage| broken_wheels_at(stage, 1));
    assert_none(&servos.chain(wheels).collect::<Vec<_>>());
}
