//! A family of drives that is not ours, in one file: copy it to bring your own drives to the master.
//!
//! | identifier | data | meaning |
//! |---|---|---|
//! | 0x100 + n | i32, little endian | absolute target in counts, in every cycle of motion |
//! | 0x200 + n | 0 or 1 | power off, power on |
//! | 0x300 + n | none | asks for the state |
//! | 0x380 + n | flags, i32 | bit 0 power, bit 1 alarm, bit 2 the shaft stands; position in counts |
//!
//! `cargo run -p can-motion --example third_family` runs a simulated one.
#![expect(missing_docs, reason = "an example to copy")]

use can_frame::DataFrame;
use can_motion::facts::{Class, Facts, Loss};
use can_motion::family::{
    AbsoluteLedger, BehindFrames, CommonFault, Context, CycleUs, Drive, Family, FaultKind, Meaning,
    OutOfTravel, PowerReport, ProcedureRefusal, Returned, Unplanned, ValueKind, ValueLimits, View,
    Wanted,
};
use can_motion::{AxisState, BusUser, CommonEvent, GroupId, Instant, Master, Outcome, Stage};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToyFault {
    Common(CommonFault),
    Alarm,
    OutsideTravel,
}

impl From<CommonFault> for ToyFault {
    fn from(fault: CommonFault) -> Self {
        Self::Common(fault)
    }
}

impl FaultKind for ToyFault {
    fn loss(self) -> Loss {
        match self {
            Self::Common(fault) => fault.loss(),
            // The drive lets go of its motor.
            Self::Alarm => Loss::Drive,
            Self::OutsideTravel => Loss::Knowledge,
        }
    }
}

/// The settings of one axis.
#[derive(Debug, Clone, Copy)]
pub struct ToyAxis {
    pub drive: u8,
    pub limits: ValueLimits,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Toy;

impl Family for Toy {
    type Frame = DataFrame;
    type Config = CycleUs;
    type AxisConfig = ToyAxis;
    type ConfigError = &'static str;
    type Plan<'a> = Unplanned<'a, Self>;
    type Placement = BehindFrames;
    type Drive = ToyDrive;
    type Request = ();
    type Procedure = ();
    type ProcedureError = ProcedureRefusal;
    type Fault = ToyFault;
    type EventKind = CommonEvent<ToyFault>;
    type Snapshot = (AxisState, Option<ToyFault>, i32);

    const HAS_CYCLE_FRAMES: bool = false;

    fn plan<'a>(config: &CycleUs, axes: &'a [ToyAxis]) -> Unplanned<'a, Self> {
        let is_sorted = axes.windows(2).all(|pair| pair[0].drive < pair[1].drive);
        let moves = axes.iter().all(|axis| axis.limits.max_step > 0);
        let checked = (is_sorted && moves && axes.len() <= 8).then_some(());
        Unplanned {
            config: *config,
            axes,
            checked: checked
                .ok_or("give 1 to 8 axes in ascending order of drive, each with a step"),
        }
    }
    fn address_of(axis: &ToyAxis) -> u8 {
        axis.drive
    }
    fn drive(_: &CycleUs, axis: &ToyAxis, _: u32) -> ToyDrive {
        ToyDrive {
            config: *axis,
            ledger: AbsoluteLedger::new(ValueKind::Position),
            position: 0,
            asked_at: None,
            missed: 0,
        }
    }
    fn address(frame: &DataFrame) -> Option<u8> {
        Some((frame.id() & 0x7F) as u8)
    }
}

/// One drive: its ledger, and the question that it owes an answer to.
#[derive(Debug)]
pub struct ToyDrive {
    config: ToyAxis,
    ledger: AbsoluteLedger,
    position: i32,
    asked_at: Option<Instant>,
    missed: u8,
}

impl ToyDrive {
    fn frame(&self, kind: u16, data: &[u8]) -> Option<DataFrame> {
        DataFrame::new(kind | u16::from(self.config.drive), data).ok()
    }
}

impl Drive for ToyDrive {
    type Family = Toy;

