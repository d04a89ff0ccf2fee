//! One ZLAC8030L: its frames, its readings, its ledger, and the one transfer that it may owe.

use bus_user::Instant;
use zlac8030l::{
    ControlWord, DataFrame, HeartbeatWatch, NmtState, SdoClient, SdoEvent, SdoRequest, SetUp,
    SetUpStep, State, StatusWord, objects,
};

use crate::core::exit::Class;
use crate::core::facts::{Brake, Facts, Knowledge, Power, Work};
use crate::core::family::{
    Context, Drive, GroupId, Meaning, OutOfTravel, ProcedureRefusal, Reaction, Returned, View,
    Wanted,
};
use crate::core::procedure::Confirmation;
use crate::core::snapshot::Counters;
use crate::core::state::{AxisState, Stage};
use crate::core::targets::{AbsoluteLedger, ValueKind};
use crate::wheel::config::{WheelConfig, WheelMasterConfig, WheelMode};
use crate::wheel::event::{Log, WheelEventKind};
use crate::wheel::fault::WheelFault;
use crate::wheel::feedback::{WheelFeedback, WheelSnapshot};
use crate::wheel::process_data;
use crate::wheel::request::{HealthReading, Purpose, WheelRequest};
use crate::wheel::set_up;
use crate::wheel::transfer::{TransferError, is_owned};
use crate::wheel::way::Way;
use crate::wheel::zlac_family::Zlac;

/// Counts of a turn of the wheel with the 1024 encoder lines of its hub motors (200Bh).
const COUNTS_PER_TURN: u32 = 4_096;
/// A wheel that follows its set-points is not farther behind than it turns in this time at the speed of its profile.
const LAG_MS: u32 = 100;

/// A ZLAC8030L.
#[derive(Debug)]
pub struct Wheel {
    pub(super) config: WheelConfig,
    pub(super) master: WheelMasterConfig,
    pub(super) ledger: AbsoluteLedger,
    pub(super) feedback: WheelFeedback,
    pub(super) counters: Counters,
    pub(super) sdo: SdoClient,
    /// What the running transfer is for.
    pub(super) purpose: Option<Purpose>,
    pub(super) script: SetUp,
    pub(super) heartbeat: HeartbeatWatch,
    /// The drive has its mapping and its supervision: it takes targets once it is operational.
    pub(super) is_set_up: bool,
    /// The drive was told to be pre-operational, so that its mapping may change.
    pub(super) may_be_mapped: bool,
    /// The device type was read.
    pub(super) is_known: bool,
    /// The wheel is stopped by control word 2, until it moves again.
    pub(super) quick_stop: bool,
    /// A drive that is out of operation has taken the quick stop.
    pub(super) is_told_to_stop: bool,
    /// For so many cycles a ramp may still wait for a wheel that was in a move of its own.
    braking_cycles: u32,
    pub(super) reset: Reset,
    /// The abort of a transfer that was given up waits for the controller.
    pub(super) abort: Option<SdoRequest>,
    /// The procedure that the application started.
    pub(super) procedure: Option<SdoRequest>,
    /// Position mode: the next frame carries the edge that makes the drive take the target.
    pub(super) edge: bool,
    pub(super) timeouts_in_row: u8,
    /// When the latest transfer started.
    pub(super) asked_at: Instant,
    /// When the latest reading of health was asked, and which comes next.
    pub(super) health_asked_at: Option<Instant>,
    pub(super) health_next: HealthReading,
    pub(super) still_since: Option<Instant>,
    /// The way to the latest target of a position.
    pub(super) way: Way,
    /// Since when the wheel turns at another speed than it was told.
    pub(super) off_since: Option<Instant>,
}

/// Where the reset of a drive's fault stands (Z40: an edge of bit 7, then 0).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reset {
    /// A fault that is found is a fault.
    No,
    /// The application cleared: a fault that is found is reset.
    Allowed,
    /// The edge is to be written.
    Edge,
    /// The edge is to be taken back.
    Release,
}

