//! The half of the thread: bytes in, bytes out, and the protocol in between.

use board_link::board::{Board, BoardConfig, Link};
use board_link::segment::Admission;
use heapless::spsc::{Consumer, Producer};

use super::application::Firmware;
use super::orders::{Ordered, Result};
use super::{CYCLES_PER_SECOND, Port};
use crate::config::AXES;
use crate::cycle_clock;
use crate::store::Storage;
use crate::telemetry::Message;

/// Bytes that wait to be sent: two of the longest answers, and one on its way.
const OUT: usize = 1_536;
/// Bytes that are taken at a time.
const CHUNK: usize = 64;

/// What the thread does beside the log.
pub(crate) struct Thread {
    board: Board<'static, Firmware, AXES>,
    link: Link<OUT>,
    /// None while the board has no clock for it.
    port: Option<Port>,
    /// The cycle in which it was looked at last.
    polled: u64,
    /// Errors of the port that the log has told, and when it tells the next ones.
    told_errors: u32,
    tells_errors_at: u64,
}

impl Thread {
    pub(super) fn new(
        admission: Option<Admission<'static, AXES>>,
        commands: Producer<'static, Ordered>,
        results: Consumer<'static, Result>,
        storage: Storage,
    ) -> Self {
        let firmware = Firmware::new(commands, results, storage);
        let config = BoardConfig::with_cycles_per_second(CYCLES_PER_SECOND);
        Self {
            board: Board::new(firmware, admission, config),
            link: Link::new(),
            port: None,
            polled: 0,
            told_errors: 0,
            tells_errors_at: 0,
        }
    }

    /// The port to the host.
    pub(crate) fn connect(&mut self, port: Port) {
        self.port = Some(port);
    }

    /// A message that the log tells.
    pub(crate) fn note(&mut self, message: &Message) {
        self.board.application().note(message);
    }

    /// One of the looks between two sleeps: every interrupt wakes the thread, a cycle has several.
    pub(crate) fn poll(&mut self) {
        let Some(port) = &mut self.port else { return };
        let now = cycle_clock::cycle();
        let mut bytes = [0; CHUNK];
        loop {
            let count = port.take(&mut bytes);
            if count == 0 {
                break;
            }
            let bytes = bytes.get(..count).unwrap_or_default();
            self.link.on_bytes(&mut self.board, now, bytes);
        }
        if now != self.polled {
            self.polled = now;
            self.board.application().keep_faults(now);
            self.link.poll(&mut self.board, now);
        }
        let count = port.send(self.link.output());
        self.link.consume(count);
        let errors = port.errors();
        if errors != self.told_errors && now >= self.tells_errors_at {
            #[cfg(not(feature = "link-usb"))]
            defmt::warn!(
                "serial port: {=u32} errors so far: check cable, ground and bit rate",
                errors
            );
            #[cfg(feature = "link-usb")]
            defmt::warn!("USB: no program read, {=u32} times so far", errors);
            self.told_errors = errors;
            self.tells_errors_at = now + u64::from(CYCLES_PER_SECOND);
        }
    }
}
