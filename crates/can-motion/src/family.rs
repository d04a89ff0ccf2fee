//! The seam between the master and a family of drives.
//!
//! One bus speaks one protocol, so a master has one family. What the families share is in `master`, `traffic` and `group`: the
//! cycle, the order of frames, the budget of requests, groups, latched faults and the reaction to them. What they do not share
//! is in the axis of the family, and reaches the master through the three traits below: its life, what it sends, what it hears.

use core::fmt::Debug;

use crate::bus_user::BusFrame;
use crate::config::GroupId;
use crate::event::{BusErrorKind, Events};
use crate::fault::Reaction;
use crate::life::{AxisState, Reason};
use crate::plan::ResponseWindow;
use crate::time::Instant;

/// Drives that speak one protocol.
pub trait Family: Debug + Clone + Copy + PartialEq + Eq {
    /// A frame on the wire.
    type Frame: BusFrame + Debug + Clone + Copy + PartialEq + Eq;
    /// Settings of the bus.
    type Config: CycleConfig + Debug + Copy;
    /// An axis of the master.
    type Axis: Life<Family = Self> + Sends + Hears + Debug;
    /// What a set-point frame carries, for the books.
    type SetPoint: Debug + Clone + Copy + PartialEq + Eq;
    /// A question to a drive, or a slow command.
    type Request: Debug + Clone + Copy + PartialEq + Eq;
    /// What can go wrong with an axis.
    type Fault: FaultKind + Debug;
    /// What an event tells.
    type EventKind: From<Happening<Self::Fault>> + Debug + Clone + Copy + PartialEq + Eq;
    /// An axis at one moment.
    type Snapshot: Debug;

    /// A drive stops by a frame and not by the silence of its master.
    const STOPS_BY_FRAME: bool;

    /// A frame that goes out once a cycle, behind the set-points.
    fn cycle_frame(config: &Self::Config) -> Option<Self::Frame>;

    /// The address of the drive that a frame comes from or goes to, 1..=127.
    fn address(frame: &Self::Frame) -> Option<u8>;

    /// The event of a frame of a drive without an axis.
    fn foreign(frame: &Self::Frame) -> Self::EventKind;

    /// The event of a frame that this protocol does not have.
    fn not_ours(error: <Self::Frame as BusFrame>::Error) -> Self::EventKind;
}

/// The settings that the cycle needs, whatever the family.
pub trait CycleConfig {
    /// Period of the cycle in microseconds.
    fn cycle_us(&self) -> u32;
    /// Requests that may go out in one cycle.
    fn requests_per_cycle(&self) -> u8;
}

/// What the master must know of a fault.
pub trait FaultKind: Clone + Copy + PartialEq + Eq {
    /// Another axis of the group has a fault.
    const GROUP: Self;
    /// The bus failed.
    const BUS: Self;

    /// The axis itself cannot follow a ramp any more.
    fn cannot_ramp(self) -> bool;
}

/// What happens to every axis and bus, whatever the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Happening<F> {
    /// The axis went from one state to another.
    State {
        /// The state that it left.
        from: AxisState,
        /// The state that it entered.
        to: AxisState,
        /// Why.
        reason: Reason,
    },
    /// A fault was latched.
    Fault(F),
    /// A set-point missed its cycle.
    SetPointMerged,
    /// Cycles that were never begun.
    CyclesMissed(u32),
    /// The controller reports an error.
    BusError(BusErrorKind),
    /// The controller is bus-off.
    BusOff,
    /// The controller takes part in the bus again.
    BusRecovered,
}

/// Where an axis writes its events.
#[derive(Debug)]
pub struct Log<'a, K> {
    pub(crate) events: &'a mut Events<K>,
    pub(crate) now: Instant,
    pub(crate) axis: u8,
}

impl<K> Log<'_, K> {
    pub(crate) fn push(&mut self, kind: impl Into<K>) {
        self.events.push(self.now, Some(self.axis), kind);
    }
}

/// Events of an axis.
pub(crate) type LogOf<'a, A> = Log<'a, <<A as Life>::Family as Family>::EventKind>;
/// Faults of an axis.
pub(crate) type FaultOf<A> = <<A as Life>::Family as Family>::Fault;
/// Settings of the bus of an axis.
pub(crate) type ConfigOf<A> = <<A as Life>::Family as Family>::Config;
/// Frames of an axis.
pub(crate) type FrameOf<A> = <<A as Life>::Family as Family>::Frame;
/// Requests of an axis.
pub(crate) type RequestOf<A> = <<A as Life>::Family as Family>::Request;
/// Set-points of an axis.
pub(crate) type SetPointOf<A> = <<A as Life>::Family as Family>::SetPoint;

