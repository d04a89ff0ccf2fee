//! Status word 6041h (guide section 7), the states of CiA 402 in it, and where a control word leads.

use core::fmt;

use crate::control_word::ControlWord;

/// State of the power stage: bits 0 to 3 of the status word. Bits 4 to 6 are not described and not believed (Z37).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// 0000: power stage off.
    NotEnabled,
    /// 0001: after control word 6.
    ReadyToSwitchOn,
    /// 0011: after control word 7.
    SwitchedOn,
    /// 0111: after control word F; the motor is energised.
    OperationEnabled,
    /// Any other pattern, which the guide does not describe. With bit 3 CiA 402 says fault.
    Undocumented,
}

impl State {
    /// The control word that leads one step towards operation enabled; `None` when it is reached.
    ///
    /// Not from an undocumented state: find out what happened and reset the fault first.
    #[must_use]
    pub const fn toward_enabled(self) -> Option<ControlWord> {
        match self {
            Self::NotEnabled => Some(ControlWord::SHUTDOWN),
            Self::ReadyToSwitchOn => Some(ControlWord::SWITCH_ON),
            Self::SwitchedOn => Some(ControlWord::ENABLE_OPERATION),
            Self::OperationEnabled | Self::Undocumented => None,
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotEnabled => "not enabled",
            Self::ReadyToSwitchOn => "ready to switch on",
            Self::SwitchedOn => "switched on",
            Self::OperationEnabled => "operation enabled",
            Self::Undocumented => "undocumented state",
        })
    }
}

/// The status word as the drive sent it; bits without a meaning are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StatusWord(u16);

impl StatusWord {
    /// A status word as received.
    #[must_use]
    pub const fn new(word: u16) -> Self {
        Self(word)
    }

    /// The word on the wire.
    #[must_use]
    pub const fn get(self) -> u16 {
        self.0
    }

    const fn bit(self, bit: u8) -> bool {
        self.0 & 1 << bit != 0
    }

    /// The state in bits 0 to 3.
    #[must_use]
    pub const fn state(self) -> State {
        match self.0 & 0xF {
            0b0000 => State::NotEnabled,
            0b0001 => State::ReadyToSwitchOn,
            0b0011 => State::SwitchedOn,
            0b0111 => State::OperationEnabled,
            _ => State::Undocumented,
        }
    }

    /// Bit 3, fault in CiA 402 and not described by the guide: 603Fh tells faults.
    #[must_use]
    pub const fn fault_bit(self) -> bool {
        self.bit(3)
    }

    /// Bit 5 is 0: stopped by the quick stop command.
    #[must_use]
    pub const fn emergency_stop(self) -> bool {
        !self.bit(5)
    }

    /// Bit 10: speed, position or torque reached, by mode.
    #[must_use]
    pub const fn target_reached(self) -> bool {
        self.bit(10)
    }

    /// Bit 12 in velocity mode: the speed is 0.
    #[must_use]
    pub const fn zero_speed(self) -> bool {
        self.bit(12)
    }

    /// Bit 12 in position mode: the target is valid; set-point acknowledge in CiA 402 (Z35).
    #[must_use]
    pub const fn target_valid(self) -> bool {
        self.bit(12)
    }

    /// Bit 13 in position mode: beyond the deviation threshold; following error in CiA 402 (Z36).
    #[must_use]
    pub const fn deviation(self) -> bool {
        self.bit(13)
    }

    /// Bit 14: the motor runs.
    #[must_use]
    pub const fn running(self) -> bool {
        self.bit(14)
    }

    /// Bit 15: stopped by an emergency stop input.
    #[must_use]
    pub const fn external_emergency_stop(self) -> bool {
        self.bit(15)
    }
}

impl fmt::Display for StatusWord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h, {}", self.0, self.state())?;
        let flags = [
            (self.emergency_stop(), "quick stop"),
            (self.running(), "running"),
            (self.target_reached(), "target reached"),
            (self.external_emergency_stop(), "emergency stop input"),
        ];
        flags
            .iter()
            .filter(|(set, _)| *set)
            .try_for_each(|(_, name)| write!(f, ", {name}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_word_has_a_state_and_keeps_its_bits() {
        let mut states = [0_u32; 5];
        for word in 0..=u16::MAX {
            let status = StatusWord::new(word);
            states[status.state() as usize] += 1;
            let expected = match word % 16 {
                0 => State::NotEnabled,
                1 => State::ReadyToSwitchOn,
                3 => State::SwitchedOn,
                7 => State::OperationEnabled,
                _ => State::Undocumented,
            };
            assert_eq!(status.state(), expected, "{word:04X}");
            let bits = u16::from(status.fault_bit()) << 3
                | u16::from(!status.emergency_stop()) << 5
                | u16::from(status.target_reached()) << 10
                | u16::from(status.zero_speed()) << 12
                | u16::from(status.deviation()) << 13
                | u16::from(status.running()) << 14
                | u16::from(status.external_emergency_stop()) << 15;
            assert_eq!(bits, word & 0xF428, "{word:04X}");
            assert_eq!(status.get(), word);
        }
        assert_eq!(states, [4096, 4096, 4096, 4096, 49_152]);
    }

    #[test]
    fn three_control_words_enable() {
        let mut state = State::NotEnabled;
        let mut words = [0; 3];
        for (word, next) in words.iter_mut().zip([
            State::ReadyToSwitchOn,
            State::SwitchedOn,
            State::OperationEnabled,
        ]) {
            *word = state.toward_enabled().unwrap().get();
            state = next;
        }
        assert_eq!(words, [0x06, 0x07, 0x0F]);
        assert_eq!(state.toward_enabled(), None);
        assert_eq!(State::Undocumented.toward_enabled(), None);
    }

    #[test]
    fn a_status_word_prints_its_state_and_what_is_set() {
        let text = |word| std::format!("{}", StatusWord::new(word));
        assert_eq!(text(0x0020), "0020h, not enabled");
        assert_eq!(text(0x0021), "0021h, ready to switch on");
        assert_eq!(text(0x0023), "0023h, switched on");
        assert_eq!(
            text(0x4427),
            "4427h, operation enabled, running, target reached"
        );
        assert_eq!(
            text(0x8008),
            "8008h, undocumented state, quick stop, emergency stop input"
        );
    }

    #[test]
    fn bit_12_is_the_speed_in_one_mode_and_the_target_in_the_other() {
        let read = |word| {
            let word = StatusWord::new(word);
            (word.zero_speed(), word.target_valid())
        };
        assert_eq!(read(0x1000), (true, true));
        assert_eq!(read(0xEFFF), (false, false));
    }
}
