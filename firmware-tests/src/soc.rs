//! Everything but the processor: time, peripherals and where they are (RM0090 and RM0440, section 2).

mod clock_control;
mod dma;
mod flash;
mod serial;

use core::mem::take;

use crate::can::{Can, Wire};
use crate::chip::Chip;
use crate::clock::Clock;
use crate::dma::{Dma, Mux};
use crate::flash::Flash;
use crate::gpio::{self, Gpio};
use crate::hooks::Leave;
use crate::instructions::Runs;
use crate::load::Masked;
use crate::nvic::Nvic;
use crate::profile::Profile;
use crate::storage::Storage;
use crate::timer::{TIMERS, Timer};
use crate::usart::{SerialLine, Usart};
use crate::watchdog::Watchdog;

pub use serial::SerialPort;

/// First address of flash, where the vector table lies after a reset.
pub const FLASH: u32 = 0x0800_0000;
const WATCHDOG: u32 = 0x4000_3000;
const BLOCK: u32 = 0x400;
/// First address of the CAN controller, and of its message memory if it has one.
const CAN: u32 = 0x4000_6400;
const CAN_MEMORY: u32 = 0x4000_A400;
const SYSTEM_CONTROL: u32 = 0xE000_E000;
const AIRCR: u32 = 0xE000_ED0C;
const AIRCR_RESET: u32 = 0x05FA_0004;
const CYCLE_COUNTER: u32 = 0xE000_1004;
/// Why the chip started, as the flags in RCC_CSR tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetCause {
    /// The supply came.
    PowerOn,
    /// The reset pin.
    Pin,
    /// The firmware asked for it.
    Software,
    /// The independent watchdog was not fed.
    Watchdog,
}

/// Everything but the processor. Time counts in core cycles since power-on.
pub struct Soc {
    /// The present cycle.
    pub now: u64,
    /// Instructions executed so far.
    pub instructions: u64,
    /// Cycles asleep so far.
    pub idle: u64,
    /// The processor stops at this cycle for something that is due.
    pub deadline: u64,
    /// The run ends at this time.
    pub limit_ns: u64,
    /// Which chip it is.
    pub chip: &'static Chip,
    /// Clock tree.
    pub clock: Clock,
    /// Interrupt controller.
    pub nvic: Nvic,
    /// CAN controller.
    pub can: Can,
    /// The bus that it is connected to.
    pub wire: Wire,
    /// The serial port and the wire at it.
    pub serial: SerialPort,
    /// DMA controllers.
    pub dma: [Dma; 2],
    /// The flash.
    pub flash: Flash,
    /// Cycles so far in which the processor waited for the flash.
    pub stalled: u64,
    /// The request multiplexer of the DMA controllers, where there is one.
    mux: Mux,
    /// Pins.
    pub gpio: Gpio,
    /// Independent watchdog.
    pub watchdog: Watchdog,
    /// Everything else.
    pub storage: Storage,
    /// Straight runs of code met so far.
    pub runs: Runs,
    /// Stretches with interrupts masked.
    pub masked: Masked,
    /// Which code ran, while that is noted.
    pub profile: Option<Profile>,
    /// The event register of the processor.
    pub event: bool,
    /// Why the processor has stopped.
    pub leave: Option<Leave>,
    /// A reset that was asked for.
    pub reset_request: Option<ResetCause>,
    /// Deepest nesting of handlers so far.
    pub deepest_nesting: usize,
    /// The supply is below the level of the voltage detector.
    pub supply_is_low: bool,
    /// Breaks the model on purpose: floating-point registers are not stacked, so that a test can show that it notices.
    pub skip_floating_point: bool,
    timers: Vec<Timer>,
}

impl Soc {
    /// A chip that has just got its supply, on a board with a crystal of `hse_hz`, 0 for none, connected to `wire`.
    #[must_use]
    pub fn new(chip: &'static Chip, hse_hz: u64, mut wire: Wire) -> Self {
        let mut soc = Self {
            now: 0,
            instructions: 0,
            idle: 0,
            deadline: 0,
            limit_ns: 0,
            chip,
            clock: Clock::new(chip, hse_hz),
            nvic: Nvic::new(FLASH),
            can: Can::new(chip, &mut wire),
            wire,
            serial: SerialPort {
                port: Usart::new(chip.serial.registers),
                line: SerialLine::default(),
            },
            dma: [0, 1].map(|controller: usize| Dma::new(&chip.dma.controllers[controller])),
            flash: Flash::new(&chip.flash),
            stalled: 0,
            mux: Mux::default(),
            gpio: Gpio::new(chip.pin_modes),
            watchdog: Watchdog::default(),
            storage: Storage::default(),
            runs: Runs::default(),
            masked: Masked::default(),
            profile: None,
            event: false,
            leave: None,
            reset_request: None,
            deepest_nesting: 0,
            supply_is_low: false,
            skip_floating_point: false,
            timers: Vec::new(),
        };
        let (option_bytes, _, new) = chip.option_bytes;
        soc.storage.poke(option_bytes, new);
        soc.reset(ResetCause::PowerOn);
        soc
    }

