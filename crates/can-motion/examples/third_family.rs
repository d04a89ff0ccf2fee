//! A family of drives that is not ours, in one file: copy it to bring your own drives to the master.
//!
//! | identifier | data | meaning |
//! |---|---|---|
//! | 0x100 + n | i32, little endian | absolute target in counts, in every cycle of motion |
//! | 0x200 + n | 0 or 1 | power off, power on |
//! | 0x300 + n | none | asks for the state |
//! | 0x380 + n | flags, i32 | bit 0 power, bit 1 alarm, bit 2 the shaft stands; position in counts |
//!
//! The drive itself is simulated in `toy_drive.rs`. `cargo run -p can-motion --example third_family` moves one, stops it and switches it
//! off.

use can_frame::{DataFrame, FrameError};
use can_motion::facts::{Class, Facts, Loss, Work};
use can_motion::family::{
    BehindFrames, Context, CycleConfig, Drive, Family, FaultKind, Meaning, OutOfTravel, Plan,
    PowerReport, ProcedureRefusal, Returned, View, Wanted,
};
use can_motion::{AxisState, CommonEvent, Confirmation, GroupId, Instant, Reaction, Stage};

/// Unanswered questions in a row after which a drive is lost.
const LOST_AFTER: u8 = 3;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToyFault {
    Alarm,
    Lost,
    Bus,
    NotConfirmed,
    SwitchedOff,
    SwitchedOn,
    OutsideTravel,
    Group,
}

impl FaultKind for ToyFault {
    const GROUP: Self = Self::Group;
    const BUS: Self = Self::Bus;
    const LOST: Self = Self::Lost;
    const NOT_CONFIRMED: Self = Self::NotConfirmed;
    const SWITCHED_OFF: Self = Self::SwitchedOff;
    const SWITCHED_ON: Self = Self::SwitchedOn;

    fn loss(self) -> Loss {
        match self {
            Self::Alarm => Loss::Drive,
            Self::Lost | Self::Bus => Loss::Contact,
            Self::OutsideTravel => Loss::Knowledge,
            _ => Loss::Anchor,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToyEvent {
    Common(CommonEvent<ToyFault>),
    Foreign,
}

impl From<CommonEvent<ToyFault>> for ToyEvent {
    fn from(event: CommonEvent<ToyFault>) -> Self {
        Self::Common(event)
    }
}

/// The settings of one axis.
#[derive(Debug, Clone, Copy)]
pub struct ToyAxis {
    pub drive: u8,
    pub travel: (i32, i32),
    /// Counts in one cycle at most.
    pub max_step: i32,
}

/// The settings of the bus: a cycle of 1 ms.
#[derive(Debug, Clone, Copy)]
pub struct ToyBus;

impl CycleConfig for ToyBus {
    fn cycle_us(&self) -> u32 {
        1_000
    }
    fn requests_per_cycle(&self) -> u8 {
        1
    }
    fn stuck_us(&self) -> u32 {
        20_000
    }
    fn confirm_us(&self) -> u32 {
        50_000
    }
    fn standstill_limit_us(&self) -> u32 {
        1_000_000
    }
}

/// Nothing is proved about this bus; a family that is meant counts its frames here.
pub struct ToyPlan<'a>(&'a [ToyAxis]);

impl Plan<Toy> for ToyPlan<'_> {
    fn config(&self) -> &ToyBus {
        &ToyBus
    }
    fn axes(&self) -> &[ToyAxis] {
        self.0
    }
    fn admit(&self, room: usize) -> Result<(), &'static str> {
        let is_sorted = self.0.windows(2).all(|pair| pair[0].drive < pair[1].drive);
        let fits = !self.0.is_empty() && self.0.len() <= room;
        let works = is_sorted && fits && self.0.iter().all(|axis| axis.max_step > 0);
        works.then_some(()).ok_or("check the axes")
    }
    fn placement(&self) -> BehindFrames {
        BehindFrames
    }
    fn warnings(&self) -> impl Iterator<Item = ToyEvent> {
        core::iter::empty()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Toy;

impl Family for Toy {
    type Frame = DataFrame;
    type Config = ToyBus;
    type AxisConfig = ToyAxis;
    type ConfigError = &'static str;
    type Plan<'a> = ToyPlan<'a>;
    type Placement = BehindFrames;
    type Drive = ToyDrive;
    type Request = ();
    type Procedure = ();
    type ProcedureError = ProcedureRefusal;
    type Fault = ToyFault;
    type EventKind = ToyEvent;
    type Snapshot = (AxisState, Option<ToyFault>, i32);

    const HAS_CYCLE_FRAMES: bool = false;

    fn plan<'a>(_: &ToyBus, axes: &'a [ToyAxis]) -> ToyPlan<'a> {
        ToyPlan(axes)
    }
    fn address_of(axis: &ToyAxis) -> u8 {
        axis.drive
    }
    fn drive(_: &ToyBus, axis: &ToyAxis, _: u32) -> ToyDrive {
        ToyDrive {
            config: *axis,
            target: 0,
            sent: 0,
            step: 0,
            position: 0,
            ramp_step: None,
            asked_at: None,
            missed: 0,
        }
    }
    fn address(frame: &DataFrame) -> Option<u8> {
        Some((frame.id() & 0x7F) as u8)
    }
    fn foreign(_: &DataFrame) -> ToyEvent {
        ToyEvent::Foreign
    }
    fn not_ours(_: FrameError) -> ToyEvent {
        ToyEvent::Foreign
    }
}

