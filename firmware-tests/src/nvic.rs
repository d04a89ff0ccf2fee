//! Interrupt controller and system exceptions (ARMv7-M, sections B1.5 and B3.4).

/// Exceptions below this number are the processor's own.
pub const FIRST_INTERRUPT: u16 = 16;
/// The exception of a fault without a handler of its own.
pub const HARD_FAULT: u16 = 3;
/// The supervisor call.
pub const SV_CALL: u16 = 11;
/// The interrupt that no mask holds up.
pub const NMI: u16 = 2;
const PEND_SV: u16 = 14;
const SYS_TICK: u16 = 15;

/// Words of one bit an interrupt: the STM32F405 has 82, the STM32G474 102.
const WORDS: usize = 4;
/// Priority of the thread: below every exception.
const THREAD_PRIORITY: i32 = 256;
/// The STM32F405 has the upper four bits of each priority.
const PRIORITY_BITS: u8 = 0xF0;
const CPUID_CORTEX_M4: u32 = 0x410F_C241;
/// CCR: the stack is aligned to eight bytes on exception entry.
const STACK_ALIGN: u32 = 0x200;
const AIRCR_KEY_WRITE: u32 = 0x05FA;
const AIRCR_KEY_READ: u32 = 0xFA05;

/// The interrupt controller.
#[derive(Debug, Clone)]
pub struct Nvic {
    enabled: [u32; WORDS],
    pending: [u32; WORDS],
    /// Level of each request line: one that stays high pends again at the end of its handler.
    line: [u32; WORDS],
    priority: [u8; WORDS * 32],
    system_priority: [u8; 12],
    system_pending: u16,
    /// Exceptions under way, innermost last.
    active: Vec<u16>,
    vector_table: u32,
    priority_group: u32,
    send_event_on_pend: bool,
    first: Option<Pending>,
    pended: bool,
}

/// The exception that goes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pending {
    /// Its group priority; the smaller preempts.
    pub priority: i32,
    /// Its number.
    pub exception: u16,
}

impl Nvic {
    /// The controller after a reset.
    #[must_use]
    pub fn new(vector_table: u32) -> Self {
        Self {
            enabled: [0; WORDS],
            pending: [0; WORDS],
            line: [0; WORDS],
            priority: [0; WORDS * 32],
            system_priority: [0; 12],
            system_pending: 0,
            active: Vec::new(),
            vector_table,
            priority_group: 0,
            send_event_on_pend: false,
            first: None,
            pended: false,
        }
    }

    /// Address of the vector table.
    #[must_use]
    pub fn vector_table(&self) -> u32 {
        self.vector_table
    }

    /// The pending and enabled exception that goes first.
    #[must_use]
    pub fn first_pending(&self) -> Option<Pending> {
        self.first
    }

    /// Exceptions under way.
    #[must_use]
    pub fn nesting(&self) -> usize {
        self.active.len()
    }

    /// The innermost exception under way, 0 for the thread.
    #[must_use]
    pub fn innermost(&self) -> u16 {
        self.active.last().copied().unwrap_or(0)
    }

    /// Whether this exception is under way.
    #[must_use]
    pub fn is_active(&self, exception: u16) -> bool {
        self.active.contains(&exception)
    }

    /// Priority of what executes now.
    #[must_use]
    pub fn execution_priority(&self) -> i32 {
        let of = |&exception: &u16| self.group(self.raw_priority(exception));
        self.active.iter().map(of).min().unwrap_or(THREAD_PRIORITY)
    }

    /// Whether something was pended since the last call that shall wake a processor waiting for an event.
    pub fn take_event(&mut self) -> bool {
        core::mem::take(&mut self.pended) && self.send_event_on_pend
    }

    fn raw_priority(&self, exception: u16) -> i32 {
        match exception {
            NMI => -2,
            HARD_FAULT => -1,
            4..FIRST_INTERRUPT => i32::from(self.system_priority[usize::from(exception) - 4]),
            _ => i32::from(self.priority[usize::from(exception - FIRST_INTERRUPT)]),
        }
    }

    fn group(&self, priority: i32) -> i32 {
        let sub_priority_bits = (2 << self.priority_group) - 1;
        if priority < 0 {
            priority
        } else {
            priority & !sub_priority_bits & 0xFF
        }
    }

