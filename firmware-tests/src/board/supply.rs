//! What outlives the supply: cuts of it, and the content of the flash.

use unicorn_engine::uc_error;

use super::memory::paint;
use super::{Board, Stop};
use crate::flash::FlashContent;
use crate::soc::ResetCause;

impl Board {
    /// Runs until `ns` after the first power-on, cuts the supply there and brings it back `off_ns` later. `seed` decides what an
    /// operation of the flash that was under way leaves; [`Flash::history`](crate::flash::Flash::history) of an earlier run tells when
    /// there is one.
    ///
    /// What was connected stays: the bus goes on without the board. Memory holds anything afterwards, the flash what was in it.
    ///
    /// # Errors
    /// When Unicorn refuses to write memory.
    pub fn cut_power_at_ns(&mut self, ns: u64, off_ns: u64, seed: u64) -> Result<Stop, uc_error> {
        let flash = &mut self.soc_mut().flash;
        flash.lose_supply_at_ns(ns);
        flash.seed = seed;
        let stop = self.run_until_ns(ns);
        self.drain_log();
        paint(&mut self.engine)?;
        self.reset(ResetCause::PowerOn);
        let soc = self.engine.get_data_mut();
        soc.now = soc.clock.cycles(soc.now_ns() + off_ns);
        soc.process();
        Ok(stop)
    }

    /// Puts another content into the flash, as a programmer does, and starts the processor from its reset.
    ///
    /// # Panics
    /// When the content is that of a flash of another size.
    pub fn set_flash_content(&mut self, content: FlashContent) {
        self.soc_mut().flash.set_content(content);
        self.reset(ResetCause::Pin);
    }
}
