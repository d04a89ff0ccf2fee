//! Life of an axis on the virtual bus: from power-on to streaming and back, and what stops it.

use core::num::NonZeroU64;

use can_motion::{
    AxisConfig, AxisState, CommandError, DriveMove, EventKind, Fault, GroupId, MasterConfig,
    Reaction, Reactions, StepChange, TargetError, Travel,
};
use drive_sim::{DynDriveConfig, FrameMatch, TxOrder};
use dyn_can::{Alarm, ConfigByte, DriveId, FunctionCode, Revision, StepLimit};
use host_tests::rig::{GROUP, Rig};

fn set_points_of(rig: &Rig, drive: u16) -> usize {
    let id = drive << 5 | FunctionCode::GoRelativePosPd as u16;
    let is_it = |raw: embedded_can::Id| matches!(raw, embedded_can::Id::Standard(standard) if standard.as_raw() == id);
    rig.traffic
        .iter()
        .filter(|record| is_it(embedded_can::Frame::id(&record.frame)))
        .count()
}

#[test]
fn from_power_on_to_streaming_every_step_is_told() {
    use AxisState::{
        Anchoring, AwaitingStandstill, CheckingConfig, CheckingStatus, Disabling, Enabling,
        FoundOn, Holding, Identifying, Locating, Probing, Ready, Streaming,
    };
    let mut rig = Rig::with_axes(1);
    rig.stream();
    assert_eq!(
        rig.path(0),
        [
            Probing,
            Identifying,
            CheckingConfig,
            CheckingStatus,
            Locating,
            FoundOn,
            Disabling,
            Ready,
            Probing,
            Identifying,
            CheckingConfig,
            CheckingStatus,
            Locating,
            AwaitingStandstill,
            Anchoring,
            Enabling,
            Holding,
            Streaming
        ]
    );
    // Nothing is sent before the drive can listen (D58), and nothing moves before the application has its say.
    assert!(rig.traffic[0].start_ns >= 150_000_000);
    assert_eq!(rig.drive(0).books().pd_frames_ignored, 0);
    assert_eq!(rig.drive(0).travel_counts(rig.bench.now_ns()), 0);
}

#[test]
fn a_move_of_the_drive_begins_and_ends_where_the_axis_holds() {
    use AxisState::{DriveMoving, DriveStopping, Holding, RampingDown, Streaming};
    let group2 = DynDriveConfig::new(DriveId::MIN).group2;
    let axes = [AxisConfig {
        drive_curve: Some(group2),
        ..host_tests::rig::axis_config(DriveId::MIN)
    }];
    let drives = vec![DynDriveConfig::new(DriveId::MIN)];
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, drives, TxOrder::Fifo);
    rig.stream();
    let told = rig.path(0).len();
    for (wanted, stops) in [(DriveMove::To(3_000), false), (DriveMove::By(-9_000), true)] {
        let now = rig.now();
        let streams = rig.master.start_move(now, 0, wanted);
        assert!(streams.is_err(), "a stream ends first");
        rig.master.stop(now, GROUP);
        rig.run_until(Holding);
        let now = rig.now();
        rig.master.start_move(now, 0, wanted).unwrap();
        rig.run_until(DriveMoving);
        if stops {
            rig.cycles(5);
            let now = rig.now();
            rig.master.stop(now, GROUP);
        }
        rig.run_until(Holding);
        let now = rig.now();
        rig.master.resume(now, GROUP).unwrap();
        rig.run_until(Streaming);
        rig.cycles(2);
    }
    let path = rig.path(0);
    let held: Vec<AxisState> = path[told..]
        .iter()
        .copied()
        .filter(|state| *state != RampingDown)
        .collect();
    let once = [Holding, DriveMoving, Holding, Streaming];
    assert_eq!(held[..4], once);
    assert_eq!(held[4..7], [Holding, DriveMoving, DriveStopping]);
    assert!(held.ends_with(&[Holding, Streaming]), "{held:?}");
    assert_eq!(rig.axis(0).fault, None);
}

#[test]
fn the_revision_is_recognised_by_itself() {
    let drives = [(1, Revision::V1_2A), (2, Revision::V1_6A)].map(|(id, revision)| {
        DynDriveConfig::new(DriveId::new(id).unwrap()).with_revision(revision)
    });
    let axes = [1, 2].map(|id| host_tests::rig::axis_config(DriveId::new(id).unwrap()));
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, drives.to_vec(), TxOrder::Fifo);
    rig.run_until(AxisState::FoundOn);
    let revisions = [0, 1].map(|axis| rig.axis(axis).feedback.revision);
    assert_eq!(revisions, [Some(Revision::V1_2A), Some(Revision::V1_6A)]);
}

