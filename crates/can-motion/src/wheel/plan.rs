//! Whether a bus carries its wheels.

use crate::core::family::Plan;
use crate::core::placement::BehindFrames;
use crate::wheel::config::{WheelConfig, WheelConfigError, WheelMasterConfig};
use crate::wheel::event::WheelEventKind;
use crate::wheel::family::Zlac;

/// The plan of a bus with wheels.
#[derive(Debug, Clone, Copy)]
pub struct WheelPlan<'a> {
    config: WheelMasterConfig,
    wheels: &'a [WheelConfig],
}

impl<'a> WheelPlan<'a> {
    /// The plan of these wheels, in ascending order of node.
    #[must_use]
    pub const fn new(config: &WheelMasterConfig, wheels: &'a [WheelConfig]) -> Self {
        Self {
            config: *config,
            wheels,
        }
    }
}

impl Plan<Zlac> for WheelPlan<'_> {
    fn config(&self) -> &WheelMasterConfig {
        &self.config
    }

    fn axes(&self) -> &[WheelConfig] {
        self.wheels
    }

    fn admit(&self, room: usize) -> Result<(), WheelConfigError> {
        self.config.validate(self.wheels, room)
    }

    fn placement(&self) -> BehindFrames {
        BehindFrames
    }

    fn warnings(&self) -> impl Iterator<Item = WheelEventKind> {
        core::iter::empty()
    }
}
