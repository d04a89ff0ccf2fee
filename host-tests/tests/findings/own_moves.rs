//! Motions that drives make by themselves: what the drives were told, where they went, and what the axis says.

use can_motion::facts::Motion;
use can_motion::{
    AxisState, DriveMove, EventKind, Fault, MoveError, MoveRefusal, Outcome, Procedure, Reason,
    Sink, WaveShape,
};
use dyn_can::{
    Counts28, DataFrame, FunctionCode, MaxAcceleration, MaxSpeed, ParamGroup2, Request, ServoMode,
    SpeedRpm,
};

use crate::support::servos::{Servo, Servos, Told, servo, servos};
use crate::support::{Call, id_of};
use embedded_can::Frame as _;

/// MaxSpd 20 and MaxAcl 10: 110,235 counts a second, 1,736,103 counts per second squared.
fn slow_curve() -> ParamGroup2 {
    ParamGroup2 {
        max_speed: MaxSpeed::new(20).unwrap(),
        max_acceleration: MaxAcceleration::new(10).unwrap(),
    }
}

pub(crate) fn slow_servo(id: i32) -> Servo {
    servo(id).drive(|drive| drive.group2 = slow_curve())
}

/// Axes that hold, with the curves of their drives read.
pub(crate) fn holding(servos: &[Servo]) -> Servos {
    let mut machine = Servos::streaming(servos);
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    for axis in 0..machine.drives() {
        machine.start(axis, Procedure::ReadGroup2).unwrap();
    }
    machine.run(40);
    machine
}

pub(crate) fn held(count: i32) -> Servos {
    let servos: Vec<Servo> = (1..=count).map(slow_servo).collect();
    holding(&servos)
}

impl Servos {
    pub(crate) fn lets_move(
        &mut self,
        axis: usize,
        wanted: DriveMove,
    ) -> Result<(), MoveError<Fault>> {
        let now = self.0.now();
        self.0.master.start_move(now, axis, wanted)
    }

    pub(crate) fn lets_move_together(
        &mut self,
        moves: &[(usize, DriveMove)],
    ) -> Result<(), MoveError<Fault>> {
        let now = self.0.now();
        self.0.master.start_moves(now, moves)
    }

    /// Another master moves the drive of an axis that holds by so many counts.
    fn rests_beside(&mut self, axis: usize, counts: i32) {
        let stranger = self.add_stranger();
        let by = Counts28::new(counts).unwrap();
        self.stranger_asks(stranger, axis, Request::GoRelativePosPtp(by));
        self.run(300);
        assert_eq!(
            (self.fault(axis), self.position(axis)),
            (None, counts.into())
        );
    }

    pub(crate) fn position(&self, axis: usize) -> i64 {
        self.0.drive(axis).position_counts(self.now_ns())
    }

    pub(crate) fn state(&self, axis: usize) -> AxisState {
        self.0.state(axis)
    }

    fn axis_sent(&self, axis: usize) -> i64 {
        self.0.axis(axis).sent_counts.into()
    }

    fn motion(&self, axis: usize) -> Motion {
        self.0.axis(axis).facts.motion
    }

    /// Commands to an axis since a mark.
    fn told_own(&self, mark: usize, axis: usize) -> Vec<Told> {
        self.commands_since(mark, axis)
    }

    /// Cycles until an axis is in a state; how many.
    #[track_caller]
    pub(crate) fn until(&mut self, axis: usize, state: AxisState) -> usize {
        for cycle in 0..20_000 {
            if self.state(axis) == state {
                return cycle;
            }
            self.run(1);
        }
        panic!(
            "axis {axis} does not become {state}, it is {}, {:?}",
            self.state(axis),
            self.0.axis(axis)
        );
    }

    /// Why an axis last changed its state.
    fn last_reason(&self, axis: u8) -> Option<(AxisState, Reason)> {
        let events = self.0.events.iter().rev();
        events
            .filter(|event| event.axis == Some(axis))
            .find_map(|event| match event.kind {
                EventKind::State { to, reason, .. } => Some((to, reason)),
                _ => None,
            })
    }
}

fn refusal(result: Result<(), MoveError<Fault>>) -> MoveRefusal {
    match result {
        Err(MoveError::Refused { refusal, .. }) => refusal,
        other => panic!("not refused by the drive: {other:?}"),
    }
}

