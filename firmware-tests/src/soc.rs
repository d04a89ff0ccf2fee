//! Everything but the processor: time, peripherals and where they are (RM0090, section 2.3).

use core::mem::take;

use crate::bxcan::{self, BxCan, Wire};
use crate::clock::Clock;
use crate::gpio::{self, Gpio};
use crate::hooks::Leave;
use crate::instructions::Runs;
use crate::load::Masked;
use crate::nvic::{NMI, Nvic};
use crate::storage::Storage;
use crate::timer::{TIMERS, Timer};
use crate::watchdog::Watchdog;

/// First address of flash, where the vector table lies after a reset.
pub const FLASH: u32 = 0x0800_0000;
const WATCHDOG: u32 = 0x4000_3000;
const BLOCK: u32 = 0x400;
const PWR_CSR: u32 = 0x4000_7004;
const RCC_CR: u32 = 0x4002_3800;
const RCC_PLLCFGR: u32 = 0x4002_3804;
const RCC_CFGR: u32 = 0x4002_3808;
const RCC_CIR: u32 = 0x4002_380C;
const RCC_APB1RSTR: u32 = 0x4002_3820;
const RCC_APB2RSTR: u32 = 0x4002_3824;
const RCC_BDCR: u32 = 0x4002_3870;
const RCC_CSR: u32 = 0x4002_3874;
/// Wait states, caches and prefetch.
pub const FLASH_ACR: u32 = 0x4002_3C00;
/// Option bytes, among them the brown-out level; they outlive every reset.
pub const FLASH_OPTCR: u32 = 0x4002_3C14;
const FLASH_OPTCR_FACTORY: u32 = 0x0FFF_AAED;
const SYSTEM_CONTROL: u32 = 0xE000_E000;
const AIRCR: u32 = 0xE000_ED0C;
const AIRCR_RESET: u32 = 0x05FA_0004;
const CYCLE_COUNTER: u32 = 0xE000_1004;
/// HSEON, HSERDY, CSSON, PLLON and the switch of the clock.
const CR_HSE: u32 = 1 << 16;
const CR_CLOCK_SECURITY: u32 = 1 << 19;
const CR_PLL: u32 = 1 << 24;
const CFGR_SWITCH: u32 = 3;
/// CSSF.
const CIR_CLOCK_LOST: u32 = 1 << 7;
/// PVDE, and PVDO.
const PWR_CR: u32 = 0x4000_7000;
const CR_DETECTOR: u32 = 1 << 4;
const CSR_SUPPLY_LOW: u32 = 1 << 2;
const DEVICE_ID: (u32, u32) = (0xE004_2000, 0x1007_6413);
/// What registers without a model of their own hold after a reset.
const RESET_VALUES: [(u32, u32); 3] = [(RCC_CR, 0x83), (RCC_PLLCFGR, 0x2400_3010), DEVICE_ID];

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

impl ResetCause {
    /// RCC_CSR after the reset. Every reset inside the chip also pulls its reset pin.
    fn flags(self) -> u32 {
        match self {
            Self::PowerOn => 0x0E00_0000,
            Self::Pin => 1 << 26,
            Self::Software => 1 << 28 | 1 << 26,
            Self::Watchdog => 1 << 29 | 1 << 26,
        }
    }
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
    /// Clock tree.
    pub clock: Clock,
    /// Interrupt controller.
    pub nvic: Nvic,
    /// CAN controller.
    pub can: BxCan,
    /// The bus that it is connected to.
    pub wire: Wire,
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
    pub fn new(hse_hz: u64, mut wire: Wire) -> Self {
        let mut soc = Self {
            now: 0,
            instructions: 0,
            idle: 0,
            deadline: 0,
            limit_ns: 0,
            clock: Clock::new(hse_hz),
            nvic: Nvic::new(FLASH),
            can: BxCan::new(&mut wire),
            wire,
            gpio: Gpio::default(),
            watchdog: Watchdog::default(),
            storage: Storage::default(),
            runs: Runs::default(),
            masked: Masked::default(),
            event: false,
            leave: None,
            reset_request: None,
            deepest_nesting: 0,
            supply_is_low: false,
            skip_floating_point: false,
            timers: Vec::new(),
        };
        soc.storage.poke(FLASH_OPTCR, FLASH_OPTCR_FACTORY);
        soc.reset(ResetCause::PowerOn);
        soc
    }

    /// Back to the state after a reset. Memory, option bytes, bus and pins outside keep what they have.
    pub fn reset(&mut self, cause: ResetCause) {
        let option_bytes = self.storage.peek(FLASH_OPTCR);
        self.storage.reset(&RESET_VALUES);
        self.storage.poke(FLASH_OPTCR, option_bytes);
        self.storage.poke(RCC_CSR, cause.flags());
        self.follow_clock();
        self.nvic = Nvic::new(FLASH);
        self.timers = TIMERS.map(Timer::new).to_vec();
        self.can.reset(&mut self.wire);
        self.gpio.reset();
        self.watchdog = Watchdog::default();
        (self.event, self.reset_request) = (false, None);
    }

