//! The latest faults, in memory that survives a reset; what is not in flash yet goes there when everything is off.

use board_link::frame::checksum;
use board_link::message::{FaultEntry, Text};
use board_settings::FaultNumber;

/// Faults that are kept.
pub(crate) const KEPT: usize = 32;
/// Bytes of a fault in flash.
pub(crate) const FAULT_BYTES: usize = 64;
/// Bytes of the version of the firmware, and of the end of the name of a source file.
const VERSION_BYTES: usize = 12;
const PLACE_BYTES: usize = 32;
/// The axis of a fault that is about none.
const NO_AXIS: u8 = u8::MAX;
/// The log was written by this layout.
const MARK: u32 = 0xFA01_0106;

/// A fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fault<'a> {
    /// The axis, where it is about one.
    pub(crate) axis: Option<u8>,
    /// Its number.
    pub(crate) code: u16,
    /// What else is known of it.
    pub(crate) detail: i32,
    /// The source file, for a panic.
    pub(crate) place: &'a str,
}

/// A fault as it is kept. Any bytes are one.
#[derive(Clone, Copy)]
#[repr(C)]
struct Entry {
    bytes: [u8; FAULT_BYTES],
    /// Of the bytes: a reset may have come while they were written.
    checksum: u32,
}

/// The log. Any bytes are one, so it can lie in memory that nothing has set.
#[repr(C)]
pub(crate) struct FaultLog {
    mark: u32,
    /// The number of the start.
    boot: u32,
    /// Milliseconds since then.
    uptime_ms: u32,
    /// The number of the next fault; the first is 1.
    next: u32,
    /// The number of the oldest that is not in flash.
    unstored: u32,
    entries: [Entry; KEPT],
}

impl FaultLog {
    /// Without faults, for tests.
    #[cfg(test)]
    const fn blank() -> Self {
        Self {
            mark: 0,
            boot: 0,
            uptime_ms: 0,
            next: 0,
            unstored: 0,
            entries: [Entry {
                bytes: [0; FAULT_BYTES],
                checksum: 0,
            }; KEPT],
        }
    }

    /// Whether it was kept over the reset; without a supply memory holds anything.
    pub(crate) const fn is_kept(&self) -> bool {
        self.mark == MARK && self.unstored >= 1 && self.unstored <= self.next
    }

    /// Begins anew.
    pub(crate) fn clear(&mut self) {
        (self.mark, self.boot, self.uptime_ms) = (MARK, 0, 0);
        (self.next, self.unstored) = (1, 1);
        for entry in &mut self.entries {
            entry.checksum = !checksum(&entry.bytes);
        }
    }

    /// Takes a fault out of flash, in any order.
    pub(crate) fn load(&mut self, bytes: [u8; FAULT_BYTES]) {
        let number = number_of(&bytes);
        if number == u32::MAX {
            return;
        }
        let place = self.entries.get(number as usize % KEPT);
        let is_older = place.is_some_and(|entry| {
            checksum(&entry.bytes) == entry.checksum && number_of(&entry.bytes) > number
        });
        if !is_older {
            self.put(number, bytes);
        }
        self.next = self.next.max(number + 1);
        self.unstored = self.next;
        self.boot = self.boot.max(word(&bytes, 4));
    }

    /// A start after all that was noted before; its number.
    pub(crate) fn begin_start(&mut self) -> u32 {
        (self.boot, self.uptime_ms) = (self.boot.wrapping_add(1), 0);
        self.boot
    }

    /// What the faults that are noted from now on say of the time.
    pub(crate) const fn set_uptime_ms(&mut self, uptime_ms: u32) {
        self.uptime_ms = uptime_ms;
    }

