//! Procedures beside the cycle, and commissioning before it, on simulated drives.

use can_motion::{
    AxisState, Confirmation, EventKind, GroupId, Instant, MasterConfig, Procedure, ProcedureEnd,
    ProcedureError, service,
};
use drive_sim::{
    Bench, BitRate, Bus, ControllerConfig, DeviceId, DynDrive, DynDriveConfig, NodeId,
    ResponseDelay, TxOrder,
};
use dyn_can::{
    Alarm, ByteOrder, Dialect, DriveId, MaxSpeed, OnPosRange, Reply, Revision, SetParamGroup2,
    SetParamGroup3,
};
use dyn_commission::{
    AnswerCount, AssignId, AssignResult, ByteOrderProbe, ByteOrderResult, Commissioner,
    CountAnswers, Group3Order, Scan, Script,
};
use host_tests::rig::{GROUP, Rig};

fn max_speed(value: i32) -> Procedure {
    Procedure::WriteGroup2(SetParamGroup2 {
        max_speed: MaxSpeed::new(value).ok(),
        max_acceleration: None,
    })
}

/// Starts a procedure on axis 0 and runs it to its end.
fn run(rig: &mut Rig, procedure: Procedure, confirmation: Confirmation) -> ProcedureEnd {
    let now = rig.now();
    rig.master.start(now, 0, procedure, confirmation).unwrap();
    let told = rig.events.len();
    for _ in 0..200 {
        rig.cycle();
        for event in &rig.events[told..] {
            if let EventKind::Procedure(end) = event.kind {
                // What was written is checked.
                if rig.state(0) == AxisState::Probing {
                    rig.run_until(AxisState::Ready);
                }
                return end;
            }
        }
    }
    panic!("the procedure does not end: {:#?}", &rig.events[told..]);
}

fn ready() -> Rig {
    let mut rig = Rig::with_axes(1);
    rig.ready();
    rig
}

#[test]
fn a_write_wears_the_drive_only_when_it_changes_something() {
    let mut rig = ready();
    let present = rig.drive(0).config().group2.max_speed.get();
    let end = run(&mut rig, max_speed(i32::from(present)), Confirmation::None);
    assert_eq!(
        (end, rig.axis(0).counters.eeprom_writes),
        (ProcedureEnd::Unchanged, 0)
    );
    assert_eq!(
        run(&mut rig, max_speed(17), Confirmation::None),
        ProcedureEnd::Written
    );
    assert_eq!(rig.axis(0).counters.eeprom_writes, 1);
    let end = run(&mut rig, Procedure::ReadGroup2, Confirmation::None);
    assert!(
        matches!(end, ProcedureEnd::Read(Reply::ParamGroup2(group)) if group.max_speed.get() == 17)
    );
}

#[test]
fn writes_keep_their_distance_and_their_budget() {
    let mut axis = host_tests::rig::axis_config(DriveId::MIN);
    axis.wear.budget = 2;
    let drive = DynDriveConfig::new(DriveId::MIN);
    let mut rig = Rig::new(MasterConfig::DEFAULT, &[axis], vec![drive], TxOrder::Fifo);
    rig.ready();
    assert_eq!(
        run(&mut rig, max_speed(17), Confirmation::None),
        ProcedureEnd::Written
    );
    let now = rig.now();
    let refused = rig.master.start(now, 0, max_speed(18), Confirmation::None);
    assert!(matches!(refused, Err(ProcedureError::WearInterval { wait_us }) if wait_us > 900_000));
    rig.cycles(1_000);
    assert_eq!(
        run(&mut rig, max_speed(18), Confirmation::None),
        ProcedureEnd::Written
    );
    rig.cycles(1_000);
    let now = rig.now();
    let refused = rig.master.start(now, 0, max_speed(19), Confirmation::None);
    assert_eq!(refused, Err(ProcedureError::WearBudget { budget: 2 }));
}

#[test]
fn what_is_hard_to_undo_needs_a_confirmation() {
    let mut rig = ready();
    let brake = Procedure::WriteGroup3(SetParamGroup3 {
        on_pos_range: OnPosRange::new(127).ok(),
        ..SetParamGroup3::default()
    });
    for procedure in [brake, Procedure::SetOrigin, Procedure::DriveReset] {
        let now = rig.now();
        let refused = rig.master.start(now, 0, procedure, Confirmation::None);
        assert_eq!(refused, Err(ProcedureError::Unconfirmed), "{procedure:?}");
    }
    assert_eq!(
        run(&mut rig, brake, Confirmation::Given),
        ProcedureEnd::Written
    );
}

