//! General-purpose timers: counting up, compare, update (RM0090, section 18).

use std::collections::HashMap;

use crate::clock::Clock;

const CHANNELS: usize = 4;
const CR1_ENABLE: u32 = 1;
const CR1_UPDATE_DISABLE: u32 = 1 << 1;
const CR1_UPDATE_SOURCE: u32 = 1 << 2;
/// Update and compare flags in SR, and their enables in DIER.
const FLAGS: u32 = 0x1F;

/// Where a timer is and how it is wired.
#[derive(Debug, Clone, Copy)]
pub struct Wiring {
    /// First address.
    pub base: u32,
    /// Number of its interrupt.
    pub interrupt: u16,
    /// Peripheral bus 1 or 2.
    pub bus: usize,
    /// Its bit in the reset register of that bus.
    pub reset_bit: u32,
    /// Whether it counts in 32 bit.
    pub wide: bool,
}

/// The timers of the STM32F405 that only count: TIM2 to 7, TIM9, TIM12.
pub const TIMERS: [Wiring; 8] = [
    wiring(0x4000_0000, 28, 1, 0, true),
    wiring(0x4000_0400, 29, 1, 1, false),
    wiring(0x4000_0800, 30, 1, 2, false),
    wiring(0x4000_0C00, 50, 1, 3, true),
    wiring(0x4000_1000, 54, 1, 4, false),
    wiring(0x4000_1400, 55, 1, 5, false),
    wiring(0x4000_1800, 43, 1, 6, false),
    wiring(0x4001_4000, 24, 2, 16, false),
];

const fn wiring(base: u32, interrupt: u16, bus: usize, reset_bit: u32, wide: bool) -> Wiring {
    Wiring {
        base,
        interrupt,
        bus,
        reset_bit,
        wide,
    }
}

/// One timer. Its counter is a function of the time; flags are raised when somebody looks.
#[derive(Debug, Clone)]
pub struct Timer {
    wiring: Wiring,
    mask: u64,
    others: HashMap<u32, u32>,
    cr1: u32,
    interrupt_enable: u32,
    status: u32,
    prescaler: u64,
    /// The prescaler in use: a new one takes effect at an update.
    prescaler_in_use: u64,
    reload: u64,
    compare: [u64; CHANNELS],
    /// Cycle and counter of the last change; ticks count from there.
    started: u64,
    start_count: u64,
    /// Ticks since then for which flags have been raised.
    looked_at: u64,
}

impl Timer {
    /// The timer after a reset.
    #[must_use]
    pub fn new(wiring: Wiring) -> Self {
        let mask = if wiring.wide { 0xFFFF_FFFF } else { 0xFFFF };
        Self {
            wiring,
            mask,
            others: HashMap::new(),
            cr1: 0,
            interrupt_enable: 0,
            status: 0,
            prescaler: 0,
            prescaler_in_use: 0,
            reload: mask,
            compare: [0; CHANNELS],
            started: 0,
            start_count: 0,
            looked_at: 0,
        }
    }

    /// Where it is and how it is wired.
    #[must_use]
    pub fn wiring(&self) -> &Wiring {
        &self.wiring
    }

    fn is_running(&self) -> bool {
        self.cr1 & CR1_ENABLE != 0
    }

    /// Core cycles of a number of timer clocks as a fraction: times the first, by the second.
    fn ratio(&self, clock: &Clock) -> (u128, u128) {
        let divided = u128::from(clock.hclk_hz()) * u128::from(self.prescaler_in_use + 1);
        (divided, u128::from(clock.timer_hz(self.wiring.bus)))
    }

    fn ticks(&self, now: u64, clock: &Clock) -> u64 {
        if !self.is_running() {
            return 0;
        }
        let (cycles, timer) = self.ratio(clock);
        (u128::from(now - self.started) * timer / cycles) as u64
    }

    fn counter(&self, ticks: u64) -> u64 {
        (self.start_count + ticks) % (self.reload + 1)
    }

    /// First tick after `ticks` at which the counter reads `value`.
    fn next_hit(&self, ticks: u64, value: u64) -> u64 {
        let modulus = self.reload + 1;
        ticks + 1 + (value + modulus - (self.start_count + ticks + 1) % modulus) % modulus
    }

