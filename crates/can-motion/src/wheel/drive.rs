//! One wheel: its state, its target, and the one transfer that its drive may owe.

use zlac8030l::{
    ControlWord, HeartbeatWatch, SdoClient, SdoEvent, SdoRequest, SetUp, SetUpStep, State,
    StatusWord,
};

use super::books::{Books, WheelRamp};
use super::config::{WheelConfig, WheelMasterConfig, WheelMode};
use super::event::WheelEventKind;
use super::fault::WheelFault;
use super::feedback::{WheelFeedback, WheelSnapshot};
use super::master::Zlac;
use super::set_up;
use crate::config::GroupId;
use crate::family::{self, Happening, Life};
use crate::fault::Reaction;
use crate::life::{AxisState, Reason};
use crate::snapshot::Counters;
use crate::time::Instant;

/// Where a wheel writes its events.
pub(super) type Log<'a> = family::Log<'a, WheelEventKind>;

/// An axis with a ZLAC8030L.
#[derive(Debug)]
pub struct Wheel {
    pub(super) config: WheelConfig,
    master: WheelMasterConfig,
    pub(super) state: AxisState,
    pub(super) fault: Option<WheelFault>,
    pub(super) books: Books,
    pub(super) feedback: WheelFeedback,
    pub(super) counters: Counters,
    pub(super) sdo: SdoClient,
    pub(super) script: SetUp,
    pub(super) heartbeat: HeartbeatWatch,
    /// The drive has its mapping and its supervision: it takes targets.
    pub(super) is_set_up: bool,
    /// An enable command went out, and no disable command since.
    pub(super) may_be_enabled: bool,
    /// The wheel is stopped by control word 2, until it streams again.
    pub(super) quick_stop: bool,
    /// A fault of the drive is to be reset once the drive answers again.
    pub(super) reset: Reset,
    /// An NMT command waits for the controller.
    pub(super) nmt_due: bool,
    /// The abort of a transfer that was given up waits for the controller.
    pub(super) abort: Option<SdoRequest>,
    /// The transfer that the application asked for and that the controller has not accepted yet.
    pub(super) wanted: Option<SdoRequest>,
    /// Position mode: the next frame carries the edge that makes the drive take the target.
    pub(super) edge: bool,
    pub(super) timeouts_in_row: u8,
    pub(super) still_since: Option<Instant>,
    /// Since when the wheel turns at another speed than it was told.
    pub(super) off_since: Option<Instant>,
    pub(super) since: Instant,
    /// The latest cycle, for what is asked between two cycles.
    pub(super) now: Instant,
    /// The fault found the wheel enabled and confirmed, so that it can hold when the fault is cleared.
    held: bool,
    ramp: Option<WheelRamp>,
    disable_after_ramp: bool,
}

