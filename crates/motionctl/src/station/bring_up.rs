//! The begin of every motion: drives that are on are taken over, the others are enabled.

use core::fmt;

use can_motion::{AxisSnapshot, AxisState, CommandError, EventKind, Fault};
use dyn_can::DriveId;

use super::fault_text::fault_text;
use super::pc_master::{GROUP, Station};
use crate::interrupt;
use crate::link::LinkFault;
use crate::output::tell;

/// Time for the drives to become ready, and again to be enabled.
const LIMIT_US: u64 = 10_000_000;
/// Time for a drive that reports an alarm to say which.
const ALARM_LIMIT_US: u64 = 500_000;

/// Why drives do not stream set-points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum BringUpError {
    /// The link failed.
    Link(LinkFault),
    /// The user asked to stop.
    Interrupted,
    /// A drive has a fault.
    Fault { drive: DriveId, fault: Fault },
    /// A drive is still in this state when the time is over.
    NotReady { drive: DriveId, state: AxisState },
    /// A drive cannot be enabled in this state.
    Refused { drive: DriveId, state: AxisState },
    /// The master takes no commands.
    NoCommands { reason: String },
}

impl From<LinkFault> for BringUpError {
    fn from(fault: LinkFault) -> Self {
        Self::Link(fault)
    }
}

impl fmt::Display for BringUpError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link(fault) => write!(f, "the link failed: {fault}"),
            Self::Interrupted => f.write_str("stopped by the user"),
            Self::Fault { drive, fault } => f.write_str(&fault_text(*drive, *fault)),
            Self::NotReady { drive, state } => write!(
                f,
                "drive {drive} is still {state} after {} s: try again, or look for a second master",
                LIMIT_US / 1_000_000
            ),
            Self::Refused { drive, state } => write!(
                f,
                "drive {drive} cannot be enabled, it is {state}: try again, or look for a second master"
            ),
            Self::NoCommands { reason } => f.write_str(reason),
        }
    }
}

impl Station<'_> {
    /// Waits until every drive is checked, takes over those that are on, enables the others, and waits until all stream.
    ///
    /// # Errors
    /// [`BringUpError`]; what was enabled until then is switched off by [`Self::shut_down`].
    pub(crate) fn bring_up(&mut self) -> Result<(), BringUpError> {
        self.wait_until(|state| matches!(state, AxisState::Ready | AxisState::FoundOn))?;
        let (found_on, off): (Vec<_>, Vec<_>) = self
            .snapshots()
            .partition(|axis| axis.state == AxisState::FoundOn);
        self.found_on = ids(&found_on);
        let now = self.now();
        if !self.found_on.is_empty() {
            self.master
                .adopt(now, GROUP)
                .map_err(|error| self.refusal(error))?;
            // One that is taken over is checked anew, and then holds.
            self.wait_until(|state| matches!(state, AxisState::Ready | AxisState::Holding))?;
        }
        let now = self.now();
        // Noted before the word is given: whatever happens from here on, these are switched off.
        self.switched_on = ids(&off);
        self.master
            .enable(now, GROUP)
            .map_err(|error| self.refusal(error))?;
        self.wait_until(|state| state == AxisState::Streaming)?;
        if self.link.is_silent() {
            tell(
                "note: this adapter acknowledges no frame: one that it drops shows only in the position that a drive reports",
            );
        }
        Ok(())
    }

    /// The master knows axes, the user knows drives.
    fn refusal(&self, error: CommandError<Fault>) -> BringUpError {
        let axis = match error {
            CommandError::Faulted { axis, .. }
            | CommandError::State { axis, .. }
            | CommandError::Busy { axis }
            | CommandError::Unclear { axis }
            | CommandError::LoadCanFall { axis } => self.master.snapshot(usize::from(axis)),
            _ => None,
        };
        match axis {
            Some(AxisSnapshot {
                drive,
                fault: Some(fault),
                ..
            }) => BringUpError::Fault { drive, fault },
            Some(AxisSnapshot { drive, state, .. }) => BringUpError::Refused { drive, state },
            None => BringUpError::NoCommands {
                reason: error.to_string(),
            },
        }
    }

    /// Drives that were on before this station came.
    pub(crate) fn found_on(&self) -> &[DriveId] {
        &self.found_on
    }

    /// The first fault since the last time, of the drive that is its cause.
    pub(crate) fn first_fault(&mut self) -> Option<(DriveId, Fault)> {
        let mut first = None;
        while let Some(event) = self.next_event() {
            if let (EventKind::Fault(fault), Some(axis)) = (event.kind, event.axis)
                && fault != Fault::Group
                && let Some(axis) = self.axes.get(usize::from(axis))
            {
                first = first.or(Some((axis.drive, fault)));
            }
        }
        let (drive, fault) = first?;
        Some((drive, self.named(drive, fault)))
    }

    /// The same fault with the name of the alarm, as soon as the drive tells it.
    pub(crate) fn named(&mut self, drive: DriveId, fault: Fault) -> Fault {
        if fault != Fault::AlarmFrame {
            return fault;
        }
        let start = self.now();
        while self.now().us_since(start) < ALARM_LIMIT_US && self.cycle(|_, _| {}).is_ok() {
            let mut axes = self.snapshots();
            let status = axes
                .find(|axis| axis.drive == drive)
                .and_then(|axis| axis.feedback.status);
            let alarm = status.map(|status| status.value.alarm());
            if let Some(alarm) = alarm.filter(|alarm| alarm.is_alarm()) {
                return Fault::AlarmStatus(alarm);
            }
        }
        fault
    }

    /// Cycles until every drive is in such a state.
    ///
    /// # Errors
    /// [`BringUpError`] when a drive has a fault, Ctrl-C comes first, or it takes too long.
    pub(crate) fn wait_until(
        &mut self,
        is_so: impl Fn(AxisState) -> bool,
    ) -> Result<(), BringUpError> {
        let start = self.now();
        loop {
            self.cycle(|_, _| {})?;
            if let Some((drive, fault)) = self.first_fault() {
                return Err(BringUpError::Fault { drive, fault });
            }
            let waits_for = self.snapshots().find(|axis| !is_so(axis.state));
            let Some(axis) = waits_for else {
                return Ok(());
            };
            if interrupt::requests() > 0 {
                return Err(BringUpError::Interrupted);
            }
            if self.now().us_since(start) >= LIMIT_US {
                let (drive, state) = (axis.drive, axis.state);
                return Err(BringUpError::NotReady { drive, state });
            }
        }
    }
}

fn ids(axes: &[AxisSnapshot]) -> Vec<DriveId> {
    axes.iter().map(|axis| axis.drive).collect()
}
