//! Commands of the application. Motion commands act on whole groups, because axes of a group move and stop together.

use crate::command::CommandError;
use crate::config::GroupId;
use crate::family::{Family, Life};
use crate::life::{AxisState, Reason};
use crate::master::Master;
use crate::time::Instant;

impl<const N: usize, F: Family> Master<N, F> {
    /// Enables the drives of a group, each when its shaft has stood still. Each axis then streams its own position
    /// until it gets a target.
    ///
    /// # Errors
    /// [`CommandError`] unless every axis of the group is [`AxisState::Ready`]; nothing changes then.
    pub fn enable(&mut self, now: Instant, group: GroupId) -> Result<(), CommandError<F::Fault>> {
        self.require(group, AxisState::Ready)?;
        self.enter_all(now, group, AxisState::Ready, AxisState::AwaitingStandstill);
        Ok(())
    }

    /// Lets a group that holds stream again, from where it stands: set the next targets from the snapshot.
    ///
    /// # Errors
    /// [`CommandError`] unless every axis of the group is [`AxisState::Holding`]; nothing changes then.
    pub fn resume(&mut self, now: Instant, group: GroupId) -> Result<(), CommandError<F::Fault>> {
        self.require(group, AxisState::Holding)?;
        self.enter_all(now, group, AxisState::Holding, AxisState::Streaming);
        Ok(())
    }

    /// Slows a group down, all axes in proportion on their path, then holds.
    pub fn stop(&mut self, now: Instant, group: GroupId) {
        self.ramp_down(now, group, false);
    }

    /// Stops a group at once: no further set-point.
    pub fn halt(&mut self, now: Instant, group: GroupId) {
        for index in 0..self.axes.len() {
            let Some((axis, mut log)) = self.axis_and_log(now, index) else {
                continue;
            };
            if axis.group() == group && axis.state().sends_set_points() {
                axis.halt(AxisState::Holding, Reason::Command, &mut log);
                self.stopped(index);
            }
        }
    }

    /// Slows a group down, then disables its drives; an axis that does not stream is disabled at once.
    pub fn disable(&mut self, now: Instant, group: GroupId) {
        self.ramp_down(now, group, true);
        for index in 0..self.axes.len() {
            let Some((axis, mut log)) = self.axis_and_log(now, index) else {
                continue;
            };
            if axis.group() == group && axis.state().may_be_disabled() {
                axis.halt(AxisState::Disabling, Reason::Command, &mut log);
            }
        }
    }

    /// Forgets the latched faults of a group. An axis with a fault of its own is probed and anchored anew and must be
    /// enabled again; one that only stopped with its group holds.
    ///
    /// # Errors
    /// [`CommandError`] when the bus is off or the group has no axis.
    pub fn clear(&mut self, now: Instant, group: GroupId) -> Result<(), CommandError<F::Fault>> {
        if self.bus_off {
            return Err(CommandError::BusOff);
        }
        if !self.axes.iter().any(|axis| axis.group() == group) {
            return Err(CommandError::NoSuchGroup(group));
        }
        for index in 0..self.axes.len() {
            let Some((axis, mut log)) = self.axis_and_log(now, index) else {
                continue;
            };
            if axis.group() == group && axis.state() == AxisState::Faulted {
                axis.clear(&mut log);
            }
        }
        Ok(())
    }

    /// True when every axis of the group is in this state; false for a group without axes.
    #[must_use]
    pub fn all_are(&self, group: GroupId, state: AxisState) -> bool {
        self.require(group, state).is_ok()
    }

    fn require(&self, group: GroupId, expected: AxisState) -> Result<(), CommandError<F::Fault>> {
        if self.bus_off {
            return Err(CommandError::BusOff);
        }
        let mut found = false;
        for (index, axis) in self.axes.iter().enumerate() {
            if axis.group() != group {
                continue;
            }
            found = true;
            let axis_index = index as u8;
            if let Some(fault) = axis.fault() {
                return Err(CommandError::Faulted {
                    axis: axis_index,
                    fault,
                });
            }
            if axis.state() != expected {
                let actual = axis.state();
                return Err(CommandError::State {
                    axis: axis_index,
                    expected,
                    actual,
                });
            }
        }
        if found {
            Ok(())
        } else {
            Err(CommandError::NoSuchGroup(group))
        }
    }

    fn enter_all(&mut self, now: Instant, group: GroupId, from: AxisState, to: AxisState) {
        for index in 0..self.axes.len() {
            let Some((axis, mut log)) = self.axis_and_log(now, index) else {
                continue;
            };
            if axis.group() == group && axis.state() == from {
                axis.enter(to, Reason::Command, &mut log);
            }
        }
    }

    fn ramp_down(&mut self, now: Instant, group: GroupId, then_disable: bool) {
        let cycles = self.ramp_cycles(group);
        for index in 0..self.axes.len() {
            let Some((axis, mut log)) = self.axis_and_log(now, index) else {
                continue;
            };
            if axis.group() != group {
                continue;
            }
            match axis.state() {
                AxisState::Streaming => {
                    axis.start_ramp(cycles, then_disable, Reason::Command, &mut log);
                }
                AxisState::RampingDown if then_disable => axis.disable_after_ramp(),
                _ => {}
            }
        }
    }
}
