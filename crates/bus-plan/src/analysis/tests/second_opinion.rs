//! Fixed-priority non-preemptive analysis of the crate `response-time-analysis`, which follows theorems that were proved by
//! machine (Prosa). One of its time units is one bit.

use std::vec::Vec;

use proptest::prelude::*;
use response_time_analysis::arrival::Sporadic;
use response_time_analysis::demand::RBF;
use response_time_analysis::fixed_priority::fully_nonpreemptive::{
    TaskUnderAnalysis, dedicated_uniproc_rta,
};
use response_time_analysis::time::{Duration, Service};
use response_time_analysis::wcet::Scalar;

use super::super::*;
use super::bounds;

const HORIZON_BITS: u32 = 40_000;

const RULES: Rules = Rules {
    error_interval_bits: None,
    horizon_bits: HORIZON_BITS,
};

fn second_opinion(messages: &[Message], index: usize) -> Option<u64> {
    let victim = messages[index];
    let others = || {
        let others = messages.iter().enumerate();
        others
            .filter(|(each, _)| *each != index)
            .map(|(_, message)| message)
    };
    let arrivals = |message: &Message| {
        Sporadic::new(
            Duration::from(u64::from(message.period_bits)),
            Duration::from(u64::from(message.jitter_bits)),
        )
    };
    let cost = |message: &Message| Scalar::new(Service::from(u64::from(message.bits)));
    let interfering: Vec<_> = others()
        .filter(|message| message.first_id <= victim.last_id)
        .map(|message| RBF::new(arrivals(message), cost(message)))
        .collect();
    let blocking = others()
        .filter(|message| message.last_id > victim.last_id)
        .map(|message| message.bits)
        .max();
    let task = TaskUnderAnalysis {
        wcet: cost(&victim),
        arrivals: &arrivals(&victim),
        blocking_bound: Service::from(u64::from(blocking.unwrap_or(0))),
    };
    let limit = Duration::from(u64::from(HORIZON_BITS));
    dedicated_uniproc_rta(&task, &interfering, limit)
        .ok()
        .map(u64::from)
}

fn message() -> impl Strategy<Value = Message> {
    (
        0..24_u16,
        47..=135_u32,
        200..3_000_u32,
        prop_oneof![Just(0), 1..4_000_u32],
    )
        .prop_map(|(id, bits, period_bits, jitter_bits)| Message {
            jitter_bits,
            ..Message::periodic(id, bits, period_bits)
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    /// Without own jitter both must agree to the bit. With it, the other analysis counts from release, this one from
    /// arrival, which is up to the jitter earlier.
    #[test]
    fn agrees_with_the_second_opinion(messages in proptest::collection::vec(message(), 1..9)) {
        for (index, (message, ours)) in messages.iter().zip(bounds(&messages, &RULES)).enumerate() {
            match (ours.map(u64::from), second_opinion(&messages, index)) {
                (Some(ours), Some(theirs)) => {
                    let jitter = u64::from(message.jitter_bits);
                    prop_assert!((theirs..=theirs + jitter).contains(&ours), "{index} of {messages:?}: {ours}, not {theirs}");
                }
                (ours, theirs) => prop_assert_eq!(ours, theirs, "{} of {:?}", index, messages),
            }
        }
    }
}