#[test]
fn after_a_new_origin_the_drive_is_checked_and_anchored_anew() {
    let start_position_counts = 5_000;
    let drive = DynDriveConfig {
        start_position_counts,
        ..DynDriveConfig::new(DriveId::MIN)
    };
    let axes = [host_tests::rig::axis_config(DriveId::MIN)];
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, vec![drive], TxOrder::Fifo);
    rig.ready();
    assert_eq!(rig.axis(0).feedback.position.unwrap().value, 5_000);
    assert_eq!(
        run(&mut rig, Procedure::SetOrigin, Confirmation::Given),
        ProcedureEnd::Sent
    );
    rig.run_until(AxisState::Ready);
    assert_eq!(rig.axis(0).feedback.position.unwrap().value, 0);
    rig.stream();
    assert_eq!(rig.axis(0).sent_counts, 0);
}

#[test]
fn writing_is_refused_while_the_axis_is_enabled_and_reading_is_not() {
    let mut rig = Rig::with_axes(2);
    rig.stream();
    rig.move_all(&[20, 20], 20);
    let now = rig.now();
    assert_eq!(
        rig.master.start(now, 0, max_speed(9), Confirmation::None),
        Err(ProcedureError::State {
            actual: AxisState::Streaming
        })
    );
    let end = run(&mut rig, Procedure::ReadGroup1, Confirmation::None);
    assert!(matches!(end, ProcedureEnd::Read(Reply::ParamGroup1(_))));
    assert_eq!(rig.master.cycle_counters().late, 0);
}

#[test]
fn writing_beside_a_streaming_axis_costs_it_nothing() {
    let mut axes = [1, 2].map(|id| host_tests::rig::axis_config(DriveId::new(id).unwrap()));
    axes[1].group = GroupId(1);
    let drives = [1, 2].map(|id| DynDriveConfig::new(DriveId::new(id).unwrap()));
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, drives.to_vec(), TxOrder::Fifo);
    rig.cycles(300);
    let now = rig.now();
    rig.master.disable(now, GROUP);
    rig.master.disable(now, GroupId(1));
    rig.cycles(100);
    let now = rig.now();
    rig.master.enable(now, GroupId(1)).unwrap();
    rig.cycles(400);
    assert_eq!(rig.axis(1).state, AxisState::Streaming);
    let frames = rig.drive(1).books().pd_frames;
    let start = rig.now();
    assert_eq!(
        run(&mut rig, max_speed(33), Confirmation::None),
        ProcedureEnd::Written
    );
    let cycles = rig.now().us_since(start) / 1_000;
    assert_eq!(rig.drive(1).books().pd_frames - frames, cycles);
}

#[test]
fn a_reset_brings_an_alarmed_drive_back_in_1_6a_and_is_refused_in_1_2a() {
    let mut rig = ready();
    rig.drive_mut(0)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    rig.cycles(50);
    assert_eq!(
        run(&mut rig, Procedure::DriveReset, Confirmation::Given),
        ProcedureEnd::Sent
    );
    assert_eq!(rig.drive(0).alarm(), Alarm::None);
    let now = rig.now();
    rig.master.clear(now, GROUP).unwrap();
    // A drive comes out of its reset with the servo on.
    rig.run_until(AxisState::FoundOn);

    let old = DynDriveConfig::new(DriveId::MIN).with_revision(Revision::V1_2A);
    let axes = [host_tests::rig::axis_config(DriveId::MIN)];
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, vec![old], TxOrder::Fifo);
    rig.ready();
    let now = rig.now();
    let refused = rig
        .master
        .start(now, 0, Procedure::DriveReset, Confirmation::Given);
    assert!(matches!(refused, Err(ProcedureError::Refused(_))));
}

/// A bus with drives and nobody who streams.
struct Workbench {
    bench: Bench<DynDrive>,
    node: NodeId,
    drives: Vec<DeviceId>,
}

impl Workbench {
    fn new(drives: Vec<DynDriveConfig>) -> Self {
        let mut bench = Bench::new(Bus::new(BitRate::Kbit1000));
        let node = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        let drives = drives.into_iter();
        let drives = drives
            .map(|drive| bench.add_device(DynDrive::new(drive), ControllerConfig::device()))
            .collect();
        bench.advance_to(200_000_000);
        Self {
            bench,
            node,
            drives,
        }
    }

