//! Consumer of a heartbeat: whether a drive lives and in which state it is. Time is an argument, in microseconds.

use crate::nmt::NmtState;

/// What a heartbeat changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HeartbeatEvent {
    /// The drive started: everything that was written to its RAM is gone.
    BootUp,
    /// The drive is in another state than before.
    State(NmtState),
}

/// Watches the heartbeat of one drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HeartbeatWatch {
    timeout_us: u32,
    state: Option<NmtState>,
    heard_us: Option<u64>,
}

impl HeartbeatWatch {
    /// A watch that calls the drive lost after `timeout_us` without heartbeat; three times the producer time 1017h is usual.
    #[must_use]
    pub const fn new(timeout_us: u32) -> Self {
        Self {
            timeout_us,
            state: None,
            heard_us: None,
        }
    }

    /// A heartbeat came.
    pub fn on_heartbeat(&mut self, now_us: u64, state: NmtState) -> Option<HeartbeatEvent> {
        self.heard_us = Some(now_us);
        let before = self.state.replace(state);
        match state {
            NmtState::BootUp => Some(HeartbeatEvent::BootUp),
            _ => (before != Some(state)).then_some(HeartbeatEvent::State(state)),
        }
    }

    /// The state that the last heartbeat told; `None` before the first.
    #[must_use]
    pub const fn state(&self) -> Option<NmtState> {
        self.state
    }

    /// When the drive is lost unless a heartbeat comes; `None` before the first one, because the producer may be off.
    #[must_use]
    pub fn deadline_us(&self) -> Option<u64> {
        Some(self.heard_us?.saturating_add(u64::from(self.timeout_us)))
    }

    /// Whether the heartbeat has stopped.
    #[must_use]
    pub fn is_lost(&self, now_us: u64) -> bool {
        self.deadline_us()
            .is_some_and(|deadline| now_us >= deadline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_restart_is_told_and_silence_is_lost() {
        let mut watch = HeartbeatWatch::new(300_000);
        assert!(!watch.is_lost(10_000_000));
        let operational = NmtState::Operational;
        assert_eq!(
            watch.on_heartbeat(0, operational),
            Some(HeartbeatEvent::State(operational))
        );
        assert_eq!(watch.on_heartbeat(100_000, operational), None);
        assert!(!watch.is_lost(399_999));
        assert!(watch.is_lost(400_000));
        let boot_up = watch.on_heartbeat(500_000, NmtState::BootUp);
        assert_eq!(boot_up, Some(HeartbeatEvent::BootUp));
        let again = watch.on_heartbeat(500_001, NmtState::BootUp);
        assert_eq!(again, Some(HeartbeatEvent::BootUp));
        assert!(!watch.is_lost(700_000));
    }

    #[test]
    fn the_latest_state_is_kept() {
        let mut watch = HeartbeatWatch::new(300_000);
        assert_eq!(watch.state(), None);
        for state in [NmtState::BootUp, NmtState::Operational] {
            watch.on_heartbeat(0, state);
            assert_eq!(watch.state(), Some(state));
        }
    }
}