#[test]
fn a_move_arrives_and_the_axis_streams_on_from_there() {
    for (wanted, end, frame) in [
        (
            DriveMove::To(20_000),
            20_000,
            FunctionCode::GoAbsolutePosPtp,
        ),
        (
            DriveMove::By(-20_000),
            -20_000,
            FunctionCode::GoRelativePosPtp,
        ),
    ] {
        let mut machine = held(1);
        let mark = machine.mark();
        machine.lets_move(0, wanted).unwrap();
        machine.until(0, AxisState::DriveMoving);
        let cycles = machine.until(0, AxisState::Holding);
        assert_eq!(
            machine.last_reason(0),
            Some((AxisState::Holding, Reason::MoveEnded))
        );
        // 20000 counts take 245 ms by the curve; two polls of 20 ms show the end.
        assert!((245..330).contains(&cycles), "{cycles} ms");
        assert_eq!(machine.position(0), end);
        assert_eq!(machine.told_own(mark, 0), [Told::Own(frame, end as i32)]);
        assert_eq!(machine.target(0), end as i32);
        // No jump and no count lost: the same counts back by streaming.
        machine.call(Call::Resume).unwrap();
        machine.0.run_until(AxisState::Streaming);
        let mark = machine.mark();
        machine.run(3);
        assert_eq!(machine.steps_since(mark, 0).iter().sum::<i32>(), 0);
        let step = if end > 0 { -20 } else { 20 };
        machine.move_all(&[step], 1_000);
        machine.run(400);
        assert_eq!((machine.fault(0), machine.position(0)), (None, 0));
        machine.call(Call::Stop).unwrap();
        machine.0.run_until(AxisState::Holding);
    }
}

#[test]
fn what_holds_and_was_not_asked_stays_while_another_moves() {
    let mut machine = held(2);
    machine.lets_move(1, DriveMove::To(5_000)).unwrap();
    machine.until(1, AxisState::DriveMoving);
    assert_eq!(machine.state(0), AxisState::Holding);
    let refused = machine.call(Call::Resume).unwrap_err();
    assert_eq!(refused, "axis 1 must be holding, it is moving by itself");
    machine.until(1, AxisState::Holding);
    assert_eq!((machine.position(0), machine.position(1)), (0, 5_000));
}

#[test]
fn a_stop_ends_a_move_where_the_drive_can_stop() {
    for call in [Call::Stop, Call::Halt, Call::Disable] {
        for (direction, after) in [(1, 60), (-1, 60), (1, 3), (1, 500), (-1, 900)] {
            let end = direction * 100_000;
            let mut machine = held(1);
            machine.lets_move(0, DriveMove::To(end)).unwrap();
            machine.until(0, AxisState::DriveMoving);
            machine.run(after);
            let (before, mark) = (machine.position(0), machine.mark());
            machine.call(call).unwrap();
            let last = match call {
                Call::Disable => AxisState::Ready,
                _ => AxisState::Holding,
            };
            machine.until(0, last);
            let at = machine.position(0);
            let direction = i64::from(direction);
            // It never comes back, and stops within what it needs at full speed and 30 ms.
            let went = (at - before) * direction;
            assert!(
                (0..=3_500 + 3_400).contains(&went),
                "{call:?} {after}: {before} {at}"
            );
            let told = machine.told_own(mark, 0);
            assert!(
                matches!(
                    told.first(),
                    Some(&Told::Own(FunctionCode::GoAbsolutePosPtp, _))
                ),
                "{told:?}"
            );
            assert_eq!(machine.fault(0), None);
            if call != Call::Disable {
                // Where it stopped is where it streams on from.
                machine.call(Call::Resume).unwrap();
                machine.0.run_until(AxisState::Streaming);
                machine.run(300);
                assert_eq!((machine.position(0), machine.fault(0)), (at, None));
            }
        }
    }
}

#[test]
fn a_stop_before_the_command_left_lets_nothing_move() {
    let mut machine = held(1);
    let mark = machine.mark();
    machine.freeze_adapter(true);
    machine.lets_move(0, DriveMove::To(5_000)).unwrap();
    machine.run(2);
    machine.call(Call::Stop).unwrap();
    machine.freeze_adapter(false);
    machine.run(100);
    assert_eq!(machine.told_own(mark, 0), []);
    assert_eq!(
        (machine.state(0), machine.position(0)),
        (AxisState::Holding, 0)
    );
}

