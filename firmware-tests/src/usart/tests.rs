//! The ports at their registers: what a driver relies on, and what happens when it is late, wrong or cut off.

use super::*;

/// Both ports in this order.
const BOTH: [Registers; 2] = [Registers::Classic, Registers::LowPower];
const AROUND: Surroundings = Surroundings {
    kernel_hz: 16_000_000,
    wired: [true; 2],
};
/// A bit at 115 200 bit/s is 8.68 us; ten are a byte.
const BYTE_NS: u64 = 86_805;
const CR3_DMA: u32 = CR3_DMA_RECEIVE | CR3_DMA_TRANSMIT;

struct Lone {
    port: Usart,
    line: SerialLine,
    now_ns: u64,
}

impl Lone {
    /// On, at 115 200 bit/s, with the idle frame of the start behind it.
    fn on(registers: Registers) -> Self {
        let mut lone = Self {
            port: Usart::new(registers),
            line: SerialLine::default(),
            now_ns: 0,
        };
        // 16 MHz / 115 200 = 138.9; 256 times that = 35 556.
        lone.set(Register::Baud, [139, 35_556]);
        lone.set_cr1(CR1_RECEIVE | CR1_TRANSMIT);
        lone.run_to(BYTE_NS + 1_000);
        lone.forget_idle();
        lone
    }

    fn offset(&self, register: Register) -> u32 {
        let [classic, low_power] = match register {
            Register::Control1 => [0x0C, 0x00],
            Register::Control3 => [0x14, 0x08],
            Register::Baud => [0x08, 0x0C],
            Register::Status => [0x00, 0x1C],
            Register::Fetch => [0x04, 0x24],
            Register::Put => [0x04, 0x28],
        };
        match self.port.registers {
            Registers::Classic => classic,
            Registers::LowPower => low_power,
        }
    }

    fn set(&mut self, register: Register, [classic, low_power]: [u32; 2]) {
        let value = match self.port.registers {
            Registers::Classic => classic,
            Registers::LowPower => low_power,
        };
        let offset = self.offset(register);
        self.port.write(offset, value, self.now_ns, &AROUND);
    }

    fn set_cr1(&mut self, value: u32) {
        self.set(Register::Control1, [value | 1 << 13, value | 1]);
    }

    fn put(&mut self, byte: u8) {
        self.set(Register::Put, [u32::from(byte); 2]);
    }

    fn status(&mut self) -> u32 {
        let offset = self.offset(Register::Status);
        self.port.read(offset) & 0xFF
    }

    fn fetch(&mut self) -> u8 {
        let offset = self.offset(Register::Fetch);
        self.port.read(offset) as u8
    }

    fn forget_idle(&mut self) {
        match self.port.registers {
            Registers::Classic => {
                self.status();
                self.fetch();
            }
            Registers::LowPower => self.port.write(0x20, IDLE, self.now_ns, &AROUND),
        }
    }

    fn run_to(&mut self, ns: u64) {
        self.now_ns = ns;
        self.port.advance(ns, Some(&AROUND), &mut self.line);
    }

    fn run(&mut self, ns: u64) {
        self.run_to(self.now_ns + ns);
    }

    fn send(&mut self, bytes: &[u8]) {
        self.line.send_bytes(self.now_ns, bytes);
    }
}

#[derive(Clone, Copy)]
enum Register {
    Control1,
    Control3,
    Baud,
    Status,
    Fetch,
    Put,
}

#[test]
fn a_byte_is_there_in_the_middle_of_its_stop_bit_and_not_before() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        lone.send(&[0x5A]);
        lone.run(82_400);
        assert_eq!(lone.status(), COMPLETE | EMPTY, "{registers:?}");
        lone.run(200);
        assert_eq!(lone.status(), RECEIVED | COMPLETE | EMPTY, "{registers:?}");
        assert_eq!(lone.fetch(), 0x5A);
        assert_eq!(lone.status(), COMPLETE | EMPTY, "{registers:?}");
    }
}

