//! What drives put on the bus in each cycle.

use can_frame::wire::bound_bits;

use crate::analysis::max;
use crate::burst::Burst;
use crate::cycle::{Cycle, RequestPlace, narrow};
use crate::drive::{Drive, Requests};
use crate::setup::{CycleSetup, RequestMix, TxOrder};

/// Shortest frame, without stuff bits: no data.
const SHORTEST_BITS: u32 = 47;

/// The frames of a cycle, with or without polls.
pub(crate) const fn cycle_of(
    setup: &CycleSetup,
    drives: &[Drive],
    is_polled: bool,
    place: RequestPlace,
) -> Cycle {
    let bus = &setup.bus;
    let rate = bus.bit_rate;
    let (asked, requests) = requests(setup, drives, is_polled);
    let budget = setup.requests_per_cycle as u64;
    let (mut set_points_bits, mut set_point_bits, mut alarm_bits, mut rest) = (0, 0, 0, drives);
    while let Some((drive, behind)) = rest.split_first() {
        set_points_bits += drive.set_point_bits as u64;
        set_point_bits = max(set_point_bits, drive.set_point_bits as u64);
        alarm_bits = max(alarm_bits, drive.alarm_bits as u64);
        rest = behind;
    }
    Cycle {
        bits: rate.bits_within(setup.cycle_us),
        bits_rounded_up: rate.bits_covering(setup.cycle_us),
        set_points_bits,
        set_point_bits,
        requests: if asked < budget { asked } else { budget },
        request_bits: requests.request_bits,
        shortest_request_bits: requests.shortest_request_bits,
        reply_bits: requests.reply_bits,
        response_min_bits: rate.bits_within(bus.response.min_us),
        response_max_bits: rate.bits_covering(bus.response.max_us),
        alarms: bus.alarm_burst as u64,
        alarm_bits,
        jitter_bits: rate.bits_covering(bus.release_jitter_us),
        reply_timeout_bits: rate.bits_within(setup.reply_us),
        place: match bus.order {
            TxOrder::Fifo => place,
            TxOrder::Identifier => RequestPlace::Anywhere,
        },
        order: bus.order,
        error_interval_bits: match bus.error_interval_us {
            Some(us) => Some(narrow(rate.bits_within(us))),
            None => None,
        },
    }
}

/// How many drives are asked, and with what. Where there are several groups, one is enabled, or checked anew after a fault, while
/// another streams.
const fn requests(setup: &CycleSetup, drives: &[Drive], is_polled: bool) -> (u64, Requests) {
    if matches!(setup.bus.requests, RequestMix::Any) || has_several_groups(drives) {
        return (drives.len() as u64, setup.any_request);
    }
    let (mut asked, mut all, mut rest) = (0, Requests::NONE, drives);
    while let Some((drive, behind)) = rest.split_first() {
        if is_polled && !drive.polls.is_none() {
            asked += 1;
            all = all.with(&drive.polls);
        }
        rest = behind;
    }
    (asked, all)
}

const fn has_several_groups(drives: &[Drive]) -> bool {
    let mut rest = drives;
    while let [first, behind @ ..] = rest {
        if let [second, ..] = behind
            && first.group != second.group
        {
            return true;
        }
        rest = behind;
    }
    false
}

/// Real period of the polls per configured period, in thousandths, at least 1000.
pub(crate) const fn poll_stretch_permille(drives: &[Drive], requests: u64) -> u32 {
    let (mut due_ppm, mut rest) = (0_u64, drives);
    while let Some((drive, behind)) = rest.split_first() {
        due_ppm += drive.polls.due_ppm;
        rest = behind;
    }
    match due_ppm.checked_div(1_000 * requests) {
        Some(permille) if permille > 1_000 => narrow(permille),
        _ => 1_000,
    }
}

/// The usual times on the wire.
pub(crate) const fn usual_burst(setup: &CycleSetup, cycle: &Cycle) -> Burst {
    let rate = setup.bus.bit_rate;
    Burst {
        set_point_us: rate.us_covering(usual_bits(narrow(cycle.set_point_bits))),
        request_us: rate.us_covering(narrow(cycle.request_bits)),
        reply_us: rate.us_covering(narrow(cycle.reply_bits)),
        requests: narrow(cycle.requests),
    }
}

/// Half way between the longest frame and the same without stuff bits.
const fn usual_bits(longest_bits: u32) -> u32 {
    let mut len = 0;
    while len < 8 && (bound_bits(len) as u32) < longest_bits {
        len += 1;
    }
    (SHORTEST_BITS + 8 * len as u32 + longest_bits) / 2
}
