//! How much a change of a parameter group writes, and whether a reading already shows it.

use crate::parameters::{
    ParamGroup1, ParamGroup2, ParamGroup3, SetParamGroup1, SetParamGroup2, SetParamGroup3,
};

/// A change of a parameter group.
macro_rules! parameter_change {
    ($change:ident of $group:ident: $($field:ident),*; $($optional:ident),*) => {
        impl $change {
            /// Parameters that it writes.
            #[must_use]
            pub fn count(&self) -> u16 {
                0 $(+ u16::from(self.$field.is_some()))* $(+ u16::from(self.$optional.is_some()))*
            }

            /// Whether a drive that reports these parameters already has what it writes.
            #[must_use]
            pub fn is_in(&self, present: &$group) -> bool {
                true
                    $(&& self.$field.is_none_or(|wanted| wanted == present.$field))*
                    $(&& self.$optional.is_none_or(|wanted| Some(wanted) == present.$optional))*
            }
        }
    };
}

parameter_change!(SetParamGroup1 of ParamGroup1: main_gain, speed_gain, integration_gain, torque_filter;);
parameter_change!(SetParamGroup2 of ParamGroup2: max_speed, max_acceleration;);
parameter_change!(SetParamGroup3 of ParamGroup3: on_pos_range, gear_number; line_number);

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_values::{GearNumber, LineNumber, MaxAcceleration, MaxSpeed, OnPosRange};

    #[test]
    fn what_is_not_given_is_neither_counted_nor_compared() {
        let present = ParamGroup2 {
            max_speed: MaxSpeed::MIN,
            max_acceleration: MaxAcceleration::MAX,
        };
        let mut change = SetParamGroup2::default();
        assert_eq!((change.count(), change.is_in(&present)), (0, true));
        change.max_speed = Some(MaxSpeed::MIN);
        assert_eq!((change.count(), change.is_in(&present)), (1, true));
        change.max_acceleration = Some(MaxAcceleration::MIN);
        assert_eq!((change.count(), change.is_in(&present)), (2, false));
    }

    #[test]
    fn a_line_number_that_is_not_reported_is_another_one() {
        let present = ParamGroup3 {
            on_pos_range: OnPosRange::MIN,
            gear_number: GearNumber::MIN,
            line_number: None,
        };
        let change = SetParamGroup3 {
            line_number: Some(LineNumber::MIN),
            ..SetParamGroup3::default()
        };
        assert_eq!((change.count(), change.is_in(&present)), (1, false));
        let reported = ParamGroup3 {
            line_number: Some(LineNumber::MIN),
            ..present
        };
        assert!(change.is_in(&reported));
    }
}