/// State, group and fault of an axis.
pub trait Life {
    /// The family of its drive.
    type Family: Family;

    /// The group that it stops with.
    fn group(&self) -> GroupId;
    /// Where it is in its life.
    fn state(&self) -> AxisState;
    /// The latched fault.
    fn fault(&self) -> Option<FaultOf<Self>>;
    /// An enable command went out, and no disable command since.
    fn may_be_enabled(&self) -> bool;
    /// What a fault does to its group.
    fn reaction_to(&self, fault: FaultOf<Self>) -> Reaction;
    /// Cycles that it needs to stop within its limit.
    fn cycles_to_stop(&self) -> u16;
    /// The axis at this moment.
    fn snapshot(&self) -> <Self::Family as Family>::Snapshot;

    /// Lets a cycle pass.
    fn tick(&mut self, config: &ConfigOf<Self>, log: &mut LogOf<'_, Self>)
    -> Option<FaultOf<Self>>;
    /// Changes the state.
    fn enter(&mut self, to: AxisState, reason: Reason, log: &mut LogOf<'_, Self>);
    /// Slows down in so many cycles.
    fn start_ramp(
        &mut self,
        cycles: u16,
        then_disable: bool,
        reason: Reason,
        log: &mut LogOf<'_, Self>,
    );
    /// The ramp under way ends disabled.
    fn disable_after_ramp(&mut self);
    /// Stops at once.
    fn halt(&mut self, to: AxisState, reason: Reason, log: &mut LogOf<'_, Self>);
    /// Notes a fault; the first one of its own stays.
    fn latch(&mut self, fault: FaultOf<Self>, log: &mut LogOf<'_, Self>);
    /// The application has seen the fault.
    fn clear(&mut self, log: &mut LogOf<'_, Self>);
}

/// Whether a drive is to be switched on or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Switch {
    /// Power to the motor.
    Enable,
    /// No power to the motor.
    Disable,
}

/// Frames on their way out, and back. The books change only when the controller has accepted a frame.
pub trait Sends: Life {
    /// A set-point goes out every cycle.
    fn sends_each_cycle(&self) -> bool;
    /// The set-point of this cycle.
    fn set_point(&self) -> (FrameOf<Self>, SetPointOf<Self>);
    /// Bits of the set-point of this cycle on the wire.
    fn set_point_bits(&self) -> u16 {
        0
    }
    /// Bits of a request on the wire.
    fn request_bits(&self, _request: RequestOf<Self>) -> u16 {
        0
    }
    /// The frame that switches the drive.
    fn switch_frame(&self, switch: Switch) -> Option<FrameOf<Self>>;
    /// The request to send next, and for how many cycles it has been due; below 0 it is not due yet.
    fn wanted_request(&self, cycle: u32) -> Option<(RequestOf<Self>, i32)>;
    /// The frame of a request; `None` while the drive owes a reply.
    fn request_frame(&self, request: RequestOf<Self>) -> Option<FrameOf<Self>>;

    /// The controller accepted a set-point.
    fn stepped(&mut self, set_point: SetPointOf<Self>, now: Instant);
    /// The controller accepted a switch.
    fn switched(&mut self, switch: Switch, log: &mut LogOf<'_, Self>);
    /// The controller accepted a request.
    fn requested(
        &mut self,
        request: RequestOf<Self>,
        cycle: u32,
        config: &ConfigOf<Self>,
        log: &mut LogOf<'_, Self>,
    );
    /// The controller gave a frame back unsent. Returns whether it was a request.
    fn displaced(&mut self, frame: &FrameOf<Self>, cycle: u32, log: &mut LogOf<'_, Self>) -> bool;
    /// The set-point of this cycle is to be sent again.
    fn owes_set_point(&self) -> bool;
    /// The set-point of the cycle before was never accepted.
    fn merged(&mut self);
}

/// Frames on their way in.
pub trait Hears: Life {
    /// A request to this drive leaves the controller at this time.
    fn expect_reply(&mut self, _leaves: Instant) {}
    /// How long the drive takes to answer, as far as is known.
    fn response_window(&self) -> Option<ResponseWindow> {
        None
    }
    /// A frame of this drive came in.
    fn hear(
        &mut self,
        frame: &FrameOf<Self>,
        config: &ConfigOf<Self>,
        log: &mut LogOf<'_, Self>,
    ) -> Option<FaultOf<Self>>;
    /// For how long a fault that was just heard keeps all requests quiet.
    fn quiet_us(&mut self, fault: FaultOf<Self>, config: &ConfigOf<Self>) -> Option<u32>;
    /// The bus failed: a reply that is still awaited may come late, or never.
    fn abandon_request(&mut self, now: Instant, config: &ConfigOf<Self>);
}
