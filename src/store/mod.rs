//! What the board keeps in its flash: the settings, and the log of its faults.
//!
//! | Module | What |
//! |---|---|
//! | `areas` | where the records lie, and the driver of the store over the flash of the chip |
//! | `sectors`, `pages` | erasing and programming, STM32F405 and STM32G474 |
//! | `fault_log` | the latest faults, in memory that survives a reset |

mod areas;
#[cfg_attr(feature = "stm32f405", path = "sectors.rs")]
#[cfg_attr(feature = "stm32g474", path = "pages.rs")]
mod chip;
mod fault_log;

use core::mem::MaybeUninit;

use board_link::message::FaultEntry;
use board_link::{Reason, Refused};
use board_settings::{Board, Configs, LONGEST, Settings};
use record_store::{Store, StoreError};

use self::areas::{ChipError, FAULTS, Place, SETTINGS};
use self::fault_log::{FAULT_BYTES, FaultLog};
use crate::board::LAST_SWITCH_PIN;
use crate::config::CYCLE_US;

#[cfg(feature = "stm32g474")]
pub(crate) use self::chip::has_met_damage;
pub(crate) use self::fault_log::Fault;

/// What the settings must fit.
const BOARD: Board = Board {
    cycle_us: CYCLE_US,
    ..CHIP
};
#[cfg(feature = "stm32f405")]
const CHIP: Board = Board::STM32F405;
#[cfg(feature = "stm32g474")]
const CHIP: Board = Board::STM32G474;

const _: () = assert!(
    CHIP.last_switch_pin == LAST_SWITCH_PIN,
    "the settings and the board disagree about the pins of switches"
);

const VERSION: &str = env!("CARGO_PKG_VERSION");

#[unsafe(link_section = ".uninit.FAULT_LOG")]
static mut FAULT_LOG: MaybeUninit<FaultLog> = MaybeUninit::uninit();

/// The settings in force, new ones on their way, and the faults. All calls are for the thread.
pub(crate) struct Storage {
    settings: Store<Place, LONGEST>,
    faults: Store<Place, FAULT_BYTES>,
    in_force: [u8; LONGEST],
    in_force_length: usize,
    staging: [u8; LONGEST],
    log: &'static mut FaultLog,
    boot: u32,
}

/// What the settings in the flash say; `None` without any, or with such as make no board that works.
pub(crate) fn read_settings() -> Option<Configs> {
    let mut room = [0; LONGEST];
    let mut store = Store::<_, LONGEST>::new(SETTINGS);
    let bytes = store.read(0, &mut room).ok().flatten()?;
    let configs = Settings::read(bytes).and_then(|settings| settings.configs(&BOARD));
    match configs {
        Ok(configs) => Some(configs),
        Err(refusal) => {
            defmt::error!(
                "the settings are refused, {=u16}: axis {}, expected {=i64}, got {=i64}",
                refusal.kind.number(),
                refusal.axis,
                refusal.expected,
                refusal.actual
            );
            None
        }
    }
}

impl Storage {
    /// After a start. `before` is what ended the one before it, where that was a failure. To be called once.
    pub(crate) fn new(is_power_on: bool, before: Option<Fault<'_>>) -> Self {
        // SAFETY: called once, so there is one reference; any bytes are a log.
        let log = unsafe { &mut *(&raw mut FAULT_LOG).cast::<FaultLog>() };
        let mut storage = Self {
            settings: Store::new(SETTINGS),
            faults: Store::new(FAULTS),
            in_force: [0; LONGEST],
            in_force_length: 0,
            staging: [0; LONGEST],
            log,
            boot: 0,
        };
        let stored = storage.settings.read(0, &mut storage.in_force);
        storage.in_force_length = stored.ok().flatten().map_or(0, <[u8]>::len);
        if is_power_on || !storage.log.is_kept() {
            storage.load_faults();
        }
        if let Some(fault) = before {
            storage.log.note(fault, VERSION);
        }
        storage.boot = storage.log.begin_start();
        storage
    }

    fn load_faults(&mut self) {
        self.log.clear();
        let log = &mut *self.log;
        let read = self.faults.for_each(|_, bytes| {
            if let Ok(bytes) = <[u8; FAULT_BYTES]>::try_from(bytes) {
                log.load(bytes);
            }
        });
        if read.is_err() {
            defmt::error!("the faults in the flash cannot be read");
        }
    }

    /// The number of this start.
    pub(crate) const fn boot(&self) -> u32 {
        self.boot
    }

    /// The settings in force, as they were stored at the start.
    pub(crate) fn settings(&self) -> &[u8] {
        self.in_force
            .get(..self.in_force_length)
            .unwrap_or_default()
    }

    /// Room for new ones.
    pub(crate) const fn staging(&mut self) -> &mut [u8] {
        &mut self.staging
    }

    /// Whether the first bytes of the room make a board that works.
    pub(crate) fn check(&self, length: u32) -> Result<(), Refused> {
        let bytes = self.staged(length)?;
        let configs = Settings::read(bytes).and_then(|settings| settings.configs(&BOARD));
        configs.map(|_| ()).map_err(Refused::from)
    }

    /// Stores them for the next start. To be called when the cycle has confirmed that nothing is enabled, and sees to it that nothing
    /// will be: the chip may stand still for half a second.
    pub(crate) fn save(&mut self, length: u32) -> Result<(), Refused> {
        self.check(length)?;
        let bytes = self.staging.get(..length as usize).unwrap_or_default();
        self.settings.append(bytes).map_err(refused)
    }

    fn staged(&self, length: u32) -> Result<&[u8], Refused> {
        let bytes = self.staging.get(..length as usize);
        bytes.ok_or(Reason::Length.because(LONGEST as i64, length.into()))
    }

    /// Notes a fault.
    pub(crate) fn note_fault(&mut self, fault: Fault<'_>) {
        self.log.note(fault, VERSION);
    }

    /// The time that faults are noted with.
    pub(crate) const fn set_uptime_ms(&mut self, uptime_ms: u32) {
        self.log.set_uptime_ms(uptime_ms);
    }

    /// Whether faults are to be stored.
    pub(crate) fn owes_faults(&self) -> bool {
        self.log.unstored().is_some()
    }

    /// Stores the oldest fault that is not in flash yet, under the condition of [`Self::save`].
    pub(crate) fn store_fault(&mut self) -> Result<(), Refused> {
        let Some((number, bytes)) = self.log.unstored() else {
            return Ok(());
        };
        self.faults.append(&bytes).map_err(refused)?;
        self.log.note_stored(number);
        Ok(())
    }

    /// Faults that are kept.
    pub(crate) fn faults(&self) -> u32 {
        self.log.count()
    }

    /// A fault, 0 the latest.
    pub(crate) fn fault(&self, index: u32) -> Option<FaultEntry> {
        self.log.get(index)
    }
}

/// The status register of the flash says what it is.
fn refused(error: StoreError<ChipError>) -> Refused {
    let status = match error {
        StoreError::Flash(ChipError(status)) => status.into(),
        _ => 0,
    };
    Reason::Store.because(0, status)
}
