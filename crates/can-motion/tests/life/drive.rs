//! The drive of the family: its ledger is the one for absolute values, and it keeps what the master told it.

use can_motion::facts::{Brake, Class, Facts, Work};
use can_motion::family::{
    AbsoluteLedger, Context, Drive, Meaning, OutOfTravel, ProcedureRefusal, Returned, ValueKind,
    View, Wanted,
};
use can_motion::plan::ResponseWindow;
use can_motion::{AxisState, Confirmation, EventLog, GroupId, Instant, Reaction, Stage};

use crate::family::{Axis, Fault, Frame, Kind, Script, Seen};

/// What the master told the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Call {
    BeginMotion,
    BeginRamp(u32),
    EndMotion {
        by_ramp: bool,
    },
    Merged,
    StartOver {
        is_cleared: bool,
    },
    /// A request was accepted, and leaves the controller at this time.
    Asked(u8, Instant),
    Returned(Frame),
    Abandon,
    BeginWork(Work),
    AbortWork,
    /// The drive was lost when it spoke.
    WasLost,
    /// Cycle, and since when nothing has changed.
    Heard(u32, Instant),
}

#[derive(Debug)]
pub(crate) struct ScriptDrive<const CYCLIC: bool> {
    axis: Axis,
    ledger: AbsoluteLedger,
    position: i32,
    wants: Option<Wanted<u8>>,
    calls: Vec<Call>,
    ticks: u32,
}

impl<const CYCLIC: bool> ScriptDrive<CYCLIC> {
    pub(crate) fn new(axis: Axis) -> Self {
        Self {
            axis,
            ledger: AbsoluteLedger::new(ValueKind::Position),
            position: 0,
            wants: None,
            calls: Vec::new(),
            ticks: 0,
        }
    }
}

impl<const CYCLIC: bool> Drive for ScriptDrive<CYCLIC> {
    type Family = Script<CYCLIC>;

