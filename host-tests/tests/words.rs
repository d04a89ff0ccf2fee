//! The texts of the masters, checked for what a machine can see.

#[path = "../../crates/motionctl/src/plain_words.rs"]
mod plain_words;

use can_motion::Fault;
use can_motion::wheel::WheelFault;
use plain_words::{flaws_of_a_message, variants};
use zlac8030l::{
    AbortCode, Emcy, FaultCode, NmtState, ObjectAddress, SdoEnd, SetUpError, WidthError,
};

fn wheel_faults() -> Vec<WheelFault> {
    let address = ObjectAddress::new(0x6084, 0);
    let mut faults = vec![
        WheelFault::Emergency(Emcy {
            error_code: 0x1000,
            error_register: 1,
            manufacturer: [0; 5],
        }),
        WheelFault::EmergencyInput,
        WheelFault::NotEnabled,
        WheelFault::SwitchedOn,
        WheelFault::NotOperational(NmtState::Stopped),
        WheelFault::Lost,
        WheelFault::Reboot,
        WheelFault::SpeedResolution {
            expected: 1,
            actual: 10,
        },
        WheelFault::FollowingError { counts: 1 },
        WheelFault::FollowingError { counts: -400 },
        WheelFault::FollowingSpeed {
            sent_decirpm: 1,
            actual_decirpm: 0,
        },
        WheelFault::OverSpeed {
            most_decirpm: 1_000,
            actual_decirpm: -1_234,
        },
        WheelFault::Bus,
        WheelFault::ConfirmTimeout,
        WheelFault::PositionRange { actual: 1 },
        WheelFault::Group,
        WheelFault::SetUp(SetUpError::NotTaken {
            address,
            expected: 1,
            actual: 2,
        }),
        WheelFault::SetUp(SetUpError::Width {
            address,
            error: WidthError {
                expected: 4,
                actual: 2,
            },
        }),
        WheelFault::SetUp(SetUpError::Silent { address }),
        WheelFault::Transfer(SdoEnd::TimedOut),
        WheelFault::Transfer(SdoEnd::Written),
        WheelFault::Transfer(SdoEnd::Aborted(AbortCode::TIMEOUT)),
        WheelFault::Transfer(SdoEnd::Specifier { actual: 0x41 }),
    ];
    faults.extend((0..16).map(|bit| WheelFault::Drive(FaultCode::new(1 << bit))));
    faults.push(WheelFault::Drive(FaultCode::new(0xFFFF)));
    faults
}

#[test]
fn every_fault_of_a_wheel_has_plain_words() {
    let source = include_str!("../../crates/can-motion/src/wheel/fault.rs");
    let faults = wheel_faults();
    for variant in variants(source, "WheelFault") {
        let is_there = faults
            .iter()
            .any(|fault| format!("{fault:?}").starts_with(&variant));
        assert!(is_there, "{variant} is not in this test");
    }
    for fault in faults {
        let text = fault.to_string();
        assert_eq!(flaws_of_a_message(&text), [""; 0], "{text}");
    }
}

#[test]
fn speeds_have_their_decimal_point_and_sign() {
    let text = WheelFault::FollowingSpeed {
        sent_decirpm: -5,
        actual_decirpm: 1_234,
    };
    assert_eq!(
        text.to_string(),
        "the wheel turns at 123.4 in place of -0.5 r/min"
    );
}

#[test]
fn one_count_is_one_count() {
    for (counts, noun) in [
        (1, "1 count "),
        (-1, "-1 count "),
        (2, "2 counts "),
        (0, "0 counts "),
    ] {
        for text in [
            Fault::Backlog { counts }.to_string(),
            Fault::FollowingError { counts }.to_string(),
            Fault::PositionJump { counts }.to_string(),
            WheelFault::FollowingError { counts }.to_string(),
        ] {
            assert!(text.contains(noun), "{text}");
        }
    }
}
