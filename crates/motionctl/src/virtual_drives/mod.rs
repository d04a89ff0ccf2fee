//! The options that say how simulated drives behave.

use can_motion::plan::{self, BusSetup, ResponseWindow};
use drive_sim::{BitRate, DynDrive, DynDriveConfig, ResponseDelay, TxOrder};
use dyn_can::{DriveId, GearNumber};

use crate::revision::RevisionOption;

/// How simulated drives behave.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct VirtualDriveOptions {
    /// Mean response delay of the drives in microseconds.
    #[arg(long, value_name = "US", default_value_t = 500)]
    response_us: u32,
    /// Spread of the response delay around its mean in percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 25, value_parser = percent)]
    response_spread: u8,
    /// Revision of the simulated drives.
    #[arg(long, value_enum, default_value_t)]
    revision: RevisionOption,
    /// Seed of the response delays.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

impl VirtualDriveOptions {
    /// Seed of the response delays.
    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// A simulated drive.
    pub(crate) fn drive(&self, drive: DriveId) -> DynDrive {
        DynDrive::new(self.config(drive))
    }

    /// The configuration of a simulated drive.
    pub(crate) fn config(&self, drive: DriveId) -> DynDriveConfig {
        self.config_of(DynDriveConfig::new(drive))
    }

    /// The same of one that was never given an id. Its number among those makes its response delays its own.
    pub(crate) fn fresh_config(&self, number: u8) -> DynDriveConfig {
        self.nth(number).config_of(DynDriveConfig::fresh())
    }

    /// The same of one more with an id that another has.
    pub(crate) fn twin_config(&self, drive: DriveId) -> DynDriveConfig {
        self.nth(1).config(drive)
    }

    /// The same with response delays of its own, for one of several.
    pub(crate) fn nth(self, number: u8) -> Self {
        // No two of the 64 ids and 256 numbers make the same seed.
        let seed = self.seed.wrapping_add(64 * u64::from(number));
        Self { seed, ..self }
    }

    /// The gear number of a simulated drive.
    pub(crate) fn gear(&self, drive: DriveId) -> GearNumber {
        DynDriveConfig::new(drive).group3.gear_number
    }

    fn config_of(&self, config: DynDriveConfig) -> DynDriveConfig {
        DynDriveConfig {
            response_delay: self.response_delay(),
            seed: self.seed.wrapping_add(u64::from(config.id.get())),
            ..config.with_revision(self.revision.into())
        }
    }

    /// The bus that the master should plan for.
    pub(crate) fn bus_setup(&self, bit_rate: BitRate, tx_order: TxOrder) -> BusSetup {
        let us = |ns: u64| u32::try_from(ns.div_ceil(1_000)).unwrap_or(u32::MAX);
        let delay = self.response_delay();
        BusSetup {
            bit_rate,
            order: match tx_order {
                TxOrder::Fifo => plan::TxOrder::Fifo,
                TxOrder::ByIdentifier => plan::TxOrder::Identifier,
            },
            response: ResponseWindow {
                min_us: us(delay.min_ns()),
                max_us: us(delay.max_ns()),
            },
            ..BusSetup::DEFAULT
        }
    }

    /// From a request to the moment its reply waits for the bus.
    pub(crate) fn response_delay(&self) -> ResponseDelay {
        let delay_ns = u64::from(self.response_us) * 1_000;
        let spread_ns = delay_ns * u64::from(self.response_spread) / 100;
        // The spread is at most the whole delay, so the least delay is not above the most.
        ResponseDelay::between(delay_ns - spread_ns, delay_ns + spread_ns)
            .unwrap_or(ResponseDelay::fixed(delay_ns))
    }
}

/// A bit rate of the command line, in kbit/s.
pub(crate) fn bit_rate(text: &str) -> Result<BitRate, String> {
    let kbit_per_s: u32 = text.parse().map_err(|_| "expected a number".to_owned())?;
    BitRate::from_kbit_per_s(kbit_per_s).map_err(|error| error.to_string())
}

/// A share in percent.
pub(crate) fn percent(text: &str) -> Result<u8, String> {
    match text.parse() {
        Ok(percent @ 0..=100) => Ok(percent),
        _ => Err(format!("must be 0..=100 percent, got {text}")),
    }
}
