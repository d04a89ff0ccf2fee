//! The serial port with its DMA on a whole chip: the registers are written as a debug probe does while the processor spins.

use drive_sim::{BitRate, Bus, ScriptedFaults};
use firmware_tests::can::Wire;
use firmware_tests::chip::{Chip, STM32F405, STM32G474};
use firmware_tests::image::Piece;
use firmware_tests::usart::Symbol;
use firmware_tests::{Board, Image, ResetCause, Stop};

const FLASH: u32 = 0x0800_0000;
const RING: u32 = 0x2000_0200;
const RING_BYTES: u32 = 8;
const TEXT: u32 = 0x2000_0300;
const CORE_COUPLED: u32 = 0x1000_0000;
const BYTE_NS: u64 = 86_806;

/// A chip whose serial port runs at 115 200 bit/s, with 16 MHz as after a reset.
struct Lone {
    board: Board,
    at: Addresses,
}

/// Where a chip has what the tests touch.
struct Addresses {
    /// Clock enables: port A, DMA, serial port.
    clocks: [(u32, u32); 3],
    /// Reset of the DMA controllers and its value.
    dma_reset: (u32, u32),
    port_a: u32,
    function: u32,
    /// CR1 and its value, CR3, BRR and its value, status register, received data, data to send.
    cr1: (u32, u32),
    cr3: u32,
    baud: (u32, u32),
    status: u32,
    fetch: u32,
    put: u32,
    /// Control register and its value, number of items, peripheral and memory address, for receiving and sending.
    streams: [(u32, u32); 2],
    /// Flags of the controller; those of a transfer error of the receiving stream.
    flags: (u32, u32),
}

const F4: Addresses = Addresses {
    clocks: [
        (0x4002_3830, 1),
        (0x4002_3830, 1 << 21 | 1),
        (0x4002_3840, 1 << 17),
    ],
    dma_reset: (0x4002_3810, 1 << 21),
    port_a: 0x4002_0000,
    function: 7,
    cr1: (0x4000_440C, 1 << 13 | 0b1100),
    cr3: 0x4000_4414,
    baud: (0x4000_4408, 139),
    status: 0x4000_4400,
    fetch: 0x4000_4404,
    put: 0x4000_4404,
    streams: [
        (0x4002_6088, 4 << 25 | 1 << 10 | 1 << 8 | 0b110),
        (0x4002_60A0, 4 << 25 | 1 << 10 | 1 << 6),
    ],
    flags: (0x4002_6004, 1 << 9),
};

const G4: Addresses = Addresses {
    clocks: [(0x4002_104C, 1), (0x4002_1048, 0b101), (0x4002_105C, 1)],
    dma_reset: (0x4002_1028, 0b101),
    port_a: 0x4800_0000,
    function: 12,
    cr1: (0x4000_8000, 0b1101),
    cr3: 0x4000_8008,
    baud: (0x4000_800C, 35_556),
    status: 0x4000_801C,
    fetch: 0x4000_8024,
    put: 0x4000_8028,
    // Channels 1 and 2.
    streams: [
        (0x4002_0008, 1 << 7 | 1 << 5 | 1 << 3),
        (0x4002_001C, 1 << 7 | 1 << 4),
    ],
    flags: (0x4002_0000, 1 << 3),
};

impl Lone {
    fn both() -> [Self; 2] {
        [Self::new(&STM32F405, F4), Self::new(&STM32G474, G4)]
    }