    fn snapshot(
        &self,
        _: Instant,
        state: AxisState,
        _: &Facts,
        fault: Option<ToyFault>,
    ) -> (AxisState, Option<ToyFault>, i32) {
        (state, fault, self.ledger.sent())
    }
    fn set_target(&mut self, target: i32) -> Result<(), OutOfTravel> {
        let ValueLimits { min, max, .. } = self.config.limits;
        let is_inside = self.ledger.accept_target(target, &self.config.limits);
        is_inside.then_some(()).ok_or(OutOfTravel { min, max })
    }
    fn anchor(&mut self, _: Instant) -> Result<(), ToyFault> {
        self.ledger.anchor(self.position);
        let ValueLimits { min, max, .. } = self.config.limits;
        let is_inside = (min..=max).contains(&self.position);
        is_inside.then_some(()).ok_or(ToyFault::OutsideTravel)
    }
    fn begin_ramp(&mut self, cycles: u32) {
        self.ledger.begin_ramp(cycles);
    }
    fn cycles_to_stop(&self) -> u32 {
        self.ledger.cycles_to_stop(&self.config.limits)
    }
    fn can_stop_in(&self, cycles: u32) -> bool {
        self.ledger.can_stop_in(cycles, &self.config.limits)
    }
    fn has_stopped(&self) -> bool {
        self.ledger.has_stopped()
    }
    fn end_motion(&mut self, _: bool) {
        self.ledger.end_motion();
    }
    fn cycle_frame(&mut self, _: &View) -> Result<DataFrame, ToyFault> {
        let value = self.ledger.offer(&self.config.limits);
        let frame = self.frame(0x100, &value.to_le_bytes());
        frame.ok_or(ToyFault::Common(CommonFault::Bus))
    }
    fn cycle_frame_accepted(&mut self, _: Instant) {
        self.ledger.accepted();
    }
    fn switch(&self, on: bool) -> Option<DataFrame> {
        self.frame(0x200, &[u8::from(on)])
    }
    fn wanted(&self, view: &View, now: Instant, _: u32) -> Option<Wanted<()>> {
        let pause_us = if view.is_lost { 50_000 } else { 5_000 };
        let asks = self.asked_at.is_none_or(|at| now.us_since(at) >= pause_us);
        asks.then(|| Wanted::urgent(Class::Reading, ()))
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
        let is_lost = self.missed > 3 && !context.view.is_lost;
        Meaning {
            fault: is_lost.then_some(CommonFault::Lost.into()),
            ..Meaning::NONE
        }
    }
    fn returned(&mut self, frame: &DataFrame, _: &mut Context<'_, Toy>) -> Returned {
        match (frame.id() & 0x780, frame.data()) {
            (0x100, &[a, b, c, d]) => {
                self.ledger.returned(i32::from_le_bytes([a, b, c, d]));
                Returned::OfCycle
            }
            (0x200, &[0]) => Returned::Switch(Class::SwitchOff),
            (0x200, _) => Returned::Switch(Class::SwitchOn),
            _ => Returned::Request,
        }
    }
    fn start_over(&mut self, _: Instant, _: bool) -> Stage {
        self.missed = 0;
        Stage::Probing
    }
    fn tick(&mut self, _: &mut Context<'_, Toy>) -> Meaning<ToyFault> {
        self.ledger.begin_cycle();
        Meaning::NONE
    }
    fn receive(&mut self, frame: &DataFrame, _: &mut Context<'_, Toy>) -> Meaning<ToyFault> {
        // One answer to one question.
        let asked_at = self.asked_at.filter(|_| self.missed > 0);
        let parts = (frame.id() & 0x780, frame.data(), asked_at);
        let (0x380, &[flags, a, b, c, d], Some(asked_at)) = parts else {
            return Meaning::NONE;
        };
        (self.position, self.missed) = (i32::from_le_bytes([a, b, c, d]), 0);
        Meaning {
            fault: (flags & 2 != 0).then_some(ToyFault::Alarm),
            power: Some(PowerReport {
                is_on: flags & 1 != 0,
                asked_at,
            }),
            is_checked: true,
            stands: Some(flags & 4 != 0),
            is_located: true,
            ..Meaning::NONE
        }
    }
}

/// The drive itself, simulated: it goes where it is told while it has power.
#[derive(Debug, Default)]
pub struct SimulatedToy {
    pub is_on: bool,
    pub has_alarm: bool,
    pub position: i32,
}

impl SimulatedToy {
    /// What the drive does with a frame of its master, and what it answers.
    pub fn take(&mut self, frame: &DataFrame) -> Option<DataFrame> {
        match (frame.id() & 0x780, frame.data()) {
            (0x100, &[a, b, c, d]) if self.is_on => {
                self.position = i32::from_le_bytes([a, b, c, d])
            }
            (0x200, [on]) => self.is_on = *on == 1 && !self.has_alarm,
            (0x300, []) => {
                let flags = u8::from(self.is_on) | u8::from(self.has_alarm) << 1 | 4;
                let [a, b, c, d] = self.position.to_le_bytes();
                return DataFrame::new(frame.id() | 0x80, &[flags, a, b, c, d]).ok();
            }
            _ => {}
        }
        None
    }
}

/// One cycle of the master with its drives, 1 and up.
pub fn cycle<const N: usize>(
    master: &mut Master<N, Toy>,
    drives: &mut [SimulatedToy],
    now: Instant,
) {
    let mut answers = Vec::new();
    master.begin_cycle(now);
    let mut sink = |frame: &DataFrame| {
        let drive = usize::from(frame.id() & 0x7F).checked_sub(1);
        answers.extend(drive.and_then(|drive| drives.get_mut(drive)?.take(frame)));
        Outcome::Accepted
    };
    let _ = master.send(now, &mut sink);
    for answer in answers {
        master.on_frame(now, &answer);
    }
}

fn main() {
    let limits = ValueLimits::new(0, 10_000, 20, 1);
    let axes = [1, 2].map(|drive| ToyAxis { drive, limits });
    let mut drives = [SimulatedToy::default(), SimulatedToy::default()];
    let mut master = Master::<2, Toy>::new(CycleUs(1_000), &axes).expect("axes that work");
    let group = GroupId(0);
    for ms in 0..1_000 {
        let now = Instant::from_us(ms * 1_000);
        match ms {
            50 => master.enable(now, group).expect("a ready group"),
            200..=599 => {
                let target = master.set_target(0, ms as i32 * 10 - 2_000);
                target.expect("a streaming axis");
            }
            600 => master.stop(now, group),
            800 => master.disable(now, group),
            _ => {}
        }
        cycle(&mut master, &mut drives, now);
        while let Some(event) = master.next_event() {
            println!("{} s, axis {:?}: {:?}", event.at, event.axis, event.kind);
        }
    }
    println!("in the end: {drives:?}");
    assert!(drives[0].position > 3_900 && !drives[0].is_on);
}
