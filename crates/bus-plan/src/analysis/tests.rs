use super::*;
use std::vec::Vec;

mod second_opinion;

const RULES: Rules = Rules {
    error_interval_bits: None,
    horizon_bits: 1 << 20,
};

/// The bound of each message among the others.
pub(super) fn bounds(messages: &[Message], rules: &Rules) -> Vec<Option<u32>> {
    let bound = |index: usize| {
        let mut others = messages.to_vec();
        let message = others.remove(index);
        response(&message, &others, rules).bits
    };
    (0..messages.len()).map(bound).collect()
}

/// Davis et al. 2007, section 3: three frames of 125 bits at 125 kbit/s, periods 2.5, 3.5 and 3.5 ms. The original analysis
/// looked at the first instance only and said 3 ms for the last; the second instance takes 3.5 ms.
#[test]
fn the_example_that_refuted_the_first_analysis() {
    // In half bits, because 2.5 ms are 312.5 bits.
    let messages = [
        Message::periodic(1, 250, 625),
        Message::periodic(2, 250, 875),
        Message::periodic(3, 250, 875),
    ];
    assert_eq!(bounds(&messages, &RULES), [Some(500), Some(750), Some(875)]);
}

#[test]
fn blocking_counts_once_and_only_from_below() {
    let messages = [
        Message::periodic(1, 60, 1_000),
        Message::periodic(2, 70, 1_000),
        Message::periodic(3, 90, 1_000),
        Message::periodic(4, 50, 1_000),
    ];
    assert_eq!(
        bounds(&messages, &RULES),
        [Some(150), Some(220), Some(270), Some(270)]
    );
}

#[test]
fn equal_identifiers_wait_for_one_another() {
    let messages = [
        Message::periodic(7, 60, 1_000),
        Message::periodic(7, 90, 1_000),
    ];
    assert_eq!(bounds(&messages, &RULES), [Some(150), Some(150)]);
}

#[test]
fn jitter_of_others_brings_one_more_frame_and_own_jitter_counts() {
    let mut messages = [
        Message::periodic(1, 60, 100),
        Message::periodic(2, 30, 1_000),
    ];
    assert_eq!(bounds(&messages, &RULES), [Some(90), Some(90)]);
    messages[0].jitter_bits = 50;
    messages[1].jitter_bits = 7;
    // At 60, the second frame is there already (jitter 50); the third comes at 150.
    assert_eq!(bounds(&messages, &RULES), [Some(140), Some(157)]);
}

#[test]
fn an_overloaded_bus_has_no_bound() {
    let messages = [Message::periodic(1, 60, 100), Message::periodic(2, 50, 100)];
    assert_eq!(bounds(&messages, &RULES), [Some(110), None]);
    assert!(!response(&messages[1], &messages[..1], &RULES).is_met());
}

#[test]
fn a_message_without_period_has_no_bound() {
    assert_eq!(bounds(&[Message::periodic(1, 60, 0)], &RULES), [None]);
}

#[test]
fn each_error_costs_a_frame_and_its_error_frame() {
    let messages = [
        Message::periodic(1, 60, 1_000),
        Message::periodic(2, 90, 1_000),
    ];
    let rules = Rules {
        error_interval_bits: Some(10_000),
        ..RULES
    };
    assert_eq!(
        bounds(&messages, &rules),
        [Some(150 + 121), Some(150 + 121)]
    );
}

#[test]
fn frames_of_one_stream_overtake_each_other() {
    let stream = Message {
        last_id: 9,
        count: 3,
        ..Message::periodic(3, 50, 1_000)
    };
    let middle = Message::periodic(5, 70, 1_000);
    // The stream disturbs as its most urgent frame, blocks as its least urgent one, and is judged as that.
    assert_eq!(
        bounds(&[stream, middle], &RULES),
        [Some(220), Some(50 + 150 + 70)]
    );
}

#[test]
fn a_bound_can_be_a_constant() {
    const BOUND: Response = response(
        &Message::periodic(2, 90, 1_000),
        &[Message::periodic(1, 60, 1_000)],
        &RULES,
    );
    assert_eq!((BOUND.bits, BOUND.is_met()), (Some(150), true));
}