    /// A chip with everything on but the port itself and its DMA.
    fn new(chip: &'static Chip, at: Addresses) -> Self {
        // Stack pointer, entry; b .
        let table = [0x2000_1000_u32, FLASH + 9].into_iter();
        let mut bytes: Vec<u8> = table.flat_map(u32::to_le_bytes).collect();
        bytes.extend([0xFE, 0xE7]);
        let image = Image::of_pieces(vec![Piece {
            address: FLASH,
            bytes,
        }]);
        let bus = Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new());
        let board = Board::new(chip, image, chip.crystal_hz, Wire::new(bus)).unwrap();
        let mut lone = Self { board, at };
        for (register, value) in lone.at.clocks {
            lone.write(register, value);
        }
        lone.connect_pins();
        let (baud, divider) = lone.at.baud;
        lone.write(baud, divider);
        lone
    }

    /// PA2 and PA3 in the alternate function of the port.
    fn connect_pins(&mut self) {
        let (port, function) = (self.at.port_a, self.at.function);
        self.write(port, 0b1010 << 4);
        self.write(port + 0x20, function << 8 | function << 12);
    }

    fn switch_on(&mut self) {
        let (cr1, value) = self.at.cr1;
        self.write(cr1, value);
        self.run_bytes(2);
    }

    fn write(&mut self, address: u32, value: u32) {
        self.board.soc_mut().write(address, 4, value);
    }

    fn read(&mut self, address: u32) -> u32 {
        self.board.soc_mut().read(address, 4)
    }

    fn now_ns(&self) -> u64 {
        self.board.soc().now_ns()
    }

    fn run_bytes(&mut self, bytes: u64) {
        let until_ns = self.now_ns() + bytes * BYTE_NS;
        assert_eq!(self.board.run_until_ns(until_ns), Stop::Limit);
    }

    fn send(&mut self, bytes: &[u8]) {
        let now_ns = self.now_ns();
        let line = &mut self.board.soc_mut().serial.line;
        line.send_bytes(now_ns, bytes);
    }

    fn received(&mut self) -> Vec<u8> {
        let line = &mut self.board.soc_mut().serial.line;
        let received = line.take_received().into_iter();
        received.map(|received| received.byte).collect()
    }

    /// Starts the DMA of received bytes into memory at `memory`, in a circle, or of bytes to send from there.
    fn start_dma(&mut self, direction: usize, memory: u32, bytes: u32) {
        let (control, value) = self.at.streams[direction];
        let port = [self.at.fetch, self.at.put][direction];
        if self.board.soc().chip.name == "stm32g474" {
            self.write(0x4002_0800 + 4 * direction as u32, 34 + direction as u32);
        }
        self.write(control + 4, bytes);
        self.write(control + 8, port);
        self.write(control + 12, memory);
        self.write(control, value | 1);
        let cr3 = self.read(self.at.cr3);
        self.write(self.at.cr3, cr3 | 1 << (6 + direction));
    }

    fn memory(&self, address: u32) -> [u8; 8] {
        let words = [address, address + 4].map(|at| self.board.peek(at).unwrap());
        let mut bytes = [0; 8];
        bytes[..4].copy_from_slice(&words[0].to_le_bytes());
        bytes[4..].copy_from_slice(&words[1].to_le_bytes());
        bytes
    }
}

#[test]
fn received_bytes_go_round_in_memory_without_the_processor() {
    for mut lone in Lone::both() {
        lone.switch_on();
        lone.start_dma(0, RING, RING_BYTES);
        lone.send(b"0123456789");
        lone.run_bytes(11);
        let name = lone.board.soc().chip.name;
        assert_eq!(&lone.memory(RING), b"89234567", "{name}");
        let (control, _) = lone.at.streams[0];
        assert_eq!(lone.read(control + 4), 6, "{name}");
        assert_eq!(lone.board.soc().serial.port.overruns(), 0, "{name}");
    }
}

#[test]
fn a_text_in_memory_is_sent_byte_after_byte() {
    for mut lone in Lone::both() {
        lone.switch_on();
        let written = lone.board.engine_mut().mem_write(u64::from(TEXT), b"hello");
        written.unwrap();
        let start_ns = lone.now_ns();
        lone.start_dma(1, TEXT, 5);
        lone.run_bytes(6);
        let line = &mut lone.board.soc_mut().serial.line;
        let received = line.take_received();
        let bytes: Vec<u8> = received.iter().map(|received| received.byte).collect();
        assert_eq!(bytes, b"hello");
        let took_ns = received[4].at_ns - start_ns;
        assert!(took_ns.abs_diff(5 * BYTE_NS) < 2_000, "{took_ns}");
    }
}