#[test]
fn a_byte_that_is_not_fetched_in_time_costs_the_next() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        lone.send(&[1, 2, 3]);
        lone.run(2 * BYTE_NS);
        assert_eq!(lone.status() & OVERRUN, OVERRUN, "{registers:?}");
        assert_eq!((lone.fetch(), lone.port.overruns()), (1, 1));
        lone.run(BYTE_NS);
        assert_eq!(lone.fetch(), 3);
    }
}

#[test]
fn the_older_port_forgets_errors_by_a_read_of_both_registers_and_the_newer_by_its_clear_register() {
    let mut lone = Lone::on(Registers::Classic);
    lone.line.send(lone.now_ns, [Symbol::Noisy(7)]);
    lone.run(BYTE_NS);
    assert_eq!(lone.fetch(), 7);
    assert_eq!(lone.status() & NOISE, NOISE);
    assert_eq!(lone.status() & NOISE, NOISE);
    lone.fetch();
    assert_eq!(lone.status() & NOISE, 0);

    let mut lone = Lone::on(Registers::LowPower);
    lone.line.send(lone.now_ns, [Symbol::Noisy(7)]);
    lone.run(BYTE_NS);
    lone.status();
    lone.fetch();
    assert_eq!(lone.status() & NOISE, NOISE);
    lone.port.write(0x20, NOISE, lone.now_ns, &AROUND);
    assert_eq!(lone.status() & NOISE, 0);
}

#[test]
fn idle_comes_a_frame_after_the_last_byte_and_once() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        lone.set_cr1(CR1_RECEIVE | IDLE);
        lone.send(&[1, 2]);
        lone.run(BYTE_NS);
        lone.fetch();
        lone.run(BYTE_NS);
        lone.fetch();
        assert!(!lone.port.line(), "{registers:?}");
        lone.run(BYTE_NS - 1_000);
        assert!(!lone.port.line(), "{registers:?}");
        lone.run(2_000);
        assert!(lone.port.line(), "{registers:?}");
        lone.forget_idle();
        lone.run(100 * BYTE_NS);
        assert!(!lone.port.line(), "{registers:?}");
    }
}

#[test]
fn bytes_go_out_one_behind_the_other_and_complete_with_the_last() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        let start_ns = lone.now_ns;
        lone.put(b'a');
        assert_eq!(lone.status() & EMPTY, EMPTY, "{registers:?}");
        lone.put(b'b');
        // In the FIFO's absence there is room for one.
        assert_eq!(lone.status() & EMPTY, 0, "{registers:?}");
        lone.run(2 * BYTE_NS - 1_000);
        assert_eq!(lone.status() & EMPTY, EMPTY, "{registers:?}");
        lone.run(2_000);
        assert_eq!(lone.status() & COMPLETE, COMPLETE, "{registers:?}");
        let received = lone.line.take_received();
        let bytes: Vec<u8> = received.iter().map(|received| received.byte).collect();
        assert_eq!(bytes, b"ab", "{registers:?}");
        for (received, expected) in received.iter().zip([1, 2]) {
            let off = (received.at_ns - start_ns).abs_diff(expected * BYTE_NS);
            assert!(off < 200 && !received.framing_error, "{received:?}");
        }
    }
}

#[test]
fn complete_is_cleared_by_the_write_alone_on_the_newer_port_only() {
    for (registers, expected) in BOTH.into_iter().zip([COMPLETE, 0]) {
        let mut lone = Lone::on(registers);
        // The setup has read SR.
        lone.port.seen = 0;
        lone.put(1);
        assert_eq!(lone.status() & COMPLETE, expected, "{registers:?}");
        lone.put(2);
        assert_eq!(lone.status() & COMPLETE, 0, "{registers:?}");
    }
}

