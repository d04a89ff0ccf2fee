//! States of CiA 402 as the guide reduces them, driven by control words.
//!
//! Specification: the words 6, 7, F enable, in this order and no shortcut; 0 switches off from everywhere; 2 stops and stays energised. On the
//! way from enabled to 7, 6 or 0 the drive may brake first: it stays enabled until the wheel stands, and says so.

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
    /// Where an enabled drive goes once its wheel stands.
    leaving: Option<Stage>,
}

/// Which ways out of enabled begin with braking (605Bh, 605Ch, Z43, Z44).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BrakesFirst {
    /// Shut-down, to ready.
    pub(super) on_shutdown: bool,
    /// Disable operation, to switched on.
    pub(super) on_disable: bool,
    /// Disable voltage, to off.
    pub(super) on_disable_voltage: bool,
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
        self.leaving = None;
        self.fault |= bits;
        self.cause = true;
        self.stage = Stage::Fault;
    }

    pub(super) fn cause_gone(&mut self) {
        self.cause = false;
    }

    /// The drive is enabled and brakes on its way out.
    pub(super) fn is_leaving(&self) -> bool {
        self.leaving.is_some()
    }

    /// The wheel stands: a drive on its way out has arrived there.
    pub(super) fn stands(&mut self) {
        if let Some(stage) = self.leaving.take() {
            self.stage = stage;
        }
    }

    /// A control word was written.
    pub(super) fn command(&mut self, word: u16, brakes_first: BrakesFirst) {
        let rising = word & !self.control_word;
        self.control_word = word;
        if self.stage == Stage::Fault {
            if rising & 0x0080 != 0 && !self.cause {
                self.stage = Stage::Off;
                self.fault = 0;
            }
            return;
        }
        let before = self.stage;
        self.leaving = None;
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
        let brakes = match self.stage {
            Stage::Ready => brakes_first.on_shutdown,
            Stage::SwitchedOn => brakes_first.on_disable,
            Stage::Off => brakes_first.on_disable_voltage,
            Stage::Enabled | Stage::QuickStop | Stage::Fault => false,
        };
        if before == Stage::Enabled && brakes {
            self.leaving = Some(self.stage);
            self.stage = Stage::Enabled;
        }
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
        words
            .iter()
            .for_each(|word| stage.command(*word, BrakesFirst::default()));
        stage.stage()
    }

    #[test]
    fn a_drive_that_brakes_first_is_enabled_until_its_wheel_stands() {
        let brakes_first = BrakesFirst {
            on_shutdown: true,
            on_disable: true,
            on_disable_voltage: true,
        };
        for (word, end) in [
            (0x07, Stage::SwitchedOn),
            (0x06, Stage::Ready),
            (0x00, Stage::Off),
        ] {
            let mut stage = PowerStage::default();
            for word in [0x06, 0x07, 0x0F, word] {
                stage.command(word, brakes_first);
            }
            assert!(stage.is_enabled() && stage.is_leaving());
            let mut taken_back = stage;
            taken_back.command(0x0F, brakes_first);
            taken_back.stands();
            assert_eq!(taken_back.stage(), Stage::Enabled);
            stage.stands();
            assert_eq!((stage.stage(), stage.is_leaving()), (end, false));
        }
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
        let command = |stage: &mut PowerStage, word| stage.command(word, BrakesFirst::default());
        command(&mut stage, 0x0080);
        assert_eq!(stage.stage(), Stage::Fault);
        stage.cause_gone();
        command(&mut stage, 0x0080);
        assert_eq!(stage.stage(), Stage::Fault, "no edge");
        command(&mut stage, 0x0000);
        command(&mut stage, 0x0080);
        assert_eq!((stage.stage(), stage.fault()), (Stage::Off, 0));
    }
}