/// Where the reset of a drive's fault stands (Z40: an edge of bit 7, then 0).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reset {
    /// No reset: a fault that is found is a fault.
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
            state: AxisState::PowerOn,
            fault: None,
            books: Books::default(),
            feedback: WheelFeedback::default(),
            counters: Counters::default(),
            sdo: SdoClient::new(config.node, timeouts.sdo).with_quirks(config.quirks),
            script: SetUp::new(set_up::options(&config)),
            heartbeat: HeartbeatWatch::new(timeouts.heartbeat_lost_us),
            is_set_up: false,
            may_be_enabled: false,
            quick_stop: false,
            reset: Reset::No,
            nmt_due: false,
            abort: None,
            wanted: None,
            edge: false,
            timeouts_in_row: 0,
            still_since: None,
            off_since: None,
            since: Instant::default(),
            now: Instant::default(),
            held: false,
            ramp: None,
            disable_after_ramp: false,
        }
    }

    pub(super) fn is_lost(&self) -> bool {
        self.fault == Some(WheelFault::Lost)
    }

    /// The value at which the wheel stays: no speed, or where it is.
    pub(super) fn anchor(&mut self) {
        let position = self.feedback.position_counts.map(|read| read.value);
        self.books.anchor(match self.config.mode {
            WheelMode::Velocity => 0,
            WheelMode::Position { .. } => position.unwrap_or(self.books.sent()),
        });
    }

    /// The control word of the next frame.
    pub(super) fn control_word(&self) -> ControlWord {
        use AxisState::{
            ConfirmingDisable, ConfirmingEnable, Disabling, Enabling, Holding, RampingDown,
            Streaming,
        };
        let status = self.feedback.status.map(|status| status.value);
        match (self.state, self.config.mode) {
            (Disabling | ConfirmingDisable, _) => ControlWord::DISABLE_VOLTAGE,
            // Released directly, a quick stop would be followed by the rest of the old move: leave it by switching off.
            (Enabling | ConfirmingEnable, WheelMode::Position { .. })
                if status.is_some_and(is_quick_stopped) =>
            {
                ControlWord::DISABLE_VOLTAGE
            }
            (Enabling | ConfirmingEnable, _) => status
                .and_then(|status| status.state().toward_enabled())
                .unwrap_or(ControlWord::ENABLE_OPERATION),
            (Streaming | RampingDown | Holding, WheelMode::Position { .. }) if !self.quick_stop => {
                let [before, edge] = ControlWord::start_move(zlac8030l::MoveKind::Absolute);
                if self.edge { edge } else { before }
            }
            (Streaming | RampingDown | Holding, _) if !self.quick_stop => {
                ControlWord::ENABLE_OPERATION
            }
            // What may be energised brakes and holds; nothing here lets a wheel go on a slope without a word.
            _ if self.may_be_enabled => ControlWord::QUICK_STOP,
            _ => ControlWord::DISABLE_VOLTAGE,
        }
    }

    fn advance_ramp(&mut self, log: &mut Log<'_>) {
        let Some(ramp) = &mut self.ramp else { return };
        if !ramp.is_done() {
            self.books.set_target(ramp.next_target());
        } else if self.books.target() == self.books.sent() {
            self.ramp = None;
            let next = if self.disable_after_ramp {
                AxisState::Disabling
            } else {
                AxisState::Holding
            };
            self.enter(next, Reason::Standstill, log);
        }
    }

    /// What the time that has passed means in this state.
    fn overdue(&mut self, config: &WheelMasterConfig, log: &mut Log<'_>) -> Option<WheelFault> {
        let timeouts = &config.timeouts;
        let elapsed_us = log.now.us_since(self.since);
        let over = |limit_us: u32| elapsed_us >= u64::from(limit_us);
        match self.state {
            AxisState::PowerOn if over(timeouts.power_on_us) => {
                self.enter(AxisState::Probing, Reason::Elapsed, log);
                None
            }
            AxisState::AwaitingStandstill if over(timeouts.standstill_limit_us) => {
                Some(WheelFault::ConfirmTimeout)
            }
            AxisState::CheckingStatus
            | AxisState::Anchoring
            | AxisState::Reanchoring
            | AxisState::ConfirmingEnable
                if over(timeouts.confirm_us) =>
            {
                Some(WheelFault::ConfirmTimeout)
            }
            AxisState::ConfirmingDisable if over(timeouts.confirm_us) => {
                // The command went out every cycle; a drive that does not say so is not asked for ever.
                self.enter(AxisState::Faulted, Reason::Elapsed, log);
                Some(WheelFault::ConfirmTimeout)
            }
            _ => None,
        }
    }

    /// A drive that is set up must be heard.
    fn silence(&self, config: &WheelMasterConfig, now: Instant) -> Option<WheelFault> {
        if !self.is_set_up || !self.state.is_known() || self.fault.is_some() {
            return None;
        }
        let limit_us = u64::from(config.timeouts.feedback_lost_us);
        let is_stale = |at: Option<Instant>| at.is_none_or(|at| now.us_since(at) >= limit_us);
        let stale = is_stale(self.feedback.status.map(|read| read.at))
            || is_stale(self.feedback.position_counts.map(|read| read.at));
        (stale || self.heartbeat.is_lost(now.as_us())).then_some(WheelFault::Lost)
    }

    /// An SDO transfer that a state needs had no answer.
    pub(super) fn miss(&mut self, lost_after: u8) -> Option<WheelFault> {
        self.timeouts_in_row = self.timeouts_in_row.saturating_add(1);
        if self.timeouts_in_row < lost_after {
            return None;
        }
        self.timeouts_in_row = 0;
        (!self.is_lost()).then_some(WheelFault::Lost)
    }

    /// What is set up in the drive.
    pub(super) fn steps(&self) -> [SetUpStep; set_up::STEPS] {
        set_up::steps(&self.master, &self.config)
    }

    /// The transfer that was given up leaves an abort behind for the drive.
    pub(super) fn note_abort(&mut self, event: &SdoEvent) {
        self.abort = event.abort().or(self.abort);
    }
}

impl Life for Wheel {
    type Family = Zlac;

    fn group(&self) -> GroupId {
        self.config.group
    }

    fn state(&self) -> AxisState {
        self.state
    }