#[test]
fn a_write_without_room_takes_the_place_of_the_byte_that_waits() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        for byte in [1, 2, 3] {
            lone.put(byte);
        }
        lone.run(5 * BYTE_NS);
        let received = lone.line.take_received();
        let bytes: Vec<u8> = received.iter().map(|received| received.byte).collect();
        assert_eq!(bytes, [1, 3], "{registers:?}");
    }
}

#[test]
fn other_bit_rates_make_wrong_bytes_with_framing_errors_both_ways() {
    for registers in BOTH {
        for (rate, is_read) in [
            (118_500, true),
            (112_000, true),
            (121_500, false),
            (109_000, false),
            (57_600, false),
            (230_400, false),
        ] {
            let mut lone = Lone::on(registers);
            lone.line.set_rate(rate);
            lone.send(&[0x31]);
            lone.put(0x32);
            lone.run(3 * BYTE_NS);
            let name = format!("{registers:?} against {rate}");
            assert_eq!(lone.status() & FRAMING_ERROR == 0, is_read, "{name}");
            assert_eq!(lone.fetch() == 0x31, is_read, "{name}");
            let received = lone.line.take_received();
            assert_eq!(received.len(), 1, "{name}");
            assert_eq!(received[0].byte == 0x32, is_read, "{name}");
            assert_eq!(received[0].framing_error, !is_read, "{name}");
        }
    }
}

#[test]
fn a_break_is_a_zero_with_a_framing_error() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        lone.line
            .send(lone.now_ns, [Symbol::Break, Symbol::Byte(9)]);
        lone.run(12 * BYTE_NS / 10);
        assert_eq!(
            lone.status() & (FRAMING_ERROR | RECEIVED),
            FRAMING_ERROR | RECEIVED
        );
        assert_eq!(lone.fetch(), 0);
        lone.run(2 * BYTE_NS);
        assert_eq!(lone.fetch(), 9, "{registers:?}");
    }
}

#[test]
fn what_comes_to_a_port_that_does_not_listen_is_lost() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        lone.set_cr1(CR1_TRANSMIT);
        lone.send(&[1]);
        lone.run(BYTE_NS / 2);
        // It is switched on within the byte: the edges that it sees are not a start bit.
        lone.set_cr1(CR1_RECEIVE | CR1_TRANSMIT);
        lone.run(BYTE_NS);
        assert_eq!((lone.status() & RECEIVED, lone.line.lost()), (0, 1));
        lone.send(&[2]);
        lone.port
            .advance(lone.now_ns + BYTE_NS, None, &mut lone.line);
        assert_eq!((lone.status() & RECEIVED, lone.line.lost()), (0, 2));
        lone.run(BYTE_NS);
        lone.line.connect(false);
        lone.send(&[3]);
        lone.put(3);
        lone.run(2 * BYTE_NS);
        assert_eq!((lone.status() & RECEIVED, lone.line.lost()), (0, 3));
        assert!(lone.line.take_received().is_empty());
    }
}

#[test]
fn without_its_alternate_function_a_pin_is_dead() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        lone.send(&[1]);
        lone.put(2);
        let around = Surroundings {
            wired: [false; 2],
            ..AROUND
        };
        let later_ns = lone.now_ns + 2 * BYTE_NS;
        lone.port.advance(later_ns, Some(&around), &mut lone.line);
        assert_eq!(lone.status() & RECEIVED, 0, "{registers:?}");
        assert!(lone.line.take_received().is_empty(), "{registers:?}");
    }
}

#[test]
fn each_interrupt_needs_its_enable() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        let both = CR1_RECEIVE | CR1_TRANSMIT;
        for (enable, expected) in [
            (0, false),
            (COMPLETE, true),
            (EMPTY, true),
            (RECEIVED, false),
        ] {
            lone.set_cr1(both | enable);
            assert_eq!(lone.port.line(), expected, "{registers:?} {enable:#x}");
        }
        lone.send(&[1]);
        lone.run(BYTE_NS);
        assert!(lone.port.line(), "{registers:?}");
        lone.fetch();
        assert!(!lone.port.line(), "{registers:?}");
    }
}

