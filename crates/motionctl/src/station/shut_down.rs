//! The end of every motion: slow down, then switch off what was switched on, and only that.

use can_motion::{AxisConfig, PollPeriods};
use dyn_can::DriveId;

use super::clock::{Clock, serve_until};
use super::pace::Pace;
use super::pc_master::{GROUP, PcMaster, Station};
use crate::drive_ids::about;
use crate::interrupt;
use crate::link::LinkFault;
use crate::output::tell;

/// Time to slow down.
const RAMP_LIMIT_US: u64 = 5_000_000;
/// Time for the drives to confirm that they are off; the command is repeated meanwhile.
const CONFIRM_LIMIT_US: u64 = 5_000_000;

/// What became of the power of the drives.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct End {
    /// Switched on by this station, and confirmed off.
    pub(crate) disabled: Vec<DriveId>,
    /// Switched on by this station, and not confirmed off.
    pub(crate) unconfirmed: Vec<DriveId>,
    /// On before, and left on.
    pub(crate) left_on: Vec<DriveId>,
}

impl Station<'_> {
    /// Slows all axes down, switches off the drives that this station has switched on, and waits for their confirmation. Drives that
    /// were on before hold. Ctrl-C during the ramp cuts it short.
    ///
    /// # Errors
    /// The fault of the link, after which nothing gets through any more: [`Self::link_warning`] says what that means.
    pub(crate) fn shut_down(&mut self) -> Result<End, LinkFault> {
        self.come_to_rest()?;
        let told = self.switched_on.clone();
        let unconfirmed = self.switch_off(&told)?;
        self.switched_on.clear();
        Ok(End {
            disabled: told
                .into_iter()
                .filter(|drive| !unconfirmed.contains(drive))
                .collect(),
            unconfirmed,
            left_on: self.found_on.clone(),
        })
    }

    /// A drive has confirmed that it is off, whoever switched it on.
    pub(crate) fn was_switched_off(&mut self, drive: DriveId) {
        self.found_on.retain(|other| *other != drive);
    }

    /// Switches off every drive of the station, whoever switched it on. Returns the drives that did not confirm.
    ///
    /// # Errors
    /// The fault of the link.
    pub(crate) fn disable_all(&mut self) -> Result<Vec<DriveId>, LinkFault> {
        let drives: Vec<DriveId> = self.drives().collect();
        self.switch_off(&drives)
    }

    /// The warning when the link has failed: which drives may still be on.
    pub(crate) fn link_warning(&mut self) -> String {
        self.link_warning_is_given = true;
        link_warning(&self.switched_on, &self.found_on)
    }

    fn come_to_rest(&mut self) -> Result<(), LinkFault> {
        let (start, requests) = (self.now(), interrupt::requests());
        self.master.stop(start, GROUP);
        while self.snapshots().any(|axis| axis.facts.moves())
            && self.now().us_since(start) < RAMP_LIMIT_US
        {
            self.cycle(|_, _| {})?;
            if interrupt::requests() > requests {
                break;
            }
        }
        let now = self.now();
        self.master.halt(now, GROUP);
        Ok(())
    }

    /// With a master of its own, because the drives of one group are switched off together, and because the other one may have
    /// panicked.
    fn switch_off(&mut self, drives: &[DriveId]) -> Result<Vec<DriveId>, LinkFault> {
        let is_meant = |axis: &&AxisConfig| drives.contains(&axis.drive);
        let unpolled = |axis: &AxisConfig| AxisConfig {
            polls: PollPeriods::OFF,
            unwatched: true,
            ..*axis
        };
        let axes: Vec<AxisConfig> = self.axes.iter().filter(is_meant).map(unpolled).collect();
        if axes.is_empty() {
            return Ok(Vec::new());
        }
        // Refused only where the plan of more axes was refused before.
        let Ok(mut master) = PcMaster::new(self.config, &axes) else {
            return Ok(drives.to_vec());
        };
        let clock = Clock::start();
        let mut pace = Pace::new(self.config.cycle_us);
        master.disable(clock.now(), GROUP);
        loop {
            serve_until(&mut master, self.link, &clock, pace.due())?;
            let now = clock.now();
            pace.begin(now);
            master.begin_cycle(now);
            let axes = (0..).map_while(|axis| master.snapshot(axis));
            let on = axes.filter(|axis| axis.facts.power.may_be_on());
            let unconfirmed: Vec<DriveId> = on.map(|axis| axis.drive).collect();
            if unconfirmed.is_empty() || now.as_us() >= CONFIRM_LIMIT_US {
                return Ok(unconfirmed);
            }
        }
    }
}

impl Drop for Station<'_> {
    /// Nobody called [`Station::shut_down`], or it did not get to its end: an error half-way, or a panic.
    fn drop(&mut self) {
        if self.switched_on.is_empty() {
            return;
        }
        let drives = core::mem::take(&mut self.switched_on);
        if self.link_warning_is_given {
            return;
        }
        match self.switch_off(&drives) {
            Ok(unconfirmed) if unconfirmed.is_empty() => {
                tell(about(&drives, "is disabled", "are disabled"));
            }
            Ok(unconfirmed) => tell(unconfirmed_warning(&unconfirmed)),
            Err(fault) => tell(format_args!(
                "the link failed: {fault}. {}",
                link_warning(&drives, &self.found_on)
            )),
        }
    }
}

/// The warning when the link has failed: which drives may still be on.
fn link_warning(switched_on: &[DriveId], found_on: &[DriveId]) -> String {
    let mut drives = [switched_on, found_on].concat();
    drives.sort_unstable();
    if drives.is_empty() {
        return "No drive was enabled.".to_owned();
    }
    format!(
        "No command gets through any more, and {}: use the emergency stop before you go near.",
        about(
            &drives,
            "may still be ENABLED where its last set-point took it",
            "may still be ENABLED where their last set-points took them"
        )
    )
}

/// The message about drives that are on already; `None` when there are none.
pub(crate) fn found_on(drives: &[DriveId]) -> Option<String> {
    (!drives.is_empty()).then(|| {
        about(
            drives,
            "was enabled before and will stay enabled",
            "were enabled before and will stay enabled",
        )
    })
}

/// The message about drives that were on before and are left on; `None` when there are none.
pub(crate) fn left_on(drives: &[DriveId]) -> Option<String> {
    (!drives.is_empty()).then(|| {
        about(
            drives,
            "was enabled before and STAYS ENABLED: `motionctl disable` switches it off",
            "were enabled before and STAY ENABLED: `motionctl disable` switches them off",
        )
    })
}

/// The warning about drives that have not said that they are disabled.
pub(crate) fn unconfirmed_warning(unconfirmed: &[DriveId]) -> String {
    about(
        unconfirmed,
        "did not confirm that it is DISABLED: use the emergency stop before you go near",
        "did not confirm that they are DISABLED: use the emergency stop before you go near",
    )
}
