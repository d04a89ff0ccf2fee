//! Plays one scenario of wheels in virtual time.

use can_motion::wheel::{
    FeedbackTiming, WheelEventKind, WheelMasterConfig, WheelMode, WheelTimeouts,
};
use can_motion::{AxisState, GroupId};
use drive_sim::{ControllerState, ErrorState, FrameMatch, Outage, OutageKind, ZlacDriveConfig};

use super::observer::{OUTAGE_SHOWS_US, Observer, broken};
use super::{MOTION_CYCLES, WheelScenario, WheelTrouble};
use crate::campaign::scenario::Command;
use crate::campaign::violation::{Promise, Violation};
use crate::rig::WheelRig;

/// Cycles from the last motion until every drive must be off: wheels slow down, and drives that started anew come back.
const CALM_CYCLES: u64 = 700;

const CYCLE_US: u64 = WheelMasterConfig::DEFAULT.cycle_us as u64;

/// How the run is broken, to see that the observer notices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WheelMutation {
    /// Not at all.
    None,
    /// Somebody clears and enables behind the back of the application.
    EnablesByItself,
    /// A bus on which nothing gets through for seconds is no fault.
    BridgesOutages,
    /// Nobody disables at the end.
    StaysOn,
    /// The limits are not those that the master was told.
    ChangesTooFast,
}

impl WheelMutation {
    /// Every broken run.
    pub const BROKEN: [Self; 4] = [
        Self::EnablesByItself,
        Self::BridgesOutages,
        Self::StaysOn,
        Self::ChangesTooFast,
    ];
}

struct Run<'a> {
    scenario: &'a WheelScenario,
    mutation: WheelMutation,
    rig: WheelRig,
    observer: Observer,
    cycle: u64,
    skip: u64,
    is_bus_off: bool,
    /// Faults that end by themselves: the cycle in which they do.
    ends: Vec<(u64, WheelTrouble)>,
    clear_at: [Option<u64>; 2],
    /// What the application asks of each wheel: speed, or position and its change.
    targets: Vec<(i32, i32)>,
}

/// Plays a scenario.
///
/// # Errors
/// The first promise that was broken.
///
/// # Panics
/// When the generator draws what cannot be: that is a bug of the campaign.
pub fn run(scenario: &WheelScenario, mutation: WheelMutation) -> Result<(), Violation> {
    let mut run = Run::new(scenario, mutation);
    while run.cycle < MOTION_CYCLES {
        run.cycle()?;
    }
    run.repair_all();
    while run.cycle < MOTION_CYCLES + CALM_CYCLES {
        run.cycle()?;
    }
    run.finish()
}

impl<'a> Run<'a> {
    fn new(scenario: &'a WheelScenario, mutation: WheelMutation) -> Self {
        let mut timeouts = WheelTimeouts {
            power_on_us: 50_000,
            ..WheelTimeouts::DEFAULT
        };
        if mutation == WheelMutation::BridgesOutages {
            // Each of them alone notices an outage.
            timeouts.stuck_us = 10_000_000;
            timeouts.feedback_lost_us = 10_000_000;
            timeouts.heartbeat_lost_us = 10_000_000;
        }
        let config = WheelMasterConfig {
            feedback: FeedbackTiming::Sync,
            timeouts,
            ..WheelMasterConfig::DEFAULT
        };
        let drives = scenario.wheels.iter().map(|wheel| ZlacDriveConfig {
            boot_delay_ns: 20_000_000,
            ..ZlacDriveConfig::new(wheel.node)
        });
        let mut wheels = scenario.wheels.clone();
        if mutation == WheelMutation::ChangesTooFast {
            wheels
                .iter_mut()
                .for_each(|wheel| wheel.limits.values.max_step *= 3);
        }
        Self {
            scenario,
            mutation,
            rig: WheelRig::wheels(config, &wheels, drives.collect()),
            observer: Observer::new(&scenario.wheels),
            cycle: 0,
            skip: 0,
            is_bus_off: false,
            ends: Vec::new(),
            clear_at: [None; 2],
            targets: vec![(0, 0); scenario.wheels.len()],
        }
    }

    fn in_group(&self, group: GroupId) -> Vec<usize> {
        let wheels = self.scenario.wheels.iter().enumerate();
        wheels
            .filter(|(_, wheel)| wheel.group == group)
            .map(|(index, _)| index)
            .collect()
    }

    fn cycle(&mut self) -> Result<(), Violation> {
        self.cycle += 1;
        self.watch_bus_off();
        self.end_troubles(self.cycle);
        self.begin_troubles();
        for group in [GroupId(0), GroupId(1)] {
            if !self.in_group(group).is_empty() {
                self.command(group);
            }
        }
        self.set_targets();
        if self.skip > 0 {
            self.skip -= 1;
            self.observer.misses_cycle(CYCLE_US);
            self.rig.skip_cycle();
        } else {
            self.rig.cycle();
        }
        self.observe()
    }

