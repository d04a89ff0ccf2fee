//! The application: the cycle of the master at its fixed rate, and the bus in between.

use can_motion::{Instant, Master, Progress, service};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, with_timeout};

use crate::automatic_enable::AutomaticEnable;
use crate::board::StatusLed;
use crate::bus::{Bus, FaultState};
use crate::config::{self, AXES};
use crate::cycle_clock::{Beat, CycleClock};
use crate::playback::Playback;
use crate::telemetry::Telemetry;

/// How long joining the bus may take before it is reported, and again after each report.
const JOIN_REPORT: Duration = Duration::from_secs(1);
const PERIOD: Duration = Duration::from_micros(config::MASTER.cycle_us as u64);
/// Cycles between two changes of the status LED: half a second.
const LED_CYCLES: u32 = 500_000 / config::MASTER.cycle_us;

/// Runs for ever, unless the configuration cannot work. The drives' own start is waited for by the master.
#[embassy_executor::task]
pub(crate) async fn run(bus: Bus, status_led: StatusLed) {
    match Master::new(config::MASTER, &config::AXIS_CONFIGS) {
        Ok(master) => App::new(master, bus, status_led).run().await,
        Err(error) => defmt::error!("the configuration cannot work: {}", error),
    }
}

struct App {
    master: Master<AXES>,
    bus: Bus,
    bus_state: FaultState,
    automatic_enable: AutomaticEnable,
    playback: Playback,
    telemetry: Telemetry,
    status_led: StatusLed,
    led_cycles: u32,
}

impl App {
    const fn new(master: Master<AXES>, bus: Bus, status_led: StatusLed) -> Self {
        Self {
            master,
            bus,
            bus_state: FaultState::ErrorActive,
            automatic_enable: AutomaticEnable::Waiting,
            playback: Playback::new(),
            telemetry: Telemetry::new(),
            status_led,
            led_cycles: 0,
        }
    }

    async fn run(mut self) {
        while with_timeout(JOIN_REPORT, self.bus.joined()).await.is_err() {
            defmt::warn!("the bus is never idle: check transceiver, wiring and termination");
        }
        defmt::info!("on the bus");
        let mut clock = CycleClock::start(PERIOD);
        let mut progress = Progress::Idle;
        loop {
            // The beat is asked first, so nothing on the bus can hold it up.
            progress = match select(clock.next(), self.bus.serviceable(progress)).await {
                Either::First(beat) => self.cycle(beat),
                Either::Second(()) => self.service(),
            };
        }
    }

    /// One cycle, up to the point where everything is sent or the mailboxes are full.
    fn cycle(&mut self, beat: Beat) -> Progress {
        let now = now();
        self.watch_bus(now);
        self.automatic_enable.update(&mut self.master, now);
        let planned = Instant::from_us(beat.planned.as_micros());
        self.playback.set_targets(&mut self.master, planned, now);
        self.master.begin_cycle(now);
        let progress = self.service();
        let work = beat.planned.elapsed() - beat.delay;
        self.telemetry.note_cycle(beat.delay, work);
        self.telemetry.report(&mut self.master);
        self.blink();
        progress
    }

    fn service(&mut self) -> Progress {
        service(&mut self.master, &mut self.bus, now())
    }

    /// Reports a change of the fault state. On bus-off everything stops, and the controller goes one step of its way
    /// back in each cycle; nothing moves afterwards, because nothing clears the faults.
    fn watch_bus(&mut self, now: Instant) {
        let state = self.bus.fault_state();
        if state != self.bus_state {
            defmt::warn!("bus: {} after {}", state, self.bus_state);
            self.bus_state = state;
        }
        if state != FaultState::BusOff {
            return;
        }
        self.master.on_bus_off(now);
        if self.bus.recover().is_ok() {
            self.master.on_bus_recovered(now);
            defmt::warn!("the bus is back; the axes stay stopped until the board is started again");
        }
    }

    fn blink(&mut self) {
        self.led_cycles += 1;
        if self.led_cycles >= LED_CYCLES {
            self.led_cycles = 0;
            self.status_led.toggle();
        }
    }
}

/// The time since the start of the board, for the master.
fn now() -> Instant {
    Instant::from_us(embassy_time::Instant::now().as_micros())
}
