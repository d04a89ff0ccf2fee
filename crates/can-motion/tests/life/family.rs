//! A family whose drives say what a test wants: a frame from a drive is what it means to the master, so that no protocol stands between.

use std::cmp::Ordering;

use can_motion::facts::{Brake, Class, Facts, Loss, Work};
use can_motion::family::{
    CommonFault, CycleConfig, Family, FaultKind, Meaning, Plan, ProcedureRefusal, RequestPlacement,
    ValueLimits, Wanted,
};
use can_motion::plan::ResponseWindow;
use can_motion::{AxisState, BusFrame, CommonEvent, DriveMove, Instant, Reaction};

use crate::drive::{Call, ScriptDrive};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    Common(CommonFault),
    /// One of the drive that takes so much.
    Of(Loss),
    OutsideTravel,
}

impl From<CommonFault> for Fault {
    fn from(fault: CommonFault) -> Self {
        Self::Common(fault)
    }
}

impl FaultKind for Fault {
    fn loss(self) -> Loss {
        match self {
            Self::Common(fault) => fault.loss(),
            Self::Of(loss) => loss,
            Self::OutsideTravel => Loss::Knowledge,
        }
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self:?}")
    }
}

/// A frame on the bus; the first number is the address of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Frame {
    // From the master.
    SetPoint(u8, i32),
    Stop(u8),
    Switch(u8, bool),
    Ask(u8, u8),
    /// It starts the moves that were loaded.
    Trigger,
    /// Of the whole bus.
    Sync,
    // From a drive.
    Says(u8, Meaning<Fault>),
    /// What the drive is to be asked next.
    Wants(u8, Option<Wanted<u8>>),
    /// Where the drive is.
    IsAt(u8, i32),
}

impl BusFrame for Frame {
    type Error = &'static str;

    fn from_can(_: &impl embedded_can::Frame) -> Result<Self, Self::Error> {
        Err("these frames never see a driver")
    }
    fn to_can<F: embedded_can::Frame>(&self) -> Option<F> {
        None
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Common(CommonEvent<Fault>),
    Foreign(Frame),
    NotOurs(&'static str),
    Warned,
    WorkAborted,
}

impl From<CommonEvent<Fault>> for Kind {
    fn from(event: CommonEvent<Fault>) -> Self {
        Self::Common(event)
    }
}

/// Settings of the bus; the waiting times are the defaults.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bus {
    pub(crate) cycle_us: u32,
    pub(crate) requests: u8,
    pub(crate) has_sync: bool,
    pub(crate) place: Place,
}

pub(crate) const BUS: Bus = Bus {
    cycle_us: 1_000,
    requests: 1,
    has_sync: false,
    place: Place {
        before: u64::MAX,
        needs_requests: false,
        enough_bits: None,
        heard: None,
    },
};

impl CycleConfig for Bus {
    fn cycle_us(&self) -> u32 {
        self.cycle_us
    }
    fn requests_per_cycle(&self) -> u8 {
        self.requests
    }
}

/// Requests go out as soon as the frames of the axes of `before` are out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) before: u64,
    pub(crate) needs_requests: bool,
    /// Beside frames of fewer bits than these the shortest request fits, otherwise the longest.
    pub(crate) enough_bits: Option<u32>,
    /// What it was told: cycle, axes, and the longest answer.
    pub(crate) heard: Option<(u32, u8, Option<ResponseWindow>)>,
}

impl RequestPlacement for Place {
    fn begin_cycle(
        &mut self,
        cycle: u32,
        axes: u8,
        window: impl FnOnce() -> Option<ResponseWindow>,
    ) {
        self.heard = Some((cycle, axes, window()));
    }
    fn request_leaves(&self, now: Instant, cycle_started: Instant, frames: u32) -> Instant {
        // Everything that it knows can be read from this time.
        let (cycle, axes, window) = self.heard.unwrap_or_default();
        let waits = now.us_since(cycle_started);
        let window = window.map_or(0, |window| window.max_us);
        let frames = 10 * u64::from(frames) + 1_000 * u64::from(window);
        let us = 1_000_000 * u64::from(cycle) + 100_000 * u64::from(axes) + frames + waits;
        Instant::from_us(now.as_us() + us)
    }
    fn before(&self) -> u64 {
        self.before
    }
    fn needs_requests(&self) -> bool {
        self.needs_requests
    }
    fn preference(&mut self, frames_bits: u32) -> Option<Ordering> {
        self.enough_bits
            .map(|enough_bits| frames_bits.cmp(&enough_bits))
    }
}