    fn fault(&self) -> Option<WheelFault> {
        self.fault
    }

    fn may_be_enabled(&self) -> bool {
        self.may_be_enabled
    }

    fn reaction_to(&self, fault: WheelFault) -> Reaction {
        self.config.reactions.to(fault)
    }

    fn cycles_to_stop(&self) -> u16 {
        WheelRamp::cycles(&self.books, &self.config)
    }

    fn snapshot(&self) -> WheelSnapshot {
        WheelSnapshot {
            node: self.config.node,
            group: self.config.group,
            state: self.state,
            fault: self.fault,
            target: self.books.target(),
            sent: self.books.sent(),
            feedback: self.feedback,
            counters: self.counters,
        }
    }

    fn tick(&mut self, config: &WheelMasterConfig, log: &mut Log<'_>) -> Option<WheelFault> {
        self.now = log.now;
        self.advance_ramp(log);
        let ended = self.sdo.poll(log.now.as_us());
        let fault = ended.and_then(|event| self.transfer_ended(event, config, log));
        fault
            .or_else(|| self.silence(config, log.now))
            .or_else(|| self.overdue(config, log))
    }

    fn enter(&mut self, to: AxisState, reason: Reason, log: &mut Log<'_>) {
        // A stop that ends while a fault is latched does not end in readiness.
        let to = match to {
            AxisState::Ready | AxisState::Holding if self.fault.is_some() => AxisState::Faulted,
            AxisState::Streaming if self.resumes_a_move() => AxisState::Enabling,
            other => other,
        };
        log.push(Happening::State {
            from: self.state,
            to,
            reason,
        });
        match to {
            AxisState::Probing => self.start_over(),
            AxisState::CheckingStatus => self.nmt_due = self.reset == Reset::No,
            AxisState::AwaitingStandstill => self.still_since = None,
            // Where a quick stop ended is not where the targets led.
            AxisState::Streaming => {
                if self.quick_stop {
                    self.anchor();
                    self.quick_stop = false;
                }
                // A drive may take the control word before the target of the same frame: the first edge must find it.
                self.edge = false;
            }
            _ => {}
        }
        self.state = to;
        self.since = log.now;
    }

    fn start_ramp(&mut self, cycles: u16, then_disable: bool, reason: Reason, log: &mut Log<'_>) {
        self.ramp = Some(WheelRamp::new(&self.books, self.config.mode, cycles));
        self.disable_after_ramp = then_disable;
        self.enter(AxisState::RampingDown, reason, log);
    }

    fn disable_after_ramp(&mut self) {
        self.disable_after_ramp = true;
    }

    /// Brakes at once, as 605Ah says, and stays energised unless it is to be disabled.
    fn halt(&mut self, to: AxisState, reason: Reason, log: &mut Log<'_>) {
        self.anchor();
        self.ramp = None;
        self.quick_stop = true;
        self.held = self.state.is_enabled();
        self.enter(to, reason, log);
    }

    fn latch(&mut self, fault: WheelFault, log: &mut Log<'_>) {
        log.push(Happening::Fault(fault));
        if self
            .fault
            .is_none_or(|latched| latched == WheelFault::Group)
        {
            self.fault = Some(fault);
        }
    }

    fn clear(&mut self, log: &mut Log<'_>) {
        let Some(fault) = self.fault.take() else {
            return;
        };
        self.timeouts_in_row = 0;
        let next = if fault != WheelFault::Group {
            self.reset = Reset::Allowed;
            AxisState::Probing
        } else if self.held {
            AxisState::Holding
        } else {
            AxisState::Ready
        };
        self.enter(next, Reason::Command, log);
    }
}

/// Energised and stopped by control word 2.
fn is_quick_stopped(status: StatusWord) -> bool {
    status.state() == State::OperationEnabled && status.emergency_stop()
}

impl Wheel {
    /// A wheel in position mode is to stream again after a quick stop.
    fn resumes_a_move(&self) -> bool {
        let is_position = matches!(self.config.mode, WheelMode::Position { .. });
        is_position && self.quick_stop && self.state == AxisState::Holding
    }

    /// Nothing known of the drive is believed any more; it is read and compared anew.
    fn start_over(&mut self) {
        self.feedback = WheelFeedback::default();
        self.heartbeat = HeartbeatWatch::new(self.master.timeouts.heartbeat_lost_us);
        self.script = SetUp::new(set_up::options(&self.config));
        // A mapping changes only while PDOs rest; one that is right already is left in operation.
        self.nmt_due = !self.is_set_up;
    }
}
