//! What a firmware that fails leaves for the one that starts after it.
//!
//! A panic or a fault resets the board at once, because code that has failed should do nothing more: set-points stop, and the next start,
//! whose code has not failed, tells the drives to disable and the user what happened. The note lies in memory that the start-up
//! code does not touch, and so does the mark of the lock: no reset ends it, only a supply that was away.

use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr;

use cortex_m::peripheral::SCB;

use crate::board;
use crate::start::Cause;

/// Bytes kept of the name of a source file: its end.
const FILE_BYTES: usize = 32;
/// Kinds of notes; memory after power-on is anything.
const PANIC: u32 = 0x1A57_C0DE;
const FAULT: u32 = 0xFA17_C0DE;
const LOST_CLOCK: u32 = 0xC10C_C0DE;
/// The firmware has failed since the supply came.
const LOCKED: u32 = 0x10C4_ED00;

/// A note. Any bit pattern is one, and `kind` says whether it was written.
#[repr(C)]
struct Note {
    kind: u32,
    /// The line of a panic; for a fault what the processor says about it, the CFSR register.
    detail: u32,
    file: [u8; FILE_BYTES],
    file_bytes: u32,
    lock: u32,
}

#[unsafe(link_section = ".uninit.LAST_WORDS")]
static mut LAST_WORDS: MaybeUninit<Note> = MaybeUninit::uninit();

/// Why the firmware failed.
pub(crate) enum LastWords {
    /// A panic.
    Panic(Place),
    /// A fault of the processor, with its CFSR register: ARMv7-M, section B3.2.15.
    Fault(u32),
    /// The crystal stopped while the board ran from it.
    LostClock,
}

/// What happened before this start.
pub(crate) struct History {
    /// What the firmware left that failed just before.
    pub(crate) last_words: Option<LastWords>,
    /// The firmware has failed since the supply came.
    pub(crate) is_locked: bool,
}

/// A place in the source.
pub(crate) struct Place {
    file: [u8; FILE_BYTES],
    file_bytes: usize,
    /// The line.
    pub(crate) line: u32,
}

impl Place {
    /// The end of the file's name.
    pub(crate) fn file(&self) -> &str {
        let bytes = self.file.get(..self.file_bytes).unwrap_or_default();
        core::str::from_utf8(bytes).unwrap_or("?")
    }
}

/// Takes the note of a firmware that failed before this start, and renews the lock.
pub(crate) fn take(cause: Cause) -> History {
    let place = (&raw mut LAST_WORDS).cast::<Note>();
    // SAFETY: called once, at the start, before anything else runs; memory always holds some bit pattern, and every one is a note.
    let note = unsafe { ptr::read_volatile(place) };
    // What memory holds after power-on means nothing, whatever it is.
    let is_valid = cause != Cause::PowerOn;
    let last_words = match note.kind {
        PANIC => Some(LastWords::Panic(Place {
            file: note.file,
            file_bytes: note.file_bytes as usize,
            line: note.detail,
        })),
        FAULT => Some(LastWords::Fault(note.detail)),
        LOST_CLOCK => Some(LastWords::LostClock),
        _ => None,
    }
    .filter(|_| is_valid);
    let has_failed = last_words.is_some() || cause == Cause::Watchdog;
    let is_locked = has_failed || is_valid && note.lock == LOCKED;
    // SAFETY: as above. The note counts once, the lock until the supply goes.
    unsafe {
        ptr::write_volatile(&raw mut (*place).kind, 0);
        ptr::write_volatile(&raw mut (*place).lock, if is_locked { LOCKED } else { 0 });
    }
    History {
        last_words,
        is_locked,
    }
}

/// The message is not kept: text would bring the formatting machinery into the image, and the place says enough.
#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    let mut note = Note {
        kind: PANIC,
        detail: 0,
        file: [0; FILE_BYTES],
        file_bytes: 0,
        lock: LOCKED,
    };
    if let Some(location) = info.location() {
        let name = location.file().as_bytes();
        let end = name.get(name.len().saturating_sub(FILE_BYTES)..);
        for (to, from) in note.file.iter_mut().zip(end.unwrap_or_default()) {
            *to = *from;
            note.file_bytes += 1;
        }
        note.detail = location.line();
    }
    // SAFETY: no interrupt comes any more, and there is one core.
    unsafe { ptr::write_volatile((&raw mut LAST_WORDS).cast::<Note>(), note) };
    SCB::sys_reset()
}

/// Any fault of the processor. One of them is a stack that has run into the end of memory, so what follows starts with an empty one.
///
/// # Safety
/// For the vector table only: it throws the stack away.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        "ldr r0, =_stack_start",
        "mov sp, r0",
        "b {note_fault}",
        note_fault = sym note_fault
    )
}

extern "C" fn note_fault() -> ! {
    let place = (&raw mut LAST_WORDS).cast::<Note>();
    // SAFETY: reading the register changes nothing. Nothing interrupts this handler, and there is one core.
    unsafe {
        ptr::write_volatile(&raw mut (*place).detail, (*SCB::PTR).cfsr.read());
        ptr::write_volatile(&raw mut (*place).kind, FAULT);
    }
    SCB::sys_reset()
}

/// The chip has found that its crystal stands still and has changed to the internal oscillator, which is too inaccurate for the bus and
/// makes every clock a tenth of what it was: nothing may go on.
#[cfg(not(all(feature = "link", feature = "stm32g474")))]
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() -> ! {
    note_lost_clock()
}

/// The same, unless it is a record in the flash that a cut of the supply has damaged, which its reader deals with.
#[cfg(all(feature = "link", feature = "stm32g474"))]
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() {
    if board::has_lost_clock() || !crate::store::has_met_damage() {
        note_lost_clock()
    }
}

fn note_lost_clock() -> ! {
    let place = (&raw mut LAST_WORDS).cast::<Note>();
    let kind = if board::has_lost_clock() {
        LOST_CLOCK
    } else {
        FAULT
    };
    // SAFETY: nothing but a fault, which ends in a reset too, interrupts this handler, and there is one core.
    unsafe {
        ptr::write_volatile(&raw mut (*place).detail, 0);
        ptr::write_volatile(&raw mut (*place).kind, kind);
    }
    SCB::sys_reset()
}
