//! What would help a plan that was refused: the plan is worked out anew for each change.

use core::fmt;

use can_frame::BitRate;

use super::bus_plan::BusPlan;
use super::cycle::RequestPlace;
use super::setup::RequestMix;
use super::text::Text;
use crate::servo::config::{AxisConfig, MasterConfig};

/// Longest cycle of a master.
const MAX_CYCLE_US: u32 = 1_000_000;

/// Longer cycles to try, in quarters of the planned one.
const CYCLE_QUARTERS: [u32; 5] = [5, 6, 8, 12, 16];

/// Changes of one setting each with which a refused plan would be admitted; the number of axes is always one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Remedies {
    /// The most requests in a cycle, fewer than planned.
    pub requests_per_cycle: Option<u8>,
    /// No polls at all.
    pub no_polls: bool,
    /// The lowest bit rate, higher than planned.
    pub bit_rate: Option<BitRate>,
    /// A cycle that is long enough, in microseconds: the planned one times 5/4, 3/2, 2, 3 or 4.
    pub cycle_us: Option<u32>,
    /// How many axes fit, from the first one on.
    pub axes: usize,
}

impl Remedies {
    pub(super) const NONE: Self = Self {
        requests_per_cycle: None,
        no_polls: false,
        bit_rate: None,
        cycle_us: None,
        axes: 0,
    };

    pub(super) const fn of(config: &MasterConfig, axes: &[AxisConfig]) -> Self {
        let requests_per_cycle = fewer_requests(config, axes);
        let is_polled = matches!(config.bus.requests, RequestMix::Polls);
        Self {
            requests_per_cycle,
            no_polls: is_polled && requests_per_cycle.is_none() && fits(config, axes, false),
            bit_rate: better_bit_rate(config, axes),
            cycle_us: better_cycle_us(config, axes),
            axes: fewer_axes(config, axes),
        }
    }

    pub(super) const fn add_to(&self, text: Text) -> Text {
        let mut text = text.str("it would fit with ");
        let mut separator = "";
        if let Some(requests) = self.requests_per_cycle {
            text = text.str("requests_per_cycle = ").number(requests as u64);
            separator = ", or ";
        }
        if self.no_polls {
            text = text.str(separator).str("no polls");
            separator = ", or ";
        }
        if let Some(bit_rate) = self.bit_rate {
            text = text.str(separator).number(bit_rate.kbit_per_s() as u64);
            text = text.str(" kbit/s");
            separator = ", or ";
        }
        if let Some(cycle_us) = self.cycle_us {
            text = text.str(separator).str("cycle_us = ");
            text = text.number(cycle_us as u64);
            separator = ", or ";
        }
        match self.axes {
            0 if separator.is_empty() => text.str("none of the usual changes"),
            0 => text,
            axes => {
                let text = text.str(separator).str("the first ");
                text.number(axes as u64).str(" axes")
            }
        }
    }
}

impl fmt::Display for Remedies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.add_to(Text::EMPTY).as_str())
    }
}

const fn fits(config: &MasterConfig, axes: &[AxisConfig], is_polled: bool) -> bool {
    BusPlan::of(config, axes, is_polled, RequestPlace::Behind)
        .check()
        .is_ok()
}

const fn fewer_requests(config: &MasterConfig, axes: &[AxisConfig]) -> Option<u8> {
    let mut fewer = *config;
    while fewer.requests_per_cycle > 1 {
        fewer.requests_per_cycle -= 1;
        if fits(&fewer, axes, true) {
            return Some(fewer.requests_per_cycle);
        }
    }
    None
}

const fn better_bit_rate(config: &MasterConfig, axes: &[AxisConfig]) -> Option<BitRate> {
    let mut better = *config;
    let mut rates = config.bus.bit_rate.higher();
    while let Some((bit_rate, others)) = rates.split_first() {
        better.bus.bit_rate = *bit_rate;
        if fits(&better, axes, true) {
            return Some(*bit_rate);
        }
        rates = others;
    }
    None
}

const fn better_cycle_us(config: &MasterConfig, axes: &[AxisConfig]) -> Option<u32> {
    let mut better = *config;
    let mut quarters: &[u32] = &CYCLE_QUARTERS;
    while let Some((factor, behind)) = quarters.split_first() {
        better.cycle_us = (config.cycle_us / 4).saturating_mul(*factor);
        if better.cycle_us <= MAX_CYCLE_US && fits(&better, axes, true) {
            return Some(better.cycle_us);
        }
        quarters = behind;
    }
    None
}

const fn fewer_axes(config: &MasterConfig, axes: &[AxisConfig]) -> usize {
    let mut fewer = axes;
    while let Some((_, before)) = fewer.split_last() {
        if fits(config, before, true) {
            return before.len();
        }
        fewer = before;
    }
    0
}
