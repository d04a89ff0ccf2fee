//! The end of every motion: ramp down, disable, confirm.

use can_motion::AxisState;

use super::{GROUP, Station};
use crate::interrupt;
use crate::link::LinkFault;

/// Time to ramp down, disable and confirm.
const LIMIT_US: u64 = 5_000_000;

/// How a shut-down ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ShutDown {
    /// Every drive that was enabled says that it is disabled.
    Disabled,
    /// This many drives did not confirm.
    Unconfirmed(usize),
}

impl Station {
    /// Slows all axes down, disables them and waits for their confirmation. Ctrl-C during the ramp cuts it short.
    ///
    /// # Errors
    /// The fault of the link, after which nothing gets through any more.
    pub(crate) fn shut_down(&mut self) -> Result<ShutDown, LinkFault> {
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
        Ok(match self.unconfirmed() {
            0 => ShutDown::Disabled,
            drives => ShutDown::Unconfirmed(drives),
        })
    }

    fn states(&self) -> impl Iterator<Item = can_motion::AxisSnapshot> + '_ {
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

    /// Axes whose drive has not said that it is disabled.
    fn unconfirmed(&self) -> usize {
        let is_disabled = |axis: &can_motion::AxisSnapshot| {
            let status = axis.feedback.status;
            status.is_some_and(|status| status.value.is_disabled())
        };
        self.states().filter(|axis| !is_disabled(axis)).count()
    }
}
