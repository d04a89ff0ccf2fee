//! Values that come from nowhere and go nowhere, as far as the compiler knows.
//!
//! Every call reads or writes volatile memory, so no result can be assumed, remembered or left out.

use core::mem::MaybeUninit;
use core::ptr;

static SOURCE: u64 = 0;

/// Any 64 bits.
#[must_use]
pub fn bits() -> u64 {
    // SAFETY: a reference is valid and aligned, and nothing writes the static.
    unsafe { ptr::read_volatile(&SOURCE) }
}

/// Any unsigned number.
#[must_use]
pub fn word() -> u32 {
    bits() as u32
}

/// Any signed number.
#[must_use]
pub fn number() -> i32 {
    bits() as i32
}

/// Any byte.
#[must_use]
pub fn byte() -> u8 {
    bits() as u8
}

/// True or false.
#[must_use]
pub fn flag() -> bool {
    bits() & 1 != 0
}

/// Any floating-point number, also none.
#[must_use]
pub fn float() -> f64 {
    f64::from_bits(bits())
}

/// Any bytes.
#[must_use]
pub fn bytes<const N: usize>() -> [u8; N] {
    [(); N].map(|()| byte())
}

/// Any value of the type, of which the compiler has only seen this one.
#[must_use]
pub fn hide<T: Copy>(value: T) -> T {
    // SAFETY: a reference is valid and aligned.
    unsafe { ptr::read_volatile(&value) }
}

/// The same reference, behind which the compiler cannot look.
#[must_use]
pub fn reach<T>(value: &T) -> &T {
    hide(value)
}

/// The same reference, behind which the compiler cannot look.
#[must_use]
pub fn reach_mut<T>(value: &mut T) -> &mut T {
    let address = ptr::from_mut(value);
    // SAFETY: the address is that of a unique reference, which is given up for the one made here.
    unsafe { &mut *hide(address) }
}

/// One of the choices.
#[must_use]
pub fn pick<T: Copy, const N: usize>(choices: [T; N]) -> T {
    const { assert!(N > 0, "there is nothing to pick from") };
    choices[word() as usize % N]
}

/// The value or nothing.
#[must_use]
pub fn maybe<T>(value: T) -> Option<T> {
    flag().then_some(value)
}

/// Takes a value that must be computed for it.
pub fn consume<T>(value: T) {
    let mut sink = MaybeUninit::uninit();
    // SAFETY: the pointer is valid for writes and aligned; a value that is never read or dropped is only leaked.
    unsafe { ptr::write_volatile(sink.as_mut_ptr(), value) }
}
