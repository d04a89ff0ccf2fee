//! The level of the supply below which the chip stays in reset. It is in the option bytes, which the chip keeps for its life: only the
//! image of `cargo fw --commission` writes it, on command; the firmware looks whether it is set.
//!
//! Below the highest level neither the flash nor the clock is specified for the speed that the boards run at.

use embassy_stm32::pac;

/// 2.7 V, coded 0 (RM0090, section 3.6.2).
#[cfg(feature = "stm32f405")]
const HIGHEST_LEVEL: u8 = 0;
/// 2.8 V, coded 4 (RM0440, section 6.1.7).
#[cfg(feature = "stm32g474")]
const HIGHEST_LEVEL: u8 = 4;

/// Unlock the flash of the STM32G4 (RM0440, section 3.3.5).
#[cfg(feature = "stm32g474")]
const FLASH_KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// Unlock the option bytes, in this order (RM0090, section 3.6.2; RM0440, section 3.4.2).
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

/// Level 2.9 V of the voltage detector (RM0090, section 5.4.1; RM0440, section 6.4.2).
#[cfg(feature = "stm32f405")]
const DETECTOR_2900_MV: u8 = 7;
#[cfg(feature = "stm32g474")]
const DETECTOR_2900_MV: u8 = 6;

/// Whether the highest level is set.
#[cfg(feature = "stm32f405")]
pub(crate) fn is_set() -> bool {
    pac::FLASH.optcr().read().bor_lev() == HIGHEST_LEVEL
}

/// Whether the highest level is set.
#[cfg(feature = "stm32g474")]
pub(crate) fn is_set() -> bool {
    pac::FLASH.optr().read().bor_lev() == HIGHEST_LEVEL
}

/// Switches the voltage detector on.
pub(crate) fn watch_supply() {
    #[cfg(feature = "stm32f405")]
    let control = pac::PWR.cr1();
    #[cfg(feature = "stm32g474")]
    let control = pac::PWR.cr2();
    control.modify(|detector| {
        detector.set_pls(DETECTOR_2900_MV);
        detector.set_pvde(true);
    });
}

/// Whether the supply is above 2.9 V at this moment.
pub(crate) fn is_supply_high() -> bool {
    #[cfg(feature = "stm32f405")]
    let status = pac::PWR.csr1();
    #[cfg(feature = "stm32g474")]
    let status = pac::PWR.sr2();
    !status.read().pvdo()
}

/// Sets it. It takes effect at the next power-on.
#[cfg(feature = "stm32f405")]
pub(crate) fn set() {
    let options = pac::FLASH.optcr();
    OPTION_KEYS
        .into_iter()
        .for_each(|key| pac::FLASH.optkeyr().write_value(key));
    options.modify(|options| options.set_bor_lev(HIGHEST_LEVEL));
    options.modify(|options| options.set_optstrt(true));
    while pac::FLASH.sr().read().bsy() {}
    options.modify(|options| options.set_optlock(true));
}

/// Sets it. It takes effect at the next power-on.
#[cfg(feature = "stm32g474")]
pub(crate) fn set() {
    FLASH_KEYS
        .into_iter()
        .for_each(|key| pac::FLASH.keyr().write_value(key));
    OPTION_KEYS
        .into_iter()
        .for_each(|key| pac::FLASH.optkeyr().write_value(key));
    pac::FLASH
        .optr()
        .modify(|options| options.set_bor_lev(HIGHEST_LEVEL));
    pac::FLASH.cr().modify(|control| control.set_optstrt(true));
    while pac::FLASH.sr().read().bsy() {}
    pac::FLASH.cr().modify(|control| {
        control.set_optlock(true);
        control.set_lock(true);
    });
}
