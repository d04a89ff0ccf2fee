//! Fault confinement: the error counters of a node.
//!
//! Law (Bosch CAN 2.0 B, section 7; ISO 11898-1, 12.1.4): the transmit error counter (TEC) rises by 8 with each transmit error and falls by 1
//! with each success; the receive error counter (REC) rises and falls by 1. From 128 on a node is error-passive; with TEC above 255 it is
//! bus-off. An error-passive transmitter that only misses the acknowledge does not count: a node alone on the bus ends at 128, not bus-off.
//!
//! Simplified: the additional 8 for a receiver that sees a dominant bit behind its own error flag is not counted, because the bus does not
//! model which receiver detected an error first.

/// From this count on a node is error-passive.
pub const ERROR_PASSIVE_COUNT: u16 = 128;

/// Above this transmit error count a node is bus-off.
pub const BUS_OFF_ABOVE: u16 = 255;

const TRANSMIT_ERROR_STEP: u16 = 8;

/// Error state of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorState {
    /// Takes part fully; signals errors with a dominant flag, which destroys the frame for all.
    Active,
    /// Signals errors with a recessive flag and waits 8 bits more between its own frames.
    Passive,
    /// Neither sends, receives nor acknowledges.
    BusOff,
}

/// The two error counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct ErrorCounters {
    tec: u16,
    rec: u16,
}

impl ErrorCounters {
    pub(crate) fn state(&self) -> ErrorState {
        if self.tec > BUS_OFF_ABOVE {
            ErrorState::BusOff
        } else if self.tec.max(self.rec) >= ERROR_PASSIVE_COUNT {
            ErrorState::Passive
        } else {
            ErrorState::Active
        }
    }

    pub(crate) fn tec(&self) -> u16 {
        self.tec
    }

    pub(crate) fn rec(&self) -> u16 {
        self.rec
    }

    pub(crate) fn transmitted(&mut self) {
        self.tec = self.tec.saturating_sub(1);
    }

    pub(crate) fn transmit_error(&mut self) {
        // A node that is bus-off sends nothing, so this ends at 255 + 8.
        self.tec = self.tec.saturating_add(TRANSMIT_ERROR_STEP);
    }

    pub(crate) fn not_acknowledged(&mut self) {
        if self.state() == ErrorState::Active {
            self.transmit_error();
        }
    }

    /// A passive receiver that receives correctly goes back to a value between 119 and 127; this is 127.
    pub(crate) fn received(&mut self) {
        self.rec = if self.rec >= ERROR_PASSIVE_COUNT {
            ERROR_PASSIVE_COUNT - 1
        } else {
            self.rec.saturating_sub(1)
        };
    }

    /// REC has eight bits in hardware and stays at its end.
    pub(crate) fn receive_error(&mut self) {
        self.rec = (self.rec + 1).min(u16::from(u8::MAX));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(transmit_errors: u16) -> ErrorCounters {
        let mut counters = ErrorCounters::default();
        (0..transmit_errors).for_each(|_| counters.transmit_error());
        counters
    }

    #[test]
    fn sixteen_transmit_errors_make_passive_and_32_bus_off() {
        assert_eq!(
            (after(15).tec(), after(15).state()),
            (120, ErrorState::Active)
        );
        assert_eq!(
            (after(16).tec(), after(16).state()),
            (128, ErrorState::Passive)
        );
        assert_eq!(
            (after(31).tec(), after(31).state()),
            (248, ErrorState::Passive)
        );
        assert_eq!(
            (after(32).tec(), after(32).state()),
            (256, ErrorState::BusOff)
        );
    }

    #[test]
    fn success_counts_down_to_zero() {
        let mut counters = after(16);
        counters.transmitted();
        assert_eq!(
            (counters.tec(), counters.state()),
            (127, ErrorState::Active)
        );
        (0..200).for_each(|_| counters.transmitted());
        assert_eq!(counters.tec(), 0);
    }

    #[test]
    fn missing_acknowledge_stops_at_passive() {
        let mut counters = ErrorCounters::default();
        (0..1000).for_each(|_| counters.not_acknowledged());
        assert_eq!(
            (counters.tec(), counters.state()),
            (128, ErrorState::Passive)
        );
    }

    #[test]
    fn receive_errors_never_lead_to_bus_off() {
        let mut counters = ErrorCounters::default();
        (0..127).for_each(|_| counters.receive_error());
        assert_eq!(counters.state(), ErrorState::Active);
        (0..1000).for_each(|_| counters.receive_error());
        assert_eq!(
            (counters.rec(), counters.state()),
            (255, ErrorState::Passive)
        );
        counters.received();
        assert_eq!(
            (counters.rec(), counters.state()),
            (127, ErrorState::Active)
        );
        counters.received();
        assert_eq!(counters.rec(), 126);
    }
}
