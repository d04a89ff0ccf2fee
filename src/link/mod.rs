//! The image that takes orders over a serial port: cargo feature `link`.
//!
//! | Module | What |
//! |---|---|
//! | `config`, `machine` | what is compiled in, and what the settings say |
//! | `uart` | bytes by DMA, without an interrupt |
//! | `usb` | with `link-usb`, in its place: bytes by USB |
//! | `thread` | the protocol, in the thread that writes the log |
//! | `application` | what the protocol asks of the firmware |
//! | `orders` | the half of the cycle: commands, and the player of the segments |
//! | `rules` | what the inputs and the state of the machine let a command do |
//! | `homing` | with `link-homing`: the axes find their origins; `no_homing` in its place |
//! | `shared` | what the thread sees of the cycle |
//! | `faults` | what ended the start before this one |
//!
//! The cycle and the thread share queues of one writer and one reader, and words; neither waits for the other.

pub(crate) mod application;
mod faults;
#[cfg_attr(not(feature = "link-homing"), path = "no_homing.rs")]
pub(crate) mod homing;
pub(crate) mod orders;
pub(crate) mod shared;
pub(crate) mod stored;
pub(crate) mod thread;
#[cfg(not(feature = "link-usb"))]
pub(crate) mod uart;
#[cfg(feature = "link-usb")]
pub(crate) mod usb;

pub(crate) use orders::Orders;
pub(crate) use thread::Thread;
#[cfg(not(feature = "link-usb"))]
pub(crate) use uart::Port;
#[cfg(feature = "link-usb")]
pub(crate) use usb::Port;

use board_link::segment::{SegmentConfig, SegmentQueue};
use heapless::spsc::Queue;
use static_cell::ConstStaticCell;

use crate::board::Watchdog;
use crate::config::{AXES, CYCLE_US};
use crate::last_words::History;
use crate::machine;
use crate::start::Cause;
use crate::store::Storage;

/// Commands on their way to the cycle: one place of the queue stays free.
const COMMANDS: usize = 5;
/// Results on their way back.
const RESULTS: usize = 9;
/// Segments that wait, and one place more.
const SEGMENTS: usize = 57;

const CYCLES_PER_SECOND: u32 = 1_000_000 / CYCLE_US;

/// The half of the cycle, and that of the thread. Without settings there is nothing for the cycle to do. To be called once: a second call
/// panics.
pub(crate) fn prepare(
    cause: Cause,
    history: &History,
    watchdog: &mut Watchdog,
) -> (Option<Orders>, Thread) {
    watchdog.feed();
    static PLAYED: ConstStaticCell<SegmentQueue<AXES, SEGMENTS>> =
        ConstStaticCell::new(SegmentQueue::new());
    static COMMANDED: ConstStaticCell<Queue<orders::Ordered, COMMANDS>> =
        ConstStaticCell::new(Queue::new());
    static DONE: ConstStaticCell<Queue<orders::Result, RESULTS>> =
        ConstStaticCell::new(Queue::new());
    let (commands, commanded) = COMMANDED.take().split();
    let (done, results) = DONE.take().split();
    let config = SegmentConfig::with_cycles_per_second(CYCLES_PER_SECOND);
    let halves = machine::get().and_then(|machine| PLAYED.take().split(&machine.limits, config));
    let (admission, player) = match halves {
        Some((admission, player)) => (Some(admission), Some(player)),
        None => (None, None),
    };
    let orders = player.map(|player| Orders::new(player, commanded, done));
    let before = faults::of_history(cause, history);
    let storage = Storage::new(cause == Cause::PowerOn, before);
    watchdog.feed();
    (orders, Thread::new(admission, commands, results, storage))
}