    /// The counter values that raise a flag, with that flag: 0 for the update, each compare value within reach.
    fn marks(&self) -> impl Iterator<Item = (u64, u32)> + '_ {
        let update = (self.cr1 & CR1_UPDATE_DISABLE == 0).then_some((0, 1));
        let compares = self.compare.iter().enumerate();
        let within = compares.filter(|(_, value)| **value <= self.reload);
        update
            .into_iter()
            .chain(within.map(|(channel, &value)| (value, 2 << channel)))
    }

    /// Raises the flags up to `now`; returns the level of the interrupt line.
    pub fn advance(&mut self, now: u64, clock: &Clock) -> bool {
        let ticks = self.ticks(now, clock);
        if ticks > self.looked_at {
            let from = self.looked_at;
            let hits = self
                .marks()
                .filter(|&(value, _)| self.next_hit(from, value) <= ticks);
            self.status |= hits.fold(0, |all, (_, flag)| all | flag);
            self.looked_at = ticks;
        }
        self.status & self.interrupt_enable & FLAGS != 0
    }

    /// The cycle of the next interrupt; `u64::MAX` for none.
    #[must_use]
    pub fn next_event(&self, clock: &Clock) -> u64 {
        let wanted = self.interrupt_enable & !self.status;
        let hits = self
            .marks()
            .filter(|&(_, flag)| flag & wanted != 0)
            .map(|(value, _)| self.next_hit(self.looked_at, value));
        let Some(ticks) = hits.min().filter(|_| self.is_running()) else {
            return u64::MAX;
        };
        let (cycles, timer) = self.ratio(clock);
        self.started + (u128::from(ticks) * cycles).div_ceil(timer) as u64
    }

    fn restart(&mut self, now: u64, count: u64) {
        (self.started, self.start_count, self.looked_at) = (now, count, 0);
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32, now: u64, clock: &Clock) -> u32 {
        self.advance(now, clock);
        match offset {
            0x00 => self.cr1,
            0x0C => self.interrupt_enable,
            0x10 => self.status,
            0x24 => self.counter(self.looked_at) as u32,
            0x28 => self.prescaler as u32,
            0x2C => self.reload as u32,
            0x34..=0x40 => self.compare[(offset as usize - 0x34) / 4] as u32,
            _ => self.others.get(&offset).copied().unwrap_or(0),
        }
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, now: u64, clock: &Clock) {
        self.advance(now, clock);
        let count = self.counter(self.looked_at);
        match offset {
            0x00 => {
                if (self.cr1 ^ value) & CR1_ENABLE != 0 {
                    self.restart(now, count);
                }
                self.cr1 = value;
            }
            0x0C => self.interrupt_enable = value,
            // Flags are cleared by writing 0.
            0x10 => self.status &= value,
            0x14 => self.generate(value, now),
            0x24 => self.restart(now, u64::from(value) & self.mask),
            0x28 => self.prescaler = u64::from(value) & 0xFFFF,
            0x2C => {
                self.restart(now, count);
                self.reload = u64::from(value) & self.mask;
            }
            0x34..=0x40 => {
                self.compare[(offset as usize - 0x34) / 4] = u64::from(value) & self.mask
            }
            _ => {
                self.others.insert(offset, value);
            }
        }
    }

    /// Events made by software.
    fn generate(&mut self, value: u32, now: u64) {
        if value & 1 != 0 {
            self.prescaler_in_use = self.prescaler;
            self.restart(now, 0);
            if self.cr1 & (CR1_UPDATE_SOURCE | CR1_UPDATE_DISABLE) == 0 {
                self.status |= 1;
            }
        }
        self.status |= value & FLAGS & !1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 16-bit timer with a tick of 16 cycles: 1 us at the 16 MHz after a reset.
    fn microseconds() -> (Timer, Clock) {
        let (mut timer, clock) = (
            Timer::new(TIMERS[6]),
            Clock::new(&crate::chip::STM32F405, 8_000_000),
        );
        timer.write(0x28, 15, 0, &clock);
        timer.write(0x14, 1, 0, &clock);
        timer.write(0x10, 0, 0, &clock);
        timer.write(0x00, CR1_ENABLE, 0, &clock);
        (timer, clock)
    }

    #[test]
    fn a_compare_interrupt_comes_at_its_tick_and_not_before() {
        let (mut timer, clock) = microseconds();
        timer.write(0x34, 100, 0, &clock);
        timer.write(0x0C, 2, 0, &clock);
        assert_eq!(timer.next_event(&clock), 1_600);
        assert!(!timer.advance(1_599, &clock));
        assert!(timer.advance(1_600, &clock));
        assert_eq!(timer.read(0x24, 1_600, &clock), 100);
        timer.write(0x10, !2, 1_600, &clock);
        assert!(!timer.advance(1_616, &clock));
    }

    #[test]
    fn the_counter_wraps_with_an_update() {
        let (mut timer, clock) = microseconds();
        timer.write(0x0C, 1, 0, &clock);
        let wrap = 65_536 * 16;
        assert_eq!(timer.next_event(&clock), wrap);
        assert!(!timer.advance(wrap - 1, &clock));
        assert!(timer.advance(wrap, &clock));
        assert_eq!(timer.read(0x24, wrap + 16, &clock), 1);
    }

    #[test]
    fn a_stopped_timer_stands() {
        let (mut timer, clock) = microseconds();
        timer.write(0x00, 0, 800, &clock);
        assert_eq!(timer.read(0x24, 80_000, &clock), 50);
        assert_eq!(timer.next_event(&clock), u64::MAX);
    }

    #[test]
    fn a_new_prescaler_waits_for_an_update() {
        let (mut timer, clock) = microseconds();
        timer.write(0x28, 31, 0, &clock);
        assert_eq!(timer.read(0x24, 1_600, &clock), 100);
        timer.write(0x14, 1, 1_600, &clock);
        assert_eq!(timer.read(0x24, 3_200, &clock), 50);
    }
}
