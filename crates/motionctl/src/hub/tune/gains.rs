//! Gains of one loop of a ZLAC8030L.

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::dictionary::{self, Entry};
use zlac8030l::{NodeId, ObjectAddress};

use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::object::ObjectSetting;

/// A loop with its gains, in the order of the option.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Loop {
    /// Kp, Ki, Kf.
    Speed,
    /// Kp, Kf.
    Position,
}

const SPEED: [(ObjectAddress, &str); 3] = [
    (ObjectAddress::new(0x201D, 0), "Kp"),
    (ObjectAddress::new(0x201E, 0), "Ki"),
    (ObjectAddress::new(0x201F, 0), "Kf"),
];
const POSITION: [(ObjectAddress, &str); 2] = [
    (ObjectAddress::new(0x2020, 0), "Kp"),
    (ObjectAddress::new(0x2021, 0), "Kf"),
];

impl Loop {
    const fn objects(self) -> &'static [(ObjectAddress, &'static str)] {
        match self {
            Self::Speed => &SPEED,
            Self::Position => &POSITION,
        }
    }

    const fn word(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Position => "position",
        }
    }

    /// The rows of the dictionary.
    pub(super) fn rows(self) -> impl Iterator<Item = &'static Entry> {
        let objects = self.objects().iter();
        objects.filter_map(|(address, _)| dictionary::find(*address))
    }
}

/// Values of the gains of a loop.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(transparent)]
pub(super) struct Gains(Vec<i64>);

impl Gains {
    /// Numbers of the command line.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let numbers = text.split(',').map(|number| number.trim().parse().ok());
        let numbers: Option<Vec<i64>> = numbers.collect();
        numbers.map(Self).ok_or_else(|| {
            format!("expected numbers as in 500,100,1000 (Kp,Ki,Kf of the speed) or 50,200 (Kp,Kf of the position), got {text}")
        })
    }

    /// Those of a drive.
    ///
    /// # Errors
    /// As [`Bus::read_number`].
    pub(super) fn of(bus: &mut Bus, node: NodeId, control: Loop) -> Result<Self, HubError> {
        let read = |row: &Entry| bus.read_number(node, row.address);
        control.rows().map(read).collect::<Result<_, _>>().map(Self)
    }

    /// Whether a loop can have them.
    ///
    /// # Errors
    /// [`HubError::Input`].
    pub(super) fn check(&self, control: Loop) -> Result<(), HubError> {
        let names: Vec<&str> = control.objects().iter().map(|(_, name)| *name).collect();
        if self.0.len() != names.len() {
            return Err(HubError::Input(format!(
                "--gains: expected {} of the {} loop, got {} numbers",
                names.join(","),
                control.word(),
                self.0.len()
            )));
        }
        self.settings(control).map(drop)
    }

    /// As objects.
    ///
    /// # Errors
    /// [`HubError::Input`] for a value out of range.
    pub(super) fn settings(&self, control: Loop) -> Result<Vec<ObjectSetting>, HubError> {
        let rows = control.rows().zip(&self.0);
        rows.map(|(row, value)| ObjectSetting::new(row, *value).map_err(HubError::Input))
            .collect()
    }

    /// With the names of the gains.
    pub(super) fn words(&self, control: Loop) -> String {
        let named: Vec<String> = control
            .objects()
            .iter()
            .zip(&self.0)
            .map(|((_, name), value)| format!("{name} {value}"))
            .collect();
        format!("{} {}", control.word(), named.join(", "))
    }

    /// By name, for JSON.
    pub(super) fn named(&self, control: Loop) -> serde_json::Map<String, serde_json::Value> {
        let names = control.objects().iter().zip(&self.0);
        names
            .map(|((_, name), value)| (name.to_ascii_lowercase(), (*value).into()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_belong_to_their_loop() {
        let gains = Gains::parse("500, 100,1000").expect("numbers");
        assert!(gains.check(Loop::Speed).is_ok());
        assert_eq!(gains.words(Loop::Speed), "speed Kp 500, Ki 100, Kf 1000");
        let error = gains.check(Loop::Position).expect_err("three").to_string();
        assert!(error.contains("expected Kp,Kf"), "{error}");
        let error = Gains::parse("500,30001,0").expect("numbers");
        let error = error.check(Loop::Speed).expect_err("too large").to_string();
        assert!(error.contains("must be 0..=30000, got 30001"), "{error}");
        assert!(Gains::parse("500,").is_err());
    }
}