#[test]
fn enabling_is_bumpless_wherever_the_axis_stands() {
    let drive = DynDriveConfig {
        start_position_counts: -54_321,
        ..DynDriveConfig::new(DriveId::MIN)
    };
    let axes = [host_tests::rig::axis_config(DriveId::MIN)];
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, vec![drive], TxOrder::Fifo);
    rig.stream();
    rig.cycles(100);
    let axis = rig.axis(0);
    assert_eq!((axis.target_counts, axis.sent_counts), (-54_321, -54_321));
    assert_eq!(rig.drive(0).commanded_counts(), 0);
}

#[test]
fn a_wrong_configuration_never_streams() {
    let mut drive = DynDriveConfig::new(DriveId::MIN);
    drive.config_byte = ConfigByte::from_byte(0x08);
    let axes = [host_tests::rig::axis_config(DriveId::MIN)];
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, vec![drive], TxOrder::Fifo);
    rig.cycles(400);
    let fault = Fault::Config(ConfigByte::from_byte(0x08));
    assert_eq!(
        (rig.axis(0).state, rig.axis(0).fault),
        (AxisState::Faulted, Some(fault))
    );
    let now = rig.now();
    assert_eq!(
        rig.master.enable(now, GROUP),
        Err(CommandError::Faulted { axis: 0, fault })
    );
    assert_eq!(
        rig.master.set_target(0, 1),
        Err(TargetError::NotStreaming {
            state: AxisState::Faulted
        })
    );
}

#[test]
fn an_alarm_stops_the_whole_group_in_the_same_cycle() {
    let mut rig = Rig::with_axes(4);
    rig.stream();
    rig.move_all(&[30, 20, 10, 5], 100);
    rig.drive_mut(2)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    rig.cycle();
    let sent: Vec<i32> = (0..4).map(|axis| rig.axis(axis).sent_counts).collect();
    let frames: Vec<usize> = (1..=4).map(|drive| set_points_of(&rig, drive)).collect();
    rig.cycles(50);
    assert_eq!(rig.axis(2).fault, Some(Fault::AlarmFrame));
    for axis in [0, 1, 3] {
        assert_eq!(rig.axis(axis).fault, Some(Fault::Group));
    }
    for (axis, (sent, frames)) in sent.iter().zip(&frames).enumerate() {
        assert_eq!(rig.axis(axis).sent_counts, *sent, "axis {axis}");
        assert_eq!(set_points_of(&rig, axis as u16 + 1), *frames, "axis {axis}");
    }
}

#[test]
fn after_a_group_fault_nothing_moves_until_clear_and_resume() {
    let mut rig = Rig::with_axes(2);
    rig.stream();
    rig.move_all(&[10, 10], 20);
    rig.drive_mut(0).faults_mut().raise_alarm(Alarm::LostPhase);
    rig.cycles(20);
    let now = rig.now();
    assert!(matches!(
        rig.master.resume(now, GROUP),
        Err(CommandError::Faulted { .. })
    ));
    // A power cycle takes the alarm away; the master must not take that for permission.
    rig.drive_mut(0).faults_mut().power_cycle(50_000_000);
    let frames = set_points_of(&rig, 2);
    rig.cycles(500);
    assert_eq!(set_points_of(&rig, 2), frames);
    let now = rig.now();
    rig.master.clear(now, GROUP).unwrap();
    rig.cycles(200);
    assert_eq!(
        (rig.axis(0).state, rig.axis(1).state),
        (AxisState::FoundOn, AxisState::Holding)
    );
    assert_eq!(set_points_of(&rig, 2), frames);
}

/// Two drives, each the only one of its group, and both streaming.
fn two_groups() -> Rig {
    let mut axes = [1, 2].map(|id| host_tests::rig::axis_config(DriveId::new(id).unwrap()));
    axes[1].group = GroupId(1);
    let drives = [1, 2].map(|id| DynDriveConfig::new(DriveId::new(id).unwrap()));
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, drives.to_vec(), TxOrder::Fifo);
    rig.cycles(300);
    for group in [GROUP, GroupId(1)] {
        let now = rig.now();
        rig.master.adopt(now, group).unwrap();
    }
    rig.cycles(200);
    for group in [GROUP, GroupId(1)] {
        let now = rig.now();
        rig.master.resume(now, group).unwrap();
    }
    rig.cycles(400);
    rig
}

#[test]
fn axes_of_another_group_go_on() {
    let mut rig = two_groups();
    rig.drive_mut(0)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    rig.cycles(10);
    assert_eq!(
        (rig.axis(0).state, rig.axis(1).state),
        (AxisState::Faulted, AxisState::Streaming)
    );
}