    fn group(&self) -> GroupId {
        GroupId(self.axis.group)
    }
    fn reaction_to(&self, _: Fault) -> Reaction {
        self.axis.reaction
    }
    fn brake(&self) -> Brake {
        self.axis.brake
    }
    fn snapshot(&self, _: Instant, state: AxisState, facts: &Facts, fault: Option<Fault>) -> Seen {
        Seen {
            state,
            facts: *facts,
            fault,
            sent: self.ledger.sent(),
            target: self.ledger.target(),
            calls: self.calls.clone(),
            ticks: self.ticks,
        }
    }
    fn set_target(&mut self, target: i32) -> Result<(), OutOfTravel> {
        let (min, max) = (self.axis.limits.min, self.axis.limits.max);
        let is_inside = self.ledger.accept_target(target, &self.axis.limits);
        is_inside.then_some(()).ok_or(OutOfTravel { min, max })
    }
    fn anchor(&mut self, _: Instant) -> Result<(), Fault> {
        self.ledger.anchor(self.position);
        let is_inside = self.position <= self.axis.limits.max;
        is_inside.then_some(()).ok_or(Fault::OutsideTravel)
    }
    fn begin_motion(&mut self) {
        self.calls.push(Call::BeginMotion);
    }
    fn begin_ramp(&mut self, cycles: u32) {
        self.calls.push(Call::BeginRamp(cycles));
        self.ledger.begin_ramp(cycles);
    }
    fn cycles_to_stop(&self) -> u32 {
        self.ledger.cycles_to_stop(&self.axis.limits)
    }
    fn can_stop_in(&self, cycles: u32) -> bool {
        self.ledger.can_stop_in(cycles, &self.axis.limits)
    }
    fn has_stopped(&self) -> bool {
        self.ledger.has_stopped()
    }
    fn end_motion(&mut self, by_ramp: bool) {
        self.calls.push(Call::EndMotion { by_ramp });
        self.ledger.end_motion();
    }
    fn must_rearm(&self) -> bool {
        self.axis.rearms
    }
    fn merged(&mut self) {
        self.calls.push(Call::Merged);
    }
    fn owes_frame(&self, view: &View) -> bool {
        CYCLIC || view.facts.moves()
    }
    fn cycle_frame(&mut self, view: &View) -> Result<Frame, Fault> {
        let address = self.axis.address;
        let class = if CYCLIC {
            Class::of_cycle(&view.facts)
        } else {
            Class::SetPoint
        };
        match class {
            Class::SwitchOn => Ok(Frame::Switch(address, true)),
            Class::SwitchOff => Ok(Frame::Switch(address, false)),
            Class::StopFrame => Ok(Frame::Stop(address)),
            _ => {
                let value = self.ledger.offer(&self.axis.limits);
                if self.axis.forbidden == Some(value) {
                    return Err(Fault::OutsideTravel);
                }
                Ok(Frame::SetPoint(address, value))
            }
        }
    }
    fn cycle_frame_accepted(&mut self, _: Instant) {
        self.ledger.accepted();
    }
    fn cycle_frame_bits(&self) -> u8 {
        self.axis.frame_bits
    }
    fn poll_bits(&self) -> u8 {
        self.axis.poll_bits
    }
    fn switch(&self, on: bool) -> Option<Frame> {
        (!CYCLIC).then_some(Frame::Switch(self.axis.address, on))
    }
    fn wanted(&self, _: &View, _: Instant, _: u32) -> Option<Wanted<u8>> {
        self.wants
    }
    fn request_frame(&self, request: u8) -> Option<Frame> {
        Some(Frame::Ask(self.axis.address, request))
    }
    fn request_accepted(
        &mut self,
        request: u8,
        leaves_at: Instant,
        _: &mut Context<'_, Script<CYCLIC>>,
    ) -> Meaning<Fault> {
        self.calls.push(Call::Asked(request, leaves_at));
        self.wants = None;
        // The answer to the last of them is that the drive does not answer.
        let lost = (request == u8::MAX).then_some(Fault::Of(can_motion::facts::Loss::Contact));
        Meaning {
            fault: lost,
            ..Meaning::NONE
        }
    }
    fn returned(&mut self, frame: &Frame, _: &mut Context<'_, Script<CYCLIC>>) -> Returned {
        self.calls.push(Call::Returned(*frame));
        match *frame {
            Frame::SetPoint(_, value) => {
                self.ledger.returned(value);
                Returned::OfCycle
            }
            Frame::Stop(_) => Returned::OfCycle,
            Frame::Switch(_, true) => Returned::Switch(Class::SwitchOn),
            Frame::Switch(_, false) => Returned::Switch(Class::SwitchOff),
            Frame::Ask(..) => Returned::Request,
            _ => Returned::Foreign,
        }
    }
    fn start_over(&mut self, _: Instant, is_cleared: bool) -> Stage {
        self.calls.push(Call::StartOver { is_cleared });
        Stage::Probing
    }
    fn response_window(&self) -> Option<ResponseWindow> {
        self.axis.window
    }
    fn receive(
        &mut self,
        frame: &Frame,
        context: &mut Context<'_, Script<CYCLIC>>,
    ) -> Meaning<Fault> {
        match *frame {
            Frame::Says(_, meaning) => {
                self.calls.push(Call::Heard(
                    context.cycle,
                    context.view.since(context.log.now),
                ));
                if context.view.is_lost {
                    self.calls.push(Call::WasLost);
                }
                return meaning;
            }
            Frame::Wants(_, wanted) => self.wants = wanted,
            Frame::IsAt(_, position) => self.position = position,
            _ => {}
        }
        Meaning::NONE
    }
    fn streams_on(&mut self, _: Instant) -> bool {
        self.axis.is_plain
    }
    fn tick(&mut self, _: &mut Context<'_, Script<CYCLIC>>) -> Meaning<Fault> {
        self.ledger.begin_cycle();
        self.ticks += 1;
        Meaning::NONE
    }
    fn abandon_request(&mut self, _: &mut Context<'_, Script<CYCLIC>>) {
        self.calls.push(Call::Abandon);
    }
    fn admit(
        &self,
        procedure: Work,
        confirmation: Confirmation,
        _: &View,
        _: Instant,
    ) -> Result<Work, ProcedureRefusal> {
        match confirmation {
            Confirmation::Given => Ok(procedure),
            Confirmation::None => Err(ProcedureRefusal::NoSuchAxis { actual: 99 }),
        }
    }
    fn begin_work(&mut self, procedure: Work) {
        self.calls.push(Call::BeginWork(procedure));
    }
    fn abort_work(&mut self, log: &mut EventLog<'_, Kind>) {
        self.calls.push(Call::AbortWork);
        log.push(Kind::WorkAborted);
    }
}
