//! Whether a bus carries its wheels: the list of their frames.

use bus_plan::analysis::Response;
use bus_plan::streams::{FrameStream, first_late, response_times};

use crate::core::family::Plan;
use crate::core::placement::BehindFrames;
use crate::wheel::config::{FeedbackTiming, WheelConfig, WheelConfigError, WheelMasterConfig};
use crate::wheel::event::WheelEventKind;
use crate::wheel::zlac_family::Zlac;

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

/// Kinds of frames on a bus with wheels.
pub const STREAMS: usize = 7;
/// Shortest tick of the event timer of a PDO: the guide counts 0.5 ms, CiA 301 counts 1 ms (Z11).
const TICK_US: u32 = 500;

impl WheelPlan<'_> {
    /// The frames of this bus.
    ///
    /// One transfer of each drive is open at most, so that no more replies than drives come at once.
    #[must_use]
    pub fn streams(&self) -> [FrameStream; STREAMS] {
        let config = &self.config;
        let cycle_us = config.cycle_us;
        let wheels = self.wheels.len() as u32;
        let requests = u32::from(config.requests_per_cycle);
        let feedback_us = match config.feedback {
            FeedbackTiming::Timer { ticks } => TICK_US * u32::from(ticks.max(1)),
            FeedbackTiming::Sync => cycle_us,
        };
        let has_sync = config.feedback == FeedbackTiming::Sync;
        let heartbeat_us = 1_000 * u32::from(config.timeouts.heartbeat_ms);
        let rounds = wheels.div_ceil(requests.max(1));
        let stream = FrameStream::new;
        [
            stream("command", wheels, 6, cycle_us, cycle_us),
            stream("SYNC", u32::from(has_sync), 0, cycle_us, cycle_us),
            stream("status", wheels, 8, feedback_us, feedback_us),
            stream("position", wheels, 6, feedback_us, feedback_us),
            stream("heartbeat", wheels, 1, heartbeat_us, heartbeat_us),
            stream("SDO request", requests, 8, cycle_us, 2 * cycle_us),
            stream(
                "SDO reply",
                wheels,
                8,
                cycle_us.saturating_mul(rounds),
                config.timeouts.sdo.reply_us,
            ),
        ]
    }

    /// The worst case of each, in the order of [`Self::streams`].
    #[must_use]
    pub fn response_times(&self) -> [Response; STREAMS] {
        response_times(&self.streams(), self.config.bit_rate)
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
        self.config.validate(self.wheels, room)?;
        match first_late(&self.streams(), self.config.bit_rate) {
            Some((frame, response)) => Err(WheelConfigError::Late { frame, response }),
            None => Ok(()),
        }
    }

    fn placement(&self) -> BehindFrames {
        BehindFrames
    }

    fn warnings(&self) -> impl Iterator<Item = WheelEventKind> {
        core::iter::empty()
    }
}