/// A controller with one mailbox that hands nothing back on request, and displaces what is less urgent.
struct Mailbox(Option<DataFrame>);

impl Sink<DataFrame> for Mailbox {
    fn offer(&mut self, frame: &DataFrame) -> Outcome<DataFrame> {
        match self.0 {
            Some(held) if held.id() <= frame.id() => Outcome::Full,
            Some(held) => {
                self.0 = Some(*frame);
                Outcome::Displaced(held)
            }
            None => {
                self.0 = Some(*frame);
                Outcome::Accepted
            }
        }
    }
}

#[test]
fn a_stop_that_displaced_its_move_does_not_move_the_drive_itself() {
    for by in [500, -500] {
        let mut machine = held(1);
        let mut mailbox = Mailbox(None);
        machine.lets_move(0, DriveMove::By(by)).unwrap();
        let send = |machine: &mut Servos, mailbox: &mut Mailbox| {
            let now = machine.0.now();
            machine.0.master.begin_cycle(now);
            let _ = can_motion::BusUser::send(&mut machine.0.master, now, mailbox);
            machine.hang(1);
        };
        send(&mut machine, &mut mailbox);
        assert_eq!(mailbox.0.map(|frame| frame.id()), Some(0x023));
        // The bus is busy with others: as far as the master knows, the drive moves.
        machine.hang(20);
        machine.call(Call::Stop).unwrap();
        send(&mut machine, &mut mailbox);
        let stop = mailbox.0.take().unwrap();
        assert_eq!(stop.id(), 0x021);
        // The drive has never heard of the move, and now of its stop. It is told at once to be where it is.
        let mark = machine.mark();
        machine.run(200);
        let stay = Told::Own(FunctionCode::GoAbsolutePosPtp, 0);
        assert_eq!(machine.told_own(mark, 0), [stay]);
        assert_eq!(machine.state(0), AxisState::Holding);
    }
}

/// The command of a move displaces the last set-point of the ramp before it: the drive begins elsewhere than the axis thought.
#[test]
fn a_move_that_displaced_a_set_point_ends_where_its_axis_says() {
    for wanted in [DriveMove::By(400), DriveMove::By(-400), DriveMove::To(400)] {
        let mut machine = holding(&[slow_servo(1).unwatched().ramp_change(40)]);
        machine.call(Call::Resume).unwrap();
        machine.0.run_until(AxisState::Streaming);
        let stranger = machine.add_stranger();
        let mut mailbox = Mailbox(None);
        for cycle in 1..100 {
            let now = machine.0.now();
            machine.0.master.begin_cycle(now);
            match cycle {
                ..=20 => machine.0.master.set_target(0, cycle * 60).unwrap(),
                21 => machine.call(Call::Stop).unwrap(),
                _ => {}
            }
            if machine.state(0) == AxisState::Holding {
                break;
            }
            if let Some(frame) = mailbox.0.take() {
                machine.stranger_sends(stranger, frame.id(), frame.data());
            }
            let _ = can_motion::BusUser::send(&mut machine.0.master, now, &mut mailbox);
            machine.hang(1);
        }
        // 30 counts.
        assert_eq!(
            mailbox.0,
            DataFrame::new(0x03C, &[0x1E]).ok(),
            "the last of the ramp"
        );
        machine.lets_move(0, wanted).unwrap();
        let now = machine.0.now();
        machine.0.master.begin_cycle(now);
        let _ = can_motion::BusUser::send(&mut machine.0.master, now, &mut mailbox);
        let frame = mailbox.0.take().unwrap();
        machine.stranger_sends(stranger, frame.id(), frame.data());
        machine.hang(1);
        machine.until(0, AxisState::Holding);
        machine.run(500);
        assert_eq!(machine.axis_sent(0), machine.position(0));
    }
}

#[test]
fn a_command_that_was_lost_times_out_and_says_so() {
    let mut machine = held(1);
    machine.lose_moves(0, 1);
    machine.lets_move(0, DriveMove::To(20_000)).unwrap();
    machine.until(0, AxisState::DriveMoving);
    for _ in 0..2_000 {
        if machine.fault(0).is_some() {
            break;
        }
        machine.run(1);
    }
    assert_eq!(
        machine.fault(0),
        Some(Fault::NotArrived { counts: -20_000 })
    );
    machine.until(0, AxisState::Faulted);
    assert_eq!(machine.position(0), 0);
    machine.call(Call::Clear).unwrap();
    machine.0.run_until(AxisState::Holding);
}