impl Wheel {
    pub(super) fn new(config: WheelConfig, master: &WheelMasterConfig) -> Self {
        let timeouts = &master.timeouts;
        Self {
            config,
            master: *master,
            ledger: AbsoluteLedger::new(match config.mode {
                // Both end at 0.
                WheelMode::Velocity | WheelMode::Torque { .. } => ValueKind::Speed,
                WheelMode::Position { .. } => ValueKind::Position,
            }),
            feedback: WheelFeedback::default(),
            counters: Counters::default(),
            sdo: SdoClient::new(config.node, timeouts.sdo).with_quirks(config.quirks),
            purpose: None,
            script: SetUp::new(set_up::options(&config)),
            heartbeat: HeartbeatWatch::new(timeouts.heartbeat_lost_us),
            is_set_up: false,
            may_be_mapped: false,
            is_known: false,
            quick_stop: false,
            is_told_to_stop: false,
            braking_cycles: 0,
            reset: Reset::No,
            abort: None,
            procedure: None,
            edge: false,
            timeouts_in_row: 0,
            asked_at: Instant::default(),
            health_asked_at: None,
            health_next: HealthReading::default(),
            still_since: None,
            off_since: None,
            way: Way::default(),
        }
    }

    pub(super) const fn is_position(&self) -> bool {
        matches!(self.config.mode, WheelMode::Position { .. })
    }

    pub(super) const fn is_torque(&self) -> bool {
        matches!(self.config.mode, WheelMode::Torque { .. })
    }

    /// The drive takes the frame of a cycle.
    pub(super) fn takes_frames(&self) -> bool {
        self.is_set_up && self.heartbeat.state() == Some(NmtState::Operational)
    }

    /// The drive has farther to go than a wheel that follows its set-points lags behind: it makes a profile of its own, which goes on
    /// to its end however the set-points slow down.
    fn makes_own_move(&self) -> bool {
        let WheelMode::Position { profile_speed_rpm } = self.config.mode else {
            return false;
        };
        let lag = u32::from(profile_speed_rpm) * COUNTS_PER_TURN * LAG_MS / 60_000;
        let position = self.feedback.position_counts.map(|position| position.value);
        position.is_none_or(|position| position.abs_diff(self.ledger.sent()) > lag)
    }

    pub(super) fn status(&self) -> Option<StatusWord> {
        self.feedback.status.map(|status| status.value)
    }

    /// The control word of the frame of this cycle, by what that frame is for.
    fn control_word(&self, class: Class, facts: &Facts) -> ControlWord {
        let power = facts.power;
        let [before, edge] = ControlWord::start_move(zlac8030l::MoveKind::Absolute);
        let moves = match self.is_position() {
            // Without its anchor the ledger does not know where the wheel is: the drive takes no target from it.
            true if self.edge && facts.knowledge == Knowledge::Anchored => edge,
            true => before,
            false => ControlWord::ENABLE_OPERATION,
        };
        match class {
            Class::SetPoint if self.quick_stop => ControlWord::QUICK_STOP,
            Class::SetPoint => moves,
            Class::SwitchOff => ControlWord::DISABLE_VOLTAGE,
            Class::SwitchOn => match self.status().map(StatusWord::state) {
                Some(State::OperationEnabled) => ControlWord::ENABLE_OPERATION,
                // Nothing leads on from a state that no document describes.
                Some(state) => state
                    .toward_enabled()
                    .unwrap_or(ControlWord::DISABLE_VOLTAGE),
                None => ControlWord::DISABLE_VOLTAGE,
            },
            _ if power == Power::Off => ControlWord::DISABLE_VOLTAGE,
            _ if power == Power::On && !self.quick_stop => moves,
            // What may be energised brakes and holds; nothing here lets a wheel go on a slope without a word.
            _ => ControlWord::QUICK_STOP,
        }
    }

    /// What is set up in the drive.
    pub(super) fn steps(&self) -> [SetUpStep; set_up::STEPS] {
        set_up::steps(&self.master, &self.config)
    }