#[test]
fn errors_alone_interrupt_the_older_port_only_with_dma() {
    for (registers, expected) in BOTH.into_iter().zip([false, true]) {
        let mut lone = Lone::on(registers);
        lone.set(Register::Control3, [CR3_ERROR_ENABLE; 2]);
        lone.line.send(lone.now_ns, [Symbol::Noisy(1)]);
        lone.run(BYTE_NS);
        assert_eq!(lone.port.line(), expected, "{registers:?}");
        lone.set(Register::Control3, [CR3_ERROR_ENABLE | CR3_DMA_RECEIVE; 2]);
        assert!(lone.port.line(), "{registers:?}");
    }
}

#[test]
fn dma_is_requested_for_a_received_byte_and_for_room() {
    for registers in BOTH {
        let mut lone = Lone::on(registers);
        assert_eq!(lone.port.requests(), [false; 2], "{registers:?}");
        lone.set(Register::Control3, [CR3_DMA; 2]);
        assert_eq!(lone.port.requests(), [false, true], "{registers:?}");
        lone.put(1);
        lone.put(2);
        assert_eq!(lone.port.requests(), [false; 2], "{registers:?}");
        lone.send(&[1]);
        lone.run(BYTE_NS + 1_000);
        assert_eq!(lone.port.requests(), [true, true], "{registers:?}");
    }
}

#[test]
fn the_fifo_of_the_newer_port_holds_eight() {
    let mut lone = Lone::on(Registers::LowPower);
    lone.port.write(0x00, 0, lone.now_ns, &AROUND);
    let on = CR1_RECEIVE | low_power::CR1_FIFO;
    lone.port.write(0x00, on | 1, lone.now_ns, &AROUND);
    lone.send(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
    lone.run(8 * BYTE_NS);
    assert_eq!(lone.status() & OVERRUN, 0);
    lone.run(BYTE_NS);
    assert_eq!(lone.status() & OVERRUN, OVERRUN);
    let bytes: Vec<u8> = (0..8).map(|_| lone.fetch()).collect();
    assert_eq!(bytes, [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(lone.status() & RECEIVED, 0);
}

#[test]
fn the_dividers_are_those_of_the_manuals() {
    // RM0090, section 30.3.4: USARTDIV 39.0625 is 0x271; from 72 MHz that makes 115 200 bit/s.
    assert_eq!(classic::bit_clocks(0, 0x271), 256 * 625);
    // With oversampling by 8 bit 3 of the fraction does not count: 0xDB is 13 and 3 eighths.
    assert_eq!(classic::bit_clocks(1 << 15, 0xDB), 256 * (8 * 13 + 3));
    assert_eq!(classic::bit_clocks(0, 0x00F), 0);
    // RM0440, section 38.4.7: 256ths of a clock, 0x300 is the least; prescalers 1, 12, 16, 256.
    let prescalers = [0, 5, 6, 7, 8, 11].map(|code| low_power::bit_clocks(0x300, code) / 0x300);
    assert_eq!(prescalers, [1, 10, 12, 16, 32, 256]);
    assert_eq!(low_power::bit_clocks(0x2FF, 0), 0);
}

#[test]
#[should_panic(expected = "8N1 alone")]
fn other_frames_are_refused() {
    let mut lone = Lone::on(Registers::Classic);
    lone.set_cr1(CR1_RECEIVE | 1 << 10);
}

#[test]
#[should_panic(expected = "makes no bit rate")]
fn a_divider_below_the_least_is_refused() {
    let mut lone = Lone::on(Registers::LowPower);
    lone.port.write(0x0C, 0x2FF, lone.now_ns, &AROUND);
}
