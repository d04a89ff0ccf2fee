//! Settings of a drive as steps of a [`SetUp`](crate::SetUp): which objects, in which order.
//!
//! A set-up makes sure that the drive is a ZLAC8030L, keeps the EEPROM from being written by each step (2010h = 1), writes only what differs
//! and reads it back. With [`SetUpOptions::save`](crate::SetUpOptions) it saves everything once at its end, which is what outlasts the
//! power. Run it while the power stage is off: the guide does not say what a drive with power does with these objects.

use can_frame::BitRate;

use crate::bit_rates::BIT_RATES;
use crate::node::NodeId;
use crate::object::ObjectValue;
use crate::objects;
use crate::set_up::{SetUpStep, Setting};
use crate::typed_object::Object;

/// Lowest node number that can be stored (guide section 9, 200Dh).
pub const LEAST_STORED_NODE: u8 = 4;

fn value<T: ObjectValue>(object: Object<T>, value: T) -> SetUpStep {
    SetUpStep::Value(Setting::new(object, value))
}

/// Parking mode: the motor's current is at most 3 A, so that it stays cool while the vehicle waits (guide section 5.2). Counts at once.
#[must_use]
pub fn parking(on: bool) -> [SetUpStep; 1] {
    [value(objects::PARKING, u16::from(on))]
}

/// Alarm PWM: after an alarm the phases are short-circuited, so that the wheel is braked and does not roll away (guide section 5.1).
#[must_use]
pub fn alarm_pwm(on: bool) -> [SetUpStep; 1] {
    [value(objects::ALARM_PWM, u16::from(on))]
}

/// Which inputs are emergency stops, and whether they release the shaft or hold it at speed 0 (guide section 5.4; Z8, Z31). What the stop
/// does is set before an input may cause one.
#[must_use]
pub fn emergency_inputs(x0: bool, x1: bool, releases_shaft: bool) -> [SetUpStep; 3] {
    let function = |is_stop| {
        if is_stop {
            objects::INPUT_EMERGENCY_STOP
        } else {
            0
        }
    };
    [
        value(objects::EMERGENCY_INPUT_RELEASES, u16::from(releases_shaft)),
        value(objects::INPUT_X0, function(x0)),
        value(objects::INPUT_X1, function(x1)),
    ]
}

/// The holding brake at output B0 (guide section 5.5.2). It is no setting that is kept: a drive starts with 0, which opens it.
#[must_use]
pub fn holding_brake(closed: bool) -> [SetUpStep; 1] {
    [value(objects::HOLDING_BRAKE, u16::from(closed))]
}

/// Speeds count 1/n r/min; after a save and a restart (guide section 5.3). `None` for n outside 1 to 10 (Z9).
#[must_use]
pub fn speed_resolution(n: u16) -> Option<[SetUpStep; 1]> {
    let is_known = (1..=10).contains(&n);
    is_known.then(|| [value(objects::SPEED_RESOLUTION, n)])
}

/// The node number; `None` below 4, where the DIP switch sets it (guide section 9, 200Dh). The guide does not say when it counts: save it,
/// restart the drive, and look for it under both numbers.
#[must_use]
pub fn node(node: NodeId) -> Option<[SetUpStep; 1]> {
    let is_stored = node.get() >= LEAST_STORED_NODE;
    is_stored.then(|| [value(objects::CAN_NODE, node.get().into())])
}

/// The bit rate, for the next power-on; `None` for one that the drive does not have.
#[must_use]
pub fn bit_rate(rate: BitRate) -> Option<[SetUpStep; 1]> {
    let mut codes = (0_u16..).zip(BIT_RATES);
    let (code, _) = codes.find(|(_, known)| *known == rate)?;
    Some([value(objects::CAN_BIT_RATE, code)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_resolution_is_one_of_ten() {
        for n in 1..=10 {
            assert_eq!(
                speed_resolution(n),
                Some([value(objects::SPEED_RESOLUTION, n)])
            );
        }
        assert_eq!([0, 11].map(speed_resolution), [None; 2]);
    }

    #[test]
    fn the_switch_sets_the_lowest_nodes() {
        let of = |number| node(NodeId::new(number).unwrap());
        assert_eq!([1, 2, 3].map(of), [None; 3]);
        assert_eq!(of(4), Some([value(objects::CAN_NODE, 4)]));
        assert_eq!(of(127), Some([value(objects::CAN_NODE, 127)]));
    }

    #[test]
    fn a_bit_rate_is_stored_as_its_place() {
        for (code, rate) in (0_u16..).zip(BIT_RATES) {
            assert_eq!(bit_rate(rate), Some([value(objects::CAN_BIT_RATE, code)]));
        }
        assert_eq!(bit_rate(BitRate::Kbit10), None);
    }
}