#[test]
fn a_drive_that_is_slower_than_it_says_times_out_and_is_stopped() {
    let mut machine = held(1);
    // Somebody else lets it crawl: 3334 counts a second.
    let crawl = ParamGroup2 {
        max_speed: MaxSpeed::MIN,
        max_acceleration: MaxAcceleration::MIN,
    };
    let stranger = machine.add_stranger();
    machine.stranger_sends(
        stranger,
        0x31,
        &[crawl.max_speed.get(), crawl.max_acceleration.get()],
    );
    machine.run(2);
    machine.lets_move(0, DriveMove::To(20_000)).unwrap();
    for _ in 0..3_000 {
        if machine.fault(0).is_some() {
            break;
        }
        machine.run(1);
    }
    assert!(
        matches!(
            machine.fault(0),
            Some(Fault::NotArrived {
                counts: -19_999..=-10_000
            })
        ),
        "{:?}",
        machine.fault(0)
    );
    assert_eq!(machine.state(0), AxisState::DriveStopping);
    machine.until(0, AxisState::Faulted);
    let at = machine.position(0);
    machine.run(500);
    assert_eq!(machine.position(0), at);
    assert!(at < 20_000);
}

#[test]
fn moves_start_together_by_one_trigger() {
    for (kind, load, trigger) in [
        (
            DriveMove::To as fn(i32) -> DriveMove,
            FunctionCode::GoAbsolutePosSync,
            0xFF_u8,
        ),
        (DriveMove::By, FunctionCode::GoRelativePosSync, 0xEE),
    ] {
        let mut machine = held(3);
        let mark = machine.mark();
        machine
            .lets_move_together(&[(0, kind(3_000)), (2, kind(-4_000))])
            .unwrap();
        machine.until(0, AxisState::Loaded);
        machine.until(0, AxisState::DriveMoving);
        assert_eq!(machine.motion(2), Motion::DriveMove);
        machine.until(0, AxisState::Holding);
        machine.until(2, AxisState::Holding);
        let positions = [0, 1, 2].map(|axis| machine.position(axis));
        assert_eq!(positions, [3_000, 0, -4_000]);
        assert_eq!(machine.told_own(mark, 0), [Told::Own(load, 3_000)]);
        assert_eq!(machine.told_own(mark, 1), []);
        let triggers: Vec<Vec<u8>> = machine
            .frames_since(mark)
            .filter(|record| id_of(record) == 0x018)
            .map(|record| record.frame.data().to_vec())
            .collect();
        assert_eq!(triggers, [[trigger]]);
        // Both started in the same millisecond: the trigger is one frame.
        machine.call(Call::Resume).unwrap();
        machine.0.run_until(AxisState::Streaming);
        machine.run(300);
        assert_eq!([0, 1, 2].map(|axis| machine.fault(axis)), [None; 3]);
    }
}

/// The trigger has the lowest identifier of all: in mailboxes that are sorted it would overtake the moves that it starts.
#[test]
fn the_trigger_waits_for_the_moves_also_where_frames_are_sorted() {
    let line = crate::support::servos::line().by_identifier();
    let mut machine = Servos::on(line, &[slow_servo(1), slow_servo(2)]);
    machine.stream();
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    for axis in 0..2 {
        machine.start(axis, Procedure::ReadGroup2).unwrap();
    }
    machine.run(40);
    let mark = machine.mark();
    machine
        .lets_move_together(&[(0, DriveMove::To(1_000)), (1, DriveMove::To(2_000))])
        .unwrap();
    machine.until(0, AxisState::DriveMoving);
    machine.run(1);
    let order: Vec<u16> = machine
        .frames_since(mark)
        .map(id_of)
        .filter(|id| [0x018, 0x036, 0x056].contains(id))
        .collect();
    assert_eq!(order.last(), Some(&0x018), "{order:X?}");
    assert_eq!(order.len(), 3);
    machine.until(1, AxisState::Holding);
    assert_eq!((machine.position(0), machine.position(1)), (1_000, 2_000));
}

