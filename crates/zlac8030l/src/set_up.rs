//! Set-up that does not wear the drive, sans-I/O: identify, compare, write what differs, read it back, save only on request.
//!
//! Order: device type, vendor, product, software version and the width of 60FFh, because other drives and generations of the maker give
//! 2009h another meaning; then 2010h = 1, so that no RW/S write reaches the EEPROM; then the steps. A write whose confirmation is lost
//! is not repeated blindly: reading back tells whether it arrived.
//!
//! PDOs are mapped in pre-operational: count 0, entries, transmission, count (guide section 6). The identifiers of PDOs are read-only
//! on this drive, so that bit 31 cannot be set first (Z20).

mod error;
mod identity;
mod options;
mod step;

pub use error::SetUpError;
pub use options::{Firmware, SetUpOptions};
pub use step::{PdoSetUp, SetUpStep, Setting};

use crate::dictionary::{self, Access};
use crate::object::{ObjectAddress, ObjectData};
use crate::objects;
use crate::sdo::SdoRequest;
use crate::sdo_client::SdoEnd;
use identity::identity;

/// How often a read is asked before the drive counts as silent.
const ATTEMPTS: u8 = 3;

/// The longest list of steps; one more is its own.
const MOST_STEPS: usize = 254;

/// What a set-up did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetUpReport {
    /// Values that were read and found right.
    pub unchanged: u16,
    /// Write requests, the opening of mappings included.
    pub written: u16,
    /// The EEPROM was written, once.
    pub saved: bool,
}

/// What is done with the settings of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Pass {
    Compare,
    Open,
    Write,
    Verify,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    /// Number of the identity that is read.
    Identify(u8),
    /// Step 0 is the protection of the EEPROM, the others follow.
    Step {
        step: u8,
        place: u8,
        pass: Pass,
    },
    Save,
    Ended(Result<(), SetUpError>),
}

/// A set-up that runs over an SDO client: ask for [`Self::wanted`], tell how it ended with [`Self::on_end`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SetUp {
    options: SetUpOptions,
    stage: Stage,
    attempts: u8,
    stored_written: bool,
    report: SetUpReport,
}

impl SetUp {
    /// A set-up at its start.
    #[must_use]
    pub const fn new(options: SetUpOptions) -> Self {
        Self {
            options,
            stage: Stage::Identify(0),
            attempts: 0,
            stored_written: false,
            report: SetUpReport {
                unchanged: 0,
                written: 0,
                saved: false,
            },
        }
    }

    /// How it ended; `None` while it runs.
    #[must_use]
    pub const fn outcome(&self) -> Option<Result<SetUpReport, SetUpError>> {
        match self.stage {
            Stage::Ended(Ok(())) => Some(Ok(self.report)),
            Stage::Ended(Err(error)) => Some(Err(error)),
            _ => None,
        }
    }

    /// The transfer that it waits for; `None` when it has ended. `steps` must be the same at every call; more than 254 are refused when the
    /// first transfer has ended, before anything is written.
    #[must_use]
    pub fn wanted(&self, steps: &[SetUpStep]) -> Option<SdoRequest> {
        match self.stage {
            Stage::Identify(number) => {
                identity(number, self.options).map(|identity| SdoRequest::Read(identity.address))
            }
            Stage::Step { step, place, pass } => {
                let step = step_at(steps, step)?;
                let setting = step.setting(place)?;
                Some(match pass {
                    Pass::Compare | Pass::Verify => SdoRequest::Read(setting.address),
                    Pass::Open => step.gate()?.write(0),
                    Pass::Write => SdoRequest::Write(setting.address, setting.data),
                })
            }
            Stage::Save => Some(objects::STORE.write(objects::STORE_SAVE_ALL)),
            Stage::Ended(_) => None,
        }
    }

    /// The wanted transfer has ended.
    pub fn on_end(&mut self, steps: &[SetUpStep], end: SdoEnd) {
        let Some(request) = self.wanted(steps) else {
            return;
        };
        let address = request.address();
        let result = match (request, end) {
            _ if steps.len() > MOST_STEPS => Err(SetUpError::TooManySteps {
                most: MOST_STEPS,
                actual: steps.len(),
            }),
            (_, SdoEnd::Aborted(code)) => Err(SetUpError::Refused { address, code }),
            (SdoRequest::Read(_), SdoEnd::Value(data)) => self.on_value(steps, data),
            (SdoRequest::Write(..), SdoEnd::Written) => self.on_write(steps, address, true),
            (SdoRequest::Write(..), SdoEnd::TimedOut) => self.on_write(steps, address, false),
            (SdoRequest::Read(_), SdoEnd::TimedOut) if self.attempts + 1 < ATTEMPTS => {
                self.attempts += 1;
                return;
            }
            _ => Err(SetUpError::Silent { address }),
        };
        self.attempts = 0;
        if let Err(error) = result {
            self.stage = Stage::Ended(Err(error));
        }
    }

