//! The family of the example: what a family gets that says nothing of its own.

#[path = "../../examples/third_family.rs"]
#[allow(
    dead_code,
    missing_docs,
    unreachable_pub,
    unfulfilled_lint_expectations,
    reason = "a program of its own"
)]
mod third_family;

use can_motion::facts::{Brake, Facts};
use can_motion::family::{
    CycleConfig, CycleUs, Drive, Family, Outlook, Plan, ValueLimits, View, Wanted,
};
use can_motion::{AxisState, DriveMove, GroupId, Instant, Master, MoveRefusal, Reaction, Stage};
use third_family::{SimulatedToy, Toy, ToyAxis, ToyFault, cycle};

const LIMITS: ValueLimits = ValueLimits::new(0, 500, 10, 2);
const CYCLE: CycleUs = CycleUs(1_000);

#[test]
fn two_drives_of_the_example_go_where_they_are_told() {
    let axes = [1, 2].map(|drive| ToyAxis {
        drive,
        limits: LIMITS,
    });
    let mut drives = [SimulatedToy::default(), SimulatedToy::default()];
    let mut master = Master::<2, Toy>::new(CYCLE, &axes).expect("axes that work");
    let mut states = Vec::new();
    for ms in 0..400 {
        let now = Instant::from_us(ms * 1_000);
        match ms {
            50 => master.enable(now, GroupId(0)).expect("a ready group"),
            150 => master.set_target(1, 500).expect("a streaming axis"),
            180 => master.stop(now, GroupId(0)),
            250 => master.disable(now, GroupId(0)),
            _ => {}
        }
        cycle(&mut master, &mut drives, now);
        let state = master.state(1).expect("an axis");
        if states.last() != Some(&state) {
            states.push(state);
        }
    }
    // The drives are asked in turn: each step of the second is one answer of both away from the next.
    let life = [
        AxisState::PowerOn,
        AxisState::Ready,
        AxisState::Probing,
        AxisState::Enabling,
        AxisState::Streaming,
        AxisState::RampingDown,
        AxisState::Holding,
        AxisState::Disabling,
        AxisState::Ready,
    ];
    assert_eq!(states, life);
    assert_eq!((drives[0].position, drives[1].position), (0, 320));
    assert!(!drives[0].is_on && !drives[1].is_on);
}

#[test]
fn settings_that_were_refused_are_not_admitted() {
    let axes = [2, 1].map(|drive| ToyAxis {
        drive,
        limits: LIMITS,
    });
    let refused = Master::<2, Toy>::new(CYCLE, &axes).map(|_| ());
    assert_eq!(
        refused,
        Err("give 1 to 8 axes in ascending order of drive, each with a step")
    );
    assert_eq!(Toy::plan(&CYCLE, &axes).warnings().count(), 0);
    let frame = can_frame::DataFrame::new(0x123, &[]).expect("an identifier of 11 bits");
    assert_eq!(Toy::foreign(&frame), None);
    assert!(!Toy::is_trigger(&frame));
    assert_eq!(Toy::frame_of_bus(&CYCLE), None);
    let error = can_frame::DataFrame::new(0x800, &[]).expect_err("an identifier of 12 bits");
    assert_eq!(Toy::not_ours(error), None);
}

#[test]
fn waiting_times_follow_the_cycle() {
    let times = |cycle: CycleUs| {
        (
            cycle.cycle_us(),
            cycle.stuck_us(),
            cycle.requests_per_cycle(),
        )
    };
    assert_eq!(times(CYCLE), (1_000, 20_000, 1));
    assert_eq!(times(CycleUs(10_000)), (10_000, 50_000, 1));
    assert_eq!(
        (CYCLE.confirm_us(), CYCLE.standstill_limit_us()),
        (200_000, 5_000_000)
    );
}

#[test]
fn a_drive_that_says_nothing_of_its_own_has_no_brake_no_rearming_and_no_length() {
    let limits = LIMITS;
    let mut drive = Toy::drive(&CYCLE, &ToyAxis { drive: 1, limits }, 0);
    assert_eq!(drive.group(), GroupId(0));
    assert_eq!(drive.reaction_to(ToyFault::Alarm), Reaction::Halt);
    assert_eq!(drive.brake(), Brake::Absent);
    assert!(!drive.must_rearm() && !drive.streams_on(Instant::default()));
    assert_eq!((drive.cycle_frame_bits(), drive.poll_bits()), (0, 0));
    assert_eq!(drive.response_window(), None);
    // Nor a motion of its own.
    let wanted = DriveMove::To(5);
    for by_trigger in [false, true] {
        let admitted = drive.admit_move(wanted, by_trigger, &CYCLE, Instant::default());
        assert_eq!(admitted, Err(MoveRefusal::Unsupported));
    }
    assert!(!drive.has_seen_load() && !drive.may_hold_load(wanted));
    assert_eq!(drive.loaded_move(), None);
    let view = View::new(
        Facts::start(Brake::Absent),
        Stage::Probing,
        Instant::default(),
    );
    assert!(!drive.owes_frame(&view));
    assert_eq!(
        drive.outlook(&view, Instant::default(), 0),
        Outlook::now(Some(Wanted::<()>::URGENT))
    );
}