    /// The transfer that was given up leaves an abort behind for the drive.
    pub(super) fn note_abort(&mut self, event: &SdoEvent) {
        self.abort = event.abort().or(self.abort);
    }

    /// Forgets what was set up, because the drive did.
    pub(super) fn forget_set_up(&mut self) {
        self.is_set_up = false;
        self.may_be_mapped = false;
        self.heartbeat = HeartbeatWatch::new(self.master.timeouts.heartbeat_lost_us);
    }
}

impl Drive for Wheel {
    type Family = Zlac;

    fn group(&self) -> GroupId {
        self.config.group
    }

    fn reaction_to(&self, fault: WheelFault) -> Reaction {
        self.config.reactions.to(fault)
    }

    fn brake(&self) -> Brake {
        if self.config.load_can_fall {
            Brake::Unclear
        } else {
            Brake::Absent
        }
    }

    fn snapshot(
        &self,
        _: Instant,
        state: AxisState,
        facts: &Facts,
        fault: Option<WheelFault>,
    ) -> WheelSnapshot {
        WheelSnapshot {
            node: self.config.node,
            group: self.config.group,
            state,
            facts: *facts,
            fault,
            target: self.ledger.target(),
            sent: self.ledger.sent(),
            feedback: self.feedback,
            counters: self.counters,
        }
    }

    fn set_target(&mut self, target: i32) -> Result<(), OutOfTravel> {
        let values = self.config.limits.values;
        let (min, max) = (values.min, values.max);
        let before = self.ledger.target();
        let is_inside = self.ledger.accept_target(target, &values);
        self.begin_way(before);
        is_inside.then_some(()).ok_or(OutOfTravel { min, max })
    }

    /// The value at which the wheel stays: no speed, or where it is.
    fn anchor(&mut self, _: Instant) -> Result<(), WheelFault> {
        let value = if self.is_position() {
            self.located()?
        } else {
            0
        };
        self.ledger.anchor(value);
        self.edge = false;
        Ok(())
    }

    fn begin_motion(&mut self) {
        self.quick_stop = false;
        // A drive may take the control word before the target of the same frame: the first edge must find it.
        self.edge = false;
        self.off_since = None;
    }

    /// A move of the drive itself ends by quick stop, and so does torque, because a wheel without torque goes on turning; the ramp ends with
    /// their standstill.
    fn begin_ramp(&mut self, cycles: u32) {
        self.ledger.begin_ramp(cycles);
        if self.makes_own_move() || self.is_torque() {
            self.quick_stop = true;
            self.braking_cycles =
                self.master.timeouts.standstill_limit_us / self.master.cycle_us.max(1);
        }
    }

    fn cycles_to_stop(&self) -> u32 {
        self.ledger.cycles_to_stop(&self.config.limits.values)
    }

    fn can_stop_in(&self, cycles: u32) -> bool {
        self.ledger.can_stop_in(cycles, &self.config.limits.values)
    }

    fn has_stopped(&self) -> bool {
        self.ledger.has_stopped() && self.braking_cycles == 0
    }

    /// At once is by quick stop: the drive brakes as 605Ah says and stays energised.
    fn end_motion(&mut self, by_ramp: bool) {
        self.braking_cycles = 0;
        self.way = Way::Over;
        self.quick_stop |= !by_ramp;
        if self.is_position() {
            self.ledger.end_motion();
        } else {
            self.ledger.anchor(0);
        }
    }

    /// Released directly, a quick stop would be followed by the rest of the old move: it is left by switching off.
    fn must_rearm(&self) -> bool {
        self.is_position() && self.quick_stop
    }

    fn merged(&mut self) {
        self.counters.merged = self.counters.merged.wrapping_add(1);
    }

    /// A wheel does not stop because its master falls silent, so it gets a frame in every cycle, unless it is not this master's.
    fn owes_frame(&self, view: &View) -> bool {
        self.takes_frames() && view.facts.power != Power::FoundOn
    }