#[test]
fn a_drive_that_alarms_for_ever_does_not_hide_that_another_is_lost() {
    let mut rig = two_groups();
    let faults = rig.drive_mut(0).faults_mut();
    faults.repeat_alarm_frames(NonZeroU64::new(2_000_000));
    faults.raise_alarm(Alarm::OverCurrent);
    rig.cycles(15);
    let asked = rig.axis(1).counters.requests;
    rig.cycles(4);
    assert_eq!(
        rig.axis(1).counters.requests,
        asked,
        "polls rest after the alarm"
    );
    rig.drive_mut(1).faults_mut().fall_silent();
    rig.cycles(200);
    assert_eq!(rig.axis(1).fault, Some(Fault::Lost));
}

#[test]
fn a_group_ramps_down_in_proportion_and_within_its_limit() {
    let mut axes = [1, 2].map(|id| host_tests::rig::axis_config(DriveId::new(id).unwrap()));
    axes.iter_mut()
        .for_each(|axis| axis.limits.max_step_change = StepChange::from_counts(4).unwrap());
    let drives = [1, 2].map(|id| DynDriveConfig::new(DriveId::new(id).unwrap()));
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, drives.to_vec(), TxOrder::Fifo);
    rig.stream();
    rig.move_all(&[100, -50], 100);
    let now = rig.now();
    rig.master.stop(now, GROUP);
    let mut before = [0, 1].map(|axis| rig.axis(axis).sent_counts);
    let mut velocity = [100, -50];
    for _ in 0..25 {
        rig.cycle();
        let sent = [0, 1].map(|axis| rig.axis(axis).sent_counts);
        for axis in 0..2 {
            let step = sent[axis] - before[axis];
            assert!(
                (step - velocity[axis]).abs() <= 5,
                "axis {axis}: {} to {step}",
                velocity[axis]
            );
            velocity[axis] = step;
        }
        assert!(
            (velocity[0] + 2 * velocity[1]).abs() <= 2,
            "not in proportion: {velocity:?}"
        );
        before = sent;
    }
    rig.cycles(3);
    assert_eq!(
        [0, 1].map(|axis| rig.axis(axis).state),
        [AxisState::Holding; 2]
    );
    assert_eq!(velocity, [0, 0]);
}

#[test]
fn disable_ramps_down_first() {
    let mut rig = Rig::with_axes(2);
    rig.stream();
    rig.move_all(&[200, 100], 50);
    let now = rig.now();
    rig.master.disable(now, GROUP);
    rig.run_until(AxisState::Ready);
    assert!(!rig.drive(0).is_enabled() && !rig.drive(1).is_enabled());
    assert_eq!(rig.drive(0).books().pd_frames_ignored, 0);
}

#[test]
fn a_silent_drive_is_lost_and_its_group_ramps_down() {
    let mut rig = Rig::with_axes(3);
    rig.stream();
    rig.move_all(&[50, 50, 50], 50);
    rig.drive_mut(1).faults_mut().fall_silent();
    rig.cycles(300);
    assert_eq!(rig.axis(1).fault, Some(Fault::Lost));
    assert_eq!(rig.axis(0).fault, Some(Fault::Group));
    assert!(rig.path(0).contains(&AxisState::RampingDown));
    assert_eq!(rig.master.cycle_counters().late, 0);
}

#[test]
fn each_fault_does_what_its_reaction_says() {
    let reactions = Reactions {
        alarm: Reaction::Disable,
        ..Reactions::DEFAULT
    };
    let axes = [1, 2].map(|id| AxisConfig {
        reactions,
        ..host_tests::rig::axis_config(DriveId::new(id).unwrap())
    });
    let drives = [1, 2].map(|id| DynDriveConfig::new(DriveId::new(id).unwrap()));
    let mut rig = Rig::new(MasterConfig::DEFAULT, &axes, drives.to_vec(), TxOrder::Fifo);
    rig.stream();
    rig.drive_mut(0)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    rig.cycles(50);
    assert!(
        !rig.drive(1).is_enabled(),
        "the other axis was disabled too"
    );
    assert_eq!(rig.axis(1).state, AxisState::Faulted);
}

#[test]
fn a_target_that_runs_away_is_a_fault_before_it_is_a_motion() {
    let mut axis = host_tests::rig::axis_config(DriveId::MIN);
    axis.limits.max_step = StepLimit::new(100).unwrap();
    axis.limits.backlog_counts = 1_000;
    let drive = DynDriveConfig::new(DriveId::MIN);
    let mut rig = Rig::new(MasterConfig::DEFAULT, &[axis], vec![drive], TxOrder::Fifo);
    rig.stream();
    rig.cycle();
    // Between two cycles, when the set-point of one is through: the worst moment.
    rig.master.set_target(0, 1_001).unwrap();
    rig.cycles(5);
    assert_eq!(rig.axis(0).fault, Some(Fault::Backlog { counts: 1_001 }));
    assert_eq!(rig.drive(0).commanded_counts(), 0);
    assert_eq!(
        rig.master.set_target(0, 1 << 27),
        Err(TargetError::NotStreaming {
            state: AxisState::Faulted
        })
    );
}