    /// Notes a fault. The oldest one makes room; the numbers show it where it was not in flash yet. A bus that stays off is told once: with
    /// nobody on it it goes off again every second, and would leave room for nothing else.
    pub(crate) fn note(&mut self, fault: Fault<'_>, version: &str) {
        if fault.code == FaultNumber::BUS_OFF && self.ends_with(fault.code) {
            return;
        }
        let mut bytes = [0; FAULT_BYTES];
        let axis = fault.axis.unwrap_or(NO_AXIS);
        let code = fault.code.to_le_bytes();
        let place = tail(fault.place, PLACE_BYTES);
        let fields: [&[u8]; 8] = [
            &self.next.to_le_bytes(),
            &self.boot.to_le_bytes(),
            &self.uptime_ms.to_le_bytes(),
            &fault.detail.to_le_bytes(),
            &code,
            &[axis, 0],
            version.as_bytes(),
            place.as_bytes(),
        ];
        let offsets = [0, 4, 8, 12, 16, 18, 20, 20 + VERSION_BYTES];
        let ends = [4, 8, 12, 16, 18, 20, 20 + VERSION_BYTES, FAULT_BYTES];
        for ((field, start), end) in fields.iter().zip(offsets).zip(ends) {
            let place = bytes.get_mut(start..end).unwrap_or_default();
            place
                .iter_mut()
                .zip(*field)
                .for_each(|(to, from)| *to = *from);
        }
        self.put(self.next, bytes);
        self.next = self.next.saturating_add(1);
    }

    /// Whether the latest fault of this start has this number.
    fn ends_with(&self, code: u16) -> bool {
        self.entry(self.next.wrapping_sub(1)).is_some_and(|entry| {
            let bytes = &entry.bytes;
            word(bytes, 4) == self.boot && word(bytes, 16) & 0xFFFF == u32::from(code)
        })
    }

    fn put(&mut self, number: u32, bytes: [u8; FAULT_BYTES]) {
        if let Some(entry) = self.entries.get_mut(number as usize % KEPT) {
            *entry = Entry {
                bytes,
                checksum: checksum(&bytes),
            };
        }
    }

    fn entry(&self, number: u32) -> Option<&Entry> {
        let entry = self.entries.get(number as usize % KEPT)?;
        let is_whole = checksum(&entry.bytes) == entry.checksum;
        (is_whole && number_of(&entry.bytes) == number).then_some(entry)
    }

    /// The oldest fault that is not in flash, with its number.
    pub(crate) fn unstored(&self) -> Option<(u32, [u8; FAULT_BYTES])> {
        let oldest = self.next.saturating_sub(KEPT as u32).max(self.unstored);
        (oldest..self.next).find_map(|number| Some((number, self.entry(number)?.bytes)))
    }

    /// A fault is in flash, and those before it.
    pub(crate) const fn note_stored(&mut self, number: u32) {
        self.unstored = number.saturating_add(1);
    }

    /// How many there are.
    pub(crate) fn count(&self) -> u32 {
        (0..KEPT as u32)
            .take_while(|index| self.get(*index).is_some())
            .count() as u32
    }

    /// A fault, 0 the latest.
    pub(crate) fn get(&self, index: u32) -> Option<FaultEntry> {
        let number = self.next.checked_sub(index.checked_add(1)?)?;
        let bytes = &self.entry(number)?.bytes;
        let axis = *bytes.get(18)?;
        Some(FaultEntry {
            number,
            boot: word(bytes, 4),
            uptime_ms: word(bytes, 8),
            detail: word(bytes, 12) as i32,
            code: (word(bytes, 16) & 0xFFFF) as u16,
            axis: (axis != NO_AXIS).then_some(axis),
            firmware: text(bytes.get(20..20 + VERSION_BYTES)?),
            place: text(bytes.get(20 + VERSION_BYTES..)?),
        })
    }
}

fn number_of(bytes: &[u8; FAULT_BYTES]) -> u32 {
    word(bytes, 0)
}

fn word(bytes: &[u8; FAULT_BYTES], at: usize) -> u32 {
    let word = bytes.get(at..).and_then(|rest| rest.first_chunk());
    word.map_or(0, |word| u32::from_le_bytes(*word))
}

/// Up to the first zero.
fn text(bytes: &[u8]) -> Text {
    let length = bytes.iter().position(|byte| *byte == 0);
    let bytes = bytes
        .get(..length.unwrap_or(bytes.len()))
        .unwrap_or_default();
    let text = core::str::from_utf8(bytes).unwrap_or_default();
    Text::try_from(text).unwrap_or_default()
}