/// A loaded move that is not wanted any more keeps its axis from every trigger until the drive is off.
#[test]
fn nothing_loaded_is_left_for_a_later_trigger() {
    let mut machine = held(2);
    // The answers to the loads do not come, so the trigger does not go out.
    machine.faults_mut(0).drop_next_replies(1);
    machine
        .lets_move_together(&[(0, DriveMove::By(500)), (1, DriveMove::By(500))])
        .unwrap();
    machine.until(0, AxisState::Loaded);
    machine.until(1, AxisState::Loaded);
    machine.call(Call::Stop).unwrap();
    machine.run(100);
    assert_eq!([machine.state(0), machine.state(1)], [AxisState::Loaded; 2]);
    assert_eq!(
        machine.call(Call::Resume).unwrap_err(),
        "axis 0 must be holding, it is loaded for a trigger"
    );
    let again = machine.lets_move(0, DriveMove::By(500)).unwrap_err();
    assert_eq!(
        again.to_string(),
        "axis 0 must be holding, it is loaded for a trigger"
    );
    machine.call(Call::Disable).unwrap();
    machine.0.run_until(AxisState::Ready);
    assert_eq!([machine.position(0), machine.position(1)], [0, 0]);
    // On again: what the drive of axis 1 keeps is not documented, so a trigger for axis 0 alone is refused.
    machine.call(Call::Enable).unwrap();
    machine.0.run_until(AxisState::Streaming);
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    for axis in 0..2 {
        machine.start(axis, Procedure::ReadGroup2).unwrap();
    }
    machine.run(40);
    let alone = machine.lets_move_together(&[(0, DriveMove::By(500))]);
    assert_eq!(alone, Err(MoveError::OldLoad { axis: 1 }));
    machine
        .lets_move_together(&[(0, DriveMove::By(500)), (1, DriveMove::By(0))])
        .unwrap();
    machine.until(0, AxisState::DriveMoving);
    machine.until(0, AxisState::Holding);
    machine.until(1, AxisState::Holding);
    assert_eq!([machine.position(0), machine.position(1)], [500, 0]);
}

#[test]
fn moves_that_do_not_belong_together_are_refused() {
    let mut machine = held(2);
    let (one, other) = ((0, DriveMove::To(1)), (1, DriveMove::To(2)));
    for moves in [
        &[] as &[(usize, DriveMove)],
        &[one, one],
        &[one, (1, DriveMove::By(2))],
    ] {
        assert_eq!(
            machine.lets_move_together(moves),
            Err(MoveError::NotTogether),
            "{moves:?}"
        );
    }
    let far = machine.lets_move_together(&[one, (7, DriveMove::To(2))]);
    assert_eq!(far, Err(MoveError::NoSuchAxis { axes: 2, actual: 7 }));
    let turning = machine.lets_move_together(&[(0, DriveMove::Speed(10)), other]);
    assert_eq!(refusal(turning), MoveRefusal::Unsupported);
    machine.run(20);
    assert_eq!(
        [0, 1].map(|axis| machine.state(axis)),
        [AxisState::Holding; 2]
    );
}

#[test]
fn limits_of_the_axis_hold_for_what_its_drive_does_by_itself() {
    let narrow = || slow_servo(1).travel(-1_000, 1_000);
    let mut machine = holding(&[narrow()]);
    for (wanted, actual) in [
        (DriveMove::To(1_001), 1_001),
        (DriveMove::To(-1_001), -1_001),
        (DriveMove::By(1_001), 1_001),
        (DriveMove::By(-1_001), -1_001),
    ] {
        let expected = MoveRefusal::Travel {
            min: -1_000,
            max: 1_000,
            actual,
        };
        assert_eq!(
            refusal(machine.lets_move(0, wanted)),
            expected,
            "{wanted:?}"
        );
    }
    // A wave of amplitude 512 swings 1024 counts to either side.
    let wave = DriveMove::Wave {
        shape: WaveShape::Sine,
        amplitude: 512,
        frequency_hz: 1,
    };
    assert!(matches!(
        refusal(machine.lets_move(0, wave)),
        MoveRefusal::Travel { .. }
    ));
    // 110,235 counts a second are 111 in a cycle.
    let mut machine = holding(&[slow_servo(1).max_step(110)]);
    let expected = MoveRefusal::TooFast {
        most: 110,
        actual: 111,
    };
    assert_eq!(
        refusal(machine.lets_move(0, DriveMove::To(50_000))),
        expected
    );
    // A short move does not get so fast.
    machine.lets_move(0, DriveMove::To(2_000)).unwrap();
    machine.until(0, AxisState::DriveMoving);
    machine.until(0, AxisState::Holding);
    // 1,736,104 counts per second squared are 444.4/256 in a cycle and cycle.
    let mut machine = holding(&[slow_servo(1).ramp_change(1)]);
    let expected = MoveRefusal::TooSudden {
        most: 256,
        actual: 445,
    };
    assert_eq!(refusal(machine.lets_move(0, DriveMove::To(10))), expected);
    assert_eq!(machine.state(0), AxisState::Holding);
}

