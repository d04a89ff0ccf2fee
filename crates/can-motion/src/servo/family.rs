//! The family of DYN drives.

use dyn_can::{DataFrame, DynFrame, FrameError, Request};

use crate::core::family::{Family, Plan};
use crate::core::master::Master;
use crate::servo::config::{AxisConfig, ConfigError, MasterConfig};
use crate::servo::drive::Servo;
use crate::servo::dyn_family::Dyn;
use crate::servo::event::EventKind;
use crate::servo::fault::Fault;
use crate::servo::placement::Aligned;
use crate::servo::plan::BusPlan;
use crate::servo::procedure::{Procedure, ProcedureError};
use crate::servo::snapshot::AxisSnapshot;

/// A master of at most `N` servo axes.
pub type ServoMaster<const N: usize> = Master<N, Dyn>;

impl Family for Dyn {
    type Frame = DataFrame;
    type Config = MasterConfig;
    type AxisConfig = AxisConfig;
    type ConfigError = ConfigError;
    type Plan<'a> = BusPlan<'a>;
    type Placement = Aligned;
    type Drive = Servo;
    type Request = Request;
    type Procedure = Procedure;
    type ProcedureError = ProcedureError;
    type Fault = Fault;
    type EventKind = EventKind;
    type Snapshot = AxisSnapshot;

    const HAS_CYCLE_FRAMES: bool = false;
    const MAKES_MOVES: bool = cfg!(feature = "procedures");

    fn plan<'a>(config: &MasterConfig, axes: &'a [AxisConfig]) -> BusPlan<'a> {
        BusPlan::new(config, axes)
    }

    fn address_of(axis: &AxisConfig) -> u8 {
        axis.drive.get()
    }

    fn drive(config: &MasterConfig, axis: &AxisConfig, rank: u32) -> Servo {
        Servo::new(axis, config, rank)
    }

    fn address(frame: &DataFrame) -> Option<u8> {
        frame.address().drive().map(dyn_can::DriveId::get)
    }

    fn is_trigger(frame: &DataFrame) -> bool {
        crate::servo::own_move::is_trigger(frame)
    }

    fn foreign(frame: &DataFrame) -> Option<EventKind> {
        Some(EventKind::ForeignFrame { id: frame.id() })
    }

    fn not_ours(error: FrameError) -> Option<EventKind> {
        Some(EventKind::NotOurs(error))
    }
}

impl Plan<Dyn> for BusPlan<'_> {
    fn config(&self) -> &MasterConfig {
        self.config()
    }

    fn axes(&self) -> &[AxisConfig] {
        self.axes()
    }

    fn admit(&self, room: usize) -> Result<(), ConfigError> {
        // What cannot work is reported before what the bus cannot carry.
        self.config().validate(self.axes(), room)?;
        self.check().map_err(|refusal| ConfigError::Plan {
            refusal,
            remedies: self.remedies(),
        })
    }

    fn placement(&self) -> Aligned {
        Aligned::new(
            self.config().cycle_us,
            self.cycle().burst(),
            self.cycle().has_room_for_requests(),
        )
    }

    fn warnings(&self) -> impl Iterator<Item = EventKind> {
        let warnings = self.cycle().warnings();
        warnings.into_iter().flatten().map(EventKind::Plan)
    }
}