/// Settings of one axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis {
    pub(crate) address: u8,
    pub(crate) group: u8,
    pub(crate) reaction: Reaction,
    pub(crate) brake: Brake,
    pub(crate) rearms: bool,
    pub(crate) limits: ValueLimits,
    /// A set-point that must not be sent.
    pub(crate) forbidden: Option<i32>,
    /// Streams without being called each cycle.
    pub(crate) is_plain: bool,
    pub(crate) window: Option<ResponseWindow>,
    pub(crate) frame_bits: u8,
    pub(crate) poll_bits: u8,
    /// Its drive can move by itself, within the travel.
    pub(crate) moves: bool,
    /// A move that its drive may have been loaded with before.
    pub(crate) old_load: Option<DriveMove>,
    /// For so long what it is to be asked stays the same.
    pub(crate) sure_for_us: u32,
    /// Before this time it is not to be asked anything.
    pub(crate) asks_from: Instant,
}

/// An axis of group 0 whose set-points change by 10 at most.
pub(crate) const fn axis(address: u8) -> Axis {
    Axis {
        address,
        group: 0,
        reaction: Reaction::Halt,
        brake: Brake::Absent,
        rearms: false,
        limits: ValueLimits::new(0, 1_000, 10, 2),
        forbidden: None,
        is_plain: false,
        window: None,
        frame_bits: 0,
        poll_bits: 0,
        moves: false,
        old_load: None,
        sure_for_us: 0,
        asks_from: Instant::from_us(0),
    }
}

/// `CYCLIC` drives get a frame in every cycle, in which their switches travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Script<const CYCLIC: bool>;

/// The settings, taken as they are: up to 3 axes.
#[derive(Debug)]
pub(crate) struct AsGiven<'a>(Bus, &'a [Axis]);

impl<const CYCLIC: bool> Plan<Script<CYCLIC>> for AsGiven<'_> {
    fn config(&self) -> &Bus {
        &self.0
    }
    fn axes(&self) -> &[Axis] {
        self.1
    }
    fn admit(&self, room: usize) -> Result<(), String> {
        (self.1.len() <= room)
            .then_some(())
            .ok_or_else(|| format!("room for {room}"))
    }
    fn placement(&self) -> Place {
        self.0.place
    }
    fn warnings(&self) -> impl Iterator<Item = Kind> {
        self.0.has_sync.then_some(Kind::Warned).into_iter()
    }
}

/// An axis at one moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) state: AxisState,
    pub(crate) facts: Facts,
    pub(crate) fault: Option<Fault>,
    pub(crate) sent: i32,
    pub(crate) target: i32,
    pub(crate) calls: Vec<Call>,
    pub(crate) ticks: u32,
    /// How often it was worked out when it is to be asked.
    pub(crate) looks: u32,
}

impl<const CYCLIC: bool> Family for Script<CYCLIC> {
    type Frame = Frame;
    type Config = Bus;
    type AxisConfig = Axis;
    type ConfigError = String;
    type Plan<'a> = AsGiven<'a>;
    type Placement = Place;
    type Drive = ScriptDrive<CYCLIC>;
    type Request = u8;
    type Procedure = Work;
    type ProcedureError = ProcedureRefusal;
    type Fault = Fault;
    type EventKind = Kind;
    type Snapshot = Seen;

    const HAS_CYCLE_FRAMES: bool = CYCLIC;

    fn plan<'a>(config: &Bus, axes: &'a [Axis]) -> AsGiven<'a> {
        AsGiven(*config, axes)
    }
    fn address_of(axis: &Axis) -> u8 {
        axis.address
    }
    fn drive(_: &Bus, axis: &Axis, _: u32) -> ScriptDrive<CYCLIC> {
        ScriptDrive::new(*axis)
    }
    fn frame_of_bus(config: &Bus) -> Option<Frame> {
        config.has_sync.then_some(Frame::Sync)
    }
    fn address(frame: &Frame) -> Option<u8> {
        match *frame {
            Frame::Sync | Frame::Trigger => None,
            Frame::SetPoint(address, _)
            | Frame::Stop(address)
            | Frame::Switch(address, _)
            | Frame::Ask(address, _)
            | Frame::Says(address, _)
            | Frame::Wants(address, _)
            | Frame::IsAt(address, _) => Some(address),
        }
    }
    fn is_trigger(frame: &Frame) -> bool {
        *frame == Frame::Trigger
    }
    fn foreign(frame: &Frame) -> Option<Kind> {
        Some(Kind::Foreign(*frame))
    }
    fn not_ours(error: &'static str) -> Option<Kind> {
        Some(Kind::NotOurs(error))
    }
}

/// What a drive is to be asked.
pub(crate) fn ask(request: u8, class: Class, overdue_cycles: i32) -> Option<Wanted<u8>> {
    Some(Wanted {
        class,
        request,
        overdue_cycles,
    })
}