#[test]
fn ranges_of_the_protocol_hold() {
    let mut machine = held(1);
    let wave = |amplitude, frequency_hz| DriveMove::Wave {
        shape: WaveShape::Square,
        amplitude,
        frequency_hz,
    };
    for (wanted, min, max) in [
        (DriveMove::By(1 << 27), 1, (1 << 27) - 1),
        (DriveMove::By(i32::MIN), 1, (1 << 27) - 1),
        (DriveMove::Speed(0), 1, 20_000),
        (DriveMove::Speed(20_001), 1, 20_000),
        (DriveMove::Speed(-20_001), 1, 20_000),
        (DriveMove::Speed(i32::MIN), 1, 20_000),
        (wave(0, 1), 1, 4_096),
        (wave(-1, 1), 1, 4_096),
        (wave(4_097, 1), 1, 4_096),
        (wave(1, 0), 1, 50),
        (wave(1, 51), 1, 50),
    ] {
        let refused = refusal(machine.lets_move(0, wanted));
        let is_range =
            matches!(refused, MoveRefusal::Range { min: a, max: b, .. } if (a, b) == (min, max));
        assert!(is_range, "{wanted:?}: {refused:?}");
    }
    for far in [1 << 27, i32::MIN, i32::MAX] {
        let refused = refusal(machine.lets_move(0, DriveMove::To(far)));
        assert!(matches!(refused, MoveRefusal::Travel { .. }), "{refused:?}");
    }
}

#[test]
fn without_its_curve_a_drive_is_not_told_to_move() {
    let mut machine = Servos::streaming(&[slow_servo(1)]);
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    let expected = MoveRefusal::CurveUnknown;
    assert_eq!(refusal(machine.lets_move(0, DriveMove::To(10))), expected);
    // Given, it need not be read.
    let mut machine = Servos::streaming(&[slow_servo(1).curve(slow_curve())]);
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    machine.lets_move(0, DriveMove::To(10)).unwrap();
}

#[test]
fn each_command_in_each_state_has_an_answer() {
    let mut machine = Servos::new(&[slow_servo(1)]);
    let asked = |machine: &mut Servos| {
        machine
            .lets_move(0, DriveMove::To(10))
            .map_err(|error| error.to_string())
    };
    let state = |name: &str| Err(format!("axis 0 must be holding, it is {name}"));
    assert_eq!(asked(&mut machine), state("waiting for power-on"));
    machine.become_ready();
    assert_eq!(asked(&mut machine), state("ready"));
    machine.call(Call::Enable).unwrap();
    machine.0.run_until(AxisState::Streaming);
    assert_eq!(asked(&mut machine), state("streaming"));
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    machine.start(0, Procedure::ReadGroup2).unwrap();
    assert_eq!(
        asked(&mut machine),
        Err("a procedure of axis 0 is under way: wait for its end".into())
    );
    machine.run(40);
    machine.lets_move(0, DriveMove::To(50_000)).unwrap();
    machine.until(0, AxisState::DriveMoving);
    assert_eq!(asked(&mut machine), state("moving by itself"));
    for call in [Call::Enable, Call::Resume, Call::Adopt, Call::Clear] {
        assert!(machine.call(call).is_err(), "{call:?}");
    }
    assert!(!machine.set_target(0, 5));
    assert!(machine.start(0, Procedure::ReadGroup1).is_err());
    machine.call(Call::Stop).unwrap();
    assert_eq!(machine.state(0), AxisState::DriveStopping);
    assert_eq!(asked(&mut machine), state("ending its own motion"));
    machine.until(0, AxisState::Holding);
    machine.bus_off();
    assert_eq!(
        asked(&mut machine),
        Err("the bus is off: recover the controller first".into())
    );
    machine.bus_recovered();
    assert_eq!(
        asked(&mut machine),
        Err("axis 0 has a fault (the bus failed, the fate of the latest set-points is unknown): remove the cause, then clear it".into())
    );
}