    fn find_first(&mut self) {
        let system =
            (0..FIRST_INTERRUPT).filter(|&exception| self.system_pending >> exception & 1 != 0);
        let interrupts = (0..WORDS).flat_map(|word| {
            let ready = self.enabled[word] & self.pending[word];
            (0..32)
                .filter(move |bit| ready >> bit & 1 != 0)
                .map(move |bit| FIRST_INTERRUPT + 32 * word as u16 + bit)
        });
        // Of equals the lower number goes first.
        let first = system
            .chain(interrupts)
            .min_by_key(|&exception| (self.raw_priority(exception), exception));
        self.first = first.map(|exception| Pending {
            priority: self.group(self.raw_priority(exception)),
            exception,
        });
    }

    /// Makes an exception pending.
    pub fn pend(&mut self, exception: u16) {
        self.pended = true;
        match place(exception) {
            None => self.system_pending |= 1 << exception,
            Some((word, bit)) => self.pending[word] |= bit,
        }
        self.find_first();
    }

    /// Level of a peripheral's request line.
    pub fn set_line(&mut self, interrupt: u16, level: bool) {
        let exception = interrupt + FIRST_INTERRUPT;
        let Some((word, bit)) = place(exception) else {
            return;
        };
        let was = self.line[word] & bit != 0;
        if level && !was {
            self.line[word] |= bit;
            self.pend(exception);
        } else if !level {
            self.line[word] &= !bit;
        }
    }

    /// The processor enters the handler of an exception.
    pub fn activate(&mut self, exception: u16) {
        match place(exception) {
            None => self.system_pending &= !(1 << exception),
            Some((word, bit)) => self.pending[word] &= !bit,
        }
        self.active.push(exception);
        self.find_first();
    }

    /// The processor leaves the handler of an exception.
    pub fn deactivate(&mut self, exception: u16) {
        self.active.retain(|&active| active != exception);
        if place(exception).is_some_and(|(word, bit)| self.line[word] & bit != 0) {
            self.pend(exception);
        }
        self.find_first();
    }

    /// Reads a register by its offset in the system control space; `None` when it is none of this controller.
    #[must_use]
    pub fn read(&self, offset: u32) -> Option<u32> {
        let word = (offset as usize & 0x7F) / 4;
        Some(match offset {
            0x100..=0x10C | 0x180..=0x18C => self.enabled[word],
            0x200..=0x20C | 0x280..=0x28C => self.pending[word],
            0x300..=0x30C => self.active_word(word),
            0x400..0x480 => bytes_at(&self.priority, offset - 0x400),
            0xD00 => CPUID_CORTEX_M4,
            0xD04 => self.interrupt_control_state(),
            0xD08 => self.vector_table,
            0xD0C => AIRCR_KEY_READ << 16 | self.priority_group << 8,
            0xD10 => u32::from(self.send_event_on_pend) << 4,
            0xD14 => STACK_ALIGN,
            0xD18..0xD24 => bytes_at(&self.system_priority, offset - 0xD18),
            _ => return None,
        })
    }

    fn active_word(&self, word: usize) -> u32 {
        let places = self.active.iter().filter_map(|&exception| place(exception));
        places
            .filter(|place| place.0 == word)
            .fold(0, |all, place| all | place.1)
    }

    fn interrupt_control_state(&self) -> u32 {
        let active = self.active.last().copied().map_or(0, u32::from);
        let pending = self.first.map_or(0, |first| u32::from(first.exception));
        let bit = |set: bool, at: u32| u32::from(set) << at;
        active
            | bit(self.active.len() <= 1, 11)
            | pending << 12
            | bit(pending >= u32::from(FIRST_INTERRUPT), 22)
            | bit(self.system_pending >> SYS_TICK & 1 != 0, 26)
            | bit(self.system_pending >> PEND_SV & 1 != 0, 28)
    }

