//! The serial port and its wire within the chip: clock, pins, reset.

use super::{BLOCK, Soc};
use crate::usart::{SerialLine, Surroundings, Usart};

/// The serial port of the board and the wire at it.
pub struct SerialPort {
    /// The port.
    pub port: Usart,
    /// The wire and the device at its other end.
    pub line: SerialLine,
}

impl Soc {
    /// What the chip gives the serial port; `None` while its clock is off.
    fn serial_surroundings(&self) -> Option<Surroundings> {
        let serial = &self.chip.serial;
        let (register, bit) = serial.enable;
        if self.storage.peek(register) >> bit & 1 == 0 {
            return None;
        }
        let choice = serial
            .clock_choice
            .map(|(register, at)| self.storage.peek(register) >> at & 3);
        let (pins, function) = serial.pins;
        Some(Surroundings {
            kernel_hz: self.clock.chosen_hz(choice.unwrap_or(0)),
            wired: pins.map(|pin| self.gpio.alternate_function(pin) == Some(function)),
        })
    }

    /// Brings the serial port up to now.
    pub(super) fn advance_serial(&mut self, now_ns: u64) {
        let SerialPort { port, line } = &self.serial;
        if port
            .next_event_ns(line)
            .is_some_and(|due_ns| due_ns <= now_ns)
        {
            let around = self.serial_surroundings();
            let SerialPort { port, line } = &mut self.serial;
            port.advance(now_ns, around.as_ref(), line);
        }
        self.nvic
            .set_line(self.chip.serial.interrupt, self.serial.port.line());
    }

    /// A register of the serial port; 0 while its clock is off.
    pub(super) fn read_serial(&mut self, address: u32) -> u32 {
        self.advance_serial(self.now_ns());
        match self.serial_surroundings() {
            Some(_) => self.serial.port.read(address % BLOCK),
            None => 0,
        }
    }

    pub(super) fn write_serial(&mut self, address: u32, value: u32) {
        let now_ns = self.now_ns();
        self.advance_serial(now_ns);
        if let Some(around) = self.serial_surroundings() {
            self.serial
                .port
                .write(address % BLOCK, value, now_ns, &around);
        }
        self.process();
    }
}
