//! A master on a controller of its own, cycle by cycle.

use can_motion::facts::{Brake, Power};
use can_motion::family::{Meaning, PowerReport, Wanted};
use can_motion::{
    AxisState, BusErrorKind, BusUser, CommonEvent, GroupId, Instant, Master, Outcome, Progress,
    Reason, Sink,
};

use crate::drive::Call;
use crate::family::{Axis, BUS, Bus, Fault, Frame, Kind, Script, Seen};

pub(crate) const G: GroupId = GroupId(0);
pub(crate) const CYCLE_US: u32 = 1_000;

/// What the controller does with the frames that it is offered.
#[derive(Debug)]
pub(crate) struct Controller {
    pub(crate) sent: Vec<Frame>,
    /// Room for so many frames more.
    pub(crate) room: usize,
    /// It says beforehand when it is full; otherwise it refuses the frame that it is offered.
    pub(crate) knows_room: bool,
    /// The next frame fails.
    pub(crate) fails: Option<BusErrorKind>,
    /// The next frame displaces this one.
    pub(crate) displaces: Option<Frame>,
    /// What it gives back when asked.
    pub(crate) held: Vec<Frame>,
}

impl Sink<Frame> for Controller {
    fn offer(&mut self, frame: &Frame) -> Outcome<Frame> {
        if self.room == 0 {
            return Outcome::Full;
        }
        if let Some(kind) = self.fails.take() {
            return Outcome::Failed(kind);
        }
        self.room -= 1;
        self.sent.push(*frame);
        self.displaces
            .take()
            .map_or(Outcome::Accepted, Outcome::Displaced)
    }
    fn has_room(&self) -> bool {
        !self.knows_room || self.room > 0
    }
    fn take_back(&mut self) -> Option<Frame> {
        self.held.pop()
    }
}

/// A master for up to 3 axes with its controller; drives without a frame in every cycle.
pub(crate) type Rig<const CYCLIC: bool = false> = RigOf<CYCLIC, 3>;

/// A master for up to `N` axes with its controller.
#[derive(Debug)]
pub(crate) struct RigOf<const CYCLIC: bool, const N: usize> {
    pub(crate) master: Master<N, Script<CYCLIC>>,
    pub(crate) can: Controller,
    pub(crate) now: Instant,
    pub(crate) progress: Progress,
    addresses: Vec<u8>,
}

/// The drive is what it should be, stands, and says where.
pub(crate) const FINE: Meaning<Fault> = Meaning {
    is_checked: true,
    stands: Some(true),
    is_located: true,
    ..Meaning::NONE
};

impl<const N: usize> RigOf<false, N> {
    pub(crate) fn new(axes: &[Axis]) -> Self {
        Self::on(BUS, axes)
    }

    /// Every drive is checked and reports no power.
    pub(crate) fn ready(axes: &[Axis]) -> Self {
        let mut rig = Self::on(BUS, axes);
        rig.all_say(Meaning {
            is_checked: true,
            ..rig.power(false)
        });
        assert!(rig.every(AxisState::Ready));
        rig.forget()
    }

    /// Every drive streams.
    pub(crate) fn streaming(axes: &[Axis]) -> Self {
        let mut rig = Self::ready(axes);
        rig.master
            .enable(rig.now, G)
            .expect("drives that are ready");
        rig.stream()
    }

    /// Every drive holds.
    pub(crate) fn holding(axes: &[Axis]) -> Self {
        let mut rig = Self::streaming(axes);
        rig.master.halt(rig.now, G);
        assert!(rig.every(AxisState::Holding));
        rig.forget()
    }
}

impl<const CYCLIC: bool, const N: usize> RigOf<CYCLIC, N> {
    pub(crate) fn on(bus: Bus, axes: &[Axis]) -> Self {
        Self {
            master: Master::new(bus, axes).expect("a plan that is admitted"),
            can: Controller {
                sent: Vec::new(),
                room: usize::MAX,
                knows_room: false,
                fails: None,
                displaces: None,
                held: Vec::new(),
            },
            now: Instant::from_us(1_000_000),
            progress: Progress::Idle,
            addresses: axes.iter().map(|axis| axis.address).collect(),
        }
    }

