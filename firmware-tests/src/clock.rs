//! The clock tree of a chip, and the time that its cycles make (RM0090, section 7; RM0440, section 7).

use crate::chip::Chip;

/// The internal oscillator, which runs after a reset.
const HSI_HZ: u64 = 16_000_000;
const NS_PER_S: u128 = 1_000_000_000;

/// Frequencies as the registers set them, and the relation of cycles to nanoseconds.
///
/// Cycles are those of the core since power-on; the relation is moved along at every change, so that neither ever jumps.
#[derive(Debug, Clone)]
pub struct Clock {
    chip: &'static Chip,
    hse_hz: u64,
    system_hz: u64,
    hclk_hz: u64,
    pclk1_hz: u64,
    timers_hz: [u64; 2],
    base_ns: u64,
    base_cycles: u64,
}

impl Clock {
    /// The clocks after power-on, for a board with a crystal of `hse_hz`; 0 for none.
    #[must_use]
    pub fn new(chip: &'static Chip, hse_hz: u64) -> Self {
        Self {
            chip,
            hse_hz,
            system_hz: HSI_HZ,
            hclk_hz: HSI_HZ,
            pclk1_hz: HSI_HZ,
            timers_hz: [HSI_HZ; 2],
            base_ns: 0,
            base_cycles: 0,
        }
    }

    /// Whether the board has a crystal.
    #[must_use]
    pub fn has_crystal(&self) -> bool {
        self.hse_hz > 0
    }

    /// The crystal breaks.
    pub fn lose_crystal(&mut self) {
        self.hse_hz = 0;
    }

    /// The core's frequency.
    #[must_use]
    pub fn hclk_hz(&self) -> u64 {
        self.hclk_hz
    }

    /// The frequency of a peripheral that chooses its clock: bus 1, system, internal oscillator (RM0440, section 7.4.28, LPUART1SEL).
    ///
    /// # Panics
    /// When it chooses the 32 kHz crystal, which the boards do not have.
    #[must_use]
    pub fn chosen_hz(&self, choice: u32) -> u64 {
        match choice {
            0 => self.pclk1_hz,
            1 => self.system_hz,
            2 => HSI_HZ,
            _ => panic!("a clock from the 32 kHz crystal is not modelled"),
        }
    }

    /// The frequency of the first peripheral bus, which clocks the CAN controller.
    #[must_use]
    pub fn pclk1_hz(&self) -> u64 {
        self.pclk1_hz
    }

    /// The frequency of the timers on peripheral bus 1 or 2.
    #[must_use]
    pub fn timer_hz(&self, bus: usize) -> u64 {
        self.timers_hz[bus - 1]
    }

    /// Time at a number of cycles, rounded down.
    #[must_use]
    pub fn ns(&self, cycles: u64) -> u64 {
        let since = u128::from(cycles - self.base_cycles);
        self.base_ns + (since * NS_PER_S / u128::from(self.hclk_hz)) as u64
    }

    /// First cycle at or after a time.
    #[must_use]
    pub fn cycles(&self, ns: u64) -> u64 {
        let since = u128::from(ns.saturating_sub(self.base_ns));
        let cycles = (since * u128::from(self.hclk_hz)).div_ceil(NS_PER_S);
        self.base_cycles
            .saturating_add(u64::try_from(cycles).unwrap_or(u64::MAX))
    }

    /// Follows the clock configuration and that of the PLL from the cycle `now` on.
    pub fn follow(&mut self, now: u64, cfgr: u32, pllcfgr: u32) {
        (self.base_ns, self.base_cycles) = (self.ns(now), now);
        let (pll, crystal) = self.chip.pll.switch;
        let system_hz = match cfgr & 3 {
            switch if switch == pll => self.pll_hz(pllcfgr),
            switch if switch == crystal => self.hse_hz,
            _ => HSI_HZ,
        };
        self.system_hz = system_hz;
        self.hclk_hz = system_hz >> ahb_shift(cfgr >> 4 & 0xF);
        let [(pclk1_hz, timer1_hz), (_, timer2_hz)] = self
            .chip
            .bus_dividers
            .map(|at| self.peripheral_bus(cfgr >> at & 7));
        self.pclk1_hz = pclk1_hz;
        self.timers_hz = [timer1_hz, timer2_hz];
    }

