//! The family of DYN drives: what only a master of theirs has.

use dyn_can::{DataFrame, DynFrame, FrameError, PdStep, Request};

use crate::axis::Axis;
use crate::command::TargetError;
use crate::config::{AxisConfig, ConfigError, MasterConfig};
use crate::event::EventKind;
use crate::family::{CycleConfig, Family, FaultKind};
use crate::fault::Fault;
use crate::life::AxisState;
use crate::master::Master;
use crate::placement::Placement;
use crate::plan::BusPlan;
use crate::procedure::{Confirmation, Procedure, ProcedureError};
use crate::snapshot::AxisSnapshot;
use crate::time::Instant;

/// DYN2 and DYN4 servo drives: each cycle a `Go_Relative_Pos_PD` for each streaming axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dyn;

impl Family for Dyn {
    type Frame = DataFrame;
    type Config = MasterConfig;
    type Axis = Axis;
    type SetPoint = PdStep;
    type Request = Request;
    type Fault = Fault;
    type EventKind = EventKind;
    type Snapshot = AxisSnapshot;

    const STOPS_BY_FRAME: bool = false;

    fn cycle_frame(_: &MasterConfig) -> Option<DataFrame> {
        None
    }

    fn address(frame: &DataFrame) -> Option<u8> {
        frame.address().drive().map(dyn_can::DriveId::get)
    }

    fn foreign(frame: &DataFrame) -> EventKind {
        EventKind::ForeignFrame { id: frame.id() }
    }

    fn not_ours(error: FrameError) -> EventKind {
        EventKind::NotOurs(error)
    }
}

impl CycleConfig for MasterConfig {
    fn cycle_us(&self) -> u32 {
        self.cycle_us
    }

    fn requests_per_cycle(&self) -> u8 {
        self.requests_per_cycle
    }
}

impl FaultKind for Fault {
    const GROUP: Self = Self::Group;
    const BUS: Self = Self::Bus;

    /// An axis that is lost, or whose position is, cannot follow a ramp.
    fn cannot_ramp(self) -> bool {
        self == Self::Lost || self.loses_reference()
    }
}

impl<const N: usize> Master<N> {
    /// A master for these axes, in ascending order of drive id.
    ///
    /// # Errors
    /// [`ConfigError`] when the configuration cannot work, or the bus cannot carry it in time.
    pub fn new(config: MasterConfig, axes: &[AxisConfig]) -> Result<Self, ConfigError> {
        // What cannot work is not worth planning.
        config.validate(axes, N)?;
        Self::with_plan(&BusPlan::new(&config, axes))
    }

    /// A master for the axes of a plan that was made before, usually in a `const`: the analysis is then no part of the program.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_plan(plan: &BusPlan<'_>) -> Result<Self, ConfigError> {
        let (config, axes) = (plan.config(), plan.axes());
        config.validate(axes, N)?;
        plan.check().map_err(|refusal| ConfigError::Plan {
            refusal,
            remedies: plan.remedies(),
        })?;
        let may_choose = plan.has_room_for_requests();
        let mut master = Self::empty(*config);
        master.placement = Placement::new(config.cycle_us, plan.burst(), may_choose);
        for warning in plan.warnings().into_iter().flatten() {
            master
                .events
                .push(Instant::default(), None, EventKind::Plan(warning));
        }
        for (rank, axis) in (0..).zip(axes) {
            master.add(axis.drive.get(), Axis::new(*axis, config, rank));
        }
        Ok(master)
    }

    /// Sets where an axis shall be, in command counts from its origin.
    ///
    /// # Errors
    /// [`TargetError`] when the axis does not stream or the target leaves its travel; nothing changes then.
    pub fn set_target(&mut self, axis: usize, counts: i32) -> Result<(), TargetError> {
        let Some(axis) = self.axes.get_mut(axis) else {
            return Err(TargetError::NoSuchAxis {
                axes: N,
                actual: axis,
            });
        };
        if axis.state != AxisState::Streaming {
            return Err(TargetError::NotStreaming { state: axis.state });
        }
        let (min, max) = (axis.config.limits.travel_min, axis.config.limits.travel_max);
        if counts < min || counts > max {
            return Err(TargetError::Travel {
                min,
                max,
                actual: counts,
            });
        }
        axis.books.set_target(counts);
        Ok(())
    }

    /// Starts a slow, wearing or dangerous command beside the cycle; its end is an event.
    ///
    /// # Errors
    /// [`ProcedureError`] when it may not run now; nothing changes then.
    pub fn start(
        &mut self,
        now: Instant,
        axis: usize,
        procedure: Procedure,
        confirmation: Confirmation,
    ) -> Result<(), ProcedureError> {
        let place = self.axes.get_mut(axis);
        let axis = place.ok_or(ProcedureError::NoSuchAxis { actual: axis })?;
        axis.start(procedure, confirmation, now)
    }
}
