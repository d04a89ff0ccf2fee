//! What the board says: the cycle hands messages over, and the thread, which everything else may interrupt, writes them to the log.

use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};

use can_motion::CommandError;
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;

use crate::config::AXES;
use crate::drives::{BoardEventKind, BoardFault};
use crate::last_words::{History, LastWords};
use crate::orders::Thread;
use crate::recovery::FaultState;
use crate::start::Cause;
use crate::statistics::{Part, Statistics};
use crate::supervisor::{Action, State};
use crate::words;

/// Messages on their way. When it is full the master keeps its events, and the next message of another kind is lost.
const MESSAGES: usize = 8;

/// A message was handed over since the thread looked: every interrupt wakes it, and most have nothing to tell.
static IS_NEWS: AtomicBool = AtomicBool::new(false);
static CHANNEL: Channel<CriticalSectionRawMutex, Message, MESSAGES> = Channel::new();

/// The counts of the latest [`Message::MotionStarts`] or [`Message::MotionEnds`], and the figures of the latest [`Message::Second`]: in
/// the messages they would take this room as often as there are places.
static COUNTS: CriticalSectionMutex<Cell<[i32; AXES]>> =
    CriticalSectionMutex::new(Cell::new([0; AXES]));
static SECOND: CriticalSectionMutex<Cell<Statistics>> =
    CriticalSectionMutex::new(Cell::new(Statistics::new()));

/// Something to tell.
pub(crate) enum Message {
    /// An event of the master: of an axis, by its place in the configuration, or of the bus.
    Event(Option<u8>, BoardEventKind),
    /// The controller takes part in the traffic for the first time.
    OnTheBus,
    /// It has waited for a second to take part.
    BusNeverIdle,
    /// The controller's state has changed.
    Bus(FaultState),
    /// The supervisor did something.
    Action(Action),
    /// The master refused what the supervisor wanted.
    Refused(Action, CommandError<BoardFault>),
    /// The supervisor is somewhere else.
    State(State),
    /// The motion starts.
    #[cfg_attr(
        feature = "link",
        allow(dead_code, reason = "only the built-in motion has it")
    )]
    MotionStarts,
    /// The motion has ended.
    #[cfg_attr(
        feature = "link",
        allow(dead_code, reason = "only the built-in motion has it")
    )]
    MotionEnds,
    /// A second has passed: a part of its figures.
    Second(Part),
}

/// Tells that the motion starts or has ended, at these command counts.
#[cfg_attr(
    feature = "link",
    allow(dead_code, reason = "only the built-in motion has it")
)]
pub(crate) fn tell_motion(message: Message, counts: [i32; AXES]) {
    COUNTS.lock(|latest| latest.set(counts));
    tell(message);
}

/// The figures of the latest second, for [`Message::Second`].
pub(crate) fn keep_second(statistics: Statistics) {
    SECOND.lock(|latest| latest.set(statistics));
}

/// Hands a message over, if there is room. Never waits.
pub(crate) fn tell(message: Message) {
    // What is lost here is a line of the log.
    let _ = CHANNEL.try_send(message);
    IS_NEWS.store(true, Ordering::Relaxed);
}

/// Whether an event can be handed over.
pub(crate) fn has_room() -> bool {
    !CHANNEL.is_full()
}

/// Writes the log and looks after the orders, for ever. `serve` is for a device that needs the thread before it looks and after it has spoken.
pub(crate) fn run(mut thread: Thread, mut serve: impl FnMut()) -> ! {
    loop {
        // Nothing is lost in between: it is taken back before the look.
        if IS_NEWS.load(Ordering::Relaxed) {
            IS_NEWS.store(false, Ordering::Relaxed);
            while let Ok(message) = CHANNEL.try_receive() {
                write(&message);
                thread.note(&message);
            }
        }
        serve();
        thread.poll();
        serve();
        // What an interrupt tells in between waits for the next one, a cycle at most.
        cortex_m::asm::wfi();
    }
}

fn write(message: &Message) {
    match message {
        Message::Event(axis, kind) => words::event(*axis, kind),
        Message::OnTheBus => defmt::info!("on the bus"),
        Message::BusNeverIdle => {
            defmt::warn!("the bus is never idle: check transceiver, wiring and termination");
        }
        Message::Refused(action, error) => words::refused(action, error),
        Message::Bus(FaultState::ErrorActive) => defmt::info!("bus: works"),
        Message::Bus(FaultState::ErrorPassive) => defmt::warn!("bus: error-passive"),
        Message::Bus(FaultState::Stuck) => defmt::error!(
            "bus: nothing gets through, nobody acknowledges: check wiring, termination and the drives' supply"
        ),
        Message::Bus(FaultState::Joining) => defmt::info!("bus: joining"),
        Message::Bus(FaultState::BusOff) => defmt::error!("bus: off"),
        Message::Action(action) => defmt::info!("action: {}", action),
        Message::State(State::Released) => {
            defmt::info!("state: release the enable input, then make it active");
        }
        Message::State(state) => defmt::info!("state: {}", state),
        Message::MotionStarts => {
            defmt::info!("the motion starts from {} counts", COUNTS.lock(Cell::get));
        }
        Message::MotionEnds => {
            defmt::info!("the motion has ended at {} counts", COUNTS.lock(Cell::get));
        }
        Message::Second(part) => SECOND.lock(Cell::get).write(*part),
    }
}

/// Tells why the board started, before anything else.
pub(crate) fn write_start(cause: Cause, history: &History) {
    match &history.last_words {
        Some(LastWords::Panic(place)) => {
            defmt::error!(
                "the firmware panicked at {=str}:{=u32}",
                place.file(),
                place.line
            );
        }
        Some(LastWords::Fault(status)) => {
            defmt::error!("the processor failed, CFSR {=u32:#010x}", *status);
        }
        Some(LastWords::LostClock) => defmt::error!("the crystal stopped in motion"),
        None if cause == Cause::Watchdog => defmt::error!("the watchdog reset the board"),
        None => defmt::info!("started: {}", cause),
    }
    if history.is_locked {
        defmt::error!("locked: nothing moves until the board is switched off and on");
    }
}