#[test]
fn a_doubled_set_point_is_reported_as_one_repeated_step() {
    let mut rig = Rig::with_axes(1);
    rig.stream();
    rig.move_all(&[40], 50);
    let set_point = FrameMatch::with_id(embedded_can::StandardId::new(0x03C).unwrap());
    rig.bench
        .bus_mut()
        .faults_mut()
        .duplicate_next(set_point, 1);
    rig.move_all(&[40], 10);
    rig.cycles(400);
    assert_eq!(rig.drive(0).commanded_counts(), 60 * 40 + 40);
    let drift = rig.saw(|kind| {
        matches!(kind, EventKind::Fault(Fault::Drift { counts: 40, cause }) if *cause == can_motion::DriftCause::OneStepRepeated)
    });
    assert!(drift, "{:?}", rig.axis(0).fault);
}

#[test]
fn a_set_point_that_the_drive_missed_is_reported_as_one_lost_step() {
    let mut rig = Rig::with_axes(1);
    rig.stream();
    rig.move_all(&[40], 50);
    let node = rig.bench.node_of(rig.drives[0]);
    let set_point = FrameMatch::with_id(embedded_can::StandardId::new(0x03C).unwrap());
    rig.bench
        .bus_mut()
        .faults_mut()
        .drop_next(node, set_point, 1);
    rig.move_all(&[40], 10);
    rig.cycles(400);
    assert_eq!(rig.drive(0).commanded_counts(), 60 * 40 - 40);
    let cause = can_motion::DriftCause::OneStepLost;
    assert_eq!(rig.axis(0).fault, Some(Fault::Drift { counts: -40, cause }));
}

#[test]
fn a_restarted_drive_is_noticed_by_its_counter() {
    let mut axis = host_tests::rig::axis_config(DriveId::MIN);
    axis.polls.counter_us = Some(20_000);
    let mut drive = DynDriveConfig::new(DriveId::MIN);
    drive.power_on_delay_ns = 0;
    let mut rig = Rig::new(MasterConfig::DEFAULT, &[axis], vec![drive], TxOrder::Fifo);
    rig.stream();
    rig.cycles(1_000);
    rig.drive_mut(0).faults_mut().reboot();
    rig.cycles(100);
    let reboot = |kind: &EventKind| matches!(kind, EventKind::Fault(Fault::Reboot { .. }));
    assert!(rig.saw(reboot), "{:?}", rig.axis(0).fault);
}

#[test]
fn skipped_cycles_merge_into_the_next_frames() {
    let mut rig = Rig::with_axes(2);
    rig.stream();
    rig.move_all(&[10, -10], 20);
    (0..5).for_each(|_| rig.skip_cycle());
    let before = rig.drive(0).books().pd_frames;
    let target = rig.axis(0).target_counts + 60;
    rig.master.set_target(0, target).unwrap();
    rig.cycle();
    assert_eq!(rig.drive(0).books().pd_frames, before + 1);
    // 64 counts are the acceleration of an axis that stood for five cycles.
    assert_eq!(rig.axis(0).sent_counts, target);
    assert!(rig.saw(|kind| *kind == EventKind::CyclesMissed(5)));
    assert_eq!(rig.master.cycle_counters().missed, 5);
}

#[test]
fn an_axis_outside_its_travel_is_not_anchored_and_a_target_outside_is_refused() {
    let mut axis = host_tests::rig::axis_config(DriveId::MIN);
    axis.limits.travel = Travel {
        min_counts: -1_000,
        max_counts: 1_000,
    };
    let drive_at = |start_position_counts| {
        vec![DynDriveConfig {
            start_position_counts,
            ..DynDriveConfig::new(DriveId::MIN)
        }]
    };
    let mut rig = Rig::new(
        MasterConfig::DEFAULT,
        &[axis],
        drive_at(1_001),
        TxOrder::Fifo,
    );
    rig.cycles(300);
    assert_eq!(
        rig.axis(0).fault,
        Some(Fault::PositionRange { read_back: 1_001 })
    );

    let mut rig = Rig::new(
        MasterConfig::DEFAULT,
        &[axis],
        drive_at(-1_000),
        TxOrder::Fifo,
    );
    rig.stream();
    let refused = TargetError::Travel {
        min: -1_000,
        max: 1_000,
        actual: 1_001,
    };
    assert_eq!(rig.master.set_target(0, 1_001), Err(refused));
    assert_eq!(rig.axis(0).target_counts, -1_000);
}