    /// What is enabled gets as far as streaming.
    pub(crate) fn stream(mut self) -> Self {
        self.all_say(FINE);
        self.cycle();
        self.cycle();
        self.all_say(self.power(true));
        assert!(self.every(AxisState::Streaming), "{:?}", self.master);
        self.forget()
    }

    /// Nobody needs what happened so far.
    pub(crate) fn forget(mut self) -> Self {
        self.events();
        self.can.sent.clear();
        self
    }

    pub(crate) fn every(&self, state: AxisState) -> bool {
        (0..self.addresses.len()).all(|axis| self.state(axis) == state)
    }

    /// A report of power that was asked for just now.
    pub(crate) fn power(&self, is_on: bool) -> Meaning<Fault> {
        let asked_at = self.now;
        Meaning {
            power: Some(PowerReport { is_on, asked_at }),
            ..Meaning::NONE
        }
    }

    pub(crate) fn says(&mut self, address: u8, meaning: Meaning<Fault>) {
        self.master
            .on_frame(self.now, &Frame::Says(address, meaning));
    }

    pub(crate) fn all_say(&mut self, meaning: Meaning<Fault>) {
        for address in self.addresses.clone() {
            self.says(address, meaning);
        }
    }

    pub(crate) fn fails(&mut self, address: u8, fault: Fault) {
        self.says(address, Meaning::fault(fault));
    }

    pub(crate) fn brake(&mut self, address: u8, brake: Brake) {
        self.says(
            address,
            Meaning {
                brake: Some(brake),
                ..Meaning::NONE
            },
        );
    }

    pub(crate) fn wants(&mut self, address: u8, wanted: Option<Wanted<u8>>) {
        self.master
            .on_frame(self.now, &Frame::Wants(address, wanted));
    }

    /// The frames that go out now.
    pub(crate) fn send(&mut self) -> Vec<Frame> {
        self.progress = self.master.send(self.now, &mut self.can);
        std::mem::take(&mut self.can.sent)
    }

    /// The frames of the next cycle.
    pub(crate) fn cycle(&mut self) -> Vec<Frame> {
        self.cycle_after(CYCLE_US)
    }

    pub(crate) fn cycle_after(&mut self, us: u32) -> Vec<Frame> {
        self.now = self.now + us;
        self.master.begin_cycle(self.now);
        self.send()
    }

    pub(crate) fn events(&mut self) -> Vec<(Option<u8>, Kind)> {
        std::iter::from_fn(|| self.master.next_event())
            .map(|event| (event.axis, event.kind))
            .collect()
    }

    pub(crate) fn state(&self, axis: usize) -> AxisState {
        self.master.state(axis).expect("an axis")
    }

    pub(crate) fn states(&self) -> Vec<AxisState> {
        (0..self.addresses.len())
            .map(|axis| self.state(axis))
            .collect()
    }

    pub(crate) fn seen(&self, axis: usize) -> Seen {
        self.master.snapshot(axis).expect("an axis")
    }

    pub(crate) fn fault(&self, axis: usize) -> Option<Fault> {
        self.seen(axis).fault
    }

    /// What is known of the power of an axis.
    pub(crate) fn power_of(&self, axis: usize) -> Power {
        self.master.facts(axis).expect("an axis").power
    }

    /// What the drive was told after so many things.
    pub(crate) fn told_since(&self, axis: usize, before: usize) -> Vec<Call> {
        self.seen(axis).calls.split_off(before)
    }

    pub(crate) fn times_told(&self, axis: usize) -> usize {
        self.seen(axis).calls.len()
    }
}

/// The event of a change of state.
pub(crate) fn went(axis: u8, from: AxisState, to: AxisState, reason: Reason) -> (Option<u8>, Kind) {
    let event = CommonEvent::State { from, to, reason };
    (Some(axis), Kind::Common(event))
}

/// The event of a latched fault.
pub(crate) fn faulted(axis: u8, fault: impl Into<Fault>) -> (Option<u8>, Kind) {
    (Some(axis), Kind::Common(CommonEvent::Fault(fault.into())))
}

/// An event of the bus.
pub(crate) fn of_bus(event: CommonEvent<Fault>) -> (Option<u8>, Kind) {
    (None, Kind::Common(event))
}