#[test]
fn constant_speed_ends_and_the_drive_comes_back_to_position_mode() {
    for (revision, writes) in [(dyn_can::Revision::V1_6A, 1), (dyn_can::Revision::V1_2A, 0)] {
        let dialect = dyn_can::Dialect::of(revision);
        let one = slow_servo(1).drive(|drive| drive.dialect = dialect);
        let mut machine = holding(&[one]);
        let mark = machine.mark();
        machine.lets_move(0, DriveMove::Speed(-120)).unwrap();
        machine.until(0, AxisState::DriveMoving);
        machine.run(1_500);
        assert_eq!(machine.state(0), AxisState::DriveMoving);
        let rpm = machine.0.drive(0).speed_rpm(machine.now_ns());
        assert!((rpm + 120.0).abs() < 1.0, "{rpm}");
        machine.call(Call::Stop).unwrap();
        let last = if writes == 1 {
            AxisState::Ready
        } else {
            AxisState::Holding
        };
        machine.until(0, last);
        let told = machine.told_own(mark, 0);
        let (speed, off) = (FunctionCode::TurnConstSpeed, FunctionCode::SetDriveConfig);
        assert_eq!(told.first(), Some(&Told::Own(speed, -120)));
        assert_eq!(told.get(1), Some(&Told::Own(speed, 0)));
        let back: Vec<_> = told
            .iter()
            .filter(|told| !matches!(told, Told::Own(..)))
            .collect();
        if writes == 1 {
            assert_eq!(back, [&Told::Off, &Told::Write(off)]);
        } else {
            assert!(back.is_empty(), "{back:?}");
        }
        assert_eq!(machine.fault(0), None);
        assert_eq!(machine.eeprom_writes_counted(0), writes);
        let mode = machine
            .0
            .drive(0)
            .config_byte()
            .config()
            .unwrap()
            .servo_mode;
        assert_eq!(mode, ServoMode::Position);
        let stopped = machine.position(0);
        if writes == 1 {
            machine.call(Call::Enable).unwrap();
        } else {
            machine.call(Call::Resume).unwrap();
        }
        machine.0.run_until(AxisState::Streaming);
        machine.run(300);
        assert_eq!((machine.fault(0), machine.position(0)), (None, stopped));
    }
}

#[test]
fn constant_speed_is_stopped_before_the_end_of_the_travel() {
    for sign in [1, -1] {
        let mut machine = holding(&[slow_servo(1).travel(-60_000, 60_000)]);
        machine.lets_move(0, DriveMove::Speed(sign * 120)).unwrap();
        machine.until(0, AxisState::DriveMoving);
        for _ in 0..5_000 {
            if machine.fault(0).is_some() {
                break;
            }
            machine.run(1);
        }
        assert!(
            matches!(machine.fault(0), Some(Fault::TravelEnd { .. })),
            "{:?}",
            machine.fault(0)
        );
        machine.run(3_000);
        let at = machine.position(0) * i64::from(sign);
        assert!((20_000..=60_000).contains(&at), "{at}");
        assert!(!machine.energised(0), "off to leave speed mode");
    }
    // No room to stop at all.
    let mut machine = holding(&[slow_servo(1).travel(-20_000, 20_000)]);
    let refused = refusal(machine.lets_move(0, DriveMove::Speed(120)));
    assert!(matches!(refused, MoveRefusal::Travel { .. }), "{refused:?}");
}

/// A drive that turns the other way comes to the other end of the travel.
#[test]
fn constant_speed_is_stopped_before_either_end_of_the_travel() {
    for sign in [1, -1] {
        let mut machine = holding(&[slow_servo(1).travel(-60_000, 60_000)]);
        let stranger = machine.add_stranger();
        machine.lets_move(0, DriveMove::Speed(sign * 120)).unwrap();
        machine.until(0, AxisState::DriveMoving);
        let other = SpeedRpm::new(-sign * 120).unwrap();
        machine.stranger_asks(stranger, 0, Request::TurnConstSpeed(other));
        for _ in 0..5_000 {
            if machine.fault(0).is_some() {
                break;
            }
            machine.run(1);
        }
        assert!(
            matches!(machine.fault(0), Some(Fault::TravelEnd { .. })),
            "{:?}",
            machine.fault(0)
        );
        machine.run(3_000);
        let at = machine.position(0) * i64::from(-sign);
        assert!((20_000..=60_000).contains(&at), "{at}");
    }
}

