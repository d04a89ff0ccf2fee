//! What the protocol asks of the firmware, answered in the thread.

use core::sync::atomic::{AtomicU32, Ordering};

use board_link::board::{Application, Command, Machine};
use board_link::message::{BoardState, Event, FaultEntry, Info, Text};
use board_link::{Reason, Refused};
use heapless::Deque;
use heapless::spsc::{Consumer, Producer};

use super::faults;
use super::orders::{Ordered, Result};
use super::shared::SHARED;
use crate::config::CYCLE_US;
use crate::telemetry::Message;

/// Events that the protocol has not taken yet: it takes them in every cycle.
const EVENTS: usize = 16;

/// Counts the starts, so that a host sees a reset; what memory holds after power-on is as good a number as any.
#[unsafe(link_section = ".uninit.STARTS")]
static STARTS: AtomicU32 = AtomicU32::new(0);

#[cfg(feature = "stm32f405")]
const BOARD: &str = "STM32F405";
#[cfg(feature = "stm32g474")]
const BOARD: &str = "STM32G474";

/// The firmware, as the protocol sees it.
pub(crate) struct Firmware {
    commands: Producer<'static, Ordered>,
    results: Consumer<'static, Result>,
    events: Deque<Event, EVENTS>,
    start: u32,
    /// As the host was told last.
    state: BoardState,
}

impl Firmware {
    /// After a start.
    pub(super) fn new(
        commands: Producer<'static, Ordered>,
        results: Consumer<'static, Result>,
    ) -> Self {
        let start = STARTS.load(Ordering::Relaxed).wrapping_add(1);
        STARTS.store(start, Ordering::Relaxed);
        Self {
            commands,
            results,
            events: Deque::new(),
            start,
            state: BoardState::NoSettings,
        }
    }

    /// What the log tells, as far as a host wants to know it.
    pub(super) fn note(&mut self, message: &Message) {
        if let Message::Event(axis, kind) = message
            && let Some((code, detail)) = faults::of_event(kind)
        {
            self.add(Event::Fault {
                axis: *axis,
                code,
                detail,
            });
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
    fn info(&self) -> Info {
        let text = |text: &str| Text::try_from(text).unwrap_or_default();
        Info {
            board: text(BOARD),
            firmware: text(env!("CARGO_PKG_VERSION")),
            boot: self.start,
            cycle_us: CYCLE_US,
            ..Info::default()
        }
    }

    fn post(&mut self, ticket: u16, command: Command) -> core::result::Result<(), Refused> {
        if SHARED.state() == BoardState::NoSettings {
            // There is no cycle that would carry it out.
            let (expected, actual) = (BoardState::Off as i64, BoardState::NoSettings as i64);
            return Err(Reason::NotReady.because(expected, actual));
        }
        let capacity = self.commands.capacity() as i64;
        let posted = self.commands.enqueue((ticket, command));
        posted.map_err(|_| Reason::Busy.because(capacity, capacity + 1))
    }

    fn result(&mut self) -> Option<Result> {
        self.results.dequeue()
    }

    fn machine(&mut self) -> Machine {
        let machine = SHARED.read();
        SHARED.want_axes();
        machine
    }

    fn event(&mut self) -> Option<Event> {
        let state = SHARED.state();
        if state != self.state {
            self.state = state;
            self.add(Event::State(state));
        }
        self.events.pop_front()
    }

    fn settings(&self) -> &[u8] {
        &[]
    }

    fn staging(&mut self) -> &mut [u8] {
        &mut []
    }

    fn check_settings(&mut self, _: u32) -> core::result::Result<(), Refused> {
        Err(Reason::Unsupported.plain())
    }

    fn fault(&mut self, _: u32) -> Option<FaultEntry> {
        None
    }
}
