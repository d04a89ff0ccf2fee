//! The independent watchdog (RM0090, section 21).

/// The oscillator of the watchdog, at its nominal frequency.
const LSI_HZ: u64 = 32_000;
/// The fastest that a real one may be (STM32F405 data sheet, section 5.3.9: 17 to 47 kHz).
pub const FASTEST_LSI_HZ: u64 = 47_000;
const NS_PER_S: u64 = 1_000_000_000;

/// The counter after the start, whatever the reload register holds: that is taken over at a feeding.
const FIRST_TICKS: u64 = 0x1000;

const KEY_RELOAD: u32 = 0xAAAA;
const KEY_START: u32 = 0xCCCC;
const KEY_UNLOCK: u32 = 0x5555;

/// The watchdog. Once started it stops only with the power.
#[derive(Debug, Clone)]
pub struct Watchdog {
    /// Frequency of its oscillator.
    pub oscillator_hz: u64,
    prescaler: u32,
    reload: u64,
    unlocked: bool,
    expires_ns: Option<u64>,
    feeds: u64,
}

impl Default for Watchdog {
    fn default() -> Self {
        Self {
            oscillator_hz: LSI_HZ,
            prescaler: 0,
            reload: 0xFFF,
            unlocked: false,
            expires_ns: None,
            feeds: 0,
        }
    }
}

impl Watchdog {
    /// A reset stops it.
    pub fn reset(&mut self) {
        *self = Self {
            oscillator_hz: self.oscillator_hz,
            ..Self::default()
        };
    }

    /// When it resets the chip unless it is fed before; `None` while it is not started.
    #[must_use]
    pub fn expires_ns(&self) -> Option<u64> {
        self.expires_ns
    }

    /// How often it was fed.
    #[must_use]
    pub fn feeds(&self) -> u64 {
        self.feeds
    }

    fn ns(&self, ticks: u64) -> u64 {
        let divider = 4 << self.prescaler.min(6);
        ticks * divider * NS_PER_S / self.oscillator_hz
    }

    /// Reads a register; a change of prescaler or reload value is never pending here.
    #[must_use]
    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            0x04 => self.prescaler,
            0x08 => self.reload as u32,
            _ => 0,
        }
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, now_ns: u64) {
        match (offset, value) {
            (0x00, KEY_START) => {
                self.unlocked = false;
                self.expires_ns = Some(now_ns + self.ns(FIRST_TICKS));
            }
            (0x00, KEY_RELOAD) => {
                self.unlocked = false;
                self.feeds += 1;
                self.expires_ns = self.expires_ns.map(|_| now_ns + self.ns(self.reload + 1));
            }
            (0x00, key) => self.unlocked = key == KEY_UNLOCK,
            (0x04, _) if self.unlocked => self.prescaler = value & 7,
            (0x08, _) if self.unlocked => self.reload = u64::from(value & 0xFFF),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// 32 kHz / 4 and 160 ticks: 20 ms.
    fn started() -> Watchdog {
        let mut watchdog = Watchdog::default();
        watchdog.write(0x00, KEY_UNLOCK, 0);
        watchdog.write(0x08, 159, 0);
        watchdog.write(0x00, KEY_START, 0);
        watchdog
    }

    #[test]
    fn it_expires_unless_it_is_fed() {
        let mut watchdog = started();
        assert_eq!(watchdog.expires_ns(), Some(512 * MS));
        watchdog.write(0x00, KEY_RELOAD, 0);
        assert_eq!(watchdog.expires_ns(), Some(20 * MS));
        watchdog.write(0x00, KEY_RELOAD, 15 * MS);
        assert_eq!(watchdog.expires_ns(), Some(35 * MS));
    }

    #[test]
    fn feeding_does_not_start_it_and_the_registers_are_locked() {
        let mut watchdog = Watchdog::default();
        watchdog.write(0x00, KEY_RELOAD, 0);
        watchdog.write(0x08, 1, 0);
        assert_eq!((watchdog.expires_ns(), watchdog.read(0x08)), (None, 0xFFF));
    }
}