    fn run<S: Script>(&mut self, script: S) -> S::Result
    where
        S::Result: Clone,
    {
        let mut task = Commissioner::new(script);
        for _ in 0..20_000 {
            let now = Instant::from_us(self.bench.now_ns() / 1_000);
            task.tick(now);
            let _ = service(&mut task, &mut self.bench.port(self.node), now);
            if let Some(result) = task.result() {
                return result.clone();
            }
            self.bench.advance_to(self.bench.now_ns() + 250_000);
        }
        panic!("the task does not end");
    }

    /// How often each drive has stored an id.
    fn id_writes(&self) -> Vec<u64> {
        let writes = self.bench.devices().map(DynDrive::eeprom_writes);
        writes.map(|writes| writes.drive_id).collect()
    }
}

fn drive(id: i32, revision: Revision) -> DynDriveConfig {
    DynDriveConfig::new(DriveId::new(id).unwrap()).with_revision(revision)
}

#[test]
fn a_scan_finds_every_drive_and_its_revision() {
    let drives = vec![
        drive(7, Revision::V1_6A),
        drive(2, Revision::V1_2A),
        drive(63, Revision::V1_6A),
    ];
    let found = Workbench::new(drives).run(Scan::default());
    let found: Vec<_> = found
        .iter()
        .map(|found| (found.drive.get(), found.revision))
        .collect();
    assert_eq!(
        found,
        [
            (2, Some(Revision::V1_2A)),
            (7, Some(Revision::V1_6A)),
            (63, Some(Revision::V1_6A))
        ]
    );
}

#[test]
fn a_scan_that_listens_longer_finds_what_answers_late() {
    let late = || {
        let mut config = drive(5, Revision::V1_6A);
        config.response_delay = ResponseDelay::fixed(30_000_000);
        Workbench::new(vec![config])
    };
    assert!(late().run(Scan::default()).is_empty());
    let found = late().run(Scan::listening(50_000));
    assert_eq!(found.first().map(|found| found.drive.get()), Some(5));
}

#[test]
fn an_id_is_given_as_the_revision_allows() {
    let id = |id| DriveId::new(id).unwrap();
    let mut old = Workbench::new(vec![drive(5, Revision::V1_2A), drive(6, Revision::V1_2A)]);
    let rename = |to| AssignId::rename(id(5), id(to));
    assert_eq!(old.run(rename(6)), AssignResult::IdTaken);
    assert_eq!(old.run(rename(9)), AssignResult::Active);
    assert_eq!(old.run(rename(9)), AssignResult::NoDrive);
    let mut new = Workbench::new(vec![drive(5, Revision::V1_6A)]);
    let result = new.run(AssignId::rename(id(5), id(9)));
    assert_eq!(result, AssignResult::AfterPowerCycle);
    assert_eq!(old.id_writes(), [1, 0]);
    assert_eq!(new.id_writes(), [1]);
}

#[test]
fn a_fresh_drive_alone_on_the_bus_gets_its_first_id() {
    for (revision, expected) in [
        (Revision::V1_2A, AssignResult::Active),
        (Revision::V1_6A, AssignResult::AfterPowerCycle),
    ] {
        let fresh = DynDriveConfig::fresh().with_revision(revision);
        let mut bench = Workbench::new(vec![fresh]);
        let id = DriveId::new(3).unwrap();
        let result = bench.run(AssignId::first_id_of_the_only_drive(id));
        assert_eq!((result, bench.id_writes()), (expected, vec![1]));
    }
}

/// A drive whose replies come a little later than those of another: nobody else looks like it.
fn twin(config: DynDriveConfig) -> DynDriveConfig {
    DynDriveConfig {
        response_delay: ResponseDelay::fixed(400_000),
        ..config
    }
}