    fn watch_bus_off(&mut self) {
        let state = self.rig.bench.bus().controller(self.rig.node).state();
        let is_off = state == ControllerState::On(ErrorState::BusOff);
        let now = self.rig.now();
        if is_off && !self.is_bus_off {
            let mut port = self.rig.bench.port(self.rig.node);
            port.abort_all();
            port.request_recovery().expect("the controller is bus-off");
            self.rig.master.on_bus_off(now);
        } else if !is_off && self.is_bus_off {
            self.rig.master.on_bus_recovered(now);
        }
        self.is_bus_off = is_off;
    }

    fn begin_troubles(&mut self) {
        let now_us = self.rig.now().as_us();
        let (scenario, cycle) = (self.scenario, self.cycle);
        for (_, trouble) in scenario.troubles.iter().filter(|(at, _)| *at == cycle) {
            match *trouble {
                WheelTrouble::Trip { wheel, bits } => {
                    self.rig.drive_mut(wheel).faults_mut().trip(bits)
                }
                WheelTrouble::EmergencyInput { wheel } => {
                    self.rig.drive_mut(wheel).faults_mut().emergency_input(true)
                }
                WheelTrouble::PowerCycle { wheel, ms } => self
                    .rig
                    .drive_mut(wheel)
                    .faults_mut()
                    .power_cycle(ms * 1_000_000),
                WheelTrouble::LeaveBus { wheel, .. } => {
                    self.rig.drive_mut(wheel).faults_mut().leave_bus()
                }
                WheelTrouble::FallSilent { wheel, .. } => {
                    self.rig.drive_mut(wheel).faults_mut().fall_silent()
                }
                WheelTrouble::SpoilReply { wheel, damage } => self
                    .rig
                    .drive_mut(wheel)
                    .faults_mut()
                    .damage_next_reply(damage),
                WheelTrouble::Unplug { .. } => self.plug(false),
                WheelTrouble::Block { ms } => self.fail_bus(OutageKind::Blocked, ms),
                WheelTrouble::Disturb { ms } => self.fail_bus(OutageKind::Disturbed, ms),
                WheelTrouble::Corrupt { frames, at_bit } => {
                    let faults = self.rig.bench.bus_mut().faults_mut();
                    faults.corrupt_next(FrameMatch::ANY, frames, at_bit);
                }
                WheelTrouble::MissCycles { cycles } => self.skip = cycles,
            }
            if let WheelTrouble::LeaveBus { ms, .. }
            | WheelTrouble::FallSilent { ms, .. }
            | WheelTrouble::Unplug { ms } = *trouble
            {
                self.ends
                    .push((self.cycle + (ms * 1_000).div_ceil(CYCLE_US), *trouble));
            }
            for wheel in 0..self.targets.len() {
                let streams = self.rig.state(wheel) == AxisState::Streaming;
                if streams && trouble.outage_ms() * 1_000 > OUTAGE_SHOWS_US {
                    self.observer.bus_fails(wheel, now_us);
                }
            }
        }
    }

    fn end_troubles(&mut self, until: u64) {
        for (_, trouble) in self
            .ends
            .extract_if(.., |(at, _)| *at <= until)
            .collect::<Vec<_>>()
        {
            match trouble {
                WheelTrouble::LeaveBus { wheel, .. } | WheelTrouble::FallSilent { wheel, .. } => {
                    self.rig.drive_mut(wheel).faults_mut().wake()
                }
                WheelTrouble::Unplug { .. } => self.plug(!self.is_unplugged()),
                _ => {}
            }
        }
    }

    /// Whether one that was pulled meanwhile lasts longer.
    fn is_unplugged(&self) -> bool {
        self.ends
            .iter()
            .any(|(_, trouble)| matches!(trouble, WheelTrouble::Unplug { .. }))
    }

    fn plug(&mut self, is_in: bool) {
        for drive in self.rig.drives.clone() {
            let node = self.rig.bench.node_of(drive);
            self.rig.bench.bus_mut().set_connected(node, is_in);
        }
    }

    fn fail_bus(&mut self, kind: OutageKind, ms: u64) {
        let from_ns = self.rig.bench.now_ns();
        let until_ns = from_ns + ms * 1_000_000;
        let outage = Outage {
            kind,
            from_ns,
            until_ns,
        };
        self.rig
            .bench
            .bus_mut()
            .add_outage(outage)
            .expect("an outage that lasts");
    }