/// One drive: its ledger, and the question that it owes an answer to.
#[derive(Debug)]
pub struct ToyDrive {
    config: ToyAxis,
    target: i32,
    sent: i32,
    step: i32,
    position: i32,
    /// Change of the step from cycle to cycle while slowing down.
    ramp_step: Option<i32>,
    asked_at: Option<Instant>,
    missed: u8,
}

impl ToyDrive {
    fn frame(&self, kind: u16, data: &[u8]) -> Option<DataFrame> {
        DataFrame::new(kind | u16::from(self.config.drive), data).ok()
    }
    fn reaches(&self, counts: i32) -> bool {
        (self.config.travel.0..=self.config.travel.1).contains(&counts)
    }
}

impl Drive for ToyDrive {
    type Family = Toy;

    fn group(&self) -> GroupId {
        GroupId(0)
    }
    fn reaction_to(&self, _: ToyFault) -> Reaction {
        Reaction::Halt
    }
    fn snapshot(
        &self,
        state: AxisState,
        _: &Facts,
        fault: Option<ToyFault>,
    ) -> (AxisState, Option<ToyFault>, i32) {
        (state, fault, self.sent)
    }
    fn set_target(&mut self, target: i32) -> Result<(), OutOfTravel> {
        let (min, max) = self.config.travel;
        self.target = if self.reaches(target) { target } else { return Err(OutOfTravel { min, max }) };
        Ok(())
    }
    fn anchor(&mut self, _: Instant) -> Result<(), ToyFault> {
        (self.target, self.sent, self.step) = (self.position, self.position, 0);
        self.reaches(self.position).then_some(()).ok_or(ToyFault::OutsideTravel)
    }
    fn begin_ramp(&mut self, cycles: u32) {
        self.ramp_step = Some(self.step / cycles.max(1) as i32);
    }
    fn cycles_to_stop(&self) -> u32 {
        self.step.unsigned_abs().min(100)
    }
    fn can_stop_in(&self, cycles: u32) -> bool {
        self.reaches(self.sent.saturating_add(self.step.saturating_mul(cycles as i32)))
    }
    fn has_stopped(&self) -> bool {
        self.step == 0
    }
    fn end_motion(&mut self, _: bool) {
        (self.target, self.step, self.ramp_step) = (self.sent, 0, None);
    }
    fn cycle_frame(&mut self, _: &View) -> Result<DataFrame, ToyFault> {
        let most = self.config.max_step;
        self.step = match self.ramp_step {
            Some(change) if self.step.abs() > change.abs().max(1) => self.step - change,
            Some(_) => 0,
            None => self.target.saturating_sub(self.sent).max(-most).min(most),
        };
        let next = self.sent + self.step;
        self.frame(0x100, &next.to_le_bytes()).ok_or(ToyFault::Bus)
    }
    fn cycle_frame_accepted(&mut self, _: Instant) {
        self.sent += self.step;
    }
    fn switch(&self, on: bool) -> Option<DataFrame> {
        self.frame(0x200, &[u8::from(on)])
    }
    fn wanted(&self, view: &View, now: Instant, _: u32) -> Option<Wanted<()>> {
        let pause_us = if view.is_lost { 50_000 } else { 5_000 };
        let is_time = self.asked_at.is_none_or(|at| now.us_since(at) >= pause_us);
        is_time.then(|| Wanted::urgent(Class::Reading, ()))
    }
    fn request_frame(&self, (): ()) -> Option<DataFrame> {
        self.frame(0x300, &[])
    }
    fn request_accepted(
        &mut self,
        (): (),
        _: Instant,
        context: &mut Context<'_, Toy>,
    ) -> Meaning<ToyFault> {
        self.asked_at = Some(context.log.now);
        self.missed = self.missed.saturating_add(1);
        let is_lost = self.missed > LOST_AFTER && !context.view.is_lost;
        Meaning {
            fault: is_lost.then_some(ToyFault::Lost),
            ..Meaning::NONE
        }
    }
    fn returned(&mut self, frame: &DataFrame, _: &mut Context<'_, Toy>) -> Returned {
        match (frame.id() & 0x780, frame.data()) {
            (0x100, _) => {
                self.sent -= self.step;
                Returned::OfCycle
            }
            (0x200, [0]) => Returned::Switch(Class::SwitchOff),
            (0x200, _) => Returned::Switch(Class::SwitchOn),
            _ => Returned::Request,
        }
    }
    fn start_over(&mut self, _: Instant, _: bool) -> Stage {
        self.missed = 0;
        Stage::Probing
    }
    fn receive(&mut self, frame: &DataFrame, _: &mut Context<'_, Toy>) -> Meaning<ToyFault> {
        let (0x380, &[flags, a, b, c, d]) = (frame.id() & 0x780, frame.data()) else {
            return Meaning::NONE;
        };
        let Some(asked_at) = self.asked_at.filter(|_| self.missed > 0) else {
            return Meaning::NONE;
        };
        self.position = i32::from_le_bytes([a, b, c, d]);
        self.missed = 0;
        Meaning {
            fault: (flags & 2 != 0).then_some(ToyFault::Alarm),
            power: Some(PowerReport { is_on: flags & 1 != 0, asked_at }),
            is_checked: true,
            stands: Some(flags & 4 != 0),
            is_located: true,
            ..Meaning::NONE
        }
    }
    fn tick(&mut self, _: &mut Context<'_, Toy>) -> Meaning<ToyFault> {
        Meaning::NONE
    }
    fn admit(
        &self,
        (): (),
        _: Confirmation,
        view: &View,
        _: Instant,
    ) -> Result<Work, ProcedureRefusal> {
        let actual = AxisState::of(&view.facts, view.stage);
        Err(ProcedureRefusal::State { actual })
    }
}
