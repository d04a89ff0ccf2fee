//! Pins: levels from outside, levels driven by the firmware (RM0090, section 8; RM0440, section 9).

use std::collections::HashMap;

/// Bytes from one port to the next.
pub const PORT_SIZE: u32 = 0x400;
/// Ports A to I.
pub const PORTS: u32 = 9;

/// A pin of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pin {
    /// The port, A to I.
    pub port: char,
    /// 0 to 15.
    pub number: u8,
}

impl Pin {
    /// A pin by the letter of its port and its number.
    #[must_use]
    pub const fn new(port: char, number: u8) -> Self {
        Self { port, number }
    }

    fn place(self) -> usize {
        usize::from(self.port as u8 - b'A')
    }
}

/// All ports.
#[derive(Debug, Clone)]
pub struct Gpio {
    /// Modes of ports A, B and the others after a reset.
    modes: [u32; 3],
    registers: HashMap<u32, u32>,
    output: [u32; PORTS as usize],
    /// Levels that something outside drives; they outlive a reset.
    outside: [u32; PORTS as usize],
}

impl Gpio {
    /// All ports after a reset, with the modes of ports A, B and the others: debug pins come up in alternate function.
    #[must_use]
    pub fn new(modes: [u32; 3]) -> Self {
        let mode = |port: u32| (port * PORT_SIZE, modes[port.min(2) as usize]);
        Self {
            modes,
            registers: (0..PORTS).map(mode).collect(),
            output: [0; PORTS as usize],
            outside: [0; PORTS as usize],
        }
    }

    /// Back to the state after a reset; what is connected stays.
    pub fn reset(&mut self) {
        *self = Self {
            outside: self.outside,
            ..Self::new(self.modes)
        };
    }

    /// Drives a pin from outside.
    pub fn drive(&mut self, pin: Pin, level: bool) {
        let bit = 1 << pin.number;
        let port = &mut self.outside[pin.place()];
        *port = if level { *port | bit } else { *port & !bit };
    }

    /// Level that the firmware drives on a pin; `None` when the pin is no output.
    #[must_use]
    pub fn driven(&self, pin: Pin) -> Option<bool> {
        self.outputs(pin.place() as u32)
            .has(pin.number)
            .then(|| self.output[pin.place()] >> pin.number & 1 != 0)
    }

    /// Alternate function of a pin; `None` when it has another mode.
    #[must_use]
    pub fn alternate_function(&self, pin: Pin) -> Option<u32> {
        let port = pin.place() as u32 * PORT_SIZE;
        let mode = self.read(port) >> (2 * pin.number) & 3;
        let functions = self.read(port + 0x20 + 4 * u32::from(pin.number / 8));
        (mode == 2).then_some(functions >> (4 * (pin.number % 8)) & 0xF)
    }

    /// The pins of a port whose mode is output.
    fn outputs(&self, port: u32) -> Outputs {
        Outputs(
            self.registers
                .get(&(port * PORT_SIZE))
                .copied()
                .unwrap_or(0),
        )
    }

    /// Reads a register by its offset from port A.
    #[must_use]
    pub fn read(&self, offset: u32) -> u32 {
        let port = offset / PORT_SIZE;
        match offset % PORT_SIZE {
            0x10 => self.levels(port),
            0x14 => self.output[port as usize],
            _ => self.registers.get(&offset).copied().unwrap_or(0),
        }
    }

    fn levels(&self, port: u32) -> u32 {
        let (outputs, at) = (self.outputs(port), port as usize);
        (0..16).fold(0, |levels, pin| {
            let source = if outputs.has(pin) {
                self.output[at]
            } else {
                self.outside[at]
            };
            levels | source & 1 << pin
        })
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32) {
        let port = (offset / PORT_SIZE) as usize;
        match offset % PORT_SIZE {
            0x14 => self.output[port] = value & 0xFFFF,
            // Set wins over reset.
            0x18 => self.output[port] = self.output[port] & !(value >> 16) | value & 0xFFFF,
            _ => {
                self.registers.insert(offset, value);
            }
        }
    }
}

/// A mode register.
struct Outputs(u32);

impl Outputs {
    fn has(&self, pin: u8) -> bool {
        self.0 >> (2 * pin) & 3 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_shows_the_outside_and_an_output_itself() {
        let mut gpio = Gpio::new([0; 3]);
        let pin = Pin::new('C', 2);
        gpio.drive(pin, true);
        assert_eq!(gpio.read(0x810), 1 << 2);
        gpio.write(0x800, 1 << 4);
        assert_eq!((gpio.read(0x810), gpio.driven(pin)), (0, Some(false)));
        gpio.write(0x818, 1 << 2);
        assert_eq!(gpio.driven(pin), Some(true));
        gpio.write(0x818, 1 << 18);
        assert_eq!(gpio.driven(pin), Some(false));
    }

    #[test]
    fn what_is_connected_outlives_a_reset() {
        let mut gpio = Gpio::new([0; 3]);
        gpio.drive(Pin::new('A', 0), true);
        gpio.write(0x400, 1);
        gpio.reset();
        assert_eq!((gpio.read(0x10), gpio.driven(Pin::new('B', 0))), (1, None));
    }
}