/// An axis that holds at the end of its travel, its shaft a little outside.
#[test]
fn constant_speed_leads_away_from_an_end_beside_which_the_drive_rests() {
    for (sign, travel) in [(1, (0, 300_000)), (-1, (-300_000, 0))] {
        let mut machine = holding(&[slow_servo(1).travel(travel.0, travel.1)]);
        machine.rests_beside(0, -10 * sign);
        machine.lets_move(0, DriveMove::Speed(sign * 120)).unwrap();
        machine.until(0, AxisState::DriveMoving);
        machine.run(500);
        assert_eq!(machine.fault(0), None);
    }
}

#[test]
fn a_short_move_of_a_drive_that_rests_beside_its_set_point_arrives() {
    for sign in [1, -1] {
        for by in [1, 4, 8, 12, 19] {
            let mut machine = held(1);
            // 10 counts are within the tolerance of 16.
            machine.rests_beside(0, -10 * sign);
            machine.lets_move(0, DriveMove::By(sign * by)).unwrap();
            machine.until(0, AxisState::DriveMoving);
            machine.until(0, AxisState::Holding);
            assert_eq!(machine.fault(0), None, "{by}");
            assert_eq!(machine.axis_sent(0), i64::from(sign * by));
        }
    }
}

#[test]
fn a_load_that_can_fall_is_not_turned_at_constant_speed() {
    let range = |drive: &mut drive_sim::DynDriveConfig| {
        drive.group3.on_pos_range = dyn_can::OnPosRange::MAX;
    };
    let mut machine = holding(&[slow_servo(1).load_can_fall().drive(range)]);
    let refused = refusal(machine.lets_move(0, DriveMove::Speed(120)));
    assert_eq!(refused, MoveRefusal::LoadCanFall);
    machine.lets_move(0, DriveMove::To(120)).unwrap();
}

#[test]
fn a_wave_swings_until_it_is_stopped_and_ends_at_its_base() {
    for (shape, amplitude, hertz, function) in [
        (WaveShape::Sine, 300, 5, FunctionCode::SinWave),
        (WaveShape::Square, 8, 10, FunctionCode::SquareWave),
    ] {
        let mut machine = held(1);
        machine.lets_move(0, DriveMove::To(1_000)).unwrap();
        machine.until(0, AxisState::DriveMoving);
        machine.until(0, AxisState::Holding);
        let mark = machine.mark();
        let wave = DriveMove::Wave {
            shape,
            amplitude,
            frequency_hz: hertz,
        };
        machine.lets_move(0, wave).unwrap();
        machine.until(0, AxisState::DriveMoving);
        let (mut least, mut most) = (i64::MAX, i64::MIN);
        for _ in 0..1_000 {
            machine.run(1);
            least = least.min(machine.position(0));
            most = most.max(machine.position(0));
        }
        assert!(least < 1_000 && most > 1_000, "{least} {most}");
        assert_eq!(machine.fault(0), None);
        machine.call(Call::Stop).unwrap();
        machine.until(0, AxisState::Holding);
        assert_eq!(machine.position(0), 1_000);
        let told = machine.told_own(mark, 0);
        let frequency = |hertz| Told::Own(FunctionCode::SsFrequency, hertz);
        let expected = [
            frequency(hertz),
            Told::Own(function, amplitude),
            Told::Own(function, 0),
            frequency(0),
        ];
        assert_eq!(told[..4], expected, "{told:?}");
        assert_eq!(
            machine.last_reason(0),
            Some((AxisState::Holding, Reason::MoveEnded))
        );
    }
}

#[test]
fn the_cases_of_the_default_servo_are_moved_too() {
    // A drive as it leaves the factory, with its own maximum speed.
    let mut machine = holding(&servos(1));
    machine.lets_move(0, DriveMove::To(16_384)).unwrap();
    machine.until(0, AxisState::DriveMoving);
    machine.until(0, AxisState::Holding);
    assert_eq!(machine.position(0), 16_384);
}
