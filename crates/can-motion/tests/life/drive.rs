//! The drive of the family: its ledger is the one for absolute values, and it keeps what the master told it.

use std::cell::Cell;

use can_motion::facts::{Brake, Class, Facts, Work};
use can_motion::family::{
    AbsoluteLedger, Context, Drive, Meaning, MoveReport, OutOfTravel, Outlook, ProcedureRefusal,
    Returned, ValueKind, View, Wanted,
};
use can_motion::plan::ResponseWindow;
use can_motion::{
    AxisState, Confirmation, DriveMove, EventLog, GroupId, Instant, MoveEnd, MoveRefusal, Reaction,
    Stage,
};

use crate::family::{Axis, Bus, Fault, Frame, Kind, Script, Seen};

/// The requests that are about a motion of the drive itself.
pub(crate) const MOVE: u8 = 200;
pub(crate) const LOAD: u8 = 201;
pub(crate) const TRIGGER: u8 = 202;

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
    BeginMove(DriveMove),
    EndMove(Instant, Option<MoveEnd>),
    KeepStamps {
        is_long_ago: bool,
    },
}

#[derive(Debug)]
pub(crate) struct ScriptDrive<const CYCLIC: bool> {
    axis: Axis,
    ledger: AbsoluteLedger,
    position: i32,
    /// What it is to be asked, and the cycle in which that was said.
    wants: Option<(Wanted<u8>, u32)>,
    calls: Vec<Call>,
    ticks: u32,
    looks: Cell<u32>,
    own_move: Option<DriveMove>,
    has_seen_load: bool,
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
            looks: Cell::new(0),
            own_move: None,
            has_seen_load: false,
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
            looks: self.looks.get(),
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
    fn wanted(&self, _: &View, now: Instant, cycle: u32) -> Option<Wanted<u8>> {
        if now < self.axis.asks_from {
            return None;
        }
        let (wanted, since) = self.wants?;
        // One that knows when it is to be asked counts the cycles until then.
        let counts = self.axis.sure_for_us > 0;
        let cycles = if counts { cycle.wrapping_sub(since) } else { 0 };
        let overdue_cycles = wanted.overdue_cycles.saturating_add_unsigned(cycles);
        Some(Wanted {
            overdue_cycles,
            ..wanted
        })
    }
    fn outlook(&self, view: &View, now: Instant, cycle: u32) -> Outlook {
        self.looks.set(self.looks.get() + 1);
        let wanted = self.wanted(view, now, cycle);
        let waits_us = self.axis.asks_from.us_since(now) as u32;
        Outlook {
            overdue_cycles: wanted.map(|wanted| wanted.overdue_cycles),
            for_us: self.axis.sure_for_us.max(waits_us),
        }
    }
    fn request_frame(&self, request: u8) -> Option<Frame> {
        Some(match request {
            TRIGGER => Frame::Trigger,
            _ => Frame::Ask(self.axis.address, request),
        })
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
            Frame::Ask(_, MOVE) => Returned::Switch(Class::DriveMove),
            Frame::Ask(_, LOAD) => Returned::Switch(Class::Load),
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
                if meaning.own_move == Some(MoveReport::LoadSeen) {
                    self.has_seen_load = true;
                }
                return meaning;
            }
            Frame::Wants(_, wanted) => self.wants = wanted.map(|wanted| (wanted, context.cycle)),
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
    fn keep_stamps(&mut self, _: Instant, is_long_ago: bool) {
        self.calls.push(Call::KeepStamps { is_long_ago });
    }
    fn admit_move(
        &self,
        wanted: DriveMove,
        by_trigger: bool,
        _: &Bus,
        _: Instant,
    ) -> Result<(), MoveRefusal> {
        let (min, max) = (self.axis.limits.min, self.axis.limits.max);
        match wanted {
            _ if !self.axis.moves => Err(MoveRefusal::Unsupported),
            DriveMove::Speed(_) | DriveMove::Wave { .. } if by_trigger => {
                Err(MoveRefusal::Unsupported)
            }
            DriveMove::To(end) if !(min..=max).contains(&end) => Err(MoveRefusal::Travel {
                min,
                max,
                actual: end.into(),
            }),
            _ => Ok(()),
        }
    }
    fn begin_move(&mut self, wanted: DriveMove, _: &Bus) {
        self.calls.push(Call::BeginMove(wanted));
        self.own_move = Some(wanted);
        self.has_seen_load = false;
    }
    fn has_seen_load(&self) -> bool {
        self.has_seen_load
    }
    fn loaded_move(&self) -> Option<DriveMove> {
        self.own_move
    }
    fn may_hold_load(&self, kind: DriveMove) -> bool {
        let discriminant = std::mem::discriminant(&kind);
        self.axis
            .old_load
            .is_some_and(|load| std::mem::discriminant(&load) == discriminant)
    }
    fn end_move(&mut self, now: Instant, how: Option<MoveEnd>) {
        self.calls.push(Call::EndMove(now, how));
        self.own_move = None;
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
