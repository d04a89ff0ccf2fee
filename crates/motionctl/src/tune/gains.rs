//! A set of gains.

use core::fmt;

use schemars::JsonSchema;
use serde::Serialize;

use crate::drives::{Parameter, Readings, Setting};

/// Gains of parameter group 1, each 1 to 127.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct Gains {
    main_gain: i32,
    speed_gain: i32,
    integration_gain: i32,
}

impl Gains {
    /// Those of a drive.
    pub(super) fn of(readings: &Readings) -> Option<Self> {
        Some(Self {
            main_gain: readings.value(Parameter::MainGain)?,
            speed_gain: readings.value(Parameter::SpeedGain)?,
            integration_gain: readings.value(Parameter::IntegrationGain)?,
        })
    }

    pub(super) fn settings(self) -> [Setting; 3] {
        let setting = |parameter, value| Setting { parameter, value };
        [
            setting(Parameter::MainGain, self.main_gain),
            setting(Parameter::SpeedGain, self.speed_gain),
            setting(Parameter::IntegrationGain, self.integration_gain),
        ]
    }

    /// Three numbers of the command line.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let expected =
            || format!("expected MAIN,SPEED,INTEGRATION, each 1..=127, as in 20,20,10, got {text}");
        let numbers: Vec<i32> = text
            .split(',')
            .map(|number| {
                number
                    .trim()
                    .parse()
                    .ok()
                    .filter(|gain| (1..=127).contains(gain))
            })
            .collect::<Option<_>>()
            .ok_or_else(expected)?;
        let [main_gain, speed_gain, integration_gain] = numbers[..] else {
            return Err(expected());
        };
        Ok(Self {
            main_gain,
            speed_gain,
            integration_gain,
        })
    }
}

impl fmt::Display for Gains {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            main_gain,
            speed_gain,
            integration_gain,
        } = self;
        write!(
            f,
            "main gain {main_gain}, speed gain {speed_gain}, integration gain {integration_gain}"
        )
    }
}
