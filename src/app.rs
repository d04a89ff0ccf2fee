//! The application: the cycle of the master at its fixed rate, and the bus in between.

use can_motion::facts::{Input, Latch, Motion, Power, accepts};
use can_motion::family::Family;
use can_motion::{BusUser, Instant, Outcome, Sink};
use static_cell::{ConstStaticCell, StaticCell};

use crate::board::{InputPins, StatusLed, Watchdog};
use crate::bus::Bus;
use crate::config::{self, AXES, Drives, GROUP};
use crate::cycle_clock::{Beat, Beats};
use crate::debounce::Debounced;
use crate::drives::{Board as _, BoardMaster};
use crate::home::{Homing as _, Step};
use crate::led::{self, LedPattern};
use crate::machine;
use crate::misbehaviour::{self, Fault};
use crate::orders::Orders;
use crate::recovery::FaultState;
use crate::statistics::{Statistics, Stretch};
use crate::supervisor::{Action, Axes, Inputs, Supervisor};
use crate::telemetry::{self, Message};

/// Cycles for which joining the bus may take before it is reported, and again after each report.
const JOIN_REPORT_CYCLES: u32 = 1_000_000 / config::CYCLE_US;
/// Cycles for which a disable command after a failure may wait for room: 10 ms.
const DISABLE_PATIENCE_CYCLES: u32 = 10_000_u32.div_ceil(config::CYCLE_US);
/// A drive that has not confirmed a disable command by then is shown: the first repetition was not enough either.
const UNCONFIRMED_CYCLES: u32 = 2 * config::MASTER.timeouts.confirm_us / config::CYCLE_US;

// With 14 axes everything static, the log and its buffer included, has 8 KiB: `cargo xtask cost` counts the whole image. These are the
// parts that grow unseen.
const _: () = {
    assert!(
        size_of::<can_motion::ServoMaster<14>>() <= 6_376,
        "a master of 14 axes has outgrown its room"
    );
    assert!(
        size_of::<can_motion::ServoMaster<14>>() - size_of::<can_motion::ServoMaster<13>>() <= 352,
        "an axis has outgrown its room"
    );
    // The orders of a host are much more than the built-in motion.
    assert!(
        cfg!(feature = "link") || size_of::<App>() <= 288 + 4 * AXES + size_of::<config::Homing>(),
        "the application has outgrown its room"
    );
};

/// What the application works with.
pub(crate) struct Parts {
    /// The drives' bus.
    pub(crate) bus: Bus,
    /// The inputs.
    pub(crate) inputs: InputPins,
    /// The status LED.
    pub(crate) status_led: StatusLed,
    /// The watchdog, running.
    pub(crate) watchdog: Watchdog,
    /// The firmware failed since the supply came.
    pub(crate) is_locked: bool,
}

/// The configuration cannot work; what is left of the board.
pub(crate) struct Refused {
    /// Why.
    pub(crate) error: <Drives as Family>::ConfigError,
    /// The status LED.
    pub(crate) status_led: StatusLed,
    /// The watchdog, running.
    pub(crate) watchdog: Watchdog,
}

/// The application in the memory that it stays in, or the reason why the configuration cannot work. To be called once: a second call
/// panics.
pub(crate) fn place(parts: Parts, orders: Orders) -> Result<&'static mut App, Refused> {
    // All of it is zero, so it takes no place in the flash, and it is made a master where it lies: nearly all of the memory is in it.
    static MASTER: ConstStaticCell<BoardMaster> = ConstStaticCell::new(BoardMaster::vacant());
    static APP: StaticCell<App> = StaticCell::new();
    let master = MASTER.take();
    match machine::take_on(master) {
        Ok(()) => Ok(APP.init(App::new(master, parts, orders))),
        Err(error) => Err(Refused {
            error,
            status_led: parts.status_led,
            watchdog: parts.watchdog,
        }),
    }
}

/// How far the application is.
#[derive(Clone, Copy)]
enum Phase {
    /// Until the controller takes part in the traffic: for ever on a bus that is held dominant or has no transceiver. No drive can be
    /// reached meanwhile, so the inputs have nothing to say.
    Joining { cycles: u32 },
    /// The firmware that moved the drives has failed: each is told to disable, as far as the bus allows.
    Disabling { axis: usize, cycles: u32 },
    /// The master works.
    Running,
}

/// The cycle with everything it works with.
pub(crate) struct App {
    master: &'static mut BoardMaster,
    parts: Parts,
    phase: Phase,
    beats: Beats,
    bus_state: FaultState,
    stop_closed: Debounced,
    enable: Debounced,
    run: Debounced,
    supervisor: Supervisor,
    /// What the axes show, as of so many changes of their facts.
    seen: (u32, Seen),
    home: config::Homing,
    orders: Orders,
    statistics: Statistics,
    led: LedPattern,
    /// Cycles for which a drive has not confirmed its disable command.
    disabling_cycles: u32,
}