    /// Writes a register; false when it is none of this controller. The reset request in AIRCR is the caller's.
    pub fn write(&mut self, offset: u32, value: u32) -> bool {
        let word = (offset as usize & 0x7F) / 4;
        match offset {
            0x100..=0x10C => self.enabled[word] |= value,
            0x180..=0x18C => self.enabled[word] &= !value,
            0x200..=0x20C => {
                self.pending[word] |= value;
                self.pended = true;
            }
            // A request that is still there pends again at once.
            0x280..=0x28C => self.pending[word] &= !value | self.line[word],
            0x400..0x480 => set_bytes_at(&mut self.priority, offset - 0x400, value),
            0xD04 => self.set_or_clear_system_pending(value),
            0xD08 => self.vector_table = value & !0x7F,
            0xD0C if value >> 16 == AIRCR_KEY_WRITE => self.priority_group = value >> 8 & 7,
            0xD10 => self.send_event_on_pend = value & 0x10 != 0,
            0xD18..0xD24 => set_bytes_at(&mut self.system_priority, offset - 0xD18, value),
            0xF00 => self.pend((value & 0x1FF) as u16 + FIRST_INTERRUPT),
            _ => return false,
        }
        self.find_first();
        true
    }

    fn set_or_clear_system_pending(&mut self, value: u32) {
        for (exception, set, clear) in [(PEND_SV, 28, 27), (SYS_TICK, 26, 25)] {
            if value >> set & 1 != 0 {
                self.system_pending |= 1 << exception;
            }
            if value >> clear & 1 != 0 {
                self.system_pending &= !(1 << exception);
            }
        }
    }
}

/// Word and bit of an interrupt; `None` for an exception of the processor.
fn place(exception: u16) -> Option<(usize, u32)> {
    let interrupt = exception.checked_sub(FIRST_INTERRUPT)?;
    Some((usize::from(interrupt / 32), 1 << (interrupt % 32)))
}

fn bytes_at(bytes: &[u8], at: u32) -> u32 {
    let word = &bytes[at as usize & !3..][..4];
    u32::from_le_bytes([word[0], word[1], word[2], word[3]])
}

fn set_bytes_at(bytes: &mut [u8], at: u32, value: u32) {
    let word = &mut bytes[at as usize & !3..][..4];
    for (byte, value) in word.iter_mut().zip(value.to_le_bytes()) {
        *byte = value & PRIORITY_BITS;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_enabled(interrupts: &[(u16, u8)]) -> Nvic {
        let mut nvic = Nvic::new(0x0800_0000);
        for &(interrupt, priority) in interrupts {
            nvic.write(0x100 + u32::from(interrupt / 32) * 4, 1 << (interrupt % 32));
            nvic.priority[usize::from(interrupt)] = priority;
        }
        nvic
    }

    #[test]
    fn the_most_urgent_goes_first_and_of_equals_the_lower_number() {
        let mut nvic = with_enabled(&[(20, 0x60), (40, 0x60), (50, 0x10)]);
        nvic.set_line(40, true);
        nvic.set_line(20, true);
        assert_eq!(nvic.first_pending().unwrap().exception, 36);
        nvic.set_line(50, true);
        assert_eq!(
            nvic.first_pending(),
            Some(Pending {
                priority: 0x10,
                exception: 66
            })
        );
    }

    #[test]
    fn a_line_that_stays_high_pends_again_at_the_end_of_its_handler() {
        let mut nvic = with_enabled(&[(20, 0)]);
        nvic.set_line(20, true);
        nvic.activate(36);
        assert_eq!(nvic.first_pending(), None);
        nvic.deactivate(36);
        assert_eq!(nvic.first_pending().unwrap().exception, 36);
        nvic.activate(36);
        nvic.set_line(20, false);
        nvic.deactivate(36);
        assert_eq!(nvic.first_pending(), None);
    }

    #[test]
    fn what_is_not_enabled_stays_pending_without_being_taken() {
        let mut nvic = with_enabled(&[]);
        nvic.set_line(20, true);
        assert_eq!(nvic.first_pending(), None);
        nvic.write(0x100, 1 << 20);
        assert_eq!(nvic.first_pending().unwrap().exception, 36);
    }

    #[test]
    fn nothing_executes_below_the_thread() {
        let mut nvic = with_enabled(&[(20, 0x60)]);
        assert_eq!(nvic.execution_priority(), THREAD_PRIORITY);
        nvic.activate(36);
        assert_eq!(nvic.execution_priority(), 0x60);
    }
}
