//! The options as the homing and the master want them.

use can_motion::wheel::{WheelConfig, WheelLimits};
use homing::{Config, Homing, Watch};
use zlac8030l::dictionary::{self, Entry};
use zlac8030l::{NodeId, ObjectAddress, objects};

use super::arguments::{Arguments, CurrentUnit};
use crate::home::{Family, HomeError, Scale};
use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::for_now::ForNow;
use crate::hub::look::Look;
use crate::hub::object::ObjectSetting;

/// The drive takes a target every second cycle, by an edge of its control word.
pub(super) const CYCLE_US: u32 = 20_000;
/// Hub motors are told a target every 40 ms and make a profile of their own to each, so that they lag more than servos do.
pub(super) const HUB: Family = Family {
    contact_degrees: 15.0,
    max_degrees: 90.0,
    max_age_us: 200_000,
    still_counts: Watch::DEFAULT.still_counts,
};
const MA_PER_DECIAMPERE: f64 = 100.0;
const PERMILLE: f64 = 1_000.0;
/// Largest current, 0.1 A.
const MAX_CURRENT: ObjectAddress = ObjectAddress::new(0x2015, 0);

/// The row of 2015h.
pub(super) fn max_current() -> Result<&'static Entry, HubError> {
    let row = dictionary::find(MAX_CURRENT);
    row.ok_or_else(|| HubError::Input("the dictionary has no object 2015h".to_owned()))
}

/// What is done, and with which limits.
pub(super) struct Plan {
    pub(super) node: NodeId,
    pub(super) wheel: WheelConfig,
    pub(super) config: Config,
    pub(super) turn_counts: f64,
    /// 2015h, to which all percents belong, in 0.1 A.
    peak_deciamperes: i64,
    most_share: f64,
    /// Thousandths of the peak for 1 of 6077h.
    permille_per_unit: f64,
}

impl Plan {
    pub(super) fn new(arguments: &Arguments, bus: &mut Bus, look: &Look) -> Result<Self, HubError> {
        let node = look.node;
        let search = &arguments.search;
        let position = bus.read(node, objects::ACTUAL_POSITION)?;
        let peak_deciamperes = bus.read_number(node, MAX_CURRENT)?;
        if search.moves() && peak_deciamperes < 1 {
            return Err(HubError::Input(format!(
                "node {node} may use {peak_deciamperes} x 0.1 A at most (2015h), so that it cannot move and percents of it mean nothing. Nothing has moved"
            )));
        }
        let scale = Scale {
            turn: look.counts_per_turn,
            cycle_us: CYCLE_US,
        };
        let config = search.config(&scale, &HUB)?;
        // Refused here, before anything is asked.
        Homing::new(config, position).map_err(|refusal| scale.words(refusal))?;
        let reach = config.reach(position).map_err(HomeError::Refusal)?;
        let most = scale.counts_of_degrees(search.max_degrees(&HUB));
        let step = (f64::from(config.search.velocity()) * 4.0).ceil();
        let limits = WheelLimits {
            // The homing sees it first, and says more.
            following_error: most.saturating_mul(2),
            ..WheelLimits::position(
                // A shaft that stands may be read a little beside where it was seen.
                reach
                    .min_counts
                    .saturating_sub(HUB.still_counts.cast_signed()),
                reach
                    .max_counts
                    .saturating_add(HUB.still_counts.cast_signed()),
                step.max(1.0) as u32,
                config.search.acceleration().ceil().max(1.0) as u32,
            )
        };
        let profile_rpm = (search.rpm * 1.25).ceil() as u16 + 1;
        let wheel = look.follows_positions(limits, profile_rpm, search.max_acceleration);
        let unit_ma = match arguments.current_unit {
            CurrentUnit::Deciampere => MA_PER_DECIAMPERE,
            CurrentUnit::Milliampere => 1.0,
        };
        let sign = if arguments.torque_reversed { -1.0 } else { 1.0 };
        let peak_ma = (peak_deciamperes.max(1) as f64) * MA_PER_DECIAMPERE;
        Ok(Self {
            node,
            wheel,
            config,
            turn_counts: look.counts_per_turn,
            peak_deciamperes,
            most_share: search.max_torque / 100.0,
            permille_per_unit: sign * unit_ma / peak_ma * PERMILLE,
        })
    }

    /// Lowers the largest current of the drive to --max-torque.
    ///
    /// # Errors
    /// As [`ForNow::set`].
    pub(super) fn lower_current(
        &self,
        lowered: &mut ForNow,
        bus: &mut Bus,
    ) -> Result<(), HubError> {
        let most = (self.peak_deciamperes as f64 * self.most_share).ceil();
        let setting = ObjectSetting {
            entry: max_current()?,
            value: most.max(1.0) as i64,
        };
        lowered.set(bus, &[setting])
    }

    /// Thousandths of the peak.
    pub(super) fn permille(&self, torque: i16) -> i16 {
        // Beyond the scale is beyond every limit.
        (f64::from(torque) * self.permille_per_unit).round() as i16
    }
}
