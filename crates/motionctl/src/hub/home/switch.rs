//! The level of a switch: from the lines of another program, or from an input of the drive.

use std::path::Path;

use homing::Reading;
use zlac8030l::{NodeId, Object, objects};

use crate::home::{HomeError, SwitchLines};
use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::object::address_text;
use crate::hub::station::WheelStation;

/// Where the level comes from.
pub(super) enum Switch {
    /// Another program.
    Lines(SwitchLines),
    /// The input of this bit of 2003h.
    Input { bit: u16 },
}

/// The inputs of a drive, with the object that has their function.
const INPUTS: [(&str, u16, Object<u16>); 2] =
    [("X0", 0, objects::INPUT_X0), ("X1", 1, objects::INPUT_X1)];

impl Switch {
    /// Opens what `--switch-input` names.
    ///
    /// # Errors
    /// [`HubError::Input`] for an input of the drive with a function of its own, or [`HomeError::SwitchLines`].
    pub(super) fn open(path: &Path, bus: &mut Bus, node: NodeId) -> Result<Self, HubError> {
        let named = INPUTS.iter().find(|(name, ..)| path == Path::new(name));
        let Some((name, bit, function)) = named else {
            let lines = SwitchLines::open(path).map_err(HomeError::SwitchLines)?;
            return Ok(Self::Lines(lines));
        };
        let actual = bus.read(node, *function)?;
        if actual != 0 {
            let object = address_text(function.address());
            return Err(HubError::Input(format!(
                "input {name} of node {node} must have no function to be a switch, {object} is {actual} (9 is an emergency stop): where no emergency stop hangs on it, `motionctl write --drives zlac:{node} {object}=0` first. Nothing has moved"
            )));
        }
        Ok(Self::Input { bit: *bit })
    }

    /// The level that is known, after the next one was asked for.
    pub(super) fn level(&self, station: &mut WheelStation<'_>) -> Option<Reading<bool>> {
        match self {
            Self::Lines(lines) => lines.level(station.now()),
            Self::Input { bit } => {
                station.ask_inputs();
                let (levels, at) = station.input_levels()?;
                Some(Reading {
                    value: levels >> bit & 1 == 1,
                    at_us: at.as_us(),
                })
            }
        }
    }

    /// A line that is no level.
    pub(super) fn fault(&self) -> Option<String> {
        match self {
            Self::Lines(lines) => lines.fault(),
            Self::Input { .. } => None,
        }
    }
}