    fn cycle_frame(&mut self, view: &View) -> Result<DataFrame, WheelFault> {
        let class = Class::of_cycle(&view.facts);
        let word = self.control_word(class, &view.facts);
        let value = self.ledger.offer(&self.config.limits.values);
        let (node, mode) = (self.config.node, self.config.mode);
        Ok(process_data::command(node, mode, word, value))
    }

    fn cycle_frame_accepted(&mut self, now: Instant) {
        self.ledger.accepted();
        self.note_way(now);
        self.edge = !self.edge;
        self.counters.set_points = self.counters.set_points.wrapping_add(1);
    }

    /// A drive that takes no frames of a cycle is switched off by a transfer.
    fn switch(&self, on: bool) -> Option<DataFrame> {
        let word = objects::CONTROL_WORD.write(ControlWord::DISABLE_VOLTAGE.get());
        (!on && !self.takes_frames()).then(|| word.encode(self.config.node))
    }

    fn wanted(&self, view: &View, now: Instant, _: u32) -> Option<Wanted<WheelRequest>> {
        self.next_request(view, now)
    }

    fn request_frame(&self, request: WheelRequest) -> Option<DataFrame> {
        Some(request.encode(self.config.node))
    }

    fn request_accepted(
        &mut self,
        request: WheelRequest,
        _: Instant,
        context: &mut Context<'_, Zlac>,
    ) -> Meaning<WheelFault> {
        self.note_request(request, context.log.now);
        Meaning::NONE
    }

    fn returned(&mut self, frame: &DataFrame, context: &mut Context<'_, Zlac>) -> Returned {
        self.note_returned(frame, context)
    }

    fn start_over(&mut self, _: Instant, is_cleared: bool) -> Stage {
        self.feedback = WheelFeedback {
            nmt: self.feedback.nmt,
            ..WheelFeedback::default()
        };
        self.script = SetUp::new(set_up::options(&self.config));
        self.is_known = false;
        self.may_be_mapped = false;
        self.timeouts_in_row = 0;
        self.reset = if is_cleared {
            Reset::Allowed
        } else {
            Reset::No
        };
        Stage::Probing
    }

    fn receive(
        &mut self,
        frame: &DataFrame,
        context: &mut Context<'_, Zlac>,
    ) -> Meaning<WheelFault> {
        self.read(frame, context)
    }

    fn tick(&mut self, context: &mut Context<'_, Zlac>) -> Meaning<WheelFault> {
        self.ledger.begin_cycle();
        self.braking_cycles = match self.still_since {
            Some(_) => 0,
            None => self.braking_cycles.saturating_sub(1),
        };
        self.watch_way(&mut context.log);
        self.pass_time(context)
    }

    fn abandon_request(&mut self, context: &mut Context<'_, Zlac>) {
        self.sdo.abandon(context.log.now.as_us());
    }

    fn admit(
        &self,
        procedure: SdoRequest,
        confirmation: Confirmation,
        view: &View,
        _: Instant,
    ) -> Result<Work, TransferError> {
        if view.is_lost || view.facts.is_checking() {
            let actual = AxisState::of(&view.facts, view.stage);
            return Err(ProcedureRefusal::State { actual }.into());
        }
        if is_owned(&procedure) {
            return Err(TransferError::Owned {
                node: self.config.node,
            });
        }
        let writes = matches!(procedure, SdoRequest::Write(..));
        let stores = procedure.address() == objects::STORE.address();
        if writes && stores && confirmation == Confirmation::None {
            return Err(TransferError::Unconfirmed);
        }
        Ok(if writes { Work::Write } else { Work::Read })
    }

    fn begin_work(&mut self, procedure: SdoRequest) {
        self.procedure = Some(procedure);
    }

    fn abort_work(&mut self, log: &mut Log<'_>) {
        if self.purpose == Some(Purpose::Procedure) {
            // Its reply may still come, and ends nothing.
            self.purpose = None;
        }
        if self.procedure.take().is_some() {
            log.push(WheelEventKind::ProcedureAborted);
        }
    }
}
