//! The application: the cycle of the master at its fixed rate, and the bus in between.

use core::mem::size_of;

use can_motion::facts::{Input, Latch, Motion, Power, accepts};
use can_motion::{ConfigError, EventKind, Instant, Progress, ServoMaster, service_taking_back};
use dyn_can::{Address, Dialect, Request, ServoSwitch};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Timer};
use embedded_can::nb::Can;
use static_cell::StaticCell;

use crate::board::{InputPins, STACK_BYTES, StatusLed, Watchdog};
use crate::bus::Bus;
use crate::config::{self, AXES, GROUP};
use crate::cycle_clock::{Beat, beat};
use crate::debounce::Debounced;
use crate::led::{self, LedPattern};
use crate::misbehaviour::{self, Fault};
use crate::playback::Playback;
use crate::recovery::FaultState;
use crate::statistics::{Statistics, Stretch};
use crate::supervisor::{Action, Axes, Inputs, Supervisor};
use crate::telemetry::{self, Message};

/// Cycles for which joining the bus may take before it is reported, and again after each report.
const JOIN_REPORT_CYCLES: u32 = 1_000_000 / config::CYCLE_US;
/// How long a disable command after a failure may wait for room, in steps of a frame's length.
const DISABLE_PATIENCE: u32 = 100;
/// A drive that has not confirmed a disable command by then is shown: the first repetition was not enough either.
const UNCONFIRMED_CYCLES: u32 = 2 * config::MASTER.timeouts.confirm_us / config::CYCLE_US;
const FRAME_TIME: Duration = Duration::from_micros(100);

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
    pub(crate) error: ConfigError,
    /// The status LED.
    pub(crate) status_led: StatusLed,
    /// The watchdog, running.
    pub(crate) watchdog: Watchdog,
}

/// Runs for ever.
#[embassy_executor::task]
pub(crate) async fn run(app: &'static mut App) {
    app.run().await;
}

/// The application in the memory that it stays in, or the reason why the configuration cannot work. To be called once: a second call
/// panics. Not inlined: its stack, on which the application is built, must be free again afterwards.
#[inline(never)]
pub(crate) fn place(parts: Parts) -> Result<&'static mut App, Refused> {
    static APP: StaticCell<App> = StaticCell::new();
    match ServoMaster::with_plan(&config::PLAN) {
        Ok(master) => Ok(APP.init(App::new(master, parts))),
        Err(error) => Err(Refused {
            error,
            status_led: parts.status_led,
            watchdog: parts.watchdog,
        }),
    }
}

/// The application is built on the stack before it goes to its place, and the compiler may copy it on the way.
const _: () = assert!(
    3 * size_of::<App>() <= STACK_BYTES,
    "too many axes for the stack: raise STACK in the memory map and STACK_BYTES"
);

/// The cycle with everything it works with.
pub(crate) struct App {
    master: ServoMaster<AXES>,
    parts: Parts,
    bus_state: FaultState,
    stop_closed: Debounced,
    enable: Debounced,
    run: Debounced,
    supervisor: Supervisor,
    playback: Playback,
    statistics: Statistics,
    led: LedPattern,
    /// Cycles for which a drive has not confirmed its disable command.
    disabling_cycles: u32,
}

impl App {
    const fn new(master: ServoMaster<AXES>, parts: Parts) -> Self {
        Self {
            master,
            supervisor: Supervisor::new(parts.is_locked),
            parts,
            bus_state: FaultState::ErrorActive,
            stop_closed: Debounced::new(),
            enable: Debounced::new(),
            run: Debounced::new(),
            playback: Playback::new(),
            statistics: Statistics::new(),
            led: LedPattern::new(),
            disabling_cycles: 0,
        }
    }

    async fn run(&mut self) {
        self.join().await;
        telemetry::tell(Message::OnTheBus);
        if self.parts.is_locked {
            self.disable_all().await;
        }
        let mut progress = Progress::Idle;
        loop {
            // The beat is asked first, so nothing on the bus can hold it up.
            progress = match select(beat(), self.parts.bus.serviceable(progress)).await {
                Either::First(beat) => self.cycle(beat),
                Either::Second(()) => {
                    let stretch = Stretch::begin();
                    let progress = self.service();
                    self.statistics.note_service(stretch);
                    progress
                }
            };
        }
    }