#[test]
fn no_id_is_given_to_one_of_several_drives() {
    let id = |id| DriveId::new(id).unwrap();
    let fresh = DynDriveConfig::fresh;
    let mut two = Workbench::new(vec![fresh(), twin(fresh())]);
    let first = AssignId::first_id_of_the_only_drive(id(3));
    assert_eq!(two.run(first), AssignResult::SeveralDrives);
    for (present, expected) in [
        (3, AssignResult::IdTaken),
        (40, AssignResult::OtherDrive(id(40))),
    ] {
        let other = drive(present, Revision::V1_6A);
        let mut bench = Workbench::new(vec![fresh(), other]);
        let first = AssignId::first_id_of_the_only_drive(id(3));
        assert_eq!(
            (bench.run(first), bench.id_writes()),
            (expected, vec![0, 0])
        );
    }
    let mut silent = Workbench::new(vec![fresh()]);
    let lone = silent.drives[0];
    silent.bench.device_mut(lone).faults_mut().leave_bus();
    let first = AssignId::first_id_of_the_only_drive(id(3));
    assert_eq!(silent.run(first), AssignResult::NoDrive);
    let five = || drive(5, Revision::V1_6A);
    let mut two = Workbench::new(vec![five(), twin(five())]);
    let rename = AssignId::rename(id(5), id(9));
    assert_eq!(two.run(rename), AssignResult::SeveralDrives);
    assert_eq!(two.id_writes(), [0, 0]);
    assert_eq!(two.run(CountAnswers::of(id(5))), AnswerCount::Several);
    assert_eq!(two.run(CountAnswers::of(id(6))), AnswerCount::None);
    let mut one = Workbench::new(vec![five()]);
    assert_eq!(one.run(CountAnswers::of(id(5))), AnswerCount::One);
}

#[test]
fn no_id_is_given_on_a_bus_that_is_not_quiet() {
    // Another drive says every 190 ms that it has an alarm: 1Dh and EE. The reads of an assignment take less.
    let drives = [5, 6].map(|id| drive(id, Revision::V1_6A));
    let mut bench = Workbench::new(drives.to_vec());
    let alarmed = bench.drives[1];
    let faults = bench.bench.device_mut(alarmed).faults_mut();
    faults.repeat_alarm_frames(core::num::NonZeroU64::new(190_000_000));
    faults.raise_alarm(Alarm::OverCurrent);
    bench.bench.advance_to(bench.bench.now_ns() + 50_000_000);
    let id = |id| DriveId::new(id).unwrap();
    let rename = AssignId::rename(id(5), id(9));
    assert_eq!(bench.run(rename), AssignResult::NotQuiet);
    assert_eq!(bench.id_writes(), [0, 0]);
}

#[test]
fn a_group_3_reply_is_read_in_both_orders() {
    use dyn_can::{GearNumber, Group3ReplyOrder};
    let read = |gear, order, revision| {
        let mut config = drive(5, revision);
        config.dialect.group3_reply_order_1_2a = Group3ReplyOrder::Fixed(order);
        config.group3.gear_number = GearNumber::new(gear).unwrap();
        let readings = Workbench::new(vec![config]).run(Group3Order::of(DriveId::new(5).unwrap()));
        let readings = readings.expect("a reply");
        let gear = |group: Option<dyn_can::ParamGroup3>| group.map(|group| group.gear_number.get());
        (
            gear(readings.msb_first),
            gear(readings.lsb_first),
            readings.order(),
        )
    };
    let (msb, lsb) = (ByteOrder::MsbFirst, ByteOrder::LsbFirst);
    // 4096 is 1000h, and 16 the other way round; 4104 is 1008h, and 2064.
    assert_eq!(
        read(4_096, msb, Revision::V1_2A),
        (Some(4_096), None, Some(msb))
    );
    assert_eq!(
        read(4_096, lsb, Revision::V1_2A),
        (None, Some(4_096), Some(lsb))
    );
    assert_eq!(
        read(4_104, msb, Revision::V1_2A),
        (Some(4_104), Some(2_064), None)
    );
    assert_eq!(
        read(4_104, lsb, Revision::V1_2A),
        (Some(2_064), Some(4_104), None)
    );
    // 1.6A tells its order by the on-position range.
    assert_eq!(
        read(4_104, msb, Revision::V1_6A),
        (None, Some(4_104), Some(lsb))
    );
}

#[test]
fn the_byte_order_is_found_out_without_moving() {
    for order in [ByteOrder::MsbFirst, ByteOrder::LsbFirst] {
        let dialect = Dialect {
            number_order: order,
            ..Dialect::V1_6A
        };
        let config = DynDriveConfig {
            dialect,
            ..DynDriveConfig::new(DriveId::MIN)
        };
        let mut bench = Workbench::new(vec![config]);
        let result = bench.run(ByteOrderProbe::with_free_shaft(
            DriveId::MIN,
            Revision::V1_6A,
        ));
        assert_eq!(result, ByteOrderResult::Order(order));
        let now_ns = bench.bench.now_ns();
        let drive = bench.bench.devices().next().expect("one drive");
        assert_eq!(drive.travel_counts(now_ns), 0);
    }
}