    /// Back to the state after a reset. Memory, option bytes, bus and pins outside keep what they have.
    pub fn reset(&mut self, cause: ResetCause) {
        let (option_bytes, ..) = self.chip.option_bytes;
        let kept = self.storage.peek(option_bytes);
        self.storage.reset(self.chip.reset_values);
        self.storage.poke(option_bytes, kept);
        self.storage
            .poke(self.chip.reset_cause, self.chip.cause(cause));
        self.follow_clock();
        self.nvic = Nvic::new(FLASH);
        self.timers = TIMERS.map(Timer::new).to_vec();
        self.can.reset(&mut self.wire);
        self.serial.port.reset();
        self.dma.iter_mut().for_each(Dma::reset);
        self.mux = Mux::default();
        self.flash.reset();
        self.gpio.reset();
        self.watchdog.reset();
        (self.event, self.reset_request) = (false, None);
    }

    /// The time.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.clock.ns(self.now)
    }

    /// An exception was entered or left.
    pub fn note_exception(&mut self, cycles: u64) {
        self.event = true;
        self.now += cycles;
        self.deepest_nesting = self.deepest_nesting.max(self.nvic.nesting());
    }

    /// Brings the peripherals up to now, their request lines into the interrupt controller, and sets the next deadline.
    pub fn process(&mut self) {
        for timer in &mut self.timers {
            let level = timer.advance(self.now, &self.clock);
            self.nvic.set_line(timer.wiring().interrupt, level);
        }
        let now_ns = self.now_ns();
        self.can.advance(&mut self.wire, now_ns);
        for (interrupt, level) in self.can.lines() {
            self.nvic.set_line(interrupt, level);
        }
        self.advance_flash(now_ns);
        self.advance_serial(now_ns);
        for (interrupt, level) in self.dma.iter().flat_map(Dma::lines) {
            self.nvic.set_line(interrupt, level);
        }
        if self
            .watchdog
            .expires_ns()
            .is_some_and(|at_ns| at_ns <= now_ns)
        {
            self.reset_request = Some(ResetCause::Watchdog);
        }
        self.event |= self.nvic.take_event();
        self.deadline = self.next_event();
    }

    fn next_event(&self) -> u64 {
        if self.next_transfer().is_some() {
            return self.now;
        }
        let timers = self
            .timers
            .iter()
            .map(|timer| timer.next_event(&self.clock));
        let times_ns = [
            self.can.next_event_ns(&self.wire),
            self.watchdog.expires_ns(),
            self.flash.next_event_ns(),
            self.serial.port.next_event_ns(&self.serial.line),
            Some(self.limit_ns),
        ];
        let times = times_ns
            .into_iter()
            .flatten()
            .map(|at_ns| self.clock.cycles(at_ns));
        timers.chain(times).min().unwrap_or(u64::MAX)
    }

    /// Reads `size` bytes at `address`.
    pub fn read(&mut self, address: u32, size: usize) -> u32 {
        let value = self.read_word(address & !3) >> (8 * (address & 3));
        match size {
            4 => value,
            _ => value & ((1 << (8 * size)) - 1),
        }
    }

    fn read_word(&mut self, address: u32) -> u32 {
        if let Some(value) = address
            .checked_sub(SYSTEM_CONTROL)
            .and_then(|offset| self.nvic.read(offset))
        {
            return value;
        }
        if let Some(timer) = self
            .timers
            .iter_mut()
            .find(|timer| timer.wiring().base == address & !(BLOCK - 1))
        {
            return timer.read(address % BLOCK, self.now, &self.clock);
        }
        if let Some(offset) = self.gpio_offset(address) {
            return self.gpio.read(offset);
        }
        if let Some(word) = self.message_word(address) {
            return *word;
        }
        match address & !(BLOCK - 1) {
            CAN => {
                let now_ns = self.now_ns();
                self.can.advance(&mut self.wire, now_ns);
                self.can.read(&self.wire, address % BLOCK)
            }
            WATCHDOG => self.watchdog.read(address % BLOCK),
            block if block == self.chip.serial.base => self.read_serial(address),
            _ if self.is_mux(address) => self.read_mux(address),
            block if block == self.chip.flash_access => self.read_flash_register(address),
            _ if address == CYCLE_COUNTER => self.now as u32,
            _ => match self.dma_at(address) {
                Some(controller) => self.read_dma(controller, address),
                None => self.read_storage(address),
            },
        }
    }

    fn read_storage(&mut self, address: u32) -> u32 {
        let value = self.ready_bits(address, self.storage.peek(address));
        self.storage.note_read(address);
        let [(switch, on), (status, low)] = self.chip.detector;
        if address == self.chip.control() && !self.clock.has_crystal() {
            return value & !(clock_control::CR_HSE << 1);
        }
        if address == status && self.supply_is_low && self.storage.peek(switch) & on != 0 {
            return value | low;
        }
        value
    }

    fn message_word(&mut self, address: u32) -> Option<&mut u32> {
        let word = address.checked_sub(CAN_MEMORY)? / 4;
        self.can.memory()?.get_mut(word as usize)
    }

    fn gpio_offset(&self, address: u32) -> Option<u32> {
        let offset = address.checked_sub(self.chip.gpio)?;
        (offset < gpio::PORTS * gpio::PORT_SIZE).then_some(offset)
    }

    /// Writes `size` bytes at `address`.
    pub fn write(&mut self, address: u32, size: usize, value: u32) {
        let (word, shift) = (address & !3, 8 * (address & 3));
        if size == 4 {
            return self.write_word(word, value);
        }
        let mask = ((1_u32 << (8 * size)) - 1) << shift;
        if word & !(BLOCK - 1) == self.chip.serial.base {
            // A read of the rest would fetch a byte.
            return self.write_word(word, value << shift & mask);
        }
        // Peripherals see a part of a word with the rest unchanged; only interrupt priorities and plain storage are written so.
        let rest = self.read_word(word) & !mask;
        self.write_word(word, rest | value << shift & mask);
    }

    fn write_word(&mut self, address: u32, value: u32) {
        if let Some(offset) = address
            .checked_sub(SYSTEM_CONTROL)
            .filter(|offset| *offset < 0x1000)
        {
            if address == AIRCR && value & AIRCR_RESET == AIRCR_RESET {
                self.reset_request = Some(ResetCause::Software);
                self.deadline = 0;
            }
            if !self.nvic.write(offset, value) {
                self.storage.write(address, value);
            }
            return;
        }
        if let Some(timer) = self
            .timers
            .iter_mut()
            .find(|timer| timer.wiring().base == address & !(BLOCK - 1))
        {
            timer.write(address % BLOCK, value, self.now, &self.clock);
            return self.process();
        }
        if let Some(offset) = self.gpio_offset(address) {
            return self.gpio.write(offset, value);
        }
        if let Some(word) = self.message_word(address) {
            *word = value;
            return;
        }
        let now_ns = self.now_ns();
        match address & !(BLOCK - 1) {
            CAN => {
                self.can.advance(&mut self.wire, now_ns);
                self.can
                    .write(&mut self.wire, address % BLOCK, value, &self.clock);
                self.process();
            }
            WATCHDOG => {
                self.watchdog.write(address % BLOCK, value, now_ns);
                self.process();
            }
            block if block == self.chip.serial.base => self.write_serial(address, value),
            _ if self.is_mux(address) => self.write_mux(address, value),
            block if block == self.chip.flash_access => self.write_flash_register(address, value),
            _ => match self.dma_at(address) {
                Some(controller) => self.write_dma(controller, address, value),
                None => self.write_storage(address, value),
            },
        }
    }

    fn write_storage(&mut self, address: u32, value: u32) {
        self.storage.write(address, value);
        if address & !(BLOCK - 1) == self.chip.rcc {
            self.reset_peripherals(address, value);
        }
        if [self.chip.configuration, self.chip.pll_configuration].contains(&address) {
            self.follow_clock();
            // Every number of cycles has changed its meaning.
            self.deadline = 0;
        }
    }

    /// Takes the reset that was asked for.
    pub fn take_reset(&mut self) -> Option<ResetCause> {
        take(&mut self.reset_request)
    }
}