/// What the facts of the axes show.
#[derive(Clone, Copy)]
struct Seen {
    axes: Axes,
    /// A drive has not confirmed its disable command.
    disabling: bool,
}

impl App {
    fn new(master: &'static mut BoardMaster, parts: Parts, orders: Orders) -> Self {
        Self {
            seen: (master.changes(), look(master)),
            master,
            supervisor: Supervisor::new(parts.is_locked),
            parts,
            phase: Phase::Joining { cycles: 0 },
            beats: Beats::new(),
            bus_state: FaultState::ErrorActive,
            stop_closed: Debounced::new(),
            enable: Debounced::new(),
            run: Debounced::new(),
            home: config::Homing::NEW,
            orders,
            statistics: Statistics::new(),
            led: LedPattern::new(),
            disabling_cycles: 0,
        }
    }

    /// For the interrupt of the beat.
    pub(crate) fn cycle(&mut self) {
        let (stretch, beat) = (Stretch::begin(), self.beats.take());
        match self.phase {
            Phase::Joining { cycles } => self.join(cycles),
            Phase::Disabling { axis, cycles } => self.disable_from(axis, cycles),
            Phase::Running => self.run(beat, stretch),
        }
        // Only a cycle that came to its end says that the firmware lives.
        self.parts.watchdog.feed();
    }

    /// For the interrupts of the bus, which it enables when it runs.
    pub(crate) fn on_traffic(&mut self) {
        let stretch = Stretch::begin();
        self.service();
        self.statistics.note_service(stretch);
    }

    fn join(&mut self, cycles: u32) {
        if misbehaviour::has(Fault::WaitForTheBus) {
            while !self.parts.bus.recover() {}
        }
        self.parts.bus.check();
        if self.parts.bus.recover() {
            telemetry::tell(Message::OnTheBus);
            self.phase = if self.parts.is_locked {
                Phase::Disabling { axis: 0, cycles: 0 }
            } else {
                Phase::Running
            };
            return;
        }
        self.orders.wait(self.parts.is_locked);
        let cycles = cycles.wrapping_add(1);
        if cycles.is_multiple_of(JOIN_REPORT_CYCLES) {
            telemetry::tell(Message::BusNeverIdle);
        }
        self.phase = Phase::Joining { cycles };
        self.parts.status_led.set(self.led.play(led::OFF_THE_BUS));
    }

    fn disable_from(&mut self, axis: usize, cycles: u32) {
        let waiting = machine::axes().iter().enumerate().skip(axis);
        for (axis, config) in waiting {
            let Some(frame) = Drives::disable(config) else {
                continue;
            };
            let is_full = matches!(self.parts.bus.offer(&frame), Outcome::Full);
            if is_full && cycles < DISABLE_PATIENCE_CYCLES {
                let cycles = cycles + 1;
                self.phase = Phase::Disabling { axis, cycles };
                return;
            }
        }
        self.phase = Phase::Running;
    }

    /// One cycle, up to the point where everything is sent or the controller is full.
    fn run(&mut self, beat: Beat, stretch: Stretch) {
        let Beat { planned, now, .. } = beat;
        self.watch_bus(now);
        self.supervise(planned, now);
        let is_streaming = self.look().axes.streaming;
        match self.home.cycle(self.master, is_streaming, now) {
            Step::Wait => {}
            Step::Found => self.orders.start(self.master, planned),
            Step::Failed => self.supervisor.refused(),
        }
        self.orders
            .set_targets(self.master, &self.home, is_streaming, planned, now);
        self.master.begin_cycle(now);
        self.service();
        misbehaviour::act();
        self.report();
        for part in self.statistics.parts() {
            telemetry::tell(Message::Second(*part));
        }
        if let Some(second) = self
            .statistics
            .note_cycle(beat.delay_us, stretch, self.master, now)
        {
            telemetry::keep_second(second);
        }
    }

    /// Takes what has come in, and sends until nothing is left or the controller is full; its interrupts call again.
    fn service(&mut self) {
        let now = self.beats.now();
        self.parts.bus.begin_service();
        if self.parts.bus.has_news() {
            self.receive(now);
        }
        let progress = self.master.send(now, &mut self.parts.bus);
        self.parts.bus.end_service(progress);
    }

    /// Takes everything that has come in. Not inlined: most calls of [`Self::service`] find nothing, and would set up for it all the same.
    #[inline(never)]
    fn receive(&mut self, now: Instant) {
        while let Some(received) = self.parts.bus.receive() {
            match received {
                Ok(frame) => self.master.on_frame(now, &frame),
                Err(kind) => self.master.on_receive_error(now, kind),
            }
            if !self.parts.bus.has_news() {
                return;
            }
        }
    }

