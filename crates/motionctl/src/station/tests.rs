//! What becomes of the power of simulated drives, whatever ends a motion.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use can_motion::facts::Knowledge;
use can_motion::{AxisSnapshot, Fault, PollPeriods};
use drive_sim::{
    Bench, BitRate, Bus, ControllerConfig, DeviceId, DynDrive, DynDriveConfig, Frame, NodeId,
    TxOrder,
};
use dyn_can::{Alarm, DriveId, FunctionCode, GearNumber};
use embedded_can::nb::Can;
use embedded_can::{Frame as _, Id, StandardId};

use super::{AxisOptions, BringUpError, End, GROUP, LookError, Station, look, unconfirmed_warning};
use crate::lawicel;
use crate::link::Link;
use crate::link::fake_adapter::{FakeAdapter, set_up_answer};

/// Time that has passed when the first frame comes: the drives are ready.
const START_NS: u64 = 1_000_000_000;
/// Longer than a drive takes to answer.
const ANSWER_NS: u64 = 1_000_000;
const GEAR: GearNumber = match GearNumber::new(4_096) {
    Ok(gear) => gear,
    Err(_) => panic!("a gear number"),
};

/// What happens to a frame of the host.
#[derive(PartialEq, Eq)]
enum Way {
    OntoTheBus,
    Lost,
    /// The adapter does not even answer.
    Frozen,
}

/// Simulated drives behind an adapter.
struct Sim {
    bench: Bench<DynDrive>,
    host: NodeId,
    devices: [DeviceId; 2],
    start: std::time::Instant,
}

impl Sim {
    fn exchange(&mut self, frame: &Frame) -> Vec<u8> {
        let elapsed = u64::try_from(self.start.elapsed().as_nanos()).unwrap();
        let now_ns = self.bench.now_ns().max(START_NS + elapsed);
        self.bench.advance_to(now_ns);
        self.bench.port(self.host).transmit(frame).unwrap();
        self.bench.advance_to(now_ns + ANSWER_NS);
        let mut answer = b"z\r".to_vec();
        while let Ok(reply) = self.bench.port(self.host).receive() {
            answer.extend(lawicel::encode(&reply).bytes());
            answer.push(b'\r');
        }
        answer
    }

    fn drive(&mut self, id: u8) -> &mut DynDrive {
        self.bench.device_mut(self.devices[usize::from(id) - 1])
    }
}

struct Rig {
    adapter: FakeAdapter,
    sim: Arc<Mutex<Sim>>,
}

impl Rig {
    /// Drives 1 and 2; those in `on` have come up with their servo on. `way` sees each frame before it goes out.
    fn new(
        name: &str,
        on: [bool; 2],
        mut way: impl FnMut(&mut Sim, &Frame) -> Way + Send + 'static,
    ) -> Self {
        let mut bench = Bench::new(Bus::new(BitRate::Kbit1000));
        let host = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        let devices = [1, 2].map(|number| {
            let config = DynDriveConfig {
                enabled_after_power_on: on[number as usize - 1],
                ..DynDriveConfig::numbered(number).unwrap()
            };
            bench.add_device(DynDrive::new(config), ControllerConfig::device())
        });
        bench.advance_to(START_NS);
        let start = std::time::Instant::now();
        let sim = Arc::new(Mutex::new(Sim {
            bench,
            host,
            devices,
            start,
        }));
        let shared = Arc::clone(&sim);
        let way = Mutex::new(move |frame: &Frame| {
            let mut sim = shared.lock().unwrap();
            match way(&mut sim, frame) {
                Way::OntoTheBus => sim.exchange(frame),
                Way::Lost => b"z\r".to_vec(),
                Way::Frozen => Vec::new(),
            }
        });
        let adapter = FakeAdapter::new(name, move |line| match lawicel::decode(line) {
            Some(frame) => way.lock().unwrap()(&frame),
            None => set_up_answer(line),
        });
        Self { adapter, sim }
    }

    fn is_on(&self) -> [bool; 2] {
        let mut sim = self.sim.lock().unwrap();
        [1, 2].map(|drive| sim.drive(drive).is_enabled())
    }
}

fn id(number: i32) -> DriveId {
    DriveId::new(number).unwrap()
}

fn station(link: &mut Link) -> Station<'_> {
    let axis = |number| AxisOptions::default().still(id(number), GEAR, PollPeriods::DEFAULT);
    Station::new(link, &[1, 2].map(axis), 5_000).unwrap()
}

fn is_switch(frame: &Frame, drive: i32, byte: u8) -> bool {
    let switch = StandardId::new(id(drive).can_id(FunctionCode::ServoDisable)).unwrap();
    frame.id() == Id::Standard(switch) && frame.data() == [byte]
}

