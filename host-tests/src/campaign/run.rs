//! Plays one scenario in virtual time.

use can_motion::{AxisState, Instant, MasterConfig, ServoMaster, service};
use drive_sim::{
    Bench, BitRate, Bus, ControllerConfig, ControllerState, DeviceId, DynDrive, DynDriveConfig,
    ErrorState, Frame, LogMode, NodeId, ReadBackUnit, ScriptedFaults,
};
use dyn_can::FunctionCode;
use embedded_can::Frame as _;
use embedded_can::nb::Can as _;

use super::application::{Application, Permission};
use super::generate::DRIVE_POWER_ON_US;
use super::injection::{Kind, Rig, id_of};
use super::mutation::{Leaky, Memory, Mutant, Mutation};
use super::observer::{Observer, Seen, drive_of};
use super::scenario::MOST_AXES;
use super::scenario::{Scenario, ServiceTiming};
use super::tap::{Note, Tap};
use super::violation::Violation;

const CYCLE_US: u64 = 1_000;

/// A fault that ends by itself.
struct Absence {
    until_us: u64,
    kind: Kind,
}

struct Run<'a> {
    scenario: &'a Scenario,
    mutation: Mutation,
    memory: Memory,
    bench: Bench<DynDrive, ScriptedFaults>,
    node: NodeId,
    devices: Vec<DeviceId>,
    master: ServoMaster<MOST_AXES>,
    application: Application,
    observer: Observer,
    next_injection: usize,
    skip_cycles: u64,
    collide: Option<usize>,
    absences: Vec<Absence>,
    bus_off: bool,
    notes: Vec<Note>,
}

/// Plays a scenario with a master under a mutation, [`Mutation::None`] for the master as it is.
///
/// # Errors
/// The first promise that was broken.
///
/// # Panics
/// When the generator draws what cannot be: that is a bug of the campaign.
pub fn run(scenario: &Scenario, mutation: Mutation) -> Result<(), Violation> {
    let mut run = Run::new(scenario, mutation);
    let cycles = scenario.duration_us / CYCLE_US;
    for cycle in 0..cycles {
        run.cycle((cycle + 1) * CYCLE_US * 1_000)?;
    }
    let seen = run.seen();
    let dropped = run.master.cycle_counters().events_dropped;
    run.observer.finish(&seen, scenario, dropped, run.now())
}