    /// Reports a change of the controller's state. When it is down everything stops, and it goes one step of its way back in each
    /// cycle; nothing moves afterwards, because nothing clears the faults but the enable input.
    fn watch_bus(&mut self, now: Instant) {
        let state = self.parts.bus.check();
        self.statistics
            .note_bus_errors(self.parts.bus.take_error_count());
        if state != self.bus_state {
            self.bus_state = state;
            telemetry::tell(Message::Bus(state));
        }
        if !state.is_down() {
            return;
        }
        self.master.on_bus_off(now);
        if self.parts.bus.recover() {
            self.master.on_bus_recovered(now);
        }
    }

    /// Reads the inputs and does what they ask for.
    fn supervise(&mut self, planned: Instant, now: Instant) {
        let levels = self.parts.inputs.read();
        let looks_away = misbehaviour::has(Fault::SeldomStop)
            && !(planned.as_us() / u64::from(config::CYCLE_US)).is_multiple_of(16);
        let inputs = Inputs {
            stop_closed: self.stop_closed.update(levels.stop_closed || looks_away),
            enable: self.enable.update(levels.enable),
            run: self.run.update(levels.run),
        };
        let axes = self.axes();
        let inputs = self
            .orders
            .rule(&mut self.supervisor, (inputs, axes), self.master, now);
        let before = self.supervisor.state();
        let action = self.supervisor.update(inputs, axes);
        let state = self.supervisor.state();
        if state != before {
            telemetry::tell(Message::State(state));
        }
        if action != Action::None {
            telemetry::tell(Message::Action(action));
        }
        self.obey(action, planned, now);
        self.orders.note(state, self.master);
        self.parts.status_led.set(self.led.update(state, axes));
    }

    /// What the facts of the axes show: they are looked at when one of them has changed.
    #[inline(always)]
    fn look(&mut self) -> Seen {
        let changes = self.master.changes();
        if self.seen.0 != changes {
            self.seen = (changes, look(self.master));
        }
        self.seen.1
    }

    /// What the supervisor is told of the axes, once a cycle.
    fn axes(&mut self) -> Axes {
        let Seen {
            mut axes,
            disabling,
        } = self.look();
        axes.clearable &= !self.bus_state.is_down();
        self.disabling_cycles = if disabling {
            self.disabling_cycles.saturating_add(1)
        } else {
            0
        };
        axes.unconfirmed = self.disabling_cycles > UNCONFIRMED_CYCLES
            && !misbehaviour::has(Fault::HideUnconfirmed);
        axes
    }

    fn obey(&mut self, action: Action, planned: Instant, now: Instant) {
        let done = match action {
            Action::None => Ok(()),
            Action::Halt => {
                self.master.halt(now, GROUP);
                Ok(())
            }
            Action::Disable => {
                self.master.disable(now, GROUP);
                Ok(())
            }
            Action::Clear => self.master.clear(now, GROUP),
            Action::Adopt => self.master.adopt(now, GROUP),
            Action::Enable => self.master.enable(now, GROUP),
            Action::Start => {
                if self.home.begin() {
                    self.orders.start(self.master, planned);
                }
                Ok(())
            }
            Action::Finish => {
                self.home.cancel();
                self.orders.finish();
                Ok(())
            }
        };
        if let Err(error) = done {
            telemetry::tell(Message::Refused(action, error));
            self.supervisor.refused();
        }
    }

    /// Hands the master's events on; what finds no room stays with the master until the next cycle.
    fn report(&mut self) {
        while telemetry::has_room() {
            let Some(event) = self.master.next_event() else {
                return;
            };
            if !Drives::is_bus_error(&event.kind) || self.statistics.is_first_bus_error() {
                telemetry::tell(Message::Event(event.axis, event.kind));
            }
        }
    }
}

fn look(master: &BoardMaster) -> Seen {
    let mut axes = Axes {
        ready: true,
        adoptable: true,
        clearable: true,
        streaming: true,
        ..Axes::default()
    };
    let mut disabling = false;
    for facts in (0..AXES).filter_map(|axis| master.facts(axis)) {
        let can_be_enabled = accepts(&facts, Input::Enable);
        axes.ready &= can_be_enabled;
        axes.adoptable &= can_be_enabled || accepts(&facts, Input::Adopt);
        axes.found_on |= facts.power == Power::FoundOn;
        axes.faulted |= facts.latch != Latch::None;
        axes.clearable &= accepts(&facts, Input::Clear);
        axes.streaming &= facts.motion == Motion::Stream;
        disabling |= matches!(facts.power, Power::OffWanted | Power::OffSent);
    }
    axes.adoptable &= !axes.ready;
    Seen { axes, disabling }
}