    /// Orders, recovery behind a fault, and power where there is none.
    fn command(&mut self, group: GroupId) {
        let now = self.rig.now();
        let wheels = self.in_group(group);
        let states: Vec<_> = wheels.iter().map(|wheel| self.rig.state(*wheel)).collect();
        let is_over = self.cycle >= MOTION_CYCLES;
        if is_over {
            if self.cycle == MOTION_CYCLES + 100 && self.mutation != WheelMutation::StaysOn {
                self.rig.master.disable(now, group);
            }
            return;
        }
        for (_, _, command) in self
            .scenario
            .orders
            .iter()
            .filter(|(at, of, _)| (*at, *of) == (self.cycle, group))
        {
            match command {
                Command::Stop => self.rig.master.stop(now, group),
                Command::Halt => {
                    self.rig.master.halt(now, group);
                    wheels.iter().for_each(|wheel| self.observer.halts(*wheel));
                }
                Command::Disable => self.rig.master.disable(now, group),
            }
        }
        let has_fault = wheels
            .iter()
            .any(|wheel| self.rig.axis(*wheel).fault.is_some());
        let slot = &mut self.clear_at[usize::from(group.0)];
        if has_fault {
            let at = slot.or(self
                .scenario
                .recover_after
                .map(|cycles| self.cycle + cycles));
            *slot = at;
            if at.is_some_and(|at| self.cycle >= at) {
                *slot = None;
                wheels.iter().for_each(|wheel| self.repair(*wheel));
                // The next recovery tries again.
                if self.rig.master.clear(now, group).is_ok()
                    && self.mutation == WheelMutation::EnablesByItself
                {
                    let _ = self.rig.master.enable(now, group);
                }
            }
        } else if states.iter().all(|state| *state == AxisState::Holding) {
            if self.rig.master.resume(now, group).is_ok() {
                wheels
                    .iter()
                    .for_each(|wheel| self.observer.may_move(*wheel));
            }
        } else if states
            .iter()
            .all(|state| matches!(state, AxisState::Ready | AxisState::Holding))
        {
            let is_enabled = self.rig.master.enable(now, group).is_ok();
            if is_enabled && self.mutation != WheelMutation::EnablesByItself {
                wheels.iter().for_each(|wheel| {
                    self.observer.may_be_on(*wheel);
                    self.observer.may_move(*wheel);
                });
            }
        }
    }

    fn repair(&mut self, wheel: usize) {
        let faults = self.rig.drive_mut(wheel).faults_mut();
        faults.remove_cause();
        faults.emergency_input(false);
    }

    fn repair_all(&mut self) {
        self.end_troubles(u64::MAX);
        (0..self.targets.len()).for_each(|wheel| self.repair(wheel));
    }

    /// Speeds and positions wander, from cycle to cycle as the limits allow; speeds sometimes jump.
    fn set_targets(&mut self) {
        for (index, wheel) in self.scenario.wheels.iter().enumerate() {
            if self.rig.state(index) != AxisState::Streaming {
                continue;
            }
            let phase = (self.cycle / 150 + index as u64) % 4;
            let target = match wheel.mode {
                WheelMode::Velocity => [120, -80, 0, 300][phase as usize],
                WheelMode::Torque { .. } => [400, -300, 0, 200][phase as usize],
                WheelMode::Position { .. } => {
                    let sent = self.rig.axis(index).sent;
                    let (_, speed) = self.targets[index];
                    let wanted = [150, -90, 0, 60][phase as usize];
                    let speed = speed + (wanted - speed).clamp(-5, 5);
                    self.targets[index] = (sent, speed);
                    sent + 2 * speed
                }
            };
            // Refused once a fault is there.
            let _ = self.rig.master.set_target(index, target);
        }
    }

    fn observe(&mut self) -> Result<(), Violation> {
        let (node, now_us) = (self.rig.node, self.rig.now().as_us());
        for event in std::mem::take(&mut self.rig.events) {
            if let (WheelEventKind::Fault(fault), Some(wheel)) = (event.kind, event.axis) {
                self.observer.faulted(usize::from(wheel), fault, now_us);
            }
        }
        for record in std::mem::take(&mut self.rig.traffic) {
            if record.node == node {
                self.observer.on_wire(&record)?;
            }
        }
        for wheel in 0..self.targets.len() {
            self.observer.state(wheel, self.rig.state(wheel), now_us)?;
        }
        Ok(())
    }

    /// Everything was disabled: no drive has power, and no wheel turns.
    fn finish(&self) -> Result<(), Violation> {
        let now_ns = self.rig.bench.now_ns();
        let now_us = now_ns / 1_000;
        for wheel in 0..self.targets.len() {
            let drive = self.rig.drive(wheel);
            let speed_rpm = drive.speed_rpm(now_ns);
            if drive.is_enabled() || speed_rpm.abs() > 1.0 {
                let state = self.rig.state(wheel);
                let what = format!(
                    "wheel {wheel}: enabled {}, {speed_rpm} r/min after disable, state {state}",
                    drive.is_enabled()
                );
                return broken(Promise::Commands, now_us, what);
            }
        }
        if self.scenario.troubles.is_empty() && !self.observer.faults.is_empty() {
            return broken(
                Promise::NoFalseAlarm,
                now_us,
                format!("without a cause: {}", self.observer.faults.join("; ")),
            );
        }
        if self.scenario.troubles.is_empty()
            && self.scenario.orders.is_empty()
            && !self.observer.moved
        {
            return broken(Promise::Orderly, now_us, "no wheel moved".to_string());
        }
        Ok(())
    }
}
