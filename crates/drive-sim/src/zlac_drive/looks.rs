//! What a test may look at.
//!
//! Specification: looking changes nothing. Methods that take `at_ns` tell the state at that instant if nothing happens until then.

use zlac8030l::ObjectAddress;

use super::config::ZlacDriveConfig;
use super::memory::EepromWear;
use super::network::NodeState;
use super::{ZlacBooks, ZlacDrive};

impl ZlacDrive {
    /// Its configuration.
    pub fn config(&self) -> &ZlacDriveConfig {
        &self.config
    }

    /// What it heard and said since it was made.
    pub fn books(&self) -> &ZlacBooks {
        &self.books
    }

    /// How often its EEPROM was written.
    pub fn eeprom_wear(&self) -> EepromWear {
        self.memory.wear()
    }

    /// The value of an object as its bits; 0 for an object that it does not have.
    pub fn object(&self, at_ns: u64, address: ObjectAddress) -> u32 {
        self.read(at_ns, (address.index, address.sub))
    }

    /// The status word.
    pub fn status_word(&self, at_ns: u64) -> u16 {
        let with_cia402 = !self.config.quirks.status_word_without_cia402_bits;
        let stopped = self.emergency_input && self.memory.has_emergency_input();
        self.stage.status_bits(with_cia402)
            | self.motion.at(at_ns).status_bits()
            | u16::from(stopped) << 15
    }

    /// Whether the motor is energised and follows its targets.
    pub fn is_enabled(&self) -> bool {
        self.stage.is_enabled()
    }

    /// Whether PDOs run.
    pub fn is_operational(&self) -> bool {
        self.network.state() == NodeState::Operational
    }

    /// The node number in force.
    pub fn node_id(&self) -> u8 {
        self.node.get()
    }

    /// Latched bits of 603Fh.
    pub fn fault_bits(&self) -> u16 {
        self.stage.fault()
    }

    /// Speed of the wheel in r/min, positive clockwise seen from the shaft.
    pub fn speed_rpm(&self, at_ns: u64) -> f64 {
        self.motion.at(at_ns).shaft_rpm()
    }

    /// Position that it reports, in counts.
    pub fn position_counts(&self, at_ns: u64) -> i64 {
        self.motion.at(at_ns).counts()
    }

    /// Distance of the wheel from where it stood at 0 ns, in counts, positive clockwise seen from the shaft; no clearing and no power cycle changes it.
    pub fn travel_counts(&self, at_ns: u64) -> i64 {
        self.motion.at(at_ns).travel_counts()
    }

    /// Whether the switch beside its shaft is operated.
    pub fn switch_is_operated(&self, at_ns: u64) -> bool {
        self.motion.at(at_ns).switch_is_operated()
    }

    /// Counts of one turn: four a line of the encoder.
    pub fn counts_per_turn(&self) -> f64 {
        self.motion.counts_per_turn()
    }
}