    fn pll_hz(&self, pllcfgr: u32) -> u64 {
        let pll = &self.chip.pll;
        let field = |(at, bits): (u32, u32)| u64::from(pllcfgr >> at & ((1 << bits) - 1));
        let (at, bits, crystal) = pll.source;
        let source_hz = if field((at, bits)) == u64::from(crystal) {
            self.hse_hz
        } else {
            HSI_HZ
        };
        let (at, bits, added) = pll.divider;
        let divider = (field((at, bits)) + added).max(1);
        source_hz / divider * field(pll.multiplier) / (2 * (field(pll.output) + 1))
    }

    /// Frequency of a peripheral bus and of its timers, which run twice as fast as a divided bus.
    fn peripheral_bus(&self, divider: u32) -> (u64, u64) {
        if divider < 4 {
            return (self.hclk_hz, self.hclk_hz);
        }
        let bus_hz = self.hclk_hz >> (divider - 3);
        (bus_hz, 2 * bus_hz)
    }
}

/// Division by 2, 4, 8, 16, 64, 128, 256, 512 for the codes 8 to 15; there is no 32.
fn ahb_shift(code: u32) -> u32 {
    match code {
        0..8 => 0,
        8..12 => code - 7,
        _ => code - 6,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chip;

    /// 8 MHz / 4 x 168 / 2, APB1 a quarter, APB2 half.
    const PLLCFGR: u32 = 1 << 22 | 168 << 6 | 4;
    const CFGR: u32 = 0b100 << 13 | 0b101 << 10 | 2;

    #[test]
    fn the_tree_of_the_board_is_168_42_and_twice_that_for_its_timers() {
        let mut clock = Clock::new(&chip::STM32F405, 8_000_000);
        clock.follow(0, CFGR, PLLCFGR);
        assert_eq!(
            (clock.hclk_hz(), clock.pclk1_hz()),
            (168_000_000, 42_000_000)
        );
        assert_eq!(
            (clock.timer_hz(1), clock.timer_hz(2)),
            (84_000_000, 168_000_000)
        );
    }

    #[test]
    fn the_tree_of_the_other_board_is_160_everywhere() {
        // 24 MHz / 6 x 80 / 2.
        let mut clock = Clock::new(&chip::STM32G474, 24_000_000);
        clock.follow(0, 3, 1 << 24 | 80 << 8 | 5 << 4 | 3);
        let timers = (clock.timer_hz(1), clock.timer_hz(2));
        assert_eq!(
            (clock.hclk_hz(), clock.pclk1_hz()),
            (160_000_000, 160_000_000)
        );
        assert_eq!(timers, (160_000_000, 160_000_000));
    }

    #[test]
    fn time_does_not_jump_when_the_clock_changes() {
        let mut clock = Clock::new(&chip::STM32F405, 8_000_000);
        assert_eq!(clock.ns(16_000), 1_000_000);
        clock.follow(16_000, CFGR, PLLCFGR);
        assert_eq!(clock.ns(16_000), 1_000_000);
        assert_eq!(clock.ns(16_000 + 168_000), 2_000_000);
        assert_eq!(clock.cycles(2_000_000), 16_000 + 168_000);
    }

    #[test]
    fn the_cycle_of_a_time_is_never_before_it() {
        let mut clock = Clock::new(&chip::STM32F405, 8_000_000);
        clock.follow(0, CFGR, PLLCFGR);
        for ns in 0..1_000 {
            assert!(clock.ns(clock.cycles(ns)) >= ns);
        }
    }
}
