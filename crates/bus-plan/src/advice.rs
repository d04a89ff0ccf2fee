//! The plan with advice: where it is refused, it is worked out anew for each change that may help.

use can_frame::BitRate;

use crate::cycle::RequestPlace;
use crate::cycle_plan::CyclePlan;
use crate::drive::Drive;
use crate::remedies::Remedies;
use crate::setup::{CycleSetup, RequestMix};

/// Longest cycle of a master.
const MAX_CYCLE_US: u32 = 1_000_000;

/// Longer cycles to try, in quarters of the planned one.
const CYCLE_QUARTERS: [u32; 5] = [5, 6, 8, 12, 16];

impl CyclePlan {
    /// Works out the worst case of these drives, in the order in which the master sends their set-points.
    #[must_use]
    pub const fn new(setup: &CycleSetup, drives: &[Drive]) -> Self {
        // The master chooses the place of the requests when that puts no set-point at risk.
        let plan = Self::of(setup, drives, true, RequestPlace::Anywhere);
        if plan.refusal.is_none() {
            return plan;
        }
        let plan = Self::of(setup, drives, true, RequestPlace::Behind);
        match &plan.refusal {
            Some(refusal) if refusal.is_about_time() => plan.with(Remedies::of(setup, drives)),
            _ => plan,
        }
    }
}

impl Remedies {
    const fn of(setup: &CycleSetup, drives: &[Drive]) -> Self {
        let requests_per_cycle = fewer_requests(setup, drives);
        let is_polled = matches!(setup.bus.requests, RequestMix::Polls);
        Self {
            requests_per_cycle,
            no_polls: is_polled && requests_per_cycle.is_none() && fits(setup, drives, false),
            bit_rate: better_bit_rate(setup, drives),
            cycle_us: better_cycle_us(setup, drives),
            axes: fewer_axes(setup, drives),
        }
    }
}

const fn fits(setup: &CycleSetup, drives: &[Drive], is_polled: bool) -> bool {
    CyclePlan::of(setup, drives, is_polled, RequestPlace::Behind)
        .check()
        .is_ok()
}

const fn fewer_requests(setup: &CycleSetup, drives: &[Drive]) -> Option<u8> {
    let mut fewer = *setup;
    while fewer.requests_per_cycle > 1 {
        fewer.requests_per_cycle -= 1;
        if fits(&fewer, drives, true) {
            return Some(fewer.requests_per_cycle);
        }
    }
    None
}

const fn better_bit_rate(setup: &CycleSetup, drives: &[Drive]) -> Option<BitRate> {
    let mut better = *setup;
    let mut rates = setup.bus.bit_rate.higher();
    while let Some((bit_rate, others)) = rates.split_first() {
        better.bus.bit_rate = *bit_rate;
        if bit_rate.is_one_of(setup.bit_rates) && fits(&better, drives, true) {
            return Some(*bit_rate);
        }
        rates = others;
    }
    None
}

const fn better_cycle_us(setup: &CycleSetup, drives: &[Drive]) -> Option<u32> {
    let mut better = *setup;
    let mut quarters: &[u32] = &CYCLE_QUARTERS;
    while let Some((factor, behind)) = quarters.split_first() {
        better.cycle_us = (setup.cycle_us / 4).saturating_mul(*factor);
        if better.cycle_us <= MAX_CYCLE_US && fits(&better, drives, true) {
            return Some(better.cycle_us);
        }
        quarters = behind;
    }
    None
}

const fn fewer_axes(setup: &CycleSetup, drives: &[Drive]) -> usize {
    let mut fewer = drives;
    while let Some((_, before)) = fewer.split_last() {
        if fits(setup, before, true) {
            return before.len();
        }
        fewer = before;
    }
    0
}
