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

#[cfg(test)]
mod tests {
    use can_motion::PollPeriods;
    use dyn_can::StepLimit;

    use super::*;
    use crate::link::fake_adapter::{FakeAdapter, set_up_answer};
    use crate::station::AxisOptions;

    /// Drive 1 answers every question and obeys no Servo_Disable.
    fn stubborn_drive(line: &[u8]) -> Vec<u8> {
        let reply: &[u8] = match line {
            // Echo_Function: the same bytes.
            [b't', b'0', b'3', b'E', ..] => line,
            b"t0350" => b"t0356140000100000",
            b"t0280" => b"t028100",
            b"t0290" => b"t029100",
            b"t02E11B" => b"t02E100",
            [b't', ..] => return b"z\r".to_vec(),
            _ => return set_up_answer(line),
        };
        [b"z\r", reply, b"\r"].concat()
    }

    #[test]
    fn a_drive_that_stays_enabled_is_named() {
        let adapter = FakeAdapter::new("stubborn", stubborn_drive);
        let mut link = adapter.open();
        let axis = AxisOptions::default().axis(DriveId::MIN, StepLimit::MAX, PollPeriods::DEFAULT);
        let mut station = Station::new(&mut link, &[axis], 1_000).unwrap();
        while !station.master().all_are(GROUP, AxisState::Ready) {
            station.cycle(|_, _| {}).unwrap();
        }
        assert_eq!(station.shut_down(), Ok(vec![DriveId::MIN]));
        assert!(warning(&[DriveId::MIN]).contains("drives 1 did not confirm"));
    }
}