fn is_set_point(frame: &Frame, drive: i32) -> bool {
    let set_point = StandardId::new(id(drive).can_id(FunctionCode::GoRelativePosPd)).unwrap();
    frame.id() == Id::Standard(set_point)
}

const ENABLE: u8 = 0x00;
const DISABLE: u8 = 0xFF;

#[test]
fn what_was_found_on_stays_on_and_what_was_switched_on_goes_off() {
    let rig = Rig::new("as-found", [false, true], |_, _| Way::OntoTheBus);
    let mut link = rig.adapter.open();
    let mut station = station(&mut link);
    station.bring_up().unwrap();
    assert_eq!(rig.is_on(), [true, true]);
    let end = End {
        disabled: vec![id(1)],
        unconfirmed: Vec::new(),
        left_on: vec![id(2)],
    };
    assert_eq!(station.shut_down(), Ok(end));
    assert_eq!(rig.is_on(), [false, true]);
}

/// Everything that a command does: looks, enables, holds for a while, disables.
fn whole_life(link: &mut Link) {
    look(link, AxisOptions::default(), &[id(1), id(2)]).unwrap();
    let mut station = station(link);
    station.bring_up().unwrap();
    let start = station.now();
    while station.now().us_since(start) < 300_000 {
        station.cycle(|_, _| {}).unwrap();
    }
    station.shut_down().unwrap();
}

#[test]
fn a_panic_at_any_stage_switches_off_what_was_switched_on() {
    // The frame of the host at which the program panics next: a request, then what enables, moves and disables drive 1.
    type IsIt = fn(&Frame) -> bool;
    let stages: [(&str, IsIt); 4] = [
        ("looks", |_| true),
        ("enables", |frame| is_switch(frame, 1, ENABLE)),
        ("streams", |frame| is_set_point(frame, 1)),
        ("disables", |frame| is_switch(frame, 1, DISABLE)),
    ];
    for (stage, is_it) in stages {
        let panics = Arc::new(AtomicBool::new(false));
        let (next, mut is_over) = (Arc::clone(&panics), false);
        let rig = Rig::new(&format!("panic-{stage}"), [false, true], move |_, frame| {
            if !is_over && is_it(frame) {
                is_over = true;
                next.store(true, Ordering::Relaxed);
            }
            Way::OntoTheBus
        });
        let mut link = rig.adapter.open();
        link.panics = panics;
        let panicked = catch_unwind(AssertUnwindSafe(|| whole_life(&mut link)));
        assert!(panicked.is_err(), "{stage}");
        assert_eq!(rig.is_on(), [false, true], "{stage}");
    }
}

#[test]
fn an_error_half_way_switches_off_what_was_switched_on() {
    let rig = Rig::new("half-way", [false, false], |_, _| Way::OntoTheBus);
    let mut link = rig.adapter.open();
    let mut station = station(&mut link);
    station.bring_up().unwrap();
    assert_eq!(rig.is_on(), [true, true]);
    // As an early return does.
    drop(station);
    assert_eq!(rig.is_on(), [false, false]);
}

#[test]
fn an_alarm_of_one_drive_while_the_others_are_enabled_disables_them() {
    let mut is_raised = false;
    let rig = Rig::new("alarm", [false, false], move |sim, frame| {
        if is_switch(frame, 1, ENABLE) && !is_raised {
            is_raised = true;
            sim.drive(2).faults_mut().raise_alarm(Alarm::OverCurrent);
        }
        Way::OntoTheBus
    });
    let mut link = rig.adapter.open();
    let mut station = station(&mut link);
    let alarm = BringUpError::Fault {
        drive: id(2),
        fault: Fault::AlarmStatus(Alarm::OverCurrent),
    };
    assert_eq!(station.bring_up(), Err(alarm));
    let end = station.shut_down().unwrap();
    assert!(end.disabled.contains(&id(1)), "{end:?}");
    assert_eq!(rig.is_on(), [false, false]);
}

#[test]
fn an_alarm_before_anything_is_enabled_leaves_all_as_it_was() {
    let rig = Rig::new("alarm-before", [false, true], |_, _| Way::OntoTheBus);
    {
        let mut sim = rig.sim.lock().unwrap();
        let drive = sim.drive(1);
        drive.faults_mut().raise_alarm(Alarm::OverheatOrOverpower);
    }
    let mut link = rig.adapter.open();
    let seen = look(&mut link, AxisOptions::default(), &[id(1), id(2)]);
    let Err(LookError::Fault { drive, fault }) = &seen else {
        panic!("{seen:?}");
    };
    assert_eq!(
        (*drive, *fault),
        (id(1), Fault::AlarmStatus(Alarm::OverheatOrOverpower))
    );
    let text = seen.unwrap_err().to_string();
    assert!(
        text.contains("drive 1: alarm, overheat or over-power"),
        "{text}"
    );
    assert_eq!(rig.is_on(), [false, true]);
}