#[test]
fn core_coupled_memory_is_out_of_reach_on_the_f405_alone() {
    for (mut lone, fails) in Lone::both().into_iter().zip([true, false]) {
        lone.switch_on();
        lone.start_dma(0, CORE_COUPLED, RING_BYTES);
        lone.send(b"abc");
        lone.run_bytes(4);
        let ((control, _), (flags, error)) = (lone.at.streams[0], lone.at.flags);
        let name = lone.board.soc().chip.name;
        assert_eq!(lone.read(flags) & error != 0, fails, "{name}");
        assert_eq!(lone.read(control) & 1 == 0, fails, "{name}");
        assert_eq!(&lone.memory(CORE_COUPLED)[..3] == b"abc", !fails, "{name}");
    }
}

#[test]
fn without_the_pins_or_the_clock_nothing_comes_or_goes() {
    for mut lone in Lone::both() {
        lone.switch_on();
        let (port, put, status) = (lone.at.port_a, lone.at.put, lone.at.status);
        lone.write(port, 0);
        lone.send(b"a");
        lone.write(put, 1);
        lone.run_bytes(2);
        assert_eq!(lone.read(status) & 1 << 5, 0);
        assert!(lone.received().is_empty());
        lone.connect_pins();
        let (clock, value) = lone.at.clocks[2];
        lone.write(clock, 0);
        lone.send(b"b");
        lone.write(put, 2);
        lone.run_bytes(2);
        assert_eq!(lone.read(lone.at.cr1.0), 0, "no clock, no registers");
        lone.write(clock, value);
        assert_eq!(lone.read(status) & 1 << 5, 0);
        assert!(lone.received().is_empty());
        lone.send(b"c");
        lone.write(put, 3);
        lone.run_bytes(2);
        assert_eq!(
            (lone.read(lone.at.fetch) as u8, lone.received()),
            (b'c', vec![3])
        );
    }
}

#[test]
fn a_byte_wide_write_sends_and_fetches_nothing() {
    for mut lone in Lone::both() {
        lone.switch_on();
        lone.send(b"x");
        lone.run_bytes(2);
        let put = lone.at.put;
        lone.board.soc_mut().write(put, 1, u32::from(b'y'));
        lone.run_bytes(2);
        assert_eq!(lone.received(), b"y");
        assert_eq!(lone.read(lone.at.status) & 1 << 5, 1 << 5);
        assert_eq!(lone.read(lone.at.fetch) as u8, b'x');
    }
}

#[test]
fn errors_of_the_wire_are_in_the_status() {
    for mut lone in Lone::both() {
        lone.switch_on();
        let now_ns = lone.now_ns();
        lone.board
            .soc_mut()
            .serial
            .line
            .send(now_ns, [Symbol::Break]);
        lone.run_bytes(3);
        assert_eq!(lone.read(lone.at.status) & 1 << 1, 1 << 1);
    }
}

#[test]
fn the_interrupts_are_pending_at_their_numbers() {
    for (mut lone, number) in Lone::both().into_iter().zip([38_u32, 91]) {
        let (cr1, value) = lone.at.cr1;
        lone.write(cr1, value | 1 << 5);
        lone.run_bytes(2);
        let pending = 0xE000_E200 + 4 * (number / 32);
        assert_eq!(lone.read(pending) >> (number % 32) & 1, 0);
        lone.send(b"q");
        lone.run_bytes(1);
        assert_eq!(lone.read(pending) >> (number % 32) & 1, 1);
    }
}

#[test]
fn resets_put_the_controllers_back() {
    for mut lone in Lone::both() {
        lone.switch_on();
        lone.start_dma(0, RING, RING_BYTES);
        let ((control, _), (reset, value)) = (lone.at.streams[0], lone.at.dma_reset);
        assert_eq!(lone.read(control) & 1, 1);
        lone.write(reset, value);
        lone.write(reset, 0);
        assert_eq!(lone.read(control), 0);
        lone.board.soc_mut().reset(ResetCause::Pin);
        for (register, value) in lone.at.clocks {
            lone.write(register, value);
        }
        assert_eq!(lone.read(lone.at.cr1.0), 0);
    }
}
