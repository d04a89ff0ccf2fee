//! What a configuration puts on the bus in each cycle.

use super::analysis::max;
use super::cycle::{Cycle, RequestPlace, narrow};
use super::frames::{Exchange, alarm_bits, set_point_bits};
use super::setup::TxOrder;
use crate::servo::config::{AxisConfig, MasterConfig};
use crate::servo::poll_kind::PollKind;

/// The frames of a cycle, with or without polls.
pub(super) const fn cycle_of(
    config: &MasterConfig,
    axes: &[AxisConfig],
    is_polled: bool,
    place: RequestPlace,
) -> Cycle {
    let setup = &config.bus;
    let rate = setup.bit_rate;
    let exchange = Exchange::of(axes, setup.requests, is_polled);
    let budget = config.requests_per_cycle as u64;
    let (mut set_points_bits, mut longest_bits, mut rest) = (0, 0, axes);
    while let Some((axis, behind)) = rest.split_first() {
        let bits = set_point_bits(axis) as u64;
        set_points_bits += bits;
        longest_bits = max(longest_bits, bits);
        rest = behind;
    }
    Cycle {
        bits: rate.bits_within(config.cycle_us),
        bits_rounded_up: rate.bits_covering(config.cycle_us),
        set_points_bits,
        set_point_bits: longest_bits,
        requests: if exchange.axes < budget {
            exchange.axes
        } else {
            budget
        },
        request_bits: exchange.request_bits as u64,
        shortest_request_bits: exchange.shortest_request_bits as u64,
        reply_bits: exchange.reply_bits as u64,
        response_min_bits: rate.bits_within(setup.response.min_us),
        response_max_bits: rate.bits_covering(setup.response.max_us),
        alarms: setup.alarm_burst as u64,
        alarm_bits: alarm_bits(axes) as u64,
        jitter_bits: rate.bits_covering(setup.release_jitter_us),
        reply_timeout_bits: rate.bits_within(config.timeouts.reply_us),
        place: match setup.order {
            TxOrder::Fifo => place,
            TxOrder::Identifier => RequestPlace::Anywhere,
        },
        order: setup.order,
        error_interval_bits: match setup.error_interval_us {
            Some(us) => Some(narrow(rate.bits_within(us))),
            None => None,
        },
    }
}

/// Real period of the polls per configured period, in thousandths, at least 1000.
pub(super) const fn poll_stretch_permille(
    config: &MasterConfig,
    axes: &[AxisConfig],
    requests: u64,
) -> u32 {
    let (mut due_ppm, mut rest) = (0_u64, axes);
    while let Some((axis, behind)) = rest.split_first() {
        let mut kinds: &[PollKind] = &PollKind::ALL;
        while let Some((kind, others)) = kinds.split_first() {
            if let Some(period_us) = axis.polls.of(*kind) {
                // The master counts in whole cycles, at least one.
                let cycles = match period_us.checked_div(config.cycle_us) {
                    Some(cycles) => max(cycles as u64, 1),
                    None => 1,
                };
                due_ppm += 1_000_000_u64.div_ceil(cycles);
            }
            kinds = others;
        }
        rest = behind;
    }
    match due_ppm.checked_div(1_000 * requests) {
        Some(permille) if permille > 1_000 => narrow(permille),
        _ => 1_000,
    }
}