    /// Until the controller takes part in the traffic: for ever on a bus that is held dominant or has no transceiver. No drive can be
    /// reached meanwhile, so the inputs have nothing to say.
    async fn join(&mut self) {
        let mut cycles = 0;
        loop {
            if misbehaviour::has(Fault::WaitForTheBus) {
                while self.parts.bus.recover().is_err() {}
            }
            self.parts.bus.check();
            if self.parts.bus.recover().is_ok() {
                return;
            }
            beat().await;
            cycles += 1;
            if cycles % JOIN_REPORT_CYCLES == 0 {
                telemetry::tell(Message::BusNeverIdle);
            }
            self.parts.status_led.set(self.led.play(led::OFF_THE_BUS));
            self.parts.watchdog.feed();
        }
    }

    /// Tells every drive to disable, as far as the bus allows: the firmware that moved them has failed.
    async fn disable_all(&mut self) {
        for axis in &config::AXIS_CONFIGS {
            let request = Request::ServoDisable(ServoSwitch::Disable);
            // The command is the same in every revision.
            let Ok(frame) = request.encode(Address::Drive(axis.drive), &Dialect::V1_6A) else {
                continue;
            };
            let Some(frame) = frame.to_can() else {
                continue;
            };
            for _ in 0..DISABLE_PATIENCE {
                self.parts.watchdog.feed();
                match self.parts.bus.transmit(&frame) {
                    Err(nb::Error::WouldBlock) => Timer::after(FRAME_TIME).await,
                    _ => break,
                }
            }
        }
    }

    /// One cycle, up to the point where everything is sent or the mailboxes are full.
    fn cycle(&mut self, beat: Beat) -> Progress {
        let (stretch, now) = (Stretch::begin(), now());
        let planned = Instant::from_us(beat.planned.as_micros());
        self.watch_bus(now);
        self.supervise(planned, now);
        self.playback.set_targets(&mut self.master, planned, now);
        self.master.begin_cycle(now);
        let progress = self.service();
        misbehaviour::act();
        self.report();
        if let Some(second) = self
            .statistics
            .note_cycle(beat.delay, stretch, &self.master, now)
        {
            telemetry::tell(Message::Second(second));
        }
        // Only a cycle that came to its end says that the firmware lives.
        self.parts.watchdog.feed();
        progress
    }

    fn service(&mut self) -> Progress {
        service_taking_back(&mut self.master, &mut self.parts.bus, now(), Bus::take_back)
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
        if self.parts.bus.recover().is_ok() {
            self.master.on_bus_recovered(now);
        }
    }

    /// Reads the inputs and does what they ask for.
    fn supervise(&mut self, planned: Instant, now: Instant) {
        let levels = self.parts.inputs.read();
        let inputs = Inputs {
            stop_closed: self.stop_closed.update(levels.stop_closed),
            enable: self.enable.update(levels.enable),
            run: self.run.update(levels.run),
        };
        let axes = self.look();
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
        self.parts.status_led.set(self.led.update(state, axes));
    }

    fn look(&mut self) -> Axes {
        let mut axes = Axes {
            ready: true,
            adoptable: true,
            clearable: !self.bus_state.is_down(),
            streaming: true,
            ..Axes::default()
        };
        let mut disabling = false;
        for facts in (0..AXES).filter_map(|axis| self.master.facts(axis)) {
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
                self.playback.start(&self.master, planned);
                Ok(())
            }
            Action::Finish => {
                self.playback.finish(planned);
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
            let is_news = match event.kind {
                EventKind::BusError(_) => self.statistics.is_first_bus_error(),
                _ => true,
            };
            if is_news {
                telemetry::tell(Message::Event(event));
            }
        }
    }
}

/// The time since the start of the board, for the master.
fn now() -> Instant {
    Instant::from_us(embassy_time::Instant::now().as_micros())
}
