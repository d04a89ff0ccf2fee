//! Byte queues between the serial line of a board and something outside of its time, such as a pseudo-terminal.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::usart::SerialLine;

#[derive(Debug, Default)]
struct Queues {
    to_board: VecDeque<u8>,
    from_board: VecDeque<u8>,
}

/// The bridge. A clone is another handle of the same queues: one stays with the board, the other goes to whoever talks with it.
///
/// The outer end is a reader and writer that never blocks: a read without a byte fails with [`io::ErrorKind::WouldBlock`]. The queues
/// have no limit.
#[derive(Debug, Clone, Default)]
pub struct SerialBridge(Arc<Mutex<Queues>>);

impl SerialBridge {
    fn queues(&self) -> MutexGuard<'_, Queues> {
        // Queues are whole after every step, so those of a thread that panicked are too.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts the bytes from outside on the line, from `now_ns` on, and takes what has come from the board.
    pub fn exchange(&self, line: &mut SerialLine, now_ns: u64) {
        let mut queues = self.queues();
        let bytes: Vec<u8> = queues.to_board.drain(..).collect();
        line.send_bytes(now_ns, &bytes);
        let received = line.take_received().into_iter();
        queues
            .from_board
            .extend(received.map(|received| received.byte));
    }
}

impl Read for SerialBridge {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut queues = self.queues();
        if queues.from_board.is_empty() && !buffer.is_empty() {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        queues.from_board.read(buffer)
    }
}

impl Write for SerialBridge {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.queues().to_board.extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::usart::{Registers, Surroundings, Usart};

    #[test]
    fn bytes_cross_in_both_directions_and_nothing_is_waited_for() {
        let around = Surroundings {
            kernel_hz: 16_000_000,
            wired: [true; 2],
        };
        let mut port = Usart::new(Registers::Classic);
        port.write(0x08, 139, 0, &around);
        port.write(0x0C, 1 << 13 | 1 << 3 | 1 << 2, 0, &around);
        let (mut line, board) = (SerialLine::default(), SerialBridge::default());
        let mut outside = board.clone();
        let mut buffer = [0; 4];
        let empty = outside.read(&mut buffer).unwrap_err();
        assert_eq!(empty.kind(), io::ErrorKind::WouldBlock);

        outside.write_all(b"q").unwrap();
        port.write(0x04, u32::from(b'a'), 0, &around);
        board.exchange(&mut line, 0);
        port.advance(1_000_000, Some(&around), &mut line);
        assert_eq!(port.read(0x04), u32::from(b'q'));
        board.exchange(&mut line, 1_000_000);
        assert_eq!(outside.read(&mut buffer).unwrap(), 1);
        assert_eq!(buffer[0], b'a');
    }
}