    /// The crystal breaks. With the clock security on the chip goes on from its internal oscillator and tells (RM0090, section 7.2.7);
    /// without it the processor stands still, which is not modelled: the chip goes on as if nothing had happened.
    pub fn lose_crystal(&mut self) {
        self.clock.lose_crystal();
        let control = self.storage.peek(RCC_CR);
        if control & CR_CLOCK_SECURITY == 0 {
            return;
        }
        self.storage.poke(RCC_CR, control & !(CR_HSE | CR_PLL));
        let switched = self.storage.peek(RCC_CFGR) & !CFGR_SWITCH;
        self.storage.poke(RCC_CFGR, switched);
        let flags = self.storage.peek(RCC_CIR) | CIR_CLOCK_LOST;
        self.storage.poke(RCC_CIR, flags);
        self.follow_clock();
        self.nvic.pend(NMI);
        self.deadline = 0;
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
        let timers = self
            .timers
            .iter()
            .map(|timer| timer.next_event(&self.clock));
        let times_ns = [
            self.can.next_event_ns(&self.wire),
            self.watchdog.expires_ns(),
            Some(self.limit_ns),
        ];
        let times = times_ns
            .into_iter()
            .flatten()
            .map(|at_ns| self.clock.cycles(at_ns));
        timers.chain(times).min().unwrap_or(u64::MAX)
    }

    fn follow_clock(&mut self) {
        let [cfgr, pllcfgr] = [RCC_CFGR, RCC_PLLCFGR].map(|register| self.storage.peek(register));
        self.clock.follow(self.now, cfgr, pllcfgr);
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
        if let Some(offset) = gpio_offset(address) {
            return self.gpio.read(offset);
        }
        match address & !(BLOCK - 1) {
            bxcan::BASE => {
                let now_ns = self.now_ns();
                self.can.advance(&mut self.wire, now_ns);
                self.can.read(&self.wire, address % BLOCK)
            }
            WATCHDOG => self.watchdog.read(address % BLOCK),
            _ if address == CYCLE_COUNTER => self.now as u32,
            _ => self.read_storage(address),
        }
    }

    fn read_storage(&mut self, address: u32) -> u32 {
        let value = ready_bits(address, self.storage.read(address));
        match address {
            RCC_CR if !self.clock.has_crystal() => value & !(CR_HSE << 1),
            PWR_CSR if self.supply_is_low && self.storage.peek(PWR_CR) & CR_DETECTOR != 0 => {
                value | CSR_SUPPLY_LOW
            }
            _ => value,
        }
    }

    /// Writes `size` bytes at `address`.
    pub fn write(&mut self, address: u32, size: usize, value: u32) {
        let (word, shift) = (address & !3, 8 * (address & 3));
        if size == 4 {
            return self.write_word(word, value);
        }
        let mask = ((1_u32 << (8 * size)) - 1) << shift;
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
        if let Some(offset) = gpio_offset(address) {
            return self.gpio.write(offset, value);
        }
        let now_ns = self.now_ns();
        match address & !(BLOCK - 1) {
            bxcan::BASE => {
                self.can.advance(&mut self.wire, now_ns);
                self.can
                    .write(&mut self.wire, address % BLOCK, value, &self.clock);
                self.process();
            }
            WATCHDOG => {
                self.watchdog.write(address % BLOCK, value, now_ns);
                self.process();
            }
            _ => self.write_storage(address, value),
        }
    }

    fn write_storage(&mut self, address: u32, value: u32) {
        self.storage.write(address, value);
        match address {
            RCC_APB1RSTR | RCC_APB2RSTR => self.reset_peripherals(address, value),
            RCC_CFGR | RCC_PLLCFGR => {
                self.follow_clock();
                // Every number of cycles has changed its meaning.
                self.deadline = 0;
            }
            _ => {}
        }
    }

    fn reset_peripherals(&mut self, register: u32, value: u32) {
        let bus = if register == RCC_APB1RSTR { 1 } else { 2 };
        for timer in &mut self.timers {
            let wiring = *timer.wiring();
            if wiring.bus == bus && value >> wiring.reset_bit & 1 != 0 {
                *timer = Timer::new(wiring);
            }
        }
        if bus == 1 && value >> bxcan::RESET_BIT & 1 != 0 {
            self.can.reset(&mut self.wire);
        }
    }

    /// Takes the reset that was asked for.
    pub fn take_reset(&mut self) -> Option<ResetCause> {
        take(&mut self.reset_request)
    }
}

fn gpio_offset(address: u32) -> Option<u32> {
    let offset = address.checked_sub(gpio::BASE)?;
    (offset < gpio::PORTS * gpio::PORT_SIZE).then_some(offset)
}

/// Oscillators, the PLL and the voltage scale are ready as soon as they are asked for.
fn ready_bits(address: u32, value: u32) -> u32 {
    let follow = |mask: u32, shift: u32| value & !(mask << shift) | (value & mask) << shift;
    match address {
        // HSI, HSE, PLL and PLLI2S.
        RCC_CR => follow(0x0501_0001, 1),
        // The clock switch.
        RCC_CFGR => follow(3, 2),
        // LSE and LSI.
        RCC_BDCR | RCC_CSR => follow(1, 1),
        PWR_CSR => value | 1 << 14,
        _ => value,
    }
}