    fn on_value(&mut self, steps: &[SetUpStep], data: ObjectData) -> Result<(), SetUpError> {
        match self.stage {
            Stage::Identify(number) => self.compare_identity(number, data),
            Stage::Step { step, place, pass } => {
                self.compare_setting(steps, step, place, pass, data)
            }
            Stage::Save | Stage::Ended(_) => Ok(()),
        }
    }

    fn compare_identity(&mut self, number: u8, data: ObjectData) -> Result<(), SetUpError> {
        if let Some(identity) = identity(number, self.options) {
            identity.check(data)?;
        }
        self.stage = match identity(number + 1, self.options) {
            Some(_) => Stage::Identify(number + 1),
            None => start_of(0),
        };
        Ok(())
    }

    fn compare_setting(
        &mut self,
        steps: &[SetUpStep],
        step: u8,
        place: u8,
        pass: Pass,
        data: ObjectData,
    ) -> Result<(), SetUpError> {
        let Some((current, setting)) =
            step_at(steps, step).and_then(|current| Some((current, current.setting(place)?)))
        else {
            return Ok(());
        };
        let address = setting.address;
        let actual = match data.raw_of_width(setting.data.len()) {
            Ok(actual) => actual,
            Err(error) => return Err(SetUpError::Width { address, error }),
        };
        let equal = actual == setting.data.raw();
        if !equal && matches!(current, SetUpStep::Expect(_)) {
            return Err(SetUpError::Differs {
                address,
                expected: setting.data.raw(),
                actual,
            });
        }
        if !equal && pass == Pass::Verify {
            return Err(SetUpError::NotTaken {
                address,
                expected: setting.data.raw(),
                actual,
            });
        }
        if equal {
            if pass == Pass::Compare {
                self.report.unchanged += 1;
            }
            self.next_place(steps, step, place, pass);
        } else {
            let (place, pass) = match current.gate() {
                Some(_) => (0, Pass::Open),
                None => (place, Pass::Write),
            };
            self.stage = Stage::Step { step, place, pass };
        }
        Ok(())
    }

    fn on_write(
        &mut self,
        steps: &[SetUpStep],
        address: ObjectAddress,
        confirmed: bool,
    ) -> Result<(), SetUpError> {
        self.report.written += 1;
        self.stored_written |=
            dictionary::find(address).is_some_and(|entry| entry.access == Access::RwS);
        match self.stage {
            // An open mapping must be known to be open; the other writes are read back anyway.
            Stage::Step {
                pass: Pass::Open, ..
            }
            | Stage::Save
                if !confirmed =>
            {
                return Err(SetUpError::Silent { address });
            }
            Stage::Step {
                step,
                pass: Pass::Open,
                ..
            } => {
                self.stage = Stage::Step {
                    step,
                    place: 0,
                    pass: Pass::Write,
                };
            }
            Stage::Step { step, place, pass } => self.next_place(steps, step, place, pass),
            Stage::Save => {
                self.report.saved = true;
                self.stage = Stage::Ended(Ok(()));
            }
            Stage::Identify(_) | Stage::Ended(_) => {}
        }
        Ok(())
    }

    fn next_place(&mut self, steps: &[SetUpStep], step: u8, place: u8, pass: Pass) {
        let has_next =
            step_at(steps, step).is_some_and(|current| current.setting(place + 1).is_some());
        self.stage = match pass {
            _ if has_next => Stage::Step {
                step,
                place: place + 1,
                pass,
            },
            Pass::Open | Pass::Write => Stage::Step {
                step,
                place: 0,
                pass: Pass::Verify,
            },
            Pass::Compare | Pass::Verify if step_at(steps, step + 1).is_some() => {
                start_of(step + 1)
            }
            Pass::Compare | Pass::Verify if self.options.save && self.stored_written => Stage::Save,
            Pass::Compare | Pass::Verify => Stage::Ended(Ok(())),
        };
    }
}

const fn start_of(step: u8) -> Stage {
    Stage::Step {
        step,
        place: 0,
        pass: Pass::Compare,
    }
}

/// Step 0 keeps writes away from the EEPROM; the steps of the caller follow.
fn step_at(steps: &[SetUpStep], step: u8) -> Option<SetUpStep> {
    match step.checked_sub(1) {
        None => Some(SetUpStep::Value(Setting::new(
            objects::EEPROM_UPDATE,
            objects::EEPROM_UPDATE_OFF,
        ))),
        Some(place) => steps.get(usize::from(place)).copied(),
    }
}

#[cfg(test)]
mod tests;
