//! The clock control: oscillators, the crystal that breaks, resets of peripherals.

use super::Soc;
use crate::nvic::NMI;
use crate::timer::Timer;

/// HSEON, CSSON and PLLON, the same in both chips, and the switch of the clock.
pub(super) const CR_HSE: u32 = 1 << 16;
const CR_CLOCK_SECURITY: u32 = 1 << 19;
const CR_PLL: u32 = 1 << 24;
const CFGR_SWITCH: u32 = 3;

impl Soc {
    /// The crystal breaks. With the clock security on the chip goes on from its internal oscillator and tells (RM0090, section 7.2.7);
    /// without it the processor stands still, which is not modelled: the chip goes on as if nothing had happened.
    pub fn lose_crystal(&mut self) {
        self.clock.lose_crystal();
        let control = self.storage.peek(self.chip.control());
        if control & CR_CLOCK_SECURITY == 0 {
            return;
        }
        let (interrupts, lost) = self.chip.clock_lost;
        for (register, set, clear) in [
            (self.chip.control(), 0, CR_HSE | CR_PLL),
            (self.chip.configuration, 0, CFGR_SWITCH),
            (interrupts, lost, 0),
        ] {
            let value = self.storage.peek(register) & !clear | set;
            self.storage.poke(register, value);
        }
        self.follow_clock();
        self.nvic.pend(NMI);
        self.deadline = 0;
    }

    pub(super) fn follow_clock(&mut self) {
        let registers = [self.chip.configuration, self.chip.pll_configuration];
        let [configuration, pll] = registers.map(|register| self.storage.peek(register));
        self.clock.follow(self.now, configuration, pll);
    }

    /// Oscillators and the PLL are ready as soon as they are asked for.
    pub(super) fn ready_bits(&self, address: u32, value: u32) -> u32 {
        let answers = self.chip.ready.iter();
        let answers = answers.filter(|answer| answer.register == address);
        answers.fold(value, |value, answer| {
            value & !(answer.asked << answer.shift) | (value & answer.asked) << answer.shift
        })
    }

    pub(super) fn reset_peripherals(&mut self, register: u32, value: u32) {
        let resets = self.chip.resets.iter();
        let bus = 1 + resets.take_while(|reset| **reset != register).count();
        for timer in &mut self.timers {
            let wiring = *timer.wiring();
            if wiring.bus == bus && value >> wiring.reset_bit & 1 != 0 {
                *timer = Timer::new(wiring);
            }
        }
        let (can_reset, bit) = self.chip.can_reset;
        if register == can_reset && value >> bit & 1 != 0 {
            self.can.reset(&mut self.wire);
        }
        let (serial_reset, bit) = self.chip.serial.reset;
        if register == serial_reset && value >> bit & 1 != 0 {
            self.serial.port.reset();
        }
        if register == self.chip.dma.reset {
            self.reset_dma(value);
        }
    }
}