/// The end of a text: whole characters.
fn tail(text: &str, most: usize) -> &str {
    let mut from = text.len().saturating_sub(most);
    while !text.is_char_boundary(from) {
        from += 1;
    }
    text.get(from..).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log() -> FaultLog {
        let mut log = FaultLog::blank();
        assert!(!log.is_kept());
        log.clear();
        assert!(log.is_kept());
        log
    }

    fn fault(code: u16) -> Fault<'static> {
        Fault {
            axis: Some(3),
            code,
            detail: -5,
            place: "",
        }
    }

    #[test]
    fn the_latest_fault_is_the_first() {
        let mut log = log();
        assert_eq!((log.count(), log.get(0)), (0, None));
        assert_eq!(log.begin_start(), 1);
        log.set_uptime_ms(1_234);
        log.note(fault(10), "0.1.0");
        log.note(
            Fault {
                axis: None,
                code: 200,
                detail: 77,
                place: "a/very/long/path/of/a/source/file/of/it.rs",
            },
            "0.1.0",
        );
        let entry = log.get(0).unwrap();
        assert_eq!((entry.number, entry.code, entry.axis), (2, 200, None));
        assert_eq!(entry.place.as_str(), "g/path/of/a/source/file/of/it.rs");
        let entry = log.get(1).unwrap();
        assert_eq!((entry.number, entry.code, entry.axis), (1, 10, Some(3)));
        assert_eq!((entry.detail, entry.uptime_ms, entry.boot), (-5, 1_234, 1));
        assert_eq!(entry.firmware.as_str(), "0.1.0");
        assert_eq!((log.count(), log.get(2)), (2, None));
        assert_eq!(log.get(u32::MAX), None);
    }

    #[test]
    fn the_last_32_are_kept_and_the_rest_is_counted() {
        let mut log = log();
        for code in 0..100 {
            log.note(fault(code), "1");
        }
        assert_eq!(log.count(), 32);
        assert_eq!(log.get(0).map(|entry| entry.number), Some(100));
        assert_eq!(log.get(31).map(|entry| entry.number), Some(69));
        assert_eq!(log.get(32), None);
        // Those that were overwritten before they were in flash are missing there.
        assert_eq!(log.unstored().map(|(number, _)| number), Some(69));
    }

    #[test]
    fn a_bus_that_stays_off_is_one_fault_of_a_start() {
        let mut log = log();
        let off = fault(FaultNumber::BUS_OFF);
        for boot in 1..=2 {
            assert_eq!(log.begin_start(), boot);
            log.note(fault(2), "1");
            (0..50).for_each(|_| log.note(off, "1"));
        }
        log.note(fault(10), "1");
        log.note(off, "1");
        let codes: std::vec::Vec<u16> = (0..log.count())
            .map(|at| log.get(at).unwrap().code)
            .collect();
        assert_eq!(codes, [100, 10, 100, 2, 100, 2]);
        assert_eq!(log.begin_start(), 3);
        // In a new start it may be the first.
        log.note(off, "1");
        assert_eq!(log.count(), 7);
    }

    #[test]
    fn each_goes_to_flash_once_and_comes_back() {
        let mut log = log();
        let boot = log.begin_start();
        let mut flash = std::vec::Vec::new();
        for code in 0..40 {
            log.note(fault(code), "1");
            while let Some((number, bytes)) = log.unstored() {
                flash.push(bytes);
                log.note_stored(number);
            }
        }
        assert_eq!(flash.len(), 40);
        let mut other = self::log();
        // As they lie in two areas.
        for bytes in flash[20..].iter().chain(&flash[..20]) {
            other.load(*bytes);
        }
        assert_eq!(other.unstored(), None);
        for index in 0..32 {
            assert_eq!(other.get(index), log.get(index));
        }
        assert_eq!(other.begin_start(), boot + 1);
        other.note(fault(7), "1");
        assert_eq!(other.get(0).map(|entry| entry.number), Some(41));
    }

    #[test]
    fn an_entry_that_a_reset_cut_off_is_left_out() {
        let mut log = log();
        log.note(fault(1), "1");
        log.note(fault(2), "1");
        log.entries[2].bytes[16] ^= 1;
        assert_eq!(log.get(0), None);
        assert_eq!(log.unstored().map(|(number, _)| number), Some(1));
        // And whatever memory holds, nothing goes wrong.
        for seed in 0..100 {
            let mut random = any_words(seed);
            log.next = random();
            log.unstored = random();
            let _ = (
                log.is_kept(),
                log.count(),
                log.unstored(),
                log.get(random()),
            );
            log.note(fault(3), "1");
        }
    }

    fn any_words(seed: u32) -> impl FnMut() -> u32 {
        let mut state = seed.wrapping_mul(0x9E37_79B9) | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            state
        }
    }
}
