//! States of CiA 402 as the guide reduces them, driven by control words.
//!
//! Law: the words 6, 7, F enable, in this order and no shortcut; 0 switches off from everywhere; 2 stops and stays energised.

/// State of the power stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Stage {
    #[default]
    Off,
    Ready,
    SwitchedOn,
    Enabled,
    QuickStop,
    Fault,
}

/// The state machine with its latched fault.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PowerStage {
    stage: Stage,
    control_word: u16,
    /// Latched bits of 603Fh.
    fault: u16,
    /// The cause of the fault is still there.
    cause: bool,
}

impl PowerStage {
    pub(super) fn stage(&self) -> Stage {
        self.stage
    }

    pub(super) fn is_enabled(&self) -> bool {
        self.stage == Stage::Enabled
    }

    pub(super) fn control_word(&self) -> u16 {
        self.control_word
    }

    pub(super) fn fault(&self) -> u16 {
        self.fault
    }

    /// Halt of CiA 402: bit 8.
    pub(super) fn halted(&self) -> bool {
        self.control_word & 0x0100 != 0
    }

    pub(super) fn trip(&mut self, bits: u16) {
        self.fault |= bits;
        self.cause = true;
        self.stage = Stage::Fault;
    }

    pub(super) fn cause_gone(&mut self) {
        self.cause = false;
    }

    /// A control word was written.
    pub(super) fn command(&mut self, word: u16) {
        let rising = word & !self.control_word;
        self.control_word = word;
        if self.stage == Stage::Fault {
            if rising & 0x0080 != 0 && !self.cause {
                self.stage = Stage::Off;
                self.fault = 0;
            }
            return;
        }
        self.stage = match (word & 0x000F, self.stage) {
            // Bit 1 is 0: disable voltage.
            (low, _) if low & 0b0010 == 0 => Stage::Off,
            // Bit 2 is 0: quick stop.
            (low, Stage::Enabled | Stage::QuickStop) if low & 0b0100 == 0 => Stage::QuickStop,
            (low, _) if low & 0b0100 == 0 => Stage::Off,
            (0b0110 | 0b1110, Stage::QuickStop) => Stage::QuickStop,
            (0b0110 | 0b1110, _) => Stage::Ready,
            (0b0111, Stage::Ready | Stage::SwitchedOn | Stage::Enabled) => Stage::SwitchedOn,
            (0b1111, Stage::SwitchedOn | Stage::Enabled | Stage::QuickStop) => Stage::Enabled,
            (_, stage) => stage,
        };
    }

    /// Bits 0 to 6 of the status word.
    pub(super) fn status_bits(&self, with_cia402_bits: bool) -> u16 {
        let (state, cia402) = match self.stage {
            Stage::Off => (0b0000, 0x40),
            Stage::Ready => (0b0001, 0),
            Stage::SwitchedOn => (0b0011, 0),
            Stage::Enabled | Stage::QuickStop => (0b0111, 0),
            Stage::Fault => (0b0000, 0x08),
        };
        let not_stopped = if self.stage == Stage::QuickStop {
            0
        } else {
            1 << 5
        };
        state | not_stopped | if with_cia402_bits { cia402 } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(words: &[u16]) -> Stage {
        let mut stage = PowerStage::default();
        words.iter().for_each(|word| stage.command(*word));
        stage.stage()
    }

    #[test]
    fn only_the_printed_order_enables() {
        assert_eq!(after(&[0x06, 0x07, 0x0F]), Stage::Enabled);
        assert_eq!(after(&[0x07, 0x0F]), Stage::Off);
        assert_eq!(after(&[0x0F]), Stage::Off);
        assert_eq!(after(&[0x06, 0x0F]), Stage::Ready);
        assert_eq!(after(&[0x06, 0x07, 0x0F, 0x00]), Stage::Off);
        assert_eq!(after(&[0x06, 0x07, 0x0F, 0x02]), Stage::QuickStop);
        assert_eq!(after(&[0x06, 0x07, 0x0F, 0x02, 0x0F]), Stage::Enabled);
    }

    #[test]
    fn a_fault_goes_by_an_edge_when_its_cause_is_gone() {
        let mut stage = PowerStage::default();
        stage.trip(0x0004);
        stage.command(0x0080);
        assert_eq!(stage.stage(), Stage::Fault);
        stage.cause_gone();
        stage.command(0x0080);
        assert_eq!(stage.stage(), Stage::Fault, "no edge");
        stage.command(0x0000);
        stage.command(0x0080);
        assert_eq!((stage.stage(), stage.fault()), (Stage::Off, 0));
    }
}
