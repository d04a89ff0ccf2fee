//! What the protocol asks of the firmware, answered in the thread.

use board_link::board::{Application, Command, Machine};
#[cfg(feature = "link-homing")]
use board_link::message::Origin;
use board_link::message::{BoardState, Event, FaultEntry, Info, Text};
use board_link::{Reason, Refused};
use board_settings::FaultNumber;
use board_settings::LONGEST;
use heapless::Deque;
use heapless::spsc::{Consumer, Producer};

use super::orders::{Ordered, Result};
use super::shared::SHARED;
#[cfg(feature = "link-homing")]
use crate::config::AXES;
use crate::config::CYCLE_US;
use crate::machine;
use crate::store::{Fault, Storage};
use crate::telemetry::Message;

/// Events that the protocol has not taken yet: it takes them in every cycle.
const EVENTS: usize = 16;

/// Asks the cycle whether faults may be stored. The link's own commands for nobody have this ticket, too.
const NOBODY: u16 = 0;
/// Cycles from one attempt to store faults to the next.
const STORE_PERIOD: u64 = 500_000 / CYCLE_US as u64;

#[cfg(feature = "stm32f405")]
const BOARD: &str = "STM32F405";
#[cfg(feature = "stm32g474")]
const BOARD: &str = "STM32G474";

/// The firmware, as the protocol sees it.
pub(crate) struct Firmware {
    commands: Producer<'static, Ordered>,
    results: Consumer<'static, Result>,
    events: Deque<Event, EVENTS>,
    storage: Storage,
    /// The command to save settings that the cycle has, and their length.
    saving: Option<(u16, u32)>,
    /// The cycle is asked whether faults may be stored.
    is_asking: bool,
    /// When faults are looked at next.
    stores_at: u64,
    /// As the host was told last.
    state: BoardState,
    /// The axes of which the host was told that they are homed, a bit each.
    #[cfg(feature = "link-homing")]
    homed: u16,
}

impl Firmware {
    /// After a start.
    pub(super) fn new(
        commands: Producer<'static, Ordered>,
        results: Consumer<'static, Result>,
        storage: Storage,
    ) -> Self {
        Self {
            commands,
            results,
            events: Deque::new(),
            storage,
            saving: None,
            is_asking: false,
            stores_at: STORE_PERIOD,
            state: BoardState::NoSettings,
            #[cfg(feature = "link-homing")]
            homed: 0,
        }
    }

    /// What the log tells, as far as a host wants to know it.
    pub(super) fn note(&mut self, message: &Message) {
        if let Message::Event(axis, kind) = message
            && let Some(FaultNumber { code, detail }) = FaultNumber::of_event(kind)
        {
            self.storage.note_fault(Fault {
                axis: *axis,
                code,
                detail,
                place: "",
            });
            self.add(Event::Fault {
                axis: *axis,
                code,
                detail,
            });
        }
    }

    /// Faults go to flash when everything is off, one in an attempt; `now` in cycles.
    pub(super) fn keep_faults(&mut self, now: u64) {
        let uptime_ms = now * u64::from(CYCLE_US) / 1_000;
        self.storage.set_uptime_ms(uptime_ms as u32);
        let is_due = now >= self.stores_at && self.saving.is_none();
        if !is_due || !self.storage.owes_faults() {
            return;
        }
        self.stores_at = now + STORE_PERIOD;
        if has_cycle_to_ask() {
            let ask = Command::SaveSettings { length: 0 };
            self.is_asking |= self.commands.enqueue((NOBODY, ask)).is_ok();
        } else {
            self.store_fault();
        }
    }

    fn store_fault(&mut self) {
        if let Err(refused) = self.storage.store_fault() {
            defmt::error!(
                "a fault is not stored, flash status {=i64:#x}",
                refused.actual
            );
        }
    }

    /// Tells of axes that have found their origins.
    #[cfg(feature = "link-homing")]
    fn note_origins(&mut self) {
        let known = SHARED.known();
        let news = known & !self.homed;
        self.homed = known;
        for axis in (0..AXES).filter(|axis| news >> axis & 1 != 0) {
            if let Origin::Found {
                counts,
                uncertainty,
            } = SHARED.origin(axis)
            {
                let axis = axis as u8;
                self.add(Event::Homed {
                    axis,
                    counts,
                    uncertainty,
                });
            }
        }
    }

    fn add(&mut self, event: Event) {
        if self.events.is_full() {
            self.events.pop_front();
        }
        // There is room now.
        let _ = self.events.push_back(event);
    }
}

impl Application for Firmware {
    const HOMES: bool = cfg!(feature = "link-homing");

    fn info(&self) -> Info {
        let text = |text: &str| Text::try_from(text).unwrap_or_default();
        Info {
            board: text(BOARD),
            firmware: text(env!("CARGO_PKG_VERSION")),
            boot: self.storage.boot(),
            settings: LONGEST as u32,
            faults: self.storage.faults(),
            cycle_us: CYCLE_US,
            ..Info::default()
        }
    }

    fn post(&mut self, ticket: u16, command: Command) -> core::result::Result<(), Refused> {
        if let Command::SaveSettings { length } = command {
            self.saving = Some((ticket, length));
            if machine::get().is_none() {
                return Ok(());
            }
        }
        if machine::get().is_none() {
            // There is no cycle that would carry it out.
            let (expected, actual) = (BoardState::Off as i64, BoardState::NoSettings as i64);
            return Err(Reason::NotReady.because(expected, actual));
        }
        let capacity = self.commands.capacity() as i64;
        let posted = self.commands.enqueue((ticket, command));
        posted.map_err(|_| {
            self.saving = self.saving.filter(|(of, _)| *of != ticket);
            Reason::Busy.because(capacity, capacity + 1)
        })
    }

    fn result(&mut self) -> Option<Result> {
        if machine::get().is_none()
            && let Some((ticket, length)) = self.saving.take()
        {
            return Some((ticket, self.storage.save(length)));
        }
        let (ticket, result) = self.results.dequeue()?;
        if self.is_asking && ticket == NOBODY && SHARED.is_storing() {
            self.is_asking = false;
            self.store_fault();
            SHARED.set_storing(self.saving.is_some());
        }
        let Some((_, length)) = self.saving.take_if(|(of, _)| *of == ticket) else {
            return Some((ticket, result));
        };
        let result = result.and_then(|()| self.storage.save(length));
        SHARED.set_storing(false);
        Some((ticket, result))
    }

    fn machine(&mut self) -> Machine {
        let machine = SHARED.read();
        SHARED.want_axes();
        machine
    }

    #[cfg(feature = "link-homing")]
    fn origin(&mut self, axis: usize) -> Origin {
        SHARED.origin(axis)
    }

    fn event(&mut self) -> Option<Event> {
        #[cfg(feature = "link-homing")]
        self.note_origins();
        let state = SHARED.state();
        if state != self.state {
            self.state = state;
            self.add(Event::State(state));
        }
        self.events.pop_front()
    }

    fn settings(&self) -> &[u8] {
        self.storage.settings()
    }

    fn staging(&mut self) -> &mut [u8] {
        self.storage.staging()
    }

    fn check_settings(&mut self, length: u32) -> core::result::Result<(), Refused> {
        self.storage.check(length)
    }

    fn fault(&mut self, index: u32) -> Option<FaultEntry> {
        self.storage.fault(index)
    }
}

/// A board that is locked, or has no settings, enables nothing.
fn has_cycle_to_ask() -> bool {
    machine::get().is_some() && SHARED.state() != BoardState::Locked
}
