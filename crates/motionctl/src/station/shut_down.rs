//! The end of every motion: ramp down, disable, confirm.

use can_motion::{AxisSnapshot, AxisState};
use dyn_can::DriveId;

use super::{GROUP, Station};
use crate::drive_ids::list;
use crate::interrupt;
use crate::link::LinkFault;

/// Time to ramp down, disable and confirm.
const LIMIT_US: u64 = 5_000_000;

impl Station<'_> {
    /// Slows all axes down, disables them and waits for their confirmation. Ctrl-C during the ramp cuts it short. Returns
    /// the drives that have not said that they are disabled.
    ///
    /// # Errors
    /// The fault of the link, after which nothing gets through any more.
    pub(crate) fn shut_down(&mut self) -> Result<Vec<DriveId>, LinkFault> {
        let (start, requests) = (self.now(), interrupt::requests());
        self.master.disable(start, GROUP);
        while self.now().us_since(start) < LIMIT_US {
            self.cycle(|_, _| {})?;
            if interrupt::requests() > requests {
                let now = self.now();
                self.master.halt(now, GROUP);
                self.master.disable(now, GROUP);
            }
            if self.unsettled() == 0 {
                break;
            }
        }
        Ok(self.unconfirmed())
    }

    fn states(&self) -> impl Iterator<Item = AxisSnapshot> + '_ {
        (0..).map_while(|axis| self.master.snapshot(axis))
    }

    /// Axes on their way to being disabled.
    fn unsettled(&self) -> usize {
        let settled = |state| {
            matches!(
                state,
                AxisState::PowerOn | AxisState::Ready | AxisState::Faulted
            )
        };
        self.states().filter(|axis| !settled(axis.state)).count()
    }

    /// Drives that have not said that they are disabled.
    fn unconfirmed(&self) -> Vec<DriveId> {
        let is_disabled = |axis: &AxisSnapshot| {
            let status = axis.feedback.status;
            status.is_some_and(|status| status.value.is_disabled())
        };
        let axes = self.states().filter(|axis| !is_disabled(axis));
        axes.map(|axis| axis.drive).collect()
    }
}

/// The warning when the link has failed while drives were enabled.
pub(crate) const LINK_WARNING: &str = "No command gets through any more. The drives hold where the last set-point took them and may still be ENABLED: use the emergency stop before you go near.";

/// The warning about drives that have not said that they are disabled.
pub(crate) fn warning(unconfirmed: &[DriveId]) -> String {
    format!(
        "drives {} did not confirm that they are DISABLED: use the emergency stop before you go near",
        list(unconfirmed)
    )
}