impl<'a> Run<'a> {
    fn new(scenario: &'a Scenario, mutation: Mutation) -> Self {
        let mut bus = Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new());
        bus.set_log(LogMode::Full);
        let mut bench = Bench::new(bus);
        let node = bench.add_master(ControllerConfig::bxcan(scenario.tx_order));
        let connect = |plan: &super::scenario::AxisPlan| {
            let drive = DynDriveConfig {
                response_delay: plan.response_delay,
                seed: plan.delay_seed,
                power_on_delay_ns: DRIVE_POWER_ON_US * 1_000,
                start_position_counts: plan.start_counts,
                read_back: if plan.fine_read_back {
                    ReadBackUnit::MovementPositions
                } else {
                    ReadBackUnit::CommandCounts
                },
                ..DynDriveConfig::new(plan.config.drive).with_revision(plan.revision)
            };
            let drive = match plan.curve {
                Some(group2) => DynDriveConfig { group2, ..drive },
                None => drive,
            };
            bench.add_device(DynDrive::new(drive), ControllerConfig::device())
        };
        let devices = scenario.axes.iter().map(connect).collect();
        let axes: Vec<_> = scenario.axes.iter().map(|axis| axis.config).collect();
        let config = MasterConfig {
            timeouts: mutation.timeouts(scenario.master.timeouts),
            ..scenario.master
        };
        let master =
            ServoMaster::new(config, &axes).expect("the generator draws configurations that work");
        Self {
            scenario,
            mutation,
            memory: Memory::default(),
            bench,
            node,
            devices,
            master,
            application: Application::new(scenario),
            observer: Observer::new(scenario),
            next_injection: 0,
            skip_cycles: 0,
            collide: None,
            absences: Vec::new(),
            bus_off: false,
            notes: Vec::new(),
        }
    }

    fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }

    fn cycle(&mut self, end_ns: u64) -> Result<(), Violation> {
        self.end_absences();
        self.inject();
        self.watch_bus_off();
        if self.skip_cycles > 0 {
            self.skip_cycles -= 1;
            self.bench.advance_to(end_ns);
        } else {
            self.begin_cycle();
            self.serve_until(end_ns)?;
            let now = self.now();
            self.mutant().end_cycle(now);
        }
        self.collect();
        let (seen, now) = (self.seen(), self.now());
        self.observer.cycle_ends(&seen, now)
    }

    fn mutant(&mut self) -> Mutant<'_> {
        Mutant {
            master: &mut self.master,
            mutation: self.mutation,
            memory: &mut self.memory,
            reply_us: u64::from(self.scenario.master.timeouts.reply_us),
        }
    }

    /// Ends the absences whose time is over.
    fn end_absences(&mut self) {
        let now_us = self.now().as_us();
        let is_over = |absence: &Absence| absence.until_us <= now_us;
        let (over, others): (Vec<_>, _) = std::mem::take(&mut self.absences)
            .into_iter()
            .partition(is_over);
        self.absences = others;
        for absence in over {
            let lasts = |other: &Absence| other.kind.absents_the_same(absence.kind);
            if self.absences.iter().any(lasts) {
                continue;
            }
            self.rig(|rig| absence.kind.end(rig));
        }
    }

    fn rig(&mut self, act: impl FnOnce(&mut Rig<'_>)) {
        let axes = self.scenario.axes.iter();
        let drives: Vec<_> = axes.map(|axis| axis.config.drive).collect();
        act(&mut Rig {
            bench: &mut self.bench,
            master: self.node,
            devices: &self.devices,
            drives: &drives,
        });
    }

    fn inject(&mut self) {
        let now_us = self.now().as_us();
        while let Some(injection) = self
            .scenario
            .injections
            .get(self.next_injection)
            .filter(|next| next.at_us <= now_us)
        {
            self.next_injection += 1;
            let master = &self.master;
            let is_faulted = |axis| {
                master
                    .snapshot(axis)
                    .is_some_and(|axis| axis.fault.is_some())
            };
            self.observer.injected(injection.kind, is_faulted);
            self.observer.bus_fails(injection.kind, self.now(), |axis| {
                let snapshot = self.master.snapshot(axis);
                snapshot.is_some_and(|axis| axis.state == AxisState::Streaming)
            });
            if let Some(us) = injection.kind.absence_us() {
                let (until_us, kind) = (now_us.saturating_add(us), injection.kind);
                self.absences.push(Absence { until_us, kind });
            }
            match injection.kind {
                Kind::MissCycles { cycles } => self.skip_cycles = cycles,
                Kind::Collide { axis } => self.collide = Some(axis),
                kind => self.rig(|rig| kind.apply(rig)),
            }
        }
    }

    /// What the driver of a controller does: on bus-off it empties the mailboxes, tells the master and starts the way back.
    fn watch_bus_off(&mut self) {
        let state = self.bench.bus().controller(self.node).state();
        let is_off = state == ControllerState::On(ErrorState::BusOff);
        let now = self.now();
        if is_off && !self.bus_off {
            let mut port = self.bench.port(self.node);
            port.abort_all();
            port.request_recovery().expect("the controller is bus-off");
            self.master.on_bus_off(now);
            self.observer.aborted();
        } else if !is_off && self.bus_off {
            self.mutant().recovered(now);
        }
        self.bus_off = is_off;
    }

    fn begin_cycle(&mut self) {
        let now = self.now();
        let mut permissions: Vec<Permission> = Vec::new();
        let mut repair = Vec::new();
        self.application.act(
            self.scenario,
            &mut self.master,
            now,
            |axis| repair.push(axis),
            &mut permissions,
        );
        for axis in repair {
            self.observer.repaired(axis);
            let silences = |absence: &Absence| matches!(absence.kind, Kind::Silence { axis: of, .. } if of == axis);
            self.absences.retain(|absence| !silences(absence));
            let drive = self.bench.device_mut(self.devices[axis]);
            let in_alarm = drive.alarm().is_alarm();
            drive.faults_mut().repeat_alarm_frames(None);
            drive.faults_mut().wake();
            if in_alarm {
                drive.faults_mut().reboot();
            }
        }
        for (axis, asked) in self.application.take_asked() {
            let drive = self.bench.device(self.devices[axis]);
            let led_counts = drive.target_counts(self.bench.now_ns());
            self.observer.asked_to_move(axis, asked, led_counts);
        }
        self.observer.cycle_begins(&permissions);
        self.mutant().begin_cycle(now);
    }

    fn serve_until(&mut self, end_ns: u64) -> Result<(), Violation> {
        loop {
            self.serve()?;
            let more = match self.scenario.service {
                ServiceTiming::EachFrame => self.bench.step_to(end_ns),
                ServiceTiming::EveryUs(us) => {
                    let next_ns = (self.bench.now_ns() / (us * 1_000) + 1) * us * 1_000;
                    self.bench.advance_to(next_ns.min(end_ns));
                    next_ns < end_ns
                }
            };
            if !more {
                return Ok(());
            }
        }
    }

    fn serve(&mut self) -> Result<(), Violation> {
        let now = self.now();
        let leaks = self.mutation == Mutation::CountsOnWouldBlock;
        let mut notes = std::mem::take(&mut self.notes);
        let mut mutant = Mutant {
            master: &mut self.master,
            mutation: self.mutation,
            memory: &mut self.memory,
            reply_us: u64::from(self.scenario.master.timeouts.reply_us),
        };
        let mut can = Leaky {
            inner: Tap::new(self.bench.port(self.node), &mut notes),
            leaks,
        };
        // Idle or blocked: the next frame on the bus, or the next cycle, is the next chance.
        let _ = service(&mut mutant, &mut can, now);
        // What ended on the wire belongs before what was just handed over.
        self.collect();
        let master = &self.master;
        self.observer
            .states((0..self.devices.len()).filter_map(|axis| master.snapshot(axis)));
        for &note in &notes {
            self.observer.note(note, self.scenario, now)?;
            self.provoke_collision(note);
        }
        notes.clear();
        self.notes = notes;
        Ok(())
    }

    /// The drive sends on the identifier on which the master has just asked.
    fn provoke_collision(&mut self, note: Note) {
        let (Some(axis), Note::Accepted(frame)) = (self.collide, note) else {
            return;
        };
        let id = id_of(drive_of(self.scenario, axis), FunctionCode::GeneralRead);
        if frame.id() == embedded_can::Id::Standard(id) {
            self.collide = None;
            let intruder = Frame::new(id, &[0x00, 0x00, 0x01]).expect("three bytes fit");
            let node = self.bench.node_of(self.devices[axis]);
            // A device has room for any number of frames.
            let _ = self.bench.port(node).transmit(&intruder);
        }
    }

    fn collect(&mut self) {
        for record in self.bench.bus_mut().log_mut().drain() {
            if record.node == self.node {
                self.observer.on_wire(&record);
            }
        }
        while let Some(event) = self.master.next_event() {
            self.observer.event(&event);
        }
    }

    fn seen(&self) -> Vec<Seen> {
        let see = |(axis, &device): (usize, &DeviceId)| {
            let drive = self.bench.device(device);
            let commanded_counts = drive.commanded_counts();
            let led_counts = drive.target_counts(self.bench.now_ns());
            self.master.snapshot(axis).map(|snapshot| Seen {
                snapshot,
                commanded_counts,
                led_counts,
            })
        };
        self.devices.iter().enumerate().filter_map(see).collect()
    }
}
