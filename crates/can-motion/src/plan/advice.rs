//! The plan with advice: where it is refused, it is worked out anew for each change that may help.

use can_frame::BitRate;

use super::bus_plan::BusPlan;
use super::cycle::RequestPlace;
use super::remedies::Remedies;
use super::setup::RequestMix;
use crate::servo::config::{AxisConfig, MasterConfig};

/// Longest cycle of a master.
const MAX_CYCLE_US: u32 = 1_000_000;

/// Longer cycles to try, in quarters of the planned one.
const CYCLE_QUARTERS: [u32; 5] = [5, 6, 8, 12, 16];

impl<'a> BusPlan<'a> {
    /// Works out the worst case of these axes, in the order in which the master sends their set-points.
    ///
    /// Takes no notice of what [`Master::new`](crate::Master::new) checks and the bus does not care about.
    #[must_use]
    pub const fn new(config: &MasterConfig, axes: &'a [AxisConfig]) -> Self {
        // The master chooses the place of the requests when that puts no set-point at risk.
        let plan = Self::of(config, axes, true, RequestPlace::Anywhere);
        if plan.refusal.is_none() {
            return plan;
        }
        let plan = Self::of(config, axes, true, RequestPlace::Behind);
        match &plan.refusal {
            Some(refusal) if refusal.is_about_time() => plan.with(Remedies::of(config, axes)),
            _ => plan,
        }
    }
}

impl Remedies {
    const fn of(config: &MasterConfig, axes: &[AxisConfig]) -> Self {
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
        if dyn_can::knows_bit_rate(*bit_rate) && fits(&better, axes, true) {
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