#[test]
fn a_drive_that_stays_enabled_is_told_again_and_named() {
    let told = Arc::new(Mutex::new(0));
    let count = Arc::clone(&told);
    let rig = Rig::new("stubborn", [false, false], move |_, frame| {
        if is_switch(frame, 1, DISABLE) {
            *count.lock().unwrap() += 1;
            return Way::Lost;
        }
        Way::OntoTheBus
    });
    let mut link = rig.adapter.open();
    let mut station = station(&mut link);
    station.bring_up().unwrap();
    let end = station.shut_down().unwrap();
    assert_eq!((end.disabled, end.unconfirmed), (vec![id(2)], vec![id(1)]));
    assert!(*told.lock().unwrap() > 2, "it is told again");
    assert!(unconfirmed_warning(&[id(1)]).contains("drive 1 did not confirm"));
    assert_eq!(rig.is_on(), [true, false]);
}

#[test]
fn an_adapter_that_freezes_ends_the_motion_and_its_drives_are_named() {
    let is_frozen = Arc::new(Mutex::new(false));
    let frozen = Arc::clone(&is_frozen);
    let rig = Rig::new("frozen", [false, true], move |_, _| {
        if *frozen.lock().unwrap() {
            Way::Frozen
        } else {
            Way::OntoTheBus
        }
    });
    let mut link = rig.adapter.open();
    let mut station = station(&mut link);
    station.bring_up().unwrap();
    *is_frozen.lock().unwrap() = true;
    let start = station.now();
    let fault = loop {
        station.cycle(|_, _| {}).unwrap();
        assert!(station.now().us_since(start) < 10_000_000, "no fault");
        if let Some((_, fault)) = station.first_fault() {
            break fault;
        }
    };
    assert_eq!(fault, Fault::Bus);
    let end = station.shut_down().unwrap();
    assert_eq!((end.unconfirmed, end.left_on), (vec![id(1)], vec![id(2)]));
}

#[test]
fn an_adapter_that_is_gone_is_said_with_the_drives_that_may_be_on() {
    let mut rig = Rig::new("gone-on", [false, true], |_, _| Way::OntoTheBus);
    let mut link = rig.adapter.open();
    let mut station = station(&mut link);
    station.bring_up().unwrap();
    rig.adapter.vanish();
    assert!(station.shut_down().is_err());
    let warning = station.link_warning();
    assert!(
        warning.contains("drives 1, 2 may still be ENABLED"),
        "{warning}"
    );
}

#[test]
fn frames_that_nobody_answers_for_let_every_axis_anchor_anew() {
    let is_mute = Arc::new(Mutex::new(false));
    let mute = Arc::clone(&is_mute);
    let rig = Rig::new("mute", [false, true], move |sim, frame| {
        if *mute.lock().unwrap() {
            // It goes out, and nobody says so.
            sim.exchange(frame);
            return Way::Frozen;
        }
        Way::OntoTheBus
    });
    let mut link = rig.adapter.open();
    let mut station = station(&mut link);
    station.bring_up().unwrap();
    *is_mute.lock().unwrap() = true;
    let cycle = |station: &mut Station<'_>| {
        station
            .cycle(|master, number| {
                for axis in 0..2 {
                    // Refused once the axis has stopped.
                    let _ = master.set_target(axis, number as i32 / 20);
                }
            })
            .unwrap();
    };
    let start = station.now();
    let is_anchored = |axis: AxisSnapshot| axis.facts.knowledge == Knowledge::Anchored;
    while station.snapshots().any(is_anchored) {
        cycle(&mut station);
        assert!(station.now().us_since(start) < 10_000_000, "no fault");
    }
    for axis in station.snapshots() {
        assert_eq!(axis.fault, Some(Fault::Bus), "{axis:?}");
        assert!(!axis.facts.moves(), "{axis:?}");
    }
    *is_mute.lock().unwrap() = false;
    // Refused until the drives have said whether they still hold.
    let clear = |station: &mut Station<'_>| {
        let now = station.now();
        station.master().clear(now, GROUP)
    };
    while clear(&mut station).is_err() {
        cycle(&mut station);
        assert!(station.now().us_since(start) < 20_000_000, "no clear");
    }
    while !station.snapshots().all(is_anchored) {
        cycle(&mut station);
        assert!(station.now().us_since(start) < 20_000_000, "no anchor");
    }
    let sent: Vec<i64> = station
        .snapshots()
        .map(|axis| axis.sent_counts.into())
        .collect();
    let mut sim = rig.sim.lock().unwrap();
    let reached = [1, 2].map(|drive| sim.drive(drive).commanded_counts());
    assert_eq!(sent, reached);
}
